//! How well plans foretold their flight.

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

/// A flight whose updates are prepared before their measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PreparedSummary {
    /// Angle between the attitude for which an update was prepared and that which it found, deg: root mean square over the record.
    pub missed_rms_deg: f64,
    /// Largest of it over all updates, deg.
    pub missed_max_deg: f64,
}

impl PreparedSummary {
    /// Of a record; none where no update is prepared.
    pub(super) fn new(record: &Record) -> Option<Self> {
        let angles = record.values("plan_missed_attitude")?;
        let square = mean(&angles.iter().map(|angle| angle * angle).collect::<Vec<_>>())?;
        let largest = *record.values("plan_missed_attitude_largest")?.last()?;
        let [missed_rms_deg, missed_max_deg] = [square.sqrt(), largest].map(f64::to_degrees);
        Some(Self { missed_rms_deg, missed_max_deg })
    }

    pub(super) fn judge(&self, judge: &mut Judge) {
        judge.hold(&flight::PREPARED_MISSED, self.missed_max_deg);
    }
}
