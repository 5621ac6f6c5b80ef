//! Instruments of a robot, a file each: what its table says, and what it reads of the motion of the body.

mod airspeed;
mod fitted;
mod height;
mod imu;
mod kinds;
mod told;

pub use told::{Measurement, Sensors};

use wingbeat_math::range::Range;
use wingbeat_math::{Dual, Error, Mat3, Quat, Scalar, Vec3};
use wingbeat_ocp::plant::{Channel, Role};

// An instrument is a file of its own, its name among those above, and its table here.
kinds::instruments! {
    /// Gyroscope and accelerometer.
    imu: imu::InertialSpec,
    /// Height.
    height: height::HeightSpec,
    /// Airspeed.
    airspeed: airspeed::AirspeedSpec,
}

/// Places of instruments from the body's origin, m.
const PLACE: Range = Range::between(-10.0, 10.0);
/// Time from a reading to its arrival, s.
const DELAY: Range = Range::between(0.0, 1.0);

/// What a table of `[sensors]` says of an instrument.
pub trait Sensor: Sized {
    /// One of small parts, without offsets: what a robot could have. A choice.
    const ORDINARY: Self;

    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    fn check(&self) -> Result<(), Error>;

    /// The instruments of one number that it is made of.
    fn instruments(&self) -> Vec<Instrument>;
}

/// A number with its derivatives by the errors of the body and by what a model misses, as an estimator reads it.
pub type Erring = Dual<16>;

/// What an instrument reads: made by `quantity!`.
#[derive(Clone, Copy, Debug)]
pub struct Quantity {
    /// Name, which ends the columns of its estimate.
    pub name: &'static str,
    /// What is told together: the axes of one part.
    pub kind: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Frame.
    pub frame: &'static str,
    /// The reading of a motion by an instrument, in `unit`.
    pub plain: fn(&FeltMotion, &Instrument) -> f64,
    /// The same with derivatives.
    pub erring: fn(&FeltMotion<Erring>, &Instrument) -> Erring,
}

/// A [`Quantity`] of name, kind, unit and frame that is the expression of a motion and of the instrument that reads it.
macro_rules! quantity {
    ($name:literal, $kind:literal, $unit:literal, $frame:literal, |$motion:ident, $instrument:ident| $read:expr) => {{
        fn read<S: wingbeat_math::Scalar>(
            $motion: &super::FeltMotion<S>,
            $instrument: &super::Instrument,
        ) -> S {
            $read
        }
        let (name, kind, unit, frame) = ($name, $kind, $unit, $frame);
        super::Quantity { name, kind, unit, frame, plain: read::<f64>, erring: read::<super::Erring> }
    }};
}
use quantity;

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// An instrument of one number, as its data sheet has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instrument {
    /// What it reads.
    pub quantity: Quantity,
    /// Where, from the body's origin in B, m.
    pub place: Vec3,
    /// A number of its own that the reading takes, in its own unit; 0 of an instrument that has none.
    pub setting: f64,
    /// Time between readings, s.
    pub every: f64,
    /// Time from a reading to its arrival, s.
    pub delay: f64,
    /// Standard deviation of its noise, in the unit of its quantity.
    pub noise: f64,
    /// Standard deviation of its constant offset, in the unit of its quantity.
    pub bias: f64,
}

/// One number that an instrument read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Number of the instrument.
    pub instrument: usize,
    /// When it was read, s.
    pub taken: f64,
    /// What was read, in the unit of the quantity.
    pub value: f64,
}

/// What instruments feel of a body.
#[derive(Clone, Copy, Debug)]
pub struct FeltMotion<S: Scalar = f64> {
    /// Height of its origin, m.
    pub height: S,
    /// R_WB.
    pub attitude: Mat3<S>,
    /// Velocity of its origin in W, m/s.
    pub velocity: Vec3<S>,
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

    /// What is felt in the state `x` with the rates `dx` in air that moves with `wind` (m/s) in W.
    pub fn motion<S: Scalar>(&self, x: &[S], dx: &[S], wind: Vec3) -> FeltMotion<S> {
        FeltMotion {
            height: x[self.height],
            attitude: Quat::from_wxyz(&x[self.attitude..]).matrix(),
            velocity: Vec3::from_slice(&x[self.velocity..]),
            airspeed: Vec3::from_slice(&x[self.velocity..]) - Vec3::constant(wind),
            rate: Vec3::from_slice(&x[self.rate..]),
            acceleration: Vec3::from_slice(&dx[self.velocity..]),
            angular_acceleration: Vec3::from_slice(&dx[self.rate..]),
        }
    }
}

impl Instrument {
    /// One at the body's origin that reads every so many s.
    fn every(quantity: Quantity, every: f64, delay: f64, [noise, bias]: [f64; 2]) -> Self {
        Self { quantity, place: Vec3::ZERO, setting: 0.0, every, delay, noise, bias }
    }

    /// What it would read without noise and offset, in the unit of its quantity.
    pub fn reads(&self, motion: &FeltMotion) -> f64 {
        (self.quantity.plain)(motion, self)
    }

    /// The same with derivatives by the errors of what is believed.
    pub fn reads_erring(&self, motion: &FeltMotion<Erring>) -> Erring {
        (self.quantity.erring)(motion, self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::GRAVITY;

    /// A body that turns at a constant rate about an axis away from its origin, at rest elsewhere.
    fn turning(rate: Vec3, center: Vec3) -> FeltMotion {
        let attitude = Mat3::from_roll_pitch_yaw(0.3, -0.2, 0.9);
        let arm = center * -1.0;
        FeltMotion {
            height: 1.2,
            attitude,
            velocity: attitude * rate.cross(arm),
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
        let falling = FeltMotion { acceleration: Vec3::new(0.0, 0.0, -GRAVITY), ..still };
        assert_eq!(falling.specific_force(Vec3::new(0.1, 0.2, 0.3)), Vec3::ZERO);
    }
}
