//! What a run says of its flaps.

use serde::Serialize;
use wingbeat_aero::Aero;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::flap::{ANGLE, BEYOND_ANGLE, BEYOND_WEIGHT, WEIGHT};

/// Angle of a flap, rad, beside which a sag that is left out is held where the flap turns by less: 5 deg, half of what is small. *Choice.*
const SMALL: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// Flaps of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FlapSummary {
    /// Largest angle, deg.
    pub angle_max_deg: f64,
    /// Weight of a flap that is left out over what its spring bears: of a robot m g r/k, along the chord; on a tether that over the largest angle or 5 deg.
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
        let weight_fraction = sag / all.angle_max_deg.to_radians().max(SMALL);
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
