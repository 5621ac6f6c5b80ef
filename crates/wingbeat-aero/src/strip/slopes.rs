//! Derivatives of the washes by places: slopes in plain numbers, of all strips side by side, times the derivatives of the points, normals
//! and directions that they go by. So derivatives along many directions cost little more than along one.

use super::cores::{EdgeCores, StripCores};
use super::influence::{Targets, Wash, plain, segment_square};
use super::motion::{StripEdge, Vectors, Wakes};
use wingbeat_math::{Dual, Meets, Over, Scalar, Vec3};

/// Whether washes of vortices whose places carry the derivatives of `K` are found by slopes: where the model's numbers are plain, and the
/// directions of wakes carry no more.
pub(super) const fn by_slopes<P: Scalar, K: Scalar, S: Scalar>() -> bool {
    K::FIRST_ORDER && plain::<P>() && size_of::<K>() == size_of::<S>()
}

/// A wash with its slopes by three vectors.
type Sloped = (f64, [Vec3; 3]);

/// A wash on each strip with its slopes by three vectors: of a segment by those from both ends to the strip and by the normal, of what a
/// wake washes by that from its point, by its direction and by the normal.
struct WashSlopes<const N: usize> {
    wash: [f64; N],
    by: [Vectors<f64, N>; 3],
}

impl<const N: usize> WashSlopes<N> {
    const ZERO: Self = Self { wash: [0.0; N], by: [Vectors::ZERO; 3] };

    #[inline(always)]
    fn set(&mut self, i: usize, (wash, by): Sloped) {
        self.wash[i] = wash;
        for k in 0..3 {
            self.by[k].set(i, by[k]);
        }
    }
    #[inline(always)]
    fn get(&self, i: usize) -> [Vec3; 3] {
        [self.by[0].get(i), self.by[1].get(i), self.by[2].get(i)]
    }
}

/// What an edge does.
struct EdgeSlopes<const N: usize> {
    /// Distances of the strips from its bound point and its trailing edge.
    distances: [[f64; N]; 2],
    leg: WashSlopes<N>,
    wake: WashSlopes<N>,
    far: WashSlopes<N>,
}

impl<const N: usize> EdgeSlopes<N> {
    const ZERO: Self = {
        let distances = [[0.0; N]; 2];
        Self { distances, leg: WashSlopes::ZERO, wake: WashSlopes::ZERO, far: WashSlopes::ZERO }
    };
}

/// A wash on each strip with its slopes by the strip's point and normal, and by the two points of either edge.
struct PlaceSlopes<const N: usize> {
    wash: [f64; N],
    point: Vectors<f64, N>,
    normal: Vectors<f64, N>,
    bound: [Vectors<f64, N>; 2],
    trailing: [Vectors<f64, N>; 2],
}

impl<const N: usize> PlaceSlopes<N> {
    const ZERO: Self = {
        let zero = Vectors::ZERO;
        Self { wash: [0.0; N], point: zero, normal: zero, bound: [zero; 2], trailing: [zero; 2] }
    };

    /// Puts the slopes of edges `a` and `b` and of the strip between them together: of the ring, the horseshoe, and far behind. All lie
    /// apart as arguments alone, without which the loops are not vectorised.
    #[inline(never)]
    fn merge(
        a: &EdgeSlopes<N>,
        b: &EdgeSlopes<N>,
        front: &WashSlopes<N>,
        rear: &WashSlopes<N>,
        ring: &mut Self,
        horseshoe: &mut Self,
        far: &mut Self,
    ) {
        for i in 0..N {
            let ([x, y, n], [xa, ya, na], [xb, yb, nb]) = (front.get(i), a.leg.get(i), b.leg.get(i));
            let (open, normal) = (front.wash[i] + b.leg.wash[i] - a.leg.wash[i], n + nb - na);
            let bound = [xa - x, -(y + xb)];
            let [right, left, rear_normal] = rear.get(i);
            ring.set(i, open + rear.wash[i], normal + rear_normal, bound, [ya - left, -(yb + right)]);
            let ([ra, _, na], [rb, _, nb]) = (a.wake.get(i), b.wake.get(i));
            let wash = open + b.wake.wash[i] - a.wake.wash[i];
            horseshoe.set(i, wash, normal + nb - na, bound, [ya + ra, -(yb + rb)]);
        }
        for i in 0..N {
            let ([ra, _, na], [rb, _, nb]) = (a.far.get(i), b.far.get(i));
            far.set(i, b.far.wash[i] - a.far.wash[i], nb - na, [ra, -rb], [Vec3::ZERO; 2]);
        }
    }

    /// Of points that move with the strip as against the edges.
    #[inline(always)]
    fn set(&mut self, i: usize, wash: f64, normal: Vec3, bound: [Vec3; 2], trailing: [Vec3; 2]) {
        self.wash[i] = wash;
        self.normal.set(i, normal);
        self.point.set(i, -(bound[0] + bound[1] + trailing[0] + trailing[1]));
        for k in 0..2 {
            self.bound[k].set(i, bound[k]);
            self.trailing[k].set(i, trailing[k]);
        }
    }
}

/// Slopes of the washes of one strip and of the edges beside it.
pub(super) struct WakeSlopes<const N: usize> {
    edges: [EdgeSlopes<N>; 2],
    front: WashSlopes<N>,
    rear: WashSlopes<N>,
    ring: PlaceSlopes<N>,
    horseshoe: PlaceSlopes<N>,
    far: PlaceSlopes<N>,
}

impl<const N: usize> WakeSlopes<N> {
    pub const ZERO: Self = Self {
        edges: [EdgeSlopes::ZERO; 2],
        front: WashSlopes::ZERO,
        rear: WashSlopes::ZERO,
        ring: PlaceSlopes::ZERO,
        horseshoe: PlaceSlopes::ZERO,
        far: PlaceSlopes::ZERO,
    };
}

/// The fading inverse of y, and its slope.
#[inline(always)]
fn faded(y: f64, core4: f64) -> (f64, f64) {
    let faded = Dual::<1>::variable(y, 0).faded_inverse(Dual::constant(core4));
    (faded.re, faded.eps[0])
}

/// Wash of a segment whose ends lie `x` and `y` before the strip, at the distances a and b; f(s) is the fading inverse.
///
/// Equation: aero.strip.segment_slopes
/// `w = n.(x x y) h, h = (1/a + 1/b) f(s): by n (x x y) h; by x (y x n) h + n.(x x y) [(1/a + 1/b) f' (x b/a + y) - f x/a^3]; by y likewise`
/// Source: aero.strip.segment by the chain rule.
/// Test: `slopes_are_the_derivatives_of_the_washes_themselves`.
#[inline(always)]
fn segment([x, y]: [Vec3; 2], [a, b]: [f64; 2], n: Vec3, core4: f64) -> Sloped {
    let cross = x.cross(y);
    let turn = n.dot(cross);
    let (over_a, over_b) = (a.recip(), b.recip());
    let (f, slope) = faded(segment_square((x - y).norm_squared(), [a, b]), core4);
    let h = (over_a + over_b) * f;
    let (both, own) = (turn * (over_a + over_b) * slope, turn * f);
    let by_x = y.cross(n) * h + x * (both * b * over_a - own * over_a * over_a * over_a) + y * both;
    let by_y = n.cross(x) * h + y * (both * a * over_b - own * over_b * over_b * over_b) + x * both;
    (turn * h, [by_x, by_y, cross * h])
}

/// Wash of a wake that leaves along `u` from a point that lies `r` before the strip, at the distance b; f(y) is the fading inverse.
///
/// Equation: aero.strip.wake_slopes
/// `w = n.(u x r) f(y), y = b (b - u.r): by r (n x u) f + n.(u x r) f' (r (2 b - u.r)/b - u b); by u (r x n) f - n.(u x r) f' b r`
/// Source: aero.strip.trailing_vortex by the chain rule.
/// Test: `slopes_are_the_derivatives_of_the_washes_themselves`.
#[inline(always)]
fn wake(u: Vec3, r: Vec3, b: f64, n: Vec3, core4: f64) -> Sloped {
    let (cross, along) = (u.cross(r), u.dot(r));
    let turn = n.dot(cross);
    let (f, slope) = faded((b - along) * b, core4);
    let bent = turn * slope;
    let by_r = n.cross(u) * f + r * (bent * ((b + b - along) / b)) - u * (bent * b);
    (turn * f, [by_r, r.cross(n) * f - r * (bent * b), cross * f])
}

/// The same far behind, where y = r^2 - (u.r)^2.
#[inline(always)]
fn far(u: Vec3, r: Vec3, n: Vec3, core4: f64) -> Sloped {
    let (cross, along) = (u.cross(r), u.dot(r));
    let turn = n.dot(cross);
    let (f, slope) = faded(r.norm_squared() - along * along, core4);
    let bent = 2.0 * turn * slope;
    let by_r = n.cross(u) * f + (r - u * along) * bent;
    (turn * f, [by_r, r.cross(n) * f - r * (bent * along), cross * f])
}

impl<P: Scalar, K: Scalar + Meets<P>, const N: usize> Targets<'_, P, K, N> {
    /// As [`wash`](Self::wash).
    pub fn wash_by_slopes<S: Over<K> + Meets<P>>(
        &self,
        wakes: &Wakes<K, S, N>,
        n: usize,
        slopes: &mut WakeSlopes<N>,
        out: &mut Wash<'_, K, S, N>,
    ) {
        let cores = self.cores;
        // The left and the right edge take turns.
        let mut edges = [self.edge(wakes, 0); 2];
        self.slope_edge(&edges[0], &cores.edges[0], &mut slopes.edges[0]);
        for j in 0..n {
            let (left, right) = (j % 2, (j + 1) % 2);
            edges[right] = self.edge(wakes, j + 1);
            self.slope_edge(&edges[right], &cores.edges[j + 1], &mut slopes.edges[right]);
            let edges = [&edges[left], &edges[right]];
            let WakeSlopes { edges: of_edges, front, rear, ring, horseshoe, far } = &mut *slopes;
            let [a, b] = [&of_edges[left], &of_edges[right]];
            self.slope_strip(edges, &a.distances, &b.distances, &cores.strips[j], front, rear);
            PlaceSlopes::merge(a, b, front, rear, ring, horseshoe, far);
            let (control, quarter) = (&self.at.control, &self.at.bound);
            for i in 0..n {
                out.ring[j][i] = self.placed(ring, i, control, edges, true);
                let wakes = [&a.wake.by[1], &b.wake.by[1]];
                out.horseshoe[j][i] =
                    turned(self.placed(horseshoe, i, control, edges, true), wakes, i, edges);
                let wakes = [&a.far.by[1], &b.far.by[1]];
                out.far[j][i] = turned(self.placed(far, i, quarter, edges, false), wakes, i, edges);
            }
        }
    }

    /// A wash on strip `i`, whose point is among `points`, with the derivatives of all places; `moved` where trailing edges count.
    #[inline(always)]
    fn placed<S: Over<K>>(
        &self,
        of: &PlaceSlopes<N>,
        i: usize,
        points: &Vectors<K, N>,
        edges: [&StripEdge<K, S>; 2],
        moved: bool,
    ) -> K {
        let mut sum = K::from(of.wash[i]);
        for c in 0..3 {
            sum = sum.plus_slope(of.point.0[c][i], &points.0[c][i]);
            sum = sum.plus_slope(of.normal.0[c][i], &self.at.normal.0[c][i]);
            sum = sum.plus_slope(of.bound[0].0[c][i], &edges[0].bound.0[c]);
            sum = sum.plus_slope(of.bound[1].0[c][i], &edges[1].bound.0[c]);
            if moved {
                sum = sum.plus_slope(of.trailing[0].0[c][i], &edges[0].trailing.0[c]);
                sum = sum.plus_slope(of.trailing[1].0[c][i], &edges[1].trailing.0[c]);
            }
        }
        sum
    }

    /// What an edge does to all strips.
    #[inline(never)]
    fn slope_edge<S: Over<K>>(&self, edge: &StripEdge<K, S>, cores: &EdgeCores<P>, out: &mut EdgeSlopes<N>) {
        let [bound, trailing, u] = [edge.bound.values(), edge.trailing.values(), edge.wake.values()];
        let [control, quarter, normal] = &self.at.values;
        let least = cores.least.value();
        for i in 0..N {
            let (p, n) = (control.get(i), normal.get(i));
            let (x, y) = (p - bound, p - trailing);
            let (a, b) = ((x.norm_squared() + least).sqrt(), (y.norm_squared() + least).sqrt());
            (out.distances[0][i], out.distances[1][i]) = (a, b);
            out.leg.set(i, segment([x, y], [a, b], n, cores.leg[i].value()));
        }
        for i in 0..N {
            let (r, n) = (control.get(i) - trailing, normal.get(i));
            out.wake.set(i, wake(u, r, out.distances[1][i], n, cores.wake[i].value()));
        }
        for i in 0..N {
            out.far.set(i, far(u, quarter.get(i) - bound, normal.get(i), cores.far[i].value()));
        }
    }

    /// What the bound vortex and the trailing edge of a strip do.
    #[inline(never)]
    fn slope_strip<S: Over<K>>(
        &self,
        edges: [&StripEdge<K, S>; 2],
        a: &[[f64; N]; 2],
        b: &[[f64; N]; 2],
        cores: &StripCores<P>,
        front: &mut WashSlopes<N>,
        rear: &mut WashSlopes<N>,
    ) {
        let [control, _, normal] = &self.at.values;
        let bound = edges.map(|edge| edge.bound.values());
        let trailing = edges.map(|edge| edge.trailing.values());
        for i in 0..N {
            let (p, n) = (control.get(i), normal.get(i));
            let ends = [p - bound[0], p - bound[1]];
            front.set(i, segment(ends, [a[0][i], b[0][i]], n, cores.front[i].value()));
        }
        for i in 0..N {
            let (p, n) = (control.get(i), normal.get(i));
            let ends = [p - trailing[1], p - trailing[0]];
            rear.set(i, segment(ends, [b[1][i], a[1][i]], n, cores.rear[i].value()));
        }
    }
}

/// The same with the derivatives of the directions in which the wakes of both edges leave, of which `of` holds the slopes.
#[inline(always)]
fn turned<K: Scalar, S: Over<K>, const N: usize>(
    wash: K,
    of: [&Vectors<f64, N>; 2],
    i: usize,
    edges: [&StripEdge<K, S>; 2],
) -> S {
    let mut sum = S::from(wash);
    for c in 0..3 {
        sum = sum.plus_slope(-of[0].0[c][i], &edges[0].wake.0[c]);
        sum = sum.plus_slope(of[1].0[c][i], &edges[1].wake.0[c]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Planform, PlanformStation, SectionMotion, StripModel, StripSettings};

    /// Derivatives that are carried through the washes themselves, which are not found by slopes.
    type Carried = Dual<1, Dual<1>>;

    /// The motion of a folded, twisted wing, of which everything changes along the one direction.
    fn sections<S: Scalar>(arcs: &[f64], number: impl Fn(f64, f64) -> S) -> Vec<SectionMotion<S>> {
        let vector = |at: f64, of: [f64; 3]| Vec3([0, 1, 2].map(|k| number(of[k], (at + k as f64).sin())));
        let section = |(j, s): (usize, &f64)| {
            let (at, fold, twist) = (7.0 * j as f64, 0.6 * s.abs(), 0.2 * s);
            let le = [0.03 + 0.05 * s * s, *s * (1.0 - 0.3 * s.abs()), fold];
            let te = [le[0] - 0.1, le[1] + 0.01 * twist, fold - 0.1 * twist];
            SectionMotion {
                le: vector(at, le),
                te: vector(at + 1.0, te),
                v_le: vector(at + 2.0, [2.0, 0.1, 1.5 * s.abs()]),
                v_te: vector(at + 3.0, [2.1, 0.2, 1.2 * s.abs()]),
                a_le: vector(at + 4.0, [1.0, -2.0, 9.0 * s]),
                a_te: vector(at + 5.0, [-1.0, 1.0, 7.0 * s]),
                span: vector(at, [0.0, -1.0, 0.0]),
                w: vector(at, [0.3, 0.2, 0.1]),
                alpha: vector(at, [1.0, 2.0, 3.0]),
            }
        };
        arcs.iter().enumerate().map(section).collect()
    }

    /// Rates of the states, then force and moment.
    fn loads<S: Scalar>(model: &StripModel, number: impl Fn(f64, f64) -> S + Copy) -> Vec<S> {
        let sections = sections(model.arcs(), number);
        let x: Vec<S> = (0..model.states()).map(|i| number(0.2 * (i as f64).cos(), 0.0)).collect();
        let mut dx = vec![S::ZERO; x.len()];
        let wind = Vec3([0.3, -0.1, 0.2]).each(|v: f64| number(v, 0.4));
        let (load, _) = model.evaluate_sum::<S, S>(&sections, wind, &x, &mut dx, None);
        dx.extend(load.force.0.into_iter().chain(load.moment.0));
        dx
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_washes_themselves() {
        let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.03, trailing_edge_m: -0.07 };
        let planform = Planform::new(&[station(0.0), station(0.5)]).unwrap();
        for strips in [6, 9] {
            let model = StripModel::new(&planform, StripSettings { strips, ..Default::default() }).unwrap();
            let by_slopes = loads(&model, |re, slope| Dual::<1> { re, eps: [slope] });
            let carried =
                loads(&model, |re, slope| Carried { re: Dual::constant(re), eps: [Dual::constant(slope)] });
            let scale = by_slopes.iter().fold(1.0, |most: f64, value| most.max(value.eps[0].abs()));
            assert!(scale > 1.0);
            for (a, b) in by_slopes.iter().zip(&carried) {
                assert!((a.re - b.re.re).abs() <= 1e-13 * scale, "{a:?} {b:?}");
                assert!((a.eps[0] - b.eps[0].re).abs() <= 1e-12 * scale, "{a:?} {b:?}");
            }
        }
    }
}
