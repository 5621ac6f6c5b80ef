//! What a closed loop makes of the errors of steps: the flight once more in finer ones, beside the first.

use super::Scenario;
use super::step_error;
use std::ops::ControlFlow;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use wingbeat_flight::guide::Prepared;
use wingbeat_flight::simulate::{Accuracy, Ending, Event, fly_within};
use wingbeat_judge::Warning;
use wingbeat_math::Vec3;

/// Error of the second flight over that which is asked: where errors grow alike, the distance of the ends is .9 to 1.1 times that of the
/// first. *Choice.*
const FINER: f64 = 0.1;

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
        let mut pilot = self.pilot(prepared).ok()?;
        let (mut x, layout) = (self.start(), self.robot.layout());
        let end = self.schedule.step * self.schedule.steps as f64;
        let reach = |t: f64, states: [&[f64]; 2]| step_error::reach(layout, end - t, states);
        let breaks = self.spec.air.breaks();
        let asked = Accuracy { error: FINER * self.spec.flight.error_m?, reach: &reach, breaks: &breaks };
        let latches = |_: f64, x: &[f64]| self.short_of_latching(x);
        let ends: (Event, _) = (&latches, Some(&asked));
        let flight = fly_within(
            &self.robot,
            &mut self.sensors(),
            &mut *pilot,
            &self.schedule,
            &mut x,
            ends,
            |_, _| Ok(if seen.recv().is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }),
        );
        let caught = self.short_of_latching(&x) <= 0.0;
        (flight.ending == Ending::Complete || caught).then(|| Vec3::from_slice(&x[layout.position..]))
    }
}

/// What is said of an error that is asked beside a controller which cannot fly twice.
pub(super) fn flown_once() -> Warning {
    let text = "flight.error_m is that of the steps alone: what the closed loop makes of them is known from a second flight, which a controller of the caller's own does not have";
    Warning::new("flight.error_of_steps", text).key("flight.error_m")
}
