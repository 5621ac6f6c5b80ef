//! The membrane of the strips: camber by the pressure difference against a tension that grows with strain.
//!
//! Each strip is a parabola z = 4 h (x/c)(1 - x/c) above its chord, the exact shape under an even pressure, and its state the camber
//! h/c. The membrane's inertia against itself is left out: its frequency, with the air that it carries, has to lie far above that
//! of the motion, which [`StripModel::membrane_frequency_hz`] tells. What remains is a balance of first order in h.

use super::grid::Grid;
use super::influence::Column;
use super::response::LeadingEdges;
use super::{Flow, StripModel};
use crate::{MembraneNumbers, Planform};
use std::f64::consts::{PI, TAU};
use wingbeat_math::{Error, Meets, Over, Scalar};

/// Strain over which the end of the tension is rounded off where the membrane goes slack. *Choice.*
const STRAIN_WIDTH: f64 = 1e-4;
/// Slope of the arc's strain (8/3)(h/c)^2 over h/c: the strain is the mean of z'^2 / 2 along the chord.
const ARC: f64 = 16.0 / 3.0;
/// Mean square of the parabola along the chord.
const MEAN_SQUARE: f64 = 8.0 / 15.0;

/// Strips between two ribs, or one strip that nothing holds at its sides.
#[derive(Clone, Debug)]
struct Bay<P> {
    first: usize,
    /// Force between neighbours over spanwise tension and step of height: one before each strip and one behind the last, which lead
    /// to the ribs; none of a strip that nothing holds.
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
    damping: P,
    areal_density: P,
    chord: Vec<P>,
    width: Vec<P>,
    bays: Vec<Bay<P>>,
}

/// What the camber does on each strip.
pub(super) struct Camber<S: Scalar, const N: usize> {
    /// Camber over chord.
    pub of_chord: Column<S, N>,
    /// Rate of the height, m/s.
    pub rate: Column<S, N>,
    /// Lift wash without what the slope of the camber adds: the wash of the flat chord, m/s.
    pub flat: Column<S, N>,
}

/// Tension over stiffness from the stretch: what it is, never negative, and its size.
fn tension<S: Scalar>(stretch: S) -> [S; 2] {
    let size = stretch.smooth_abs(STRAIN_WIDTH);
    [(stretch + size) * 0.5, size]
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
                let allowed = format!("0 to the tip, {}", planform.station_arcs().last().map_or(0.0, |s| s.value()));
                return Err(Error::invalid(format!("membrane.ribs_m[{k}]"), arc, allowed));
            }
            ribs.extend(at);
        }
        ribs.sort_by(|a, b| b.value().total_cmp(&a.value()));
        ribs.dedup_by(|a, b| (*a - *b).value().abs() < 1e-9);
        let mut laid = Self {
            prestrain: numbers.prestrain,
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
    fn bay(&mut self, strips: std::ops::Range<usize>, ribs: &[P], grid: &Grid<P>, numbers: &MembraneNumbers<P>) {
        let arc = |k: usize| match k {
            0 => ribs[0],
            k if k > strips.len() => ribs[1],
            k => grid.control_arcs[strips.start + k - 1],
        };
        let chord = |k: usize| grid.chord[(strips.start + k.max(1) - 1).min(strips.end - 1)];
        let tie = |k: usize| {
            let least = (grid.width[strips.start] * 0.1).value();
            let mut step = arc(k) - arc(k + 1);
            if step.value() < least {
                step = P::from(least);
            }
            (chord(k) + chord(k + 1)) * (0.5 * MEAN_SQUARE) / step
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

    /// Rates of the heights, m/s, at the cambers `camber` under the loads `load`, N, which fall by `resistance` N s/m with
    /// the rate: (tau K + R) h' = Q - N with N_i = (16/3) T_x (h/c) dy + spanwise [T_y (8/15) c dh/dy], T_x = E t/(1 - nu^2)
    /// (e_x + nu e_y), e_x = e_0 + (8/3)(h/c)^2, e_y = e_0 + mean of (8/15) h_y^2 / 2, T = E t e_x without ribs; no tension is negative.
    /// K is the tangent of N with the sizes of the tensions, those along the span held.
    ///
    /// Equation: aero.membrane
    /// `(tau K + R) h' = Q - N, N = (16/3) T (h/c) dy + d/dy[T_y (8/15) c h_y], T = E t/(1 - nu^2)(e_x + nu e_y), e_x = e_0 +
    /// (8/3)(h/c)^2`
    /// Source: virtual work of a membrane of constant tension along its chord; Nielsen 1963, J. Appl. Mech. 30, without extension.
    /// Test: `an_even_pressure_bends_the_membrane_to_its_parabola`.
    pub fn rates<S: Scalar + Meets<P>, const N: usize>(
        &self,
        camber: &Column<S, N>,
        load: &Column<S, N>,
        resistance: &Column<S, N>,
    ) -> Column<S, N> {
        let mut rates = [S::ZERO; N];
        for bay in &self.bays {
            self.bay_rates(bay, camber, load, resistance, &mut rates);
        }
        rates
    }

    fn bay_rates<S: Scalar + Meets<P>, const N: usize>(
        &self,
        bay: &Bay<P>,
        camber: &Column<S, N>,
        load: &Column<S, N>,
        resistance: &Column<S, N>,
        rates: &mut Column<S, N>,
    ) {
        let (first, count) = (bay.first, bay.ties.len() - 1);
        let height = |k: usize| match k {
            k if k == 0 || k > count => S::ZERO,
            k => camber[first + k - 1] * self.chord[first + k - 1],
        };
        let stretch = |i: usize| camber[i].squared() * (0.5 * ARC) + self.prestrain;
        let (mut along_span, mut along_chord) = (<S as From<P>>::from(self.prestrain), S::ZERO);
        for (k, tie) in bay.ties.iter().enumerate() {
            along_span += (height(k + 1) - height(k)).squared() * (*tie * bay.inverse_area * 0.5);
        }
        for i in first..first + count {
            along_chord += stretch(i) * (self.chord[i] * self.width[i] * bay.inverse_area);
        }
        let [pull, span_size] = tension(along_span + along_chord * bay.poisson).map(|t| t * bay.stiffness);
        // Symmetric tridiagonal system: diagonal and what is left of the load, eliminated on the way.
        let mut diagonal = [S::ONE; N];
        let off = |k: usize| -(span_size * (bay.ties[k] * self.damping));
        for k in 0..count {
            let i = first + k;
            let [taut, size] =
                tension(stretch(i) + along_span * bay.poisson).map(|t| t * bay.stiffness);
            let slope = self.width[i] / self.chord[i] * ARC;
            let tangent = (size + camber[i].squared() * (bay.stiffness * ARC)) * slope
                + span_size * (bay.ties[k] + bay.ties[k + 1]);
            let (to, from) = (height(k + 2) - height(k + 1), height(k + 1) - height(k));
            let spanwise = (to * bay.ties[k + 1] - from * bay.ties[k]) * pull;
            rates[i] = load[i] - taut * camber[i] * (self.width[i] * ARC) + spanwise;
            diagonal[i] = tangent * self.damping + resistance[i];
            if k > 0 {
                let share = off(k) / diagonal[i - 1];
                diagonal[i] -= share * off(k);
                let before = rates[i - 1];
                rates[i] -= share * before;
            }
        }
        for k in (0..count).rev() {
            let i = first + k;
            if k + 1 < count {
                let behind = rates[i + 1];
                rates[i] -= off(k + 1) * behind;
            }
            rates[i] = rates[i] / diagonal[i];
        }
    }

    /// Least frequency of a strip with the air of the density `density` that it carries, Hz, its sides let go: the modal mass is
    /// (8/15) m c + (7/12) pi rho c^2/4 for each span, the stiffness (16/3) T/c with T the tension of the flat membrane, or
    /// twice what a slack one lacks of it.
    ///
    /// Equation: aero.membrane.frequency
    /// `omega^2 = (16/3) T/c / [(8/15) m c + (7/12) pi rho c^2/4]`
    /// Source: Rayleigh's quotient with the parabola; the air's part by thin-aerofoil theory, own derivation.
    /// Test: `the_frequency_of_a_membrane_is_that_of_its_string`.
    pub fn frequency_hz(&self, density: P) -> f64 {
        let stretch = self.prestrain.value();
        let stretch = if stretch < 0.0 { -2.0 * stretch } else { stretch };
        let of = |bay: &Bay<P>| {
            let chord = self.chord[bay.first].value();
            let air = density.value() * PI * chord * chord / 4.0 * (7.0 / 12.0);
            let mass = self.areal_density.value() * chord * MEAN_SQUARE + air;
            (ARC * bay.stiffness.value() * stretch / chord / mass).sqrt() / TAU
        };
        self.bays.iter().map(of).fold(f64::INFINITY, f64::min)
    }
}

impl<P: Scalar> StripModel<P> {
    /// Least frequency of the membrane, Hz, of those of its strips; none without one.
    pub fn membrane_frequency_hz(&self) -> Option<f64> {
        self.membrane.as_ref().map(|membrane| membrane.frequency_hz(self.numbers.density))
    }

    /// Where the cambers begin among the states.
    fn camber_states(&self) -> usize {
        self.followed_states() + if self.follows() { self.settings.strips } else { 0 }
    }

    /// Cambers over chord from the states.
    pub(super) fn cambers<S: Scalar, const N: usize>(&self, x: &[S]) -> Column<S, N> {
        let n = self.settings.strips;
        let mut column = [S::ZERO; N];
        column[..n].copy_from_slice(&x[self.camber_states()..][..n]);
        column
    }

    /// Adds what the slope of the camber makes of the wash at 3/4 chord, 2 (h/c) V: with z' = 4 (h/c) cos t, x = c (1 - cos t)/2,
    /// the wash is B0 + B1 cos t + B2 cos 2t, of which B0 - B1/2 lifts; B1 = -4 (h/c) V, from the rate B0 = -h'/2, B2 = h'/2.
    ///
    /// Equation: aero.camber_wash
    /// `lifting wash 2 (h/c) V - h'/2 of a parabola, z = h (1 - cos 2t)/2`
    /// Source: Glauert 1926, ch. 7, with the wash of the rate.
    /// Test: `a_moving_camber_is_lifted_as_a_vortex_panel_says`.
    pub(super) fn wash_of_slope<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        flow: &Flow<G, N>,
        camber: &Column<S, N>,
        wash: &mut Column<S, N>,
    ) {
        for i in 0..self.settings.strips {
            wash[i] += camber[i] * (self.wind_along(i, flow) * 2.0);
        }
    }

    /// Size of the wind along the chord, m/s.
    #[inline]
    pub(super) fn wind_along<G: Scalar, const N: usize>(&self, i: usize, flow: &Flow<G, N>) -> G {
        flow.strips.along[i].smooth_abs(self.floor)
    }

    /// Load on the parabola of strip `i`, N, by virtual work of the pressure difference: F/2 of the circulatory force
    /// rho a0 b dy V (w_l - B1/4), B1 = -b q - 4 (h/c) V, and of the vortex; 2/3 of what presses evenly, the plate's in separated
    /// flow; and (3/4) P' of the air that the chord carries, -(2/3) m a of the membrane's mass under the chord's acceleration.
    ///
    /// Equation: aero.camber_load
    /// `Q = rho pi b dy V (w_l + b q/4 + (h/c) V) + F_vortex/2 + 2/3 F_plate + 3/4 P' - 2/3 m a`
    /// Source: pressure of thin-aerofoil theory, 2 rho V [(w_l + B1/2) cot(t/2) - B1 sin t - B2 sin 2t] + 2 rho dphi/dt (Theodorsen
    /// 1935; Glauert 1926), against sin^2 t; evenness of the plate's pressure a choice.
    /// Test: `a_moving_camber_is_lifted_as_a_vortex_panel_says`.
    fn camber_load<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        (flow, membrane): (&Flow<G, N>, &Membrane<P>),
        (camber, lift_wash, attached): (S, S, S),
        vortex: S,
    ) -> S {
        let (strips, along) = (&flow.strips, self.wind_along(i, flow));
        let own = camber * along + S::from(strips.pitch[i] * (self.tables.chord[i] * 0.125));
        let circulatory = (lift_wash + own) * attached * (along * self.tables.lift_scale[i]);
        let drag = self.numbers.drag().of_plate();
        let (along, wash) = (strips.along[i], strips.wash_half[i]);
        let delta2 = self.floor * self.floor;
        let plate = match self.settings.section.law.separates() {
            true => drag.section(&self.polar, along, wash, attached, delta2).normal,
            false => S::ZERO,
        };
        let normal_rate = strips.normal_rate.get(i);
        let turning = along * normal_rate.dot(strips.chordwise.get(i))
            - strips.drift[i] * normal_rate.dot(strips.across.get(i));
        let acceleration = turning - strips.wash_half_rate[i];
        let mass = membrane.areal_density * self.tables.chord[i] * membrane.width[i] * self.tables.covered[i];
        let inertia = flow.impulse_rate[i] * 0.75 - acceleration * (mass * (2.0 / 3.0));
        (circulatory + vortex * attached * self.tables.drag_scale[i]) * 0.5
            + plate * (self.tables.drag_scale[i] * (2.0 / 3.0))
            + inertia
    }

    /// Rates of the cambers, and what they make of washes and lags: the rate h' lowers the wash by h'/2, and with it at once the
    /// load, so that the air damps the camber.
    pub(super) fn advance_camber<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        (flow, membrane): (&Flow<G, N>, &Membrane<P>),
        (of_chord, attached): (Column<S, N>, &Column<S, N>),
        (wash, lift_wash): (&mut Column<S, N>, &mut Column<S, N>),
        x: &[S],
        dx: &mut [S],
    ) -> Camber<S, N> {
        let (n, tables) = (self.settings.strips, &self.tables);
        let vortex = match self.settings.section.law.about().edge_vortex {
            true => self.law_column(x, 0),
            false => [S::ZERO; N],
        };
        let (mut load, mut resistance) = ([S::ZERO; N], [S::ZERO; N]);
        for i in 0..n {
            let section = (of_chord[i], lift_wash[i], attached[i]);
            load[i] = self.camber_load(i, (flow, membrane), section, vortex[i]);
            let scale = tables.lift_scale[i] * tables.at_once * 0.25;
            resistance[i] = attached[i] * (self.wind_along(i, flow) * scale);
        }
        let rate = membrane.rates(&of_chord, &load, &resistance);
        let mut flat = *lift_wash;
        for i in 0..n {
            let fallen = rate[i] * -0.5;
            wash[i] += fallen;
            lift_wash[i] += fallen * tables.at_once;
            flat[i] = lift_wash[i] - of_chord[i] * (self.wind_along(i, flow) * 2.0);
            for (k, lag) in self.numbers.lags.iter().enumerate() {
                dx[k * n + i] += fallen * (flow.strips.speed[i] * (lag.rate * tables.turnover[i]));
            }
            dx[self.camber_states() + i] = rate[i] * tables.chord[i].recip();
        }
        Camber { of_chord, rate, flat }
    }

    /// Nose-up couple of the camber of strip `i` about its quarter chord, N m:
    /// -rho pi b^2 dy V [2 (h/c) V + (b/c) h'], from (pi/2) rho V b^2 (B1 - B2) + (pi/8) rho b^3 B1'.
    ///
    /// Equation: aero.camber_moment
    /// `-rho pi b^2 dy V [2 (h/c) V + h'/2]; steady c_m = -pi h/c`
    /// Source: Glauert 1926, ch. 7; rate by thin-aerofoil theory, own derivation.
    /// Test: `a_moving_camber_is_lifted_as_a_vortex_panel_says`.
    pub(super) fn camber_moment<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        i: usize,
        flow: &Flow<G, N>,
        attached: S,
        camber: &Camber<S, N>,
    ) -> S {
        let along = self.wind_along(i, flow);
        let turning = camber.of_chord[i] * (along * 2.0) + camber.rate[i] * 0.5;
        -(turning * attached * (along * (self.tables.lift_scale[i] * self.tables.chord[i] * 0.25)))
    }

    /// Forward force of the pressure on the camber's slopes, which is no suction of the leading edge and so is not lost with it:
    /// adds what [`cap_suction`](Self::cap_suction) took of it.
    pub(super) fn keep_slopes<G: Scalar + Meets<P>, S: Over<G> + Meets<P>, const N: usize>(
        &self,
        flow_along: impl Fn(usize) -> G,
        camber: &Camber<S, N>,
        (edges, attached): (&LeadingEdges<S, N>, &Column<S, N>),
        (wash, shares): (&Column<S, N>, &Column<S, N>),
        chordwise: &mut Column<S, N>,
    ) {
        for i in 0..self.settings.strips {
            let slopes = camber.of_chord[i] * attached[i] * (flow_along(i) * (self.tables.lift_scale[i] * 2.0));
            chordwise[i] -= slopes * wash[i] * shares[i] * (S::ONE - edges.held[i]);
        }
    }
}
