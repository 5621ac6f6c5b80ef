//! What turns the crank of the gait where it does not turn at a constant rate: motors, a file each.

mod kinds;
mod motor;

use wingbeat_math::{Error, Meets, Parameters, Scalar, Walk};

// A motor is a file of its own, its name among those above, and its table here.
kinds::motors! {
    /// A motor that turns the cranks of all driven joints: angle and rate of the crank, which is the
    /// gait's phase, are states and start at the start's phase and the gait's frequency.
    motor: motor::MotorSpec => Motor,
}

/// A motor with its gearbox, its numbers of type `P`.
pub trait Turns<P: Scalar> {
    /// Torque on the crank, N m, at its rate, rad/s, under the share `supply` of the supply.
    fn crank_torque<S: Scalar + Meets<P>>(&self, crank_rate: S, supply: S) -> S;

    /// Inertia of all that turns with the crank, about its axis, kg m2.
    fn inertia(&self) -> P;
}

/// What a table of `[drive]` says of a motor.
pub trait Drive {
    /// What it makes.
    type Built;

    /// # Errors
    /// [`Error::Invalid`] with the key.
    fn build(&self) -> Result<Self::Built, Error>;

    /// What its shaft does at the crank's rate, rad/s, under the share `supply` of the supply.
    fn shaft(motor: &Self::Built, crank_rate: f64, supply: f64) -> Shaft;
}

/// What the shaft of a motor does, before its gearbox.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// N m.
    pub torque: f64,
    /// Mechanical power, W.
    pub power: f64,
    /// Electrical power, W; negative where the motor feeds its supply.
    pub electrical_power: f64,
}

/// What a motor does at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorWork {
    /// Angle of the crank, rad.
    pub crank_angle: f64,
    /// Rate of the crank, rad/s.
    pub crank_rate: f64,
    /// Torque on the crank behind the gearbox, N m; part of it accelerates rotor and crank.
    pub crank_torque: f64,
    /// Torque of the motor's shaft, N m.
    pub shaft_torque: f64,
    /// Mechanical power of the shaft, W.
    pub shaft_power: f64,
    /// Electrical power V I, W; negative where the motor feeds its supply.
    pub electrical_power: f64,
    /// Kinetic energy of rotor and crank, J.
    pub energy: f64,
}
