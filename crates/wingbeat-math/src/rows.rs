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

/// y = a x + b z
#[inline]
pub fn combine(y: &mut [f64], [a, b]: [f64; 2], [x, z]: [&[f64]; 2]) {
    let n = y.len().min(x.len()).min(z.len());
    let (ys, y_rest) = y[..n].as_chunks_mut();
    let ((xs, x_rest), (zs, z_rest)) = (x[..n].as_chunks(), z[..n].as_chunks());
    let (a_all, b_all) = (f64x4::splat(a), f64x4::splat(b));
    for i in 0..ys.len().min(xs.len()).min(zs.len()) {
        ys[i] = f64x4::new(zs[i]).mul_add(b_all, f64x4::new(xs[i]) * a_all).to_array();
    }
    for i in 0..y_rest.len().min(x_rest.len()).min(z_rest.len()) {
        y_rest[i] = fused(b, z_rest[i], a * x_rest[i]);
    }
}

/// y += sum_k a_k x_k
pub fn axpy_four(y: &mut [f64], a: [f64; 4], x: [&[f64]; 4]) {
    let n = x.iter().fold(y.len(), |n, x| n.min(x.len()));
    let (ys, y_rest) = y[..n].as_chunks_mut();
    let [x0, x1, x2, x3] =
        [x[0][..n].as_chunks(), x[1][..n].as_chunks(), x[2][..n].as_chunks(), x[3][..n].as_chunks()];
    for i in 0..ys.len().min(x0.0.len()).min(x1.0.len()).min(x2.0.len()).min(x3.0.len()) {
        let sum = f64x4::new(x0.0[i]).mul_add(f64x4::splat(a[0]), f64x4::new(ys[i]));
        let sum = f64x4::new(x1.0[i]).mul_add(f64x4::splat(a[1]), sum);
        let sum = f64x4::new(x2.0[i]).mul_add(f64x4::splat(a[2]), sum);
        ys[i] = f64x4::new(x3.0[i]).mul_add(f64x4::splat(a[3]), sum).to_array();
    }
    for i in 0..y_rest.len() {
        y_rest[i] += (a[0] * x0.1[i] + a[1] * x1.1[i]) + (a[2] * x2.1[i] + a[3] * x3.1[i]);
    }
}

/// y += a x; returns x'z.
pub fn axpy_dot(y: &mut [f64], a: f64, x: &[f64], z: &[f64]) -> f64 {
    let n = y.len().min(x.len()).min(z.len());
    let (ys, y_rest) = y[..n].as_chunks_mut();
    let ((xs, x_rest), (zs, z_rest)) = (x[..n].as_chunks(), z[..n].as_chunks());
    let (factor, mut sums, mut rest) = (f64x4::splat(a), f64x4::ZERO, 0.0);
    for i in 0..xs.len().min(ys.len()).min(zs.len()) {
        let x = f64x4::new(xs[i]);
        ys[i] = x.mul_add(factor, f64x4::new(ys[i])).to_array();
        sums = x.mul_add(f64x4::new(zs[i]), sums);
    }
    for i in 0..x_rest.len().min(y_rest.len()).min(z_rest.len()) {
        y_rest[i] = fused(a, x_rest[i], y_rest[i]);
        rest = fused(x_rest[i], z_rest[i], rest);
    }
    sums.reduce_add() + rest
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
