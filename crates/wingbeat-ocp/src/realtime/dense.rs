//! Dense row-major kernels whose inner loops run along contiguous rows. Entries are in the caller's units.

use wingbeat_math::rows::{axpy, dot, fused};

/// The entries of a matrix row in blocks of [`PACK`], without blocks that are zero, then the entries that fill no block; made once,
/// reused. An entry of zero adds nothing, to the bit.
#[derive(Clone, Debug)]
pub struct Terms {
    /// First column and entries of each block, as many as are `used`.
    blocks: Vec<(usize, [f64; PACK])>,
    used: usize,
    rest: [f64; PACK],
    /// Columns of the `rest`.
    beyond: std::ops::Range<usize>,
}

impl Terms {
    /// Storage for rows of at most `n` entries.
    pub fn new(n: usize) -> Self {
        Self { blocks: vec![(0, [0.0; PACK]); n / PACK], used: 0, rest: [0.0; PACK], beyond: 0..0 }
    }

    /// Gathers `scale` times `row`.
    fn gather(&mut self, scale: f64, row: &[f64]) {
        let (blocks, rest) = row.as_chunks::<PACK>();
        self.used = 0;
        for k in 0..blocks.len() {
            let [a, b, c, d] = blocks[k];
            if (a != 0.0) | (b != 0.0) | (c != 0.0) | (d != 0.0) {
                self.blocks[self.used] = (k * PACK, [scale * a, scale * b, scale * c, scale * d]);
                self.used += 1;
            }
        }
        self.beyond = row.len() - rest.len()..row.len();
        for j in 0..rest.len() {
            self.rest[j] = scale * rest[j];
        }
    }

    /// row += sum of the terms times the rows of B that they name.
    fn add_to(&self, row: &mut [f64], b: &[f64]) {
        let width = row.len();
        let mut first = 0;
        while first < width {
            first += match (width - first) / PACK {
                12.. => self.add_block::<48>(row, b, first),
                11 => self.add_block::<44>(row, b, first),
                10 => self.add_block::<40>(row, b, first),
                9 => self.add_block::<36>(row, b, first),
                8 => self.add_block::<32>(row, b, first),
                7 => self.add_block::<28>(row, b, first),
                6 => self.add_block::<24>(row, b, first),
                5 => self.add_block::<20>(row, b, first),
                4 => self.add_block::<16>(row, b, first),
                3 => self.add_block::<12>(row, b, first),
                2 => self.add_block::<8>(row, b, first),
                _ => self.add_block::<PACK>(row, b, first),
            };
        }
    }

    /// [`add_to`](Self::add_to) on `N` columns, summed in registers; returns `N`.
    #[inline]
    fn add_block<const N: usize>(&self, row: &mut [f64], b: &[f64], first: usize) -> usize {
        let width = row.len();
        let mut sum = [0.0; N];
        for (column, block) in &self.blocks[..self.used] {
            let b = &b[column * width + first..][..(PACK - 1) * width + N];
            for k in 0..PACK {
                let b = &b[k * width..][..N];
                for l in 0..N {
                    sum[l] = fused(block[k], b[l], sum[l]);
                }
            }
        }
        for j in self.beyond.clone() {
            let (a, b) = (self.rest[j - self.beyond.start], &b[j * width + first..][..N]);
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
/// [`PACK`]; blocks of A that are zero cost nothing.
pub fn multiply_add(c: &mut [f64], alpha: f64, a: &[f64], b: &[f64], width: usize, terms: &mut Terms) {
    let inner = b.len() / width;
    for (c, a) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        terms.gather(alpha, a);
        terms.add_to(c, b);
    }
}

/// c += alpha A x for one x, A row-major with as many columns.
pub fn multiply_add_one(c: &mut [f64], alpha: f64, a: &[f64], x: &[f64]) {
    for i in 0..c.len() {
        c[i] = fused(alpha, dot(&a[i * x.len()..][..x.len()], x), c[i]);
    }
}

/// As [`solve`] for one right side.
pub fn solve_one(lu: &[f64], stride: usize, pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for k in (0..n).rev() {
        b.swap(pivots[k], k);
    }
    for k in (0..n).rev() {
        let (above, below) = b[..n].split_at_mut(k + 1);
        above[k] -= dot(&lu[k * stride + k + 1..k * stride + n], below);
    }
    for k in 0..n {
        let (above, rest) = b.split_at_mut(k);
        rest[0] = (rest[0] - dot(&lu[k * stride..][..k], above)) / lu[k * stride + k];
    }
}

/// Rows that the kernels run along are padded to a multiple of this.
pub const PACK: usize = 4;

/// A padded row, [`PACK`] by [`PACK`].
#[inline]
pub fn packs(row: &[f64]) -> &[[f64; PACK]] {
    row.as_chunks().0
}

/// The same, to be changed.
#[inline]
pub fn packs_mut(row: &mut [f64]) -> &mut [[f64; PACK]] {
    row.as_chunks_mut().0
}

/// `columns` padded to a multiple of [`PACK`].
pub fn padded(columns: usize) -> usize {
    columns.next_multiple_of(PACK)
}

/// Factors the row-major n x n matrix A = U L from the last state to the
/// first, in place, rows padded to `stride`: states that only respond stand
/// last, so that what they do not drive stays zero and costs nothing. A
/// diagonal below a tenth of its column gives way to the largest entry above
/// it; `pivots` receives the exchanges. False when the matrix is singular.
///
/// [`PACK`] columns are eliminated at a time, then what stands before them hears of all of them at once, in the same order.
pub fn factor(a: &mut [f64], n: usize, stride: usize, pivots: &mut [usize]) -> bool {
    let mut end = n;
    while end > 0 {
        let start = (end - 1) / PACK * PACK;
        for k in (start..end).rev() {
            let Some(p) = pivot(a, stride, k) else { return false };
            pivots[k] = p;
            exchange(a, stride, p, k);
            eliminate(a, stride, start, k);
        }
        let (above, panel) = a.split_at_mut(start * stride);
        let last = end - start - 1;
        for i in (0..last).rev() {
            let (upper, lower) = panel.split_at_mut((i + 1) * stride);
            let (head, factors) = upper[i * stride..].split_at_mut(start);
            for k in (i + 1..=last).rev() {
                axpy(head, -factors[k], &lower[(k - i - 1) * stride..]);
            }
        }
        // Of a panel of fewer columns the factors that are not there are zero: their row may be any.
        let row = |k: usize| &packs(&panel[k.min(last) * stride..])[..start / PACK];
        let rows = [row(0), row(1), row(2), row(3)];
        for i in 0..start {
            let (head, factors) = above[i * stride..][..start + PACK].split_at_mut(start);
            let mut negative = [0.0; PACK];
            for k in 0..PACK {
                negative[k] = if k <= last { -factors[k] } else { 0.0 };
            }
            subtract(packs_mut(head), negative, rows);
        }
        end = start;
    }
    true
}

/// The row whose entry of the column `k` is to lead it; none where that is zero or not finite.
fn pivot(a: &[f64], stride: usize, k: usize) -> Option<usize> {
    let mut largest = 0.0;
    for row in a[..k * stride].chunks_exact(stride) {
        let magnitude = row[k].abs();
        largest = if magnitude > largest { magnitude } else { largest };
    }
    let diagonal = a[k * stride + k].abs();
    let gives_way = diagonal < 0.1 * largest;
    let magnitude = if gives_way { largest } else { diagonal };
    if !(magnitude > f64::MIN_POSITIVE && magnitude.is_finite()) {
        return None;
    }
    if gives_way { (0..k).find(|i| a[i * stride + k].abs() == largest) } else { Some(k) }
}

/// Eliminates the column `k` from all rows above, in the columns from `start` on.
fn eliminate(a: &mut [f64], stride: usize, start: usize, k: usize) {
    let (above, rest) = a.split_at_mut(k * stride);
    let (at, inverse) = (k - start, 1.0 / rest[k]);
    let mut leading = [0.0; PACK];
    leading[..at].copy_from_slice(&rest[start..k]);
    for row in above.chunks_exact_mut(stride) {
        let row = &mut row[start..][..PACK];
        let factor = row[at] * inverse;
        for l in 0..PACK {
            row[l] = fused(-factor, leading[l], row[l]);
        }
        row[at] = factor;
    }
}

/// y += sum of the terms `factors` times the `rows`, which are as long, from the last to the first.
#[inline]
fn subtract(y: &mut [[f64; PACK]], factors: [f64; PACK], rows: [&[[f64; PACK]]; PACK]) {
    let [a, b, c, d] = factors;
    if (a == 0.0) & (b == 0.0) & (c == 0.0) & (d == 0.0) {
        return;
    }
    let n = y.len();
    let rows = [&rows[0][..n], &rows[1][..n], &rows[2][..n], &rows[3][..n]];
    for i in 0..n {
        let mut sum = y[i];
        for k in (0..PACK).rev() {
            for l in 0..PACK {
                sum[l] = fused(factors[k], rows[k][i][l], sum[l]);
            }
        }
        y[i] = sum;
    }
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
        for (n, turned) in [(5, 0), (5, 2), (14, 0), (14, 6), (16, 0), (16, 9)] {
            let entry = |i: usize, j: usize| match (i, j) {
                (0, 3) | (1, 4) if turned == 0 => 0.0,
                _ => ((i * 7 + j * 3) as f64).sin() + if j == (i + turned) % n { 9.0 } else { 0.0 },
            };
            let stride = padded(n);
            let mut lu = vec![0.0; n * stride];
            let mut b = vec![0.0; n * PACK];
            for i in 0..n {
                for j in 0..n {
                    lu[i * stride + j] = entry(i, j);
                    b[i * PACK + 1] += entry(i, j) * (j as f64 - 1.5);
                }
            }
            let mut pivots = vec![0; n];
            assert!(factor(&mut lu, n, stride, &mut pivots));
            let exchanges = (0..n).filter(|&k| pivots[k] != k).count();
            assert!(if turned == 0 { exchanges == 0 } else { exchanges > 1 }, "{pivots:?}");
            solve(&lu, stride, &pivots, &mut b, PACK, &mut Terms::new(n));
            for i in 0..n {
                assert!((b[i * PACK + 1] - (i as f64 - 1.5)).abs() < 1e-12, "{b:?}");
            }
        }
        assert!(!factor(&mut [1.0, 2.0, 0.0, 0.0, 2.0, 4.0, 0.0, 0.0], 2, 4, &mut [0; 2]));
    }
}
