//! How an update ended.

use super::Tracking;
use crate::plant::{Fault, Plant};

/// A limit of the plan: which one, and at which node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Limit of an input channel.
    Input {
        /// Index of the channel.
        channel: usize,
        /// Node, 0 to the number of intervals.
        node: usize,
    },
    /// Limit of a state channel.
    State {
        /// Index of the channel.
        channel: usize,
        /// Node, 1 to the number of intervals.
        node: usize,
    },
    /// Rate limit of an input channel over the interval that ends at `node`.
    Rate {
        /// Index of the channel.
        channel: usize,
        /// Node, 1 to the number of intervals.
        node: usize,
    },
    /// A [`LinearLimit`](super::LinearLimit) of the tracking problem.
    Linear {
        /// Index of the limit.
        row: usize,
        /// Node, 1 to the number of intervals.
        node: usize,
    },
}

impl Limit {
    /// Name of the channel (of an input also where its rate is meant) or linear limit.
    pub fn name<'a, P: Plant, T: Tracking>(&self, plant: &'a P, tracking: &'a T) -> &'a str {
        match *self {
            Self::Input { channel, .. } | Self::Rate { channel, .. } => &plant.inputs()[channel].name,
            Self::State { channel, .. } => &plant.states()[channel].name,
            Self::Linear { row, .. } => &tracking.limits()[row].name,
        }
    }
}

/// End of an update. Only `Solved` and `IterationLimit` change the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UpdateStatus {
    /// Steps and defects fell below the tolerance.
    Solved,
    /// The iterations asked for were made; the plan is the last iterate. The
    /// normal end of a real-time update.
    IterationLimit,
    /// The linearised limits contradict each other.
    Infeasible {
        /// The limit that cannot be met.
        worst: Limit,
    },
    /// Curvature is missing, or numbers left the finite range.
    NumericalTrouble,
    /// The model could not be evaluated.
    ModelFault(Fault),
}

impl UpdateStatus {
    /// True when the update changed the plan.
    pub fn updated(&self) -> bool {
        matches!(self, Self::Solved | Self::IterationLimit)
    }
}

/// Measures of the last update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// The plan led nowhere; this is the attempt from rest.
    pub restarted: bool,
    /// Sequential quadratic programming iterations made.
    pub iterations: usize,
    /// Largest entry of the reduced gradient of the Lagrangian at the last point linearised, in the unit of the cost over those
    /// of the inputs.
    pub stationarity: f64,
    /// Largest defect at the last point linearised, in units of the states.
    pub defect: f64,
    /// Largest step of an input, as a share of half its range, or in its unit where it has none.
    pub step: f64,
    /// Constraints added or dropped by the quadratic programs, summed.
    pub qp_changes: usize,
    /// Limits that bind in the last quadratic program.
    pub active: usize,
}
