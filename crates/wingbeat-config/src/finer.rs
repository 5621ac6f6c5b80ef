//! What becomes of the errors of steps: the flight once more in finer ones.

use super::Scenario;
use super::step_error;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use wingbeat_flight::guide::Prepared;
use wingbeat_flight::simulate::{Accuracy, Ending, Event, Schedule, fly_within};
use wingbeat_judge::{Warning, limits};
use wingbeat_math::Vec3;

/// Error of the second flight over that which is asked: where errors grow alike, the distance of the ends is .9 to 1.1 times that of the
/// first. *Choice.*
const FINER: f64 = 0.1;

/// A second flight, which tells what becomes of the errors of the steps of the first.
pub(super) enum SecondFlight<'a> {
    /// The controller cannot fly twice.
    Never,
    /// Its end in half steps, where the first tells that its own are too long.
    Halved(&'a dyn Fn() -> Option<Vec3>),
    /// In finer steps beside the first.
    Beside(FinerFlight),
}

/// The second flight as the first one sees it.
pub(super) struct FinerFlight {
    /// The first one goes ahead by a sample at most, so that whatever ends it ends both.
    told: SyncSender<()>,
    end: Receiver<Option<Vec3>>,
}

/// The second flight as it sees the first.
pub(super) struct FirstFlight {
    seen: Receiver<()>,
    end: Sender<Option<Vec3>>,
}

/// Both ends of what the two tell each other.
pub(super) fn pair() -> (FinerFlight, FirstFlight) {
    let ((told, seen), (to, from)) = (sync_channel(1), channel());
    (FinerFlight { told, end: from }, FirstFlight { seen, end: to })
}

impl FinerFlight {
    /// Lets the second flight go on by a sample.
    pub fn go_on(&self) {
        // One that has ended says so at its end.
        let _ = self.told.send(());
    }

    /// Distance from `position` to where the second flight ends, m; infinite where it breaks down, none where no thread was there for it.
    pub fn distance(self, position: Vec3) -> Option<f64> {
        drop(self.told);
        let end = self.end.recv().ok()?;
        Some(end.map_or(f64::INFINITY, |end| (end - position).norm()))
    }
}

impl Scenario {
    /// Whether a flight under the scenario's own controller has an error asked of it.
    pub(super) fn flies_again(&self) -> bool {
        self.spec.flight.error_m.is_some() && self.schedule.steps_per_update.is_some()
    }

    /// Flies once more beside the `first` flight.
    pub(super) fn fly_again(&self, prepared: Option<Prepared>, first: &FirstFlight) {
        // Whoever no longer asks has ended.
        let _ = first.end.send(self.end_in_finer_steps(prepared, &first.seen));
    }

    fn end_in_finer_steps(&self, prepared: Option<Prepared>, seen: &Receiver<()>) -> Option<Vec3> {
        let layout = self.robot.layout();
        let end = self.schedule.step * self.schedule.steps as f64;
        let reach = |t: f64, states: [&[f64]; 2]| step_error::reach(layout, end - t, states);
        let breaks = self.spec.air.breaks();
        let asked = Accuracy { error: FINER * self.spec.flight.error_m?, reach: &reach, breaks: &breaks };
        self.end_of_another(prepared, &self.schedule, Some(&asked), &|| seen.recv().is_ok())
    }

    /// The error of steps, m: at most `most`, or where that is told as too much, what a flight in half steps shows, whose end is another.
    pub(super) fn measured_error(&self, most: f64, end: &dyn Fn() -> Option<Vec3>, position: Vec3) -> f64 {
        let told = |limit| self.limits.of(limit).0;
        let told = told(&limits::flight::STEP_ERROR).min(told(&limits::flight::STEPS_LOST));
        if most <= told || most.is_infinite() {
            return most;
        }
        end().map_or(f64::INFINITY, |end| step_error::halved([position, end]))
    }

    /// Where the flight ends in steps of half the length; none where it breaks down.
    pub(super) fn end_in_half_steps(&self) -> Option<Vec3> {
        let prepared = self.prepared.clone().or_else(|| self.prepare());
        self.end_of_another(prepared, &self.schedule.halved(), None, &|| true)
    }

    fn end_of_another(
        &self,
        prepared: Option<Prepared>,
        schedule: &Schedule,
        asked: Option<&Accuracy>,
        goes_on: &dyn Fn() -> bool,
    ) -> Option<Vec3> {
        let mut pilot = self.pilot(prepared).ok()?;
        let mut x = self.start();
        let latches = |_: f64, x: &[f64]| self.short_of_latching(x);
        let ends: (Event, _) = (&latches, asked);
        let flight =
            fly_within(&self.robot, &mut self.sensors(), &mut *pilot, schedule, &mut x, ends, |_, _| {
                Ok(if goes_on() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
            });
        let caught = self.short_of_latching(&x) <= 0.0;
        let position = Vec3::from_slice(&x[self.robot.layout().position..]);
        (flight.ending == Ending::Complete || caught).then_some(position)
    }
}

/// What is said of an error that is asked beside a controller which cannot fly twice.
pub(super) fn flown_once() -> Warning {
    let text = "flight.error_m is that of the steps alone: what the closed loop makes of them is known from a second flight, which a controller of the caller's own does not have";
    Warning::new("flight.error_of_steps", text).key("flight.error_m")
}
