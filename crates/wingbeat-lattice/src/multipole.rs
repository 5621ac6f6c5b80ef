//! Vortices seen from afar: moments of a patch about its centre, and the velocity that they induce.
//!
//! With a_k = D_y^k(1/|x - y|)/k! at the centre c, 1/|x - y| = sum_k a_k (y - c)^k, and the velocity curl(sum_k a_k M_k)/(4 pi),
//! M_k = sum Gamma l (y - c)^k, becomes sum_m a_m C_m/(4 pi), C_m = -sum_i m_i e_i x M_(m - e_i). As 1/r is harmonic, the a_m whose
//! last exponent is above 1 are sums of the others.

use std::sync::LazyLock;
use wide::f64x4;
use wingbeat::math::Vec3;

/// Degree of the last a_m; [`velocity`] calls each.
pub const DEGREE: usize = 6;
/// Degree of the last moment.
const LAST: usize = DEGREE - 1;
/// Moments up to the last degree.
pub const MOMENTS: usize = (LAST + 1) * (LAST + 2) * (LAST + 3) / 6;
/// Terms a_m of the degrees from 1 on: 2 n + 1 of the degree n.
pub const TERMS: usize = (DEGREE + 1) * (DEGREE + 1) - 1;

/// Place of the exponents (i, j, l) among all of degree at most `degree`: by degree, then by l, then by j.
const fn place(i: usize, j: usize, l: usize) -> usize {
    let n = i + j + l;
    let before = n * (n + 1) * (n + 2) / 6;
    // Of the degree n there are n + 1 - l with the last exponent l.
    before + l * (n + 1) - l * l.saturating_sub(1) / 2 + j
}

/// All exponents of degree at most `degree`, in the order of [`place`].
fn exponents(degree: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..=degree).flat_map(|n| (0..=n).flat_map(move |l| (0..=n - l).map(move |j| [n - l - j, j, l])))
}

/// Moments of a patch: circulation times length (m3/s), by every power of the place (m).
pub type Moments = [Vec3; MOMENTS];
/// Coefficients of a patch, of degree n in (m3/s) m^(n-1): by degree n from 1 on, n + 1 with the last exponent 0, then n with
/// 1, each by the second exponent.
pub type Coefficients = [[f64; 3]; TERMS];

/// Powers (y - c)^k of all moments.
fn powers(y: Vec3) -> [f64; MOMENTS] {
    let mut values = [1.0; MOMENTS];
    for ((axis, below), at) in LOWER.iter().zip(1..) {
        values[at] = values[*below] * y[*axis];
    }
    values
}

/// Of every power but the first the axis along which it is one higher than another, and the place of that one.
static LOWER: LazyLock<Vec<(usize, usize)>> = LazyLock::new(|| {
    let lower = |[i, j, l]: [usize; 3]| match (i, j) {
        (1.., _) => (0, place(i - 1, j, l)),
        (0, 1..) => (1, place(i, j - 1, l)),
        _ => (2, place(i, j, l - 1)),
    };
    exponents(LAST).skip(1).map(lower).collect()
});

/// Adds the straight vortex from `a` to `b`, seen from the centre (m), of the circulation `strength` (m2/s): two points of
/// Gauss hold its moments up to the third exactly.
pub fn add_segment(moments: &mut Moments, a: Vec3, b: Vec3, strength: f64) {
    let (middle, along) = ((a + b) * 0.5, b - a);
    let off = along * (0.5 / 3.0_f64.sqrt());
    let half = along * (0.5 * strength);
    let (first, second) = (powers(middle - off), powers(middle + off));
    for ((moment, p), q) in moments.iter_mut().zip(first).zip(second) {
        *moment += half * (p + q);
    }
}

/// How moments about one centre become those about another.
#[derive(Debug)]
pub struct Shift {
    /// Place of the moment that grows, place of the moment that is moved, place of the power, binomial coefficients.
    terms: Vec<(usize, usize, usize, f64)>,
}

/// The one there is.
pub static SHIFT: LazyLock<Shift> = LazyLock::new(Shift::new);

impl Shift {
    fn new() -> Self {
        let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
        let mut terms = Vec::new();
        for k in exponents(LAST) {
            for j in exponents(LAST).filter(|j| (0..3).all(|axis| j[axis] <= k[axis])) {
                let of = |[a, b, c]: [usize; 3]| place(a, b, c);
                let rest = std::array::from_fn(|axis| k[axis] - j[axis]);
                let factor = (0..3).map(|axis| choose(k[axis], j[axis])).product();
                terms.push((of(k), of(j), of(rest), factor));
            }
        }
        Self { terms }
    }

    /// Adds moments about a centre that lies `off` (m) from that of `sum`.
    pub fn add(&self, sum: &mut Moments, moments: &Moments, off: Vec3) {
        let powers = powers(off);
        for (to, from, power, factor) in &self.terms {
            sum[*to] += moments[*from] * (factor * powers[*power]);
        }
    }
}

/// The coefficients that moments have.
///
/// Equation: lattice.multipole
/// `velocity = sum_m a_m C_m/(4 pi), C_m = -sum_i m_i e_i x M_(m - e_i), M_k = sum Gamma l (y - c)^k`
/// Source: Lindsay & Krasny 2001, J. Comput. Phys. 172; harmonic terms folded: own derivation.
/// Test: `moments_stand_for_their_vortices_at_a_distance_and_when_shifted`.
pub fn coefficients(moments: &Moments) -> Coefficients {
    let units = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 0.0, 1.0)];
    let mut all: Vec<Vec3> = exponents(DEGREE)
        .map(|m| {
            let part = |axis: usize| {
                let mut below = m;
                below[axis] -= 1;
                units[axis].cross(moments[place(below[0], below[1], below[2])]) * -(m[axis] as f64)
            };
            (0..3).filter(|axis| m[*axis] > 0).map(part).fold(Vec3::ZERO, |sum, part| sum + part)
        })
        .collect();
    // l (l - 1) a_(i, j, l) = -(i + 2)(i + 1) a_(i + 2, j, l - 2) - (j + 2)(j + 1) a_(i, j + 2, l - 2), from the highest l down.
    for n in 2..=DEGREE {
        for l in (2..=n).rev() {
            for j in 0..=n - l {
                let i = n - l - j;
                let moved = all[place(i, j, l)] * -((l * (l - 1)) as f64).recip();
                all[place(i + 2, j, l - 2)] += moved * ((i + 2) * (i + 1)) as f64;
                all[place(i, j + 2, l - 2)] += moved * ((j + 2) * (j + 1)) as f64;
            }
        }
    }
    let mut kept = [[0.0; 3]; TERMS];
    let places =
        (1..=DEGREE).flat_map(|n| (0..2).flat_map(move |l| (0..=n - l).map(move |j| (n - l - j, j, l))));
    for (kept, (i, j, l)) in kept.iter_mut().zip(places) {
        *kept = all[place(i, j, l)].0;
    }
    kept
}

/// Terms of a degree, with the last exponent 0 and 1, by the second exponent.
type DegreeTerms = [[f64x4; DEGREE + 1]; 2];

/// Velocity times 4 pi (m/s) at four points that lie `d` (m) from the centre: n r^2 a_k = (2 n - 1) sum_i d_i a_(k - e_i) -
/// (n - 1) sum_i a_(k - 2 e_i), n the degree of k.
///
/// Equation: lattice.multipole_terms
/// `n r^2 a_k = (2 n - 1) sum_i d_i a_(k - e_i) - (n - 1) sum_i a_(k - 2 e_i)`
/// Source: Duan & Krasny 2001, J. Comput. Chem. 22.
/// Test: `moments_stand_for_their_vortices_at_a_distance_and_when_shifted`.
#[inline(always)]
pub fn velocity(coefficients: &Coefficients, d: &[f64x4; 3]) -> [f64x4; 3] {
    let inverse = f64x4::ONE / d[0].mul_add(d[0], d[1].mul_add(d[1], d[2] * d[2]));
    let u = d.map(|d| d * inverse);
    let mut sum = [f64x4::ZERO; 3];
    let none = [[f64x4::ZERO; DEGREE + 1]; 2];
    let mut zeroth = none;
    zeroth[0][0] = inverse.sqrt();
    let mut add = |one: &DegreeTerms, two: &DegreeTerms, degree: usize| -> DegreeTerms {
        // Called with every degree as a constant, so that its loops are unrolled.
        let share = (degree as f64).recip();
        let (first, second) = (f64x4::splat(2.0 - share), inverse * f64x4::splat(1.0 - share));
        let mut now = none;
        for l in 0..2 {
            for j in 0..=degree - l {
                let i = degree - l - j;
                let (mut near, mut far) = (f64x4::ZERO, f64x4::ZERO);
                if i > 0 {
                    near = u[0] * one[l][j];
                }
                if j > 0 {
                    near = u[1].mul_add(one[l][j - 1], near);
                }
                if l > 0 {
                    near = u[2].mul_add(one[0][j], near);
                }
                if i > 1 {
                    far = two[l][j];
                }
                if j > 1 {
                    far += two[l][j - 2];
                }
                let term = first.mul_sub(near, second * far);
                now[l][j] = term;
                let c = &coefficients[degree * degree - 1 + l * (degree + 1) + j];
                (0..3).for_each(|k| sum[k] = term.mul_add(f64x4::splat(c[k]), sum[k]));
            }
        }
        now
    };
    let first = add(&zeroth, &none, 1);
    let second = add(&first, &zeroth, 2);
    let third = add(&second, &first, 3);
    let fourth = add(&third, &second, 4);
    let fifth = add(&fourth, &third, 5);
    add(&fifth, &fourth, 6);
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::segment;
    use wingbeat::math::Random;

    #[test]
    fn places_are_the_order_of_the_exponents() {
        for (at, [i, j, l]) in exponents(DEGREE).enumerate() {
            assert_eq!(place(i, j, l), at);
        }
        assert_eq!(exponents(LAST).count(), MOMENTS);
    }

    #[test]
    fn moments_stand_for_their_vortices_at_a_distance_and_when_shifted() {
        let mut random = Random::new(5);
        let mut drawn = |size: f64| Vec3(std::array::from_fn(|_| size * random.normal()));
        let vortices: Vec<(Vec3, Vec3)> = (0..20)
            .map(|_| {
                let at = drawn(0.05);
                (at, at + drawn(0.02))
            })
            .collect();
        let off = Vec3::new(0.03, -0.05, 0.04);
        let (mut own, mut moved) = ([Vec3::ZERO; MOMENTS], [Vec3::ZERO; MOMENTS]);
        vortices.iter().for_each(|(a, b)| add_segment(&mut own, *a, *b, 0.7));
        SHIFT.add(&mut moved, &own, off);
        let at = [
            Vec3::new(1.0, 0.3, -0.4),
            Vec3::new(-0.2, 0.9, 0.5),
            Vec3::new(0.1, -0.2, 2.0),
            Vec3::new(3.0, 3.0, 3.0),
        ];
        for (moments, centre) in [(&own, Vec3::ZERO), (&moved, -off)] {
            let c = coefficients(moments);
            let d: [f64x4; 3] = std::array::from_fn(|k| f64x4::from(at.map(|p| p[k] - centre[k])));
            let found = velocity(&c, &d).map(|v| v.to_array());
            for (lane, p) in at.iter().enumerate() {
                let exact = vortices.iter().fold(Vec3::ZERO, |sum, (a, b)| sum + segment(*p, *a, *b) * 0.7);
                let found = Vec3::new(found[0][lane], found[1][lane], found[2][lane])
                    * (0.25 * std::f64::consts::FRAC_1_PI);
                assert!((found - exact).norm() < 2e-4 * exact.norm(), "{lane}: {found:?} {exact:?}");
            }
        }
    }
}
