//! A membrane by itself: its bays, tensions and rates under given loads.

use super::super::grid::StripGrid;
use crate::{MAX_STRIPS, MembraneNumbers, Planform};
use arrayvec::ArrayVec;
use std::f64::consts::{PI, TAU};
use wingbeat_math::{Error, GRAVITY, Meets, Scalar};

/// Strain over which the end of the tension is rounded off where the membrane goes slack. *Choice.*
const STRAIN_WIDTH: f64 = 1e-4;
/// Stretch over which the size of the tension is rounded off in the membrane's own damping. *Choice.*
const DAMPED_WIDTH: f64 = 1e-3;
/// Least distance of a strip's middle from its neighbour or a rib, over the width of the narrower strip beside. *Choice.*
const LEAST_TIE: f64 = 0.1;
/// Shapes of a strip.
pub(in super::super) const MODES: usize = 2;
/// Rate of the arc's strain, the mean of z'^2/2 along the chord, by h/c of each shape, over h/c.
pub(super) const ARC: [f64; MODES] = [16.0 / 3.0, 16.0 / 5.0];
/// Mean square of each shape along the chord.
const MEAN_SQUARE: [f64; MODES] = [8.0 / 15.0, 8.0 / 105.0];

/// Tension of each strip of a bay along its chord, and its size.
type Tensions<S> = ArrayVec<[S; 2], MAX_STRIPS>;

/// Something for each shape.
pub(in super::super) type Shapes<T> = [T; MODES];

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

impl<P> Bay<P> {
    fn strips(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.ties.len() - 1
    }
}

/// The membrane laid on strips.
#[derive(Clone, Debug)]
pub(in super::super) struct Membrane<P> {
    pub(super) prestrain: P,
    pub(super) prestrain_span: P,
    pub(in super::super) damping: P,
    pub(in super::super) areal_density: P,
    chord: Vec<P>,
    pub(super) width: Vec<P>,
    bays: Vec<Bay<P>>,
    /// Arcs of the ribs from the left tip to the right, m.
    pub(super) ribs: Vec<f64>,
}

impl<P: Scalar> Membrane<P> {
    /// Whether two ribs hold strips between them.
    pub fn is_ribbed(&self) -> bool {
        self.bays.iter().any(|bay| !bay.inverse_area.is_zero())
    }
}

/// Integral of the smooth positive part of `x` from where it is none on: [x^2 + x r + w^2 asinh(x/w)]/4, r = sqrt(x^2 + w^2).
fn positive_integral<S: Scalar>(x: S) -> S {
    let (width, root) = (STRAIN_WIDTH, x.smooth_abs(STRAIN_WIDTH));
    (x * x + x * root + ((x + root) * (1.0 / width)).ln() * (width * width)) * 0.25
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
        grid: &StripGrid<P>,
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
        wingbeat_math::order::descend_by(&mut ribs, |item| item.value());
        ribs.dedup_by(|a, b| (*a - *b).value().abs() < 1e-9);
        let mut laid = Self {
            prestrain: numbers.prestrain,
            prestrain_span: numbers.prestrain_span,
            damping: numbers.damping,
            areal_density: numbers.areal_density,
            chord: grid.chord.clone(),
            width: grid.width.clone(),
            bays: Vec::new(),
            ribs: ribs.iter().map(|rib| rib.value()).collect(),
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
        grid: &StripGrid<P>,
        numbers: &MembraneNumbers<P>,
    ) {
        let arc = |k: usize| match k {
            0 => ribs[0],
            k if k > strips.len() => ribs[1],
            k => grid.control_arcs[strips.start + k - 1],
        };
        let beside = |k: usize| (strips.start + k.max(1) - 1).min(strips.end - 1);
        let chord = |k: usize| grid.chord[beside(k)];
        let width = |k: usize| grid.width[beside(k)].value();
        let tie = |k: usize| {
            let least = width(k).min(width(k + 1)) * LEAST_TIE;
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
    /// `resistances` N s/m with the rate of each shape, and that on the second grows by `crossings` N s/m with the rate of the first: (tau K + R) h' = Q - N with N = k T_x (h/c) dy - d/dy[s T_y c dh/dy] dy, k = 16/3 and 16/5, s = 8/15 and 8/105;
    /// T_x = E t/(1 - nu^2) (e_x + nu e_y), e_x = e_0 + (8/3)(h_1/c)^2 + (8/5)(h_2/c)^2, e_y the prestrain along the span + the mean of s h_y^2/2 between the
    /// ribs, none where it is negative, T_y = E t e_y + nu times the mean of T_x; T = E t e_x without ribs; no tension is negative. N is the
    /// slope of [`stored`](Self::stored).
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
        resistances: Shapes<&[S]>,
        crossings: &[S],
        rates: &mut Shapes<&mut [S]>,
    ) {
        let mut along = Tensions::new();
        for bay in &self.bays {
            let across = self.tensions(bay, camber, &mut along);
            for m in 0..MODES {
                self.shape_rates((bay, m), (&along, across), (camber[m], resistances[m]), rates[m]);
                if m == 0 {
                    let [first, second] = rates;
                    bay.strips().for_each(|i| second[i] += crossings[i] * first[i]);
                }
            }
        }
    }

    /// Energy of the strains at the heights over chord `camber`, J, from none on: E t/(1 - nu^2) F(e_x + nu s(e_y)) c dy and E t F(e_y) of
    /// the area of a bay, F the integral of the smooth positive part s.
    ///
    /// Equation: aero.membrane.stored
    /// `sum E t/(1 - nu^2) F(e_x + nu s(e_y)) c dy + E t F(e_y) A, F' = s`
    /// Source: plane stress, energy of a membrane that wrinkles across a slack direction (Pipkin 1986, IMA J. Appl. Math. 36); in a slack
    /// span E t/(1 - nu^2) in place of E t, a choice.
    /// Test: `the_forces_of_a_membrane_are_the_slopes_of_its_energy`.
    pub(in super::super) fn stored<S: Scalar + Meets<P>>(&self, camber: Shapes<&[S]>) -> S {
        let mut sum = S::ZERO;
        for bay in &self.bays {
            let span = self.span_strain(bay, camber);
            let narrowed = span.smooth_positive(STRAIN_WIDTH) * bay.poisson;
            for i in bay.strips() {
                let energy = positive_integral(self.stretch(camber, i) + narrowed);
                sum += energy * (bay.stiffness * self.chord[i] * self.width[i]);
            }
            if !bay.inverse_area.is_zero() {
                let uniaxial = bay.stiffness * (P::ONE - bay.poisson * bay.poisson);
                sum += positive_integral(span) * (uniaxial / bay.inverse_area);
            }
        }
        sum
    }

    /// Power h' tau K h' that the membrane's own damping takes at the heights over chord `camber` and their rates, 1/s, W.
    pub(in super::super) fn lost<S: Scalar + Meets<P>>(
        &self,
        camber: Shapes<&[S]>,
        rates: Shapes<&[S]>,
    ) -> S {
        let (mut sum, mut along) = (S::ZERO, Tensions::new());
        for bay in &self.bays {
            let [_, held] = self.tensions(bay, camber, &mut along);
            for m in 0..MODES {
                for (k, i) in bay.strips().enumerate() {
                    let slope = bay.stiffness * (self.width[i] * self.chord[i] * ARC[m]);
                    let tangent = along[k][1] * (self.width[i] * self.chord[i] * ARC[m])
                        + camber[m][i].squared() * (slope * ARC[m]);
                    sum += tangent * rates[m][i].squared() * self.damping;
                }
                for (k, tie) in bay.ties.iter().enumerate() {
                    let step = self.height(bay, rates[m], k + 1) - self.height(bay, rates[m], k);
                    sum += held * step.squared() * (*tie * MEAN_SQUARE[m] * self.damping);
                }
            }
        }
        sum
    }

    /// Shows `see` what each height over the chord bears at the heights `camber` with their `rates` (1/s), by shape and strip: the slope of what is
    /// [`stored`](Self::stored), half that of what is [`lost`](Self::lost) by its rate, and the part of that by its own rate over it, N m and N m s.
    pub(in super::super) fn efforts(
        &self,
        camber: Shapes<&[P]>,
        rates: Shapes<&[P]>,
        mut see: impl FnMut([usize; 2], [P; 3]),
    ) where
        P: Meets<P>,
    {
        let mut along = Tensions::new();
        for bay in &self.bays {
            let across = self.tensions(bay, camber, &mut along);
            for (m, k) in (0..MODES).flat_map(|m| (0..bay.strips().len()).map(move |k| (m, k))) {
                let (i, tie) = (bay.first + k, across[1] * MEAN_SQUARE[m]);
                let [pulled, tangent] = self.bent((bay, m, k), (&along, across), camber[m]);
                let beside = self.height(bay, rates[m], k) * bay.ties[k]
                    + self.height(bay, rates[m], k + 2) * bay.ties[k + 1];
                let (chord, own) = (self.chord[i], tangent * self.chord[i] * self.chord[i] * self.damping);
                see(
                    [m, i],
                    [-(pulled * chord), own * rates[m][i] - beside * tie * chord * self.damping, own],
                );
            }
        }
    }

    /// Strain of a bay along the span.
    fn span_strain<S: Scalar + Meets<P>>(&self, bay: &Bay<P>, camber: Shapes<&[S]>) -> S {
        let mut strain = <S as From<P>>::from(self.prestrain_span);
        for (column, mean) in camber.iter().zip(MEAN_SQUARE) {
            for (k, tie) in bay.ties.iter().enumerate() {
                let step = self.height(bay, column, k + 1) - self.height(bay, column, k);
                strain += step.squared() * (*tie * bay.inverse_area * (0.5 * mean));
            }
        }
        strain
    }

    /// Mass of each strip, kg.
    pub(super) fn masses(&self) -> impl Iterator<Item = f64> {
        let area = self.chord.iter().zip(&self.width).map(|(c, w)| (*c * *w).value());
        area.map(|area| area * self.areal_density.value())
    }

    /// Strain of the strip `i` along its chord.
    pub(super) fn stretch<S: Scalar + Meets<P>>(&self, camber: Shapes<&[S]>, i: usize) -> S {
        let arc = |m: usize| camber[m][i].squared() * (0.5 * ARC[m]);
        arc(0) + arc(1) + self.prestrain
    }

    /// Height of the shape `m` at the strip `k` of a bay, counted from 1; none at its ribs.
    fn height<S: Scalar + Meets<P>>(&self, bay: &Bay<P>, column: &[S], k: usize) -> S {
        match k {
            k if k == 0 || k >= bay.ties.len() => S::ZERO,
            k => column[bay.first + k - 1] * self.chord[bay.first + k - 1],
        }
    }

    /// Tensions of a bay, and their sizes: of each strip along the chord, in `along`, and of all along the span.
    #[inline(never)]
    fn tensions<S: Scalar + Meets<P>>(
        &self,
        bay: &Bay<P>,
        camber: Shapes<&[S]>,
        along: &mut Tensions<S>,
    ) -> [S; 2] {
        along.clear();
        let span = self.span_strain(bay, camber);
        let taut = span.smooth_positive(STRAIN_WIDTH);
        let mut along_chord = S::ZERO;
        for i in bay.strips() {
            let strain = tension(self.stretch(camber, i) + taut * bay.poisson);
            along_chord += strain[0] * (self.chord[i] * self.width[i] * bay.inverse_area);
            along.push(strain.map(|t| t * bay.stiffness));
        }
        // A slack strip wrinkles: across it the membrane narrows as it likes; s' is s over the root that is in it.
        let narrowing = taut / (taut * 2.0 - span) * bay.poisson;
        let across = taut * (P::ONE - bay.poisson * bay.poisson) + along_chord * narrowing;
        [across, across.smooth_abs(DAMPED_WIDTH)].map(|t| t * bay.stiffness)
    }

    /// What tensions do on the shape `m` of the strip `k` of a bay: their force on its height, N, and what that falls by with it, N/m, by the
    /// sizes of the tensions.
    #[inline(always)]
    fn bent<S: Scalar + Meets<P>>(
        &self,
        (bay, m, k): (&Bay<P>, usize, usize),
        (along, [pull, held]): (&[[S; 2]], [S; 2]),
        camber: &[S],
    ) -> [S; 2] {
        let (i, arc) = (bay.first + k, ARC[m]);
        let tie = |k: usize| bay.ties[k] * MEAN_SQUARE[m];
        let [before, here, behind] = [k, k + 1, k + 2].map(|k| self.height(bay, camber, k));
        let slope = self.width[i] / self.chord[i] * arc;
        let tangent = (along[k][1] + camber[i].squared() * (bay.stiffness * arc)) * slope
            + held * (tie(k) + tie(k + 1));
        let pulled = ((behind - here) * tie(k + 1) - (here - before) * tie(k)) * pull
            - along[k][0] * camber[i] * (self.width[i] * arc);
        [pulled, tangent]
    }

    /// Turns the loads of the strips of a bay on the shape `m`, which `rates` holds, into the rates: a symmetric tridiagonal system,
    /// diagonal and what is left of the load eliminated on the way.
    #[inline(never)]
    fn shape_rates<S: Scalar + Meets<P>>(
        &self,
        (bay, m): (&Bay<P>, usize),
        (along, [pull, held]): (&[[S; 2]], [S; 2]),
        (camber, resistance): (&[S], &[S]),
        rates: &mut [S],
    ) {
        let (first, count, mean) = (bay.first, bay.ties.len() - 1, MEAN_SQUARE[m]);
        let off = |k: usize| -(held * (bay.ties[k] * mean * self.damping));
        let mut diagonal = ArrayVec::<S, MAX_STRIPS>::new();
        for k in 0..count {
            let i = first + k;
            let [pulled, tangent] = self.bent((bay, m, k), (along, [pull, held]), camber);
            let mut pivot = tangent * self.damping + resistance[i];
            rates[i] += pulled;
            if k > 0 {
                let (share, ahead) = (off(k) / diagonal[k - 1], rates[i - 1]);
                pivot -= share * off(k);
                rates[i] -= share * ahead;
            }
            diagonal.push(pivot);
        }
        for i in (first..first + count).rev() {
            if i + 1 < first + count {
                let behind = rates[i + 1];
                rates[i] -= off(i + 1 - first) * behind;
            }
            rates[i] = rates[i] / diagonal[i - first];
        }
    }

    /// What its motion is held against at the strain `stretch` (dimensionless) along the chord, in air of the density `density`
    /// (kg/m3), sides let go.
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
        let mut scales = MembraneScales {
            frequency_hz: f64::INFINITY,
            damping_s: self.damping.value(),
            weight_rise: 0.0,
            mean_chord: self.chord.iter().map(|c| c.value()).sum::<f64>() / self.chord.len() as f64,
        };
        for bay in &self.bays {
            let chord = bay.strips().map(|i| self.chord[i].value()).fold(0.0, f64::max);
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
    /// Mean chord of the strips, m.
    pub mean_chord: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PlanformStation;
    use wingbeat_math::{Dual, RK4, Workspace};

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
        let grid = StripGrid {
            arcs: (0..6).map(|k| arc(k) + 0.05).collect(),
            control_arcs: (0..5).map(arc).collect(),
            fraction: vec![0.5; 5],
            covered: vec![true; 5],
            outline: vec![(0.1, -0.1); 6],
            between: vec![0.2; 5],
            bulge: vec![[0.0; 2]; 5],
            chord: vec![0.2; 5],
            width: vec![0.1; 5],
            cos_half: vec![1.0; 5],
            cos_three_quarter: vec![1.0; 5],
            mean_chord: 0.2,
            tip_to_tip: 1.0,
            aspect: 2.5,
            crowded: false,
            tip: 0.5,
            tip_chords: [0.2; 2],
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
                skin.rates(
                    [&camber[0], &camber[1]],
                    [&[1e-3; 5]; 2],
                    &[0.0; 5],
                    &mut [&mut first, &mut second],
                );
                (0..5).for_each(|i| camber[0][i] += 1e-4 * first[i] / 0.2);
            }
            // h = p c^2 / (8 T), T = E t (e_0 + (8/3)(h/c)^2).
            let tension = 100.0 * (prestrain + 8.0 / 3.0 * camber[0][2] * camber[0][2]);
            let exact = pressure * 0.2 / (8.0 * tension);
            assert!((camber[0][2] / exact - 1.0).abs() < 2e-3, "{prestrain}: {} {exact}", camber[0][2]);
        }
    }

    /// Without own damping and under a unit resistance the rates are minus the forces: taut, slack along the chord, along the span.
    #[test]
    fn the_forces_of_a_membrane_are_the_slopes_of_its_energy() {
        type D = Dual<10>;
        for (prestrain, span) in [(0.02, 0.01), (-0.004, 0.01), (0.01, -0.002), (-0.004, -0.002)] {
            let skin = Membrane { prestrain_span: span, ..held(prestrain, true, 0.0) };
            let value = |k: usize| 0.02 + 0.013 * (k as f64 * 1.7).sin();
            let camber: Shapes<[D; 5]> =
                std::array::from_fn(|m| std::array::from_fn(|i| D::variable(value(5 * m + i), 5 * m + i)));
            let mut rates = [[D::constant(0.0); 5]; MODES];
            let [first, second] = &mut rates;
            let (unit, none) = ([D::constant(1.0); 5], [D::constant(0.0); 5]);
            skin.rates([&camber[0], &camber[1]], [&unit; 2], &none, &mut [first, second]);
            // By the heights over the chord of 0.2 m.
            let slopes = skin.stored([&camber[0], &camber[1]]).eps.map(|slope| slope / 0.2);
            let size = slopes.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            for (k, slope) in slopes.into_iter().enumerate() {
                let lacking = (rates[k / 5][k % 5].re + slope).abs() / size;
                assert!(lacking < 1e-11, "{prestrain} {span} {k}: {lacking}");
            }
        }
    }

    /// Of strips that nothing holds, over a cycle of loads that has come to repeat: stored is the integral of the tension over the strain,
    /// lost (R + tau K) h'^2 with K the second derivative of what is stored by each height, the size of the tension rounded as everywhere.
    #[test]
    fn work_on_a_membrane_is_what_it_stores_and_loses() {
        let (tau, resistance, step) = (2e-3, 0.03, 2.5e-5);
        let skin = held(0.05, false, tau);
        let (c, dy, stiffness) = (0.2, 0.1, 100.0);
        let stretch = |h: [f64; 2]| 0.05 + 0.5 * (ARC[0] * h[0] * h[0] + ARC[1] * h[1] * h[1]);
        // The integral of (e + sqrt(e^2 + w^2))/2.
        let stored = |h: [f64; 2]| {
            let (e, w) = (stretch(h), STRAIN_WIDTH);
            0.25 * stiffness * c * dy * (e * e + e * e.hypot(w) + w * w * (e / w).asinh())
        };
        // Heights over the chord, work, loss and the size of the work.
        let rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), std::convert::Infallible> {
            let load = [0.02 + 0.05 * (40.0 * t).sin(), 0.02 * (80.0 * t).cos()];
            let h = [x[0], x[1]];
            let [mut first, mut second] = load.map(|load| [load; 5]);
            let heights: Shapes<&[f64]> = [&[h[0]; 5], &[h[1]; 5]];
            skin.rates(heights, [&[resistance; 5]; 2], &[0.0; 5], &mut [&mut first, &mut second]);
            dx.fill(0.0);
            for (m, rate) in [first[2], second[2]].into_iter().enumerate() {
                let taut = stretch(h).smooth_abs(DAMPED_WIDTH) + ARC[m] * h[m] * h[m];
                let tangent = ARC[m] * dy / c * stiffness * taut;
                dx[m] = rate / c;
                dx[2] += load[m] * rate;
                dx[3] += (resistance + tau * tangent) * rate * rate;
                dx[4] += (load[m] * rate).abs();
            }
            Ok(())
        };
        let (mut x, mut work) = ([0.03, -0.01, 0.0, 0.0, 0.0], Workspace::new(5, 4));
        let cycle = (TAU / 40.0 / step).round() as usize;
        let mut begun = x;
        for k in 0..2 * cycle {
            if k == cycle {
                begun = x;
            }
            RK4.step(rates, k as f64 * step, step, &mut x, &mut work).unwrap();
        }
        let [worked, lost, size] = [2, 3, 4].map(|i| x[i] - begun[i]);
        let lacking = (worked - lost - (stored([x[0], x[1]]) - stored([begun[0], begun[1]]))).abs() / size;
        assert!(lost > 0.05 * size && lacking < 1e-8, "{worked} {lost} {size}: {lacking}");
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
}
