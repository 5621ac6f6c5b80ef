//! The loop of plant, controller and clock.

use super::record::Column;
use crate::math::{Quat, RK4, Workspace};
use crate::plant::{Fault, Plant};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// What decides the plant's inputs.
pub trait Controller {
    /// Plans anew from the measured state. A failure leaves the previous plan in force.
    fn update(&mut self, t: f64, x: &[f64]) -> Update;
    /// Writes the planned inputs at time `t`, the very function the plan was made with.
    fn input(&self, t: f64, u: &mut [f64]);
    /// Columns of [`diagnostics`](Self::diagnostics).
    fn columns(&self) -> Vec<Column> {
        Vec::new()
    }
    /// Appends what the last update tells of itself, one number per column.
    /// Nothing that depends on the wall clock, so that records repeat.
    fn diagnostics(&self, _row: &mut Vec<f64>) {}
}

/// How an update of the controller ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// A new plan is in force.
    Fresh,
    /// The update failed; the previous plan goes on.
    Kept,
    /// The update came after its deadline; the previous plan goes on.
    Late,
}

/// The controller that leaves every regulator at rest.
#[derive(Clone, Copy, Debug)]
pub struct AtRest;

impl Controller for AtRest {
    fn update(&mut self, _: f64, _: &[f64]) -> Update {
        Update::Fresh
    }
    fn input(&self, _: f64, u: &mut [f64]) {
        u.fill(0.0);
    }
}

/// The clock of a flight: whole steps between updates and between samples.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    /// Integration step, s.
    pub step: f64,
    /// Number of steps.
    pub steps: usize,
    /// Steps between controller updates; `None` never updates.
    pub steps_per_update: Option<usize>,
    /// Steps between samples.
    pub steps_per_sample: usize,
}

/// The plant at one instant, as it is recorded.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Time, s.
    pub t: f64,
    /// State.
    pub x: &'a [f64],
    /// Inputs in force.
    pub u: &'a [f64],
    /// Wall time since the flight began.
    pub elapsed: Duration,
}

/// How a flight ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// The whole duration was flown.
    Complete,
    /// The model could not be evaluated.
    Fault(Fault),
    /// The observer asked to stop.
    Stopped,
}

/// A flown flight without its samples.
#[derive(Clone, Debug)]
pub struct Flight {
    /// How it ended.
    pub ending: Ending,
    /// Time reached, s.
    pub duration: f64,
    /// Wall time of the loop.
    pub wall: Duration,
    /// Wall time of each controller update.
    pub updates: Vec<Duration>,
    /// Updates that failed and kept the previous plan.
    pub failures: usize,
    /// Updates that came late and kept the previous plan.
    pub late: usize,
}

/// Flies `plant` from `x` (state at t = 0, left at the final state) under
/// `controller`: classical Runge-Kutta steps, inputs limited by the plant's
/// channels, quaternion renormalised every step.
///
/// `observe` sees every sample, the first at t = 0, and may stop the flight.
pub fn fly<P: Plant, C: Controller>(
    plant: &P,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    mut observe: impl FnMut(&Sample, &C) -> ControlFlow<()>,
) -> Flight {
    let start = Instant::now();
    let mut u = vec![0.0; plant.inputs().len()];
    let mut stage_u = u.clone();
    let mut work = Workspace::new(x.len(), RK4.b.len());
    let mut flight = Flight {
        ending: Ending::Complete,
        duration: 0.0,
        wall: Duration::ZERO,
        updates: Vec::with_capacity(schedule.steps_per_update.map_or(0, |n| schedule.steps / n + 1)),
        failures: 0,
        late: 0,
    };
    for i in 0..=schedule.steps {
        let t = i as f64 * schedule.step;
        flight.duration = t;
        if schedule.steps_per_update.is_some_and(|n| i % n == 0) && i < schedule.steps {
            let begun = Instant::now();
            match controller.update(t, x) {
                Update::Fresh => {}
                Update::Kept => flight.failures += 1,
                Update::Late => flight.late += 1,
            }
            flight.updates.push(begun.elapsed());
        }
        if i % schedule.steps_per_sample == 0 {
            limited_input(plant, controller, t, &mut u);
            if observe(&Sample { t, x, u: &u, elapsed: start.elapsed() }, controller).is_break() {
                flight.ending = Ending::Stopped;
                break;
            }
        }
        if i == schedule.steps {
            break;
        }
        let rates = |t: f64, x: &[f64], dx: &mut [f64]| {
            limited_input(plant, controller, t, &mut stage_u);
            plant.rates(t, x, &stage_u, dx)
        };
        let end = RK4.step(rates, t, schedule.step, x, &mut work).and_then(|()| finite(x, t));
        if let Err(fault) = end {
            flight.ending = Ending::Fault(fault);
            break;
        }
        renormalise(plant, x);
    }
    flight.wall = start.elapsed();
    flight
}

/// The controller's inputs at `t`, limited by the plant's channels.
fn limited_input<P: Plant, C: Controller>(plant: &P, controller: &C, t: f64, u: &mut [f64]) {
    controller.input(t, u);
    for (u, channel) in u.iter_mut().zip(plant.inputs()) {
        *u = channel.clamp(*u);
    }
}

fn finite(x: &[f64], time: f64) -> Result<(), Fault> {
    match x.iter().position(|v| !v.is_finite()) {
        Some(state) => Err(Fault::NotFinite { state, time }),
        None => Ok(()),
    }
}

fn renormalise<P: Plant>(plant: &P, x: &mut [f64]) {
    if let Some(a) = plant.attitude() {
        Quat::from_wxyz(&x[a..]).normalized().store_wxyz(&mut x[a..]);
    }
}
