//! Height: barometer or rangefinder.

use super::{DELAY, Instrument, Quantity, Sensor, quantity};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// Height of the body's origin above that of the begin: barometer or rangefinder.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct HeightSpec {
    /// Time between readings, s.
    pub every_s: f64,
    /// Time from a reading to its arrival, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Standard deviation of the noise, m.
    #[serde(default)]
    pub height_m: f64,
    /// Standard deviation of the constant offset, m.
    #[serde(default)]
    pub bias_m: f64,
}

ranges!(HeightSpec {
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    height_m: Range::NOT_NEGATIVE,
    bias_m: Range::NOT_NEGATIVE,
});
const HEIGHT: Quantity = quantity!("height", "height", "m", "W", |motion, _height| motion.height);

impl Sensor for HeightSpec {
    const ORDINARY: Self = Self { every_s: 20e-3, delay_s: 0.0, height_m: 0.01, bias_m: 0.0 };

    fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    fn instruments(&self) -> Vec<Instrument> {
        vec![Instrument::every(HEIGHT, self.every_s, self.delay_s, [self.height_m, self.bias_m])]
    }
}
