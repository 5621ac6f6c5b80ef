//! A flapping robot held on a stand in a wind, or carried at constant velocity.

use wingbeat_math::Error;
use wingbeat_math::{Jet, Mat3, Scalar, Vec3};
use wingbeat_ocp::plant::{Fault, MAX_STATES, Plant};
use wingbeat_robot::{BodyMotion, CarriedLoads, MAX_ELEMENTS, Mirror, Robot};

/// Sideways speed against the air that still counts as none, m/s.
const NO_SIDESLIP: f64 = 1e-9;

/// How the wings flap and the body is pitched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flapping<S = f64> {
    /// Frequency of the gait, Hz.
    pub frequency_hz: S,
    /// Pitch, rad; negative is nose up.
    pub pitch: S,
}

/// A robot whose body moves at constant velocity without turning, level in roll,
/// with both wings alike: what a stand in a wind does.
#[derive(Clone, Debug)]
pub struct Stand<'a> {
    robot: &'a Robot,
    mirror: Mirror,
    velocity: Vec3,
    yaw: f64,
}

impl<'a> Stand<'a> {
    /// `robot` carried with `velocity` (m/s in W), heading `yaw` (rad).
    ///
    /// # Errors
    /// [`Error::Invalid`] when the gait stands still, a wing has a regulator that the
    /// other has not, or the air comes from the side.
    pub fn new(robot: &'a Robot, velocity: Vec3, yaw: f64) -> Result<Self, Error> {
        if !(robot.frequency_hz() > 0.0) {
            return Err(Error::invalid("robot.gait", robot.frequency_hz(), "a gait that flaps"));
        }
        if robot.motor().is_some() {
            let allowed = "nothing here: the plan chooses the rate of the crank, which a motor leaves to torque and load; fly what it finds with the motor";
            return Err(Error::invalid("robot.drive.motor", "given", allowed));
        }
        if robot.has_pin_springs() {
            let allowed = "none here: the power of the plan is that of the joints alone";
            return Err(Error::invalid("robot.gait.linkage.springs", "given", allowed));
        }
        if robot.carried_states() > MAX_STATES {
            let allowed = format!("at most {MAX_STATES} states");
            return Err(Error::invalid("aero", robot.carried_states(), allowed));
        }
        let left = Mat3::<f64>::from_roll_pitch_yaw(0.0, 0.0, yaw).column(1);
        let sideslip = left.dot(velocity - robot.mean_wind());
        if !(sideslip.abs() <= NO_SIDESLIP) {
            let allowed = "no speed against the air across the plane of symmetry";
            return Err(Error::invalid("start.velocity_m_s", format!("{sideslip} m/s across"), allowed));
        }
        let mirror = robot.mirror().map_err(|e| e.within("robot"))?;
        Ok(Self { robot, mirror, velocity, yaw })
    }

    /// The robot.
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }
    /// The states and inputs of one wing.
    pub fn mirror(&self) -> &Mirror {
        &self.mirror
    }

    /// Motion of the body at the pitch `pitch`, rad.
    pub fn body<S: Scalar>(&self, pitch: S) -> BodyMotion<S> {
        let attitude = Mat3::from_roll_pitch_yaw(S::ZERO, pitch, S::from(self.yaw));
        BodyMotion::steady(attitude, Vec3::constant(self.velocity))
    }

    /// The gait's clock, in s, at `t` s.
    pub fn clock<S: Scalar>(&self, t: S, flapping: &Flapping<S>) -> Jet<S> {
        let pace = flapping.frequency_hz * (1.0 / self.robot.frequency_hz());
        Jet::new(t * pace, pace, S::ZERO)
    }

    /// Loads at `t` s for the states `x` and inputs `u` of one wing; `dx` receives
    /// the rates of `x`. Allocates nothing.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn evaluate<S: Scalar>(
        &self,
        t: S,
        flapping: &Flapping<S>,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<CarriedLoads<S>, Fault> {
        let (mut states, mut rates) = ([S::ZERO; MAX_STATES], [S::ZERO; MAX_STATES]);
        let mut inputs = [S::ZERO; MAX_ELEMENTS];
        let (n, m) = (self.robot.carried_states(), self.robot.inputs().len());
        self.mirror.expand_states(x, &mut states[..n]);
        self.mirror.expand_inputs(u, &mut inputs[..m]);
        let (clock, body) = (self.clock(t, flapping), self.body(flapping.pitch));
        let loads = self.robot.carried(&clock, &body, &states[..n], &inputs[..m], &mut rates[..n])?;
        for (dx, &i) in dx.iter_mut().zip(&self.mirror.states) {
            *dx = rates[i];
        }
        Ok(loads)
    }

    /// Smooth clearances ([`Robot::smooth_clearances`]) at `t` s for the states `x` of one wing.
    ///
    /// # Errors
    /// The [`Fault`] that makes the gait unusable there.
    pub fn clear<S: Scalar>(
        &self,
        t: S,
        flapping: &Flapping<S>,
        x: &[S],
        values: &mut [S],
    ) -> Result<(), Fault> {
        let mut states = [S::ZERO; MAX_STATES];
        let n = self.robot.carried_states();
        self.mirror.expand_states(x, &mut states[..n]);
        self.robot.smooth_clearances(self.clock(t, flapping).x, &states[..n], values)
    }

    /// Upward and forward force of the air, N, with forward the horizontal heading,
    /// and its nose-up moment about the centre of mass, N m.
    pub fn lift_thrust_trim<S: Scalar>(&self, loads: &CarriedLoads<S>, pitch: S) -> [S; 3] {
        let force = loads.air.total().force + loads.body_drag.force;
        let (sine, cosine) = pitch.sin_cos();
        // R_y(pitch): the body's x axis points down for a positive pitch.
        let up = force[2] * cosine - force[0] * sine;
        let forward = force[0] * cosine + force[2] * sine;
        [up, forward, -loads.trim_moment()[1]]
    }
}
