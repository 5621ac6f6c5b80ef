//! Gyroscope and accelerometer.

use super::{DELAY, FeltMotion, Instrument, PLACE, Quantity, Sensor, quantity};
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{GRAVITY, Scalar, Vec3};

/// Gyroscope and accelerometer about the body axes, at one place.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct InertialSpec {
    /// Place from the body's origin, in B, m.
    #[serde(default)]
    pub place_m: [f64; 3],
    /// Time between readings, s.
    pub every_s: f64,
    /// Time from a reading to its arrival, s.
    #[serde(default)]
    pub delay_s: f64,
    /// Standard deviation of the noise of the angular rate, rad/s.
    #[serde(default)]
    pub rate_rad_s: f64,
    /// Standard deviation of its constant offset, drawn once a flight for each axis, rad/s.
    #[serde(default)]
    pub rate_bias_rad_s: f64,
    /// Standard deviation of the noise of the specific force, m/s2.
    #[serde(default)]
    pub force_m_s2: f64,
    /// Standard deviation of its constant offset, m/s2.
    #[serde(default)]
    pub force_bias_m_s2: f64,
}

ranges!(InertialSpec {
    place_m: PLACE,
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    rate_rad_s: Range::NOT_NEGATIVE,
    rate_bias_rad_s: Range::NOT_NEGATIVE,
    force_m_s2: Range::NOT_NEGATIVE,
    force_bias_m_s2: Range::NOT_NEGATIVE,
});
const RATE: [Quantity; 3] = [
    quantity!("rate_x", "rate", "rad/s", "B", |motion, _imu| motion.rate[0]),
    quantity!("rate_y", "rate", "rad/s", "B", |motion, _imu| motion.rate[1]),
    quantity!("rate_z", "rate", "rad/s", "B", |motion, _imu| motion.rate[2]),
];
const FORCE: [Quantity; 3] = [
    quantity!("force_x", "force", "m/s2", "B", |motion, imu| motion.specific_force(imu.place)[0]),
    quantity!("force_y", "force", "m/s2", "B", |motion, imu| motion.specific_force(imu.place)[1]),
    quantity!("force_z", "force", "m/s2", "B", |motion, imu| motion.specific_force(imu.place)[2]),
];

impl Sensor for InertialSpec {
    const ORDINARY: Self = Self {
        place_m: [0.0; 3],
        every_s: 2.5e-3,
        delay_s: 0.0,
        rate_rad_s: 0.02,
        rate_bias_rad_s: 0.0,
        force_m_s2: 0.3,
        force_bias_m_s2: 0.0,
    };

    fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    fn instruments(&self) -> Vec<Instrument> {
        let axes = |quantities: [Quantity; 3], errors: [f64; 2]| {
            quantities.map(|quantity| Instrument {
                place: Vec3(self.place_m),
                ..Instrument::every(quantity, self.every_s, self.delay_s, errors)
            })
        };
        let rates = axes(RATE, [self.rate_rad_s, self.rate_bias_rad_s]);
        let forces = axes(FORCE, [self.force_m_s2, self.force_bias_m_s2]);
        rates.into_iter().chain(forces).collect()
    }
}

impl<S: Scalar> FeltMotion<S> {
    /// Specific force, m/s2 in B, at `place` (m, B): what an accelerometer feels there, gravity not being felt.
    ///
    /// Equation: simulate.specific_force
    /// `f = R'(a - g) + w' x r + w x (w x r) at the place r of the body`
    /// Source: rigid-body kinematics; Titterton & Weston 2004, ch. 3.
    /// Test: `an_accelerometer_on_the_axis_of_a_turn_feels_gravity_alone`.
    pub fn specific_force(&self, place: Vec3) -> Vec3<S> {
        let place = Vec3::constant(place);
        let up = Vec3::new(S::ZERO, S::ZERO, S::from(GRAVITY));
        self.attitude.transpose_mul(self.acceleration + up)
            + self.angular_acceleration.cross(place)
            + self.rate.cross(self.rate.cross(place))
    }
}
