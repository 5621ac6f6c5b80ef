//! Small dense solves in place, row-major, without allocation. Matrices and vectors are in the caller's units.

use super::{Over, Scalar};

/// Solves A x = b for a symmetric positive definite `N` x `N` matrix by LDL'
/// (Golub & Van Loan, Matrix Computations, 4.1.2). `None` when a pivot is not
/// positive.
pub fn solve_symmetric<const N: usize, G: Scalar, S: Over<G>>(
    mut a: [[G; N]; N],
    b: [S; N],
) -> Option<[S; N]> {
    solve_symmetric_leading(N, &mut a, b)
}

/// As [`solve_symmetric`] for the leading `n` rows and columns of a matrix that becomes its factors; the rest of the
/// answer is that of `b`.
#[inline]
pub fn solve_symmetric_leading<const N: usize, G: Scalar, S: Over<G>>(
    n: usize,
    a: &mut [[G; N]],
    mut b: [S; N],
) -> Option<[S; N]> {
    solve_symmetric_rows(a, &mut b[..n])?;
    Some(b)
}

/// The same for as many leading rows and columns as `b` has entries, which become those of the answer.
#[inline]
pub fn solve_symmetric_rows<const N: usize, G: Scalar, S: Over<G>>(
    a: &mut [[G; N]],
    b: &mut [S],
) -> Option<()> {
    let n = b.len();
    let a = &mut a[..n];
    let mut inverse = [G::ZERO; N];
    for j in 0..n {
        // Row j times the pivots so far.
        let mut scaled = [G::ZERO; N];
        let mut pivot = a[j][j];
        for k in 0..j {
            scaled[k] = a[j][k] * a[k][k];
            pivot = pivot.less_product(a[j][k], scaled[k]);
        }
        let pivot = pivot.positive()?;
        a[j][j] = pivot;
        inverse[j] = pivot.recip();
        for i in j + 1..n {
            let mut sum = a[i][j];
            for k in 0..j {
                sum = sum.less_product(a[i][k], scaled[k]);
            }
            a[i][j] = sum * inverse[j];
        }
    }
    for i in 0..n {
        for k in 0..i {
            b[i] = b[i].less_over(b[k], a[i][k]);
        }
    }
    for i in 0..n {
        b[i] = b[i] * inverse[i];
    }
    for i in (0..n).rev() {
        for k in i + 1..n {
            b[i] = b[i].less_over(b[k], a[k][i]);
        }
    }
    Some(())
}

/// LU factorisation with partial pivoting of the row-major `n` x `n` matrix
/// `a`, in place; `pivots` receives the row exchanges. Pivoting follows values.
/// Returns false when the matrix is singular to working precision.
pub fn lu_factor<S: Scalar>(a: &mut [S], n: usize, pivots: &mut [usize]) -> bool {
    for k in 0..n {
        let magnitude = |a: &[S], i: usize| a[i * n + k].value().abs();
        let p = (k..n).max_by(|&i, &j| magnitude(a, i).total_cmp(&magnitude(a, j))).unwrap_or(k);
        pivots[k] = p;
        if p != k {
            for j in 0..n {
                a.swap(k * n + j, p * n + j);
            }
        }
        if !(magnitude(a, k) > f64::MIN_POSITIVE && magnitude(a, k).is_finite()) {
            return false;
        }
        let inverse = a[k * n + k].recip();
        let (top, below) = a.split_at_mut((k + 1) * n);
        let pivot_row = &top[k * n + k + 1..];
        for row in below.chunks_exact_mut(n) {
            let factor = row[k] * inverse;
            row[k] = factor;
            for (x, p) in row[k + 1..].iter_mut().zip(pivot_row) {
                *x -= factor * *p;
            }
        }
    }
    true
}

/// Solves A X = B in place for `columns` right-hand sides stored row-major
/// (`n` x `columns`), from [`lu_factor`]'s output.
pub fn lu_solve<S: Scalar>(lu: &[S], n: usize, pivots: &[usize], b: &mut [S], columns: usize) {
    for (k, &p) in pivots.iter().enumerate().take(n) {
        if p != k {
            for j in 0..columns {
                b.swap(k * columns + j, p * columns + j);
            }
        }
    }
    for i in 1..n {
        let (top, rest) = b.split_at_mut(i * columns);
        eliminate(&mut rest[..columns], &lu[i * n..i * n + i], top);
    }
    for i in (0..n).rev() {
        let (head, tail) = b.split_at_mut((i + 1) * columns);
        let row = &mut head[i * columns..];
        eliminate(row, &lu[i * n + i + 1..(i + 1) * n], tail);
        let inverse = lu[i * n + i].recip();
        for x in row {
            *x *= inverse;
        }
    }
}

/// row -= sum_k factors[k] rows[k]
#[inline]
fn eliminate<S: Scalar>(row: &mut [S], factors: &[S], rows: &[S]) {
    for (f, other) in factors.iter().zip(rows.chunks_exact(row.len())) {
        for (x, y) in row.iter_mut().zip(other) {
            *x -= *f * *y;
        }
    }
}

/// Eigenvalues of a symmetric matrix, ascending, by cyclic Jacobi rotations
/// (Golub & Van Loan, Matrix Computations, 8.5).
pub fn symmetric_eigenvalues<const N: usize>(mut a: [[f64; N]; N]) -> [f64; N] {
    for _sweep in 0..50 {
        let off: f64 = (0..N).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a[i][j].powi(2)).sum();
        let scale: f64 = (0..N).map(|i| a[i][i].powi(2)).sum();
        if off <= 1e-32 * scale || off == 0.0 {
            break;
        }
        for p in 0..N {
            for q in p + 1..N {
                jacobi_rotation(&mut a, p, q);
            }
        }
    }
    let mut values: [f64; N] = std::array::from_fn(|i| a[i][i]);
    crate::order::ascend(&mut values);
    values
}

/// Zeroes a[p][q] by a plane rotation.
fn jacobi_rotation<const N: usize>(a: &mut [[f64; N]; N], p: usize, q: usize) {
    if a[p][q] == 0.0 {
        return;
    }
    let tau = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    for k in 0..N {
        let (x, y) = (a[k][p], a[k][q]);
        (a[k][p], a[k][q]) = (c * x - s * y, s * x + c * y);
    }
    for k in 0..N {
        let (x, y) = (a[p][k], a[q][k]);
        (a[p][k], a[q][k]) = (c * x - s * y, s * x + c * y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_of_a_known_matrix() {
        // Second-difference matrix: 2 - 2 cos(k pi / 5).
        let a: [[f64; 4]; 4] =
            std::array::from_fn(|i| std::array::from_fn(|j: usize| [2.0, -1.0, 0.0, 0.0][i.abs_diff(j)]));
        for (k, v) in symmetric_eigenvalues(a).iter().enumerate() {
            let exact = 2.0 - 2.0 * ((k + 1) as f64 * std::f64::consts::PI / 5.0).cos();
            assert!((v - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn both_solvers_agree_with_the_product() {
        let a = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]];
        let x = [1.0, -2.0, 3.0];
        let b: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| a[i][j] * x[j]).sum());
        let mut lu = a.concat();
        let mut pivots = [0; 3];
        assert!(lu_factor(&mut lu, 3, &mut pivots));
        let mut y = b;
        lu_solve(&lu, 3, &pivots, &mut y, 1);
        let z = solve_symmetric(a, b).unwrap();
        for i in 0..3 {
            assert!((y[i] - x[i]).abs() < 1e-14 && (z[i] - x[i]).abs() < 1e-14);
        }
    }

    #[test]
    fn singular_matrices_are_refused() {
        assert!(solve_symmetric([[1.0, 1.0], [1.0, 1.0]], [1.0, 1.0]).is_none());
        assert!(!lu_factor(&mut [1.0, 2.0, 2.0, 4.0], 2, &mut [0; 2]));
    }
}
