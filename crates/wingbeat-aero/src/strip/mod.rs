//! Preset `full`: a strip model with three-dimensional, delayed wash.
//!
//! Every strip carries two or three lags of the wash on its chord and one or two of the wash of
//! the wake. The potential jump on the chord, not only the circulation, induces
//! a three-dimensional wash, which makes lift and added mass drop together at
//! low aspect ratio; flow is tangent at 3/4 chord under the true horseshoes of
//! the folded, moving wing. Valid for attached flow, aspect ratio 3 and more.

mod bent;
mod carried;
mod carried_place;
mod constants;
mod cores;
mod flap;
mod grid;
mod influence;
mod late;
mod loads;
mod membrane;
mod motion;
mod mutual;
mod reach;
mod response;
mod settings;
mod side_edge;
mod slopes;
mod tables;

pub use bent::SkinSheet;
pub use constants::Lags;
pub use grid::{AngleMap, StripSpacing, spacing};
pub use late::ByStates;
pub(crate) use late::{row, without_slopes};
pub use membrane::MembraneScales;
pub(super) use mutual::{ARRIVAL_LAGS, Others, Source, Vortices};
pub use settings::{LagSet, StripSettings};

use crate::law::Polar;
use crate::section::ZeroLift;
use crate::{
    Coupling, LiftLaw, Loads, MAX_STRIPS, Planform, SectionMotion, SectionSettings, Sections, SurfaceNumbers,
    Wrench,
};
use cores::Cores;
use flap::Hinges;
use grid::StripGrid;
use influence::{Beside, Matrix, StripColumn, TargetPlaces, Targets, Wash, invert, lanes, multiply, plain};
use membrane::{Camber, Membrane};
use motion::{Edges, Strips, Wakes};
use response::{FullSpread, StripResponse};
use settings::SpanForce;
use tables::Tables;
use wingbeat_math::{Error, Meets, Over, Scalar, Vec3, kept};
use wingbeat_ocp::plant::Channel;

/// The strip model of a wing. Sections are the edges between strips.
#[derive(Clone, Debug)]
pub struct StripModel<P: Scalar = f64> {
    settings: StripSettings,
    grid: StripGrid<P>,
    zero_lift: ZeroLift<P>,
    polar: Polar<P>,
    numbers: SurfaceNumbers<P>,
    lags: &'static Lags,
    /// Smoothing speed, m/s.
    floor: f64,
    tables: Tables<P>,
    cores: Cores<P>,
    membrane: Option<Membrane<P>>,
    /// Whether the shapes of the membrane are given with their rates, and not found.
    shapes_given: bool,
    hinges: Option<Hinges>,
    /// Time of the inertance of its springs, s: [`StripModel::set_inertance`].
    inertance: f64,
    span_force: SpanForce,
}

/// What the strips know of the air at one instant, whatever the lags hold; what places alone decide is in `K`.
struct StripFlow<K: Scalar, S: Scalar, const N: usize> {
    strips: Strips<K, S, N>,
    /// Wash of horseshoes without the own two-dimensional part, 1/m.
    remainder: Matrix<S, N>,
    /// Half the wash far behind, 1/m.
    far: Matrix<S, N>,
    /// Inverse of A0 = 1 - doublet diag(d): the wash which motion leaves on the chord.
    relief: Matrix<K, N>,
    /// Wash that drives the carried air, m/s, and its rate, m/s2, where it is not taken at 1/2 chord; else not written.
    placed: [StripColumn<S, N>; 2],
    /// What is left of the wash that drives the carried air, m/s.
    half_left: StripColumn<S, N>,
    /// Normal speed left by a unit normal speed of the whole wing.
    unit_left: StripColumn<K, N>,
    /// Normal impulse of the air by the motion alone, N s, and its rate, N.
    impulse: StripColumn<S, N>,
    impulse_rate: StripColumn<S, N>,
    /// Added-mass matrix on [acceleration; angular acceleration] about the body origin.
    added_mass: [[K; 6]; 6],
    /// How much sooner the wash of the wakes comes than on the flat wing.
    sooner: K,
    /// Acceleration of gravity that turns flaps, m/s2 in B; not written without one.
    gravity: Vec3<S>,
}

/// Where an evaluation writes what the strips know of the air. A thread keeps it, so that it is not set to zero each time: each
/// evaluation writes all that it reads.
struct Room<K: Scalar, S: Scalar, const N: usize> {
    /// Number of strips that it was last used for: all is zero beyond them.
    strips: usize,
    flow: StripFlow<K, S, N>,
    edges: Edges<K, S, N>,
    wakes: Wakes<K, S, N>,
    places: TargetPlaces<K, N>,
    beside: Beside<K, S, N>,
}

/// What is wanted beside the sum.
pub(super) struct Wanted<'a, G: Scalar, S: Scalar> {
    /// Loads by strip and source.
    pub loads: Option<&'a mut Loads<S>>,
    /// What the coordinates of the sections take.
    pub coupling: Option<Coupling<'a, G, S>>,
}

impl StripModel {
    /// Lays strips on the planform.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a setting has no physical meaning or there are too few strips
    /// for the hinges.
    pub fn new(planform: &Planform, settings: StripSettings) -> Result<Self, Error> {
        settings.check()?;
        let outline = Some(planform.clone());
        let [hinges, webs] = [&settings.hinge_arcs_m, &settings.webs_m].map(Vec::clone);
        Self::laid(SurfaceNumbers { outline, hinges, webs, ..settings.numbers() }, settings)
    }
}

impl<P: Scalar> StripModel<P> {
    #[inline(never)]
    fn laid(numbers: SurfaceNumbers<P>, settings: StripSettings) -> Result<Self, Error> {
        let Some(planform) = &numbers.outline else {
            return Err(Error::invalid("planform", "none", "an outline"));
        };
        let lags = settings.lags.lags();
        let whole_chord = settings.flap.is_none() && settings.membrane.is_none();
        let grid = StripGrid::new(planform, settings.strips, &numbers.bounds(), lags.fills && whole_chord)?;
        let whole =
            numbers.hinges.iter().all(|arc| arc.is_zero()) && grid.covered.iter().all(|covered| *covered);
        if settings.side_edges && !(whole && settings.flap.is_none() && settings.strips > 1) {
            let allowed = "false of a wing with a hinge beyond its root, a flap, a gap or one strip: this was derived of whole flat wings";
            return Err(Error::invalid("side_edges", true, allowed));
        }
        let span_force = settings.span_force()?;
        let ribs = settings.membrane.iter().flat_map(|membrane| &membrane.ribs_m);
        let ribs: Vec<f64> = ribs.copied().collect();
        let skin = |numbers| Membrane::new(numbers, &ribs, planform, &grid);
        let from_root: Vec<P> = grid.control_arcs.iter().map(|s| planform.from_root(*s)).collect();
        let hinges = |spec| Hinges::new(spec, &from_root, &grid.covered);
        let hinges = settings.flap.as_ref().map(hinges);
        if let (Some(0), Some(flap)) = (hinges.as_ref().map(Hinges::count), &settings.flap) {
            let allowed = "below the arc of the middle of a strip: no strip has a flap";
            return Err(
                Error::invalid("flap.from_arc_m", flap.from_arc_m, allowed).against(["flap.to_arc_m"])
            );
        }
        Ok(Self {
            hinges,
            membrane: numbers.membrane.as_ref().map(skin).transpose()?,
            shapes_given: false,
            inertance: 0.0,
            span_force,
            tables: Tables::new(&grid, &settings, &numbers, lags),
            cores: Cores::new(&grid, settings.vortex_core),
            floor: settings.regularisation_m_s,
            zero_lift: ZeroLift::new(numbers.zero_lift_angle),
            polar: Polar::new(settings.section.law, &numbers, grid.aspect),
            numbers,
            lags,
            grid,
            settings,
        })
    }

    /// The same strips with other numbers than the settings say.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the strips do not fit the outline.
    #[inline(never)]
    pub fn with<Q: Scalar>(&self, numbers: &SurfaceNumbers<Q>) -> Result<StripModel<Q>, Error> {
        Ok(StripModel {
            shapes_given: self.shapes_given,
            inertance: self.inertance,
            ..StripModel::laid(numbers.clone(), self.settings.clone())?
        })
    }

    /// Gives its flaps the inertance of `time` s about their hinges, as joints on springs by `robot.inertance`.
    pub fn set_inertance(&mut self, time: f64) {
        self.inertance = time;
    }

    /// The same strips under another law.
    ///
    /// # Errors
    /// As [`with`](Self::with).
    pub fn under(&self, law: LiftLaw) -> Result<Self, Error> {
        let section = SectionSettings { law, ..self.settings.section };
        let settings = StripSettings { section, ..self.settings.clone() };
        let (shapes_given, inertance) = (self.shapes_given, self.inertance);
        Ok(Self { shapes_given, inertance, ..Self::laid(self.numbers.clone(), settings)? })
    }

    /// The numbers in use.
    pub fn numbers(&self) -> &SurfaceNumbers<P> {
        &self.numbers
    }
    /// The settings in use.
    pub fn settings(&self) -> &StripSettings {
        &self.settings
    }
    /// Number of strips.
    pub fn strips(&self) -> usize {
        self.settings.strips
    }
    /// False of a strip `i` in a gap of the planform.
    pub fn covers(&self, i: usize) -> bool {
        self.grid.covered[i]
    }
    /// Whether hinges lie too close for so many strips, so that widths jump there: see [`StripSpacing::crowded`].
    pub fn is_crowded(&self) -> bool {
        self.grid.crowded
    }
    /// Whether suction of edges bears along its span, and whether the impulse that turns does: `edge_suction` and `turning_impulse` as
    /// they were resolved, of which either may not be given.
    pub fn span_keys(&self) -> [bool; 2] {
        [SpanForce::Edges, SpanForce::Impulse].map(|force| self.span_force == force)
    }
    /// Whether the impulse of the circulation turns on a wing that has hinges and a trailing edge that is swept.
    pub fn turns_swept(&self) -> bool {
        let bent = |pair: &[(P, P)]| pair[0].1 != pair[1].1;
        self.span_force == SpanForce::Impulse
            && !self.settings.hinge_arcs_m.is_empty()
            && self.grid.outline.windows(2).any(bent)
    }
    /// Number of states: for each wash lag, then for each wake lag, for each state of the
    /// law, for the impulse where it is followed, for the camber of a membrane and for a flap blocks of one value per strip, left tip to
    /// right tip.
    pub fn states(&self) -> usize {
        let shapes = if self.membrane.is_some() { self.shape_states().len() } else { 0 };
        let turns = if self.hinges.is_some() { flap::BLOCKS } else { 0 };
        let blocks = usize::from(self.follows()) + shapes + turns;
        self.followed_states() + blocks * self.settings.strips
    }
    /// Whether the impulse of the carried air is followed by states.
    pub(super) fn follows(&self) -> bool {
        self.settings.folding_rates && self.settings.section.added_mass
    }
    /// Whether states begin with what the motion says.
    pub(super) fn settles(&self) -> bool {
        self.follows() || self.hinges.is_some()
    }
    /// Where the followed impulses begin.
    fn followed_states(&self) -> usize {
        self.law_states() + self.settings.strips * self.settings.section.law.states().len()
    }
    /// Where the states of the law begin.
    fn law_states(&self) -> usize {
        self.settings.strips * self.lags.states_per_strip()
    }
    /// Arc coordinates, m, of the sections wanted: the edges of the strips from left tip
    /// (positive) to right tip.
    pub fn arcs(&self) -> &[P] {
        &self.grid.arcs
    }
    /// Names and units of the states, in order.
    #[inline(never)]
    pub fn channels(&self) -> Vec<Channel> {
        let wash = (1..=self.lags.rate.len()).map(|k| (format!("wash_lag{k}"), "m/s"));
        let wake = (1..=self.lags.wake.len()).map(|k| (format!("wake_lag{k}"), "m2/s"));
        let law = self.settings.section.law.states().iter().map(|state| (state.name.to_owned(), state.unit));
        let followed = self.follows().then(|| ("impulse".to_owned(), "N s"));
        let camber = self
            .membrane
            .iter()
            .flat_map(|_| self.shape_states().iter().map(|(of, unit)| ((*of).to_owned(), *unit)));
        let turns = self.hinges.iter().flat_map(|_| flap::STATES.map(|(of, unit)| (of.to_owned(), unit)));
        wash.chain(wake)
            .chain(law)
            .chain(followed)
            .chain(camber)
            .chain(turns)
            .flat_map(|(name, unit)| {
                (0..self.strips()).map(move |i| Channel::free(format!("{name}_{i}"), unit, ""))
            })
            .collect()
    }
    /// Arc coordinates of the control sections, m.
    pub fn strip_arcs(&self) -> &[P] {
        &self.grid.control_arcs
    }
    /// Widths of the strips, m.
    pub fn widths(&self) -> &[P] {
        &self.grid.width
    }
    /// Chords of the control sections, m.
    pub fn chords(&self) -> &[P] {
        &self.grid.chord
    }

    /// Loads and state rates.
    ///
    /// `sections` are the edges in the order of [`arcs`](Self::arcs), `wind` the
    /// velocity of the air in B, `x` the states (m/s for wash lags, m2/s for wake
    /// lags, then those of the law), `dx` receives their rates. The accelerations of the sections leave out what the
    /// body's own acceleration adds: see [`Loads`].
    ///
    /// # Panics
    /// When a slice is shorter than `arcs()` or `states()` ask for.
    pub fn evaluate<S: Scalar + Meets<P>>(
        &self,
        sections: &[SectionMotion<S>],
        wind: Vec3<S>,
        x: &[S],
        dx: &mut [S],
        loads: &mut Loads<S>,
    ) {
        loads.clear();
        let wanted = Wanted { loads: Some(&mut *loads), coupling: None };
        (loads.wrench, loads.added_mass) =
            self.evaluate_among::<S, S, S>(&sections, wind, x, dx, None, wanted);
    }

    /// As [`evaluate`](Self::evaluate) for the sum alone: the wrench and the
    /// added-mass matrix. The lags may carry more derivatives than the motion. `coupling` receives
    /// what the coordinates of `sections` take.
    pub fn evaluate_sum<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        sections: &dyn Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        coupling: Option<Coupling<G, S>>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        self.evaluate_among::<G, G, S>(sections, wind, x, dx, None, Wanted { loads: None, coupling })
    }

    /// Place of the control section of strip `i` between its edges, 0 to 1.
    pub(super) fn fraction(&self, i: usize) -> P {
        self.grid.fraction[i]
    }

    /// Sum of the loads, and state rates, of the surface among others; writes the loads by strip behind the
    /// strips that `loads` holds. The places of the sections carry the derivatives of `K` alone. Chooses the width of the columns.
    pub(super) fn evaluate_among<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
    >(
        &self,
        sections: &dyn Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        others: Option<Others<'_, P, G, S>>,
        wanted: Wanted<'_, G, S>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        macro_rules! wide {
            ($($width:literal),*) => {
                match self.settings.strips {
                    $(0..=$width => self.evaluate_in::<G, G, S, $width>(sections, wind, x, dx, others, wanted),)*
                    _ => self.evaluate_in::<G, G, S, MAX_STRIPS>(sections, wind, x, dx, others, wanted),
                }
            };
        }
        // Columns of plain numbers are as wide as there are strips, in whole registers; of others only their room is.
        // The tests of this crate take one width, for which they are compiled in less time; those of `wingbeat` take the others.
        if const { cfg!(test) || S::RECORDED || !plain::<P>() } {
            self.evaluate_in::<G, G, S, MAX_STRIPS>(sections, wind, x, dx, others, wanted)
        } else if const { size_of::<K>() < size_of::<G>() } {
            // One copy of the code: what it spares matters less where there are many strips.
            match self.settings.strips {
                0..=16 => self.evaluate_in::<K, G, S, 16>(sections, wind, x, dx, others, wanted),
                _ => self.evaluate_in::<G, G, S, MAX_STRIPS>(sections, wind, x, dx, others, wanted),
            }
        } else if const { plain::<S>() } {
            wide!(8, 12, 16, 24)
        } else {
            wide!(16)
        }
    }

    /// The evaluation with columns of `N` lanes, of which `strips()` count.
    #[inline(never)]
    fn evaluate_in<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        sections: &dyn Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        others: Option<Others<'_, P, G, S>>,
        wanted: Wanted<'_, G, S>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        kept(
            || Box::new(Room::<K, G, N>::NEW),
            |room| self.evaluate_with(room, sections, wind, x, dx, others, wanted),
        )
    }

    /// The evaluation in a room.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "those of the evaluation and its room")]
    fn evaluate_with<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        room: &mut Room<K, G, N>,
        sections: &dyn Sections<G>,
        wind: Vec3<G>,
        x: &[S],
        dx: &mut [S],
        others: Option<Others<'_, P, G, S>>,
        wanted: Wanted<'_, G, S>,
    ) -> (Wrench<S>, [[G; 6]; 6]) {
        self.flow(sections, wind, room);
        let flow = &room.flow;
        let states = self.states();
        let Wanted { mut loads, coupling } = wanted;
        let foreign = others.map(|others| self.wash_of_others(&flow.strips, others));
        if let Some(loads) = loads.as_deref_mut() {
            self.note_others(foreign.as_ref(), loads);
        }
        let mut camber = Camber::none();
        camber.given = loads.as_ref().map(|_| S::ZERO);
        let (x, dx) = (&x[..states], &mut dx[..states]);
        let load = |response: &StripResponse<'_, S, N>, dx: &mut [S]| {
            if let Some(loads) = loads.as_deref_mut() {
                self.note_membrane(flow, response, (x, dx), loads);
                self.note_flaps(flow, x, loads);
            }
            let strips = coupling.map(|Coupling { mass, strips, impulses }| {
                if let Some(mass) = mass {
                    self.couple(flow, sections, mass);
                }
                if let (Some(rates), true) = (impulses, self.follows()) {
                    self.follow(flow, sections, rates);
                }
                strips
            });
            self.load_strips(flow, response, loads, strips)
        };
        let wrench = self.respond(flow, foreign.as_ref(), x, dx, &mut camber, &mut FullSpread, load);
        (wrench, lifted(&flow.added_mass))
    }

    /// See [`Aero::settle`](crate::Aero::settle).
    #[inline(never)]
    pub(super) fn settle<S: Scalar + Meets<P>>(
        &self,
        sections: &dyn Sections<S>,
        wind: Vec3<S>,
        x: &mut [S],
    ) {
        if !self.settles() {
            return;
        }
        let mut room = Room::<S, S, MAX_STRIPS>::NEW;
        self.flow(sections, wind, &mut room);
        if self.follows() {
            self.settle_impulse(&room.flow, x);
        }
        if self.hinges.is_some() {
            self.settle_flaps(&room.flow, x);
        }
    }

    /// Points, velocities and influence of the wing as it lies and moves now.
    ///
    /// R = horseshoe + 1/(pi c cos L_1/2) on the diagonal,
    /// K = beta (ring + own two-dimensional ring), A0 = 1 - K diag(d).
    ///
    /// Equation: aero.strip.remainder
    /// `R = horseshoe + own bound vortex, K = beta (ring + own ring), A0 = 1 - K diag(d)`
    /// Source: Weissinger 1947 (steady limit); doublet wash: own derivation, beta fitted to the lifting surface.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface_and_the_drag_of_their_wake`.
    #[inline(always)]
    fn flow<K: Scalar + Meets<P>, S: Over<K> + Meets<P>, const N: usize>(
        &self,
        sections: &dyn Sections<S>,
        wind: Vec3<S>,
        room: &mut Room<K, S, N>,
    ) {
        let (n, tables) = (self.settings.strips, &self.tables);
        if room.strips != n {
            *room = Room { strips: n, ..Room::NEW };
        }
        let Room { flow, edges, wakes, places, beside, .. } = room;
        flow.added_mass = [[K::ZERO; 6]; 6];
        if const { plain::<S>() } {
            edges.fill(sections, n);
            self.move_strips(edges, wind, &mut flow.strips);
            self.shed_wakes(edges, wind, wakes);
        } else {
            self.move_on(sections, wind, &mut flow.strips, wakes);
        }
        flow.sooner = self.sooner(wakes);
        let mut wash = Wash { ring: &mut flow.relief, horseshoe: &mut flow.remainder, far: &mut flow.far };
        Targets::new(&flow.strips, &self.cores, places).wash(wakes, n, beside, &mut wash);
        if !self.settings.wake_wash {
            flow.remainder = [[S::ZERO; N]; N];
            flow.far = [[S::ZERO; N]; N];
        }
        let beta = if self.settings.doublet_wash { self.lags.doublet } else { 0.0 };
        for j in 0..n {
            if self.settings.wake_wash {
                flow.remainder[j][j] = flow.remainder[j][j] + tables.own_bound[j];
            }
            let (doublet, scale) = (&mut flow.relief[j], tables.doublet[j] * -beta);
            let own = (doublet[j] + tables.own_ring[j]) * scale + 1.0;
            for i in 0..lanes::<K, N>(n) {
                doublet[i] *= scale;
            }
            doublet[j] = own;
        }
        invert(&mut flow.relief, n);
        flow.unit_left = multiply(&flow.relief, &[K::ONE; N], n);
        self.carry_air(flow, sections.complete());
        if self.hinges.is_some() {
            flow.gravity = sections.gravity();
            self.relieve(flow);
        }
    }
}

/// The matrix with more derivatives, all zero: written out, as a loop over what has just been written waits for it.
#[inline(always)]
fn lifted<K: Scalar, G: Over<K>>(matrix: &[[K; 6]; 6]) -> [[G; 6]; 6] {
    let row = |[a, b, c, d, e, f]: [K; 6]| [a.into(), b.into(), c.into(), d.into(), e.into(), f.into()];
    let [a, b, c, d, e, f] = *matrix;
    [row(a), row(b), row(c), row(d), row(e), row(f)]
}

impl<K: Scalar, S: Over<K>, const N: usize> Room<K, S, N> {
    /// Nothing is written yet.
    const NEW: Self = Self {
        strips: 0,
        flow: StripFlow::STILL,
        edges: Edges::ZERO,
        wakes: Wakes::ZERO,
        places: TargetPlaces::ZERO,
        beside: Beside::ZERO,
    };
}

impl<K: Scalar, S: Over<K>, const N: usize> StripFlow<K, S, N> {
    /// Nothing moves yet.
    const STILL: Self = {
        let (matrix, zero) = ([[S::ZERO; N]; N], [S::ZERO; N]);
        Self {
            strips: Strips::ZERO,
            remainder: matrix,
            far: matrix,
            relief: [[K::ZERO; N]; N],
            placed: [zero; 2],
            half_left: zero,
            unit_left: [K::ZERO; N],
            impulse: zero,
            impulse_rate: zero,
            added_mass: [[K::ZERO; 6]; 6],
            sooner: K::ONE,
            gravity: Vec3::ZERO,
        }
    };
}
