//! What can be stepped, who steers it, and how that ends.

use std::ops::ControlFlow;
use wingbeat_math::{Quat, Scalar};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::{Observation, Robot};

/// Numbers of states and inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// States that dx/dt moves.
    pub states: usize,
    /// Inputs.
    pub inputs: usize,
}

/// A system at one instant.
#[derive(Debug)]
pub struct Moment<'a, M = ()> {
    /// Time, s.
    pub t: f64,
    /// State, in the units of the system's channels.
    pub x: &'a [f64],
    /// Inputs in force, in the units of the system's channels.
    pub u: &'a [f64],
    /// What the system carries from step to step.
    pub memory: &'a M,
}

impl<M> Clone for Moment<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<M> Copy for Moment<'_, M> {}

/// What a [`Stepper`](super::Stepper) advances: dx/dt = f(t, x, u), with something done between the steps.
/// Every [`Plant`] is one.
pub trait System {
    /// What changes only between the steps, beside the state: a shed wake. `()` for what is
    /// an ordinary differential equation and nothing else.
    type Memory: Clone + Default;

    /// Numbers of states and inputs.
    fn sizes(&self) -> Sizes;

    /// Writes dx/dt. Pure, and allocates nothing after the first call of a thread.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn slope(&self, at: Moment<Self::Memory>, dx: &mut [f64]) -> Result<(), Fault>;

    /// Keeps inputs within what the system can do, in the units of their channels.
    fn limit(&self, _u: &mut [f64]) {}

    /// Done once after every Runge-Kutta step, at the step's end `t`: sheds the wake of the last `dt` (s) into `memory`, puts
    /// `x` back onto its constraints. `u` are the inputs of the last stage.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn advance(
        &self,
        _t: f64,
        _dt: f64,
        _x: &mut [f64],
        _u: &[f64],
        _memory: &mut Self::Memory,
    ) -> Result<(), Fault> {
        Ok(())
    }
}

/// Inputs keep to the channels' limits; an attitude stays of unit length.
impl<P: Plant> System for P {
    type Memory = ();

    fn sizes(&self) -> Sizes {
        Sizes { states: self.states().len(), inputs: self.inputs().len() }
    }
    fn slope(&self, at: Moment, dx: &mut [f64]) -> Result<(), Fault> {
        self.rates_in_numbers(at.t, at.x, at.u, dx)
    }
    fn limit(&self, u: &mut [f64]) {
        let channels = self.inputs();
        for i in 0..u.len().min(channels.len()) {
            u[i] = channels[i].clamp(u[i]);
        }
    }
    fn advance(&self, _: f64, _: f64, x: &mut [f64], _: &[f64], _: &mut ()) -> Result<(), Fault> {
        upright(self, x);
        Ok(())
    }
}

/// Puts the attitude of a state, if there is one, back to unit length.
pub(super) fn upright<S: Scalar>(plant: &impl Plant, x: &mut [S]) {
    if let Some(a) = plant.attitude() {
        Quat::from_wxyz(&x[a..]).normalized().store_wxyz(&mut x[a..]);
    }
}

/// A system that has more to show than its state: loads, angles, power.
pub trait Observed: System {
    /// What is seen.
    type Observation;

    /// Looks at the system.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    fn observed(&self, at: Moment<Self::Memory>) -> Result<Self::Observation, Fault>;
}

impl Observed for Robot {
    type Observation = Observation;

    fn observed(&self, at: Moment) -> Result<Observation, Fault> {
        self.observe(at.t, at.x, at.u)
    }
}

/// Who steers a system through a [`Stepper::run`](super::Stepper::run), and watches it. `k` counts the run's steps;
/// its ends are before step 0, between the steps, and after the last.
pub trait Driver<M> {
    /// Decides what the inputs will be from this end of a step on, at the time `_t` (s) in the state `_x`.
    fn decide(&mut self, _k: usize, _t: f64, _x: &[f64]) {}

    /// The next end of a step after `k` at which something is decided.
    fn next(&self, k: usize) -> usize {
        k + 1
    }

    /// Writes the inputs at time `t`; what it leaves alone stays as it was.
    fn inputs(&self, t: f64, u: &mut [f64]);

    /// Sees the system at this end of a step, and stops the run by `Break`.
    ///
    /// # Errors
    /// The [`Fault`] of a system that cannot be looked at.
    fn observe(&mut self, k: usize, at: Moment<M>) -> Result<ControlFlow<()>, Fault>;

    /// What ends the run where it falls to 0, dimensionless, at the time `_t` (s) in the state `_x`; infinite where nothing does.
    fn event(&self, _t: f64, _x: &[f64]) -> f64 {
        f64::INFINITY
    }

    /// Sees the system at the event that ends the run, within a step.
    ///
    /// # Errors
    /// The [`Fault`] of a system that cannot be looked at.
    fn ended(&mut self, _at: Moment<M>) -> Result<(), Fault> {
        Ok(())
    }
}

/// Leaves the inputs as they are set; the function watches.
pub struct Held<F>(pub F);

impl<M, F: FnMut(usize, Moment<M>) -> Result<ControlFlow<()>, Fault>> Driver<M> for Held<F> {
    fn inputs(&self, _: f64, _: &mut [f64]) {}
    fn observe(&mut self, k: usize, at: Moment<M>) -> Result<ControlFlow<()>, Fault> {
        (self.0)(k, at)
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// All steps were taken.
    Complete,
    /// The model could not be evaluated.
    Fault(Fault),
    /// The observer asked to stop.
    Stopped,
}

impl Ending {
    /// The fault as an error.
    ///
    /// # Errors
    /// The [`Fault`] that ended the run.
    pub fn check(self) -> Result<(), Fault> {
        match self {
            Self::Fault(fault) => Err(fault),
            Self::Complete | Self::Stopped => Ok(()),
        }
    }
}
