//! How much of each limit a motion uses.

use super::TrackInstant;
use crate::arm::{LimitProfile, Payload, SerialArm};

/// What can bind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitKind {
    /// Joint speed.
    Velocity,
    /// Joint acceleration.
    Acceleration,
    /// Joint jerk.
    Jerk,
    /// Joint torque.
    Torque,
    /// Tool speed of the profile.
    ToolSpeed,
    /// Tool angular rate of the profile.
    ToolRate,
    /// Tool acceleration of the profile.
    ToolAcceleration,
}

impl LimitKind {
    /// Words and unit for a report.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => ("velocity", "rad/s"),
            Self::Acceleration => ("acceleration", "rad/s2"),
            Self::Jerk => ("jerk", "rad/s3"),
            Self::Torque => ("torque", "N m"),
            Self::ToolSpeed => ("tool speed", "m/s"),
            Self::ToolRate => ("tool angular rate", "rad/s"),
            Self::ToolAcceleration => ("tool acceleration", "m/s2"),
        }
    }
    /// Power of the speed with which the quantity grows when the motion runs faster; 0 for torque.
    pub(super) fn order(self) -> i32 {
        match self {
            Self::Velocity | Self::ToolSpeed | Self::ToolRate => 1,
            Self::Acceleration | Self::ToolAcceleration => 2,
            Self::Jerk => 3,
            Self::Torque => 0,
        }
    }
}

/// The peak of one quantity against its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Joint index; none for the tool.
    pub joint: Option<usize>,
    /// What is limited.
    pub kind: LimitKind,
    /// Largest magnitude reached, in the unit of the quantity.
    pub value: f64,
    /// Its limit, in the unit of the quantity; infinity when there is none.
    pub limit: f64,
}

impl Peak {
    /// Share of the limit that the peak takes; 0 without a limit.
    pub fn share(&self) -> f64 {
        if self.limit.is_finite() { self.value / self.limit } else { 0.0 }
    }
    /// Factor by which the whole motion could run faster until this limit binds.
    pub fn headroom(&self) -> f64 {
        match self.kind.order() {
            0 => f64::INFINITY,
            n => self.share().powf(-1.0 / f64::from(n)),
        }
    }
}

/// Every peak of a tracked motion, torque included when a payload is given.
pub fn peaks(
    arm: &SerialArm,
    profile: &LimitProfile,
    payload: Option<&Payload>,
    instants: &[TrackInstant],
) -> Vec<Peak> {
    let mut peaks = Vec::with_capacity(4 * arm.dof() + 3);
    let most = |f: &dyn Fn(&TrackInstant) -> f64| instants.iter().fold(0.0_f64, |m, i| m.max(f(i).abs()));
    let torque: Vec<_> = payload.map_or(vec![], |p| instants.iter().map(|i| arm.torques(&i.q, p)).collect());
    for (j, joint) in arm.joints.iter().enumerate() {
        let mut add = |kind, value, limit| peaks.push(Peak { joint: Some(j), kind, value, limit });
        add(LimitKind::Velocity, most(&|i| i.q[j].d), profile.velocity[j]);
        add(LimitKind::Acceleration, most(&|i| i.q[j].dd), profile.acceleration[j]);
        add(LimitKind::Jerk, jerk(instants, j), profile.jerk[j]);
        if payload.is_some() {
            let value = torque.iter().fold(0.0_f64, |m, t| m.max(t[j].abs()));
            add(LimitKind::Torque, value, joint.effort);
        }
    }
    let mut add = |kind, value, limit| peaks.push(Peak { joint: None, kind, value, limit });
    add(LimitKind::ToolSpeed, most(&|i| i.tool.velocity.norm()), profile.tool.speed);
    add(LimitKind::ToolRate, most(&|i| i.tool.rate.norm()), profile.tool.rate);
    add(LimitKind::ToolAcceleration, most(&|i| i.tool.acceleration.norm()), profile.tool.acceleration);
    peaks
}

/// Largest |jerk| of joint `j` by differences of its acceleration.
fn jerk(instants: &[TrackInstant], j: usize) -> f64 {
    instants.windows(2).map(|w| ((w[1].q[j].dd - w[0].q[j].dd) / (w[1].t - w[0].t)).abs()).fold(0.0, f64::max)
}

/// The peak that uses most of its limit.
pub fn binding(peaks: &[Peak]) -> Option<&Peak> {
    peaks.iter().max_by(|a, b| a.share().total_cmp(&b.share()))
}
