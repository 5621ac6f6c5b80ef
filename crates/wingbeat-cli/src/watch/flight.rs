//! A flight while it is flown.

use std::sync::Arc;

use serde_json::json;
use wingbeat::scenario::{Scenario, ShownSample, Watched};
use wingbeat::simulate::Sample;
use wingbeat_report::growing::GrowingRows;
use wingbeat_report::motion::{MOST, RATE};
use wingbeat_report::run::{FlownScenario, ShownRun, of_flight};

use super::{Watch, WatchArguments};
use crate::error::Error;

/// A flight that is watched, or not.
pub struct FlightWatch {
    watch: Option<Watch<ShownSample>>,
    /// Time of the next sample that is shown, and to the one after it, s.
    next: f64,
    step: f64,
    shown: usize,
}

impl FlightWatch {
    /// Begins where it is wanted.
    ///
    /// # Errors
    /// Those of [`Watch::begin`].
    pub fn begin(live: &WatchArguments, scenario: &Arc<Scenario>) -> Result<Self, Error> {
        let scenario = scenario.clone();
        let watch = Watch::begin(live, move |painter| {
            // A scenario that can be flown can be recorded.
            let Ok(watched) = scenario.watched() else { return };
            let mut sound = true;
            let add = |watched: &mut Watched<'_>, news: Vec<ShownSample>| {
                sound = sound && news.iter().all(|seen| watched.add(seen).is_ok());
            };
            let mut growing = GrowingRows::default();
            painter.run(watched, add, |watched, runs| drawn(&scenario, watched, &mut growing, runs));
        })?;
        Ok(Self { watch, next: 0.0, step: 1.0 / RATE, shown: 0 })
    }

    /// Shows a sample, where one is due: at most so many a second as the page has, half as many once that is full.
    pub fn see(&mut self, sample: &Sample) {
        let Some(watch) = &self.watch else { return };
        if sample.t < self.next {
            return;
        }
        watch.tell(ShownSample::of(sample));
        self.shown += 1;
        if self.shown == MOST {
            // The page then shows every second row of these.
            self.shown = MOST / 2;
            self.step *= 2.0;
        }
        self.next += self.step;
    }

    /// Says that the flight is over.
    pub fn end(&self) {
        self.watch.iter().for_each(Watch::end);
    }
}

/// Takes what was flown into the `runs`; true where these have only grown.
fn drawn(
    scenario: &Scenario,
    watched: &Watched<'_>,
    growing: &mut GrowingRows,
    runs: &mut Vec<ShownRun>,
) -> bool {
    let flown = FlownScenario { scenario, record: watched.record() };
    if runs.is_empty() {
        let first = of_flight(&scenario.spec.name, "flight under way", flown, &[]);
        runs.push(ShownRun { settings: scenario.resolved.clone(), ..first });
    }
    let grown = growing.grow(&mut runs[0], flown);
    let now = watched.record().values("t").and_then(|t| t.last()).copied().unwrap_or(0.0);
    runs[0].summary = json!({ "simulated_s": now, "of_s": scenario.spec.flight.duration_s });
    grown
}
