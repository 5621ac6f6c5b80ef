//! How far along the span the incidence reaches that separates the flow.

use super::grid::StripGrid;
use super::tables::StripConstants;
use crate::MAX_STRIPS;
use wingbeat_math::{Meets, Scalar};

/// Length over which the incidence that separates the flow spreads along the span, over the chord. *Choice* just above a bound. Past stall
/// the circulation falls as the wash grows, so that without a reach neighbours may rest at either side of the stall, and the result goes
/// with the number of strips. An infinite wing has one state of rest where 1 + (pi/4) k [f + w f' / (1 + (r k)^2)] is positive for all
/// waves k (per chord) along the span, f = 1/(1 + (w/w_s)^4) of the wash w, and k/4 the wash of a wave of unit circulation: from r = 0.151
/// on. From 0.15 to 0.25 the attached lift of rectangles of aspect ratio 4 at 25 deg moves by +2.2 % under law
/// `lev` and by -5.3 % under `lev3d`, the normal force of such a one of 2 under `lev3d`, with its plate's part, by +3.4 %.
const REACH: f64 = 0.16;

/// The incidence by which strips separate, spread along the span: a tridiagonal matrix, factorised.
#[derive(Clone, Debug)]
pub(super) struct SpanReach<P> {
    /// What of a strip's own value counts, of the sum before it, and of the result behind it.
    own: StripConstants<P>,
    before: StripConstants<P>,
    behind: StripConstants<P>,
}

impl<P: Scalar> SpanReach<P> {
    /// Of the strips of a wing; nothing reaches over a gap.
    pub(super) fn new(grid: &StripGrid<P>) -> Self {
        let last = grid.width.len() - 1;
        let zero = [P::ZERO; MAX_STRIPS];
        let mut reach = Self { own: zero, before: zero, behind: zero };
        // What of r^2 c^2 dq/dy passes the edge to the right of a strip, m, over the difference of q.
        let passes = |i: usize| {
            if i >= last || !grid.covered[i] || !grid.covered[i + 1] {
                return P::ZERO;
            }
            let length = (grid.chord[i] + grid.chord[i + 1]) * (0.5 * REACH);
            length.squared() / (grid.control_arcs[i] - grid.control_arcs[i + 1])
        };
        let mut from_left = P::ZERO;
        for i in 0..=last {
            let (left, right) = (if i > 0 { passes(i - 1) } else { P::ZERO }, passes(i));
            let pivot = (grid.width[i] + left + right - left * from_left).recip();
            (reach.own[i], reach.before[i], reach.behind[i]) =
                (grid.width[i] * pivot, left * pivot, right * pivot);
            from_left = reach.behind[i];
        }
        reach
    }

    /// Spreads the squared sines q_0 of the incidence of each strip: their mean over the span stays, and none goes beyond the largest or
    /// below the least.
    ///
    /// Equation: aero.strip.reach
    /// `q - d/dy(r^2 c^2 dq/dy) = q_0, dq/dy = 0 at tips and gaps, r = 0.16: q is the sin^2 a of the separated share`
    /// Source: own derivation; artificial viscosity along the span: Chattot 2004 (there of the circulation); r a choice above a bound.
    /// Test: `a_wing_past_stall_has_one_state_of_rest`.
    #[inline(always)]
    pub(super) fn spread<S: Scalar + Meets<P>>(&self, squares: &mut [S]) {
        let mut before = S::ZERO;
        for (i, value) in squares.iter_mut().enumerate() {
            *value = *value * self.own[i] + before * self.before[i];
            before = *value;
        }
        let mut behind = S::ZERO;
        for (i, value) in squares.iter_mut().enumerate().rev() {
            *value += behind * self.behind[i];
            behind = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Gap, Planform, PlanformStation};

    #[test]
    fn what_spreads_keeps_its_mean_and_stays_on_its_side_of_a_gap() {
        let station =
            |arc_m, chord: f64| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -chord };
        let planform = Planform::new(&[station(0.0, 0.1), station(0.3, 0.04)]).unwrap();
        let grid = StripGrid::new(&planform, 12, &[], true).unwrap();
        let mean = |of: &[f64]| of.iter().zip(&grid.width).map(|(q, width)| q * width).sum::<f64>();
        let mut squares: Vec<f64> = (0..12).map(|i| 0.5 + 0.5 * f64::from(3 * i % 7).sin()).collect();
        let before = squares.clone();
        let reach = SpanReach::new(&grid);
        reach.spread(&mut squares);
        assert!((mean(&squares) - mean(&before)).abs() < 1e-15);
        let ends = |of: &[f64]| of.iter().fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(*q), b.max(*q)));
        let ((least, most), (least_before, most_before)) = (ends(&squares), ends(&before));
        assert!(least > least_before && most < most_before);
        let mut same = vec![0.3; 12];
        reach.spread(&mut same);
        assert!(same.iter().all(|q| (q - 0.3).abs() < 1e-15));

        let gap = Gap { from_arc_m: 0.0, to_arc_m: 0.05 };
        let parted = StripGrid::new(&planform.with_gaps(&[gap]).unwrap(), 12, &[], true).unwrap();
        let mut one: Vec<f64> = parted.control_arcs.iter().map(|arc| f64::from(*arc > 0.05)).collect();
        let begun = one.clone();
        SpanReach::new(&parted).spread(&mut one);
        assert!(one.iter().zip(&begun).all(|(now, then)| (now - then).abs() < 1e-15));
    }
}
