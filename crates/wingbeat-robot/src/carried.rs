//! The robot with its body carried along a given motion: on a test rig, in a tunnel, on a stand.

use super::drive::Ratios;
use super::dynamics::{BodySystem, of_numbers};
use super::sections::{CarrierRoom, Carriers};
use super::surface::External;
use super::{Joints, Links, Robot};
use crate::body::{BaseAcceleration, Coordinates, LinkMotion, MAX_LINKS, Momentum, joint_power};
use arrayvec::ArrayVec;
use wingbeat_aero::{LoadSource, Loads, MAX_STRIPS, StallCount, StripLoads, Surface};
use wingbeat_math::{Jet, Mat3, Meets, Quat, Scalar, Vec3, Wrench};
use wingbeat_ocp::plant::{Fault, MAX_COORDINATES};

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

/// Loads in N and N m on what carries the robot, by source, in B about the body origin; and what the joints do.
#[derive(Clone, Debug, Default)]
pub struct CarriedLoads<S: Scalar = f64> {
    /// Aerodynamic loads of the surfaces by source.
    pub air: StripLoads<S>,
    /// Drag of the body with what `robot.residual` says, N and N m.
    pub body_drag: Wrench<S>,
    /// Weight, N and N m.
    pub gravity: Wrench<S>,
    /// Minus the rate of momentum of body and links, N and N m.
    pub inertia: Wrench<S>,
    /// Joint coordinates with rates and accelerations, rad or m; order of the tree.
    pub joints: ArrayVec<Jet<S>, MAX_LINKS>,
    /// Joint efforts, N m or N.
    pub torques: ArrayVec<S, MAX_LINKS>,
    /// Power that surfaces and body take from the air, W.
    pub air_power: S,
    /// Centre of mass from the body origin, in B, m.
    pub center_of_mass: Vec3<S>,
    /// Strips past the angles of attack up to which their laws hold.
    pub stalled: StallCount,
    /// How far flaps and spars give way.
    pub deflections: Deflections,
}

/// How far the parts of a robot that the loads deform give way: the largest of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deflections {
    /// Angle of a flap, rad.
    pub flap: f64,
    /// Angle between two pieces of a spar, rad.
    pub spar: f64,
}

impl Deflections {
    /// The larger of both, kind by kind.
    #[must_use]
    pub fn largest(self, other: Self) -> Self {
        Self { flap: self.flap.max(other.flap), spar: self.spar.max(other.spar) }
    }
}

impl<S: Scalar> CarriedLoads<S> {
    /// The wrench that the robot exerts on its carrier, N and N m about the body origin, in B.
    pub fn total(&self) -> Wrench<S> {
        self.air.total() + self.body_drag + self.gravity + self.inertia
    }
    /// The loads, N and N m, in the order of [`LoadSource::ALL`].
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

impl<P: Scalar> Robot<P> {
    /// Number of states of a carried robot: structure, then aerodynamics.
    pub fn carried_states(&self) -> usize {
        self.layout.len - self.layout.structure
    }

    /// Loads with the body moving as `body`, structure and aerodynamics in the
    /// state `x` and the inputs `u`; `dx` receives the rates of `x`. `clock` is the
    /// gait's time with its rate, 1 while flapping at the full frequency, and the rate's slope; a
    /// motor receives its rate as the share of the supply voltage.
    ///
    /// Newton-Euler: carrier + air + drag + gravity = rate of momentum, so the
    /// carrier bears air + drag + gravity + inertia.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    ///
    /// Equation: robot.carried_wrench
    /// `carrier bears air + drag + weight - d(momentum)/dt`
    /// Source: Newton-Euler.
    /// Test: `a_robot_at_rest_bears_its_weight_on_the_stand`.
    pub fn carried<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<CarriedLoads<S>, Fault> {
        self.carry(clock, body, (x, u), &[], dx, |_, _| ())
    }

    /// The same with the loads `beyond` on links and body from beyond the surfaces' models, which [`CarriedLoads::air`] lacks; `seen`
    /// is shown the loads of the strips and what they ride on.
    #[inline(always)]
    pub(super) fn carry<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        (x, u): (&[S], &[S]),
        beyond: &[Wrench<f64>],
        dx: &mut [S],
        seen: impl FnOnce(&Carriers<S>, &Loads<S>),
    ) -> Result<CarriedLoads<S>, Fault> {
        let (elements, structure) = (self.layout.joints - self.layout.structure, self.structure_states());
        let (mut joints, mut links) = (Joints::new(), Links::new());
        let mut ratios = Ratios::new();
        self.joints(clock, &x[..structure], u, &mut dx[..elements], &mut joints, &mut ratios)?;
        let v = body.attitude.transpose_mul(body.velocity);
        self.links(&joints, v, body.rate, &mut links);
        let imposed = BaseAcceleration {
            origin: body.attitude.transpose_mul(body.acceleration),
            angular: body.angular_acceleration,
        };
        let base = LinkMotion::base(v, body.rate).accelerated(&imposed);
        let mut coordinates = Coordinates::none();
        self.coordinates(&links, &ratios, &mut coordinates);
        let (wind, wind_dot) = self.wind(clock.x, body.attitude);
        let gravity = self.gravity(body.attitude);
        let still = Coordinates::none();
        if coordinates.count() > 0 {
            let mut moving = Links::new();
            moving.extend(links.iter().map(|link| link.accelerated(&imposed)));
            let mut room = CarrierRoom::new();
            let mut carriers = Carriers::within(&mut room, &coordinates);
            carriers.follow(&base, &self.carriers, &moving, [wind_dot, gravity]);
            let second_rates = self
                .second_rates(&moving, &carriers, gravity, (wind, clock.d), (x, beyond), dx)
                .ok_or(Fault::MassMatrix { time: clock.x.value() })?;
            self.store_coordinate_rates(&x[..structure], &second_rates, &mut dx[..structure]);
            self.let_go(&mut joints, &mut links, &coordinates, &ratios, &second_rates);
        }
        let mut moving = Links::new();
        moving.extend(links.iter().map(|link| link.accelerated(&imposed)));
        let mut room = CarrierRoom::new();
        let mut carriers = Carriers::within(&mut room, &still);
        carriers.follow(&base, &self.carriers, &moving, [wind_dot, gravity]);
        let (structure_state, x) = x.split_at(structure);
        let dx = &mut dx[structure..];
        let mut loads = Loads::default();
        let mut external = self.air_loads(&carriers, wind, x, dx, &mut loads);
        external.iter_mut().zip(beyond).for_each(|(load, beyond)| *load += of_numbers(beyond));
        seen(&carriers, &loads);
        let body_drag = self.body_load(clock, (structure_state, u), (v - wind, body.rate));
        Ok(CarriedLoads {
            air: loads.by_source(),
            body_drag,
            gravity: self.mechanism.tree.gravity(gravity, &links),
            inertia: self.momentum_reaction(body.rate, &links, imposed),
            torques: self.joint_torques(&links, imposed, &external, gravity),
            air_power: air_power(&base, &links, &external)
                + body_drag.force.dot(v)
                + body_drag.moment.dot(body.rate),
            stalled: self.stalled(&loads),
            deflections: self.deflections(&loads, &joints),
            center_of_mass: self.mechanism.tree.center_of_mass(&links),
            joints,
        })
    }

    /// Sets states that follow the impulse of the air to that impulse, at the gait's time `clock` (s): the wings have always
    /// moved as they do.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn settle_carried<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        x: &mut [S],
        u: &[S],
    ) -> Result<(), Fault> {
        if !self.covering.aero.settles() {
            return Ok(());
        }
        let (structure, air) = x.split_at_mut(self.structure_states());
        let (mut joints, mut links, mut ratios) = (Joints::new(), Links::new(), Ratios::new());
        self.joints(clock, structure, u, &mut structure.to_vec(), &mut joints, &mut ratios)?;
        let v = body.attitude.transpose_mul(body.velocity);
        self.links(&joints, v, body.rate, &mut links);
        let (wind, wind_dot) = self.wind(clock.x, body.attitude);
        let still = Coordinates::none();
        let mut room = CarrierRoom::new();
        let mut carriers = Carriers::within(&mut room, &still);
        carriers.follow(&LinkMotion::base(v, body.rate), &self.carriers, &links, [wind_dot, Vec3::ZERO]);
        self.covering.settle(&carriers, wind, air);
        Ok(())
    }

    /// The strips by their angles of attack.
    fn stalled<S: Scalar>(&self, loads: &Loads<S>) -> StallCount {
        let (mut count, mut incidence) = (StallCount::default(), loads.incidence[..loads.strips].iter());
        for surface in self.covering.aero.surfaces() {
            let aero = surface.aero();
            count.see(aero, incidence.by_ref().take(aero.strips()).map(|angle| angle.value()));
        }
        count
    }

    /// The largest deflections under `loads` with the `joints` as they are.
    fn deflections<S: Scalar>(&self, loads: &Loads<S>, joints: &[Jet<S>]) -> Deflections {
        let spars = self.mechanism.pieces().map(|joint| joints[joint].x.value().abs());
        Deflections {
            flap: loads.flap.iter().map(|angle| angle.value().abs()).fold(0.0, f64::max),
            spar: spars.fold(0.0, f64::max),
        }
    }

    /// Heights over the chord of the strips of its membranes in the state `x` of structure and air, surface by surface, dimensionless; none of
    /// a surface that is no membrane.
    pub fn membrane_heights(&self, x: &[f64]) -> Vec<Vec<[f64; 2]>> {
        let air = &x[self.structure_states()..];
        let of = |surface: &Surface<P>| {
            let heights = surface.aero().membrane().map(|of| of.camber_of(&air[surface.states()]));
            let [camber, forward] = heights.unwrap_or_default();
            camber.iter().zip(forward).map(|(a, b)| [*a, *b]).collect()
        };
        self.covering.aero.surfaces().iter().map(of).collect()
    }

    /// Places in the state of the carried robot of what says how its shape gives way: coordinates of elastic and free joints, heights of
    /// membranes and angles of flaps.
    pub fn bent_states(&self) -> Vec<usize> {
        let (l, coordinates) = (&self.layout, self.mechanism.coordinates.len());
        let surfaces = (0..self.covering.aero.surfaces().len()).flat_map(|k| self.bent_states_of(k));
        (l.joints..l.joints + coordinates).chain(surfaces).map(|place| place - l.structure).collect()
    }

    /// Places in the state of the flying robot of what says how the chords of the surface number `surface` are bent.
    pub fn bent_states_of(&self, surface: usize) -> std::ops::Range<usize> {
        let surface = &self.covering.aero.surfaces()[surface];
        let (first, bent) = (self.layout.aero + surface.states().start, surface.aero().bent_states());
        first + bent.start..first + bent.end
    }

    /// Number of states of the structure: elements, elastic joints, crank.
    fn structure_states(&self) -> usize {
        self.layout.aero - self.layout.structure
    }

    /// Second rates of elastic joints and crank with the body's acceleration imposed; `moving` and
    /// `carriers` hold it. `wind` and `supply`: velocity of the air, the motor's share of its voltage; `beyond` as for `carry`.
    fn second_rates<S: Scalar + Meets<P>>(
        &self,
        moving: &[LinkMotion<S>],
        carriers: &Carriers<S>,
        gravity: Vec3<S>,
        (wind, supply): (Vec3<S>, S),
        (x, beyond): (&[S], &[Wrench<f64>]),
        dx: &mut [S],
    ) -> Option<[S; MAX_COORDINATES]> {
        let structure = self.structure_states();
        let mut system = BodySystem::<S, S>::new(carriers.coordinates.count());
        self.mechanism.tree.coordinate_inertia(
            moving,
            gravity,
            carriers.coordinates,
            Some(&mut system.mass),
            &mut system.forces,
        );
        self.add_efforts(&x[..structure], supply, &mut system.forces);
        self.add_inertances(&mut system.mass);
        self.add_beyond(beyond, carriers, &mut system.forces);
        // The rates of the air are those of the loads that follow, with these second rates.
        system.add_air::<S, P>(self, carriers, (wind, None), &x[structure..], &mut dx[structure..]);
        let degrees = system.solve(None, carriers.coordinates.count())?;
        Some(std::array::from_fn(|c| degrees[6 + c]))
    }

    /// Gives elastic joints, what the crank turns, and the links the second rates found.
    pub(super) fn let_go<S: Scalar + Meets<P>>(
        &self,
        joints: &mut Joints<S>,
        links: &mut Links<S>,
        coordinates: &Coordinates<S>,
        ratios: &Ratios<S>,
        second_rates: &[S],
    ) {
        if second_rates.is_empty() {
            return;
        }
        for (&joint, rate) in self.mechanism.coordinates.iter().zip(second_rates) {
            joints[joint].dd = *rate;
        }
        if self.motor.is_some() {
            let turning = second_rates[self.degrees() - 1];
            joints.iter_mut().zip(&ratios.crank).for_each(|(joint, ratio)| joint.dd += *ratio * turning);
        }
        self.let_loaded_go(joints, ratios, second_rates);
        for (i, link) in links.iter_mut().enumerate() {
            link.accelerate(&coordinates.combined(i, second_rates));
        }
    }

    /// Loads of all strips, `loads`, and of the links that bear them.
    pub(super) fn air_loads<S: Scalar + Meets<P>>(
        &self,
        carriers: &Carriers<S>,
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) -> External<S> {
        let covering = &self.covering;
        let mut motions = ArrayVec::new();
        covering.motions(carriers, &mut motions);
        let around = (carriers.ground, carriers.gravity, true);
        covering.aero.evaluate_under(around, &motions, wind, x, dx, loads);
        let totals: ArrayVec<Wrench<S>, MAX_STRIPS> =
            loads.strip[..loads.strips].iter().map(StripLoads::total).collect();
        let mut external = External::new();
        external.extend(std::iter::repeat_n(Wrench::ZERO, self.mechanism.tree.links() + 1));
        covering.share(&covering.riding(carriers), &totals, &mut external);
        external
    }

    /// Minus the rate of momentum of body and links about the body origin, in B.
    pub(super) fn momentum_reaction<S: Scalar + Meets<P>>(
        &self,
        w: Vec3<S>,
        links: &[LinkMotion<S>],
        base: BaseAcceleration<S>,
    ) -> Wrench<S> {
        let (mass, bias) = self.mechanism.tree.inertia_and_bias(w, links);
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
    pub fn carried_energy<S: Scalar + Meets<P>>(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        position: Vec3<S>,
        x: &[S],
        u: &[S],
    ) -> Result<S, Fault> {
        let structure = self.structure_states();
        let (mut joints, mut links) = (Joints::new(), Links::new());
        let mut ratios = Ratios::new();
        self.joints(clock, &x[..structure], u, &mut x[..structure].to_vec(), &mut joints, &mut ratios)?;
        let v = body.attitude.transpose_mul(body.velocity);
        self.links(&joints, v, body.rate, &mut links);
        let datum = -body.attitude.transpose_mul(position);
        let tree = &self.mechanism.tree;
        let potential = tree.potential_energy(self.gravity(body.attitude), &links, datum);
        Ok(tree.kinetic_energy(v, body.rate, &links) + potential)
    }
}

impl Robot {
    /// Sets states that follow the impulse of the air to that impulse, of a robot in flight at (t, x, u).
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn settle(&self, t: f64, x: &mut [f64], u: &[f64]) -> Result<(), Fault> {
        let l = &self.layout;
        let body = BodyMotion {
            rate: Vec3::from_slice(&x[l.rate..]),
            ..BodyMotion::steady(
                Quat::from_wxyz(&x[l.attitude..]).matrix(),
                Vec3::from_slice(&x[l.velocity..]),
            )
        };
        self.settle_carried(&Jet::new(t, 1.0, 0.0), &body, &mut x[l.structure..], u)
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
        let mut structure = vec![0.0; self.structure_states()];
        if self.motor.is_some() {
            let phase = *clock * self.phase_rate + self.phase_start;
            let (crank, rate) = (structure.len() - 1 - self.degrees(), structure.len() - 1);
            (structure[crank], structure[rate]) = (phase.x, phase.d);
        }
        let u = vec![0.0; self.inputs.len()];
        let (mut joints, mut links) = (Joints::new(), Links::new());
        self.joints(clock, &structure, &u, &mut structure.clone(), &mut joints, &mut Ratios::new())?;
        let v = body.attitude.transpose_mul(body.velocity);
        self.links(&joints, v, body.rate, &mut links);
        Ok(self.mechanism.tree.momentum(v, body.rate, &links, -body.attitude.transpose_mul(position)))
    }
}

/// Power of the loads on body and links, W: sum of F . v + T . w with F, T, v at the body origin, `base` last in
/// `external`. With it the joints' power is the rate of the energy of body and links.
///
/// Equation: robot.air_power
/// `P_joints + P_air + P_carrier = d(energy)/dt, P = sum F . v + T . w`
/// Source: conservation of energy.
/// Test: `the_power_of_joints_air_and_carrier_is_the_rate_of_energy`.
pub(super) fn air_power<S: Scalar>(
    base: &LinkMotion<S>,
    links: &[LinkMotion<S>],
    external: &[Wrench<S>],
) -> S {
    links.iter().chain([base]).zip(external).fold(S::ZERO, |sum, (link, load)| {
        sum + load.force.dot(link.velocity_at(Vec3::ZERO)) + load.moment.dot(link.rate)
    })
}
