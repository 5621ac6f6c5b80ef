//! How the joints are driven over the flapping cycle.

use super::bound::BoundSpec;
use crate::body::{FourierSeries, LinkageDimensions};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::require::not_negative;

/// What turns the driven joints.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GaitSpec {
    /// Joint coordinates as Fourier series of the phase.
    Fourier {
        /// Flapping frequency, Hz; 0 holds the wings still.
        frequency_hz: f64,
        /// Flapping and a glide on folded wings in turn; `frequency_hz` is then that of both together.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bound: Option<BoundSpec>,
        /// Shoulder of `wing`, positive raises it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        shoulder: Option<FourierSeries>,
        /// Elbow of `wing`, positive raises the outer wing.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        elbow: Option<FourierSeries>,
    },
    /// Joint angles from the closed linkage of the computational structure.
    Linkage {
        /// Crank frequency, Hz; 0 holds the wings still.
        frequency_hz: f64,
        /// Dimensions of the linkage.
        #[serde(default)]
        dimensions: Box<LinkageDimensions>,
    },
}

impl Default for GaitSpec {
    /// Nothing flaps.
    fn default() -> Self {
        Self::Fourier { frequency_hz: 0.0, bound: None, shoulder: None, elbow: None }
    }
}

impl GaitSpec {
    /// Flapping frequency, Hz.
    pub fn frequency_hz(&self) -> f64 {
        match self {
            Self::Fourier { frequency_hz, .. } | Self::Linkage { frequency_hz, .. } => *frequency_hz,
        }
    }

    /// Strokes and a glide in turn, where they are.
    pub fn bound(&self) -> Option<&BoundSpec> {
        match self {
            Self::Fourier { bound, .. } => bound.as_ref(),
            Self::Linkage { .. } => None,
        }
    }

    /// The key under which a robot file gives it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Fourier { .. } => "fourier",
            Self::Linkage { .. } => "linkage",
        }
    }

    /// Flaps at another frequency, Hz.
    pub fn set_frequency_hz(&mut self, hz: f64) {
        match self {
            Self::Fourier { frequency_hz, .. } | Self::Linkage { frequency_hz, .. } => *frequency_hz = hz,
        }
    }

    /// `winged`: whether there is a `wing` whose shoulder and elbow it drives.
    pub(super) fn check(&self, winged: bool) -> Result<(), Error> {
        not_negative(&format!("{}.frequency_hz", self.kind()), self.frequency_hz())?;
        self.bound().map_or(Ok(()), |bound| bound.check().map_err(|e| e.within("fourier.bound")))?;
        let Self::Fourier { shoulder, elbow, .. } = self else { return Ok(()) };
        for (key, series) in [("fourier.shoulder", shoulder), ("fourier.elbow", elbow)] {
            match (winged, series) {
                (true, None) => {
                    return Err(Error::invalid(key, "missing", "a Fourier series: the robot has a [wing]"));
                }
                (false, Some(_)) => {
                    let allowed = "nothing: without a [wing] each link brings its series in `driven`";
                    return Err(Error::invalid(key, "given", allowed));
                }
                (_, Some(series)) => series.check().map_err(|e| e.within(key))?,
                (false, None) => {}
            }
        }
        Ok(())
    }
}
