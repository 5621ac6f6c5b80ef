//! What a flight has come to while it goes on.

use crate::Scenario;
use crate::recorder::Recorder;
use std::time::Duration;
use wingbeat_flight::simulate::{AtRest, Record, Sample};
use wingbeat_math::Error;
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::BeyondLoads;

/// A sample that outlives the instant at which it was shown.
#[derive(Clone, Debug)]
pub struct ShownSample {
    t: f64,
    x: Vec<f64>,
    u: Vec<f64>,
    beyond: BeyondLoads,
    readings: Vec<f64>,
}

impl ShownSample {
    /// A copy of a sample.
    pub fn of(sample: &Sample) -> Self {
        Self {
            t: sample.t,
            x: sample.x.to_vec(),
            u: sample.u.to_vec(),
            beyond: sample.beyond.clone(),
            readings: sample.readings.to_vec(),
        }
    }
}

/// The record of a flight as far as its samples are known, with the readings of its sensors, without what controller and strips tell.
pub struct Watched<'a>(Recorder<'a>);

impl Scenario {
    /// A record that grows with the samples of a flight.
    ///
    /// # Errors
    /// Columns of one name.
    pub fn watched(&self) -> Result<Watched<'_>, Error> {
        let readings = self.sensors().columns(self.schedule.steps_per_update.is_some());
        Recorder::new(self.robot(), self.manoeuvre(), (&AtRest, readings), 0, None).map(Watched)
    }
}

impl Watched<'_> {
    /// Adds a sample.
    ///
    /// # Errors
    /// A state that has no loads, or a number that is not finite.
    pub fn add(&mut self, seen: &ShownSample) -> Result<(), Fault> {
        let ShownSample { t, x, u, beyond, readings } = seen;
        self.0.sample(&Sample { t: *t, x, u, beyond, readings, elapsed: Duration::ZERO }, &AtRest)
    }

    /// The record so far.
    pub fn record(&self) -> &Record {
        self.0.record()
    }
}
