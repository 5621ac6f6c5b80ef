//! The velocities of vortices with cores at eight points at once, where the processor has AVX-512. Operation by operation as for four
//! points, so that the numbers are the same to the bit.

use crate::kernel::{LANES, NEVER_ZERO, VortexGrid, Window};
use std::arch::x86_64::{
    __m512d, _mm512_add_pd, _mm512_cvtsd_f64, _mm512_div_pd, _mm512_fmadd_pd, _mm512_fmsub_pd, _mm512_max_pd,
    _mm512_mul_pd, _mm512_permutexvar_pd, _mm512_set_pd, _mm512_set1_epi64, _mm512_set1_pd,
    _mm512_setzero_pd, _mm512_sqrt_pd, _mm512_sub_pd,
};
use wide::f64x4;
use wingbeat::math::Vec3;

/// Whether the processor has what [`add_induced`] needs.
pub fn is_there() -> bool {
    std::arch::is_x86_feature_detected!("avx512f")
}

/// A vertex as seen from eight points: where they lie from it, and how far.
#[derive(Clone, Copy)]
pub struct WideVertex {
    r: [__m512d; 3],
    far: __m512d,
}

/// What a segment does at eight points: r1 x r2, and numerator and denominator of what it is to be multiplied with.
struct Felt {
    across: [__m512d; 3],
    numerator: __m512d,
    denominator: __m512d,
}

#[target_feature(enable = "avx512f")]
#[inline]
fn see(p: &[__m512d; 3], point: Vec3) -> WideVertex {
    let r = [
        _mm512_sub_pd(p[0], _mm512_set1_pd(point[0])),
        _mm512_sub_pd(p[1], _mm512_set1_pd(point[1])),
        _mm512_sub_pd(p[2], _mm512_set1_pd(point[2])),
    ];
    WideVertex { r, far: _mm512_sqrt_pd(dot(&r, &r)) }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn dot(a: &[__m512d; 3], b: &[__m512d; 3]) -> __m512d {
    _mm512_fmadd_pd(a[0], b[0], _mm512_fmadd_pd(a[1], b[1], _mm512_mul_pd(a[2], b[2])))
}

/// As [`cored`](crate::kernel) of four points.
#[target_feature(enable = "avx512f")]
#[inline]
fn cored(a: &WideVertex, b: &WideVertex, core: f64) -> Felt {
    let (r1, r2) = (&a.r, &b.r);
    let across = [
        _mm512_fmsub_pd(r1[1], r2[2], _mm512_mul_pd(r1[2], r2[1])),
        _mm512_fmsub_pd(r1[2], r2[0], _mm512_mul_pd(r1[0], r2[2])),
        _mm512_fmsub_pd(r1[0], r2[1], _mm512_mul_pd(r1[1], r2[0])),
    ];
    let (dot, product) = (dot(r1, r2), _mm512_mul_pd(a.far, b.far));
    let excess = _mm512_max_pd(_mm512_sub_pd(product, dot), _mm512_setzero_pd());
    let square = _mm512_fmadd_pd(excess, _mm512_add_pd(product, dot), _mm512_set1_pd(core));
    let numerator = _mm512_mul_pd(_mm512_add_pd(a.far, b.far), excess);
    Felt { across, numerator, denominator: _mm512_fmadd_pd(product, square, _mm512_set1_pd(NEVER_ZERO)) }
}

/// Adds the velocity of one segment.
#[target_feature(enable = "avx512f")]
#[inline]
fn add(felt: &Felt, strength: f64, sum: &mut [__m512d; 3]) {
    let (factor, strength) = (_mm512_div_pd(felt.numerator, felt.denominator), _mm512_set1_pd(strength));
    for (sum, across) in sum.iter_mut().zip(&felt.across) {
        *sum = _mm512_fmadd_pd(_mm512_mul_pd(*across, factor), strength, *sum);
    }
}

/// Eight numbers of two blocks in one register.
#[target_feature(enable = "avx512f")]
#[inline]
fn joined(low: f64x4, high: f64x4) -> __m512d {
    let ([a, b, c, d], [e, f, g, h]) = (low.to_array(), high.to_array());
    _mm512_set_pd(h, g, f, e, d, c, b, a)
}

/// The number in a lane.
#[target_feature(enable = "avx512f")]
#[inline]
fn lane(of: __m512d, lane: usize) -> f64 {
    _mm512_cvtsd_f64(_mm512_permutexvar_pd(_mm512_set1_epi64(lane as i64), of))
}

/// As [`add_induced`](crate::kernel::add_induced) of vortices with cores, for two blocks of points (m) and the sums of their
/// velocities (m/s).
#[target_feature(enable = "avx512f")]
pub fn add_induced(
    grid: &VortexGrid,
    window: &Window,
    pair: [&[f64x4; 3]; 2],
    seen: &mut Vec<WideVertex>,
    sums: &mut [[f64x4; 3]; 2],
) {
    let n = grid.columns;
    let [first_row, last_row] = window.rows;
    let [first, last] = window.columns;
    let last_along = if last + 1 < n { 0.0 } else { 1.0 };
    let mut p = [_mm512_setzero_pd(); 3];
    let mut sum = p;
    for (k, (p, sum)) in p.iter_mut().zip(&mut sum).enumerate() {
        *p = joined(pair[0][k], pair[1][k]);
        *sum = joined(sums[0][k], sums[1][k]);
    }
    seen.clear();
    for r in first_row..=last_row {
        let points = &grid.points[r * n + first..=r * n + last];
        let here = r * (n - 1) + first..r * (n - 1) + last;
        let (across, core_across) = (&grid.across[here.clone()], &grid.core_across[here]);
        let own = if r == last_row && r + 1 < grid.rows() { 0.0 } else { 1.0 };
        let mut left = see(&p, points[0]);
        if r == first_row {
            seen.push(left);
            for ((point, strength), core) in points[1..].iter().zip(across).zip(core_across) {
                let now = see(&p, *point);
                add(&cored(&left, &now, *core), own * strength, &mut sum);
                seen.push(now);
                left = now;
            }
            continue;
        }
        let above = (r - 1) * n + first..=(r - 1) * n + last;
        let (along, core_along) = (&grid.along[above.clone()], &grid.core_along[above]);
        let edge = if points.len() == 1 { last_along } else { 1.0 };
        add(&cored(&seen[0], &left, core_along[0]), edge * along[0], &mut sum);
        seen[0] = left;
        let cells = points.len() - 1;
        let rest = points[1..].iter().zip(&mut seen[1..]).zip(across.iter().zip(core_across));
        let rest = rest.zip(along[1..].iter().zip(&core_along[1..])).enumerate();
        for (cell, (((point, before), (across, core_across)), (along, core_along))) in rest {
            let now = see(&p, *point);
            let along = if cell + 1 == cells { last_along * along } else { *along };
            let (one, two) = (cored(before, &now, *core_along), cored(&left, &now, *core_across));
            // Two quotients for one division.
            let inverse = _mm512_div_pd(_mm512_set1_pd(1.0), _mm512_mul_pd(one.denominator, two.denominator));
            let a = _mm512_mul_pd(
                _mm512_mul_pd(one.numerator, _mm512_set1_pd(along)),
                _mm512_mul_pd(two.denominator, inverse),
            );
            let b = _mm512_mul_pd(
                _mm512_mul_pd(two.numerator, _mm512_set1_pd(own * across)),
                _mm512_mul_pd(one.denominator, inverse),
            );
            for ((sum, one), two) in sum.iter_mut().zip(&one.across).zip(&two.across) {
                *sum = _mm512_fmadd_pd(*one, a, _mm512_fmadd_pd(*two, b, *sum));
            }
            *before = now;
            left = now;
        }
    }
    for (k, sum) in sum.into_iter().enumerate() {
        let mut lanes = [[0.0; LANES]; 2];
        for (i, number) in lanes.iter_mut().flatten().enumerate() {
            *number = lane(sum, i);
        }
        (sums[0][k], sums[1][k]) = (f64x4::from(lanes[0]), f64x4::from(lanes[1]));
    }
}
