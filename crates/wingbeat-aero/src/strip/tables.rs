//! What of each strip never changes, padded so that loops over lanes need no end.

use super::carried_place::carried_places;
use super::constants::jump_weights;
use super::grid::StripGrid;
use super::reach::SpanReach;
use super::side_edge::{self, TipPull};
use super::{Lags, StripSettings};
use crate::{LagNumbers, MAX_STRIPS, MAX_WASH_LAGS, SurfaceNumbers};
use arrayvec::ArrayVec;
use std::f64::consts::PI;
use wingbeat_math::Scalar;

/// A constant per strip, left tip to right tip, padded.
pub(super) type StripConstants<P = f64> = [P; MAX_STRIPS];

/// Constants of the strips. Extra lanes repeat the last strip; what scales a force or a mass is
/// zero there, so that sums may run over all lanes.
#[derive(Clone, Debug)]
pub(super) struct Tables<P: Scalar> {
    /// One on the wing, zero in a gap.
    pub covered: StripConstants<P>,
    /// Place of the control section between the strip's edges, 0 to 1, and its 1/4, 1/2 and 3/4 chord as fractions of the chord that
    /// straight lines between the edges have there.
    pub fraction: StripConstants<P>,
    pub quarter: StripConstants<P>,
    pub half: StripConstants<P>,
    pub three_quarter: StripConstants<P>,
    /// Chord, m.
    pub chord: StripConstants<P>,
    /// One over the half chord, 1/m.
    pub turnover: StripConstants<P>,
    /// Lift slope of the section over that of a thin plate.
    pub slope_share: P,
    /// Circulation over lift wash a0 b cos(sweep), m.
    pub slope: StripConstants<P>,
    /// Potential jump over the wash that the lags leave on the chord, m: what the circulation has beyond the chord
    /// doublet, so that the two are one in steady flow; 2 pi b cos(sweep) / 1.5 of a thin plate.
    pub jump: StripConstants<P>,
    /// Chord doublet over wash, pi b cos(sweep) / 1.5, m.
    pub doublet: StripConstants<P>,
    /// Its inverse, 1/m; zero in a gap.
    pub inverse_doublet: StripConstants<P>,
    /// Own two-dimensional wash of the bound vortex, 1/m.
    pub own_bound: StripConstants<P>,
    /// Own two-dimensional wash of bound vortex and trailing edge, 1/m.
    pub own_ring: StripConstants<P>,
    /// Circulatory force over wash and speed, rho dy a0 b cos(sweep), kg/m.
    pub lift_scale: StripConstants<P>,
    /// One over the width, 1/m; zero in a gap.
    pub inverse_width: StripConstants<P>,
    /// One half where the strip and the next to the right carry, else zero.
    pub joined: StripConstants<P>,
    /// How far aft the leading edge runs over the width.
    pub leading_slope: StripConstants<P>,
    /// How far aft the half-chord line runs, m.
    pub half_run: StripConstants<P>,
    /// Force of the vortex of a side edge over the square of the wash, kg/m: that of the two outermost strips.
    pub side_edge: StripConstants<P>,
    /// Pulls of the left and the right tip along the span.
    pub tips: [TipPull<P>; 2],
    /// How far along the span the incidence reaches that separates the flow.
    pub reach: SpanReach<P>,
    /// Profile drag over speed squared and coefficient, rho c dy / 2, kg/m.
    pub drag_scale: StripConstants<P>,
    /// Leading-edge suction over wash squared and `drag_scale`: a0 cos(sweep).
    pub edge_slope: StripConstants<P>,
    /// Share of the wing's area.
    pub share: StripConstants<P>,
    /// Added mass as part of an infinite wing, kg.
    pub mass: StripConstants<P>,
    /// How far behind mid chord the wash drives the carried air and its force acts, m, where it is not at mid chord.
    pub behind: Option<StripConstants<P>>,
    /// Weight of the wash that acts at once in the lift wash: 1/2 with the weights that the set of lags has.
    pub at_once: P,
    /// Lags of the wash on the chord of this wing, and their weights in the circulation.
    pub lags: ArrayVec<LagNumbers<P>, MAX_WASH_LAGS>,
    pub circulation: ArrayVec<P, MAX_WASH_LAGS>,
    /// Weights of the lags in the potential jump left on the chord.
    pub jump_weights: ArrayVec<P, MAX_WASH_LAGS>,
    /// One over the lengths over which the wake lags act, 1/m.
    pub inverse_wake_length: Vec<P>,
    /// Square of the mean chord, m2, and one over its sum with that of the distance between the tips of the flat wing, 1/m2.
    pub chord_square: P,
    pub inverse_reach: P,
}

impl<P: Scalar> Tables<P> {
    /// Where the control section of strip `i` lies between its edges, and where its 1/4, 1/2 and 3/4 chord lie behind them, as fractions.
    #[inline(always)]
    pub fn section(&self, i: usize) -> [P; 4] {
        [self.fraction[i], self.quarter[i], self.half[i], self.three_quarter[i]]
    }

    pub fn new(
        grid: &StripGrid<P>,
        settings: &StripSettings,
        numbers: &SurfaceNumbers<P>,
        lags: &Lags,
    ) -> Self {
        let last = settings.strips - 1;
        let (chord, cos, cos34) = (&grid.chord, &grid.cos_half, &grid.cos_three_quarter);
        let repeated =
            |f: &dyn Fn(usize) -> P| -> StripConstants<P> { std::array::from_fn(|i| f(i.min(last))) };
        // What a gap carries is nothing: its neighbours then shed at its two borders.
        let carried = |f: &dyn Fn(usize) -> P| repeated(&|i| if grid.covered[i] { f(i) } else { P::ZERO });
        let scale = |f: &dyn Fn(usize) -> P| -> StripConstants<P> {
            let value = carried(&|i| grid.width[i] * f(i));
            std::array::from_fn(|i| if i > last { P::ZERO } else { numbers.density * value[i] })
        };
        let covered = (0..=last).filter(|i| grid.covered[*i]);
        let area = covered.fold(P::ZERO, |sum, i| sum + chord[i] * grid.width[i]);
        let half_slope = numbers.section_slope * 0.5;
        // How far aft the line at the share `x` of the chord runs from left to right.
        let run = |i: usize, x: f64| {
            let ahead = |(leading, trailing): (P, P)| leading + (trailing - leading) * x;
            ahead(grid.outline[i]) - ahead(grid.outline[i + 1])
        };
        // Vortices lie on the lines between edges, the control point on the section of the strip.
        let own_bound = |i: usize| {
            let behind = chord[i] * 0.75 - grid.bulge[i][0] - grid.between[i] * 0.25;
            (behind * (2.0 * PI) * cos[i]).recip()
        };
        let place =
            |x: f64| repeated(&|i| (chord[i] / grid.between[i]) * x - grid.bulge[i][0] / grid.between[i]);
        let delay_scale = grid.mean_chord * grid.aspect.powf(lags.exponent);
        let (own_lags, circulation) = lags.of_wing(&numbers.lags, grid.aspect);
        Self {
            covered: carried(&|_| P::ONE),
            fraction: repeated(&|i| grid.fraction[i]),
            quarter: place(0.25),
            half: place(0.5),
            three_quarter: place(0.75),
            chord: repeated(&|i| chord[i]),
            turnover: repeated(&|i| P::from(2.0) / chord[i]),
            slope_share: numbers.section_slope / (2.0 * PI),
            slope: carried(&|i| chord[i] * cos[i]).map(|width| half_slope * width),
            jump: carried(&|i| chord[i] * cos[i]).map(|width| (half_slope - PI / 3.0) * width),
            doublet: carried(&|i| chord[i] * PI * cos[i] / 3.0),
            inverse_doublet: carried(&|i| P::from(3.0) / (chord[i] * PI * cos[i])),
            own_bound: repeated(&own_bound),
            own_ring: repeated(&|i| {
                let ahead = grid.between[i] + grid.bulge[i][0] - chord[i] * 0.75;
                own_bound(i) + (ahead * (2.0 * PI) * cos34[i]).recip()
            }),
            lift_scale: scale(&|i| chord[i] * cos[i]).map(|scale| half_slope * scale),
            inverse_width: carried(&|i| grid.width[i].recip()),
            joined: std::array::from_fn(|i| {
                let both = i < last && grid.covered[i] && grid.covered[i + 1];
                if both { P::from(0.5) } else { P::ZERO }
            }),
            leading_slope: carried(&|i| run(i, 0.0) / grid.width[i]),
            half_run: carried(&|i| run(i, 0.5)),
            side_edge: std::array::from_fn(|i| {
                if i > last {
                    P::ZERO
                } else {
                    side_edge::scale(grid, i, numbers.density, half_slope * chord[i] * cos[i])
                }
            }),
            tips: TipPull::new(grid, numbers.density),
            reach: SpanReach::new(grid),
            drag_scale: scale(&|i| chord[i] * 0.5),
            edge_slope: carried(&|i| cos[i]).map(|cosine| numbers.section_slope * cosine),
            share: std::array::from_fn(|i| {
                if i > last || !grid.covered[i] { P::ZERO } else { chord[i] * grid.width[i] / area }
            }),
            mass: scale(&|i| chord[i] * PI * chord[i] * cos[i] / 4.0)
                .map(|mass| mass * numbers.added_mass_scale),
            behind: (settings.doublet_wash && settings.flap.is_none() && settings.membrane.is_none())
                .then(|| carried_places(grid, lags.doublet))
                .map(|places| repeated(&|i| places[i])),
            at_once: numbers
                .lags
                .iter()
                .zip(lags.lift)
                .fold(P::from(0.5), |rest, (lag, weight)| rest - (lag.weight - *weight)),
            jump_weights: jump_weights(&own_lags, &circulation),
            lags: own_lags,
            circulation,
            chord_square: grid.mean_chord.squared(),
            inverse_reach: (grid.mean_chord.squared() + grid.tip_to_tip.squared()).recip(),
            inverse_wake_length: lags.wake_delay.iter().map(|t| (delay_scale * *t).recip()).collect(),
        }
    }
}
