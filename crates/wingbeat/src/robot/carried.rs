//! The robot with its body carried along a given motion: on a test rig, in a tunnel, on a stand.

use super::observe::accelerated;
use super::sections::Riding;
use super::{JOINTS, Robot};
use crate::aero::{LoadSource, Loads, MAX_STRIPS, SectionMotion, Sections, StripLoads};
use crate::body::{BaseAcceleration, LinkMotion, Momentum, joint_power};
use crate::math::{Jet, Mat3, Scalar, Vec3, Wrench};
use crate::plant::Fault;

/// Motion that something outside imposes on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMotion<S: Scalar = f64> {
    /// R_WB.
    pub attitude: Mat3<S>,
    /// v_WB_W, m/s.
    pub velocity: Vec3<S>,
    /// w_WB_B, rad/s.
    pub rate: Vec3<S>,
    /// Acceleration of the body origin in W, m/s2.
    pub acceleration: Vec3<S>,
    /// Derivative of `rate` in B, rad/s2.
    pub angular_acceleration: Vec3<S>,
}

impl<S: Scalar> BodyMotion<S> {
    /// At constant velocity (m/s in W) without turning.
    pub fn steady(attitude: Mat3<S>, velocity: Vec3<S>) -> Self {
        let zero = Vec3::ZERO;
        Self { attitude, velocity, rate: zero, acceleration: zero, angular_acceleration: zero }
    }
}

/// Loads on what carries the robot, by source, in B about the body origin; and
/// what the joints do.
#[derive(Clone, Copy, Debug, Default)]
pub struct CarriedLoads<S: Scalar = f64> {
    /// Aerodynamic loads of the wing by source.
    pub air: StripLoads<S>,
    /// Drag of the body.
    pub body_drag: Wrench<S>,
    /// Weight.
    pub gravity: Wrench<S>,
    /// Minus the rate of momentum of body and links.
    pub inertia: Wrench<S>,
    /// Joint angles with rates and accelerations, rad; order of [`JOINTS`].
    pub joints: [Jet<S>; JOINTS.len()],
    /// Joint torques, N m.
    pub torques: [S; JOINTS.len()],
    /// Power that wing and body take from the air, W.
    pub air_power: S,
    /// Centre of mass from the body origin, in B, m.
    pub center_of_mass: Vec3<S>,
}

impl<S: Scalar> CarriedLoads<S> {
    /// The wrench that the robot exerts on its carrier.
    pub fn total(&self) -> Wrench<S> {
        self.air.total() + self.body_drag + self.gravity + self.inertia
    }
    /// The loads in the order of [`LoadSource::ALL`].
    pub fn parts(&self) -> [Wrench<S>; LoadSource::ALL.len()] {
        self.air.parts_with([self.body_drag, self.gravity, self.inertia])
    }
    /// Mechanical power of the joints, W.
    pub fn joint_power(&self) -> S {
        joint_power(&self.torques, &self.joints)
    }
    /// Moment of the air about the centre of mass, in B, N m.
    pub fn trim_moment(&self) -> Vec3<S> {
        let air = self.air.total() + self.body_drag;
        air.moment - self.center_of_mass.cross(air.force)
    }
}

impl Robot {
    /// Number of states of a carried robot: structure, then aerodynamics.
    pub fn carried_states(&self) -> usize {
        self.layout.len - self.layout.structure
    }

    /// Loads with the body moving as `body`, structure and aerodynamics in the
    /// state `x` and the inputs `u`; `dx` receives the rates of `x`. `clock` is the
    /// gait's time with its rate, 1 while flapping at the full frequency, and the rate's slope.
    ///
    /// Newton-Euler: carrier + air + drag + gravity = rate of momentum, so the
    /// carrier bears air + drag + gravity + inertia.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// Equation: robot.carried_wrench
    pub fn carried<S: Scalar>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<CarriedLoads<S>, Fault> {
        let structure = self.layout.aero - self.layout.structure;
        let joints = self.joints_on(clock, &x[..structure], u, &mut dx[..structure])?;
        let v = body.attitude.transpose_mul(body.velocity);
        let mut links = [LinkMotion::default(); JOINTS.len()];
        self.tree.motions(&joints, v, body.rate, &mut links);
        let imposed = BaseAcceleration {
            origin: body.attitude.transpose_mul(body.acceleration),
            angular: body.angular_acceleration,
        };
        let base = accelerated(&LinkMotion::base(v, body.rate), imposed);
        let moving = links.map(|link| accelerated(&link, imposed));
        let (wind, wind_dot) = self.wind(clock.x, body.attitude);
        let riding = Riding::new(&self.sections, &base, &moving, wind_dot);
        let mut sections = [SectionMotion::default(); MAX_STRIPS + 1];
        let count = self.sections.len();
        for (i, section) in sections.iter_mut().enumerate().take(count) {
            *section = riding.section(i);
        }
        let mut loads = Loads::default();
        let (x, dx) = (&x[structure..], &mut dx[structure..]);
        self.aero.evaluate(&sections[..count], wind, x, dx, &mut loads);
        let body_drag = self.body_drag(v - wind);
        let gravity = self.gravity(body.attitude);
        Ok(CarriedLoads {
            air: loads.by_source(),
            body_drag,
            gravity: self.tree.gravity(gravity, &links),
            inertia: self.momentum_reaction(body.rate, &links, imposed),
            torques: self.joint_torques(&links, imposed, &loads, gravity),
            air_power: self.air_power(&base, &links, &loads) + body_drag.force.dot(v),
            center_of_mass: self.tree.center_of_mass(&links),
            joints,
        })
    }

    /// Power of the strips' loads on the links they ride on, W: sum of F . v + T . w with F, T, v
    /// at the body origin. With it the joints' power is the rate of the energy of body and links.
    ///
    /// Equation: robot.air_power
    fn air_power<S: Scalar>(&self, base: &LinkMotion<S>, links: &[LinkMotion<S>], loads: &Loads<S>) -> S {
        self.strip_links.iter().zip(&loads.strip).fold(S::ZERO, |sum, (link, strip)| {
            let (link, load) = (link.map_or(base, |i| &links[i]), strip.total());
            sum + load.force.dot(link.velocity_at(Vec3::ZERO)) + load.moment.dot(link.rate)
        })
    }

    /// Minus the rate of momentum of body and links about the body origin, in B.
    pub(super) fn momentum_reaction<S: Scalar>(
        &self,
        w: Vec3<S>,
        links: &[LinkMotion<S>],
        base: BaseAcceleration<S>,
    ) -> Wrench<S> {
        let (mass, bias) = self.tree.inertia_and_bias(w, links);
        let mut acceleration = [S::ZERO; 6];
        base.origin.store(&mut acceleration);
        base.angular.store(&mut acceleration[3..]);
        let row = |i: usize| (0..6).fold(S::ZERO, |sum, j| sum + mass[i][j] * acceleration[j]);
        let force = Vec3::new(row(0), row(1), row(2));
        let moment = Vec3::new(row(3), row(4), row(5));
        -(Wrench { force, moment } + bias)
    }

    /// Kinetic energy plus potential energy above z = 0, J, of body and links with the body
    /// origin at `p_WB` (m).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn carried_energy<S: Scalar>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        position: Vec3<S>,
        x: &[S],
        u: &[S],
    ) -> Result<S, Fault> {
        let structure = self.layout.aero - self.layout.structure;
        let joints = self.joints_on(clock, &x[..structure], u, &mut x[..structure].to_vec())?;
        let v = body.attitude.transpose_mul(body.velocity);
        let mut links = [LinkMotion::default(); JOINTS.len()];
        self.tree.motions(&joints, v, body.rate, &mut links);
        let datum = -body.attitude.transpose_mul(position);
        let potential = self.tree.potential_energy(self.gravity(body.attitude), &links, datum);
        Ok(self.tree.kinetic_energy(v, body.rate, &links) + potential)
    }

    /// Momentum of body and links about the origin of W, resolved in B, with the
    /// body origin at `p_WB` (m) and the structure at rest.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn carried_momentum(
        &self,
        clock: &Jet,
        body: &BodyMotion,
        position: Vec3,
    ) -> Result<Momentum, Fault> {
        let structure = vec![0.0; self.layout.aero - self.layout.structure];
        let u = vec![0.0; self.inputs.len()];
        let joints = self.joints_on(clock, &structure, &u, &mut structure.clone())?;
        let v = body.attitude.transpose_mul(body.velocity);
        let mut links = [LinkMotion::default(); JOINTS.len()];
        self.tree.motions(&joints, v, body.rate, &mut links);
        Ok(self.tree.momentum(v, body.rate, &links, -body.attitude.transpose_mul(position)))
    }
}
