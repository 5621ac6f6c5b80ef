//! Flights of several plants at once, in the lanes of a scalar.

use super::fly::{Controller, Flight, Pilot, Sample, Schedule};
use super::sensor::Sensors;
use super::stepper::finite;
use super::system::{Driver, Ending, Moment, System, upright};
use std::ops::ControlFlow;
use wingbeat_math::{Dynamics, EqualSteps, Lanes, RK4, Workspace};
use wingbeat_ocp::plant::{Fault, Plant};

/// One flight of several.
#[derive(Debug)]
pub struct Seat<'a, P, C, O> {
    /// What flies.
    pub plant: &'a P,
    /// What the controller knows of it.
    pub sensors: &'a mut Sensors,
    /// Who steers.
    pub controller: &'a mut C,
    /// The clock; the steps of all flights are alike.
    pub schedule: &'a Schedule,
    /// State at t = 0, in the units of the plant's channels.
    pub start: &'a [f64],
    /// Sees every sample, the first at t = 0, and may stop the flight.
    pub observe: O,
}

/// A flight under way.
struct Lane<'a, P, C, O> {
    pilot: Pilot<'a, P, C, O>,
    x: Vec<f64>,
    u: Vec<f64>,
    /// How it ended, and the time that it reached, s.
    ended: Option<(Ending, f64)>,
}

/// Flies as [`fly`](super::fly) does, each flight in a lane: `rates` are those of all plants at once, as
/// [`Plant::rates`] of each. Everything else is done flight by flight in double precision.
///
/// What becomes of a flight does not depend, to the bit, on those beside it, nor on their number or order. It differs from
/// what [`fly`](super::fly) makes of it by the rounding of `S`.
///
/// # Panics
/// When there are more flights than lanes, none, or of other sizes or steps.
pub fn fly_side_by_side<'a, S: Lanes, P: Plant, C: Controller, O>(
    rates: impl Fn(S, &[S], &[S], &mut [S]) -> Result<(), Fault>,
    seats: Vec<Seat<'a, P, C, O>>,
) -> Vec<Flight>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    assert!((1..=S::WIDTH).contains(&seats.len()), "{} flights in {} lanes", seats.len(), S::WIDTH);
    let Schedule { step, steps, .. } = *seats[0].schedule;
    let (states, inputs) = (seats[0].start.len(), seats[0].plant.inputs().len());
    let lane = |Seat { plant, sensors, controller, schedule, start, observe }: Seat<'a, P, C, O>| {
        assert!(schedule.step == step && schedule.steps == steps, "steps of all flights are alike");
        let pilot = Pilot::new(plant, sensors, controller, schedule, observe);
        let mut u = vec![0.0; inputs];
        plant.limit(&mut u);
        Lane { pilot, x: start.to_vec(), u, ended: None }
    };
    let lanes: Vec<_> = seats.into_iter().map(lane).collect();
    let last = lanes.len() - 1;
    let mut x: Vec<S> = (0..states).map(|i| S::of(|lane| lanes[lane.min(last)].x[i])).collect();
    let all = EqualSteps::new(0.0, step, steps);
    let mut row = FlightRow { lanes, rates, steps: all, u: vec![S::ZERO; inputs] };
    let whole = if row.boundary(0, &x).is_break() {
        Ok(false)
    } else {
        let todo = EqualSteps::new(S::ZERO, S::from(step), steps);
        RK4.integrate(&mut row, todo, &mut x, &mut Workspace::new(states, RK4.b.len()))
    };
    let end = match whole {
        Err(fault) => Ending::Fault(fault),
        Ok(_) => Ending::Complete,
    };
    let flight = |lane: Lane<P, C, O>| {
        let (ending, duration) = lane.ended.unwrap_or((end, all.time(steps)));
        lane.pilot.flight(ending, duration)
    };
    row.lanes.into_iter().map(flight).collect()
}

/// The flights as the integrator sees them.
struct FlightRow<'a, S, P, C, O, F> {
    lanes: Vec<Lane<'a, P, C, O>>,
    rates: F,
    steps: EqualSteps,
    u: Vec<S>,
}

impl<S: Lanes, P: Plant, C: Controller, O, F> FlightRow<'_, S, P, C, O, F>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    /// Before step `k` of every flight: look whether it goes on, decide, apply, record.
    fn boundary(&mut self, k: usize, x: &[S]) -> ControlFlow<()> {
        let t = self.steps.time(k);
        for (number, lane) in self.lanes.iter_mut().enumerate().filter(|(_, lane)| lane.ended.is_none()) {
            for (to, from) in lane.x.iter_mut().zip(x) {
                *to = from.lane(number);
            }
            let before = self.steps.time(k.saturating_sub(1));
            if let Err(fault) = finite(&lane.x, before) {
                lane.ended = Some((Ending::Fault(fault), before));
                continue;
            }
            lane.pilot.decide(k, t, &lane.x);
            lane.set_inputs(t);
            let ending = match lane.pilot.observe(k, Moment { t, x: &lane.x, u: &lane.u, memory: &() }) {
                Ok(ControlFlow::Continue(())) => continue,
                Ok(ControlFlow::Break(())) => Ending::Stopped,
                Err(fault) => Ending::Fault(fault),
            };
            lane.ended = Some((ending, t));
        }
        if self.lanes.iter().all(|lane| lane.ended.is_some()) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }
}

impl<P: Plant, C: Controller, O> Lane<'_, P, C, O>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
{
    fn set_inputs(&mut self, t: f64) {
        self.pilot.inputs(t, &mut self.u);
        self.pilot.plant.limit(&mut self.u);
    }
}

impl<S: Lanes, P: Plant, C: Controller, O, F> Dynamics<S, Fault> for FlightRow<'_, S, P, C, O, F>
where
    O: FnMut(&Sample, &C) -> Result<ControlFlow<()>, Fault>,
    F: Fn(S, &[S], &[S], &mut [S]) -> Result<(), Fault>,
{
    fn slope(&mut self, t: S, x: &[S], dx: &mut [S]) -> Result<(), Fault> {
        let Self { lanes, rates, u, .. } = self;
        lanes.iter_mut().filter(|lane| lane.ended.is_none()).for_each(|lane| lane.set_inputs(t.value()));
        let last = lanes.len() - 1;
        for (i, u) in u.iter_mut().enumerate() {
            *u = S::of(|lane| lanes[lane.min(last)].u[i]);
        }
        rates(t, x, u, dx)
    }

    fn after_step(&mut self, k: usize, _: S, x: &mut [S]) -> Result<ControlFlow<()>, Fault> {
        upright(self.lanes[0].pilot.plant, x);
        Ok(self.boundary(k + 1, x))
    }
}
