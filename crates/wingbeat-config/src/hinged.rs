//! What a run says of its flaps.

use serde::Serialize;
use wingbeat_aero::Aero;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::flap::{ANGLE, BEYOND_ANGLE, BEYOND_WEIGHT, WEIGHT};

/// Flaps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FlapSummary {
    /// Largest angle, deg.
    pub angle_max_deg: f64,
    /// Weight of a flap that is left out over what its spring bears: of a robot m g r/k, along the chord; on a tether that over the largest angle.
    pub weight_fraction: f64,
}

impl FlapSummary {
    /// Of the surface `aero` of a robot from the angles (rad) of its strips at all instants; none without a flap or an instant.
    pub fn of(aero: &Aero, angles: impl Iterator<Item = f64>) -> Option<Self> {
        let weight_fraction = aero.flap()?.flap_sag()?;
        let largest = angles.map(f64::abs).reduce(f64::max)?;
        Some(Self { angle_max_deg: largest.to_degrees(), weight_fraction })
    }

    /// The same of a tethered wing, which knows no gravity.
    pub fn tethered(aero: &Aero, angles: impl Iterator<Item = f64>) -> Option<Self> {
        let all = Self::of(aero, angles)?;
        let sag = all.weight_fraction;
        let weight_fraction = if sag == 0.0 { 0.0 } else { sag / all.angle_max_deg.to_radians() };
        Some(Self { weight_fraction, ..all })
    }

    /// The worse of two.
    pub fn worse(self, other: Self) -> Self {
        Self {
            angle_max_deg: self.angle_max_deg.max(other.angle_max_deg),
            weight_fraction: self.weight_fraction.max(other.weight_fraction),
        }
    }

    /// Holds them against their limits.
    pub fn judge(&self, judge: &mut Judge) {
        judge.hold(&ANGLE, self.angle_max_deg);
        judge.hold(&BEYOND_ANGLE, self.angle_max_deg);
        judge.hold(&WEIGHT, self.weight_fraction);
        judge.hold(&BEYOND_WEIGHT, self.weight_fraction);
    }
}
