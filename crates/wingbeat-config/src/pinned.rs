//! What a run says of the springs on the pins of its linkage.

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
}

impl PinSummary {
    /// Of the pins of `robot` from the columns that `record` has of them; none without a spring or a row.
    pub fn of(robot: &Robot, record: &Record) -> Option<Self> {
        let pins: Vec<&[f64]> = robot.pin_names().filter_map(|name| record.values(&name)).collect();
        let rows = pins.first().map_or(0, |pin| pin.len());
        let at = |row: usize| robot.pin_deflection(pins.iter().map(|pin| pin[row]));
        (0..rows).map(at).reduce(PinDeflection::largest).map(Self::new)
    }

    /// Of the largest deflection.
    pub fn new(of: PinDeflection) -> Self {
        Self { deflection_max_deg: of.angle.to_degrees(), limit_fraction: of.fraction }
    }

    /// Holds them against their limits.
    pub fn judge(&self, judge: &mut Judge) {
        judge.hold(&ANGLE, self.deflection_max_deg);
        judge.hold_if(&BEYOND, self.limit_fraction);
    }
}
