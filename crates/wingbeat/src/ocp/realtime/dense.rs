//! Dense row-major kernels whose inner loops run along contiguous rows.

/// a b + c, fused where the target fuses.
#[inline(always)]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// y += a x
#[inline]
pub fn axpy(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = fused(a, *x, *y);
    }
}

/// x'y, in four partial sums.
#[inline]
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len().min(y.len());
    let (xs, x_rest) = x[..n].as_chunks::<4>();
    let (ys, y_rest) = y[..n].as_chunks::<4>();
    let mut sum = [0.0; 4];
    for (x, y) in xs.iter().zip(ys) {
        for l in 0..4 {
            sum[l] = fused(x[l], y[l], sum[l]);
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}

/// C += alpha A B for A (n x p) and rows of B and C of `width`; entries of A
/// that are zero cost nothing.
pub fn multiply_add(c: &mut [f64], alpha: f64, a: &[f64], b: &[f64], width: usize) {
    let inner = b.len() / width;
    for (c, a) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        for (a, b) in a.iter().zip(b.chunks_exact(width)) {
            if *a != 0.0 {
                axpy(c, alpha * a, b);
            }
        }
    }
}

/// Cholesky factor L of a symmetric positive definite n x n matrix, in its
/// lower triangle; false when a pivot is not positive.
pub fn cholesky(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        for j in 0..i {
            let other = &above[j * n..][..j + 1];
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        row[i] = pivot.sqrt();
    }
    true
}

/// Inverse of the lower triangle `l` (n x n) into `inverse`, zeros above.
pub fn invert_lower(l: &[f64], n: usize, inverse: &mut [f64]) {
    inverse.fill(0.0);
    for i in 0..n {
        let (above, rest) = inverse.split_at_mut(i * n);
        let row = &mut rest[..n];
        let scale = 1.0 / l[i * n + i];
        for (j, other) in above.chunks_exact(n).enumerate() {
            axpy(&mut row[..=j], -scale * l[i * n + j], &other[..=j]);
        }
        row[i] = scale;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_factor_undoes_cholesky() {
        let a = [4.0, 1.0, -0.5, 1.0, 3.0, 0.25, -0.5, 0.25, 2.0];
        let (mut l, mut inverse) = (a, [0.0; 9]);
        assert!(cholesky(&mut l, 3));
        invert_lower(&l, 3, &mut inverse);
        for i in 0..3 {
            for j in 0..3 {
                // L^-1 A L^-T = I
                let entry: f64 = (0..9).map(|k| inverse[i * 3 + k / 3] * a[k] * inverse[j * 3 + k % 3]).sum();
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
        assert!(!cholesky(&mut [1.0, 2.0, 2.0, 1.0], 2));
    }

    #[test]
    fn products_and_sums_agree_with_their_definition() {
        let x: Vec<f64> = (0..7).map(f64::from).collect();
        assert_eq!(dot(&x, &x), 91.0);
        let (a, b) = ([1.0, 0.0, 2.0, -1.0, 3.0, 0.5], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let mut c = [1.0; 4];
        multiply_add(&mut c, 2.0, &a, &b, 2);
        assert_eq!(c, [23.0, 29.0, 22.0, 27.0]);
    }
}
