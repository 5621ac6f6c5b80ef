//! Dense row-major kernels whose inner loops run along contiguous rows. Entries are in the caller's units.

/// a b + c, fused where the target fuses.
#[inline(always)]
fn fused(a: f64, b: f64, c: f64) -> f64 {
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
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}

/// The entries of a matrix row that are not zero, with their columns; made
/// once, reused.
#[derive(Clone, Debug)]
pub struct Terms(Vec<(usize, f64)>);

impl Terms {
    /// Storage for rows of at most `n` entries.
    pub fn new(n: usize) -> Self {
        Self(Vec::with_capacity(n))
    }

    /// Gathers `scale` times `row`.
    fn gather(&mut self, scale: f64, row: &[f64]) {
        self.0.clear();
        for (j, a) in row.iter().enumerate() {
            if *a != 0.0 {
                self.0.push((j, scale * a));
            }
        }
    }

    /// row += sum of the terms times the rows of B that they name.
    fn add_to(&self, row: &mut [f64], b: &[f64]) {
        let width = row.len();
        let mut first = 0;
        while first < width {
            first += match width - first {
                32.. => self.add_block::<32>(row, b, first),
                16.. => self.add_block::<16>(row, b, first),
                8.. => self.add_block::<8>(row, b, first),
                _ => self.add_block::<PACK>(row, b, first),
            };
        }
    }

    /// [`add_to`](Self::add_to) on `N` columns, summed in registers; returns `N`.
    #[inline]
    fn add_block<const N: usize>(&self, row: &mut [f64], b: &[f64], first: usize) -> usize {
        let width = row.len();
        let mut sum = [0.0; N];
        for &(j, a) in &self.0 {
            let b = &b[j * width + first..][..N];
            for l in 0..N {
                sum[l] = fused(a, b[l], sum[l]);
            }
        }
        let row = &mut row[first..][..N];
        for l in 0..N {
            row[l] += sum[l];
        }
        N
    }
}

/// C += alpha A B for A (n x p) and rows of B and C of `width`, a multiple of
/// [`PACK`]; entries of A that are zero cost nothing.
pub fn multiply_add(c: &mut [f64], alpha: f64, a: &[f64], b: &[f64], width: usize, terms: &mut Terms) {
    let inner = b.len() / width;
    for (c, a) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        terms.gather(alpha, a);
        terms.add_to(c, b);
    }
}

/// Rows that the kernels run along are padded to a multiple of this.
pub const PACK: usize = 4;

/// `columns` padded to a multiple of [`PACK`].
pub fn padded(columns: usize) -> usize {
    columns.next_multiple_of(PACK)
}

/// Factors the row-major n x n matrix A = U L from the last state to the
/// first, in place, rows padded to `stride`: states that only respond stand
/// last, so that what they do not drive stays zero and costs nothing. A
/// diagonal below a tenth of its column gives way to the largest entry above
/// it; `pivots` receives the exchanges. False when the matrix is singular.
pub fn factor(a: &mut [f64], n: usize, stride: usize, pivots: &mut [usize]) -> bool {
    for k in (0..n).rev() {
        let magnitude = |i: usize| a[i * stride + k].abs();
        let largest = (0..k).fold(k, |p, i| if magnitude(i) > magnitude(p) { i } else { p });
        let p = if magnitude(k) < 0.1 * magnitude(largest) { largest } else { k };
        pivots[k] = p;
        if !(magnitude(p) > f64::MIN_POSITIVE && magnitude(p).is_finite()) {
            return false;
        }
        exchange(a, stride, p, k);
        let (above, rest) = a.split_at_mut(k * stride);
        let pivot_row = &rest[..padded(k)];
        let inverse = 1.0 / rest[k];
        for row in above.chunks_exact_mut(stride) {
            let factor = row[k] * inverse;
            if factor != 0.0 {
                let (head, tail) = row.split_at_mut(k);
                tail[0] = factor;
                axpy(head, -factor, &pivot_row[..k]);
            }
        }
    }
    true
}

/// Solves A X = B in place from the output of [`factor`], for rows of B of
/// `width`, a multiple of [`PACK`].
pub fn solve(lu: &[f64], stride: usize, pivots: &[usize], b: &mut [f64], width: usize, terms: &mut Terms) {
    let n = pivots.len();
    for k in (0..n).rev() {
        exchange(b, width, pivots[k], k);
    }
    for k in (0..n).rev() {
        let (above, below) = b.split_at_mut((k + 1) * width);
        terms.gather(-1.0, &lu[k * stride + k + 1..k * stride + n]);
        terms.add_to(&mut above[k * width..], below);
    }
    for k in 0..n {
        let (above, rest) = b.split_at_mut(k * width);
        let row = &mut rest[..width];
        terms.gather(-1.0, &lu[k * stride..][..k]);
        terms.add_to(row, above);
        let inverse = 1.0 / lu[k * stride + k];
        row.iter_mut().for_each(|x| *x *= inverse);
    }
}

/// Swaps rows `p` < `k`.
fn exchange(a: &mut [f64], stride: usize, p: usize, k: usize) {
    if p != k {
        let (above, rest) = a.split_at_mut(k * stride);
        above[p * stride..][..stride].swap_with_slice(&mut rest[..stride]);
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
        let a = [1.0, 0.0, 2.0, -1.0, 3.0, 0.5];
        let b = [1.0, 2.0, 0.0, 0.0, 3.0, 4.0, 0.0, 0.0, 5.0, 6.0, 0.0, 0.0];
        let mut c = [1.0; 8];
        multiply_add(&mut c, 2.0, &a, &b, PACK, &mut Terms::new(3));
        assert_eq!(c, [23.0, 29.0, 1.0, 1.0, 22.0, 27.0, 1.0, 1.0]);
    }

    #[test]
    fn factors_solve_with_and_without_exchanges() {
        const N: usize = 5;
        const STRIDE: usize = 8;
        for turned in [0, 2] {
            let entry = |i: usize, j: usize| match (i, j) {
                (0, 3) | (1, 4) if turned == 0 => 0.0,
                _ => ((i * 7 + j * 3) as f64).sin() + if j == (i + turned) % N { 9.0 } else { 0.0 },
            };
            let mut lu = vec![0.0; N * STRIDE];
            let mut b = vec![0.0; N * PACK];
            for i in 0..N {
                for j in 0..N {
                    lu[i * STRIDE + j] = entry(i, j);
                    b[i * PACK + 1] += entry(i, j) * (j as f64 - 1.5);
                }
            }
            let mut pivots = [0; N];
            assert!(factor(&mut lu, N, STRIDE, &mut pivots));
            let exchanges = (0..N).filter(|&k| pivots[k] != k).count();
            assert!(if turned == 0 { exchanges == 0 } else { exchanges > 1 }, "{pivots:?}");
            solve(&lu, STRIDE, &pivots, &mut b, PACK, &mut Terms::new(N));
            for i in 0..N {
                assert!((b[i * PACK + 1] - (i as f64 - 1.5)).abs() < 1e-12, "{b:?}");
            }
        }
        assert!(!factor(&mut [1.0, 2.0, 0.0, 0.0, 2.0, 4.0, 0.0, 0.0], 2, 4, &mut [0; 2]));
    }
}
