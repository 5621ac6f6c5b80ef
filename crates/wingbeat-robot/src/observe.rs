//! What is worth seeing of a flight at one instant: angles, named forces, power.

use super::dynamics::Evaluation;
use super::sections::{CarrierRoom, Carriers, SurfaceSection};
use super::surface::External;
use super::{Links, MAX_ELEMENTS, Robot};
use crate::MotorWork;
use crate::body::{BaseAcceleration, Coordinates, LinkMotion, MAX_LINKS, drive_power, joint_power};
use arrayvec::ArrayVec;
use wingbeat_aero::{ForceDetail, LoadSource, Loads, StripLoads};
use wingbeat_math::{Jet, Mat3, Meets, Scalar, Vec3, Wrench};
use wingbeat_ocp::plant::Fault;

/// One instant of a flight.
#[derive(Clone, Debug)]
pub struct Observation {
    /// R_WB.
    pub attitude: Mat3,
    /// Joint coordinates, rad or m; order of the tree.
    pub joints: Vec<f64>,
    /// Angles of the pins of the linkage that have a spring, rad; in the order of [`Robot::pin_names`].
    pub pins: Vec<f64>,
    /// Joint efforts, N m or N.
    pub torques: Vec<f64>,
    /// Phase of the gait, rad.
    pub phase: f64,
    /// Mechanical power of the driven joints, W: that of the drive and that of the actuators.
    pub power: f64,
    /// Sum of the positive powers of the driven joints, each by itself, W: what drives that share nothing give. See [`drive_power`].
    pub separate_power: f64,
    /// Part of `power` that the drive gives, turning the crank, W.
    pub drive_power: f64,
    /// Part of it that the actuators give, displacing the structure, W.
    pub regulator_power: f64,
    /// Part of `power` that drive and actuators give to springs and dampers on pins of the linkage, W.
    pub pin_power: f64,
    /// The motor, where one turns the crank.
    pub motor: Option<MotorWork>,
    /// Kinetic energy plus potential energy above z = 0, in the springs of elastic joints and pins and in membranes, J.
    pub energy: f64,
    /// Power that the surfaces, their membranes and the body take from the air, W; that of the membranes' own inertia is in it.
    pub air_power: f64,
    /// Power that the dampers of elastic joints, pins and membranes take, W.
    pub dissipation: f64,
    /// Aerodynamic loads summed over the strips of all surfaces, by source, in B about the body origin.
    pub air: StripLoads<f64>,
    /// Parts of `air` that its sources do not tell apart, in B.
    pub detail: ForceDetail<f64>,
    /// Drag of the body with what `robot.residual` says, N and N m in B.
    pub body_drag: Wrench<f64>,
    /// Part of it that `robot.residual` says, N and N m in B.
    pub residual: Wrench<f64>,
    /// Whether the wings are beyond the velocities at which `robot.residual` was measured; none without one.
    pub beyond_residual: Option<bool>,
    /// Wrench of the thrusters, N and N m in B.
    pub thrust: Wrench<f64>,
    /// Gravity, N and N m in B.
    pub gravity: Wrench<f64>,
    /// Inertia: minus the rate of momentum of body and links, N and N m in B. With the forces above it sums to zero
    /// (d'Alembert).
    pub inertia: Wrench<f64>,
    /// Loads, incidence, circulation and place of the strips of all surfaces in turn, in B about the
    /// body origin.
    pub strips: Box<Loads<f64>>,
    /// Centre of mass from the body origin, in B, m.
    pub center_of_mass: Vec3,
    /// Momentum of body and links, in W, kg m/s.
    pub momentum: Vec3,
    /// Angular momentum of body and links about the centre of mass, in W, kg m2/s.
    pub angular_momentum: Vec3,
    /// For each surface the ends of its panels, left to right: hinge-line point, leading and trailing
    /// edge, from the body origin, in B, m.
    pub outlines: Vec<Vec<[Vec3; 3]>>,
    /// Clearances, m, in the order of [`Plant::clearances`](wingbeat_ocp::plant::Plant::clearances): exact, not rounded off.
    pub clearances: Vec<f64>,
}

/// A robot with all its accelerations; what of it is large lies where its caller has room, and is filled there.
pub(super) struct Moving<'a> {
    /// What led to its rates: joint coordinates with their second rates, and links without the body's own acceleration.
    pub e: &'a mut Evaluation<f64>,
    /// That acceleration.
    pub body: BaseAcceleration<f64>,
    /// The body as a link, accelerated.
    pub base: LinkMotion,
    /// The links with the body's acceleration.
    pub moving: &'a mut Links<f64>,
    /// Velocity of the air and its rate, in B.
    pub wind: [Vec3; 2],
}

impl<'a> Moving<'a> {
    /// Nothing moves yet.
    pub fn still(e: &'a mut Evaluation<f64>, moving: &'a mut Links<f64>) -> Self {
        Self {
            e,
            body: BaseAcceleration::from_slice(&[0.0; 6]),
            base: LinkMotion::REST,
            moving,
            wind: [Vec3::ZERO; 2],
        }
    }
}

impl Observation {
    /// The loads of air, body drag, gravity and inertia in the order of [`LoadSource::ALL`], N and N m.
    pub fn parts(&self) -> [Wrench<f64>; LoadSource::ALL.len()] {
        self.air.parts_with([self.body_drag, self.gravity, self.inertia])
    }

    /// Incidence of each strip, wash included, rad; surface after surface.
    pub fn incidence(&self) -> impl Iterator<Item = f64> {
        self.strips.incidence[..self.strips.strips].iter().copied()
    }
}

impl Robot {
    /// Looks at the robot at (t, x, u).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn observe(&self, t: f64, x: &[f64], u: &[f64]) -> Result<Observation, Fault> {
        Ok(self.look((t, x, u), &[], Loads::boxed(), |_, _| ())?.1)
    }

    /// The same with loads on links and body from beyond the surfaces' models, which [`Observation::air`] lacks; `strips` are written over.
    /// Before it what `draw` makes of body and links.
    #[inline]
    pub(super) fn look<T>(
        &self,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &[Wrench<f64>],
        strips: Box<Loads<f64>>,
        draw: impl FnOnce(&LinkMotion, &[LinkMotion]) -> T,
    ) -> Result<(T, Observation), Fault> {
        let mut dx = vec![0.0; x.len()];
        let (mut e, mut moving) = (Evaluation::empty(), Links::new());
        let mut seen = Moving::still(&mut e, &mut moving);
        self.moving((t, x, u), beyond, &mut dx, &mut seen)?;
        let drawn = draw(&seen.e.base, &seen.e.links);
        Ok((drawn, self.observed(&seen, (t, x, u), beyond, &mut dx, strips)?))
    }

    /// What is worth seeing of what has been `seen` at (t, x, u).
    fn observed(
        &self,
        seen: &Moving<'_>,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &[Wrench<f64>],
        dx: &mut [f64],
        mut strips: Box<Loads<f64>>,
    ) -> Result<Observation, Fault> {
        let Moving { e, body, base, moving, wind: [wind, wind_dot] } = seen;
        let (joints, links, body, wind) = (&e.joints, &e.links, *body, *wind);
        let still = Coordinates::none();
        let mut room = CarrierRoom::new();
        let mut carriers = Carriers::within(&mut room, &still);
        carriers.follow(base, &self.carriers, moving, [*wind_dot, self.gravity(e.attitude)]);
        carriers.ground = self.ground_below(e.attitude, x[self.layout.position + 2]);
        let aero = self.layout.aero;
        let mut external = self.air_loads(&carriers, wind, &x[aero..], &mut dx[aero..], &mut strips);
        external.iter_mut().zip(beyond).for_each(|(load, beyond)| *load += *beyond);
        let structure = &x[self.layout.structure..];
        let against = e.base.velocity - wind;
        let body_drag = self.body_load(&Jet::new(t, 1.0, 0.0), (structure, u), (against, e.base.rate));
        let residual = match self.residual {
            Some(_) => body_drag + -self.body_drag(against),
            None => Wrench::ZERO,
        };
        let g = self.gravity(e.attitude);
        let torques = self.joint_torques(links, body, &external, g);
        let tree = &self.mechanism.tree;
        let springs = || {
            let springs = self.mechanism.springs().zip(&self.mechanism.coordinates).enumerate();
            springs.map(|(c, (spring, &joint))| {
                (spring, joints[joint], self.rest_displaced(c, &x[self.layout.structure..]))
            })
        };
        let of = |coordinate: usize| joints[self.mechanism.coordinates[coordinate]];
        let inerters = || self.inertances().map(|(b_of, b)| (b, b_of.map(of)));
        let mut displacements = [Jet::ZERO; MAX_ELEMENTS];
        self.response.displacements(structure, u, &mut displacements);
        let phase = self.phase_of(&Jet::new(t, 1.0, 0.0), structure, &displacements);
        let pins = self.pin_work(phase, &displacements)?;
        let pin_power = pins.given[0] + pins.given[1];
        let [drive_power, regulator_power] =
            self.power_split(phase, structure, &displacements, &torques, pins.given)?;
        let rest_power = self.rest_power(structure, &displacements);
        let center_of_mass = tree.center_of_mass(links);
        let momentum = tree.momentum(e.base.velocity, e.base.rate, links, center_of_mass);
        let datum = -e.attitude.transpose_mul(Vec3::from_slice(&x[self.layout.position..]));
        Ok(Observation {
            attitude: e.attitude,
            phase: phase.x,
            drive_power,
            regulator_power,
            motor: self.motor_work(phase, 1.0),
            separate_power: self.separate_power(&torques, joints)
                + rest_power.max(0.0)
                + pins.by_wing.map(|power| power.max(0.0)).iter().sum::<f64>(),
            pin_power,
            power: joint_power(&torques, joints) + rest_power + pin_power
                - springs().map(|(spring, q, y)| spring.effort(q.x, q.d, y) * q.d).sum::<f64>()
                + inerters().map(|(b, [q, other])| b * q.d * other.dd).sum::<f64>(),
            energy: tree.kinetic_energy(e.base.velocity, e.base.rate, links)
                + tree.potential_energy(g, links, datum)
                + springs().map(|(spring, joint, y)| spring.energy(joint.x, y)).sum::<f64>()
                + inerters().map(|(b, [q, other])| 0.5 * b * q.d * other.d).sum::<f64>()
                + pins.energy
                + strips.membrane.stored,
            air_power: super::carried::air_power(base, links, &external)
                + body_drag.force.dot(e.base.velocity)
                + body_drag.moment.dot(e.base.rate)
                + strips.membrane.given,
            dissipation: springs().map(|(spring, joint, _)| spring.dissipation(joint.d)).sum::<f64>()
                + pins.dissipation
                + strips.membrane.lost,
            inertia: self.momentum_reaction(e.base.rate, links, body),
            joints: joints.iter().map(|j| j.x).collect(),
            pins: pins.angles,
            torques: torques.to_vec(),
            air: strips.by_source(),
            detail: strips.detail_sum(&[]),
            body_drag,
            residual,
            beyond_residual: self.beyond_residual([e.base.velocity - wind, e.base.rate], phase.d),
            thrust: self.thrust(structure),
            gravity: tree.gravity(g, links),
            strips,
            center_of_mass,
            momentum: e.attitude * momentum.linear,
            angular_momentum: e.attitude * momentum.angular,
            outlines: self.outlines(&e.base, links),
            clearances: self.clearances.least(links).collect(),
        })
    }

    /// Sum of the positive powers of the driven joints, W.
    fn separate_power(&self, torques: &[f64], joints: &[Jet]) -> f64 {
        let driven = (0..torques.len()).filter(|joint| !self.is_elastic(*joint));
        driven.map(|j| drive_power(&torques[j..=j], &joints[j..=j], 0.0, 0.0)).sum()
    }

    /// The robot with its accelerations at (t, x, u) under the loads `beyond`; `dx` receives the rates.
    pub(super) fn moving(
        &self,
        (t, x, u): (f64, &[f64], &[f64]),
        beyond: &[Wrench<f64>],
        dx: &mut [f64],
        seen: &mut Moving<'_>,
    ) -> Result<(), Fault> {
        let e = &mut *seen.e;
        self.evaluate(t, x, u, beyond, dx, e)?;
        self.let_go(&mut e.joints, &mut e.links, &e.coordinates, &e.ratios, &e.second_rates);
        seen.body = BaseAcceleration::from_slice(&seen.e.acceleration);
        seen.base = seen.e.base.accelerated(&seen.body);
        seen.moving.extend(seen.e.links.iter().map(|link| link.accelerated(&seen.body)));
        let (wind, rate) = self.wind(t, seen.e.attitude);
        seen.wind = [wind, rate];
        Ok(())
    }

    /// Ends of the panels of every surface.
    fn outlines(&self, base: &LinkMotion, links: &[LinkMotion]) -> Vec<Vec<[Vec3; 3]>> {
        let place = |(_, s): &(String, SurfaceSection)| {
            let link = s.link.map_or(base, |i| &links[i]);
            let [le, te] = s.edges(link);
            [s.hinge_point(link), le, te]
        };
        self.covering.laid.iter().map(|surface| surface.outline.iter().map(place).collect()).collect()
    }
}

impl<P: Scalar> Robot<P> {
    /// Efforts that the joints need: `links` without the base's own acceleration,
    /// which is `body`; `external` the loads of the air on them; `g` is gravity in B.
    pub(super) fn joint_torques<S: Scalar + Meets<P>>(
        &self,
        links: &[LinkMotion<S>],
        body: BaseAcceleration<S>,
        external: &External<S>,
        g: Vec3<S>,
    ) -> ArrayVec<S, MAX_LINKS> {
        let mut torques: ArrayVec<S, MAX_LINKS> = links.iter().map(|_| S::ZERO).collect();
        self.mechanism.tree.joint_torques(links, body, g, external, &mut torques);
        torques
    }
}
