//! The robot with its body carried along a given motion: on a test rig, in a tunnel.

use super::observe::accelerated;
use super::sections::Riding;
use super::{JOINTS, Robot};
use crate::aero::{Loads, MAX_STRIPS, SectionMotion, Sections, StripLoads};
use crate::body::{BaseAcceleration, LinkMotion, Momentum};
use crate::math::{Jet, Mat3, Vec3, Wrench};
use crate::plant::Fault;

/// Motion that something outside imposes on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMotion {
    /// R_WB.
    pub attitude: Mat3,
    /// v_WB_W, m/s.
    pub velocity: Vec3,
    /// w_WB_B, rad/s.
    pub rate: Vec3,
    /// Acceleration of the body origin in W, m/s2.
    pub acceleration: Vec3,
    /// Derivative of `rate` in B, rad/s2.
    pub angular_acceleration: Vec3,
}

/// Loads on what carries the robot, by source, in B about the body origin.
#[derive(Clone, Copy, Debug, Default)]
pub struct CarriedLoads {
    /// Aerodynamic loads of the wing by source.
    pub air: StripLoads<f64>,
    /// Drag of the body.
    pub body_drag: Wrench<f64>,
    /// Weight.
    pub gravity: Wrench<f64>,
    /// Minus the rate of momentum of body and links.
    pub inertia: Wrench<f64>,
}

impl CarriedLoads {
    /// The wrench that the robot exerts on its carrier.
    pub fn total(&self) -> Wrench<f64> {
        self.air.total() + self.body_drag + self.gravity + self.inertia
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
    pub fn carried(
        &self,
        clock: &Jet,
        body: &BodyMotion,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
    ) -> Result<CarriedLoads, Fault> {
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
        Ok(CarriedLoads {
            air: loads.by_source(),
            body_drag: self.body_drag(v - wind),
            gravity: self.tree.gravity(self.gravity(body.attitude), &links),
            inertia: self.momentum_reaction(body.rate, &links, imposed),
        })
    }

    /// Minus the rate of momentum of body and links about the body origin, in B.
    pub(super) fn momentum_reaction(
        &self,
        w: Vec3,
        links: &[LinkMotion<f64>],
        base: BaseAcceleration<f64>,
    ) -> Wrench<f64> {
        let (mass, bias) = self.tree.inertia_and_bias(w, links);
        let mut acceleration = [0.0; 6];
        base.origin.store(&mut acceleration);
        base.angular.store(&mut acceleration[3..]);
        let row = |i: usize| (0..6).map(|j| mass[i][j] * acceleration[j]).sum::<f64>();
        let force = Vec3::new(row(0), row(1), row(2));
        let moment = Vec3::new(row(3), row(4), row(5));
        -(Wrench { force, moment } + bias)
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
