//! What the edges of a wing do along its span: suction of swept leading edges and of side edges, and the vortices that take its place
//! above sharp tips.

use super::grid::StripGrid;
use super::response::StripResponse;
use super::settings::SpanForce;
use super::{StripFlow, StripModel};
use crate::section::SectionForce;
use arrayvec::ArrayVec;
use std::f64::consts::PI;
use wingbeat_math::{Meets, Over, Scalar};

/// Pull of a side edge over [`scale`] and products of the lift washes at the outermost strip: of the flat chord squared, twice the flat
/// chord times a parabolic camber, camber squared. What of the circulation G lies ahead of a point of the chord makes them: mean((A/G)^2)
/// is 0.615 of a flat section far from the tips and 0.72 beside them. *Fitted* to a vortex lattice of flat and evenly cambered rectangles
/// (`validation/lifting_surface/side_edges.csv`), as strips have a G beside the tips that is an eighth larger: at aspect ratios of 1, 2, 4
/// and 8 it has 0.61, 0.58, 0.57, 0.57 first, 0.22, 0.26, 0.28, 0.29 in the middle and 0.43, 0.35, 0.32, 0.31 last.
const PULL: [f64; 3] = [0.575, 0.273, 0.33];
/// The same times the distance behind mid chord over the chord: 0.045 to 0.049, 0.10 to 0.14, 0.088 to 0.090.
const PULL_BEHIND: [f64; 3] = [0.048, 0.11, 0.089];

/// Share of [`PULL`] that is counted to the circulation. *Choice*: of a wing that turns the impulse of the carried air has the other, whose F
/// is sqrt(1 - x^2)/pi from -1 to 1 along the chord, its square 2/(3 pi^2) of 0.615 in the mean; of a wing that does not turn the
/// ninth is missing.
const OF_CIRCULATION: f64 = 1.0 - 2.0 / (3.0 * PI * PI * 0.615);

/// Distance from a tip over the span at which strips tell what stays attached of the force of that tip. Of the outermost strip all stays as
/// it narrows, since its lift wash vanishes, and the force would grow with the number of strips. *Choice*: where the outermost of nine
/// strips of Aerobat lies.
const STATION: f64 = 0.025;

/// Wash below which its size is rounded off, so that it has a derivative, m/s. *Choice.*
const ROUNDING: f64 = 1e-9;

/// Force at a tip over the square of the wash there and [`PULL`], kg/m: rho (pi/16) (c b/(d (b - d))) slope^2, c the chord at the tip.
pub(super) fn scale<P: Scalar>(grid: &StripGrid<P>, i: usize, density: P, slope: P) -> P {
    let last = grid.width.len() - 1;
    let (from, to) = (grid.arcs[0], grid.arcs[last + 1]);
    let span = from - to;
    let at = grid.control_arcs[i];
    let (chord, inboard) = match i {
        0 => (grid.tip_chords[0], from - at),
        i if i == last => (grid.tip_chords[1], at - to),
        _ => return P::ZERO,
    };
    density * (PI / 16.0) * chord * span * slope * slope / (inboard * (span - inboard))
}

/// Where strips tell what stays attached of the pull of a tip.
#[derive(Clone, Debug)]
pub(super) struct TipStation<P> {
    /// The strips between whose control sections it lies, from the tip on.
    strips: [usize; 2],
    /// Weights of their shares.
    weights: [P; 2],
}

impl<P: Scalar> TipStation<P> {
    /// That of the left and of the right tip. Between two control sections shares go as a straight line over the square root of the
    /// distance, with which Lan's angle grows; of fewer strips, or beside a gap, the outermost counts alone.
    pub fn new(grid: &StripGrid<P>) -> [Self; 2] {
        let last = grid.width.len() - 1;
        let tips = [grid.arcs[0], grid.arcs[last + 1]];
        let station = ((tips[0] - tips[1]) * STATION).sqrt();
        [0, 1].map(|side| {
            let nth = |j: usize| if side == 0 { j } else { last - j };
            let root = |j: usize| ((grid.control_arcs[nth(j)] - tips[side]) * [-1.0, 1.0][side]).sqrt();
            let reached = (1..=last / 2).find(|j| root(*j) > station);
            let inner = reached.filter(|j| grid.covered[nth(*j)] && grid.covered[nth(j - 1)]).unwrap_or(0);
            let outer = inner.saturating_sub(1);
            let share = (station - root(outer)) / (root(inner) - root(outer));
            let share = if inner > 0 && share > P::ZERO { share } else { P::ZERO };
            Self { strips: [outer, inner].map(nth), weights: [P::ONE - share, share] }
        })
    }

    /// The mean of what `of` tells of its strips.
    #[inline(always)]
    fn mean<S: Scalar + Meets<P>>(&self, of: impl Fn(usize) -> S) -> S {
        of(self.strips[0]) * self.weights[0] + of(self.strips[1]) * self.weights[1]
    }
}

impl<P: Scalar> StripModel<P> {
    /// Force of the vortex of a side edge on the outermost strip `i`. At the distance d from a tip the circulation
    /// goes as G = k sqrt(d), of which the share F(x) lies ahead of the station x. The sheet there has the strength
    /// dG/dy = k F/(2 sqrt(d)), as that of a leading edge, 2 A/sqrt(d), which is pulled by pi rho A^2 for each length. The pull along the
    /// span is so (pi/16) rho k^2 c mean(F^2); where the flow leaves the edge it turns to the normal, on the side of the wash, whole and at
    /// once. What counts of the circulation is what stays attached at a fortieth of the span from the tip, so that the force has the square of
    /// that share. Between the tips
    /// of the span b an elliptic circulation has k^2 = G^2 b/(d (b - d)). The parts of flat chord and camber push each to its own side.
    ///
    /// Equation: aero.strip.side_edge
    /// `F = (pi/16) rho k^2 c mean(F^2), k^2 = G^2 b/(d (b - d)), G = g lw at the outermost strip, times the attached share at b/40`
    /// Source: Lamar 1974, NASA TR R-428 (side edges lose their suction as leading edges do, Polhamus 1966); own derivation; mean(F^2)
    /// by a vortex lattice; at once: a choice.
    /// Test: `side_edges_have_the_suction_of_a_vortex_lattice`.
    #[inline(never)]
    pub(super) fn side_edge<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
    ) -> SectionForce<S> {
        self.side_edge_of(i, response, response.at_tips[usize::from(i > 0)].squared())
    }

    /// The same, given the square of the attached share.
    fn side_edge_of<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
        shares: S,
    ) -> SectionForce<S> {
        let wash = response.lift_wash[i];
        let flat = response.camber.and_then(|camber| camber.flat.get(i)).copied().unwrap_or(wash);
        let camber = wash - flat;
        let [flat_size, camber_size] = [flat, camber].map(|wash| wash.smooth_abs(ROUNDING));
        let products = [flat * flat_size, flat * camber_size + camber * flat_size, camber * camber_size];
        let sum = |of: [f64; 3]| (0..3).fold(S::ZERO, |sum, k| sum + products[k] * of[k]) * shares;
        let scale = self.tables.side_edge[i];
        let mut force = SectionForce::in_plane(S::ZERO, sum(PULL) * scale, S::ZERO);
        force.nose_up = -(sum(PULL_BEHIND) * (scale * self.tables.chord[i]));
        force
    }

    /// What the circulation bears beside the plane of section `i`, whose `suction` points along the chord, N. A plate feels pressure along
    /// its normal and suction at its edges, square to them: at a leading edge swept by L the suction S has S tan(L) along the span, and the
    /// side edge at a tip has the pull of [`Self::side_edge`], outward, unless a vortex takes its place. Where the section drifts
    /// with the speed v along its span, the pressure is rho v dphi/dy less: the jump phi of the circulation G, with the integral
    /// b G along the chord, takes rho v d(bG)/dy but for what the trailing edge cuts off, rho v G tan, and so rho v b dG/dy at 5/8 of
    /// the chord, and gives rho v G tan of the half-chord line at its middle. Sweeps are those of the flat wing. Left out: the couple of
    /// the edges' suction about the normal, that of a taper, what of the tip's pull goes where the leading edge loses its suction, and what
    /// the root of a one-sided surface stands on: its circulation ends there as at a tip.
    /// The impulse of the carried air holds its own share of all this (`aero.strip.carried_air`), as what turns with the normal. With
    /// `edge_suction` alone.
    ///
    /// Equation: aero.strip.along_span
    /// `F = [S tan(sweep of leading edge) +- side edge] e_span - rho v_span dy [b dG/dy - G tan(sweep of half chord)] n, G = g lw`
    /// Source: Bernoulli on a lifting surface; suction square to an edge: Lamar 1974, NASA TR R-428; own derivation; flat
    /// sweeps a choice.
    /// Test: `suction_is_square_to_swept_edges`.
    #[inline(never)]
    pub(super) fn along_span<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        i: usize,
        flow: &StripFlow<K, G, N>,
        response: &StripResponse<'_, S, N>,
        suction: S,
    ) -> SectionForce<S> {
        let mut force = SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO);
        if i >= self.settings.strips {
            return force;
        }
        let (tables, last) = (&self.tables, self.settings.strips - 1);
        let own = self.bound(i, response.lift_wash[i], response.attached[i]);
        let [left, right] = self.edge_weights(i);
        let mut sum = own * (left + right);
        if i > 0 {
            sum += response.beside[i - 1] * left;
        }
        if i < last {
            sum += response.beside[i + 1] * right;
        }
        let drift = flow.strips.drift[i];
        force = self.spread(i, sum * drift);
        force.normal += own * tables.half_run[i] * drift;
        force.across = -(suction * tables.leading_slope[i]);
        if !self.settings.side_edges && (i == 0 || i == last) {
            force.across += self.pull(i, response, response.at_tips[usize::from(i > 0)].squared());
        }
        force
    }

    /// The pull of the tip of the outermost strip `i` along the span, N, given the square of the attached share.
    fn pull<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
        shares: S,
    ) -> S {
        let outward = if i == 0 { -1.0 } else { 1.0 };
        response.lift_wash[i].squared()
            * shares
            * (self.tables.side_edge[i] * (PULL[0] * OF_CIRCULATION * outward))
    }

    /// Circulation of the lift times the density, kg/(m s).
    #[inline(always)]
    pub(super) fn bound<S: Scalar + Meets<P>>(&self, i: usize, lift_wash: S, attached: S) -> S {
        lift_wash * attached * (self.tables.lift_scale[i] * self.tables.inverse_width[i])
    }

    /// What the sums of the circulation of section `i` and of that to its left and right weigh in b dG, m: half of them is that at an edge,
    /// which in Lan's angle lies midway; none at tips and gaps.
    #[inline(always)]
    pub(super) fn edge_weights(&self, i: usize) -> [P; 2] {
        let (joined, half) = (&self.tables.joined, self.tables.chord[i] * 0.5);
        [if i > 0 { joined[i - 1] * half } else { P::ZERO }, -(joined[i] * half)]
    }

    /// The force of a pressure that acts at 5/8 of the chord, N.
    #[inline(always)]
    pub(super) fn spread<S: Scalar + Meets<P>>(&self, i: usize, normal: S) -> SectionForce<S> {
        let mut force = SectionForce::in_plane(S::ZERO, normal, S::ZERO);
        force.nose_up = normal * (self.tables.chord[i] * -0.125);
        force
    }

    /// Whether the circulation pulls at the tips.
    #[inline(always)]
    pub(super) fn pulls_at_tips(&self) -> bool {
        self.span_force == SpanForce::Edges || self.settings.side_edges
    }

    /// The share of the circulation that stays attached beside the left and the right tip, of `own` of the outermost strips and
    /// `others` of those beside them.
    #[inline(always)]
    pub(super) fn at_tips<S: Scalar + Meets<P>>(&self, own: &[S], others: &[S]) -> [S; 2] {
        let outermost = [0, self.settings.strips - 1];
        let of = |tip: usize, k: usize| if k == outermost[tip] { own[k] } else { others[k] };
        [0, 1].map(|tip| self.tables.stations[tip].mean(|k| of(tip, k)))
    }

    /// The outermost strips, for each another that tells what stays attached there, and the force over the share of that, N.
    pub(super) fn by_shares<S: Scalar + Meets<P>, const N: usize>(
        &self,
        response: &StripResponse<'_, S, N>,
    ) -> ArrayVec<(usize, usize, SectionForce<S>), 4> {
        let mut forces = ArrayVec::new();
        for (tip, i) in [0, self.settings.strips - 1].into_iter().enumerate() {
            let TipStation { strips, weights } = &self.tables.stations[tip];
            for (&k, &weight) in strips.iter().zip(weights).filter(|(k, _)| **k != i) {
                let shares = response.at_tips[tip] * (weight * 2.0);
                let force = if self.settings.side_edges {
                    self.side_edge_of(i, response, shares)
                } else {
                    SectionForce {
                        across: self.pull(i, response, shares),
                        ..SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO)
                    }
                };
                forces.push((i, k, force));
            }
        }
        forces
    }

    /// Whether the strip `i` bears such a vortex.
    #[inline(always)]
    pub(super) fn has_side_edge(&self, i: usize) -> bool {
        self.settings.side_edges && (i == 0 || i + 1 == self.settings.strips)
    }
}
