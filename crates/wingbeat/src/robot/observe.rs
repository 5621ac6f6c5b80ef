//! What is worth seeing of a flight at one instant: angles, named forces, power.

use super::dynamics::Evaluation;
use super::sections::{Riding, Section};
use super::{JOINTS, Robot, RobotSpec};
use crate::aero::{LoadSource, Loads, Planform, Sections, StripLoads};
use crate::body::{BaseAcceleration, LinkMotion, joint_power};
use crate::math::{Mat3, Scalar, Vec3, Wrench};
use crate::plant::Fault;

/// Points along the hinge line of the wings, left tip to right tip: tip, elbow,
/// shoulder, shoulder, elbow, tip.
pub const WING_POINTS: usize = 6;

/// One instant of a flight.
#[derive(Clone, Debug)]
pub struct Observation {
    /// R_WB.
    pub attitude: Mat3,
    /// Joint angles, rad; order of [`JOINTS`].
    pub joints: [f64; JOINTS.len()],
    /// Joint torques, N m.
    pub torques: [f64; JOINTS.len()],
    /// Mechanical power of the joints, W.
    pub power: f64,
    /// Kinetic energy plus potential energy above z = 0, J.
    pub energy: f64,
    /// Aerodynamic loads summed over the strips, by source, in B about the body origin.
    pub air: StripLoads<f64>,
    /// Drag of the body, in B.
    pub body_drag: Wrench<f64>,
    /// Gravity, in B.
    pub gravity: Wrench<f64>,
    /// Inertia: minus the rate of momentum of body and links, in B. With the
    /// forces above it sums to zero (d'Alembert).
    pub inertia: Wrench<f64>,
    /// Loads, incidence, circulation and place of each strip, in B about the body origin.
    pub strips: Loads<f64>,
    /// Centre of mass from the body origin, in B, m.
    pub center_of_mass: Vec3,
    /// Hinge-line points with leading and trailing edge, from the body origin, in B, m.
    pub wing: [[Vec3; 3]; WING_POINTS],
}

impl Observation {
    /// The loads of air, body drag, gravity and inertia in the order of [`LoadSource::ALL`].
    pub fn parts(&self) -> [Wrench<f64>; LoadSource::ALL.len()] {
        self.air.parts_with([self.body_drag, self.gravity, self.inertia])
    }

    /// Incidence of each strip, wash included, rad.
    pub fn incidence(&self) -> &[f64] {
        &self.strips.incidence[..self.strips.strips]
    }
}

/// Arcs of the [`WING_POINTS`].
pub(super) fn wing_point_arcs(spec: &RobotSpec, planform: &Planform) -> [f64; WING_POINTS] {
    let (root, tip) = (spec.wing.shoulder_m[1], planform.half_span());
    let elbow = root + spec.wing.proximal.length_m;
    [tip, elbow, root, -root, -elbow, -tip]
}

impl Robot {
    /// Looks at the robot at (t, x, u).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe(&self, t: f64, x: &[f64], u: &[f64]) -> Result<Observation, Fault> {
        let mut dx = vec![0.0; x.len()];
        let e = self.evaluate(t, x, u, &mut dx)?;
        let body = BaseAcceleration::from_slice(&e.acceleration);
        let base = accelerated(&e.base, body);
        let links = e.links.map(|link| accelerated(&link, body));

        let mut loads = Loads::default();
        let (wind, wind_dot) = self.wind(t, e.attitude);
        let riding = Riding::new(&self.sections, &base, &links, wind_dot);
        let sections: Vec<_> = (0..self.sections.len()).map(|i| riding.section(i)).collect();
        let aero = self.layout.aero;
        self.aero.evaluate(&sections, wind, &x[aero..], &mut dx[aero..], &mut loads);
        let air = loads.by_source();
        let body_drag = self.body_drag(e.base.velocity - wind);
        let g = self.gravity(e.attitude);
        let gravity = self.tree.gravity(g, &e.links);
        let torques = self.joint_torques(&e.links, body, &loads, g);
        Ok(Observation {
            attitude: e.attitude,
            joints: e.joints.map(|j| j.x),
            torques,
            power: joint_power(&torques, &e.joints),
            energy: self.energy(&e, g, Vec3::from_slice(&x[self.layout.position..])),
            inertia: self.inertia(&e),
            air,
            body_drag,
            gravity,
            strips: loads,
            center_of_mass: self.tree.center_of_mass(&e.links),
            wing: self.wing_points.map(|s: Section| {
                let link = s.link.map_or(&e.base, |i| &e.links[i]);
                let [le, te] = s.edges(link);
                [s.hinge_point(link), le, te]
            }),
        })
    }

    fn inertia(&self, e: &Evaluation<f64>) -> Wrench<f64> {
        self.momentum_reaction(e.base.rate, &e.links, BaseAcceleration::from_slice(&e.acceleration))
    }

    fn energy(&self, e: &Evaluation<f64>, g: Vec3, position: Vec3) -> f64 {
        let datum = -e.attitude.transpose_mul(position);
        self.tree.kinetic_energy(e.base.velocity, e.base.rate, &e.links)
            + self.tree.potential_energy(g, &e.links, datum)
    }

    /// Torques that the joints need: `links` without the base's own acceleration,
    /// which is `body`; `g` is gravity in B.
    pub(super) fn joint_torques<S: Scalar>(
        &self,
        links: &[LinkMotion<S>],
        body: BaseAcceleration<S>,
        loads: &Loads<S>,
        g: Vec3<S>,
    ) -> [S; JOINTS.len()] {
        let mut external = [Wrench::ZERO; JOINTS.len()];
        for (link, strip) in self.strip_links.iter().zip(&loads.strip) {
            if let Some(link) = link {
                external[*link] += strip.total();
            }
        }
        let mut torques = [S::ZERO; JOINTS.len()];
        self.tree.joint_torques(links, body, g, &external, &mut torques);
        torques
    }
}

/// The link with the body's own acceleration added.
pub(super) fn accelerated<S: Scalar>(link: &LinkMotion<S>, body: BaseAcceleration<S>) -> LinkMotion<S> {
    LinkMotion {
        acceleration: link.acceleration + body.origin + body.angular.cross(link.position),
        rate_dot: link.rate_dot + body.angular,
        ..*link
    }
}
