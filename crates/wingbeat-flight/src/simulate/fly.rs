//! The flight of a plant: sensors, controller and clock around the stepper.

use super::accuracy::{Accuracy, Taken};
use super::coupled::Steers;
use super::record::Column;
use super::sensor::{Measurement, Sensors};
use super::stepper::Stepper;
use super::system::{Driver, Ending, Moment};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_robot::BeyondLoads;

/// What decides the plant's inputs.
pub trait Controller {
    /// Does what can be done for the update at time `t`, s, before it is measured. An update that was not prepared gives the same commands.
    fn prepare(&mut self, _t: f64) {}
    /// Plans anew at time `t` from what is measured. A failure leaves the previous plan in force.
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update;
    /// Writes the planned inputs at time `t`, the very function the plan was made with.
    fn input(&self, t: f64, u: &mut [f64]);
    /// Columns of [`diagnostics`](Self::diagnostics).
    fn columns(&self) -> Vec<Column> {
        Vec::new()
    }
    /// Appends what the last update tells of itself, one number per column in its unit. Nothing that depends on the wall clock,
    /// so that records repeat.
    fn diagnostics(&self, _row: &mut Vec<f64>) {}
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    fn prepare(&mut self, t: f64) {
        (**self).prepare(t);
    }
    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        (**self).update(t, measurement)
    }
    fn input(&self, t: f64, u: &mut [f64]) {
        (**self).input(t, u);
    }
    fn columns(&self) -> Vec<Column> {
        (**self).columns()
    }
    fn diagnostics(&self, row: &mut Vec<f64>) {
        (**self).diagnostics(row);
    }
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
    fn update(&mut self, _: f64, _: &Measurement) -> Update {
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

impl Schedule {
    /// The same flight in steps of half the length.
    pub fn halved(&self) -> Self {
        Self {
            step: 0.5 * self.step,
            steps: 2 * self.steps,
            steps_per_update: self.steps_per_update.map(|steps| 2 * steps),
            steps_per_sample: 2 * self.steps_per_sample,
        }
    }
}

/// The plant at one instant, as it is recorded.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Time, s.
    pub t: f64,
    /// State, in the units of the plant's channels.
    pub x: &'a [f64],
    /// Inputs in force, in the units of the plant's channels.
    pub u: &'a [f64],
    /// Loads from beyond the robot's own models, as [`Robot::rates_beyond`](wingbeat_robot::Robot::rates_beyond) takes them.
    pub beyond: &'a BeyondLoads,
    /// What the sensors read, each in the unit of its column of [`Sensors::columns`]; empty before anything was measured.
    pub readings: &'a [f64],
    /// Wall time since the flight began.
    pub elapsed: Duration,
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
    /// Wall time of each controller update, with its preparation.
    pub updates: Vec<Duration>,
    /// Wall time of each from the measurement to the commands.
    pub answers: Vec<Duration>,
    /// Updates that failed and kept the previous plan.
    pub failures: usize,
    /// Updates that came late and kept the previous plan.
    pub late: usize,
    /// The steps that were taken, where a stated error chose them.
    pub taken: Option<Taken>,
}

/// Flies `plant` from `x` (state at t = 0, left at the final state) under
/// `controller`, which knows of it what `sensors` tell: the steps of a [`Stepper`], inputs limited by the plant's
/// channels, quaternion renormalised every step.
///
/// `observe` sees every sample, the first at t = 0, and may stop the flight.
pub fn fly<P: Plant, C: Controller + ?Sized>(
    plant: &P,
    sensors: &mut Sensors,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    observe: impl FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
) -> Flight {
    fly_until(plant, sensors, controller, schedule, x, &|_, _| f64::INFINITY, observe)
}

/// As [`fly`], up to where `event`, dimensionless, of the time (s) and the state falls to 0, if it does: that instant is found within its
/// step, and `observe` sees it as the last sample, between those that are due.
pub fn fly_until<P: Plant, C: Controller + ?Sized>(
    plant: &P,
    sensors: &mut Sensors,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    event: Event,
    observe: impl FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
) -> Flight {
    fly_within(plant, sensors, controller, schedule, x, (event, None), observe)
}

/// As [`fly_until`], where an accuracy is asked in steps as long as it allows; updates and samples stay where they are.
pub fn fly_within<P: Plant, C: Controller + ?Sized>(
    plant: &P,
    sensors: &mut Sensors,
    controller: &mut C,
    schedule: &Schedule,
    x: &mut [f64],
    (event, asked): (Event, Option<&Accuracy>),
    mut observe: impl FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
) -> Flight {
    let observe: SampleObserver<C> = &mut observe;
    let mut pilot = Pilot { event, ..Pilot::new(plant, sensors, controller, schedule, observe) };
    let mut stepper = Stepper::new(plant, 0.0, x);
    let (ending, taken) = match asked {
        None => (stepper.run(schedule.step, schedule.steps, &mut pilot), None),
        Some(asked) => {
            let (ending, taken) = stepper.run_within(schedule.step, schedule.steps, &mut pilot, asked);
            (ending, Some(taken))
        }
    };
    x.copy_from_slice(stepper.state());
    Flight { taken, ..pilot.flight(ending, stepper.time()) }
}

/// Who sees the samples of a flight, whatever it does with them.
pub(super) type SampleObserver<'a, C> = &'a mut dyn FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>;

/// What ends a flight where it falls to 0, dimensionless, of the time (s) and the state.
pub type Event<'a> = &'a dyn Fn(f64, &[f64]) -> f64;

/// A controller behind its sensors at the stepper's wheel.
pub(super) struct Pilot<'a, P, C: ?Sized, O> {
    pub plant: &'a P,
    sensors: &'a mut Sensors,
    controller: &'a mut C,
    schedule: &'a Schedule,
    event: Event<'a>,
    observe: O,
    start: Instant,
    updates: Vec<Duration>,
    answers: Vec<Duration>,
    failures: usize,
    late: usize,
}

impl<'a, P, C: ?Sized, O> Pilot<'a, P, C, O> {
    /// At the wheel from now on.
    pub fn new(
        plant: &'a P,
        sensors: &'a mut Sensors,
        controller: &'a mut C,
        schedule: &'a Schedule,
        observe: O,
    ) -> Self {
        let updates = schedule.steps_per_update.map_or(0, |n| schedule.steps / n + 1);
        Self {
            plant,
            sensors,
            controller,
            schedule,
            event: &|_, _| f64::INFINITY,
            observe,
            start: Instant::now(),
            updates: Vec::with_capacity(updates),
            answers: Vec::with_capacity(updates),
            failures: 0,
            late: 0,
        }
    }

    /// The flight that ended so at the time `duration`, s.
    pub fn flight(self, ending: Ending, duration: f64) -> Flight {
        Flight {
            ending,
            duration,
            wall: self.start.elapsed(),
            updates: self.updates,
            answers: self.answers,
            failures: self.failures,
            late: self.late,
            taken: None,
        }
    }
}

impl<P: Plant, C: Controller + ?Sized, O> Driver<()> for Pilot<'_, P, C, O>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    fn decide(&mut self, k: usize, t: f64, x: &[f64]) {
        self.update(k, t, x);
    }

    fn next(&self, k: usize) -> usize {
        let every = self.schedule.steps_per_update;
        every.map_or(usize::MAX, |every| (k / every + 1) * every)
    }

    fn inputs(&self, t: f64, u: &mut [f64]) {
        self.controller.input(t, u);
    }

    fn observe(&mut self, k: usize, at: Moment) -> Result<ControlFlow<()>, Fault> {
        self.sensors.watch(k, self.plant, at.t, at.x, at.u)?;
        self.see(k, (at.t, at.x, at.u), &BeyondLoads::NONE)
    }

    fn event(&self, t: f64, x: &[f64]) -> f64 {
        (self.event)(t, x)
    }

    fn ended(&mut self, at: Moment) -> Result<(), Fault> {
        self.see(0, (at.t, at.x, at.u), &BeyondLoads::NONE).map(drop)
    }
}

impl<P, C: Controller + ?Sized, O> Steers for Pilot<'_, P, C, O>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    /// Lets the controller plan anew before step `k`, where that is due.
    fn update(&mut self, k: usize, t: f64, x: &[f64]) {
        let due = self.schedule.steps_per_update.is_some_and(|n| k.is_multiple_of(n));
        if k == self.schedule.steps || !due {
            return;
        }
        let begun = Instant::now();
        self.controller.prepare(t);
        let measured = Instant::now();
        match self.controller.update(t, &self.sensors.measure(t, x)) {
            Update::Fresh => {}
            Update::Kept => self.failures += 1,
            Update::Late => self.late += 1,
        }
        let ended = Instant::now();
        self.updates.push(ended - begun);
        self.answers.push(ended - measured);
    }

    fn planned(&self, t: f64, u: &mut [f64]) {
        self.controller.input(t, u);
    }

    /// Shows the sample before step `k`, where one is due.
    fn see(
        &mut self,
        k: usize,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &BeyondLoads,
    ) -> Result<ControlFlow<()>, Fault> {
        if !k.is_multiple_of(self.schedule.steps_per_sample) {
            return Ok(ControlFlow::Continue(()));
        }
        let readings = self.sensors.shown(t);
        let sample = Sample { t, x, u, beyond, readings, elapsed: self.start.elapsed() };
        (self.observe)(&sample, self.controller)
    }
}
