//! How a group of robots is stepped at once.

use arrayvec::ArrayVec;
use std::sync::Arc;
use wingbeat_flight::simulate::{Stepper, Together};
use wingbeat_math::{Double4, Lanes, Single8};
use wingbeat_robot::Robot;

/// Numbers with which the robots of a [`Flock`](super::Flock) are stepped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// Double precision, four robots at once.
    #[default]
    Double,
    /// Single precision, eight robots at once: faster by half, and rounded to 6e-8 of every number.
    Single,
}

/// Most robots that are stepped at once.
pub(super) const MOST_LANES: usize = Single8::WIDTH;

impl Precision {
    /// Robots that are stepped at once.
    pub fn lanes(self) -> usize {
        match self {
            Self::Double => Double4::WIDTH,
            Self::Single => Single8::WIDTH,
        }
    }
}

/// Room to step robots side by side.
pub(super) enum LaneRoom {
    Double(Together<Double4>),
    Single(Together<Single8>),
}

impl LaneRoom {
    pub fn new(precision: Precision, states: usize, inputs: usize) -> Self {
        match precision {
            Precision::Double => Self::Double(Together::new(states, inputs)),
            Precision::Single => Self::Single(Together::new(states, inputs)),
        }
    }

    /// Takes `steps` steps of `dt` seconds with every one of `members`.
    pub fn step(
        &mut self,
        mut members: ArrayVec<&mut Stepper<Arc<Robot>>, MOST_LANES>,
        dt: f64,
        steps: usize,
    ) {
        match self {
            Self::Double(together) => together.step(&mut members, dt, steps),
            Self::Single(together) => together.step(&mut members, dt, steps),
        }
    }
}
