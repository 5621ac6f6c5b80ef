//! How the joints are driven over the flapping cycle.

use super::super::numbers::{DAMPING, STIFFNESS};
use super::bound::BoundSpec;
use crate::body::{FourierSeries, LinkageDimensions, LinkagePin};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require::{finite, not_negative};

/// What turns the driven joints.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum GaitSpec {
    /// Joint coordinates as Fourier series of the phase.
    Fourier {
        /// Flapping frequency, Hz; 0 holds the wings still.
        #[schemars(extend("minimum" = 0.0))]
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
        #[schemars(extend("minimum" = 0.0))]
        frequency_hz: f64,
        /// Dimensions of the linkage.
        #[serde(default)]
        dimensions: Box<LinkageDimensions>,
        /// Springs on its pins, the same on both sides: the flexures of a compliant mechanism.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        springs: Vec<PinSpringSpec>,
    },
}

/// A spring on a pin of the linkage: effort = -stiffness (angle - rest) - damping angle'.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct PinSpringSpec {
    /// The pin; its angle is that of the second body that it joins against the first.
    pub pin: LinkagePin,
    /// N m/rad.
    pub stiffness: f64,
    /// N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// Angle without effort, rad; the middle of the pin's travel over a turn of the crank where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    /// Deflection from rest that it bears, rad, at most half a turn; a run that goes beyond is `outside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
}

ranges!(PinSpringSpec { stiffness: STIFFNESS.range, damping: DAMPING.range, limit: Range::over(0.0, PI) });

impl PinSpringSpec {
    /// That no pin has two springs.
    fn check(all: &[Self]) -> Result<(), Error> {
        for (i, spring) in all.iter().enumerate() {
            let key = |of: &str| format!("linkage.springs[{i}].{of}");
            spring.in_range().map_err(|e| e.within(&format!("linkage.springs[{i}]")))?;
            if all[..i].iter().any(|before| before.pin == spring.pin) {
                return Err(Error::invalid(key("pin"), spring.pin.name(), "a pin that has no spring yet"));
            }
            spring.rest.map_or(Ok(()), |rest| finite(&key("rest"), &[rest]))?;
        }
        Ok(())
    }
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
        let (shoulder, elbow) = match self {
            Self::Fourier { shoulder, elbow, .. } => (shoulder, elbow),
            Self::Linkage { springs, .. } => return PinSpringSpec::check(springs),
        };
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
