//! What a solver says: how it ended, and a line per iteration.

use std::fmt;
use std::time::Duration;

/// How a solve ended.
#[derive(Clone, Debug, PartialEq)]
pub enum SolveStatus {
    /// All optimality conditions hold to the tolerance.
    Solved,
    /// They hold to the looser, acceptable tolerance, and no better point was found.
    Acceptable,
    /// The constraints cannot be met near the last point.
    Infeasible {
        /// Name of the channel whose limits are missed most.
        channel: String,
        /// By how much, in the unit of the channel.
        violation: f64,
    },
    /// The iterations allowed were used up.
    IterationLimit,
    /// The processor time allowed was used up.
    TimeLimit,
    /// The functions or the linear algebra broke down.
    NumericalTrouble {
        /// What happened, in words.
        cause: String,
    },
    /// The finest mesh allowed is too coarse for the tolerance asked.
    CoarseMesh {
        /// Largest error between its nodes, relative.
        error: f64,
    },
    /// The objective falls without end.
    Unbounded,
    /// The observer asked for an end.
    Stopped,
}

impl SolveStatus {
    /// True when the result is an optimum to one of the tolerances.
    pub fn is_success(&self) -> bool {
        matches!(self, Self::Solved | Self::Acceptable)
    }
}

impl fmt::Display for SolveStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Solved => write!(f, "solved"),
            Self::Acceptable => write!(f, "acceptable"),
            Self::Infeasible { channel, violation } => {
                write!(f, "infeasible: {channel} misses its limits by {violation:.3e} at the last iterate")
            }
            Self::IterationLimit => write!(f, "iteration limit"),
            Self::TimeLimit => write!(f, "time limit, of processor time"),
            Self::NumericalTrouble { cause } => write!(f, "numerical trouble: {cause}"),
            Self::CoarseMesh { error } => write!(
                f,
                "mesh too coarse: the finest mesh allowed leaves a relative error of {error:.1e} between its nodes; \
                 allow more meshes or intervals, or a larger tolerance"
            ),
            Self::Unbounded => write!(f, "unbounded objective"),
            Self::Stopped => write!(f, "stopped on request"),
        }
    }
}

/// One line of the iteration log.
#[derive(Clone, Copy, Debug)]
pub struct Iteration {
    /// Number, from 0.
    pub number: usize,
    /// Objective, unscaled.
    pub objective: f64,
    /// Largest constraint residual, scaled.
    pub infeasibility: f64,
    /// Largest component of the Lagrangian's gradient, scaled.
    pub stationarity: f64,
    /// Barrier parameter.
    pub barrier: f64,
    /// Shift of the Hessian's diagonal in the step that led here.
    pub shift: f64,
    /// Length of that step along the Newton direction.
    pub step: f64,
    /// True inside the restoration of feasibility.
    pub restoring: bool,
}

impl Iteration {
    /// Heading of the log.
    pub const HEADING: &'static str =
        " iter       objective  infeasibility  stationarity   barrier     shift      step";
}

impl fmt::Display for Iteration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mark = if self.restoring { 'r' } else { ' ' };
        write!(
            f,
            "{:5}{mark} {:14.7e}  {:13.3e}  {:12.3e}  {:8.1e}  {:8.1e}  {:8.1e}",
            self.number,
            self.objective,
            self.infeasibility,
            self.stationarity,
            self.barrier,
            self.shift,
            self.step
        )
    }
}

/// Tolerances and limits of a solve.
#[derive(Clone, Debug)]
pub struct Options {
    /// Largest scaled error of the optimality conditions at a solution.
    pub tolerance: f64,
    /// Largest product of a limit's multiplier and distance at a solution.
    pub complementarity: f64,
    /// Error that is acceptable when no better point is found.
    pub acceptable: f64,
    /// Most iterations.
    pub iterations: usize,
    /// Most processor time of the thread that solves.
    pub time: Duration,
    /// First barrier parameter.
    pub barrier: f64,
    /// How far inside its limits the start is moved, as a share.
    pub margin: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            complementarity: 1e-10,
            acceptable: 1e-6,
            iterations: 1000,
            time: Duration::from_secs(120),
            barrier: 0.1,
            margin: 1e-2,
        }
    }
}

/// What a solve returns.
#[derive(Clone, Debug)]
pub struct Solution {
    /// How it ended.
    pub status: SolveStatus,
    /// The variables.
    pub x: Vec<f64>,
    /// The objective there.
    pub objective: f64,
    /// The constraint values there.
    pub constraints: Vec<f64>,
    /// Multipliers of the constraints: the gradient of
    /// objective + multipliers . constraints vanishes off the limits.
    pub multipliers: Vec<f64>,
    /// Multipliers of the variables' limits, positive at an upper one: the gradient of objective +
    /// multipliers . constraints + bounds . x vanishes.
    pub bounds: Vec<f64>,
    /// Iterations used, those of restorations included.
    pub iterations: usize,
    /// Largest scaled error of the optimality conditions.
    pub error: f64,
    /// Largest scaled violation of a constraint.
    pub infeasibility: f64,
    /// Largest violation of a constraint's limits, in its own unit.
    pub violation: f64,
    /// Name of the constraint that is missed by so much; empty without one.
    pub missed: String,
    /// Wall time.
    pub time: Duration,
}
