//! Sums over contiguous rows of numbers, by index: iterators over two slices stay calls where nothing is optimised at link time. Entries
//! are in the caller's units.

/// a b + c, fused where the target fuses.
#[inline(always)]
pub fn fused(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// y += a x
#[inline]
pub fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    let n = y.len().min(x.len());
    let (y, x) = (&mut y[..n], &x[..n]);
    for i in 0..n {
        y[i] = fused(a, x[i], y[i]);
    }
}

/// x'y, in four partial sums.
#[inline]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().min(y.len());
    let (xs, x_rest) = x[..n].as_chunks::<4>();
    let (ys, y_rest) = y[..n].as_chunks::<4>();
    let mut sum = [0.0; 4];
    for i in 0..xs.len() {
        for l in 0..4 {
            sum[l] = fused(xs[i][l], ys[i][l], sum[l]);
        }
    }
    let mut rest = 0.0;
    for i in 0..x_rest.len() {
        rest += x_rest[i] * y_rest[i];
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}
