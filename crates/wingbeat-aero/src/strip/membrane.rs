//! The membrane of the strips: camber by the pressure difference against a tension that grows with strain.
//!
//! Above the chord of a strip, x = c (1 - cos t)/2, stands z = sin^2 t (h_1 + h_2 cos t): the parabola, exact under an even
//! pressure, and the shape that moves the bulge forward. States are both over the chord. The inertia of the membrane against itself
//! is left out: its frequency, with the air that it carries, has to lie far above that of the motion, which
//! [`StripModel::membrane_scales`] tells. What remains is a balance of first order in the heights.

use super::grid::Grid;
use super::influence::Column;
use super::{Flow, StripModel};
use crate::{MAX_STRIPS, MembraneNumbers, Planform};
use std::f64::consts::{PI, TAU};
use wingbeat_math::{Error, GRAVITY, Meets, Over, Scalar, Vec3};

/// Strain over which the end of the tension is rounded off where the membrane goes slack. *Choice.*
const STRAIN_WIDTH: f64 = 1e-4;
/// Stretch over which the size of the tension is rounded off in the membrane's own damping. *Choice.*
const DAMPED_WIDTH: f64 = 1e-3;
/// Least distance of a strip's middle from a rib, over the width of the bay's first strip. *Choice.*
const LEAST_TIE: f64 = 0.1;
/// Shapes of a strip.
const MODES: usize = 2;
/// Rate of the arc's strain, the mean of z'^2/2 along the chord, by h/c of each shape, over h/c.
const ARC: [f64; MODES] = [16.0 / 3.0, 16.0 / 5.0];
/// Mean square of each shape along the chord.
const MEAN_SQUARE: [f64; MODES] = [8.0 / 15.0, 8.0 / 105.0];

/// What each strip carries for it: the heights over the chord, and the momentum that the parabola feels, as followed.
pub(super) const STATES: [(&str, &str); BLOCKS] =
    [("camber", ""), ("camber_forward", ""), ("camber_momentum", "N s")];
/// Number of its states per strip.
pub(super) const BLOCKS: usize = MODES + 1;

/// Something for each shape.
pub(super) type Shapes<T> = [T; MODES];

/// Strips between two ribs, or one strip that nothing holds at its sides.
#[derive(Clone, Debug)]
struct Bay<P> {
    first: usize,
    /// Chord over the distance between neighbours: one before each strip and one behind the last, which lead to the ribs; none of a
    /// strip that nothing holds.
    ties: Vec<P>,
    /// One over its area, 1/m2.
    inverse_area: P,
    /// Poisson's ratio; none of a strip that nothing holds.
    poisson: P,
    /// Tension over strain of plane stress E t/(1 - nu^2), N/m.
    stiffness: P,
}

/// The membrane laid on strips.
#[derive(Clone, Debug)]
pub(super) struct Membrane<P> {
    prestrain: P,
    prestrain_span: P,
    damping: P,
    areal_density: P,
    chord: Vec<P>,
    width: Vec<P>,
    bays: Vec<Bay<P>>,
}

/// What the camber does on each strip.
pub(super) struct Camber<S: Scalar, const N: usize> {
    /// Heights over the chord.
    pub of_chord: Shapes<Column<S, N>>,
    /// Rate of the parabola's height, m/s.
    pub rate: Column<S, N>,
    /// Lift wash without what the slopes add: the wash of the flat chord, m/s.
    pub flat: Column<S, N>,
    /// What the slope at the leading edge takes of that wash there, m/s.
    pub nose: Column<S, N>,
}

/// What a strip's membrane meets: as [`Strips`](super::motion::Strips), with the impulse of the air by the motion.
#[derive(Clone, Copy)]
pub(super) struct SectionAir<G: Scalar> {
    along: G,
    wash_half: G,
    speed: G,
    pitch: G,
    drift: G,
    impulse: G,
    normal_rate: Vec3<G>,
    chordwise: Vec3<G>,
    across: Vec3<G>,
}

impl<G: Scalar> SectionAir<G> {
    fn of<const N: usize>(flow: &Flow<G, N>, i: usize) -> Self {
        let strips = &flow.strips;
        Self {
            along: strips.along[i],
            wash_half: strips.wash_half[i],
            speed: strips.speed[i],
            pitch: strips.pitch[i],
            drift: strips.drift[i],
            impulse: flow.impulse[i],
            normal_rate: strips.normal_rate.get(i),
            chordwise: strips.chordwise.get(i),
            across: strips.across.get(i),
        }
    }
}

/// A membrane whose rates are not yet known.
pub(super) struct Bulging<G: Scalar, S: Scalar, const N: usize> {
    airs: [SectionAir<G>; N],
    of_chord: Shapes<Column<S, N>>,
}

/// Tension over stiffness from the stretch: what it is, never negative, and its size.
fn tension<S: Scalar>(stretch: S) -> [S; 2] {
    [stretch.smooth_positive(STRAIN_WIDTH), stretch.smooth_abs(DAMPED_WIDTH)]
}

impl<P: Scalar> Membrane<P> {
    /// Lays it on `grid`.
    ///
    /// # Errors
    /// [`Error::Invalid`] when a rib lies beyond the tip.
    pub fn new(
        numbers: &MembraneNumbers<P>,
        ribs_m: &[f64],
        planform: &Planform<P>,
        grid: &Grid<P>,
    ) -> Result<Self, Error> {
        let mut ribs = Vec::new();
        for (k, &arc) in ribs_m.iter().enumerate() {
            let at = planform.coordinates(P::from(arc));
            if at.iter().any(|s| s.abs().value() > planform.half_span().value() * (1.0 + 1e-9)) {
                let allowed =
                    format!("0 to the tip, {}", planform.station_arcs().last().map_or(0.0, |s| s.value()));
                return Err(Error::invalid(format!("membrane.ribs_m[{k}]"), arc, allowed));
            }
            ribs.extend(at);
        }
        ribs.sort_by(|a, b| b.value().total_cmp(&a.value()));
        ribs.dedup_by(|a, b| (*a - *b).value().abs() < 1e-9);
        let mut laid = Self {
            prestrain: numbers.prestrain,
            prestrain_span: numbers.prestrain_span,
            damping: numbers.damping,
            areal_density: numbers.areal_density,
            chord: grid.chord.clone(),
            width: grid.width.clone(),
            bays: Vec::new(),
        };
        let strips = grid.chord.len();
        let before = |rib: &P| grid.control_arcs.iter().filter(|s| s.value() > rib.value()).count();
        let mut next = 0;
        for pair in ribs.windows(2) {
            let (from, to) = (before(&pair[0]), before(&pair[1]));
            laid.loose(next..from, numbers);
            if from < to {
                laid.bay(from..to, pair, grid, numbers);
            }
            next = to;
        }
        laid.loose(next..strips, numbers);
        Ok(laid)
    }

    /// Strips that nothing holds at their sides.
    fn loose(&mut self, strips: std::ops::Range<usize>, numbers: &MembraneNumbers<P>) {
        self.bays.extend(strips.map(|first| Bay {
            first,
            ties: vec![P::ZERO; 2],
            inverse_area: P::ZERO,
            poisson: P::ZERO,
            stiffness: numbers.stiffness,
        }));
    }

    /// The strips between two ribs.
    fn bay(
        &mut self,
        strips: std::ops::Range<usize>,
        ribs: &[P],
        grid: &Grid<P>,
        numbers: &MembraneNumbers<P>,
    ) {
        let arc = |k: usize| match k {
            0 => ribs[0],
            k if k > strips.len() => ribs[1],
            k => grid.control_arcs[strips.start + k - 1],
        };
        let chord = |k: usize| grid.chord[(strips.start + k.max(1) - 1).min(strips.end - 1)];
        let tie = |k: usize| {
            let least = (grid.width[strips.start] * LEAST_TIE).value();
            let mut step = arc(k) - arc(k + 1);
            if step.value() < least {
                step = P::from(least);
            }
            (chord(k) + chord(k + 1)) * 0.5 / step
        };
        let area = strips.clone().fold(P::ZERO, |sum, i| sum + grid.chord[i] * grid.width[i]);
        let poisson = numbers.poisson_ratio;
        self.bays.push(Bay {
            first: strips.start,
            ties: (0..=strips.len()).map(tie).collect(),
            inverse_area: area.recip(),
            poisson,
            stiffness: numbers.stiffness / (P::ONE - poisson * poisson),
        });
    }

    /// Turns the loads in `rates`, N, into the rates of the heights, m/s, at the heights over chord `camber`; the loads fall by
    /// `resistance` N s/m with the rate: (tau K + R) h' = Q - N with N = k T_x (h/c) dy - d/dy[s T_y c dh/dy] dy, k = 16/3 and 16/5, s = 8/15 and 8/105;
    /// T_x = E t/(1 - nu^2) (e_x + nu e_y), e_x = e_0 + (8/3)(h_1/c)^2 + (8/5)(h_2/c)^2, e_y the prestrain along the span + the mean of s h_y^2/2 between the
    /// ribs, T_y = E t e_y + nu times the mean of T_x; T = E t e_x without ribs; no tension is negative.
    /// K is the tangent of N with the sizes of the tensions, those along the span held.
    ///
    /// Equation: aero.membrane
    /// `(tau K + R) h' = Q - N, N = k T (h/c) dy - d/dy[s T_y c h_y] dy, T = E t/(1 - nu^2)(e_x + nu e_y), e_x = e_0 +
    /// (8/3)(h_1/c)^2 + (8/5)(h_2/c)^2`
    /// Source: virtual work of a membrane of constant tension along its chord; Nielsen 1963, J. Appl. Mech. 30, without extension.
    /// Test: `an_even_pressure_bends_the_membrane_to_its_parabola`.
    #[inline(never)]
    pub fn rates<S: Scalar + Meets<P>>(
        &self,
        camber: Shapes<&[S]>,
        resistance: &[S],
        rates: Shapes<&mut [S]>,
    ) {
        let mut rates = rates;
        for bay in &self.bays {
            self.bay_rates(bay, camber, resistance, &mut rates);
        }
    }

    /// Strain of the strip `i` along its chord.
    fn stretch<S: Scalar + Meets<P>>(&self, camber: Shapes<&[S]>, i: usize) -> S {
        let arc = |m: usize| camber[m][i].squared() * (0.5 * ARC[m]);
        arc(0) + arc(1) + self.prestrain
    }

    /// Turns the loads of the strips of a bay, which `rates` holds, into the rates.
    fn bay_rates<S: Scalar + Meets<P>>(
        &self,
        bay: &Bay<P>,
        camber: Shapes<&[S]>,
        resistance: &[S],
        rates: &mut Shapes<&mut [S]>,
    ) {
        let (first, count) = (bay.first, bay.ties.len() - 1);
        let height = |m: usize, k: usize| match k {
            k if k == 0 || k > count => S::ZERO,
            k => camber[m][first + k - 1] * self.chord[first + k - 1],
        };
        let step = |m: usize, k: usize| height(m, k + 1) - height(m, k);
        let (mut along_span, mut along_chord) = (<S as From<P>>::from(self.prestrain_span), S::ZERO);
        for (k, tie) in bay.ties.iter().enumerate() {
            let square = step(0, k).squared() * MEAN_SQUARE[0] + step(1, k).squared() * MEAN_SQUARE[1];
            along_span += square * (*tie * bay.inverse_area * 0.5);
        }
        for i in first..first + count {
            let share = self.chord[i] * self.width[i] * bay.inverse_area;
            let [taut, _] = tension(self.stretch(camber, i) + along_span * bay.poisson);
            along_chord += taut * share;
        }
        // A slack strip wrinkles: across it the membrane narrows as it likes.
        let across = along_span * (P::ONE - bay.poisson * bay.poisson) + along_chord * bay.poisson;
        let [pull, held] = tension(across).map(|t| t * bay.stiffness);
        let mut taut = [[S::ONE; MAX_STRIPS]; 2];
        for i in first..first + count {
            let stretch = self.stretch(camber, i) + along_span * bay.poisson;
            [taut[0][i], taut[1][i]] = tension(stretch).map(|t| t * bay.stiffness);
        }
        for m in 0..MODES {
            // Symmetric tridiagonal system: diagonal and what is left of the load, eliminated on the way.
            let tie = |k: usize| bay.ties[k] * MEAN_SQUARE[m];
            let off = |k: usize| -(held * (tie(k) * self.damping));
            let (mut diagonal, rates) = ([S::ONE; MAX_STRIPS], &mut *rates[m]);
            for k in 0..count {
                let (i, ahead) = (first + k, rates[(first + k).saturating_sub(1)]);
                let slope = self.width[i] / self.chord[i] * ARC[m];
                let tangent = (taut[1][i] + camber[m][i].squared() * (bay.stiffness * ARC[m])) * slope
                    + held * (tie(k) + tie(k + 1));
                diagonal[i] = tangent * self.damping + resistance[i];
                rates[i] += (step(m, k + 1) * tie(k + 1) - step(m, k) * tie(k)) * pull
                    - taut[0][i] * camber[m][i] * (self.width[i] * ARC[m]);
                if k > 0 {
                    let share = off(k) / diagonal[i - 1];
                    diagonal[i] -= share * off(k);
                    rates[i] -= share * ahead;
                }
            }
            for i in (first..first + count).rev() {
                if i + 1 < first + count {
                    let behind = rates[i + 1];
                    rates[i] -= off(i + 1 - first) * behind;
                }
                rates[i] = rates[i] / diagonal[i];
            }
        }
    }

    /// What its motion is held against at the strain `stretch` along the chord, in air of the density `density`, sides let go.
    ///
    /// Least frequency of a bay: the modal mass is (8/15) m c + (7/12) pi rho c^2/4 for each span, the stiffness (16/3) T/c, both with
    /// the largest chord, and T = K e the tension. What the strain of a vibration adds to the stiffness is left out, so that it
    /// is rather low.
    ///
    /// Equation: aero.membrane.frequency
    /// `omega^2 = (16/3) T/c / [(8/15) m c + (7/12) pi rho c^2/4]`
    /// Source: Rayleigh's quotient with the parabola; the air's part by thin-aerofoil theory, own derivation.
    /// Test: `the_frequency_of_a_membrane_is_that_of_its_string`.
    pub fn scales(&self, density: f64, stretch: f64) -> MembraneScales {
        let mass = self.areal_density.value();
        let mut scales =
            MembraneScales { frequency_hz: f64::INFINITY, damping_s: self.damping.value(), weight_rise: 0.0 };
        for bay in &self.bays {
            let strips = bay.first..bay.first + bay.ties.len() - 1;
            let chord = strips.map(|i| self.chord[i].value()).fold(0.0, f64::max);
            let tension = bay.stiffness.value() * stretch;
            let carried = mass * chord * MEAN_SQUARE[0] + density * PI * chord * chord / 4.0 * (7.0 / 12.0);
            let frequency = (ARC[0] * tension / chord / carried).sqrt() / TAU;
            scales.frequency_hz = scales.frequency_hz.min(frequency);
            if mass > 0.0 {
                scales.weight_rise = scales.weight_rise.max(mass * GRAVITY * chord / (8.0 * tension));
            }
        }
        scales
    }
}

/// What the motion of a membrane is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MembraneScales {
    /// Least frequency, Hz.
    pub frequency_hz: f64,
    /// Time of its own damping, within which it follows its inertia too, s.
    pub damping_s: f64,
    /// Rise over the chord that its weight would make of it, m g c/(8 T).
    pub weight_rise: f64,
}

impl<P: Scalar> StripModel<P> {
    /// Whether the surface is a membrane.
    pub fn is_membrane(&self) -> bool {
        self.membrane.is_some()
    }

    /// What the motion of the membrane is held against at the strain `stretch` along its chord; none without one.
    pub fn membrane_scales(&self, stretch: f64) -> Option<MembraneScales> {
        self.membrane.as_ref().map(|membrane| membrane.scales(self.numbers.density.value(), stretch))
    }

    /// Strain along the chord at those heights over the chord, what the span adds left out; below zero the membrane is slack.
    pub fn membrane_stretch(&self, camber: f64, forward: f64) -> Option<f64> {
        let membrane = self.membrane.as_ref()?;
        Some(membrane.prestrain.value() + 0.5 * (ARC[0] * camber * camber + ARC[1] * forward * forward))
    }

    /// Heights above mid chord over the chord of the strips in the state `x`; nothing without a membrane.
    pub fn camber_of<'a>(&self, x: &'a [f64]) -> &'a [f64] {
        let strips = if self.membrane.is_some() { self.settings.strips } else { 0 };
        x.get(self.camber_states()..).and_then(|x| x.get(..strips)).unwrap_or_default()
    }

    /// Where the cambers begin among the states.
    fn camber_states(&self) -> usize {
        self.followed_states() + if self.follows() { self.settings.strips } else { 0 }
    }

    /// Heights over the chord from the states.
    pub(super) fn cambers<S: Scalar, const N: usize>(&self, x: &[S]) -> Shapes<Column<S, N>> {
        let (n, at) = (self.settings.strips, self.camber_states());
        let mut shapes = [[S::ZERO; N]; MODES];
        for (m, column) in shapes.iter_mut().enumerate() {
            column[..n].copy_from_slice(&x[at + m * n..][..n]);
        }
        shapes
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
    fn wash_of_slope<G: Scalar, S: Over<G>>(
        &self,
        airs: &[SectionAir<G>],
        [first, second]: Shapes<&[S]>,
        wash: &mut [S],
    ) {
        for (i, air) in airs.iter().enumerate() {
            wash[i] += (first[i] * 2.0 - second[i]) * air.along.smooth_abs(self.floor);
        }
    }

    /// Momentum (3/4) P + (2/3) m w of strip `i` that its parabola feels, N s, and the part (2/3) m a of the rate of the second term that
    /// is the turn of the normal in the air, N: m is the mass of the membrane, w the wash at mid chord.
    fn camber_momentum<G: Scalar + Meets<P>>(
        &self,
        i: usize,
        air: &SectionAir<G>,
        membrane: &Membrane<P>,
    ) -> [G; 2] {
        let covered = self.tables.covered[i];
        let mass = membrane.areal_density * self.tables.chord[i] * membrane.width[i] * covered * (2.0 / 3.0);
        let turning =
            air.along * air.normal_rate.dot(air.chordwise) - air.drift * air.normal_rate.dot(air.across);
        [air.impulse * 0.75 + air.wash_half * mass, turning * mass]
    }

    /// Loads on the shapes of strip `i`, N, by virtual work of the pressure difference; of the circulatory force per wash
    /// L = rho a0 b dy V a half on the parabola, with w_l - B1/4, and an eighth on the other, with w_l + B1/2 - B2, where
    /// B1 = -b q - 4 V h_1/c and B2 = -3 V h_2/c; the vortex like the lift; on the parabola 2/3 of what presses evenly, the plate's
    /// force in separated flow, and `inertia`: (3/4) P' of the air that the chord carries less (2/3) m a of the membrane's mass.
    ///
    /// Equation: aero.camber_load
    /// `Q_1 = L (w_l + b q/4 + V h_1/c)/2 + F_vortex/2 + 2/3 F_plate + 3/4 P' - 2/3 m a, Q_2 = L (w_l - b q/2 - V (2 h_1 - 3 h_2)/c)/8 +
    /// F_vortex/8`
    /// Source: pressure of thin-aerofoil theory, 2 rho V [(w_l + B1/2) cot(t/2) - B1 sin t - B2 sin 2t] + 2 rho dphi/dt (Theodorsen
    /// 1935; Glauert 1926), against the shapes; evenness of the plate's pressure a choice; the rate of B1 on h_2 left out.
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
        let drag = self.numbers.drag().of_plate();
        let delta2 = self.floor * self.floor;
        let plate = match self.settings.section.law.separates() {
            true => drag.section(&self.polar, air.along, air.wash_half, attached, delta2).normal,
            false => S::ZERO,
        };
        let even = plate * (self.tables.drag_scale[i] * (2.0 / 3.0)) + inertia;
        let fore = lift_wash - (first * 2.0 - second * 3.0) * wind - turn * 2.0;
        [
            ((lift_wash + first * wind + turn) * per_wash + vortex) * 0.5 + even,
            (fore * per_wash + vortex) * 0.125,
        ]
    }

    /// J^' = (J - J^)/tau: the momentum that the parabola feels is followed by a state within the membrane's own damping time, and
    /// its rate is the load of inertia.
    ///
    /// Equation: aero.camber_inertia
    /// `J^' = (J - J^)/tau, J = 3/4 P + 2/3 m w; load J^' - 2/3 m (turn of the normal in the air)`
    /// Source: rate of momentum by a first-order filter, tau a choice.
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    ///
    /// Rates of the cambers, and what they make of washes and lags: the rate h_1' lowers the wash by h_1'/2, and with it at once the
    /// load, so that the air damps the camber; that damping is taken for both shapes, whose second has no other effect of its rate.
    #[inline(never)]
    fn bulge<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        (airs, membrane): (&[SectionAir<G>], &Membrane<P>),
        (of_chord, attached): (Shapes<&[S]>, &[S]),
        [wash, lift_wash, flat, nose, first_rate]: [&mut [S]; 5],
        x: &[S],
        dx: &mut [S],
    ) {
        let (n, tables, at) = (self.settings.strips, &self.tables, self.camber_states());
        let vortices = self.settings.section.law.about().edge_vortex.then(|| &x[self.law_states()..][..n]);
        let (mut load, mut resistance) = ([[S::ZERO; MAX_STRIPS]; MODES], [S::ZERO; MAX_STRIPS]);
        let felt = at + MODES * n;
        for (i, air) in airs.iter().enumerate() {
            // The rate of the momentum as a state follows it: accelerations are not yet known here.
            let [momentum, turning] = self.camber_momentum(i, air, membrane);
            dx[felt + i] = (x[felt + i] - momentum) * -membrane.damping.recip();
            let vortex = vortices.map_or(S::ZERO, |vortices| vortices[i]);
            let section = (lift_wash[i], attached[i], vortex, dx[felt + i] - turning);
            let shapes = [of_chord[0][i], of_chord[1][i]];
            [load[0][i], load[1][i]] = self.camber_load(i, air, shapes, section);
            let scale = tables.lift_scale[i] * tables.at_once * 0.25;
            resistance[i] = attached[i] * (air.along.smooth_abs(self.floor) * scale);
        }
        let [first, second] = &mut load;
        membrane.rates(of_chord, &resistance, [first, second]);
        for (i, air) in airs.iter().enumerate() {
            let (fallen, wind) = (load[0][i] * -0.5, air.along.smooth_abs(self.floor));
            wash[i] += fallen;
            lift_wash[i] += fallen * tables.at_once;
            nose[i] = of_chord[1][i] * wind;
            flat[i] = lift_wash[i] - of_chord[0][i] * (wind * 2.0) + nose[i];
            first_rate[i] = load[0][i];
            for (k, lag) in self.numbers.lags.iter().enumerate() {
                dx[k * n + i] += fallen * (air.speed * (lag.rate * tables.turnover[i]));
            }
            for (m, rate) in load.iter().enumerate() {
                dx[at + m * n + i] = rate[i] * tables.chord[i].recip();
            }
        }
    }

    /// What the membrane, if there is one, makes of the wash: see [`wash_of_slope`](Self::wash_of_slope).
    pub(super) fn slopes<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        flow: &Flow<G, N>,
        x: &[S],
        wash: &mut Column<S, N>,
    ) -> Option<Bulging<G, S, N>> {
        self.membrane.as_ref()?;
        let airs = std::array::from_fn(|i| SectionAir::of(flow, i));
        let of_chord = self.cambers::<S, N>(x);
        self.wash_of_slope(&airs[..self.settings.strips], [&of_chord[0], &of_chord[1]], wash);
        Some(Bulging { airs, of_chord })
    }

    /// See [`bulge`](Self::bulge).
    pub(super) fn advance_camber<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        Bulging { airs, of_chord }: Bulging<G, S, N>,
        attached: &Column<S, N>,
        (wash, lift_wash): (&mut Column<S, N>, &mut Column<S, N>),
        x: &[S],
        dx: &mut [S],
    ) -> Option<Camber<S, N>> {
        let zero = [S::ZERO; N];
        let mut camber = Camber { of_chord, rate: zero, flat: *lift_wash, nose: zero };
        let air = (&airs[..self.settings.strips], self.membrane.as_ref()?);
        let held: (Shapes<&[S]>, &[S]) = ([&of_chord[0], &of_chord[1]], attached);
        let columns: [&mut [S]; 5] = [wash, lift_wash, &mut camber.flat, &mut camber.nose, &mut camber.rate];
        self.bulge(air, held, columns, x, dx);
        Some(camber)
    }

    /// Nose-up couple of the camber of strip `i` about its quarter chord, N m:
    /// -rho pi b^2 dy V [V (2 h_1 - 3/2 h_2)/c + h_1'/2], from (pi/2) rho V b^2 (B1 - B2) + (pi/8) rho b^3 B1'.
    ///
    /// Equation: aero.camber_moment
    /// `-rho pi b^2 dy V [V (2 h_1 - 3/2 h_2)/c + h_1'/2]; steady c_m = -pi (h_1 - 3/4 h_2)/c`
    /// Source: Glauert 1926, ch. 7; rate by thin-aerofoil theory, own derivation.
    /// Test: `a_sail_bulges_and_lifts_as_its_two_shapes_say`.
    pub(super) fn camber_moment<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        flow: &Flow<G, N>,
        attached: S,
        camber: &Camber<S, N>,
    ) -> S {
        let (wind, [first, second]) = (flow.strips.along[i].smooth_abs(self.floor), &camber.of_chord);
        let turning = (first[i] * 2.0 - second[i] * 1.5) * wind + camber.rate[i] * 0.5;
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
        Loads, MembraneSpec, PlanformStation, SectionMotion, SectionSettings, StripModel, StripSettings,
    };
    use wingbeat_math::{Dual, Vec3};

    /// A skin of one chord of 0.2 m and width 0.1 m between each pair of five strips, held at both ends of the five.
    fn held(prestrain: f64, ribs: bool, damping: f64) -> Membrane<f64> {
        let numbers = MembraneNumbers {
            stiffness: 100.0,
            areal_density: 0.02,
            prestrain,
            prestrain_span: 0.01,
            poisson_ratio: 0.3,
            damping,
        };
        let arc = |k: usize| 0.2 - 0.1 * k as f64;
        let grid = Grid {
            arcs: (0..6).map(|k| arc(k) + 0.05).collect(),
            control_arcs: (0..5).map(arc).collect(),
            fraction: vec![0.5; 5],
            covered: vec![true; 5],
            outline: vec![(0.1, -0.1); 6],
            chord: vec![0.2; 5],
            width: vec![0.1; 5],
            cos_half: vec![1.0; 5],
            cos_three_quarter: vec![1.0; 5],
            mean_chord: 0.2,
            aspect: 2.5,
        };
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.1, trailing_edge_m: -0.1 };
        let planform = Planform::new(&[station(0.0), station(0.25)]).unwrap();
        let ribs: &[f64] = if ribs { &[0.25] } else { &[] };
        Membrane::new(&numbers, ribs, &planform, &grid).unwrap()
    }

    #[test]
    fn an_even_pressure_bends_the_membrane_to_its_parabola() {
        for (prestrain, pressure) in [(0.05, 10.0), (0.0, 20.0), (-0.01, 20.0)] {
            let skin = held(prestrain, false, 1e-3);
            let mut camber = [[0.03; 5], [0.0; 5]];
            for _ in 0..20_000 {
                let [mut first, mut second] = [[pressure * 0.02 * 2.0 / 3.0; 5], [0.0; 5]];
                skin.rates([&camber[0], &camber[1]], &[1e-3; 5], [&mut first, &mut second]);
                (0..5).for_each(|i| camber[0][i] += 1e-4 * first[i] / 0.2);
            }
            // h = p c^2 / (8 T), T = E t (e_0 + (8/3)(h/c)^2).
            let tension = 100.0 * (prestrain + 8.0 / 3.0 * camber[0][2] * camber[0][2]);
            let exact = pressure * 0.2 / (8.0 * tension);
            assert!((camber[0][2] / exact - 1.0).abs() < 2e-3, "{prestrain}: {} {exact}", camber[0][2]);
        }
    }

    /// Without own damping and under a unit resistance the rates are minus the forces, whose slopes are symmetric: they have a
    /// potential, so that a cycle of heights costs nothing.
    #[test]
    fn the_forces_of_a_membrane_have_a_potential() {
        type D = Dual<10>;
        let skin = held(-0.004, true, 0.0);
        let value = |k: usize| 0.02 + 0.013 * (k as f64 * 1.7).sin();
        let camber: Shapes<[D; 5]> =
            std::array::from_fn(|m| std::array::from_fn(|i| D::variable(value(5 * m + i), 5 * m + i)));
        let mut rates = [[D::constant(0.0); 5]; MODES];
        let [first, second] = &mut rates;
        skin.rates([&camber[0], &camber[1]], &[D::constant(1.0); 5], [first, second]);
        let slope = |a: usize, b: usize| rates[a / 5][a % 5].eps[b];
        for (a, b) in (0..10).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let size = slope(a, a).abs().max(slope(b, b).abs());
            // The rounded corner of the spanwise tension, of strain e, lacks (1e-4/2 e)^2 of symmetry.
            let lacking = (slope(a, b) - slope(b, a)).abs() / size;
            assert!(lacking < 1e-4, "{a} {b}: {lacking}");
        }
    }

    /// Of strips that nothing holds: stored is E t e^2/2 over the area, lost (R + tau K) h'^2 with K the second derivative of what is
    /// stored by each height.
    #[test]
    fn work_on_a_membrane_is_what_it_stores_and_loses() {
        let (tau, resistance, step) = (2e-3, 0.03, 2e-6);
        let skin = held(0.05, false, tau);
        let (c, dy, stiffness) = (0.2, 0.1, 100.0);
        let stretch = |h: [f64; 2]| 0.05 + 0.5 * (ARC[0] * h[0] * h[0] + ARC[1] * h[1] * h[1]);
        let stored = |h: [f64; 2]| 0.5 * stiffness * stretch(h).powi(2) * c * dy;
        let (mut h, mut balance, mut worked) = ([0.03, -0.01], [0.0; 2], 0.0);
        let start = stored(h);
        for k in 0..50_000 {
            let t = (k as f64 + 0.5) * step;
            let load = [0.02 + 0.05 * (40.0 * t).sin(), 0.02 * (70.0 * t).cos()];
            let rates = |h: [f64; 2]| {
                let [mut first, mut second] = load.map(|load| [load; 5]);
                skin.rates([&[h[0]; 5], &[h[1]; 5]], &[resistance; 5], [&mut first, &mut second]);
                [first[2], second[2]]
            };
            // By the rule of the middle.
            let half = rates(h);
            let middle = [0, 1].map(|m| h[m] + 0.5 * step * half[m] / c);
            let rate = rates(middle);
            for m in 0..2 {
                let tangent =
                    ARC[m] * dy / c * stiffness * (stretch(middle) + ARC[m] * middle[m] * middle[m]);
                balance[0] += load[m] * rate[m] * step;
                balance[1] += (resistance + tau * tangent) * rate[m] * rate[m] * step;
                worked += (load[m] * rate[m] * step).abs();
                h[m] += step * rate[m] / c;
            }
        }
        let lacking = (balance[0] - balance[1] - (stored(h) - start)).abs() / worked;
        assert!(balance[1] > 0.05 * worked && lacking < 1e-5, "{balance:?} {lacking}");
    }

    /// Of a string pi sqrt(T/m)/c; the parabola is stiffer by sqrt(10)/pi.
    #[test]
    fn the_frequency_of_a_membrane_is_that_of_its_string() {
        let string = 0.5 * (100.0_f64 * 0.05 / 0.02).sqrt() / 0.2;
        let frequency = |density| held(0.05, false, 1e-3).scales(density, 0.05).frequency_hz;
        let found = frequency(0.0);
        assert!((found / string - 10_f64.sqrt() / PI).abs() < 1e-9, "{found} {string}");
        assert!(frequency(1.2) < found);
    }

    /// In plane flow: k T h/c and the loads of both shapes are two linear equations, lift 2 pi (a + 2 h_1 - h_2), moment about 1/4 chord
    /// -pi (h_1 - 3/4 h_2), and no drag.
    #[test]
    fn a_sail_bulges_and_lifts_as_its_two_shapes_say() {
        let (alpha, tension, span) = (1e-3_f64, 1.5, 10.0);
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
                thickness_m: 1e-3,
                modulus_pa: 1e5,
                density_kg_m3: 10.0,
                prestrain: tension / 100.0,
                prestrain_span: None,
                poisson_ratio: 0.3,
                damping_s: 0.05,
                ribs_m: Vec::new(),
            }),
            ..Default::default()
        };
        let planform = Planform::new(&[station(0.0), station(0.5 * span)]).unwrap();
        let model = StripModel::new(&planform, settings).unwrap();
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
