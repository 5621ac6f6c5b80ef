//! Small motions about a shape at rest or in steady rotation.

use crate::beam::Beam;
use crate::motion::Setting;
use nalgebra::linalg::{Schur, balancing::balance_parlett_reinsch};
use nalgebra::{Complex, DMatrix};

/// Steps of the QR iteration for each row of a matrix, as in LAPACK's `dhseqr`.
const QR_STEPS: usize = 30;

/// Mass, damping (with gyroscopic terms) and stiffness of small motions, by the coordinates. With coordinates in the units of
/// their strains the rows are generalised forces: J over those units.
#[derive(Clone, Debug)]
pub struct SmallMotionMatrices {
    /// Mass.
    pub mass: DMatrix<f64>,
    /// Damping and gyroscopic terms.
    pub damping: DMatrix<f64>,
    /// Stiffness, with that of loads and rotation.
    pub stiffness: DMatrix<f64>,
}

/// The small motions about the shape `q`, at rest in the axes of the root. Strains of twist and bending are in rad/m, the
/// others dimensionless.
pub fn linear(beam: &Beam, setting: &Setting, q: &[f64]) -> SmallMotionMatrices {
    let zero = vec![0.0; q.len()];
    let [stiffness, damping, mass] = beam.tangents(setting, [q, &zero, &zero], &[]);
    SmallMotionMatrices { mass, damping, stiffness }
}

/// Eigenvalues of M x'' + C x' + K x = 0, rad/s; none where the mass is singular.
pub fn eigenvalues(linear: &SmallMotionMatrices) -> Vec<Complex<f64>> {
    let n = linear.mass.nrows();
    let factors = linear.mass.clone().lu();
    let (Some(k), Some(c)) = (factors.solve(&linear.stiffness), factors.solve(&linear.damping)) else {
        return Vec::new();
    };
    let rates = DMatrix::from_fn(n, 2 * n, |i, j| if j < n { k[(i, j)] } else { c[(i, j - n)] });
    of_first_order(&rates, n)
}

/// Eigenvalues of the states q (`n` of them), v and x where q' = v and (v', x')' = -`rates` (q, v, x)', rad/s; none where one is not
/// finite, or the QR iteration finds no end.
pub fn of_first_order(rates: &DMatrix<f64>, n: usize) -> Vec<Complex<f64>> {
    let size = rates.ncols();
    let matrix = DMatrix::from_fn(size, size, |i, j| match i.checked_sub(n) {
        None => f64::from(u8::from(j == i + n)),
        Some(i) => -rates[(i, j)],
    });
    if !matrix.iter().all(|x| x.is_finite()) {
        return Vec::new();
    }
    // Rows of very unlike size, as a soft sheet beside a stiff spar has, are made alike where the iteration does not end.
    let ended = |matrix: DMatrix<f64>| Schur::try_new(matrix, f64::EPSILON, QR_STEPS * size);
    let balanced = || {
        let mut alike = matrix.clone();
        balance_parlett_reinsch(&mut alike);
        ended(alike)
    };
    let found = ended(matrix.clone()).or_else(balanced);
    found.map_or_else(Vec::new, |schur| schur.complex_eigenvalues().iter().copied().collect())
}

/// Frequencies of the oscillations, rad/s, ascending, and their shapes by the coordinates, of unit mass, without damping and
/// gyroscopic terms; none where the mass is not positive.
pub fn frequencies(linear: &SmallMotionMatrices) -> Vec<(f64, Vec<f64>)> {
    let Some(root) = linear.mass.clone().cholesky() else { return Vec::new() };
    let Some(inverse) = root.l().try_inverse() else { return Vec::new() };
    let symmetric = (&linear.stiffness + linear.stiffness.transpose()) * 0.5;
    let eigen = (&inverse * symmetric * inverse.transpose()).symmetric_eigen();
    let shapes = inverse.transpose() * &eigen.eigenvectors;
    let mode = |i: usize| (eigen.eigenvalues[i].max(0.0).sqrt(), shapes.column(i).iter().copied().collect());
    let mut modes: Vec<(f64, Vec<f64>)> = (0..eigen.eigenvalues.len()).map(mode).collect();
    wingbeat_math::order::ascend_by(&mut modes, |item| item.0);
    modes
}
