//! Dense strictly convex quadratic programs by the dual active-set method (Goldfarb & Idnani 1983): exact, cold-started, no
//! allocation after set-up. Variables, rows and cost are in the caller's units.

use super::dense::{cholesky, invert_lower};
use wingbeat_math::rows::{axpy, dot};

/// min 1/2 z'Hz + g'z with low <= z <= high and row_low <= C z <= row_high.
#[derive(Clone, Debug, Default)]
pub struct QuadraticProgram {
    /// Hessian, n x n row-major, symmetric positive definite.
    pub hessian: Vec<f64>,
    /// Gradient, n.
    pub gradient: Vec<f64>,
    /// Lower limits of the variables, n.
    pub low: Vec<f64>,
    /// Upper limits of the variables, n.
    pub high: Vec<f64>,
    /// Rows C, rows x n, row-major.
    pub rows: Vec<f64>,
    /// Lower limits of the rows.
    pub row_low: Vec<f64>,
    /// Upper limits of the rows.
    pub row_high: Vec<f64>,
}

impl QuadraticProgram {
    /// A program of `n` variables and `rows` two-sided rows.
    pub fn new(n: usize, rows: usize) -> Self {
        Self {
            hessian: vec![0.0; n * n],
            gradient: vec![0.0; n],
            low: vec![f64::NEG_INFINITY; n],
            high: vec![f64::INFINITY; n],
            rows: vec![0.0; rows * n],
            row_low: vec![f64::NEG_INFINITY; rows],
            row_high: vec![f64::INFINITY; rows],
        }
    }

    fn size(&self) -> usize {
        self.gradient.len()
    }
}

/// How the method ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum QpEnd {
    /// The minimum was found.
    Solved,
    /// The limits contradict each other; constraint `worst` (variables first,
    /// then rows) cannot be met with those that bind.
    Infeasible {
        /// Index of the constraint.
        worst: usize,
    },
    /// The Hessian is not positive definite, or rounding made the method cycle.
    Trouble,
}

/// One side of a constraint that binds.
#[derive(Clone, Copy, Debug, Default)]
struct Bound {
    constraint: usize,
    /// +1 at the lower limit, -1 at the upper.
    sign: f64,
    multiplier: f64,
}

/// The solver's working arrays.
#[derive(Clone, Debug)]
pub struct ActiveSet {
    n: usize,
    /// Solution z, n.
    pub z: Vec<f64>,
    factor: Vec<f64>,
    /// J' row by row: J J' = H^-1, and J' N = [R; 0] for the binding normals N.
    basis: Vec<f64>,
    /// R, upper triangular, column j at stride n.
    triangle: Vec<f64>,
    projected: Vec<f64>,
    dual_step: Vec<f64>,
    direction: Vec<f64>,
    binding: Vec<Bound>,
    /// Constraints added or dropped in the last solve.
    pub changes: usize,
    /// Whether that found the minimum.
    solved: bool,
}

impl ActiveSet {
    /// Working arrays for at most `n` variables.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            z: vec![0.0; n],
            factor: vec![0.0; n * n],
            basis: vec![0.0; n * n],
            triangle: vec![0.0; n * n],
            projected: vec![0.0; n],
            dual_step: vec![0.0; n],
            direction: vec![0.0; n],
            binding: Vec::with_capacity(n + 1),
            changes: 0,
            solved: false,
        }
    }

    /// Number of constraints that bind at the solution.
    pub fn active(&self) -> usize {
        self.binding.len()
    }

    /// Solves `qp`; the solution is left in `z`.
    pub fn solve(&mut self, qp: &QuadraticProgram) -> QpEnd {
        if !self.unconstrained_minimum(qp) {
            return QpEnd::Trouble;
        }
        self.improve(qp)
    }

    /// Solves a program that differs from the last one by its gradient and limits alone: from the constraints that bound there, less those
    /// that would pull. Where that one had no solution, or these lead to none, as [`solve`](Self::solve).
    ///
    /// Equation: ocp.moved_program
    /// `z = J [y1; -J2' g], R' y1 = b, R u = y1 + J1' g; the least u below zero is released until none is`
    /// Source: Goldfarb & Idnani 1983, of the minimum on the binding constraints N' z = b with J' N = [R; 0].
    /// Test: `a_moved_program_has_the_solution_that_it_has_alone`.
    pub fn solve_moved(&mut self, qp: &QuadraticProgram) -> QpEnd {
        if !std::mem::take(&mut self.solved) {
            return self.solve(qp);
        }
        self.changes = 0;
        while let Some(pulling) = self.minimum_on_binding(qp) {
            self.changes += 1;
            self.drop(pulling);
        }
        let finite = self.z.iter().all(|z| z.is_finite());
        if finite && self.improve(qp) == QpEnd::Solved { QpEnd::Solved } else { self.solve(qp) }
    }

    /// The minimum where what binds does so, with its multipliers; returns the constraint whose multiplier is the least below zero.
    fn minimum_on_binding(&mut self, qp: &QuadraticProgram) -> Option<usize> {
        let (n, q) = (self.n, self.binding.len());
        for (p, row) in self.projected.iter_mut().zip(self.basis.chunks_exact(n)) {
            *p = dot(row, &qp.gradient);
        }
        for j in 0..q {
            let Bound { constraint, sign, .. } = self.binding[j];
            let limits = match (constraint.checked_sub(n), sign > 0.0) {
                (None, true) => &qp.low,
                (None, false) => &qp.high,
                (Some(_), true) => &qp.row_low,
                (Some(_), false) => &qp.row_high,
            };
            let column = &self.triangle[j * n..][..n];
            let limit = sign * limits[constraint.checked_sub(n).unwrap_or(constraint)];
            self.dual_step[j] = (limit - dot(&column[..j], &self.dual_step[..j])) / column[j];
        }
        self.z.fill(0.0);
        for (j, row) in self.basis.chunks_exact(n).enumerate() {
            let along = if j < q { self.dual_step[j] } else { -self.projected[j] };
            axpy(&mut self.z, along, row);
        }
        for j in 0..q {
            self.dual_step[j] += self.projected[j];
        }
        self.back_substitute(q);
        let mut least = (0.0, None);
        for (j, (bound, u)) in self.binding.iter_mut().zip(&self.dual_step).enumerate() {
            bound.multiplier = *u;
            if *u < least.0 {
                least = (*u, Some(j));
            }
        }
        least.1
    }

    /// Solves R r = v in place of the first `q` numbers of the dual step.
    fn back_substitute(&mut self, q: usize) {
        for j in (0..q).rev() {
            let column = &self.triangle[j * self.n..][..self.n];
            let r = self.dual_step[j] / column[j];
            axpy(&mut self.dual_step[..j], -r, &column[..j]);
            self.dual_step[j] = r;
        }
    }

    /// Lets the constraint that is violated most bind until none is.
    fn improve(&mut self, qp: &QuadraticProgram) -> QpEnd {
        let limit = 20 * (qp.size() + qp.row_low.len()) + 20;
        while let Some((mut bound, mut slack)) = self.most_violated(qp) {
            loop {
                self.changes += 1;
                if self.changes > limit || !slack.is_finite() {
                    return QpEnd::Trouble;
                }
                let (room, blocking) = self.directions(qp, &bound);
                let curvature = dot(&self.projected[self.active()..], &self.projected[self.active()..]);
                let dependent = curvature <= 1e-18 * dot(&self.projected, &self.projected);
                let full = if dependent { f64::INFINITY } else { -slack / curvature };
                let step = room.min(full);
                if step == f64::INFINITY {
                    return QpEnd::Infeasible { worst: bound.constraint };
                }
                if !dependent {
                    axpy(&mut self.z, step, &self.direction);
                    slack += step * curvature;
                }
                for (b, r) in self.binding.iter_mut().zip(&self.dual_step) {
                    b.multiplier -= step * r;
                }
                bound.multiplier += step;
                if step == full {
                    self.add(bound);
                    break;
                }
                self.drop(blocking);
            }
        }
        self.settle(qp);
        self.solved = true;
        QpEnd::Solved
    }

    /// Puts the binding variables exactly on their limits.
    fn settle(&mut self, qp: &QuadraticProgram) {
        for b in self.binding.iter().filter(|b| b.constraint < self.n) {
            let limits = if b.sign > 0.0 { &qp.low } else { &qp.high };
            self.z[b.constraint] = limits[b.constraint];
        }
    }

    /// z = -H^-1 g and J = L^-T; false if H is not positive definite.
    fn unconstrained_minimum(&mut self, qp: &QuadraticProgram) -> bool {
        (self.changes, self.solved) = (0, false);
        self.binding.clear();
        self.factor.copy_from_slice(&qp.hessian);
        if !cholesky(&mut self.factor, self.n) {
            return false;
        }
        invert_lower(&self.factor, self.n, &mut self.basis);
        self.z.fill(0.0);
        for row in self.basis.chunks_exact(self.n) {
            axpy(&mut self.z, -dot(row, &qp.gradient), row);
        }
        self.z.iter().all(|z| z.is_finite())
    }

    /// The constraint violated most, with its slack (negative).
    fn most_violated(&self, qp: &QuadraticProgram) -> Option<(Bound, f64)> {
        let mut worst = (Bound::default(), 0.0);
        let mut look = |constraint: usize, value: f64, low: f64, high: f64| {
            for (sign, limit) in [(1.0, low), (-1.0, high)] {
                let slack = sign * (value - limit);
                if slack < worst.1 - 1e-10 * (1.0 + limit.abs()) {
                    worst = (Bound { constraint, sign, multiplier: 0.0 }, slack);
                }
            }
        };
        for (i, z) in self.z.iter().enumerate() {
            look(i, *z, qp.low[i], qp.high[i]);
        }
        for (i, row) in qp.rows.chunks_exact(self.n).enumerate() {
            look(self.n + i, dot(row, &self.z), qp.row_low[i], qp.row_high[i]);
        }
        (worst.1 < 0.0).then_some(worst)
    }

    /// Primal direction z = J2 J2' a and dual direction r = R^-1 J1' a for the
    /// normal a of `bound`; returns the largest dual step and what blocks it.
    ///
    /// Equation: ocp.dual_active_set
    /// `z = J2 J2' a, r = R^-1 J1' a`
    /// Source: Goldfarb & Idnani 1983.
    /// Test: `random_programs_satisfy_the_optimality_conditions`.
    fn directions(&mut self, qp: &QuadraticProgram, bound: &Bound) -> (f64, usize) {
        let (n, q) = (self.n, self.binding.len());
        if bound.constraint < n {
            for (p, row) in self.projected.iter_mut().zip(self.basis.chunks_exact(n)) {
                *p = bound.sign * row[bound.constraint];
            }
        } else {
            let normal = &qp.rows[(bound.constraint - n) * n..][..n];
            for (p, row) in self.projected.iter_mut().zip(self.basis.chunks_exact(n)) {
                *p = bound.sign * dot(row, normal);
            }
        }
        self.direction.fill(0.0);
        for (p, row) in self.projected.iter().zip(self.basis.chunks_exact(n)).skip(q) {
            axpy(&mut self.direction, *p, row);
        }
        self.dual_step[..q].copy_from_slice(&self.projected[..q]);
        self.back_substitute(q);
        let mut room = (f64::INFINITY, 0);
        for (j, (b, r)) in self.binding.iter().zip(&self.dual_step).enumerate() {
            if *r > 0.0 && b.multiplier / r < room.0 {
                room = (b.multiplier / r, j);
            }
        }
        room
    }

    /// Lets `bound` bind, of which the [directions](Self::directions) are at hand: reflects J2 so that J' a has one entry below R,
    /// J2 - b (J2 v) v' with v = p + sgn(p_1) |p| e_1, p = J2' a, b = 1/(|p| (|p| + |p_1|)); J2 p is the primal direction.
    ///
    /// Equation: ocp.reflected_basis
    /// `J2 := J2 - (J2 v) v'/(q (q + abs(p_1))), v = p + sgn(p_1) q e_1, p = J2' a, q = abs(p)`
    /// Source: Householder; Golub & Van Loan, Matrix Computations, 5.1.
    /// Test: `random_programs_satisfy_the_optimality_conditions`.
    fn add(&mut self, bound: Bound) {
        let (n, q) = (self.n, self.binding.len());
        let first = self.projected[q];
        let length = dot(&self.projected[q..], &self.projected[q..]).sqrt().copysign(first);
        axpy(&mut self.direction, length, &self.basis[q * n..][..n]);
        let share = 1.0 / (length * (length + first));
        self.projected[q] += length;
        for (p, row) in self.projected.iter().zip(self.basis.chunks_exact_mut(n)).skip(q) {
            axpy(row, -share * p, &self.direction);
        }
        self.projected[q] = -length;
        self.triangle[q * n..][..=q].copy_from_slice(&self.projected[..=q]);
        self.binding.push(bound);
    }

    /// Releases the binding constraint at position `l`.
    fn drop(&mut self, l: usize) {
        let n = self.n;
        self.binding.remove(l);
        for j in l..self.binding.len() {
            self.triangle.copy_within((j + 1) * n..(j + 1) * n + j + 2, j * n);
        }
        for j in l..self.binding.len() {
            let column = &self.triangle[j * n..][..n];
            let (c, s, _) = rotation(column[j], column[j + 1]);
            for column in self.triangle.chunks_exact_mut(n).take(self.binding.len()).skip(j) {
                let (a, b) = (column[j], column[j + 1]);
                (column[j], column[j + 1]) = (c * a + s * b, c * b - s * a);
            }
            rotate_rows(&mut self.basis, n, j, c, s);
        }
    }
}

/// Givens rotation (c, s, length) that turns (a, b) into (length, 0).
fn rotation(a: f64, b: f64) -> (f64, f64, f64) {
    if b == 0.0 {
        return (1.0, 0.0, a);
    }
    let length = (a * a + b * b).sqrt();
    (a / length, b / length, length)
}

/// Rotates rows `j` and `j + 1` of a row-major matrix of `n` columns.
fn rotate_rows(matrix: &mut [f64], n: usize, j: usize, c: f64, s: f64) {
    if s == 0.0 {
        return;
    }
    let (upper, lower) = matrix[j * n..(j + 2) * n].split_at_mut(n);
    for i in 0..n {
        let (a, b) = (upper[i], lower[i]);
        upper[i] = c * a + s * b;
        lower[i] = c * b - s * a;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic numbers in (-1, 1).
    fn noise(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (*seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn random_program(n: usize, rows: usize, seed: &mut u64) -> QuadraticProgram {
        let mut qp = QuadraticProgram::new(n, rows);
        let root: Vec<f64> = (0..n * n).map(|_| noise(seed)).collect();
        for i in 0..n {
            for j in 0..n {
                qp.hessian[i * n + j] = (0..n).map(|k| root[k * n + i] * root[k * n + j]).sum();
            }
            qp.hessian[i * n + i] += 0.1;
            qp.gradient[i] = 3.0 * noise(seed);
            (qp.low[i], qp.high[i]) = (-0.5, 0.5);
        }
        qp.rows.iter_mut().for_each(|c| *c = noise(seed));
        qp.row_low.fill(-0.3);
        qp.row_high.fill(0.3);
        qp
    }

    /// Largest violation of the Karush-Kuhn-Tucker conditions.
    fn kkt_error(qp: &QuadraticProgram, solver: &ActiveSet) -> f64 {
        let n = qp.size();
        let mut stationarity: Vec<f64> =
            (0..n).map(|i| qp.gradient[i] + dot(&qp.hessian[i * n..][..n], &solver.z)).collect();
        let mut error = 0.0_f64;
        for b in &solver.binding {
            error = error.max(-b.multiplier);
            let (value, low, high) = if b.constraint < n {
                stationarity[b.constraint] -= b.sign * b.multiplier;
                (solver.z[b.constraint], qp.low[b.constraint], qp.high[b.constraint])
            } else {
                let i = b.constraint - n;
                let row = &qp.rows[i * n..][..n];
                axpy(&mut stationarity, -b.sign * b.multiplier, row);
                (dot(row, &solver.z), qp.row_low[i], qp.row_high[i])
            };
            error = error.max((value - if b.sign > 0.0 { low } else { high }).abs());
        }
        let violated = solver.most_violated(qp).map_or(0.0, |(_, slack)| -slack);
        stationarity.iter().fold(error.max(violated), |e, s| e.max(s.abs()))
    }

    #[test]
    fn random_programs_satisfy_the_optimality_conditions() {
        let mut seed = 7;
        let mut most_active = 0;
        for trial in 0..200 {
            let (n, rows) = (2 + trial % 20, trial % 13);
            let qp = random_program(n, rows, &mut seed);
            let mut solver = ActiveSet::new(n);
            assert_eq!(solver.solve(&qp), QpEnd::Solved, "trial {trial}");
            assert!(kkt_error(&qp, &solver) < 1e-9, "trial {trial}: {}", kkt_error(&qp, &solver));
            most_active = most_active.max(solver.active());
        }
        assert!(most_active > 8);
    }

    #[test]
    fn a_moved_program_has_the_solution_that_it_has_alone() {
        let mut seed = 11;
        let (mut released, mut bound) = (0, 0);
        for trial in 0..200 {
            let (n, rows) = (2 + trial % 20, trial % 13);
            let mut qp = random_program(n, rows, &mut seed);
            let mut solver = ActiveSet::new(n);
            // Without a solution before it a program is solved from the beginning.
            assert_eq!(solver.solve_moved(&qp), QpEnd::Solved);
            assert!(kkt_error(&qp, &solver) < 1e-9);
            let before = solver.active();
            let moved = [&mut qp.gradient, &mut qp.row_low, &mut qp.row_high, &mut qp.low, &mut qp.high];
            for number in moved.into_iter().flatten() {
                *number += 0.1 * noise(&mut seed);
            }
            let mut alone = ActiveSet::new(n);
            assert_eq!(
                (solver.solve_moved(&qp), alone.solve(&qp)),
                (QpEnd::Solved, QpEnd::Solved),
                "{trial}"
            );
            assert!(kkt_error(&qp, &solver) < 1e-8, "trial {trial}: {}", kkt_error(&qp, &solver));
            let apart =
                solver.z.iter().zip(&alone.z).fold(0.0_f64, |most, (z, other)| most.max((z - other).abs()));
            assert!(apart < 1e-8, "trial {trial}: {apart}");
            released += usize::from(solver.active() < before);
            bound += usize::from(solver.active() > before);
        }
        assert!(released > 10 && bound > 10, "{released}, {bound}");
    }

    #[test]
    fn contradicting_limits_are_infeasible() {
        let mut qp = random_program(3, 1, &mut 5);
        qp.rows.copy_from_slice(&[1.0, 1.0, 1.0]);
        (qp.row_low[0], qp.row_high[0]) = (1.6, 2.0);
        assert!(matches!(ActiveSet::new(3).solve(&qp), QpEnd::Infeasible { .. }));
        (qp.row_low[0], qp.row_high[0]) = (1.5, 2.0);
        assert_eq!(ActiveSet::new(3).solve(&qp), QpEnd::Solved);
    }

    #[test]
    fn indefinite_or_undefined_programs_are_trouble() {
        let mut qp = QuadraticProgram::new(2, 0);
        qp.hessian.copy_from_slice(&[1.0, 2.0, 2.0, 1.0]);
        assert_eq!(ActiveSet::new(2).solve(&qp), QpEnd::Trouble);
        qp.hessian.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
        qp.gradient[1] = f64::NAN;
        assert_eq!(ActiveSet::new(2).solve(&qp), QpEnd::Trouble);
    }
}
