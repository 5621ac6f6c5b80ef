//! The membrane of the strips: camber by the pressure difference against a tension that grows with strain.
//!
//! Above the chord of a strip, x = c (1 - cos t)/2, stands z = sin^2 t (h_1 + h_2 cos t): the parabola, exact under an even
//! pressure, and the shape that moves the bulge forward. States are both over the chord. The parabola feels the inertia of the membrane
//! and of the air that it carries within the membrane's own damping time, the second shape none: the frequency with that air has to lie
//! far above that of the motion, which [`StripModel::membrane_scales`] tells.

mod reaction;
mod sheet;

use super::{StripFlow, StripModel};
use crate::MAX_STRIPS;
use arrayvec::ArrayVec;
use sheet::ARC;
pub use sheet::MembraneScales;
pub(super) use sheet::{MODES, Membrane, Shapes};
use wingbeat_math::{Meets, Over, Scalar, append_copies};

/// What each strip carries for it: the heights over the chord, the momentum that the parabola feels and the rate of its height, as
/// followed.
const STATES: [(&str, &str); MODES + 2] =
    [("camber", ""), ("camber_forward", ""), ("camber_momentum", "N s"), ("camber_rate", "m/s")];
/// The same where the shapes are given: their heights with their rates, and the rate as followed.
const GIVEN: [(&str, &str); 2 * MODES + 1] = [
    ("camber", ""),
    ("camber_forward", ""),
    ("rate_of_camber", "1/s"),
    ("rate_of_camber_forward", "1/s"),
    ("camber_rate", "m/s"),
];

/// What the camber does on each strip, of a membrane or a flap; columns end with the last strip that is computed, and are empty without.
pub(super) struct Camber<'x, S: Scalar, const N: usize> {
    /// Heights over the chord.
    pub of_chord: Shapes<&'x [S]>,
    /// Nose-up couple about the quarter chord, N m.
    pub couple: ArrayVec<S, N>,
    /// Couple of the weight of a flap about the chord, N m.
    pub about_chord: ArrayVec<S, N>,
    /// Lift wash without what the slopes add: the wash of the flat chord, m/s.
    pub flat: ArrayVec<S, N>,
    /// What the slope at the leading edge takes of that wash there, m/s.
    pub nose: ArrayVec<S, N>,
    /// Rate of the parabola's height as followed, m/s, and its rate, m/s2.
    pub followed: [ArrayVec<S, N>; 2],
    /// Impulse of the air by the slope of the second shape, or by a flap, N s, and its rate, N.
    pub slope: [ArrayVec<S, N>; 2],
    /// Power of the loads on the shapes, W; none where it is not wanted.
    pub given: Option<S>,
}

impl<S: Scalar, const N: usize> Camber<'_, S, N> {
    /// Fills the columns with zeros of `count` lanes.
    pub fn open(&mut self, count: usize) {
        let Self { couple, about_chord, flat, nose, followed, slope, .. } = self;
        let moving = followed.iter_mut().chain(slope.iter_mut());
        for column in [couple, about_chord, flat, nose].into_iter().chain(moving) {
            append_copies(column, S::ZERO, count);
        }
    }

    /// That of a rigid surface. Columns are not filled and not moved: with derivatives they are large.
    #[inline(always)]
    pub fn none() -> Self {
        let empty = || [ArrayVec::new(), ArrayVec::new()];
        let ([couple, flat], [nose, about_chord]) = (empty(), empty());
        Self {
            of_chord: [&[]; MODES],
            couple,
            about_chord,
            flat,
            nose,
            followed: empty(),
            slope: empty(),
            given: None,
        }
    }
}

/// What a strip's membrane meets: as [`Strips`](super::motion::Strips), with the impulse of the air by the motion.
#[derive(Clone, Copy)]
pub(super) struct SectionAir<G: Scalar> {
    along: G,
    wash_half: G,
    speed: G,
    pitch: G,
    impulse: G,
    /// Acceleration of the flat chord by the turn of the normal in the air, m/s2.
    turning: G,
}

/// That of each strip.
pub(super) type SectionAirs<G, const N: usize> = ArrayVec<SectionAir<G>, N>;

/// A membrane in the air of its strips.
pub(super) struct Skin<'a, P, G: Scalar, S> {
    membrane: &'a Membrane<P>,
    airs: &'a [SectionAir<G>],
    /// Heights over the chord.
    of_chord: Shapes<&'a [S]>,
}

impl<P: Scalar> StripModel<P> {
    /// Whether the surface is a membrane.
    pub fn is_membrane(&self) -> bool {
        self.membrane.is_some()
    }

    /// Whether ribs hold a membrane so that it is tense along the span too; none without one.
    pub fn is_ribbed(&self) -> Option<bool> {
        self.membrane.as_ref().map(Membrane::is_ribbed)
    }

    /// The same surface whose membrane, if there is one, moves as it is given: heights of both shapes with their rates and the rate as
    /// followed, all per strip, are the last of the states, and have no rates of their own.
    #[must_use]
    pub fn with_shapes_given(&self) -> Self {
        Self { shapes_given: self.membrane.is_some(), ..self.clone() }
    }

    /// Number of the states that are given.
    pub fn given(&self) -> usize {
        if self.shapes_given { GIVEN.len() * self.settings.strips } else { 0 }
    }

    /// Names and units of what each strip carries for a membrane.
    pub(super) fn shape_states(&self) -> &'static [(&'static str, &'static str)] {
        if self.shapes_given { &GIVEN } else { &STATES }
    }

    /// What the motion of the membrane is held against at the strain `stretch` (dimensionless) along its chord; none without
    /// one.
    pub fn membrane_scales(&self, stretch: f64) -> Option<MembraneScales> {
        self.membrane.as_ref().map(|membrane| membrane.scales(self.numbers.density.value(), stretch))
    }

    /// Load that the bending stiffness of the membrane would bear in the shape of half a sine over that which the strain `stretch` bears:
    /// pi^2 D/(c^2 T), D = E t^3/[12 (1 - nu^2)] and T = E t e/(1 - nu^2), c the mean chord; none without one.
    ///
    /// Equation: aero.membrane.bending
    /// `pi^2 t^2/(12 c^2 e)`
    /// Source: Timoshenko & Woinowsky-Krieger 1959, Theory of Plates and Shells, section 2 (long plates with tension).
    /// Test: `a_thick_membrane_bears_by_bending`.
    pub fn membrane_bending(&self, stretch: f64) -> Option<f64> {
        let thickness = self.settings.membrane.as_ref()?.thickness_m;
        let over = std::f64::consts::PI * thickness / self.membrane_scales(stretch)?.mean_chord;
        Some(over * over / 12.0 / stretch)
    }

    /// Mass of the membrane of each strip, kg; nothing without one.
    pub fn membrane_masses(&self) -> Vec<f64> {
        let masses = self.membrane.iter().flat_map(Membrane::masses);
        masses.zip(&self.tables.covered).map(|(mass, covered)| mass * covered.value()).collect()
    }

    /// Strain along the chord at those heights over the chord, what the span adds left out; below zero the membrane is slack.
    pub fn membrane_stretch(&self, camber: f64, forward: f64) -> Option<f64> {
        let membrane = self.membrane.as_ref()?;
        Some(membrane.prestrain.value() + 0.5 * (ARC[0] * camber * camber + ARC[1] * forward * forward))
    }

    /// Strain of the flat membrane along the span at rest, dimensionless; none without two ribs between which it is tense.
    pub fn membrane_prestrain_span(&self) -> Option<f64> {
        let membrane = self.membrane.as_ref()?;
        (membrane.ribs.len() > 1).then(|| membrane.prestrain_span.value())
    }

    /// Arcs of the ribs that hold the membrane to the chord, from the left tip to the right, m; nothing without one.
    pub fn membrane_ribs(&self) -> &[f64] {
        self.membrane.as_ref().map_or(&[], |membrane| &membrane.ribs)
    }

    /// Both heights over the chord of the strips in the state `x`; nothing without a membrane.
    pub fn camber_of<'a>(&self, x: &'a [f64]) -> [&'a [f64]; MODES] {
        let strips = if self.membrane.is_some() { self.settings.strips } else { 0 };
        let from = |mode: usize| self.camber_states() + mode * strips;
        std::array::from_fn(|mode| x.get(from(mode)..from(mode) + strips).unwrap_or_default())
    }

    /// Where the states lie that say how the chords of its strips are bent: both heights of a membrane, or the angles of flaps.
    pub fn bent_states(&self) -> std::ops::Range<usize> {
        let n = self.settings.strips;
        match (self.membrane.is_some(), self.has_flap()) {
            (true, _) => self.camber_states()..self.camber_states() + MODES * n,
            (_, true) => self.flap_states()..self.flap_states() + n,
            _ => 0..0,
        }
    }

    /// Where the cambers begin among the states.
    fn camber_states(&self) -> usize {
        self.followed_states() + if self.follows() { self.settings.strips } else { 0 }
    }

    /// Heights over the chord from the states.
    pub(super) fn cambers<'x, S>(&self, x: &'x [S]) -> Shapes<&'x [S]> {
        let (n, at) = (self.settings.strips, self.camber_states());
        std::array::from_fn(|m| &x[at + m * n..][..n])
    }

    /// Adds what the slopes make of the wash at 3/4 chord, V (2 h_1 - h_2)/c: the wash is B0 + B1 cos t + B2 cos 2t + ..., of
    /// which B0 - B1/2 lifts; with z' = [4 h_1 cos t + h_2 (1 + 3 cos 2t)]/c it is B0 = -V h_2/c, B1 = -4 V h_1/c, B2 = -3 V h_2/c,
    /// from the rate B0 = -h_1'/2, B2 = h_1'/2.
    ///
    /// Equation: aero.camber_wash
    /// `lifting wash V (2 h_1 - h_2)/c - h_1'/2 of z = sin^2 t (h_1 + h_2 cos t)`
    /// Source: Glauert 1926, ch. 7, with the wash of the rate.
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    #[inline(never)]
    pub(super) fn wash_of_slope<G: Scalar, S: Over<G>>(&self, skin: &Skin<'_, P, G, S>, wash: &mut [S]) {
        let [first, second] = skin.of_chord;
        for (i, air) in skin.airs.iter().enumerate() {
            wash[i] += (first[i] * 2.0 - second[i]) * air.along.smooth_abs(self.floor);
        }
    }

    /// Momentum (3/4) P + (2/3) m w of strip `i` that its parabola feels by the motion of the chord, N s, and the part (2/3) m a of the rate
    /// of the second term that is the turn of the normal in the air, N: m is the mass of the membrane, w the wash at mid chord.
    fn camber_momentum<G: Scalar + Meets<P>>(
        &self,
        i: usize,
        air: &SectionAir<G>,
        membrane: &Membrane<P>,
    ) -> [G; 2] {
        let mass = self.film_mass(i, membrane);
        [air.impulse * 0.75 + air.wash_half * mass, air.turning * mass]
    }

    /// Mass of the membrane of strip `i` as both chord and parabola move it, (2/3) m, kg.
    fn film_mass(&self, i: usize, membrane: &Membrane<P>) -> P {
        self.membrane_mass(i, membrane) * (2.0 / 3.0)
    }

    /// Mass of the membrane of strip `i`, kg.
    fn membrane_mass(&self, i: usize, membrane: &Membrane<P>) -> P {
        membrane.areal_density * self.tables.chord[i] * membrane.width[i] * self.tables.covered[i]
    }

    /// Mass that the parabola of strip `i` feels where its rise accelerates, kg: that of the membrane by the mean square of the shape, and
    /// of the air in plane flow. The wash -h_1' (1 - cos 2t)/2 of its rate makes the pressure 2 rho b h_1'' (-3/4 sin t + 1/12 sin 3t),
    /// which bears on the shape with -7/12 pi rho b^2 h_1'' for each span.
    ///
    /// Equation: aero.camber_mass
    /// `8/15 m + 7/12 pi rho b^2 dy, as in aero.membrane.frequency`
    /// Source: Theodorsen 1935; Peters, Hsieh & Torrero 2007 (modes of camber); own derivation.
    /// Test: `a_membrane_let_go_moves_by_its_mass_tension_and_delay`.
    pub(super) fn camber_mass(&self, i: usize, membrane: &Membrane<P>) -> P {
        self.membrane_mass(i, membrane) * (8.0 / 15.0) + self.carried_mass(i) * (7.0 / 12.0)
    }

    /// Mass pi rho b^2 dy of the air that strip `i` carries in plane flow, kg; none where added mass is left out.
    fn carried_mass(&self, i: usize) -> P {
        if self.settings.section.added_mass { self.tables.mass[i] } else { P::ZERO }
    }

    /// Normal force of the plate in separated flow over `drag_scale`, m2/s2, by the speed along the chord and the wash at mid chord.
    pub(super) fn plate<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        [along, wash_half]: [G; 2],
        attached: S,
    ) -> S {
        let drag = self.numbers.drag().of_plate();
        match self.settings.section.law.separates() {
            true => drag.section(&self.polar, along, wash_half, attached, self.floor * self.floor).normal,
            false => S::ZERO,
        }
    }

    /// Loads on the shapes of strip `i`, N, by virtual work of the pressure difference; of the circulatory force per wash
    /// L = rho a0 b dy V a half on the parabola, with w_l - B1/4, and an eighth on the other, with w_l + B1/2 - B2, where
    /// B1 = -b q - 4 V h_1/c and B2 = -3 V h_2/c; the vortex like the lift; on the parabola 2/3 of what presses evenly, the plate's
    /// force in separated flow, and `inertia`: (3/4) P' of the air that the chord carries less (2/3) m a of the membrane's mass.
    /// What the rate h_1' makes of the second load is [`crossing`](Self::crossing). Left out, and named in docs/sections.md: what is felt of
    /// the second shape's rates, and the weight; w holds the wind, so that a gust moves the membrane's mass too.
    ///
    /// Equation: aero.camber_load
    /// `Q_1 = L (w_l + b q/4 + V h_1/c)/2 + F_vortex/2 + 2/3 F_plate + 3/4 P' - 2/3 m a, Q_2 = L (w_l - b q/2 - V (2 h_1 - 3 h_2)/c -
    /// h_1'/2)/8 - pi rho b^2 dy V h_1'/(4 c) + F_vortex/8`
    /// Source: pressure of thin-aerofoil theory, 2 rho V [(w_l + B1/2) cot(t/2) - B1 sin t - B2 sin 2t] + 2 rho dphi/dt (Theodorsen
    /// 1935; Glauert 1926), against the shapes; evenness of the plate's pressure a choice; the rate of -b q in B1 on h_2 left out.
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    fn camber_load<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        air: &SectionAir<G>,
        [first, second]: Shapes<S>,
        (lift_wash, attached, vortex, inertia): (S, S, S, S),
    ) -> Shapes<S> {
        let wind = air.along.smooth_abs(self.floor);
        let turn = air.pitch * (self.tables.chord[i] * 0.125);
        let per_wash = attached * (wind * self.tables.lift_scale[i]);
        let vortex = vortex * attached * self.tables.drag_scale[i];
        let plate = self.plate([air.along, air.wash_half], attached);
        let even = plate * (self.tables.drag_scale[i] * (2.0 / 3.0)) + inertia;
        let fore = lift_wash - (first * 2.0 - second * 3.0) * wind - turn * 2.0;
        [
            ((lift_wash + first * wind + turn) * per_wash + vortex) * 0.5 + even,
            (fore * per_wash + vortex) * 0.125,
        ]
    }

    /// J^' = (J - J^)/tau: the momentum that the parabola feels is followed by a state within the membrane's own damping time, and
    /// its rate is the load of inertia. At the angular frequency w it lags by about w tau, which the verdict holds against a limit. The part
    /// -mu h_1' of J, mu of aero.camber_mass, is known with h_1' only: its load -mu h_1'/tau stands with what resists the rate. The slope of
    /// the second shape makes the pressure rho b V h_2' (sin t - sin 3t)/c, which bears on the parabola with (1/2) pi rho b^2 V h_2'/c.
    ///
    /// Equation: aero.camber_inertia
    /// `J^' = (J - J^)/tau, J = 3/4 P + 2/3 m w - mu h_1' + (1/2) pi rho b^2 dy V h_2/c; load J^' - 2/3 m (turn of the normal in the
    /// air)`
    /// Source: rate of momentum by a first-order filter, tau a choice; Theodorsen 1935 (pressure of a rate).
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    ///
    /// Rates of the cambers, and what they make of washes and lags: the rate h_1' lowers the wash by h_1'/2, and with it at once the
    /// load, so that the air damps the camber; that damping is taken for both shapes, whose second has no other effect of its rate.
    #[inline(never)]
    pub(super) fn bulge<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        &Skin { membrane, airs, of_chord }: &Skin<'_, P, G, S>,
        attached: &[S],
        [wash, lift_wash, flat, nose, couple]: [&mut [S]; 5],
        ([follows, slope], wanted): ([[&mut [S]; 2]; 2], bool),
        x: &[S],
        dx: &mut [S],
    ) -> S {
        let (n, tables, at) = (self.settings.strips, &self.tables, self.camber_states());
        let (mut first, mut second) = (ArrayVec::<S, MAX_STRIPS>::new(), ArrayVec::<S, MAX_STRIPS>::new());
        let (felt, per_time) = (at + MODES * n, membrane.damping.recip());
        let followed = felt + n * if self.shapes_given { MODES } else { 1 };
        let given = if self.shapes_given {
            for (i, air) in airs.iter().enumerate() {
                let wind = air.along.smooth_abs(self.floor);
                slope[0][i] = of_chord[1][i] * (wind * (self.carried_mass(i) * 0.5));
                first.push(x[felt + i] * tables.chord[i]);
                second.push(x[felt + n + i] * tables.chord[i]);
            }
            S::ZERO
        } else {
            let vortices =
                self.settings.section.law.about().edge_vortex.then(|| &x[self.law_states()..][..n]);
            let mut resistances = [ArrayVec::<S, MAX_STRIPS>::new(), ArrayVec::<S, MAX_STRIPS>::new()];
            let mut crossings = ArrayVec::<S, MAX_STRIPS>::new();
            for (i, air) in airs.iter().enumerate() {
                // The rate of the momentum as a state follows it: accelerations are not yet known here.
                let [momentum, turning] = self.camber_momentum(i, air, membrane);
                let wind = air.along.smooth_abs(self.floor);
                slope[0][i] = of_chord[1][i] * (wind * (self.carried_mass(i) * 0.5));
                dx[felt + i] = (x[felt + i] - momentum - slope[0][i]) * -per_time;
                let vortex = vortices.map_or(S::ZERO, |vortices| vortices[i]);
                let section = (lift_wash[i], attached[i], vortex, dx[felt + i] - turning);
                let load = self.camber_load(i, air, of_chord.map(|shape| shape[i]), section);
                first.push(load[0]);
                second.push(load[1]);
                let scale = tables.lift_scale[i] * tables.at_once * 0.25;
                let of_air = attached[i] * (wind * scale);
                resistances[0].push(of_air + self.camber_mass(i, membrane) * per_time);
                resistances[1].push(of_air);
                crossings.push(self.crossing(i, wind, attached[i]));
            }
            let loads = wanted.then(|| [first.clone(), second.clone()]);
            let resistances = resistances.each_ref().map(|of| &of[..]);
            membrane.rates(of_chord, resistances, &crossings, &mut [&mut first, &mut second]);
            let power = |[on_first, on_second]: [ArrayVec<S, MAX_STRIPS>; 2]| {
                (0..n).fold(S::ZERO, |sum, i| {
                    let fore = on_second[i] + crossings[i] * first[i] - resistances[1][i] * second[i];
                    sum + (on_first[i] - resistances[0][i] * first[i]) * first[i] + fore * second[i]
                })
            };
            loads.map_or(S::ZERO, power)
        };
        for (i, air) in airs.iter().enumerate() {
            let (fallen, wind) = (first[i] * -0.5, air.along.smooth_abs(self.floor));
            wash[i] += fallen;
            lift_wash[i] += fallen * tables.at_once;
            nose[i] = of_chord[1][i] * wind;
            flat[i] = lift_wash[i] - of_chord[0][i] * (wind * 2.0) + nose[i];
            (follows[0][i], follows[1][i]) = (x[followed + i], (first[i] - x[followed + i]) * per_time);
            slope[1][i] = second[i] * (wind * (self.carried_mass(i) * 0.5 / tables.chord[i]));
            couple[i] = self.camber_moment(i, wind, attached[i], of_chord.map(|shape| shape[i]), first[i]);
            for (k, lag) in tables.lags.iter().enumerate() {
                dx[k * n + i] += fallen * (air.speed * (lag.rate * tables.turnover[i]));
            }
            if self.shapes_given {
                continue;
            }
            dx[felt + i] -= first[i] * (self.camber_mass(i, membrane) * per_time);
            dx[followed + i] = follows[1][i];
            for (m, rate) in [&first, &second].into_iter().enumerate() {
                dx[at + m * n + i] = rate[i] * tables.chord[i].recip();
            }
        }
        given
    }

    /// Load on the second shape of strip `i` per rate h_1', N s/m: the wash -h_1'/2 that lifts at once and B2 = h_1'/2 in aero.camber_load, and
    /// the rate -4 V h_1'/c of B1, which bears on that shape with pi rho b^2 B1'/16 for each span.
    fn crossing<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(&self, i: usize, wind: G, attached: S) -> S {
        let tables = &self.tables;
        let by_lift = tables.lift_scale[i] * (tables.at_once + 1.0) * (1.0 / 16.0);
        let by_rate = wind * (self.carried_mass(i) * 0.25 / tables.chord[i]);
        -(attached * (wind * by_lift)) - by_rate
    }

    /// What the membrane meets, if there is one, kept in `airs`.
    #[inline(always)]
    pub(super) fn skin<'a, K: Scalar, G: Over<K>, S, const N: usize>(
        &'a self,
        flow: &StripFlow<K, G, N>,
        airs: &'a mut SectionAirs<G, N>,
        x: &'a [S],
    ) -> Option<Skin<'a, P, G, S>> {
        let membrane = self.membrane.as_ref()?;
        let strips = &flow.strips;
        for i in 0..self.settings.strips {
            airs.push(SectionAir {
                along: strips.along[i],
                wash_half: strips.wash_half[i],
                speed: strips.speed[i],
                pitch: strips.pitch[i],
                impulse: flow.impulse[i],
                turning: strips.turning(i),
            });
        }
        Some(Skin { membrane, airs, of_chord: self.cambers(x) })
    }

    /// Nose-up couple of the camber of strip `i` about its quarter chord, N m:
    /// -rho pi b^2 dy V [V (2 h_1 - 3/2 h_2)/c + h_1'/2], from (pi/2) rho V b^2 (B1 - B2) + (pi/8) rho b^3 B1'.
    ///
    /// Equation: aero.camber_moment
    /// `-rho pi b^2 dy V [V (2 h_1 - 3/2 h_2)/c + h_1'/2]; steady c_m = -pi (h_1 - 3/4 h_2)/c`
    /// Source: Glauert 1926, ch. 7; rate by thin-aerofoil theory, own derivation.
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    #[inline(always)]
    fn camber_moment<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        i: usize,
        wind: G,
        attached: S,
        [first, second]: Shapes<S>,
        first_rate: S,
    ) -> S {
        let turning = (first * 2.0 - second * 1.5) * wind + first_rate * 0.5;
        -(turning * attached * (wind * (self.tables.lift_scale[i] * self.tables.chord[i] * 0.25)))
    }

    /// Forward force of the pressure on the slopes, which is no suction of the leading edge and so is not lost with it:
    /// adds what [`cap_suction`](Self::cap_suction) took of it. Of the chord force w_l W that of the edge is (w - n)(W - n), w the
    /// wash of the flat chord, W as it turns the force, and n what the slope at the edge takes.
    #[inline(never)]
    pub(super) fn keep_slopes<S: Scalar + Meets<P>>(
        &self,
        [flat, nose, held, attached]: [&[S]; 4],
        [lift_wash, wash, shares]: [&[S]; 3],
        chordwise: &mut [S],
    ) {
        for i in 0..self.settings.strips {
            let edge = (flat[i] - nose[i]) * (wash[i] - nose[i]);
            let slopes = (lift_wash[i] * wash[i] - edge) * attached[i] * self.tables.lift_scale[i];
            chordwise[i] -= slopes * shares[i] * (S::ONE - held[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Loads, MembraneSpec, Planform, PlanformStation, SectionMotion, SectionSettings, StripModel,
        StripSettings,
    };
    use std::f64::consts::PI;
    use wingbeat_math::Vec3;

    /// A sail of 1 m chord and 10 m span, E t = 100 N/m, 0.01 kg/m2.
    fn sail(thickness: f64, prestrain: f64) -> StripModel {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.5, trailing_edge_m: -0.5 };
        let settings = StripSettings {
            strips: 4,
            wake_wash: false,
            doublet_wash: false,
            regularisation_m_s: 1e-4,
            section: SectionSettings {
                drag: crate::ProfileDrag { cd0: 0.0, cd90: 0.0 },
                density_kg_m3: 1.0,
                ..Default::default()
            },
            membrane: Some(MembraneSpec {
                thickness_m: thickness,
                modulus_pa: 100.0 / thickness,
                density_kg_m3: 0.01 / thickness,
                prestrain,
                prestrain_span: None,
                poisson_ratio: 0.3,
                damping_s: 0.05,
                ribs_m: Vec::new(),
            }),
            ..Default::default()
        };
        let planform = Planform::new(&[station(0.0), station(5.0)]).unwrap();
        StripModel::new(&planform, settings).unwrap()
    }

    /// pi^2 D/(c^2 T) by its parts, as the square of the thickness at one E t; the strips weigh what the sail weighs.
    #[test]
    fn a_thick_membrane_bears_by_bending() {
        let (thickness, strain) = (0.1, 0.015);
        let modulus = 100.0 / thickness;
        let plate = 1.0 - 0.3 * 0.3;
        let bending = modulus * thickness * thickness * thickness / (12.0 * plate);
        let exact = PI * PI * bending / (modulus * thickness * strain / plate);
        let found = sail(thickness, 0.01).membrane_bending(strain).unwrap();
        assert!((found / exact - 1.0).abs() < 1e-3 && found > 0.5, "{found} {exact}");
        let thin = sail(0.001, 0.01).membrane_bending(strain).unwrap();
        assert!((thin * 10_000.0 / found - 1.0).abs() < 1e-12, "{thin}");
        let model = sail(0.001, 0.01);
        let (mass, area): (f64, f64) = (model.membrane_masses().iter().sum(), model.widths().iter().sum());
        assert!((mass / (0.01 * area) - 1.0).abs() < 1e-9, "{mass} {area}");
    }

    /// In air that rests, mu J-filtered: (K tau^2 + R tau + mu) s^2 + (2 K tau + R) s + K = 0, K = (16/3) T dy/c and mu = w^-2 K of the
    /// frequency that the verdict names.
    #[test]
    fn a_membrane_let_go_moves_by_its_mass_tension_and_delay() {
        let (tension, tau) = (10.0, 0.05);
        let model = sail(1e-3, tension / 100.0);
        let section = |y: &f64| SectionMotion {
            le: Vec3([0.5, *y, 0.0]),
            te: Vec3([-0.5, *y, 0.0]),
            span: Vec3([0.0, -1.0, 0.0]),
            ..Default::default()
        };
        let sections: Vec<_> = model.arcs().iter().map(section).collect();
        let (n, strip, small) = (model.strips(), 1, 1e-5);
        let places = [model.camber_states() + strip, model.camber_states() + MODES * n + strip];
        let mut matrix = [[0.0; 2]; 2];
        for (column, place) in places.into_iter().enumerate() {
            let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
            x[place] = small;
            model.evaluate(&sections, Vec3::ZERO, &x, &mut dx, &mut Loads::default());
            (0..2).for_each(|row| matrix[row][column] = dx[places[row]] / small);
        }
        let [[a, b], [c, d]] = matrix;
        let width = model.widths()[strip];
        let stiffness = 16.0 / 3.0 * tension * width;
        let frequency = 2.0 * PI * model.membrane_scales(tension / 100.0).unwrap().frequency_hz;
        let mass = stiffness / (frequency * frequency);
        assert!((mass / (width * (8.0 / 15.0 * 0.01 + 7.0 / 48.0 * PI)) - 1.0).abs() < 1e-9, "{mass}");
        let all = stiffness * tau * tau + mass;
        let near = |value: f64, exact: f64| {
            assert!((value / exact - 1.0).abs() < 1e-3, "{matrix:?}: {value} {exact}")
        };
        near(a * d - b * c, stiffness / all);
        near(a + d, -2.0 * stiffness * tau / all);
    }

    /// In plane flow: k T h/c and the loads of both shapes are two linear equations, lift 2 pi (a + 2 h_1 - h_2), moment about 1/4 chord
    /// -pi (h_1 - 3/4 h_2), and no drag.
    #[test]
    fn a_sail_bulges_and_lifts_as_its_two_shapes_say() {
        let (alpha, tension) = (1e-3_f64, 1.5);
        let model = sail(1e-3, tension / 100.0);
        let (s, c) = alpha.sin_cos();
        let section = |y: &f64| SectionMotion {
            le: Vec3([0.5 * c, *y, 0.5 * s]),
            te: Vec3([-0.5 * c, *y, -0.5 * s]),
            span: Vec3([0.0, -1.0, 0.0]),
            ..Default::default()
        };
        let sections: Vec<_> = model.arcs().iter().map(section).collect();
        let (mut x, mut dx) = (vec![0.0; model.states()], vec![0.0; model.states()]);
        let (mut loads, wind) = (Loads::default(), Vec3([-1.0, 0.0, 0.0]));
        for _ in 0..6000 {
            model.evaluate(&sections, wind, &x, &mut dx, &mut loads);
            x.iter_mut().zip(&dx).for_each(|(x, dx)| *x += 0.02 * dx);
        }
        let second = PI / 8.0 * alpha / (3.2 * tension - PI / 4.0);
        let first = PI / 2.0 * (alpha - second) / (16.0 / 3.0 * tension - 1.5 * PI);
        let near = |value: f64, exact: f64, what: &str| {
            assert!((value / exact - 1.0).abs() < 1e-3, "{what}: {value} {exact}")
        };
        near(loads.camber[1], first, "first shape");
        near(loads.camber_forward[1], second, "second shape");
        let (lift, area) = (2.0 * PI * (alpha + 2.0 * first - second), model.widths().iter().sum::<f64>());
        near(loads.wrench.force[2], 0.5 * lift * area, "lift");
        let about_quarter = -loads.wrench.moment[1] - 0.25 * loads.wrench.force[2];
        near(about_quarter, -0.5 * PI * (first - 0.75 * second) * area, "moment");
        assert!(
            loads.wrench.force[0].abs() < 2e-3 * alpha * loads.wrench.force[2],
            "{:?}",
            loads.wrench.force
        );
    }
}
