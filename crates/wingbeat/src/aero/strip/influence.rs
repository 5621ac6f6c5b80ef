//! Wash of bound vortices, trailing legs and wake on all strips at once.
//!
//! Matrices are stored by columns: `m[j][i]` is the wash of strip j on strip i,
//! so that the inner loops run over strips without a gap and vectorise.

use super::motion::{Edge, Strip};
use crate::math::{Scalar, Vec3};
use std::f64::consts::PI;

/// A number per strip.
pub(super) type Column<S, const N: usize> = [S; N];
/// A number per pair of strips, `m[source][target]`.
pub(super) type Matrix<S, const N: usize> = [[S; N]; N];

const INVERSE_4PI: f64 = 0.25 / PI;

/// Points of all strips by component, where the wash is wanted.
struct Points<S, const N: usize> {
    x: [S; N],
    y: [S; N],
    z: [S; N],
}

impl<S: Scalar, const N: usize> Points<S, N> {
    fn new(strips: &[Strip<S>; N], of: impl Fn(&Strip<S>) -> Vec3<S>) -> Self {
        let at = |k: usize| std::array::from_fn(|i| of(&strips[i])[k]);
        Self { x: at(0), y: at(1), z: at(2) }
    }
    #[inline(always)]
    fn get(&self, i: usize) -> Vec3<S> {
        Vec3([self.x[i], self.y[i], self.z[i]])
    }
}

/// Where the wash is taken: 3/4 chord points, 1/4 chord points, normals.
pub(super) struct Targets<S, const N: usize> {
    control: Points<S, N>,
    bound: Points<S, N>,
    normal: Points<S, N>,
}

/// Normal wash of the trailing vortex of one edge, of unit strength, on all strips.
pub(super) struct Trailing<S, const N: usize> {
    /// Distance of the control points to the edge's bound point and trailing edge.
    to_bound: Column<S, N>,
    to_trailing: Column<S, N>,
    /// From the bound point to the trailing edge.
    leg: Column<S, N>,
    /// From the trailing edge to infinity.
    wake: Column<S, N>,
    /// Half the wash far behind, taken at the 1/4 chord points.
    far: Column<S, N>,
}

impl<S: Scalar, const N: usize> Trailing<S, N> {
    const ZERO: Self = {
        let zero = [S::ZERO; N];
        Self { to_bound: zero, to_trailing: zero, leg: zero, wake: zero, far: zero }
    };
}

/// Normal wash of a strip's vortex of unit strength on all strips.
pub(super) struct Wash<S, const N: usize> {
    /// Closed ring from the quarter chord to the trailing edge.
    pub ring: Matrix<S, N>,
    /// The horseshoe: ring and wake together.
    pub horseshoe: Matrix<S, N>,
    /// Half the wash far behind (Munk): the wash that turns the force.
    pub far: Matrix<S, N>,
}

/// A quotient whose division waits, so that several share one.
#[derive(Clone, Copy)]
struct Ratio<S> {
    above: S,
    below: S,
}

/// x / y, falling to zero below `core2`: x y / (y^2 + core2^2). It differs from x / y
/// by (core2 / y)^2, which the vortex's own strips hardly feel.
#[inline(always)]
fn cored<S: Scalar>(x: S, y: S, core2: f64) -> Ratio<S> {
    Ratio { above: x * y, below: y.mul_add(y, S::from(core2 * core2)) }
}

/// a . b + c with fused products.
#[inline(always)]
fn fused<S: Scalar>(a: Vec3<S>, b: Vec3<S>, c: S) -> S {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2].mul_add(b[2], c)))
}

/// a x b with fused products.
#[inline(always)]
fn cross<S: Scalar>(a: Vec3<S>, b: Vec3<S>) -> Vec3<S> {
    let part = |j: usize, k: usize| a[j].mul_add(b[k], -(a[k] * b[j]));
    Vec3([part(1, 2), part(2, 0), part(0, 1)])
}

/// Normal velocity of a straight vortex of unit strength along `d`, from whose ends r1 and
/// r2 = r1 - d lead to the target at the distances a and b:
/// n . (d x r1) (a + b) / (4 pi a b (a b + r1.r2)), regular on the extension of the segment.
///
/// Equation: aero.strip.segment
#[inline(always)]
fn segment<S: Scalar>(
    d: Vec3<S>,
    r1: Vec3<S>,
    r2: Vec3<S>,
    [a, b]: [S; 2],
    n: Vec3<S>,
    core2: f64,
) -> Ratio<S> {
    let ab = a * b;
    let turn = fused(cross(n, d), r1, S::ZERO) * INVERSE_4PI;
    let Ratio { above, below } = cored(turn * (a + b), fused(r1, r2, ab), core2);
    Ratio { above, below: below * ab }
}

/// Both quotients by one division.
#[inline(always)]
fn divide<S: Scalar>(p: Ratio<S>, q: Ratio<S>) -> (S, S) {
    let inverse = (p.below * q.below).recip();
    (p.above * q.below * inverse, q.above * p.below * inverse)
}

impl<S: Scalar, const N: usize> Targets<S, N> {
    pub fn new(strips: &[Strip<S>; N]) -> Self {
        Self {
            control: Points::new(strips, |s| s.three_quarter),
            bound: Points::new(strips, |s| s.quarter),
            normal: Points::new(strips, |s| s.normal),
        }
    }

    /// Leg along the chord, semi-infinite vortex u x r / (4 pi |r| (|r| - u.r)) from the
    /// trailing edge along u, and, far behind, half of the two-dimensional vortex
    /// u x r / (2 pi |r_perp|^2).
    ///
    /// Equation: aero.strip.trailing_vortex
    fn trailing(&self, edge: &Edge<S>, core2: f64, out: &mut Trailing<S, N>) {
        let (u, chord) = (edge.wake, edge.trailing - edge.bound);
        let least = S::from(core2 * 1e-6);
        for i in 0..N {
            let (p, n) = (self.control.get(i), self.normal.get(i));
            let (ra, rt) = (p - edge.bound, p - edge.trailing);
            let (a, b) = (fused(ra, ra, least).sqrt(), fused(rt, rt, least).sqrt());
            let leg = segment(chord, ra, rt, [a, b], n, core2);
            let around = cross(n, u);
            let wake = cored(fused(around, rt, S::ZERO), b * (b - fused(u, rt, S::ZERO)), core2);
            let r = self.bound.get(i) - edge.bound;
            let ahead = fused(r, u, S::ZERO);
            let off2 = fused(r, r, -(ahead * ahead));
            let far = cored(fused(around, r, S::ZERO), off2, core2);
            let (both, far) = divide(Ratio { above: S::ONE, below: leg.below * wake.below }, far);
            out.to_bound[i] = a;
            out.to_trailing[i] = b;
            out.leg[i] = leg.above * wake.below * both;
            out.wake[i] = wake.above * leg.below * both * INVERSE_4PI;
            out.far[i] = far * INVERSE_4PI;
        }
    }

    /// Wash of the rings and horseshoes between the `edges`, and far behind; `cores` are the
    /// squared core radii of the vortices that leave the edges, m2.
    pub fn wash(&self, edges: &[Edge<S>], cores: &[f64]) -> Wash<S, N> {
        let zero = [[S::ZERO; N]; N];
        let mut out = Wash { ring: zero, horseshoe: zero, far: zero };
        let mut beside = [Trailing::ZERO; 2];
        self.trailing(&edges[0], cores[0], &mut beside[0]);
        for (j, pair) in edges.windows(2).enumerate() {
            self.trailing(&pair[1], cores[j + 1], &mut beside[(j + 1) % 2]);
            let [left, right] = [&beside[j % 2], &beside[(j + 1) % 2]];
            let core2 = cores[j].min(cores[j + 1]);
            let [ahead, behind] = [pair[1].bound - pair[0].bound, pair[0].trailing - pair[1].trailing];
            for i in 0..N {
                let (p, n) = (self.control.get(i), self.normal.get(i));
                let (r1, r2) = (p - pair[0].bound, p - pair[1].bound);
                let front = segment(ahead, r1, r2, [left.to_bound[i], right.to_bound[i]], n, core2);
                let (r1, r2) = (p - pair[1].trailing, p - pair[0].trailing);
                let rear = segment(behind, r1, r2, [right.to_trailing[i], left.to_trailing[i]], n, core2);
                let (front, rear) = divide(front, rear);
                let open = front + right.leg[i] - left.leg[i];
                out.ring[j][i] = open + rear;
                out.horseshoe[j][i] = open + right.wake[i] - left.wake[i];
                out.far[j][i] = right.far[i] - left.far[i];
            }
        }
        out
    }
}

/// sum_j m[j] v[j], over the first `n` sources.
#[inline(always)]
pub(super) fn multiply<S: Scalar, const N: usize>(
    m: &Matrix<S, N>,
    v: &Column<S, N>,
    n: usize,
) -> Column<S, N> {
    let mut sum = [S::ZERO; N];
    for (column, x) in m.iter().zip(v).take(n) {
        for i in 0..N {
            sum[i] = column[i].mul_add(*x, sum[i]);
        }
    }
    sum
}

/// v . m[j] for each of the first `n` sources, over the first `n` targets.
#[inline(always)]
pub(super) fn multiply_transposed<S: Scalar, const N: usize>(
    m: &Matrix<S, N>,
    v: &Column<S, N>,
    n: usize,
) -> Column<S, N> {
    let mut sum = [S::ZERO; N];
    for (x, column) in sum.iter_mut().zip(m).take(n) {
        *x = dot(column, v, n);
    }
    sum
}

/// a . b over the first `n` entries.
#[inline(always)]
pub(super) fn dot<S: Scalar, const N: usize>(a: &Column<S, N>, b: &Column<S, N>, n: usize) -> S {
    let mut lanes = [S::ZERO; 4];
    for (a, b) in a[..n].chunks_exact(4).zip(b[..n].chunks_exact(4)) {
        for k in 0..4 {
            lanes[k] = a[k].mul_add(b[k], lanes[k]);
        }
    }
    let mut sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    for i in n - n % 4..n {
        sum = a[i].mul_add(b[i], sum);
    }
    sum
}

/// Inverse of the leading `n` x `n` block of `m` by Gauss-Jordan elimination
/// without exchanges, in place. The matrices met here are positive definite up to a diagonal scaling,
/// for which this is stable (Golub & Van Loan, Matrix Computations, 4.2.2).
pub(super) fn invert<S: Scalar, const N: usize>(m: &mut Matrix<S, N>, n: usize) {
    for k in 0..n {
        let pivot = m[k][k].recip();
        // One more on the diagonal leaves -factor in place of what is eliminated.
        let mut column = m[k];
        column[k] += S::ONE;
        for (j, other) in m.iter_mut().enumerate().take(n) {
            if j == k {
                continue;
            }
            let factor = -(other[k] * pivot);
            for i in 0..N {
                other[i] = column[i].mul_add(factor, other[i]);
            }
        }
        for i in 0..N {
            m[k][i] = column[i] * pivot;
        }
        m[k][k] = pivot;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        let mut m: Matrix<f64, 8> =
            std::array::from_fn(|j| std::array::from_fn(|i| 0.1 * ((3 * i + 5 * j) as f64).sin()));
        for i in 0..8 {
            m[i][i] += 1.0;
        }
        let original = m;
        invert(&mut m, 6);
        for j in 0..6 {
            let mut column = m[j];
            column[6..].fill(0.0);
            let product = multiply(&original, &column, 6);
            for i in 0..6 {
                assert!((product[i] - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_long_segment_is_half_a_line_vortex_on_each_side() {
        let (r1, r2) = (Vec3::new(0.3, 1e4, 0.0), Vec3::new(0.3, -1e4, 0.0));
        let n = Vec3::new(0.0, 0.0, 1.0);
        let Ratio { above, below } = segment(r1 - r2, r1, r2, [r1.norm(), r2.norm()], n, 1e-12);
        let value = above / below;
        assert!((value.abs() / (1.0 / (2.0 * PI * 0.3)) - 1.0).abs() < 1e-6);
        assert!(value < 0.0);
    }
}
