//! Eigenvalues of a square matrix, by an iteration that ends.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Steps of the QR iteration for each eigenvalue, as in LAPACK's `dhseqr`.
const STEPS: usize = 30;
/// Tries after the first: balanced, then with a reflection each. *Choice.*
const TRIES: usize = 6;
/// By how much each of them takes more for zero beside the diagonal. *Choice*: the last takes 6e-11 of it.
const LOOSER: f64 = 8.0;

/// Eigenvalues of a square matrix, in no order and in the unit of its entries; none where an entry is not finite or the iteration does not end.
///
/// The double shift of Francis turns in circles on some matrices: on those with rows of very unlike size, such as of a soft sheet beside a
/// stiff spar, which a balanced one mends (Parlett & Reinsch 1969), and on cyclic permutations. With a reflection H = I - 2 v v' the matrix
/// H A H has the same eigenvalues and another iteration. Where large entries leave rounding beside small eigenvalues that are almost the
/// same, as the lags of many strips beside a stiff spar, nothing beside the diagonal ever gets small enough for them: each try takes more
/// for zero.
pub fn spectrum(matrix: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if !matrix.iter().all(|x| x.is_finite()) {
        return None;
    }
    let size = matrix.nrows();
    if size == 0 {
        return Some(Vec::new());
    }
    let (mut tried, mut tolerance) = (matrix.clone(), f64::EPSILON);
    for turn in 0..=TRIES {
        if let Some(found) = Schur::try_new(tried, tolerance, STEPS * size) {
            return Some(found.complex_eigenvalues().iter().copied().collect());
        }
        tolerance *= LOOSER;
        tried = matrix.clone();
        balance_parlett_reinsch(&mut tried);
        if turn == 0 {
            continue;
        }
        let axis = DVector::from_fn(size, |i, _| ((turn * (i + 1)) as f64).sin()).normalize();
        let reflection = DMatrix::identity(size, size) - &axis * axis.transpose() * 2.0;
        tried = &reflection * tried * &reflection;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_on_which_the_shift_turns_in_circles_have_eigenvalues() {
        for size in 1..=12 {
            let root = 1.7748_f64.powf(1.0 / size as f64);
            let cyclic = DMatrix::from_fn(size, size, |i, j| match (i, j) {
                (0, j) if j + 1 == size => 1.7748,
                (i, j) if i == j + 1 => 1.0,
                _ => 0.0,
            });
            let found = spectrum(&cyclic).unwrap();
            for k in 0..size {
                let wanted = Complex::from_polar(root, std::f64::consts::TAU * k as f64 / size as f64);
                let nearest = found.iter().map(|value| (value - wanted).norm()).fold(f64::MAX, f64::min);
                assert!(nearest < 1e-12, "{size}, {wanted}: {found:?}");
            }
        }
    }

    /// A stiff oscillator that drives lags of almost one rate, each of which feeds the next.
    #[test]
    fn lags_beside_a_stiff_spar_have_eigenvalues() {
        let (lags, stiff) = (60, 1.3e5_f64);
        let size = lags + 2;
        let matrix = DMatrix::from_fn(size, size, |i, j| match (i, j) {
            (0, 1) => 1.0,
            (1, 0) => -stiff * stiff,
            (1, 1) => -20.0,
            (i, j) if i > 1 && i == j => -100.0,
            (i, 1) if i > 1 => 1e4,
            (1, _) => 1e-3,
            (i, j) if i > 2 && i == j + 1 => 30.0,
            _ => 0.0,
        });
        let found = spectrum(&matrix).unwrap();
        assert_eq!(found.len(), size);
        let fast = found.iter().map(|value| value.im).fold(0.0, f64::max);
        assert!((fast / stiff - 1.0).abs() < 1e-7, "{fast}");
        let trace: f64 = found.iter().map(|value| value.re).sum();
        assert!((trace / matrix.trace() - 1.0).abs() < 1e-6, "{trace}");
    }

    #[test]
    fn a_matrix_with_numbers_that_are_none_has_no_eigenvalues() {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut matrix = DMatrix::identity(4, 4);
            matrix[(2, 1)] = bad;
            assert_eq!(spectrum(&matrix), None);
        }
        assert_eq!(spectrum(&DMatrix::zeros(0, 0)), Some(Vec::new()));
        assert_eq!(spectrum(&DMatrix::zeros(3, 3)).map(|all| all.len()), Some(3));
    }
}
