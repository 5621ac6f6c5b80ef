//! Named limits of joint and tool motion.

/// Limits of the tool's motion; infinity when not limited.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolLimits {
    /// m/s
    pub speed: f64,
    /// rad/s
    pub rate: f64,
    /// m/s2
    pub acceleration: f64,
}

/// One named set of limits, one entry per joint; infinity when not limited.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitProfile {
    /// Name, printed with every result.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// rad/s
    pub velocity: Vec<f64>,
    /// rad/s2
    pub acceleration: Vec<f64>,
    /// rad/s3
    pub jerk: Vec<f64>,
    /// Limits of the tool.
    pub tool: ToolLimits,
}
