//! Instruments of a robot: what they read at their own times, with noise, a constant offset and a delay.

use super::sensors::SensorSpec;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{GRAVITY, Mat3, Quat, Random, Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, Fault, Plant, Role};
use wingbeat_robot::Wind;

/// Places of instruments from the body's origin, m.
const PLACE: Range = Range::between(-10.0, 10.0);
/// Time from a reading to its arrival, s.
const DELAY: Range = Range::between(0.0, 1.0);

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

ranges!(InertialSpec {
    place_m: PLACE,
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    rate_rad_s: Range::NOT_NEGATIVE,
    rate_bias_rad_s: Range::NOT_NEGATIVE,
    force_m_s2: Range::NOT_NEGATIVE,
    force_bias_m_s2: Range::NOT_NEGATIVE,
});
ranges!(HeightSpec {
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    height_m: Range::NOT_NEGATIVE,
    bias_m: Range::NOT_NEGATIVE,
});
ranges!(AirspeedSpec {
    place_m: PLACE,
    every_s: Range::POSITIVE,
    delay_s: DELAY,
    speed_m_s: Range::NOT_NEGATIVE,
    bias_m_s: Range::NOT_NEGATIVE,
});

impl InertialSpec {
    /// One of small parts, without offsets. *Choice.*
    fn ordinary() -> Self {
        Self {
            place_m: [0.0; 3],
            every_s: 2.5e-3,
            delay_s: 0.0,
            rate_rad_s: 0.02,
            rate_bias_rad_s: 0.0,
            force_m_s2: 0.3,
            force_bias_m_s2: 0.0,
        }
    }
}

impl HeightSpec {
    /// A rangefinder of small parts, without an offset. *Choice.*
    fn ordinary() -> Self {
        Self { every_s: 20e-3, delay_s: 0.0, height_m: 0.01, bias_m: 0.0 }
    }
}

impl AirspeedSpec {
    /// A small pitot tube, without an offset. *Choice.*
    fn ordinary() -> Self {
        Self { place_m: [0.0; 3], every_s: 20e-3, delay_s: 0.0, speed_m_s: 0.1, bias_m_s: 0.0 }
    }
}

/// What an instrument reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angular rate about an axis of B, rad/s.
    Rate(usize),
    /// Specific force along an axis of B, m/s2.
    Force(usize),
    /// Height above W's origin, m.
    Height,
    /// Airspeed along body x, m/s.
    Airspeed,
}

/// An instrument of one number, as its data sheet has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// What it reads.
    pub quantity: Quantity,
    /// Where, from the body's origin in B, m.
    pub place: Vec3,
    /// Time between readings, s.
    pub every: f64,
    /// Time from a reading to its arrival, s.
    pub delay: f64,
    /// Standard deviation of its noise.
    pub noise: f64,
    /// Standard deviation of its constant offset.
    pub bias: f64,
}

/// One number that an instrument read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Number of the instrument.
    pub instrument: usize,
    /// When it was read, s.
    pub taken: f64,
    /// What was read.
    pub value: f64,
}

/// What instruments feel of a body.
#[derive(Clone, Copy, Debug)]
pub struct Motion<S: Scalar = f64> {
    /// Height of its origin, m.
    pub height: S,
    /// R_WB.
    pub attitude: Mat3<S>,
    /// Velocity of its origin against the air, in W, m/s.
    pub airspeed: Vec3<S>,
    /// Angular rate in B, rad/s.
    pub rate: Vec3<S>,
    /// Acceleration of its origin in W, m/s2.
    pub acceleration: Vec3<S>,
    /// Angular acceleration in B, rad/s2.
    pub angular_acceleration: Vec3<S>,
}

/// Where height, attitude, velocity and angular rate stand in the state of a plant.
#[derive(Clone, Copy, Debug)]
pub struct Places {
    /// Position along z.
    pub height: usize,
    /// First of the quaternion.
    pub attitude: usize,
    /// First of the velocity.
    pub velocity: usize,
    /// First of the angular rate.
    pub rate: usize,
}

impl Places {
    /// Those among `channels`; none of a plant that has no such body.
    pub fn of(channels: &[Channel]) -> Option<Self> {
        let place = |role: Role| role.place(channels);
        Some(Self {
            height: place(Role::Position(2))?,
            attitude: place(Role::Attitude(0))?,
            velocity: place(Role::Velocity(0))?,
            rate: place(Role::AngularRate(0))?,
        })
    }

    /// What is felt in the state `x` with the rates `dx` in air that moves with `wind` in W.
    pub fn motion<S: Scalar>(&self, x: &[S], dx: &[S], wind: Vec3) -> Motion<S> {
        Motion {
            height: x[self.height],
            attitude: Quat::from_wxyz(&x[self.attitude..]).matrix(),
            airspeed: Vec3::from_slice(&x[self.velocity..]) - Vec3::constant(wind),
            rate: Vec3::from_slice(&x[self.rate..]),
            acceleration: Vec3::from_slice(&dx[self.velocity..]),
            angular_acceleration: Vec3::from_slice(&dx[self.rate..]),
        }
    }
}

impl<S: Scalar> Motion<S> {
    /// Specific force at `place`: what an accelerometer feels there, gravity not being felt.
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

    /// Velocity of `place` against the air, along body x.
    ///
    /// Equation: simulate.airspeed
    /// `e_x . (R'(v - wind) + w x r)`
    /// Source: definition.
    /// Test: `an_accelerometer_on_the_axis_of_a_turn_feels_gravity_alone`.
    pub fn forward_airspeed(&self, place: Vec3) -> S {
        (self.attitude.transpose_mul(self.airspeed) + self.rate.cross(Vec3::constant(place)))[0]
    }
}

impl Instrument {
    /// What it would read without noise and offset.
    pub fn reads<S: Scalar>(&self, motion: &Motion<S>) -> S {
        match self.quantity {
            Quantity::Rate(axis) => motion.rate[axis],
            Quantity::Force(axis) => motion.specific_force(self.place)[axis],
            Quantity::Height => motion.height,
            Quantity::Airspeed => motion.forward_airspeed(self.place),
        }
    }
}

impl SensorSpec {
    /// The instruments there are: rates, forces, height, airspeed.
    pub fn instruments(&self) -> Vec<Instrument> {
        let mut all = Vec::new();
        if let Some(imu) = &self.imu {
            let (place, every, delay) = (Vec3(imu.place_m), imu.every_s, imu.delay_s);
            let axes = |quantity: fn(usize) -> Quantity, noise: f64, bias: f64| {
                (0..3).map(move |i| Instrument { quantity: quantity(i), place, every, delay, noise, bias })
            };
            all.extend(axes(Quantity::Rate, imu.rate_rad_s, imu.rate_bias_rad_s));
            all.extend(axes(Quantity::Force, imu.force_m_s2, imu.force_bias_m_s2));
        }
        all.extend(self.height.as_ref().map(|height| Instrument {
            quantity: Quantity::Height,
            place: Vec3::ZERO,
            every: height.every_s,
            delay: height.delay_s,
            noise: height.height_m,
            bias: height.bias_m,
        }));
        all.extend(self.airspeed.as_ref().map(|airspeed| Instrument {
            quantity: Quantity::Airspeed,
            place: Vec3(airspeed.place_m),
            every: airspeed.every_s,
            delay: airspeed.delay_s,
            noise: airspeed.speed_m_s,
            bias: airspeed.bias_m_s,
        }));
        all
    }

    /// One ordinary sensor of each kind, by the name of its table: what a robot could have.
    pub(crate) fn examples() -> [(&'static str, Vec<Instrument>); 3] {
        let imu = Self { imu: Some(InertialSpec::ordinary()), ..Self::default() };
        let height = Self { height: Some(HeightSpec::ordinary()), ..Self::default() };
        let airspeed = Self { airspeed: Some(AirspeedSpec::ordinary()), ..Self::default() };
        [("imu", imu.instruments()), ("height", height.instruments()), ("airspeed", airspeed.instruments())]
    }

    /// Refuses instruments out of range.
    pub(super) fn check_instruments(&self) -> Result<(), Error> {
        self.imu.as_ref().map_or(Ok(()), |imu| imu.in_range().map_err(|e| e.within("imu")))?;
        self.height.as_ref().map_or(Ok(()), |height| height.in_range().map_err(|e| e.within("height")))?;
        self.airspeed.as_ref().map_or(Ok(()), |speed| speed.in_range().map_err(|e| e.within("airspeed")))
    }
}

/// Instruments on a flight, and what they have read and not yet told.
#[derive(Debug)]
pub(super) struct Fitted {
    instruments: Vec<Instrument>,
    /// Steps of the flight between readings.
    every: Vec<usize>,
    biases: Vec<f64>,
    noise: Vec<Random>,
    places: Places,
    wind: Wind,
    waiting: Vec<Reading>,
    dx: Vec<f64>,
}

impl Fitted {
    /// `instruments` of a plant whose states are `channels`, in `wind`, on a flight in steps of `step` s; noise and offsets
    /// follow `seed`. None of a plant without a body.
    pub fn new(
        instruments: Vec<Instrument>,
        channels: &[Channel],
        wind: Wind,
        step: f64,
        seed: u64,
    ) -> Option<Self> {
        let mut noise: Vec<Random> =
            (0..instruments.len()).map(|i| Random::stream(seed, 1 + i as u64)).collect();
        Some(Self {
            every: instruments.iter().map(|i| (i.every / step).round().max(1.0) as usize).collect(),
            biases: instruments.iter().zip(&mut noise).map(|(i, noise)| i.bias * noise.normal()).collect(),
            noise,
            places: Places::of(channels)?,
            wind,
            waiting: Vec::new(),
            dx: vec![0.0; channels.len()],
            instruments,
        })
    }

    /// Lets the instruments read that are due at step `k` of the flight.
    pub fn watch<P: Plant>(
        &mut self,
        k: usize,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        if !self.every.iter().any(|every| k.is_multiple_of(*every)) {
            return Ok(());
        }
        plant.rates_in_numbers(t, x, u, &mut self.dx)?;
        let motion = self.places.motion(x, &self.dx, self.wind.at(t).0);
        for (i, instrument) in self.instruments.iter().enumerate() {
            if k.is_multiple_of(self.every[i]) {
                let error = self.biases[i] + instrument.noise * self.noise[i].normal();
                let value = instrument.reads(&motion) + error;
                self.waiting.push(Reading { instrument: i, taken: t, value });
            }
        }
        Ok(())
    }

    /// Moves what has arrived by the time `t` to `told`, in the order in which it was read.
    pub fn tell(&mut self, t: f64, told: &mut Vec<Reading>) {
        told.clear();
        let arrived =
            |reading: &Reading| reading.taken + self.instruments[reading.instrument].delay <= t + ROUNDING;
        told.extend(self.waiting.iter().copied().filter(arrived));
        let instruments = &self.instruments;
        self.waiting.retain(|r| r.taken + instruments[r.instrument].delay > t + ROUNDING);
    }
}

/// Rounding of times, s.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that turns at a constant rate about an axis away from its origin, at rest elsewhere.
    fn turning(rate: Vec3, center: Vec3) -> Motion {
        let attitude = Mat3::from_roll_pitch_yaw(0.3, -0.2, 0.9);
        let arm = center * -1.0;
        Motion {
            height: 1.2,
            attitude,
            airspeed: attitude * rate.cross(arm),
            rate,
            acceleration: attitude * rate.cross(rate.cross(arm)),
            angular_acceleration: Vec3::ZERO,
        }
    }

    #[test]
    fn an_accelerometer_on_the_axis_of_a_turn_feels_gravity_alone() {
        let (rate, center) = (Vec3::new(3.0, -7.0, 2.0), Vec3::new(0.04, 0.01, -0.02));
        let motion = turning(rate, center);
        let felt = motion.specific_force(center);
        let up = motion.attitude.transpose_mul(Vec3::new(0.0, 0.0, GRAVITY));
        assert!((felt - up).norm() < 1e-12 && motion.forward_airspeed(center).abs() < 1e-14);
        let beside = motion.specific_force(center + Vec3::new(0.1, 0.0, 0.0)) - up;
        assert!((beside - rate.cross(rate.cross(Vec3::new(0.1, 0.0, 0.0)))).norm() < 1e-12);
    }

    #[test]
    fn a_body_that_falls_feels_nothing() {
        let still = turning(Vec3::ZERO, Vec3::ZERO);
        let falling = Motion { acceleration: Vec3::new(0.0, 0.0, -GRAVITY), ..still };
        assert_eq!(falling.specific_force(Vec3::new(0.1, 0.2, 0.3)), Vec3::ZERO);
    }
}
