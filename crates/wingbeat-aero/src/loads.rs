//! Aerodynamic loads, named by source.

use super::MAX_STRIPS;
use arrayvec::ArrayVec;
use wingbeat_math::{Over, Scalar, Vec3, Wrench, append_copies};
use wingbeat_ocp::plant::MAX_DEGREES;

/// Where a load on a wing or a robot comes from: the one list of names of columns, sums and curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadSource {
    /// Lift of the bound and shed vorticity.
    Circulatory,
    /// Turning of that force by the wash of wake and lags.
    InducedDrag,
    /// Reaction of the accelerated air.
    AddedMass,
    /// Skin friction and separation of the wing.
    ProfileDrag,
    /// Drag of the body.
    BodyDrag,
    /// Weight.
    Gravity,
    /// Minus the rate of momentum of body and links.
    Inertia,
}

impl LoadSource {
    /// Sources of a strip's loads, in the order of [`StripLoads::parts`].
    pub const STRIP: [Self; 4] = [Self::Circulatory, Self::InducedDrag, Self::AddedMass, Self::ProfileDrag];
    /// All sources: those of the strips, then those of the rest of the robot.
    pub const ALL: [Self; 7] = [
        Self::Circulatory,
        Self::InducedDrag,
        Self::AddedMass,
        Self::ProfileDrag,
        Self::BodyDrag,
        Self::Gravity,
        Self::Inertia,
    ];

    /// Name as written in columns.
    pub fn name(self) -> &'static str {
        match self {
            Self::Circulatory => "circulatory",
            Self::InducedDrag => "induced_drag",
            Self::AddedMass => "added_mass",
            Self::ProfileDrag => "profile_drag",
            Self::BodyDrag => "body_drag",
            Self::Gravity => "gravity",
            Self::Inertia => "inertia",
        }
    }

    /// True for a force of the air.
    pub fn is_of_air(self) -> bool {
        !matches!(self, Self::Gravity | Self::Inertia)
    }
}

/// What a model's circulation per strip is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Circulation {
    /// The bound circulation.
    Bound,
    /// A sum of wash lags fitted to the loads, 25 % off the bound circulation at k = .5: no picture of the wake.
    LagSum,
}

impl Circulation {
    /// Name as written in columns.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bound => "circulation",
            Self::LagSum => "circulation_lag_sum",
        }
    }
}

/// Loads of one strip by source: forces in N, moments in N m about the body origin, in B.
#[derive(Clone, Copy, Debug, Default)]
pub struct StripLoads<S: Scalar> {
    /// Lift of the bound and shed vorticity, perpendicular to the wind the
    /// section meets by its own motion.
    pub circulatory: Wrench<S>,
    /// What the wash of wake and lags adds by turning that force: induced drag.
    pub induced_drag: Wrench<S>,
    /// Reaction of the accelerated air, with the section moment of pitching.
    pub added_mass: Wrench<S>,
    /// Skin friction and separation, along the wind.
    pub profile_drag: Wrench<S>,
}

impl<S: Scalar> StripLoads<S> {
    /// Sum over the sources, N and N m.
    pub fn total(&self) -> Wrench<S> {
        self.circulatory + self.induced_drag + self.added_mass + self.profile_drag
    }

    /// The loads, N and N m, in the order of [`LoadSource::STRIP`].
    pub fn parts(&self) -> [Wrench<S>; LoadSource::STRIP.len()] {
        [self.circulatory, self.induced_drag, self.added_mass, self.profile_drag]
    }

    /// The same with `rest` behind: body drag, gravity and inertia, in the order of [`LoadSource::ALL`].
    pub fn parts_with(&self, rest: [Wrench<S>; 3]) -> [Wrench<S>; LoadSource::ALL.len()] {
        let ([a, b, c, d], [e, f, g]) = (self.parts(), rest);
        [a, b, c, d, e, f, g]
    }
}

impl<S: Scalar> std::ops::AddAssign for StripLoads<S> {
    fn add_assign(&mut self, o: Self) {
        self.circulatory += o.circulatory;
        self.induced_drag += o.induced_drag;
        self.added_mass += o.added_mass;
        self.profile_drag += o.profile_drag;
    }
}

/// Forces in B that are parts of a source and that the sources do not tell apart, N.
#[derive(Clone, Copy, Debug, Default)]
pub struct ForceDetail<S: Scalar> {
    /// Leading-edge suction along the zero-lift line, part of the circulatory force.
    pub suction: Vec3<S>,
    /// Normal force of the leading-edge vortex of law `lev`, part of the circulatory force.
    pub vortex: Vec3<S>,
    /// What `cd90` gives: the normal force of separated flow, or under law `linear` the drag that grows with the square of
    /// the incidence's sine; part of the profile drag.
    pub plate: Vec3<S>,
}

impl<S: Scalar> ForceDetail<S> {
    /// Names of the parts as written in columns, in the order of [`parts`](Self::parts).
    pub const NAMES: [&'static str; 3] = ["suction", "vortex", "separated"];

    /// The parts, N, in B.
    pub fn parts(&self) -> [Vec3<S>; 3] {
        [self.suction, self.vortex, self.plate]
    }
}

impl<S: Scalar> std::ops::AddAssign for ForceDetail<S> {
    fn add_assign(&mut self, o: Self) {
        self.suction += o.suction;
        self.vortex += o.vortex;
        self.plate += o.plate;
    }
}

/// Energy of the membranes and flaps of all strips: over a time `given` is the growth of `stored` and what is `lost`.
#[derive(Clone, Copy, Debug, Default)]
pub struct MembraneWork<S: Scalar = f64> {
    /// Power of the loads on shapes and flaps, of their inertia too, W.
    pub given: S,
    /// Energy of the strains and springs, J.
    pub stored: S,
    /// Power that their own damping takes, W.
    pub lost: S,
    /// Momentum of their own mass by its rate against the chords, in B, N s.
    pub momentum: Vec3<S>,
}

/// What coordinates beyond the six of the body take from a surface.
#[derive(Debug)]
pub struct Coupling<'a, G: Scalar, S: Scalar> {
    /// Mass matrix (kg, kg m and kg m2, or per unit of a coordinate) on [acceleration of the body origin; angular acceleration;
    /// second rates of the coordinates]; its rows and columns 6.. grow by the added mass. None where nobody asks for that.
    pub mass: Option<&'a mut [[G; MAX_DEGREES]]>,
    /// Load of each strip about the body origin, in B, accelerations of body and coordinates left out, N and N m.
    pub strips: &'a mut [Wrench<S>],
    /// Where states follow the impulse of the air: what their rates lack.
    pub impulses: Option<&'a mut ImpulseRates<G>>,
}

/// How the rates of followed impulses fall with accelerations that the sections leave out: those of the body origin, angular
/// ones, and second rates of the coordinates.
#[derive(Clone, Debug, Default)]
pub struct ImpulseRates<G: Scalar> {
    /// Where the states of the surface at hand begin among all.
    pub(super) first_state: usize,
    pub(super) rows: ArrayVec<ImpulseRow<G>, MAX_STRIPS>,
}

/// The row of one state.
#[derive(Clone, Debug)]
pub(super) struct ImpulseRow<G> {
    pub state: usize,
    pub by: [G; MAX_DEGREES],
}

impl<G: Scalar> ImpulseRates<G> {
    /// None yet.
    pub const fn none() -> Self {
        Self { first_state: 0, rows: ArrayVec::new_const() }
    }

    /// The states that follow impulses, by their places among those of all surfaces, and how much the rate of each, N, falls with every
    /// acceleration: in N over the unit of the acceleration.
    pub fn rows(&self) -> impl Iterator<Item = (usize, &[G; MAX_DEGREES])> {
        self.rows.iter().map(|row| (row.state, &row.by))
    }

    /// Completes the rates `dx` of the states of all surfaces by the accelerations found, m/s2, rad/s2 and those of the
    /// coordinates.
    pub fn complete<S: Over<G>>(&self, accelerations: &[S], dx: &mut [S]) {
        for row in &self.rows {
            let mut lacking = S::ZERO;
            for (acceleration, by) in accelerations.iter().zip(row.by) {
                lacking = acceleration.fused(by, lacking);
            }
            dx[row.state] -= lacking;
        }
    }
}

/// Loads of the whole wing.
///
/// The body acceleration may still be unknown when the loads are computed:
/// with s = [acceleration of the body origin; angular acceleration] (inertial,
/// in B) beyond what the sections' accelerations hold, the true wrench is
/// `wrench - added_mass s`.
#[derive(Clone, Debug)]
pub struct Loads<S: Scalar> {
    /// Sum over strips and sources, N and N m, about the body origin in B.
    pub wrench: Wrench<S>,
    /// Added-mass matrix (kg, kg m and kg m2) on [acceleration; angular acceleration], symmetric, about the body origin, in B.
    pub added_mass: [[S; 6]; 6],
    /// Strips from left tip to right tip.
    pub strip: ArrayVec<StripLoads<S>, MAX_STRIPS>,
    /// Incidence that each strip meets, wash included, rad.
    pub incidence: ArrayVec<S, MAX_STRIPS>,
    /// Wash along the normal that each strip meets at 3/4 chord, m/s.
    pub wash: ArrayVec<S, MAX_STRIPS>,
    /// Height of a membrane above mid chord over the chord, of each strip.
    pub camber: ArrayVec<S, MAX_STRIPS>,
    /// Height over the chord of the shape that moves the bulge forward: see [`membrane_height`](crate::membrane_height).
    pub camber_forward: ArrayVec<S, MAX_STRIPS>,
    /// Wash along the normal by other surfaces at 3/4 chord of each strip, m/s; part of `wash`.
    pub wash_of_others: ArrayVec<S, MAX_STRIPS>,
    /// Circulation of each strip, m2/s; what it is worth says [`Circulation`].
    pub circulation: ArrayVec<S, MAX_STRIPS>,
    /// Share of each strip's flow that is separated.
    pub separated: ArrayVec<S, MAX_STRIPS>,
    /// Share of the linear leading-edge suction of each strip that the edge does not hold.
    pub suction_lost: ArrayVec<S, MAX_STRIPS>,
    /// Point at 1/4 chord of each control section, in the frame of the sections, m.
    pub quarter_chord: ArrayVec<Vec3<S>, MAX_STRIPS>,
    /// Angle of a flap of each strip, trailing edge down, rad.
    pub flap: ArrayVec<S, MAX_STRIPS>,
    /// Number of strips.
    pub strips: usize,
    /// What membranes and flaps get, hold and lose.
    pub membrane: MembraneWork<S>,
    /// Parts of the forces of each strip, where they are asked for: nothing but a record needs them.
    pub detail: Option<ArrayVec<ForceDetail<S>, MAX_STRIPS>>,
}

impl<S: Scalar> Default for Loads<S> {
    fn default() -> Self {
        Self {
            wrench: Wrench::ZERO,
            added_mass: [[S::ZERO; 6]; 6],
            strip: ArrayVec::new(),
            incidence: ArrayVec::new(),
            wash: ArrayVec::new(),
            camber: ArrayVec::new(),
            camber_forward: ArrayVec::new(),
            flap: ArrayVec::new(),
            wash_of_others: ArrayVec::new(),
            circulation: ArrayVec::new(),
            separated: ArrayVec::new(),
            suction_lost: ArrayVec::new(),
            quarter_chord: ArrayVec::new(),
            strips: 0,
            membrane: MembraneWork::default(),
            detail: None,
        }
    }
}

impl<S: Scalar> Loads<S> {
    /// No strips and no membranes yet.
    pub(super) fn clear(&mut self) {
        (self.strips, self.membrane) = (0, MembraneWork::default());
        self.strip.clear();
        self.quarter_chord.clear();
        self.of_strips().into_iter().for_each(ArrayVec::clear);
        self.detail.iter_mut().for_each(ArrayVec::clear);
    }

    /// The numbers of the strips.
    fn of_strips(&mut self) -> [&mut ArrayVec<S, MAX_STRIPS>; 9] {
        [
            &mut self.incidence,
            &mut self.wash,
            &mut self.camber,
            &mut self.camber_forward,
            &mut self.flap,
            &mut self.wash_of_others,
            &mut self.circulation,
            &mut self.separated,
            &mut self.suction_lost,
        ]
    }

    /// Makes room for `count` strips behind those that are there; returns the place of the first.
    pub(super) fn extend(&mut self, count: usize) -> usize {
        let first = self.strips;
        self.strips += count;
        append_copies(&mut self.strip, StripLoads::default(), count);
        append_copies(&mut self.quarter_chord, Vec3::ZERO, count);
        for of in self.of_strips() {
            append_copies(of, S::ZERO, count);
        }
        if let Some(detail) = &mut self.detail {
            append_copies(detail, ForceDetail::default(), count);
        }
        first
    }

    /// As [`extend`](Self::extend), of strips that do not give way and meet no others: what they have not is zero, and all else is to be
    /// pushed, strip after strip.
    pub(super) fn extend_rigid(&mut self, count: usize) {
        self.strips += count;
        for of in [&mut self.camber, &mut self.camber_forward, &mut self.flap, &mut self.wash_of_others] {
            append_copies(of, S::ZERO, count);
        }
    }

    /// Empty loads that are to tell the parts of the forces too, where they are large: on the heap.
    pub fn boxed() -> Box<Self> {
        let mut loads = Box::<Self>::default();
        loads.detail = Some(ArrayVec::new());
        loads
    }

    /// Sum of the parts over the strips, N, each times its weight (1 beyond the end of `weights`); zero where they were not
    /// asked for.
    pub fn detail_sum(&self, weights: &[S]) -> ForceDetail<S> {
        let mut sum = ForceDetail::default();
        let weight = |i: usize| weights.get(i).copied().unwrap_or(S::ONE);
        for (i, part) in self.detail.iter().flat_map(|detail| &detail[..self.strips]).enumerate() {
            let of = |force: Vec3<S>| force * weight(i);
            sum += ForceDetail { suction: of(part.suction), vortex: of(part.vortex), plate: of(part.plate) };
        }
        sum
    }

    /// Sum over strips by source.
    pub fn by_source(&self) -> StripLoads<S> {
        let mut sum = StripLoads::default();
        self.strip[..self.strips].iter().for_each(|strip| sum += *strip);
        sum
    }
}
