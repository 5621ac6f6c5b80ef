//! How well a reduced plan foretold its flight.

use super::summary::mean;
use serde::Serialize;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::flight;

/// A flight by a plan that leaves out a part of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ReducedPlanSummary {
    /// Error of the plan of an update at the next one, of height, velocity, roll, pitch and rates, each over the deviation that costs as much as a full
    /// command: root mean square over these and over the flight.
    pub error_rms: f64,
    /// Largest of it at an update, dimensionless.
    pub error_max: f64,
}

impl ReducedPlanSummary {
    /// Of a record; none where the plan leaves out nothing.
    pub(super) fn new(record: &Record) -> Option<Self> {
        let errors = record.values("orbit_plan_error")?;
        let square = mean(&errors.iter().map(|error| error * error).collect::<Vec<_>>())?;
        Some(Self { error_rms: square.sqrt(), error_max: errors.iter().copied().fold(0.0, f64::max) })
    }

    pub(super) fn judge(&self, judge: &mut Judge) {
        judge.hold(&flight::PLAN_ERROR, self.error_rms);
    }
}
