//! Distance between segments.

use super::{Scalar, Vec3};

/// Squared length below which a segment is a point, and scale of parallel ones, m2.
const TINY: f64 = 1e-18;

/// Distance between two segments, in the unit of their ends (Ericson, Real-Time Collision Detection, 5.1.9). Its derivatives
/// are exact where the nearest points are unique; where the segments touch they are taken as zero.
///
/// Equation: math.segment_distance
/// `min over s, t in [0, 1] of abs(a0 + s da - b0 - t db)`
/// Source: Ericson 2005, Real-Time Collision Detection, 5.1.9.
/// Test: `segment_distance_against_a_fine_search`.
pub fn segment_distance<S: Scalar>(a: [Vec3<S>; 2], b: [Vec3<S>; 2]) -> S {
    let (d1, d2, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (aa, ee, f) = (d1.norm_squared(), d2.norm_squared(), d2.dot(r));
    let unit = |share: S| share.clamped(0.0, 1.0);
    let (s, t) = if aa.value() <= TINY && ee.value() <= TINY {
        (S::ZERO, S::ZERO)
    } else if aa.value() <= TINY {
        (S::ZERO, unit(f / ee))
    } else {
        let c = d1.dot(r);
        if ee.value() <= TINY {
            (unit(-c / aa), S::ZERO)
        } else {
            let bb = d1.dot(d2);
            let det = aa * ee - bb * bb;
            let s = if det.value() > TINY { unit((bb * f - c * ee) / det) } else { S::ZERO };
            let t = (bb * s + f) / ee;
            let clamped = unit(t);
            let s = if t == clamped { s } else { unit((bb * clamped - c) / aa) };
            (s, clamped)
        }
    };
    let squared = (a[0] + d1 * s - b[0] - d2 * t).norm_squared();
    if squared.value() > 0.0 { squared.sqrt() } else { S::ZERO }
}

/// Distance of a segment from a triangle, in the unit of their corners; 0 where it passes through. Its derivatives are exact where the
/// nearest points are unique, and zero where it passes through.
///
/// Equation: math.triangle_distance
/// `least of the distances from the edges, and from the plane at ends that lie over the triangle; 0 where the segment pierces it`
/// Source: Ericson 2005, Real-Time Collision Detection, 5.1.10.
/// Test: `triangle_distance_against_a_fine_search`.
pub fn triangle_distance<S: Scalar>(segment: [Vec3<S>; 2], triangle: [Vec3<S>; 3]) -> S {
    let [a, b, c] = triangle;
    let edges = [[a, b], [b, c], [c, a]];
    let normal = (b - a).cross(c - a);
    let less = |one: S, other: S| if other < one { other } else { one };
    let beside =
        edges.map(|edge| segment_distance(segment, edge)).into_iter().fold(S::from(f64::INFINITY), less);
    if normal.norm_squared().value() <= TINY * TINY {
        return beside;
    }
    let size = normal.norm();
    let over =
        |p: Vec3<S>| edges.iter().all(|[from, to]| (*to - *from).cross(p - *from).dot(normal).value() >= 0.0);
    let above = segment.map(|p| (p - a).dot(normal) / size);
    let [low, high] = above.map(Scalar::value);
    if low * high <= 0.0 && low != high {
        let at = segment[0] + (segment[1] - segment[0]) * (above[0] / (above[0] - above[1]));
        if over(at) {
            return S::ZERO;
        }
    }
    let ends = segment.into_iter().zip(above).filter(|(p, _)| over(*p));
    ends.map(|(_, above)| if above.value() < 0.0 { -above } else { above }).fold(beside, less)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dual, Random};

    fn drawn(random: &mut Random) -> [[Vec3; 2]; 2] {
        let mut p = || Vec3(std::array::from_fn(|_| random.between(-1.0, 1.0)));
        [[p(), p()], [p(), p()]]
    }

    #[test]
    fn segment_distance_against_a_fine_search() {
        let mut random = Random::new(3);
        for _ in 0..50 {
            let [a, b] = drawn(&mut random);
            let mut best = f64::INFINITY;
            for i in 0..=200 {
                for j in 0..=200 {
                    let (s, t) = (i as f64 / 200.0, j as f64 / 200.0);
                    let x = a[0] + (a[1] - a[0]) * s;
                    let y = b[0] + (b[1] - b[0]) * t;
                    best = best.min((x - y).norm());
                }
            }
            let exact = segment_distance(a, b);
            assert!(exact <= best + 1e-12 && best - exact < 0.02, "{exact} {best}");
        }
    }

    #[test]
    fn derivatives_of_the_distance_are_exact() {
        let mut random = Random::new(5);
        for _ in 0..50 {
            let [a, b] = drawn(&mut random);
            for (end, axis) in (0..2).flat_map(|end| (0..3).map(move |axis| (end, axis))) {
                let mut moved = a.map(Vec3::<Dual<1>>::constant);
                moved[end][axis] = Dual::variable(a[end][axis], 0);
                let exact = segment_distance(moved, b.map(Vec3::constant)).eps[0];
                let at = |h: f64| {
                    let mut moved = a;
                    moved[end][axis] += h;
                    segment_distance(moved, b)
                };
                let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
                assert!((exact - difference).abs() < 1e-6, "{exact} {difference}");
            }
        }
        let cross = [[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]]];
        let touching = cross.map(|s| s.map(|p| Vec3::<Dual<1>>::constant(Vec3(p))));
        assert_eq!(segment_distance(touching[0], touching[1]).eps[0], 0.0);
    }

    #[test]
    fn triangle_distance_against_a_fine_search() {
        let mut random = Random::new(5);
        let mut pierced = 0;
        for _ in 0..60 {
            let [[a, b], [c, d]] = drawn(&mut random);
            let [[e, _], _] = drawn(&mut random);
            let mut best = f64::INFINITY;
            for i in 0..=60 {
                let on = a + (b - a) * (f64::from(i) / 60.0);
                for j in 0..=60 {
                    for k in 0..=60 - j {
                        let at = c + (d - c) * (f64::from(j) / 60.0) + (e - c) * (f64::from(k) / 60.0);
                        best = best.min((on - at).norm());
                    }
                }
            }
            let exact = triangle_distance([a, b], [c, d, e]);
            assert!(exact <= best + 1e-12 && best - exact < 0.05, "{exact} {best}");
            pierced += usize::from(exact == 0.0);
        }
        assert!(pierced > 2 && pierced < 30, "{pierced}");
    }
}
