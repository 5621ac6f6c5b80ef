//! Airspeed: pitot tube.

use super::{DELAY, FeltMotion, Instrument, PLACE, Quantity, Sensor, quantity};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Scalar, Vec3};

/// Speed of the air along body x at a place, without what the wings do to it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct AirspeedSpec {
    /// Place from the body's origin, in B, m.
    #[serde(default)]
    pub place_m: [f64; 3],
    /// Time between readings, s.
    pub every_s: f64,
    /// Time from a reading to its arrival, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Standard deviation of the noise, m/s.
    #[serde(default)]
    pub speed_m_s: f64,
    /// Standard deviation of the constant offset, m/s.
    #[serde(default)]
    pub bias_m_s: f64,
}

ranges!(AirspeedSpec {
    place_m: PLACE,
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    speed_m_s: Range::NOT_NEGATIVE,
    bias_m_s: Range::NOT_NEGATIVE,
});

const AIRSPEED: Quantity =
    quantity!("airspeed", "airspeed", "m/s", "B", |motion, tube| motion.forward_airspeed(tube.place));

impl Sensor for AirspeedSpec {
    const ORDINARY: Self =
        Self { place_m: [0.0; 3], every_s: 20e-3, delay_s: 0.0, speed_m_s: 0.1, bias_m_s: 0.0 };

    fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    fn instruments(&self) -> Vec<Instrument> {
        let tube = Instrument::every(AIRSPEED, self.every_s, self.delay_s, [self.speed_m_s, self.bias_m_s]);
        vec![Instrument { place: Vec3(self.place_m), ..tube }]
    }
}

impl<S: Scalar> FeltMotion<S> {
    /// Velocity, m/s, of `place` (m, B) against the air, along body x.
    ///
    /// Equation: simulate.airspeed
    /// `e_x . (R'(v - wind) + w x r)`
    /// Source: definition.
    /// Test: `an_accelerometer_on_the_axis_of_a_turn_feels_gravity_alone`.
    pub fn forward_airspeed(&self, place: Vec3) -> S {
        (self.attitude.transpose_mul(self.airspeed) + self.rate.cross(Vec3::constant(place)))[0]
    }
}
