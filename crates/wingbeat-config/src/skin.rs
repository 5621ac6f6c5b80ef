//! What a run says of its membranes.

use serde::Serialize;
use wingbeat_aero::{Aero, membrane_height};

/// Membranes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MembraneSummary {
    /// Largest rise over the chord.
    pub camber_max: f64,
    /// Share of strips and instants in which the membrane is slack along the chord.
    pub slack_fraction: f64,
    /// Frequency of the motion over the least one of the membranes.
    pub frequency_fraction: f64,
}

impl MembraneSummary {
    /// Of the surface `aero` from the heights over the chord of its strips at all instants; none without a membrane.
    pub fn of(aero: &Aero, heights: impl Iterator<Item = [f64; 2]>, frequency_hz: f64) -> Option<Self> {
        let membrane = aero.membrane()?;
        let (mut camber_max, mut slack, mut count) = (0.0_f64, 0.0, 0.0);
        for [camber, forward] in heights {
            for x in [0.3, 0.4, 0.5, 0.6, 0.7] {
                camber_max = camber_max.max(membrane_height(camber, forward, x).abs());
            }
            let stretch = membrane.membrane_stretch(camber, forward).unwrap_or_default();
            slack += if stretch < 0.0 { 1.0 } else { 0.0 };
            count += 1.0;
        }
        let frequency_fraction = frequency_hz / membrane.membrane_frequency_hz()?;
        Some(Self { camber_max, slack_fraction: slack / f64::max(count, 1.0), frequency_fraction })
    }

    /// The worse of two.
    pub fn worse(self, other: Self) -> Self {
        Self {
            camber_max: self.camber_max.max(other.camber_max),
            slack_fraction: self.slack_fraction.max(other.slack_fraction),
            frequency_fraction: self.frequency_fraction.max(other.frequency_fraction),
        }
    }
}
