//! Equations of motion: driven joints follow gait and structure exactly; the body's acceleration and
//! the second rates of elastic joints and of a crank under a motor come from one solve.

use super::drive::Ratios;
use super::joints::Displaced;
use super::perch::BodyPose;
use super::sections::{CarrierRoom, Carriers};
use super::surface::{External, MechanismLoads};
use super::{Joints, Links, Robot};
use crate::body::{BaseAcceleration, Coordinates, LinkMotion};
use arrayvec::ArrayVec;
use std::ops::Range;
use wingbeat_aero::{Ground, ImpulseRates};
use wingbeat_math::linear::solve_symmetric_leading;
#[cfg(feature = "lanes")]
use wingbeat_math::{Double4, Single8};
use wingbeat_math::{GRAVITY, Jet, Mat3, Meets, Over, Quat, Scalar, Vec3, Wrench, append_copies, kept, lift};
use wingbeat_ocp::plant::{
    Channel, Early, Fault, Known, Late, MAX_COORDINATES, MAX_DEGREES, PartsInEarly, Plant,
};

/// Everything one evaluation computes on the way to the rates; what the states of the air do
/// not enter is in `G`.
pub(super) struct Evaluation<G: Scalar, S: Over<G> = G> {
    /// R_WB.
    pub attitude: Mat3<G>,
    /// Joint coordinates, rates and accelerations, without the second rates of elastic joints.
    pub joints: Joints<G>,
    /// Links with the body's own acceleration and those second rates left out.
    pub links: Links<G>,
    /// The body as a link.
    pub base: LinkMotion<G>,
    /// The base and those links that carry surfaces.
    pub carriers: CarrierRoom<G>,
    /// How elastic joints and crank move the links.
    pub coordinates: Coordinates<G>,
    /// Ratios of the joints to a crank under a motor and to elements with an inertia.
    pub ratios: Ratios<G>,
    /// Acceleration of the body origin and angular acceleration, inertial, in B.
    pub acceleration: [S; 6],
    /// Second rates of elastic joints and crank.
    pub second_rates: ArrayVec<S, MAX_COORDINATES>,
}

impl<G: Scalar, S: Over<G>> Evaluation<G, S> {
    /// Room for an evaluation, which is large and so filled in place.
    #[inline(always)]
    pub fn empty() -> Self {
        Self {
            attitude: Mat3::IDENTITY,
            joints: Joints::new(),
            links: Links::new(),
            base: LinkMotion::REST,
            carriers: CarrierRoom::new(),
            coordinates: Coordinates::none(),
            ratios: Ratios::new(),
            acceleration: [S::ZERO; 6],
            second_rates: ArrayVec::new(),
        }
    }

    /// Does `work` in the room of an evaluation. Of plain numbers it is a new one; what is larger takes longer to fill with
    /// constants than a room that the thread keeps takes to find, of which links and carriers stay as they were left, for what follows to write over.
    #[inline(always)]
    pub fn within<R>(work: impl FnOnce(&mut Self) -> R) -> R {
        if const { size_of::<S>() <= size_of::<f64>() } {
            return work(&mut Self::empty());
        }
        kept(
            || Box::new(Self::empty()),
            |room| {
                room.joints.clear();
                room.coordinates.clear();
                room.ratios.clear();
                room.second_rates.clear();
                work(room)
            },
        )
    }
}

/// What of an instant does not know the air on the surfaces, in B.
pub(super) struct InstantSetting<G: Scalar> {
    /// R_WB.
    pub attitude: Mat3<G>,
    /// Velocity and acceleration of the air.
    pub wind: Vec3<G>,
    pub wind_dot: Vec3<G>,
    pub gravity: Vec3<G>,
    /// Drag of the body.
    drag: Wrench<G>,
}

/// Mass matrix of body and coordinates: as many rows as there are degrees of freedom.
pub(super) type DegreeMatrix<G> = ArrayVec<[G; MAX_DEGREES], MAX_DEGREES>;

/// What becomes of the inertia of body and links.
pub(super) enum InstantInertia<'a, G> {
    /// The mass matrix gets that on the body's accelerations; the wrench holds the rest.
    Summed(&'a mut [[G; 6]; 6]),
    /// Body and coordinates have these accelerations, links and body move with them, and the wrench holds all of it.
    Held(&'a [f64]),
}

/// The wrench on the body of all but the air on the surfaces, and what led to it.
type InstantForces<G> = (Wrench<G>, InstantSetting<G>);

impl Plant for Robot {
    fn states(&self) -> &[Channel] {
        &self.states
    }
    fn inputs(&self) -> &[Channel] {
        &self.inputs
    }
    fn attitude(&self) -> Option<usize> {
        Some(self.layout.attitude)
    }
    fn clearances(&self) -> &[Channel] {
        &self.clearances.channels
    }
    fn clear<S: Scalar>(&self, t: S, x: &[S], values: &mut [S]) -> Result<(), Fault> {
        self.smooth_clearances(t, &x[self.layout.structure..], values)
    }
    fn unfelt_states(&self) -> Range<usize> {
        // Over a ground the height is felt, and at a perch the place.
        let unfelt = match (&self.perch, &self.ground) {
            (Some(_), _) => 0,
            (None, Some(_)) => 2,
            (None, None) => 3,
        };
        self.layout.position..self.layout.position + unfelt
    }
    fn known(&self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64], known: &mut Known) -> Result<bool, Fault> {
        self.known_columns(t, x, u, dx, known)
    }
    fn derived_states(&self) -> Range<usize> {
        // Over a ground and at a perch the attitude is felt beside what the air and gravity are seen in it; flaps feel gravity by themselves.
        let felt = self.perch.is_some() || self.ground.is_some() || self.covering.aero.have_flaps();
        let derived = if felt { 0 } else { 4 };
        self.layout.attitude..self.layout.attitude + derived
    }
    fn derive(&self, x: &[f64], f: &[f64], known: &Known, a: &mut [f64]) {
        self.turned_columns(x, f, known, a);
    }
    fn driven_states(&self) -> Range<usize> {
        // Elements with an inertia are moved by what they carry.
        let driven = if self.loaded.is_empty() { 2 * self.elements.len() } else { 0 };
        self.layout.structure..self.layout.structure + driven
    }
    fn placing_states(&self) -> [Range<usize>; 2] {
        let (l, elements) = (&self.layout, self.elements.len());
        [l.structure..l.structure + elements, l.joints..l.joints + self.degrees()]
    }
    fn late_states(&self) -> usize {
        self.layout.aero
    }
    fn given_states(&self) -> &[Range<usize>] {
        &self.given
    }
    fn rates<S: Scalar>(&self, t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
        self.state_rates(t, x, u, dx)
    }
    fn rates_by_late<S: Over<f64>>(
        &self,
        t: f64,
        early: &[f64],
        late: &[S],
        u: &[f64],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        let clock = Jet::new(t, 1.0, 0.0);
        Evaluation::within(|out| self.evaluate_parts::<f64, _, _>(t, &clock, early, late, u, &[], dx, out))
    }
    fn rates_in_numbers(&self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        self.rates(t, x, u, dx)
    }
    fn rates_in_early(&self, t: f64, x: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        self.rates(Early::from(t), x, u, dx)
    }
    fn rates_in_moving(&self, t: f64, x: &[Early], u: &[Early], dx: &mut [Early]) -> Result<(), Fault> {
        let (t, (early, air)) = (Early::from(t), x.split_at(self.layout.aero));
        let clock = Jet::new(t, Early::ONE, Early::ZERO);
        Evaluation::within(|out| self.evaluate_parts::<f64, _, _>(t, &clock, early, air, u, &[], dx, out))
    }
    fn rates_about(
        &self,
        known: &Known,
        places: bool,
        at: PartsInEarly<'_>,
        dx: [&mut [Early]; 2],
    ) -> Result<(), Fault> {
        match places {
            true => self.balanced_rates::<Early>(known, at, dx),
            false => self.balanced_rates::<f64>(known, at, dx),
        }
    }
    fn rates_in_late(
        &self,
        t: f64,
        early: &[f64],
        late: &[Late],
        u: &[f64],
        dx: &mut [Late],
    ) -> Result<(), Fault> {
        self.rates_by_late(t, early, late, u, dx)
    }
    #[cfg(feature = "lanes")]
    fn rates_in_double4(
        &self,
        t: Double4,
        x: &[Double4],
        u: &[Double4],
        dx: &mut [Double4],
    ) -> Result<(), Fault> {
        self.state_rates(t, x, u, dx)
    }
    #[cfg(feature = "lanes")]
    fn rates_in_single8(
        &self,
        t: Single8,
        x: &[Single8],
        u: &[Single8],
        dx: &mut [Single8],
    ) -> Result<(), Fault> {
        self.state_rates(t, x, u, dx)
    }
}

impl<P: Scalar> Robot<P> {
    /// dx/dt at (t, x, u) into `dx`, as [`Plant::rates`], of a robot whose numbers may carry derivatives.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    pub fn state_rates<S: Scalar + Meets<P>>(
        &self,
        t: S,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        self.rates_by_clock(t, &Jet::new(t, S::ONE, S::ZERO), x, u, dx)
    }

    /// Rates and all that led to them.
    #[inline(always)]
    pub(super) fn evaluate<S: Scalar + Meets<P>>(
        &self,
        t: S,
        x: &[S],
        u: &[S],
        beyond: &[Wrench<f64>],
        dx: &mut [S],
        out: &mut Evaluation<S>,
    ) -> Result<(), Fault> {
        let (early, air) = x.split_at(self.layout.aero);
        self.evaluate_parts::<S, _, _>(t, &Jet::new(t, S::ONE, S::ZERO), early, air, u, beyond, dx, out)
    }

    /// Rates at the time `t` of a robot whose gait is at the time `clock` (s): its crank may run faster or slower than by the
    /// gait's frequency, and may carry derivatives by its pace.
    ///
    /// # Errors
    /// The [`Fault`] that makes the model unusable there.
    #[inline(never)]
    pub fn rates_by_clock<S: Scalar + Meets<P>>(
        &self,
        t: S,
        clock: &Jet<S>,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<(), Fault> {
        let (early, air) = x.split_at(self.layout.aero);
        Evaluation::within(|out| self.evaluate_parts::<S, _, _>(t, clock, early, air, u, &[], dx, out))
    }

    /// The same, given the states of body and structure and those of the air, under the loads `beyond` of links and body; places
    /// in B carry the derivatives of `K` alone.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "time, state and inputs in their parts")]
    fn evaluate_parts<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        t: G,
        clock: &Jet<G>,
        x: &[G],
        air: &[S],
        u: &[G],
        beyond: &[Wrench<f64>],
        dx: &mut [S],
        out: &mut Evaluation<G, S>,
    ) -> Result<(), Fault> {
        let l = &self.layout;
        let structure = &x[l.structure..];
        let mut mass = [[G::ZERO; 6]; 6];
        let inertia = InstantInertia::Summed(&mut mass);
        let (body, setting) = self.instant((t, clock), x, u, (beyond, inertia), dx, out)?;
        let InstantSetting { attitude, wind, wind_dot, gravity, .. } = setting;
        let Evaluation { links, base, carriers, coordinates, second_rates, .. } = out;
        let mut carriers = Carriers::within(carriers, coordinates);
        carriers.follow(base, &self.carriers, links, [wind_dot, gravity]);
        carriers.ground = self.ground_below(attitude, x[l.position + 2]);
        let states = (structure, air, &mut dx[l.aero..]);
        let acceleration = self
            .acceleration::<K, _, _>(
                (&mut mass, body, beyond),
                &carriers,
                links,
                (wind, gravity),
                states,
                second_rates,
            )
            .ok_or(Fault::MassMatrix { time: t.value() })?;

        attitude.times(Vec3::from_slice(&acceleration)).store(&mut dx[l.velocity..]);
        Vec3::from_slice(&acceleration[3..]).store(&mut dx[l.rate..]);
        self.store_coordinate_rates(structure, second_rates, &mut dx[l.structure..l.aero]);
        (out.attitude, out.acceleration) = (attitude, acceleration);
        Ok(())
    }

    /// The wrench on the body of all but the air on the surfaces, with what led to it; `dx` gets the rates that follow from the state alone.
    #[inline(always)]
    pub(super) fn instant<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        (t, clock): (G, &Jet<G>),
        x: &[G],
        u: &[G],
        (beyond, inertia): (&[Wrench<f64>], InstantInertia<'_, G>),
        dx: &mut [S],
        out: &mut Evaluation<G, S>,
    ) -> Result<InstantForces<G>, Fault> {
        let l = &self.layout;
        let structure = &x[l.structure..];
        let Evaluation { joints, ratios, .. } = out;
        self.joints(clock, structure, u, &mut dx[l.structure..l.joints], joints, ratios)?;
        let setting = self.set_out((t, clock), x, u, dx, out);
        let Evaluation { joints, links, base, coordinates, ratios, .. } = out;
        let tree = &self.mechanism.tree;
        let (inertial, first_moment) = match inertia {
            InstantInertia::Summed(mass) => tree.inertia_bias_and_moment(base.rate, links, mass),
            InstantInertia::Held(held) => {
                let held: ArrayVec<G, MAX_DEGREES> = held.iter().map(|a| G::from(*a)).collect();
                self.let_go(joints, links, coordinates, ratios, &held[6..]);
                let field = BaseAcceleration::from_slice(&held);
                base.accelerate(&field);
                links.iter_mut().for_each(|link| link.accelerate(&field));
                tree.inertial_and_moment(base.rate, &field, links)
            }
        };
        let mut body = tree.weight(setting.gravity, first_moment) + setting.drag + -inertial;
        if !self.thrusters.is_empty() {
            body += self.thrust(structure);
        }
        for load in beyond {
            body += of_numbers(load);
        }
        if let Some(perch) = &self.perch {
            let position = Vec3::from_slice(&x[l.position..]);
            let velocity = Vec3::from_slice(&x[l.velocity..]);
            body += perch.load(&BodyPose { position, attitude: setting.attitude, velocity, rate: base.rate });
        }
        Ok((body, setting))
    }

    /// Puts the links of the joints in `out` beside them and the rates that follow from the state alone into `dx`.
    #[inline(never)]
    fn set_out<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        (t, clock): (G, &Jet<G>),
        x: &[G],
        u: &[G],
        dx: &mut [S],
        out: &mut Evaluation<G, S>,
    ) -> InstantSetting<G> {
        let l = &self.layout;
        let q = Quat::from_wxyz(&x[l.attitude..]);
        let attitude = q.matrix();
        let v_w = Vec3::from_slice(&x[l.velocity..]);
        let w = Vec3::from_slice(&x[l.rate..]);
        let v = attitude.transpose_mul(v_w);

        let structure = &x[l.structure..];
        let Evaluation { joints, links, base, coordinates, ratios, .. } = out;
        self.links(joints, v, w, links);
        *base = LinkMotion::base(v, w);
        self.coordinates(links, ratios, coordinates);

        let (wind, wind_dot) = self.wind(t, attitude);
        v_w.lifted().store(&mut dx[l.position..]);
        let mut turning = [G::ZERO; 4];
        q.rate(w).store_wxyz(&mut turning);
        lift(&turning, &mut dx[l.attitude..]);
        let drag = self.body_load(clock, (structure, u), (v - wind, w));
        InstantSetting { attitude, wind, wind_dot, gravity: self.gravity(attitude), drag }
    }

    /// Acceleration of the body origin and angular acceleration in B under the wrench `body` of all but the air and the
    /// air's; `mass` is that of body and links, `beyond` the part of the wrench that links bear. Fills the rates of the air, the
    /// last of `states`, and the second rates of the coordinates. `None` when the mass matrix is not positive definite.
    #[inline(always)]
    fn acceleration<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        (mass, body, beyond): (&mut [[G; 6]; 6], Wrench<G>, &[Wrench<f64>]),
        carriers: &Carriers<G>,
        links: &[LinkMotion<G>],
        (wind, g_b): (Vec3<G>, Vec3<G>),
        (structure, air, air_rates): (&[G], &[S], &mut [S]),
        second_rates: &mut ArrayVec<S, MAX_COORDINATES>,
    ) -> Option<[S; 6]> {
        let coordinates = carriers.coordinates;
        let follows = self.covering.aero.follow_impulses();
        if coordinates.count() == 0 && !follows {
            let (load, ref added) = self.covering.sum::<K, _, _>(carriers, wind, air, air_rates, None);
            let net = load + body.lifted();
            add(mass, added);
            let mut rhs = [S::ZERO; 6];
            net.force.store(&mut rhs);
            net.moment.store(&mut rhs[3..]);
            return solve_symmetric_leading(6, mass, rhs);
        }
        let mut system = BodySystem::new(coordinates.count());
        let BodySystem { mass: matrix, forces, .. } = &mut system;
        self.mechanism.tree.coordinate_inertia(links, g_b, coordinates, Some(matrix), forces);
        self.add_efforts(structure, G::ONE, &mut system.forces);
        self.add_inertances(&mut system.mass);
        self.add_beyond(beyond, carriers, &mut system.forces);
        let mut impulses = ImpulseRates::none();
        let lacking = follows.then_some(&mut impulses);
        let mut net = system.add_air::<K, P>(self, carriers, (wind, lacking), air, air_rates);
        add(&mut system.mass, mass);
        net += body.lifted();
        let degrees = system.solve(Some(net), coordinates.count())?;
        impulses.complete(&degrees[..6 + coordinates.count()], air_rates);
        second_rates.extend(degrees[6..][..coordinates.count()].iter().copied());
        Some(std::array::from_fn(|i| degrees[i]))
    }

    /// Adds the forces of the air on the coordinates of `carriers` to `forces`; returns its wrench (N and N m, B) on the whole and the added
    /// mass. What is `wanted` beside: the mass matrix of the coordinates and what the rates of followed impulses lack.
    #[inline(always)]
    pub(super) fn bear_air<K: Scalar + Meets<P>, G: Over<K> + Meets<P>, S: Over<G> + Over<K> + Meets<P>>(
        &self,
        carriers: &Carriers<G>,
        wind: Vec3<G>,
        (x, dx): (&[S], &mut [S]),
        (mass, impulses): (Option<&mut [[G; MAX_DEGREES]]>, Option<&mut ImpulseRates<G>>),
        forces: &mut [S],
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        // Nobody asks what links bear.
        if carriers.coordinates.count() == 0 && impulses.is_none() {
            return self.covering.sum::<K, _, _>(carriers, wind, x, dx, None);
        }
        let links = self.mechanism.tree.links();
        let mut external = External::<S>::new();
        external.extend(std::iter::repeat_n(Wrench::ZERO, links + 1));
        let coupled = Some(MechanismLoads { mass, external: &mut external, impulses });
        let sum = self.covering.sum::<K, _, _>(carriers, wind, x, dx, coupled);
        for (link, load) in external.iter().enumerate().take(links) {
            carriers.project(link, load, forces);
        }
        sum
    }

    /// Motion of the links with the joints at `joints`, the body moving with `v` and `w` in B.
    #[inline(always)]
    pub(super) fn links<S: Scalar + Meets<P>>(
        &self,
        joints: &Joints<S>,
        v: Vec3<S>,
        w: Vec3<S>,
        links: &mut Links<S>,
    ) {
        // What an evaluation before has left is written over.
        links.truncate(joints.len());
        let lacking = joints.len() - links.len();
        append_copies(links, LinkMotion::REST, lacking);
        self.mechanism.tree.motions(joints, v, w, links);
    }

    /// How elastic joints and a crank under a motor move the links.
    #[inline]
    pub(super) fn coordinates<S: Scalar + Meets<P>>(
        &self,
        links: &[LinkMotion<S>],
        ratios: &Ratios<S>,
        coordinates: &mut Coordinates<S>,
    ) {
        for (c, &joint) in self.mechanism.coordinates.iter().enumerate() {
            coordinates.add_joint(c, &self.mechanism.tree, joint, S::ONE, links);
        }
        if self.motor.is_some() {
            self.add_crank(links, ratios, coordinates);
        }
        self.add_loaded(links, ratios, coordinates);
    }

    /// Adds what the loads `beyond` on the links are along the coordinates.
    pub(super) fn add_beyond<G: Scalar>(
        &self,
        beyond: &[Wrench<f64>],
        carriers: &Carriers<G>,
        forces: &mut [G],
    ) {
        for (link, load) in beyond.iter().enumerate().take(self.mechanism.tree.links()) {
            carriers.project(link, &of_numbers::<G>(load), forces);
        }
    }

    /// Adds the efforts of springs, dampers and motor to the `forces` on the coordinates; `structure` as for [`Robot::joints`],
    /// `supply` the share of the voltage that the motor receives.
    pub(super) fn add_efforts<G: Scalar + Meets<P>>(&self, structure: &[G], supply: G, forces: &mut [G]) {
        let (count, states) = (self.degrees(), &structure[2 * self.elements.len()..]);
        let displaced = self.elements.iter().any(|element| matches!(element.moves[0], Displaced::Rest(_)));
        for (c, spring) in self.mechanism.springs().enumerate() {
            let moved = if displaced { self.rest_displaced(c, structure) } else { G::ZERO };
            forces[c] += spring.effort(states[c], states[count + c], moved);
        }
        if let Some(motor) = &self.motor {
            forces[count - 1] += motor.crank_torque(states[2 * count - 1], supply);
        }
    }

    /// Adds the inertances of springs and the inertia of the motor to the mass matrix of body and coordinates.
    pub(super) fn add_inertances<G: Scalar + Meets<P>>(&self, mass: &mut [[G; MAX_DEGREES]]) {
        for ([i, j], inertance) in self.inertances() {
            mass[6 + i][6 + j] += G::from(inertance);
        }
        if let Some(motor) = &self.motor {
            let crank = 5 + self.degrees();
            mass[crank][crank] += G::from(motor.inertia());
        }
    }

    /// Rates of the coordinates and their rates, and of the rates of elements with an inertia, into `dx`, which holds those of the whole
    /// `structure`, as for [`Robot::joints`].
    pub(super) fn store_coordinate_rates<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        structure: &[G],
        second_rates: &[S],
        dx: &mut [S],
    ) {
        let (elements, count) = (self.elements.len(), self.degrees());
        for (loaded, rate) in self.loaded.iter().zip(&second_rates[count..]) {
            dx[elements + loaded.element] = *rate;
        }
        let dx = &mut dx[2 * elements..];
        lift(&structure[2 * elements + count..][..count], dx);
        dx[count..2 * count].copy_from_slice(&second_rates[..count]);
    }

    /// Velocity and acceleration of the air, resolved in B.
    #[inline]
    pub(super) fn wind<S: Scalar + Meets<P>>(&self, t: S, attitude: Mat3<S>) -> (Vec3<S>, Vec3<S>) {
        let (velocity, acceleration) = self.wind.at(t);
        (attitude.transpose_mul(velocity), attitude.transpose_mul(acceleration))
    }

    /// The plane that the air does not cross as the body sees it, its origin at the height `z` m in W.
    #[inline]
    pub(super) fn ground_below<S: Scalar>(&self, attitude: Mat3<S>, z: S) -> Option<Ground<S>> {
        let up = || attitude.transpose_mul(Vec3::new(S::ZERO, S::ZERO, S::ONE));
        self.ground.map(|height| Ground { normal: up(), offset: -z + height })
    }

    /// Gravity in B, m/s2.
    #[inline]
    pub(super) fn gravity<S: Scalar>(&self, attitude: Mat3<S>) -> Vec3<S> {
        attitude.transpose_mul(Vec3::new(S::ZERO, S::ZERO, S::from(-GRAVITY)))
    }

    /// Drag of the body at its origin, F_i = -rho/2 A_i |v_i| v_i along each body
    /// axis; `v` is the velocity against the air, in B.
    #[inline]
    pub(super) fn body_drag<S: Scalar + Meets<P>>(&self, v: Vec3<S>) -> Wrench<S> {
        let mut drag = Wrench::ZERO;
        for i in 0..3 {
            let scale = self.density * self.drag_area[i] * -0.5;
            drag.force[i] = v[i] * v[i].smooth_abs(DRAG_WIDTH) * scale;
        }
        drag
    }
}

/// A load in another type.
pub(super) fn of_numbers<S: Scalar>(load: &Wrench<f64>) -> Wrench<S> {
    Wrench { force: load.force.each(S::from), moment: load.moment.each(S::from) }
}

/// Speed below which the body's drag is rounded off, m/s.
const DRAG_WIDTH: f64 = 1e-3;

/// Adds the leading 6 x 6 block.
#[inline]
pub(super) fn add<S: Scalar, const N: usize>(mass: &mut [[S; N]], block: &[[S; 6]; 6]) {
    for i in 0..6 {
        for j in 0..6 {
            mass[i][j] += block[i][j];
        }
    }
}

/// Mass matrix and forces of body and coordinates.
pub(super) struct BodySystem<G: Scalar, S: Over<G>> {
    pub mass: DegreeMatrix<G>,
    /// Forces on the coordinates that the states of the air do not enter.
    pub forces: [G; MAX_COORDINATES],
    /// Forces of the air on the coordinates.
    pub of_air: [S; MAX_COORDINATES],
}

impl<G: Scalar, S: Over<G>> BodySystem<G, S> {
    /// Of body and `count` coordinates, all zero.
    #[inline(always)]
    pub fn new(count: usize) -> Self {
        let mut mass = DegreeMatrix::new();
        append_copies(&mut mass, [G::ZERO; MAX_DEGREES], 6 + count);
        Self { mass, forces: [G::ZERO; MAX_COORDINATES], of_air: [S::ZERO; MAX_COORDINATES] }
    }

    /// Adds the added mass of all surfaces and their forces on the coordinates of `carriers`; returns their wrench (N and N m,
    /// B) on the whole. `wind` comes with room for what the rates of followed impulses lack.
    pub fn add_air<K: Scalar + Meets<P>, P: Scalar>(
        &mut self,
        robot: &Robot<P>,
        carriers: &Carriers<G>,
        (wind, impulses): (Vec3<G>, Option<&mut ImpulseRates<G>>),
        x: &[S],
        dx: &mut [S],
    ) -> Wrench<S>
    where
        G: Over<K> + Meets<P>,
        S: Over<K> + Meets<P>,
    {
        let wanted = (Some(&mut self.mass[..]), impulses);
        let (net, ref added) = robot.bear_air::<K, G, S>(carriers, wind, (x, dx), wanted, &mut self.of_air);
        add(&mut self.mass, added);
        net
    }

    /// Accelerations (m/s2 and rad/s2, B) of the body under the wrench `net` (all of them zero where it is imposed: `None`) and
    /// second rates of `count` coordinates. `None` when the matrix is not positive definite.
    pub fn solve(&mut self, net: Option<Wrench<S>>, count: usize) -> Option<[S; MAX_DEGREES]> {
        let mut rhs = [S::ZERO; MAX_DEGREES];
        match net {
            Some(net) => {
                net.force.store(&mut rhs);
                net.moment.store(&mut rhs[3..]);
            }
            None => {
                for i in 0..6 {
                    for j in 0..6 + count {
                        (self.mass[i][j], self.mass[j][i]) = (G::ZERO, G::ZERO);
                    }
                    self.mass[i][i] = G::ONE;
                }
            }
        }
        for c in 0..count {
            rhs[6 + c] = self.of_air[c] + self.forces[c];
        }
        solve_symmetric_leading(6 + count, &mut self.mass, rhs)
    }
}
