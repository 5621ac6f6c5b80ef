//! Continuous turbulence of a scenario's air.

use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_robot::Dryden;

/// Most nodes of the course of a flight's turbulence.
const MAX_NODES: f64 = 1e6;

/// Turbulence with Dryden's spectra (MIL-F-8785C), frozen as the robot flies through it and the same everywhere on the robot; the
/// controller does not know of it. Either `altitude_m` and `wind_6m_m_s`, or `deviation_m_s` and `length_m`. Its axes stay those of
/// the start: along the heading, to its left, up.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct DrydenSpec {
    /// Airspeed at which the turbulence passes, m/s.
    pub airspeed_m_s: f64,
    /// Altitude of the low-altitude model, m: 10 to 1000 ft.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude_m: Option<f64>,
    /// Mean wind 6 m above the ground of that model, m/s: 7.7 is its light, 15 its moderate, 23 its severe turbulence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind_6m_m_s: Option<f64>,
    /// Standard deviations along each axis, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation_m_s: Option<[f64; 3]>,
    /// Scales of each axis, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<[f64; 3]>,
}

ranges!(DrydenSpec {
    airspeed_m_s: Range::between(0.1, 100.0),
    altitude_m: Range::between(3.048, 304.8),
    wind_6m_m_s: Range::between(0.0, 100.0),
    deviation_m_s: Range::between(0.0, 100.0),
    length_m: Range::between(1e-3, 1e4),
});

impl DrydenSpec {
    /// The turbulence of a flight of `duration` s.
    ///
    /// # Errors
    /// A number out of range; not one of the two ways to give it; scales too short for a flight as long.
    pub(super) fn turbulence(&self, duration: f64) -> Result<Dryden, Error> {
        self.in_range()?;
        let airspeed = self.airspeed_m_s;
        let made = match (self.altitude_m, self.wind_6m_m_s, self.deviation_m_s, self.length_m) {
            (Some(altitude), Some(wind), None, None) => Dryden::low(altitude, wind, airspeed),
            (None, None, Some(deviation), Some(length)) => Dryden { deviation, length, airspeed },
            _ => {
                let allowed = "altitude_m and wind_6m_m_s, or deviation_m_s and length_m";
                return Err(Error::invalid("", "another choice of keys", allowed));
            }
        };
        if duration / made.step() > MAX_NODES {
            let allowed = format!(
                "scales and a flight of at most {MAX_NODES:e} nodes; one lasts {:.2e} s",
                made.step()
            );
            return Err(Error::invalid("length_m", format!("{:?}", made.length), allowed));
        }
        Ok(made)
    }
}
