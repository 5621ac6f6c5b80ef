//! What a run says of the springs on the pins of its linkage.

use super::summary::mean;
use serde::Serialize;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::linkage::{ANGLE, BEYOND};
use wingbeat_robot::{PinDeflection, Robot};

/// Springs on the pins of the linkage in a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PinSummary {
    /// Largest deflection of a pin from the rest of its spring, deg.
    pub deflection_max_deg: f64,
    /// Largest deflection over the `limit` of the spring, as a share; missing where no spring has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_fraction: Option<f64>,
    /// Largest size of the power that drive and actuators give to springs and dampers, W.
    pub power_max_w: f64,
    /// Mean of that power over all rows of the record, W: what dampers take where these are whole cycles.
    pub power_mean_w: f64,
}

impl PinSummary {
    /// Of the pins of `robot` from the columns that `record` has of them; none without a spring or a row.
    pub fn of(robot: &Robot, record: &Record) -> Option<Self> {
        let pins: Vec<&[f64]> = robot.pin_names().filter_map(|name| record.values(&name)).collect();
        let rows = pins.first().map_or(0, |pin| pin.len());
        let at = |row: usize| robot.pin_deflection(pins.iter().map(|pin| pin[row]));
        let of = (0..rows).map(at).reduce(PinDeflection::largest)?;
        let power = record.values("pin_power")?;
        Some(Self {
            deflection_max_deg: of.angle.to_degrees(),
            limit_fraction: of.fraction,
            power_max_w: power.iter().fold(0.0, |most, power| power.abs().max(most)),
            power_mean_w: mean(power)?,
        })
    }

    /// Holds them against their limits.
    pub fn judge(&self, judge: &mut Judge) {
        judge.hold(&ANGLE, self.deflection_max_deg);
        judge.hold_if(&BEYOND, self.limit_fraction);
    }
}
