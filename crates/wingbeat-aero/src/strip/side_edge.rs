//! Vortices above the side edges of a wing: what a sharp tip loses of its suction pushes along the normal there.

use super::StripModel;
use super::grid::StripGrid;
use super::response::StripResponse;
use crate::section::SectionForce;
use std::f64::consts::PI;
use wingbeat_math::{Meets, Over, Scalar};

/// Mean over the chord at a side edge of products of the shares of the circulation that lie ahead of a point, of the flat chord with
/// itself, with a parabolic camber, and of the camber with itself. Of flat and evenly cambered rectangles by a vortex lattice, 10 x 80:
/// 0.70 to 0.77, 0.20 to 0.31 and 0.26 to 0.27 at aspect ratios of 1 to 8; taken at 2. A long wing far from its tips has 0.615, 0.445 and
/// 0.356: near a tip the load lies further ahead.
const AHEAD: [f64; 3] = [0.72, 0.26, 0.26];
/// The same products times the distance behind mid chord over the chord: there 0.06 to 0.08, 0.10 to 0.12 and 0.06 to 0.09.
const BEHIND_MIDDLE: [f64; 3] = [0.07, 0.11, 0.07];

/// Force at a tip over the square of the wash there and what [`AHEAD`] says, kg/m: rho (pi/16) (c b/(d (b - d))) slope^2.
pub(super) fn scale<P: Scalar>(grid: &StripGrid<P>, i: usize, density: P, slope: P) -> P {
    let last = grid.width.len() - 1;
    let (from, to) = (grid.arcs[0], grid.arcs[last + 1]);
    let span = from - to;
    let at = grid.control_arcs[i];
    let inboard = if i == 0 { from - at } else { at - to };
    if i == 0 || i == last {
        density * (PI / 16.0) * grid.chord[i] * span * slope * slope / (inboard * (span - inboard))
    } else {
        P::ZERO
    }
}

impl<P: Scalar> StripModel<P> {
    /// Force of the vortex of a side edge on the outermost strip `i`, none on the others. At the distance d from a tip the circulation
    /// goes as G = k sqrt(d), of which the share F(x) lies ahead of the station x. The sheet there has the strength
    /// dG/dy = k F/(2 sqrt(d)), as that of a leading edge, 2 A/sqrt(d), which is pulled by pi rho A^2 for each length. The pull along the
    /// span is so (pi/16) rho k^2 c mean(F^2); where the flow leaves the edge it turns to the normal, on the side of the wash, whole and at
    /// once, as far as the flow is attached. Between the tips of the span b an elliptic circulation has
    /// k^2 = G^2 b/(d (b - d)).
    ///
    /// Equation: aero.strip.side_edge
    /// `F = (pi/16) rho k^2 c mean(F^2), k^2 = G^2 b/(d (b - d)), G = g lw at the outermost strip, of the attached share`
    /// Source: Lamar 1974, NASA TR R-428 (side edges lose their suction as leading edges do, Polhamus 1966); own derivation; mean(F^2)
    /// by a vortex lattice; at once: a choice.
    /// Test: `side_edges_have_the_suction_of_a_vortex_lattice`.
    #[inline(always)]
    pub(super) fn side_edge<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        response: &StripResponse<'_, S, N>,
    ) -> Option<SectionForce<S>> {
        let at_tip = i == 0 || i + 1 == self.settings.strips;
        if !(self.settings.side_edges && at_tip) {
            return None;
        }
        let wash = response.lift_wash[i];
        let flat = response.camber.and_then(|camber| camber.flat.get(i)).copied().unwrap_or(wash);
        let camber = wash - flat;
        let products = [flat.squared(), flat * camber * 2.0, camber.squared()];
        let side = wash * wash.smooth_abs(self.floor).recip() * response.attached[i];
        let sum = |of: [f64; 3]| (0..3).fold(S::ZERO, |sum, k| sum + products[k] * of[k]) * side;
        let scale = self.tables.side_edge[i];
        let mut force = SectionForce::in_plane(S::ZERO, sum(AHEAD) * scale, S::ZERO);
        force.nose_up = -(sum(BEHIND_MIDDLE) * (scale * self.tables.chord[i]));
        Some(force)
    }
}
