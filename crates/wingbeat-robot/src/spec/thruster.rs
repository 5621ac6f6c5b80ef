//! Thrusters on the body.

use super::structure::ElementSpec;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;

/// A small propeller on the body. Its thrust is a state, `displacement_NAME` in N, and follows its command as a
/// critically damped element whose mean delay is `lag_s`.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ThrusterSpec {
    /// Name of its channel.
    pub name: String,
    /// Place from the body's origin, in B, m.
    pub place_m: [f64; 3],
    /// Direction of the force on the body, in B, dimensionless; its length does not count.
    pub direction: [f64; 3],
    /// Largest thrust, N; the least is none.
    pub max_n: f64,
    /// Lag of the thrust behind its command, s.
    pub lag_s: f64,
}

ranges!(ThrusterSpec {
    place_m: Range::between(-10.0, 10.0),
    direction: Range::between(-10.0, 10.0),
    max_n: Range::POSITIVE,
    lag_s: Range::between(1e-4, 10.0),
});

impl ThrusterSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::finite("direction", &self.direction)?;
        if !(self.direction.iter().map(|d| d * d).sum::<f64>() > 1e-12) {
            let given = format!("{:?}", self.direction);
            return Err(Error::invalid("direction", given, "a direction: longer than 1e-6"));
        }
        Ok(())
    }

    /// The element that is its thrust: critically damped at 2 / lag, so that a ramp comes `lag_s` late.
    pub(super) fn element(&self, thruster: usize) -> ElementSpec {
        ElementSpec {
            name: self.name.clone(),
            moves: Vec::new(),
            scales: Vec::new(),
            low: Some(0.0),
            high: Some(self.max_n),
            inertia: None,
            frequency_hz: Some(1.0 / (PI * self.lag_s)),
            damping: Some(1.0),
            thruster: Some(thruster),
        }
    }
}
