//! Sums over contiguous rows of numbers, by index: iterators over two slices stay calls where nothing is optimised at link time. Entries
//! are in the caller's units.

use wide::f64x4;

/// a b + c, fused where the target fuses.
#[inline(always)]
pub fn fused(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// y += a x
#[inline]
pub fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    let n = y.len().min(x.len());
    let (ys, y_rest) = y[..n].as_chunks_mut();
    let (xs, x_rest) = x[..n].as_chunks();
    let factor = f64x4::splat(a);
    for i in 0..xs.len().min(ys.len()) {
        ys[i] = f64x4::new(xs[i]).mul_add(factor, f64x4::new(ys[i])).to_array();
    }
    for i in 0..x_rest.len().min(y_rest.len()) {
        y_rest[i] = fused(a, x_rest[i], y_rest[i]);
    }
}

/// x'y, in four partial sums.
#[inline]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().min(y.len());
    let (xs, x_rest) = x[..n].as_chunks();
    let (ys, y_rest) = y[..n].as_chunks();
    let mut sums = f64x4::ZERO;
    for i in 0..xs.len().min(ys.len()) {
        sums = f64x4::new(xs[i]).mul_add(f64x4::new(ys[i]), sums);
    }
    let (sum, mut rest) = (sums.to_array(), 0.0);
    for i in 0..x_rest.len().min(y_rest.len()) {
        rest += x_rest[i] * y_rest[i];
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}

/// True when no number is infinite or none: all times zero are zero.
pub fn all_finite(x: &[f64]) -> bool {
    let (chunks, rest) = x.as_chunks();
    let mut sums = f64x4::ZERO;
    for i in 0..chunks.len() {
        sums = f64x4::new(chunks[i]).mul_add(f64x4::ZERO, sums);
    }
    sums.reduce_add() == 0.0 && rest.iter().all(|v| v.is_finite())
}
