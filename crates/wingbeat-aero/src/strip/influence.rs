//! Wash of bound vortices, trailing legs and wake on all strips at once.
//!
//! Matrices are stored by columns: `m[j][i]` is the wash of strip j on strip i,
//! so that the inner loops run over strips without a gap and vectorise.

use super::cores::{Cores, EdgeCores, StripCores};
use super::motion::{StripEdge, Strips, Vectors, Wakes};
use super::slopes::{WakeSlopes, by_slopes};
use std::f64::consts::PI;
use std::ops::Range;
use wingbeat_math::{Dual, Meets, Over, Scalar, Vec3};

/// A number per strip.
pub(super) type StripColumn<S, const N: usize> = [S; N];
/// A number per pair of strips, `m[source][target]`.
pub(super) type Matrix<S, const N: usize> = [[S; N]; N];

pub(super) const INVERSE_4PI: f64 = 0.25 / PI;
/// Smallest squared distance to the end of a vortex over its squared core radius.
pub(super) const NEAREST: f64 = 1e-6;

/// How many of the `N` lanes of a column of so many `strips` are computed. Of plain numbers all, so that loops over them have a fixed
/// end and vectorise; what is larger, with derivatives or of several robots, is computed for strips alone, and is zero beyond.
#[inline(always)]
pub(super) fn lanes<S, const N: usize>(strips: usize) -> usize {
    if plain::<S>() { N } else { strips.min(N) }
}

/// Whether numbers fill a register side by side.
#[inline(always)]
pub(super) const fn plain<S>() -> bool {
    size_of::<S>() <= size_of::<f64>()
}

/// A column of so many `strips`, of which element `i` is `of(i)`. What has many derivatives is written once, though it is copied then, where
/// a column set to zero first is written twice.
#[inline(always)]
pub(super) fn column<S: Scalar, const N: usize>(
    strips: usize,
    mut of: impl FnMut(usize) -> S,
) -> StripColumn<S, N> {
    if const { large::<S>() } {
        return std::array::from_fn(|i| if i < strips { of(i) } else { S::ZERO });
    }
    let mut column = [S::ZERO; N];
    for i in 0..lanes::<S, N>(strips) {
        column[i] = of(i);
    }
    column
}

/// Whether a number takes more than a register.
#[inline(always)]
pub(super) const fn large<S>() -> bool {
    size_of::<S>() > 4 * size_of::<f64>()
}

/// Where the wash is taken, and of what direction: points and the lines n through them. Lengths are over the mean
/// chord, so that their high powers stay far from the ends of the numbers.
pub(super) struct Targets<'a, P: Scalar, K: Scalar, const N: usize> {
    pub cores: &'a Cores<P>,
    strips: usize,
    pub at: &'a TargetPlaces<K, N>,
}

/// Places of [`Targets`].
pub(super) struct TargetPlaces<K, const N: usize> {
    /// 3/4 and 1/4 chord points.
    pub control: Vectors<K, N>,
    pub bound: Vectors<K, N>,
    /// Normals over 4 pi, with their moments about the origin at both points.
    pub normal: Vectors<K, N>,
    control_moment: Vectors<K, N>,
    bound_moment: Vectors<K, N>,
    /// Points and normals without derivatives; written where slopes are wanted.
    pub values: [Vectors<f64, N>; 3],
}

impl<K: Scalar, const N: usize> TargetPlaces<K, N> {
    pub const ZERO: Self = {
        let zero = Vectors::ZERO;
        let values = [Vectors::ZERO; 3];
        Self { control: zero, bound: zero, normal: zero, control_moment: zero, bound_moment: zero, values }
    };
}

/// A straight line as direction and moment about the origin (Pluecker coordinates).
#[derive(Clone, Copy)]
pub(super) struct PlueckerLine<S: Scalar> {
    pub direction: Vec3<S>,
    pub moment: Vec3<S>,
}

/// Normal wash of the trailing vortex of one edge, of unit strength, on all strips.
pub(super) struct Trailing<K, S, const N: usize> {
    /// Distance of the control points to the edge's bound point and trailing edge.
    to_bound: StripColumn<K, N>,
    to_trailing: StripColumn<K, N>,
    /// From the bound point to the trailing edge.
    leg: StripColumn<K, N>,
    /// From the trailing edge to infinity.
    wake: StripColumn<S, N>,
    /// Half the wash far behind, taken at the 1/4 chord points.
    far: StripColumn<S, N>,
}

impl<K: Scalar, S: Over<K>, const N: usize> Trailing<K, S, N> {
    pub const ZERO: Self = {
        let (still, zero) = ([K::ZERO; N], [S::ZERO; N]);
        Self { to_bound: still, to_trailing: still, leg: still, wake: zero, far: zero }
    };
}

/// What edges and strips make on the way.
pub(super) struct Beside<K, S, const N: usize> {
    edges: [Trailing<K, S, N>; 2],
    pub slopes: WakeSlopes<N>,
}

impl<K: Scalar, S: Over<K>, const N: usize> Beside<K, S, N> {
    pub const ZERO: Self = Self { edges: [Trailing::ZERO; 2], slopes: WakeSlopes::ZERO };
}

/// Normal wash of a strip's vortex of unit strength on all strips.
pub(super) struct Wash<'a, K, S, const N: usize> {
    /// Closed ring from the quarter chord to the trailing edge.
    pub ring: &'a mut Matrix<K, N>,
    /// The horseshoe: ring and wake together.
    pub horseshoe: &'a mut Matrix<S, N>,
    /// Half the wash far behind (Munk): the wash that turns the force.
    pub far: &'a mut Matrix<S, N>,
}

/// A quotient whose division waits, so that several share one.
#[derive(Clone, Copy)]
pub(super) struct Ratio<S> {
    above: S,
    below: S,
}

/// x / y, falling to zero below the core: x y / (y^2 + core4).
#[inline(always)]
pub(super) fn cored<S: Scalar>(x: S, y: S, core4: S) -> Ratio<S> {
    Ratio { above: x * y, below: y.mul_add(y, core4) }
}

/// x / y, falling to zero where y is less than the core: x y^3 / (y^4 + core4).
///
/// Equation: aero.strip.core
/// `x y^3 / (y^4 + (k^2 y0)^4) in place of x / y`
/// Source: choice: the wash of a vortex fades within k of its distance on the flat wing.
/// Test: `a_flight_converges_with_the_step`.
#[inline(always)]
fn faded<P, S: Scalar + Meets<P>>(x: S, y: S, core4: P) -> Ratio<S> {
    let y2 = y.squared();
    Ratio { above: x * (y2 * y), below: y2.squared_add(S::from(core4)) }
}

/// a b + r1.r2 = ((a + b)^2 - d^2) / 2 at the distances a and b from the ends of a segment of length d: by its
/// smallness the wash of the segment grows.
#[inline(always)]
pub(super) fn segment_square<S: Scalar>(d2: S, [a, b]: [S; 2]) -> S {
    (a + b).squared_add(-d2) * 0.5
}

/// The wash of [`segment`] with the core of [`faded`].
#[inline(always)]
fn faded_segment<P, S: Scalar + Meets<P>>(turn: S, d2: S, ends: [S; 2], core4: P) -> Ratio<S> {
    if S::CARRIES {
        let [a, b] = ends;
        let inverse = segment_square(d2, ends).faded_inverse(S::from(core4));
        return Ratio { above: turn * (a + b) * inverse, below: a * b };
    }
    segment(turn, d2, ends, |x, y| faded(x, y, core4))
}

/// a . b + c with fused products.
#[inline(always)]
fn fused<K: Scalar, S: Over<K>>(a: Vec3<S>, b: Vec3<K>, c: S) -> S {
    a[0].fused(b[0], a[1].fused(b[1], a[2].fused(b[2], c)))
}

/// a . a + c with fused products.
#[inline(always)]
fn fused_square<K: Scalar, S: Over<K>>(a: Vec3<K>, c: S) -> S {
    c.plus_square(a[2]).plus_square(a[1]).plus_square(a[0])
}

impl<S: Scalar> PlueckerLine<S> {
    /// Along `direction`, in m or of length 1, through `point`, m.
    #[inline(always)]
    pub fn new<K: Scalar>(point: Vec3<K>, direction: Vec3<S>) -> Self
    where
        S: Over<K>,
    {
        Self { direction, moment: point.cross_over(direction) }
    }
    /// n . (d x r), in m times the units of both directions, for r from this line, of direction d, to a point on the line n.
    #[inline(always)]
    pub fn turn<K: Scalar>(&self, n: &PlueckerLine<K>) -> S
    where
        S: Over<K>,
    {
        fused(self.direction, n.moment, fused(self.moment, n.direction, S::ZERO))
    }
}

/// Normal velocity of a straight vortex of unit strength along `d`, 4 pi `turn` = n . (d x r)
/// with r from the vortex to the target, at the distances a and b from its ends:
/// n . (d x r) (a + b) / (4 pi a b (a b + r1.r2)), regular on the extension of the segment;
/// 2 (a b + r1.r2) = (a + b)^2 - d^2. `core` makes the last quotient.
///
/// Equation: aero.strip.segment
/// `n . (d x r) (a + b) / (4 pi a b (a b + r1.r2)), 2 (a b + r1.r2) = (a + b)^2 - d^2`
/// Source: Biot & Savart; Katz & Plotkin 2001, section 10.4.5, rearranged.
/// Test: `a_long_segment_is_half_a_line_vortex_on_each_side`.
#[inline(always)]
pub(super) fn segment<S: Scalar>(
    turn: S,
    d2: S,
    [a, b]: [S; 2],
    core: impl FnOnce(S, S) -> Ratio<S>,
) -> Ratio<S> {
    let Ratio { above, below } = core(turn * (a + b), segment_square(d2, [a, b]));
    Ratio { above, below: below * (a * b) }
}

impl<S: Scalar> Ratio<S> {
    #[inline(always)]
    fn quotient(self) -> S {
        self.above / self.below
    }
}

/// Both quotients by one division, where the numbers have room for it.
#[inline(always)]
pub(super) fn divide<S: Scalar>(p: Ratio<S>, q: Ratio<S>) -> (S, S) {
    if S::NARROW {
        return (p.quotient(), q.quotient());
    }
    let inverse = (p.below * q.below).recip();
    (p.above * q.below * inverse, q.above * p.below * inverse)
}

impl<'a, P: Scalar, K: Scalar + Meets<P>, const N: usize> Targets<'a, P, K, N> {
    pub fn new<S: Over<K>>(
        strips: &Strips<K, S, N>,
        cores: &'a Cores<P>,
        places: &'a mut TargetPlaces<K, N>,
    ) -> Self {
        let count = cores.strips.len();
        let TargetPlaces { control, bound, normal, control_moment, bound_moment, values } = &mut *places;
        for i in 0..lanes::<K, N>(count) {
            let n = strips.normal.get(i).scaled(cores.strength * INVERSE_4PI);
            let at = |points: &Vectors<K, N>| points.get(i).scaled(cores.scale);
            let (p, q) = (at(&strips.three_quarter), at(&strips.quarter));
            normal.set(i, n);
            control.set(i, p);
            bound.set(i, q);
            if const { by_slopes::<P, K, S>() } {
                values.iter_mut().zip([p, q, n]).for_each(|(values, v)| values.set(i, v.values()));
                continue;
            }
            control_moment.set(i, p.cross(n));
            bound_moment.set(i, q.cross(n));
        }
        Self { cores, strips: count, at: places }
    }

    /// Edge `j` as seen from here.
    #[inline(always)]
    pub fn edge<S: Over<K>>(&self, wakes: &Wakes<K, S, N>, j: usize) -> StripEdge<K, S> {
        let StripEdge { bound, trailing, wake } = wakes.edge(j);
        let scale = self.cores.scale;
        StripEdge { bound: bound.scaled(scale), trailing: trailing.scaled(scale), wake }
    }

    /// The normal of strip `i` through its 3/4 chord point, over 4 pi.
    #[inline(always)]
    fn at_control(&self, i: usize) -> PlueckerLine<K> {
        PlueckerLine { direction: self.at.normal.get(i), moment: self.at.control_moment.get(i) }
    }

    /// Leg along the chord, semi-infinite vortex u x r / (4 pi |r| (|r| - u.r)) from the
    /// trailing edge along u, and, far behind, half of the two-dimensional vortex
    /// u x r / (2 pi |r_perp|^2).
    ///
    /// Equation: aero.strip.trailing_vortex
    /// `u x r / (4 pi r (r - u.r)); far behind half of u x r / (2 pi r_perp^2)`
    /// Source: Biot & Savart; Munk 1921, NACA Rep. 121.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface_and_the_drag_of_their_wake`.
    fn trailing<S: Over<K> + Meets<P>>(
        &self,
        edge: &StripEdge<K, S>,
        cores: &EdgeCores<P>,
        out: &mut Trailing<K, S, N>,
    ) {
        if const { size_of::<K>() < size_of::<S>() } {
            return self.trailing_turned(edge, cores, out);
        }
        let (u, chord) = (edge.wake, edge.trailing - edge.bound);
        let chord2 = chord.norm_squared();
        let (leg, wake) = (PlueckerLine::new(edge.bound, chord), PlueckerLine::new(edge.trailing, u));
        let behind = PlueckerLine::new(edge.bound, u);
        let (u_trailing, u_bound) = (edge.trailing.dot_over(u), edge.bound.dot_over(u));
        let least = K::from(cores.least);
        for i in 0..lanes::<S, N>(self.strips) {
            let (p, n) = (self.at.control.get(i), self.at_control(i));
            let (ra, rt) = (p - edge.bound, p - edge.trailing);
            let (a, b) = (fused_square(ra, least).sqrt(), fused_square(rt, least).sqrt());
            let leg = faded_segment(leg.turn(&n), chord2, [a, b], cores.leg[i]);
            let behind_edge = (u_trailing + b - fused(u, p, S::ZERO)) * b;
            let wake_turn = wake.turn(&n);
            let q = self.at.bound.get(i);
            let r = q - edge.bound;
            let ahead = fused(u, q, -u_bound);
            let n = PlueckerLine { direction: n.direction, moment: self.at.bound_moment.get(i) };
            let (far_turn, beside2) = (behind.turn(&n), fused_square(r, -ahead.squared()));
            out.to_bound[i] = a;
            out.to_trailing[i] = b;
            if S::CARRIES {
                out.leg[i] = leg.quotient();
                out.wake[i] = wake_turn * behind_edge.faded_inverse(S::from(cores.wake[i]));
                out.far[i] = far_turn * beside2.faded_inverse(S::from(cores.far[i]));
                continue;
            }
            let wake = faded(wake_turn, behind_edge, cores.wake[i]);
            let far = faded(far_turn, beside2, cores.far[i]);
            if S::NARROW {
                (out.leg[i], out.wake[i], out.far[i]) = (leg.quotient(), wake.quotient(), far.quotient());
                continue;
            }
            let (both, far) = divide(Ratio { above: S::ONE, below: wake.below * leg.below }, far);
            out.leg[i] = (wake.below * leg.above * both).beneath();
            out.wake[i] = wake.above * leg.below * both;
            out.far[i] = far;
        }
    }

    /// As [`trailing`](Self::trailing), where of the edge the wake's direction u alone carries more derivatives: those of the wash by u
    /// are found first, and once. With t = n . (u x r) and f(y) = y^3/(y^4 + core^4) the wash is t f(y): of the wake y = r (r - u.r), by
    /// u f (r x n) - t f' |r| r; far behind y = r^2 - (u.r)^2, by u f (r x n) - 2 t f' (u.r) r.
    fn trailing_turned<S: Over<K> + Meets<P>>(
        &self,
        edge: &StripEdge<K, S>,
        cores: &EdgeCores<P>,
        out: &mut Trailing<K, S, N>,
    ) {
        let (u, chord) = (edge.wake.beneath::<K>(), edge.trailing - edge.bound);
        let chord2 = chord.norm_squared();
        let (leg, wake) = (PlueckerLine::new(edge.bound, chord), PlueckerLine::new(edge.trailing, u));
        let behind = PlueckerLine::new(edge.bound, u);
        let (u_trailing, u_bound) = (edge.trailing.dot_over(u), edge.bound.dot_over(u));
        let least = K::from(cores.least);
        let faded = |y: K, core4: P| {
            let faded = Dual::<1, K>::variable(y, 0).faded_inverse(Dual::constant(K::from(core4)));
            (faded.re, faded.eps[0])
        };
        let mut wash = [[K::ZERO; N]; 2];
        let mut by = [Vectors::<K, N>::ZERO; 2];
        for i in 0..lanes::<K, N>(self.strips) {
            let (p, n) = (self.at.control.get(i), self.at_control(i));
            let (ra, rt) = (p - edge.bound, p - edge.trailing);
            let (a, b) = (fused_square(ra, least).sqrt(), fused_square(rt, least).sqrt());
            (out.to_bound[i], out.to_trailing[i]) = (a, b);
            out.leg[i] = faded_segment(leg.turn(&n), chord2, [a, b], cores.leg[i]).quotient();
            let turn = wake.turn(&n);
            let (f, slope) = faded((u_trailing + b - fused(u, p, K::ZERO)) * b, cores.wake[i]);
            wash[0][i] = turn * f;
            by[0].set(i, rt.cross(n.direction) * f - rt * (turn * slope * b));
            let q = self.at.bound.get(i);
            let (r, ahead) = (q - edge.bound, fused(u, q, -u_bound));
            let n = PlueckerLine { direction: n.direction, moment: self.at.bound_moment.get(i) };
            let turn = behind.turn(&n);
            let (f, slope) = faded(fused_square(r, -ahead.squared()), cores.far[i]);
            wash[1][i] = turn * f;
            by[1].set(i, r.cross(n.direction) * f - r * (turn * slope * ahead * 2.0));
        }
        let turned = [0, 1, 2].map(|k| edge.wake[k] - u[k]);
        for (k, out) in [&mut out.wake, &mut out.far].into_iter().enumerate() {
            let [x, y, z] = &by[k].0;
            for i in 0..lanes::<S, N>(self.strips) {
                let sum = turned[0].fused(x[i], S::from(wash[k][i]));
                out[i] = turned[2].fused(z[i], turned[1].fused(y[i], sum));
            }
        }
    }

    /// Wash of the rings and horseshoes between the edges of the first `n` strips, and far behind.
    pub fn wash<S: Over<K> + Meets<P>>(
        &self,
        wakes: &Wakes<K, S, N>,
        n: usize,
        beside: &mut Beside<K, S, N>,
        out: &mut Wash<'_, K, S, N>,
    ) {
        if const { by_slopes::<P, K, S>() } {
            return self.wash_by_slopes(wakes, n, &mut beside.slopes, out);
        }
        let (cores, beside) = (self.cores, &mut beside.edges);
        // The left and the right edge take turns, as their columns do: nothing is moved.
        let mut edges = [self.edge(wakes, 0); 2];
        self.trailing(&edges[0], &cores.edges[0], &mut beside[0]);
        for j in 0..n {
            edges[(j + 1) % 2] = self.edge(wakes, j + 1);
            self.trailing(&edges[(j + 1) % 2], &cores.edges[j + 1], &mut beside[(j + 1) % 2]);
            let edges = [&edges[j % 2], &edges[(j + 1) % 2]];
            let (left, right) = (&beside[j % 2], &beside[(j + 1) % 2]);
            let (ring, horseshoe, far) = (&mut out.ring[j], &mut out.horseshoe[j], &mut out.far[j]);
            if S::CARRIES {
                self.strip(&edges, left, right, &cores.strips[j], ring, horseshoe, far);
            } else {
                self.strip_apart(&edges, left, right, &cores.strips[j], ring, horseshoe, far);
            }
        }
    }

    /// As [`strip`](Self::strip), of plain numbers. The columns come one by one, to a function that stays one: only as arguments
    /// are they known to lie apart, without which a loop over twelve strips is not vectorised.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is written lies apart from what is read")]
    fn strip_apart<S: Over<K> + Meets<P>>(
        &self,
        edges: &[&StripEdge<K, S>; 2],
        left: &Trailing<K, S, N>,
        right: &Trailing<K, S, N>,
        cores: &StripCores<P>,
        ring: &mut StripColumn<K, N>,
        horseshoe: &mut StripColumn<S, N>,
        far: &mut StripColumn<S, N>,
    ) {
        self.strip(edges, left, right, cores, ring, horseshoe, far);
    }

    /// Columns of the strip between two edges.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what is written lies apart from what is read")]
    fn strip<S: Over<K> + Meets<P>>(
        &self,
        edges: &[&StripEdge<K, S>; 2],
        left: &Trailing<K, S, N>,
        right: &Trailing<K, S, N>,
        cores: &StripCores<P>,
        ring: &mut StripColumn<K, N>,
        horseshoe: &mut StripColumn<S, N>,
        far: &mut StripColumn<S, N>,
    ) {
        let [ahead, behind] = [edges[1].bound - edges[0].bound, edges[0].trailing - edges[1].trailing];
        let lines = [PlueckerLine::new(edges[0].bound, ahead), PlueckerLine::new(edges[1].trailing, behind)];
        let lengths = [ahead.norm_squared(), behind.norm_squared()];
        for i in 0..lanes::<S, N>(self.strips) {
            let n = self.at_control(i);
            let ends = [left.to_bound[i], right.to_bound[i]];
            let front = segment(lines[0].turn(&n), lengths[0], ends, |x, y| faded(x, y, cores.front[i]));
            let ends = [right.to_trailing[i], left.to_trailing[i]];
            let rear = segment(lines[1].turn(&n), lengths[1], ends, |x, y| faded(x, y, cores.rear[i]));
            let (front, rear) = divide(front, rear);
            let open = front + right.leg[i] - left.leg[i];
            ring[i] = open + rear;
            horseshoe[i] = right.wake[i] + open - left.wake[i];
            far[i] = right.far[i] - left.far[i];
        }
    }
}

/// sum_j m[j] v[j], over the first `n` sources.
#[inline(always)]
pub(super) fn multiply<G: Scalar, S: Over<G>, const N: usize>(
    m: &Matrix<G, N>,
    v: &StripColumn<S, N>,
    n: usize,
) -> StripColumn<S, N> {
    multiply_some(m, v, 0..n, n)
}

/// As [`multiply`] where `v` is zero but for the sources `some` of the first `n`; `m` needs no more columns.
#[inline(always)]
pub(super) fn multiply_some<G: Scalar, S: Over<G>, const N: usize>(
    m: &[StripColumn<G, N>],
    v: &StripColumn<S, N>,
    some: Range<usize>,
    n: usize,
) -> StripColumn<S, N> {
    if const { !plain::<S>() } {
        return column(n, |i| some.clone().fold(S::ZERO, |sum, j| v[j].fused(m[j][i], sum)));
    }
    let mut sum = [S::ZERO; N];
    for j in some {
        for i in 0..lanes::<S, N>(n) {
            sum[i] = v[j].fused(m[j][i], sum[i]);
        }
    }
    sum
}

/// v . m[j] for each of the first `n` sources; zero beyond.
#[inline(always)]
pub(super) fn multiply_transposed<K: Scalar, S: Over<K>, const N: usize>(
    m: &Matrix<K, N>,
    v: &StripColumn<S, N>,
    n: usize,
) -> StripColumn<S, N> {
    if const { !plain::<S>() } {
        return column(n, |j| dot(&m[j], v, n));
    }
    let mut sum = [S::ZERO; N];
    for j in 0..n {
        sum[j] = dot(&m[j], v, n);
    }
    sum
}

/// a . b of so many `strips`, beyond which one of them is zero.
#[inline(always)]
pub(super) fn dot<K: Scalar, S: Over<K>, const N: usize>(
    a: &StripColumn<K, N>,
    b: &StripColumn<S, N>,
    strips: usize,
) -> S {
    let mut sums = [S::ZERO; 4];
    let (a, b) = (a.as_chunks::<4>().0, b.as_chunks::<4>().0);
    for i in 0..lanes::<S, N>(strips).div_ceil(4).min(a.len()) {
        for k in 0..4 {
            sums[k] = b[i][k].fused(a[i][k], sums[k]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// a . b where b is zero but for `some`.
#[inline(always)]
pub(super) fn dot_some<K: Scalar, S: Over<K>, const N: usize>(
    a: &StripColumn<K, N>,
    b: &StripColumn<S, N>,
    some: Range<usize>,
) -> S {
    if const { plain::<S>() } {
        return dot(a, b, N);
    }
    some.fold(S::ZERO, |sum, i| b[i].fused(a[i], sum))
}

/// Sum over all lanes.
#[inline(always)]
pub(super) fn sum<S: Scalar, const N: usize>(a: &StripColumn<S, N>) -> S {
    let mut lanes = [S::ZERO; 4];
    for a in a.chunks_exact(4) {
        for k in 0..4 {
            lanes[k] += a[k];
        }
    }
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3])
}

/// Inverse of the leading `n` x `n` block of `m` by Gauss-Jordan elimination in place,
/// two unknowns at a time, without exchanges. The matrices met here are positive definite up to
/// a diagonal scaling, for which this is stable (Golub & Van Loan, Matrix Computations, 4.2.2).
/// `N` is even.
#[inline(never)]
pub(super) fn invert<S: Scalar, const N: usize>(m: &mut Matrix<S, N>, n: usize) {
    if const { S::FIRST_ORDER && large::<S>() } {
        return invert_by_values(m, n);
    }
    if n % 2 == 1 {
        // An unknown of its own makes the number even.
        m.iter_mut().for_each(|column| column[n] = S::ZERO);
        m[n].fill(S::ZERO);
        m[n][n] = S::ONE;
    }
    let lanes = lanes::<S, N>(n.next_multiple_of(2));
    for k in (0..n).step_by(2) {
        let (before, rest) = m.split_at_mut(k);
        let (pair, after) = rest.split_at_mut(2);
        let block = inverse_of_pair([[pair[0][k], pair[1][k]], [pair[0][k + 1], pair[1][k + 1]]]);
        // A copy is known to lie apart from the others, so that loops vectorise; numbers that fill a register need none.
        let apart;
        let [p, q] = if const { plain::<S>() || large::<S>() } {
            apart = [pair[0], pair[1]];
            [&apart[0], &apart[1]]
        } else {
            [&pair[0], &pair[1]]
        };
        for other in before.iter_mut().chain(&mut after[..n.saturating_sub(k + 2)]) {
            let (a, b) = (other[k], other[k + 1]);
            let f = -block[0][0].mul_add(a, block[0][1] * b);
            let g = -block[1][0].mul_add(a, block[1][1] * b);
            for i in 0..lanes {
                other[i] = q[i].mul_add(g, p[i].mul_add(f, other[i]));
            }
            // In place of what is eliminated.
            (other[k], other[k + 1]) = (f, g);
        }
        for i in 0..lanes {
            let (a, b) = (pair[0][i], pair[1][i]);
            for c in 0..2 {
                pair[c][i] = b.mul_add(block[1][c], a * block[0][c]);
            }
        }
        for c in 0..2 {
            (pair[c][k], pair[c][k + 1]) = (block[0][c], block[1][c]);
        }
    }
}

/// The same of a matrix with first derivatives, from the inverse R of its values.
///
/// Equation: aero.strip.inverse_slopes
/// `d(A^-1) = -R dA R, R = A^-1`
/// Source: derivative of A R = 1.
/// Test: `the_inverse_has_the_derivatives_that_its_elimination_carries`.
fn invert_by_values<S: Scalar, const N: usize>(m: &mut Matrix<S, N>, n: usize) {
    let (mut inverse, mut turned) = ([[0.0; N]; N], [[0.0; N]; N]);
    for j in 0..n {
        for i in 0..n {
            inverse[j][i] = m[j][i].value();
        }
    }
    invert(&mut inverse, n);
    for j in 0..n {
        for i in 0..n {
            turned[j][i] = -inverse[i][j];
        }
    }
    // dA R row by row, then the rest column by column, each in place.
    let mut kept = [S::ZERO; N];
    for i in 0..n {
        for k in 0..n {
            kept[k] = m[k][i];
        }
        for j in (0..n).step_by(2) {
            let sums = two_sums(&kept[..n], [&inverse[j], &inverse[(j + 1).min(N - 1)]]);
            for c in 0..2.min(n - j) {
                m[j + c][i] = sums[c];
            }
        }
    }
    for j in 0..n {
        kept[..n].copy_from_slice(&m[j][..n]);
        for i in (0..n).step_by(2) {
            let sums = two_sums(&kept[..n], [&turned[i], &turned[(i + 1).min(N - 1)]]);
            for c in 0..2.min(n - i) {
                m[j][i + c] = S::from(inverse[j][i + c]).plus_slope(1.0, &sums[c]);
            }
        }
    }
}

/// Derivatives of two sums of the numbers `of`, by their slopes.
#[inline(always)]
fn two_sums<S: Scalar, const N: usize>(of: &[S], [slopes, others]: [&[f64; N]; 2]) -> [S; 2] {
    let (mut one, mut other) = (S::ZERO, S::ZERO);
    for k in 0..of.len().min(N) {
        one = one.plus_slope(slopes[k], &of[k]);
        other = other.plus_slope(others[k], &of[k]);
    }
    [one, other]
}

/// Inverse of a 2 x 2 matrix by rows.
#[inline(always)]
fn inverse_of_pair<S: Scalar>([[a, b], [c, d]]: [[S; 2]; 2]) -> [[S; 2]; 2] {
    let inverse = a.mul_add(d, -(b * c)).recip();
    [[d * inverse, -(b * inverse)], [-(c * inverse), a * inverse]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Dual;

    #[test]
    fn the_inverse_has_the_derivatives_that_its_elimination_carries() {
        type Few = Dual<8>;
        for n in [1, 5, 6, 8] {
            let mut m: Matrix<Few, 8> = std::array::from_fn(|j| {
                std::array::from_fn(|i| {
                    let of = |k: usize| 0.1 * ((3 * i + 5 * j + 7 * k) as f64).sin();
                    Dual { re: of(0) + f64::from(u8::from(i == j)), eps: std::array::from_fn(|k| of(k + 1)) }
                })
            });
            // Duals of duals have derivatives of another order, and are eliminated as they are.
            let mut carried: Matrix<Dual<8, Dual<1>>, 8> = m.map(|column| {
                column.map(|of| Dual { re: Dual::constant(of.re), eps: of.eps.map(Dual::constant) })
            });
            invert(&mut m, n);
            invert(&mut carried, n);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let (one, other) = (m[j][i], carried[j][i]);
                let off = (0..8).map(|k| (one.eps[k] - other.eps[k].re).abs()).fold(0.0, f64::max);
                assert!(off < 1e-13 && (one.re - other.re.re).abs() < 1e-14, "{n}: {off}");
            }
        }
    }

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        for n in [1, 5, 6, 8] {
            let mut m: Matrix<f64, 8> =
                std::array::from_fn(|j| std::array::from_fn(|i| 0.1 * ((3 * i + 5 * j) as f64).sin()));
            for i in 0..8 {
                m[i][i] += 1.0;
            }
            let original = m;
            invert(&mut m, n);
            for j in 0..n {
                let mut column = m[j];
                column[n..].fill(0.0);
                let product = multiply(&original, &column, n);
                for i in 0..n {
                    assert!((product[i] - f64::from(u8::from(i == j))).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn a_long_segment_is_half_a_line_vortex_on_each_side() {
        let (target, ends) = (Vec3::new(0.3, 2.0, 0.0), [1e4, -1e4].map(|y| Vec3::new(0.0, y, 0.0)));
        let along = ends[1] - ends[0];
        let distances = ends.map(|end| (target - end).norm());
        let turn = PlueckerLine::new(ends[0], along)
            .turn(&PlueckerLine::new(target, Vec3::new(0.0, 0.0, INVERSE_4PI)));
        let Ratio { above, below } = faded_segment(turn, along.norm_squared(), distances, 1e-12);
        let value = above / below;
        assert!((value.abs() / (1.0 / (2.0 * PI * 0.3)) - 1.0).abs() < 1e-6);
        assert!(value > 0.0);
    }
}
