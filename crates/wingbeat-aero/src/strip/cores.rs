//! Cores of the vortices: how near a vortex may come to a strip before its wash fades.
//!
//! On the flat wing a vortex and the strips it washes over pass one another at distances that the planform
//! gives. A wing that folds, or a wake that swings round at low airspeed, brings them nearer, down to nothing:
//! a line vortex of a discrete sheet would then be felt as a pulse shorter than any step, where the sheet that
//! it stands for is smooth. So the wash fades where the two come within a share k of their distance on
//! the flat wing, and is unchanged on the flat wing itself, whatever its strips.

use super::grid::StripGrid;
use super::influence::{NEAREST, segment_square};
use super::tables::StripConstants;
use wingbeat_math::{Scalar, Vec3};

/// Power of the squared distance at which the wash fades: sharp, so that wings that fold to half their
/// distances lose little of their interplay (2 % at k = 0.3).
const POWER: i32 = 4;

/// Cores of the vortices that leave an edge, for every strip, lengths over the mean chord.
#[derive(Clone, Debug)]
pub(super) struct EdgeCores<P = f64> {
    /// Least squared distance to an end of a vortex.
    pub least: P,
    /// Of the leg along the chord.
    pub leg: StripConstants<P>,
    /// Of the vortex behind the trailing edge.
    pub wake: StripConstants<P>,
    /// Of the line far behind, at the 1/4 chord points.
    pub far: StripConstants<P>,
}

/// Cores of the vortices along a strip, for every strip, lengths over the mean chord.
#[derive(Clone, Debug)]
pub(super) struct StripCores<P = f64> {
    /// Of the bound vortex.
    pub front: StripConstants<P>,
    /// Of the trailing edge.
    pub rear: StripConstants<P>,
}

/// Cores of all vortices.
#[derive(Clone, Debug)]
pub(super) struct Cores<P = f64> {
    /// One over the mean chord, 1/m: the scale of lengths.
    pub scale: P,
    /// Strength of a unit vortex: what the cores take from it on the flat wing is given back, and lengths are
    /// over the mean chord, 1/m.
    pub strength: P,
    pub edges: Vec<EdgeCores<P>>,
    pub strips: Vec<StripCores<P>>,
}

/// The flat wing, x forward and y to the left, lengths over the mean chord or as they are.
pub(super) struct Flat<'a, P> {
    grid: &'a StripGrid<P>,
    scale: P,
    /// (k^2)^4.
    fade: f64,
}

impl<'a, P: Scalar> Flat<'a, P> {
    /// With lengths in m, and no cores.
    pub fn plain(grid: &'a StripGrid<P>) -> Self {
        Self { grid, scale: P::ONE, fade: 0.0 }
    }
    /// The point of edge `j` at the chord fraction `x`, m or over the mean chord.
    pub fn edge(&self, j: usize, x: f64) -> Vec3<P> {
        let (leading, trailing) = self.grid.outline[j];
        Vec3([leading + (trailing - leading) * x, self.grid.arcs[j], P::ZERO]).scaled(self.scale)
    }
    /// The point of the control section of strip `i`, m or over the mean chord; lanes beyond the last strip repeat it.
    pub fn target(&self, i: usize, x: f64) -> Vec3<P> {
        let i = i.min(self.grid.chord.len() - 1);
        let (a, b) = (self.edge(i, x), self.edge(i + 1, x));
        a + (b - a).scaled(self.grid.fraction[i])
    }
    /// The cores from the measures y0 that the washes of one vortex fall by.
    fn cores(&self, y0: impl Fn(usize) -> P) -> StripConstants<P> {
        std::array::from_fn(|i| y0(i).powi(POWER) * self.fade)
    }
    fn along(&self, a: Vec3<P>, b: Vec3<P>) -> StripConstants<P> {
        self.cores(|i| {
            let p = self.target(i, 0.75);
            segment_square((b - a).norm_squared(), [(p - a).norm(), (p - b).norm()])
        })
    }
    /// r (r - u.r) behind `trailing`, u straight back; without the difference where it cancels.
    fn behind(&self, trailing: Vec3<P>) -> StripConstants<P> {
        self.cores(|i| {
            let r = self.target(i, 0.75) - trailing;
            let (length, ahead) = (r.norm(), r[0]);
            if ahead.value() > 0.0 {
                length * (length + ahead)
            } else {
                length * r[1] * r[1] / (length - ahead)
            }
        })
    }
}

impl<P: Scalar> Cores<P> {
    /// The cores of a planform; `share` is k, dimensionless. With y what the wash of a vortex falls by, and y0 its value on the
    /// flat wing, the wash is taken (1 + k^8) y^4 / (y^4 + (k^2 y0)^4) times; y goes with the square of the distance near a
    /// vortex, whose wash is halved k distances off.
    ///
    /// Equation: aero.strip.core_distance
    /// `y0 the value on the flat wing of what the wash falls by; strengths times 1 + k^8`
    /// Source: choice: nothing changes on the flat wing.
    /// Test: `cores_of_left_and_right_mirror_each_other`.
    pub fn new(grid: &StripGrid<P>, share: f64) -> Self {
        let scale = grid.mean_chord.recip();
        let flat = Flat { grid, scale, fade: (share * share).powi(POWER) };
        let edge = |(j, half): (usize, P)| {
            let (bound, trailing) = (flat.edge(j, 0.25), flat.edge(j, 1.0));
            EdgeCores {
                least: (half * share * scale).powi(2) * NEAREST,
                leg: flat.along(bound, trailing),
                wake: flat.behind(trailing),
                far: flat.cores(|i| (flat.target(i, 0.25)[1] - bound[1]).powi(2)),
            }
        };
        let strip = |j: usize| {
            let line = |x: f64| flat.along(flat.edge(j, x), flat.edge(j + 1, x));
            StripCores { front: line(0.25), rear: line(1.0) }
        };
        let edges = grid.half_widths().enumerate().map(edge).collect();
        let strips = (0..grid.chord.len()).map(strip).collect();
        Self { scale, strength: scale * (1.0 + flat.fade), edges, strips }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Planform, PlanformStation};

    #[test]
    fn cores_of_left_and_right_mirror_each_other() {
        let rows = [[0.0, 0.02, -0.14], [0.07, 0.035, -0.15], [0.15, 0.08, -0.02], [0.2, 0.06, 0.04]];
        let stations = rows.map(|[arc_m, leading_edge_m, trailing_edge_m]| PlanformStation {
            arc_m,
            leading_edge_m,
            trailing_edge_m,
        });
        let planform = Planform::new(&stations).unwrap();
        for n in [8, 9, 16] {
            let cores = Cores::new(&StripGrid::new(&planform, n, &[0.02, 0.07], true).unwrap(), 0.3);
            let alike = |a: &StripConstants, b: &StripConstants| {
                (0..n).all(|i| (a[i] / b[n - 1 - i] - 1.0).abs() < 1e-11)
            };
            for (a, b) in cores.edges.iter().zip(cores.edges.iter().rev()) {
                assert!(alike(&a.leg, &b.leg) && alike(&a.wake, &b.wake) && alike(&a.far, &b.far));
            }
            for (a, b) in cores.strips.iter().zip(cores.strips.iter().rev()) {
                assert!(alike(&a.front, &b.front) && alike(&a.rear, &b.rear));
            }
        }
    }
}
