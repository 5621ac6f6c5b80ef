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

/// Pull of a side edge over what [`pull_of_square`] makes of products of circulations: that of the flat chord squared, twice the flat
/// chord times a parabolic camber, camber squared. What of the circulation G lies ahead of a point of the chord makes them: mean((A/G)^2)
/// is 0.615 of a flat section far from the tips and 0.72 beside them. *Fitted* to a vortex lattice of flat and evenly cambered rectangles
/// (`validation/lifting_surface/side_edges.csv`), as strips have a G beside the tips of their own: at aspect ratios of 1, 2, 4
/// and 8 it has 0.82, 0.79, 0.79, 0.79 first, 0.29, 0.35, 0.37, 0.39 in the middle and 0.57, 0.47, 0.43, 0.41 last.
const PULL: [f64; 3] = [0.795, 0.363, 0.438];
/// The same times the distance behind mid chord over the chord: 0.061 to 0.067, 0.13 to 0.19, 0.117 to 0.120.
const PULL_BEHIND: [f64; 3] = [0.0663, 0.146, 0.118];

/// Share of [`PULL`] that is counted to the circulation. *Choice*: of a wing that turns the impulse of the carried air has the other, whose F
/// is sqrt(1 - x^2)/pi from -1 to 1 along the chord, its square 2/(3 pi^2) of 0.615 in the mean; of a wing that does not turn the
/// ninth is missing.
const OF_CIRCULATION: f64 = 1.0 - 2.0 / (3.0 * PI * PI * 0.615);

/// Distance from a tip over the mean chord at which the circulation tells the force of the side edge. What stays attached of the outermost strip
/// rises to one as it narrows, since its lift wash vanishes, so that its own circulation would tell another force of every number of
/// strips. *Choice*: where the outermost of eight strips lies at an aspect ratio of 5.
const STATION: f64 = 0.15;

/// Wash below which its size is rounded off, so that it has a derivative, m/s. *Choice.*
const ROUNDING: f64 = 1e-9;

/// Force at a tip over the square of the wash there and [`PULL`], kg/m: rho (pi/16) (c b/(d (b - d))) slope^2, c the chord at the tip.
pub(super) fn scale<P: Scalar>(grid: &StripGrid<P>, i: usize, density: P, slope: P) -> P {
    let (last, span) = (grid.width.len() - 1, grid.tip * 2.0);
    let (chord, inboard) = match i {
        0 => (grid.tip_chords[0], grid.tip - grid.control_arcs[0]),
        i if i == last => (grid.tip_chords[1], grid.tip + grid.control_arcs[last]),
        _ => return P::ZERO,
    };
    pull_of_square(chord, span, inboard) * density * slope * slope
}

/// Pull of a side edge over the square of the circulation at the distance d from the tip, density and [`PULL`]:
/// (pi/16) c b/(d (b - d)).
fn pull_of_square<P: Scalar>(chord: P, span: P, distance: P) -> P {
    chord * span / (distance * (span - distance)) * (PI / 16.0)
}

/// How the circulation beside a tip pulls along the span.
#[derive(Clone, Debug)]
pub(super) struct TipPull<P> {
    /// The strips that tell the circulation at the station, and their weights.
    strips: [usize; 3],
    weights: [P; 3],
    /// Pull over the square of circulation times density and [`PULL`], m3/kg.
    scale: P,
}

impl<P: Scalar> TipPull<P> {
    /// The pulls, N, of the left and of the right tip in air of `density`, kg/m3. The circulation goes as a parabola over the square root of
    /// the distance from the tip, through the control sections beside the station and the next. Where the station lies beyond the outermost section, or
    /// beside a gap, that section tells. Under separation the place matters: k^2 at 0.3 mean chords is 0.64 of that at 0.1 under law
    /// `stall` at 25 deg.
    pub(super) fn new(grid: &StripGrid<P>, density: P) -> [Self; 2] {
        let (last, span) = (grid.width.len() - 1, grid.tip * 2.0);
        [(0, -1.0), (1, 1.0)].map(|(side, outward)| {
            let nth = |j: usize| if side == 0 { j } else { last - j };
            let distance = |j: usize| grid.tip + grid.control_arcs[nth(j)] * outward;
            let of = |strips, weights, at| {
                let of_square = pull_of_square(grid.tip_chords[side], span, at);
                Self { strips, weights, scale: of_square / density }
            };
            let station = grid.mean_chord * STATION;
            let inner = (1..last).find(|j| distance(*j) > station).filter(|_| distance(0) < station);
            let strips = inner.map(|j| [j - 1, j, j + 1].map(nth));
            let Some(strips) = strips.filter(|strips| strips.iter().all(|i| grid.covered[*i])) else {
                return of([nth(0); 3], [P::ONE, P::ZERO, P::ZERO], distance(0));
            };
            let at = station.sqrt();
            let roots = strips.map(|i| (grid.tip + grid.control_arcs[i] * outward).sqrt());
            let over = |k: usize, other: usize| (at - roots[other]) / (roots[k] - roots[other]);
            of(strips, [0, 1, 2].map(|k| over(k, (k + 1) % 3) * over(k, (k + 2) % 3)), station)
        })
    }

    /// The circulation at the station.
    #[inline(always)]
    fn circulation<S: Scalar + Meets<P>>(&self, of: impl Fn(usize) -> S) -> S {
        let of = |k: usize| of(self.strips[k]) * self.weights[k];
        of(0) + of(1) + of(2)
    }
}

impl<P: Scalar> StripModel<P> {
    /// Force of the vortex of a side edge on the outermost strip `i`. At the distance d from a tip the circulation
    /// goes as G = k sqrt(d), of which the share F(x) lies ahead of the station x. The sheet there has the strength
    /// dG/dy = k F/(2 sqrt(d)), as that of a leading edge, 2 A/sqrt(d), which is pulled by pi rho A^2 for each length. The pull along the
    /// span is so (pi/16) rho k^2 c mean(F^2); where the flow leaves the edge it turns to the normal, on the side of the wash, whole and at
    /// once. What counts of the circulation is what stays attached, so that the force has the square of that share. Between the tips
    /// of the span b an elliptic circulation has k^2 = G^2 b/(d (b - d)). The parts of flat chord and camber push each to its own side;
    /// where there is camber the outermost strip tells G, else the distance of 0.15 mean chords.
    ///
    /// Equation: aero.strip.side_edge
    /// `F = (pi/16) rho k^2 c mean(F^2), k^2 = G^2 b/(d (b - d)), G = g lw times the attached share, at 0.15 mean chords`
    /// Source: Lamar 1974, NASA TR R-428 (side edges lose their suction as leading edges do, Polhamus 1966); own derivation; mean(F^2)
    /// by a vortex lattice; at once: a choice.
    /// Test: `side_edges_have_the_suction_of_a_vortex_lattice`.
    #[inline(never)]
    pub(super) fn side_edge<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
    ) -> SectionForce<S> {
        let mut force = SectionForce::in_plane(S::ZERO, S::ZERO, S::ZERO);
        let Some(camber) = response.camber else {
            let (tip, chord) = (self.tip(i), self.tables.chord[i]);
            let circulation = self.at_tip(i, response);
            let square = circulation * circulation.smooth_abs(ROUNDING) * tip.scale;
            force.normal = square * PULL[0];
            force.nose_up = -(square * (chord * PULL_BEHIND[0]));
            return force;
        };
        let wash = response.lift_wash[i];
        let flat = camber.flat.get(i).copied().unwrap_or(wash);
        let bulge = wash - flat;
        let [flat_size, bulge_size] = [flat, bulge].map(|wash| wash.smooth_abs(ROUNDING));
        let products = [flat * flat_size, flat * bulge_size + bulge * flat_size, bulge * bulge_size];
        let share = response.attached[i].squared();
        let sum = |of: [f64; 3]| (0..3).fold(S::ZERO, |sum, k| sum + products[k] * of[k]) * share;
        let scale = self.tables.side_edge[i];
        force.normal = sum(PULL) * scale;
        force.nose_up = -(sum(PULL_BEHIND) * (scale * self.tables.chord[i]));
        force
    }

    /// How the tip beside the outermost strip `i` pulls.
    #[inline(always)]
    fn tip(&self, i: usize) -> &TipPull<P> {
        &self.tables.tips[usize::from(i > 0)]
    }

    /// The circulation times density beside the tip at the outermost strip `i`, kg/(m s).
    #[inline(always)]
    fn at_tip<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
    ) -> S {
        let own = self.bound(i, response.lift_wash[i], response.attached[i]);
        self.tip(i).circulation(|k| if k == i { own } else { response.beside[k] })
    }

    /// What the circulation bears beside the plane of section `i`, whose `suction` points along the chord, N. A plate feels pressure along
    /// its normal and suction at its edges, square to them: at a leading edge swept by L the suction S has S tan(L) along the span, and the
    /// side edge at a tip has the pull of [`Self::side_edge`], outward, unless a vortex takes its place; there G is that at the distance of
    /// 0.15 mean chords. Where the section drifts
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
            let pull = self.at_tip(i, response).squared() * self.tip(i).scale * (PULL[0] * OF_CIRCULATION);
            force.across += if i == 0 { -pull } else { pull };
        }
        force
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

    /// Whether the circulation makes a force at the tips.
    #[inline(always)]
    pub(super) fn pulls_at_tips(&self) -> bool {
        self.span_force == SpanForce::Edges || self.settings.side_edges
    }

    /// The outermost strips, for each another whose circulation times density, given `of` all strips, makes a force at the tip there, and
    /// the force, m2/s, and moment, m3/s, over it.
    pub(super) fn by_others(
        &self,
        of: impl Fn(usize) -> P + Copy,
    ) -> ArrayVec<(usize, usize, SectionForce<P>), 6> {
        let mut forces = ArrayVec::new();
        let (vortices, last) = (self.settings.side_edges, self.settings.strips - 1);
        if !self.pulls_at_tips() || (vortices && self.membrane.is_some()) {
            return forces;
        }
        for (i, outward) in [(0, -1.0), (last, 1.0)] {
            let (tip, chord) = (self.tip(i), self.tables.chord[i]);
            let slope = tip.circulation(of) * tip.scale * 2.0;
            for (&k, &weight) in tip.strips.iter().zip(&tip.weights).filter(|(k, _)| **k != i) {
                let mut force = SectionForce::in_plane(P::ZERO, P::ZERO, P::ZERO);
                if vortices {
                    let size = slope.smooth_abs(ROUNDING) * weight;
                    force.normal = size * PULL[0];
                    force.nose_up = -(size * (chord * PULL_BEHIND[0]));
                } else {
                    force.across = slope * weight * (PULL[0] * OF_CIRCULATION * outward);
                }
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
