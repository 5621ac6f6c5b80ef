//! Dense row-major kernels whose inner loops run along contiguous rows. Entries are in the caller's units.

use std::ops::Range;
use wingbeat_math::rows::{axpy, dot, fused};

/// Widest panel: its rows are summed in registers.
pub const WIDEST: usize = 48;

/// First column and width of panels of about the same width that make up `width` columns, a multiple of [`PACK`].
pub fn panels(width: usize) -> impl Iterator<Item = (usize, usize)> {
    let each = padded(width.div_ceil(width.div_ceil(WIDEST).max(1))).max(PACK);
    (0..width).step_by(each).map(move |first| (first, each.min(width - first)))
}

/// `scale` times some rows of a matrix with rows of `stride`.
pub struct LeftFactor<'a> {
    pub scale: f64,
    pub a: &'a [f64],
    pub stride: usize,
    pub rows: [Range<usize>; 2],
}

/// Calls a kernel for rows of `width`, a multiple of [`PACK`] up to [`WIDEST`].
macro_rules! by_width {
    ($width:expr, $kernel:ident $arguments:tt) => {
        match $width {
            4 => $kernel::<4> $arguments,
            8 => $kernel::<8> $arguments,
            12 => $kernel::<12> $arguments,
            16 => $kernel::<16> $arguments,
            20 => $kernel::<20> $arguments,
            24 => $kernel::<24> $arguments,
            28 => $kernel::<28> $arguments,
            32 => $kernel::<32> $arguments,
            36 => $kernel::<36> $arguments,
            40 => $kernel::<40> $arguments,
            44 => $kernel::<44> $arguments,
            48 => $kernel::<48> $arguments,
            width => panic!("a panel of {width} columns"),
        }
    };
}

/// C += A B for rows of C of `stride`, of which the first `width` entries are meant; the columns of A from each of the given ones on
/// meet rows of B of `width`. Blocks of [`PACK`] entries of A that are zero cost nothing: a term of zero adds nothing, to the bit.
pub fn add_product(c: &mut [f64], stride: usize, a: &LeftFactor, parts: &[(usize, &[f64])], width: usize) {
    for (place, i) in a.rows[0].clone().chain(a.rows[1].clone()).enumerate() {
        let row = &a.a[i * a.stride..][..a.stride];
        by_width!(width, add_row(&mut c[place * stride..], a.scale, row, parts));
    }
}

/// c += scale times the sum of the entries of a row of A from each of the given ones on times the rows of B.
#[inline(never)]
fn add_row<const N: usize>(c: &mut [f64], scale: f64, row: &[f64], parts: &[(usize, &[f64])]) {
    let mut sum = [0.0; N];
    for (from, b) in parts {
        add_terms(&mut sum, &row[*from..], b.as_chunks().0);
    }
    let c = &mut c[..N];
    for l in 0..N {
        c[l] = fused(scale, sum[l], c[l]);
    }
}

/// sum += sum_k a_k b_k over as many as there are of both.
#[inline(always)]
fn add_terms<const N: usize>(sum: &mut [f64; N], a: &[f64], b: &[[f64; N]]) {
    let n = a.len().min(b.len());
    let (blocks, rest) = a[..n].as_chunks::<PACK>();
    let (rows, rows_rest) = b[..n].as_chunks::<PACK>();
    for i in 0..blocks.len().min(rows.len()) {
        let (a, b) = (&blocks[i], &rows[i]);
        if (a[0] == 0.0) & (a[1] == 0.0) & (a[2] == 0.0) & (a[3] == 0.0) {
            continue;
        }
        for k in 0..PACK {
            for l in 0..N {
                sum[l] = fused(a[k], b[k][l], sum[l]);
            }
        }
    }
    for k in 0..rest.len().min(rows_rest.len()) {
        for l in 0..N {
            sum[l] = fused(rest[k], rows_rest[k][l], sum[l]);
        }
    }
}

/// C += A B for A (n x p) and rows of B and C of `width`, a multiple of [`PACK`].
pub fn multiply_add(c: &mut [f64], a: &[f64], b: &[f64], width: usize) {
    let inner = b.len() / width;
    if width <= WIDEST {
        let a = LeftFactor { scale: 1.0, a, stride: inner, rows: [0..c.len() / width, 0..0] };
        return add_product(c, width, &a, &[(0, b)], width);
    }
    for (c, a) in c.chunks_exact_mut(width).zip(a.chunks_exact(inner)) {
        for (a, b) in a.iter().zip(b.chunks_exact(width)).filter(|(a, _)| **a != 0.0) {
            axpy(c, *a, b);
        }
    }
}

/// As [`solve`] for one right side.
pub fn solve_one(lu: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    for k in (0..n).rev() {
        b.swap(pivots[k], k);
    }
    for k in (0..n).rev() {
        let (above, below) = b[..n].split_at_mut(k + 1);
        above[k] -= dot(&lu[k * n + k + 1..k * n + n], below);
    }
    for k in 0..n {
        let (above, rest) = b.split_at_mut(k);
        rest[0] = (rest[0] - dot(&lu[k * n..][..k], above)) / lu[k * n + k];
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

/// Columns that [`factor`] eliminates at a time.
const PANEL: usize = 8;

/// Factors the row-major n x n matrix A = U L, n a multiple of [`PACK`], from the last state to the
/// first, in place. A
/// diagonal below a tenth of its column gives way to the largest entry above
/// it; `pivots` receives the exchanges. False when the matrix is singular.
///
/// Of [`PANEL`] columns that are eliminated what stands before them hears at once.
#[inline(never)]
pub fn factor(a: &mut [f64], pivots: &mut [usize]) -> bool {
    let (n, mut end) = (pivots.len(), pivots.len());
    while end > 0 {
        let start = end.saturating_sub(PANEL);
        for k in (start..end).rev() {
            let Some(p) = pivot(a, n, k) else { return false };
            pivots[k] = p;
            exchange(a, n, p, k);
            if end - start == PANEL {
                eliminate::<PANEL>(a, n, start, k)
            } else {
                eliminate::<PACK>(a, n, start, k)
            }
        }
        if start > 0 {
            let (above, panel) = a.split_at_mut(start * n);
            for i in (0..PANEL - 1).rev() {
                let (upper, lower) = panel.split_at_mut((i + 1) * n);
                let (head, factors) = upper[i * n..].split_at_mut(start);
                take_rows(head, factors, i + 1, lower, n);
            }
            for row in above.chunks_exact_mut(n) {
                let (head, factors) = row.split_at_mut(start);
                take_rows(head, factors, 0, panel, n);
            }
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

/// Eliminates the column `k` from all rows above, in the `N` columns from `start` on.
fn eliminate<const N: usize>(a: &mut [f64], stride: usize, start: usize, k: usize) {
    let (above, rest) = a.split_at_mut(k * stride);
    let (at, inverse) = (k - start, 1.0 / rest[k]);
    let mut leading = [0.0; N];
    leading[..at].copy_from_slice(&rest[start..k]);
    for row in above.chunks_exact_mut(stride) {
        let row = &mut row[start..][..N];
        let factor = row[at] * inverse;
        for l in 0..N {
            row[l] = fused(-factor, leading[l], row[l]);
        }
        row[at] = factor;
    }
}

/// y -= sum of the `factors` of a panel from the one given on times the `rows` of `stride`, which begin with as many entries.
#[inline(never)]
fn take_rows(y: &mut [f64], factors: &[f64], from: usize, rows: &[f64], stride: usize) {
    let mut negative = [0.0; PANEL];
    for k in from..PANEL {
        negative[k] = -factors[k];
    }
    if negative == [0.0; PANEL] {
        return;
    }
    let y = packs_mut(y);
    let n = y.len();
    // Of the factors before, which are zero here, the row may be any.
    let row = |k: usize| &packs(&rows[k.saturating_sub(from) * stride..])[..n];
    let rows = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
    for i in 0..n {
        let mut sum = y[i];
        for k in 0..PANEL {
            for l in 0..PACK {
                sum[l] = fused(negative[k], rows[k][i][l], sum[l]);
            }
        }
        y[i] = sum;
    }
}

/// Solves A X = B in place from the output of [`factor`], for rows of B of
/// `width`, a multiple of [`PACK`] up to [`WIDEST`].
pub fn solve(lu: &[f64], pivots: &[usize], b: &mut [f64], width: usize) {
    let n = pivots.len();
    for k in (0..n).rev() {
        exchange(b, width, pivots[k], k);
    }
    for k in (0..n).rev() {
        let (above, below) = b.split_at_mut((k + 1) * width);
        let factors = &lu[k * n + k + 1..(k + 1) * n];
        by_width!(width, add_row(&mut above[k * width..], -1.0, factors, &[(0, below)]));
    }
    for k in 0..n {
        let (above, rest) = b.split_at_mut(k * width);
        by_width!(width, add_row(rest, -1.0, &lu[k * n..][..k], &[(0, above)]));
        let inverse = 1.0 / lu[k * n + k];
        rest[..width].iter_mut().for_each(|x| *x *= inverse);
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
        multiply_add(&mut c, &a, &b, PACK);
        assert_eq!(c, [12.0, 15.0, 1.0, 1.0, 11.5, 14.0, 1.0, 1.0]);
    }

    #[test]
    fn factors_solve_with_and_without_exchanges() {
        for (n, turned) in [(4, 0), (8, 3), (12, 0), (16, 6), (20, 0), (20, 9)] {
            let entry = |i: usize, j: usize| match (i, j) {
                (0, 3) | (1, 2) if turned == 0 => 0.0,
                _ => ((i * 7 + j * 3) as f64).sin() + if j == (i + turned) % n { 9.0 } else { 0.0 },
            };
            let (mut lu, mut b) = (vec![0.0; n * n], vec![0.0; n * PACK]);
            for i in 0..n {
                for j in 0..n {
                    lu[i * n + j] = entry(i, j);
                    b[i * PACK + 1] += entry(i, j) * (j as f64 - 1.5);
                }
            }
            let (mut pivots, mut one) =
                (vec![0; n], b[1..].iter().step_by(PACK).copied().collect::<Vec<_>>());
            assert!(factor(&mut lu, &mut pivots));
            let exchanges = (0..n).filter(|&k| pivots[k] != k).count();
            assert!(if turned == 0 { exchanges == 0 } else { exchanges > 1 }, "{pivots:?}");
            solve(&lu, &pivots, &mut b, PACK);
            solve_one(&lu, &pivots, &mut one);
            for i in 0..n {
                assert!((b[i * PACK + 1] - (i as f64 - 1.5)).abs() < 1e-12, "{b:?}");
                assert!((one[i] - (i as f64 - 1.5)).abs() < 1e-12, "{one:?}");
            }
        }
        let singular = |i: usize, j: usize| {
            if i < 2 && j < 2 { ((i + 1) * (j + 1)) as f64 } else { f64::from(u8::from(i == j)) }
        };
        let mut a: Vec<f64> = (0..16).map(|k| singular(k / 4, k % 4)).collect();
        assert!(!factor(&mut a, &mut [0; 4]));
    }

    #[test]
    fn panels_are_of_about_one_width() {
        let of = |width| panels(width).collect::<Vec<_>>();
        assert_eq!(
            [of(48), of(60), of(100)],
            [vec![(0, 48)], vec![(0, 32), (32, 28)], vec![(0, 36), (36, 36), (72, 28)]]
        );
    }
}
