//! The Newton system of the barrier problem and its inertia correction.

use super::runs::{EntryRun, runs};
use super::standard::Standard;
use wingbeat_math::multifrontal::{Factors, Inertia, Pattern};
use wingbeat_math::rows::axpy_dot;

/// Stability threshold of the pivots.
const PIVOT_THRESHOLD: f64 = 1e-6;
/// First, smallest and largest shift of the Hessian's diagonal
/// (Waechter & Biegler 2006, algorithm IC).
const FIRST_SHIFT: f64 = 1e-4;
const SMALLEST_SHIFT: f64 = 1e-20;
const LARGEST_SHIFT: f64 = 1e20;
/// Residual of the Newton system, relative, that needs no refinement.
const RESIDUAL: f64 = 1e-11;
/// Curvature given to a slack that nothing holds.
const SMALLEST_SLACK: f64 = 1e-12;

/// The matrix [[H + Sigma_x + dw, A'], [A, -D]] over (dx, dy), with D the
/// condensed slacks of inequalities and dc for equations, without the
/// variables that are not free. H and A are the derivatives of the program.
pub(super) struct Kkt {
    /// Its parts: Hessian, diagonal of the variables, Jacobian, diagonal of the rows.
    pattern: Pattern,
    factors: Factors,
    /// The entries of the Hessian and of the Jacobian, by rows.
    hessian: Vec<EntryRun>,
    jacobian: Vec<EntryRun>,
    /// Variables that are not free.
    held: Vec<usize>,
    /// Diagonals in use: Sigma_x + dw, and -D.
    diagonal: Vec<f64>,
    rows: Vec<f64>,
    /// For each block the rows that it or an earlier one meets: with the inertia that is wanted, as many eigenvalues at most are
    /// negative after it. The rows after it are untouched so far, so that on their multipliers the rest of the matrix is not
    /// positive, and it has as many negative eigenvalues or more.
    most: Vec<usize>,
    n: usize,
    m: usize,
    /// The identity takes the place of the Hessian.
    identity: bool,
    last_shift: f64,
    /// Shift in use.
    pub shift: f64,
    /// Diagonal of the slacks' part in use: Sigma_s + dw.
    slack: Vec<f64>,
    residual: Vec<f64>,
}

impl Kkt {
    pub fn new(standard: &Standard) -> Self {
        let (n, m) = (standard.n, standard.m);
        let structure = &standard.structure;
        let jacobian: Vec<_> = structure.jacobian.iter().map(|&(i, j)| (n + i, j)).collect();
        let diagonal: Vec<_> = (0..n + m).map(|j| (j, j)).collect();
        let held: Vec<usize> = (0..n).filter(|&j| !standard.free[j]).collect();
        let mut blocks = structure.variable_block.clone();
        held.iter().for_each(|&j| blocks[j] = Pattern::LEFT_OUT);
        blocks.extend(&structure.constraint_block);
        let parts = [&structure.hessian, &diagonal[..n], &jacobian, &diagonal[n..]];
        let mut first = structure.constraint_block.clone();
        for &(i, j) in structure.jacobian.iter().filter(|(_, j)| standard.free[*j]) {
            first[i] = first[i].min(structure.variable_block[j]);
        }
        let count = structure.variable_block.iter().chain(&first).max().map_or(0, |last| last + 1);
        let mut most = vec![0; count];
        first.iter().for_each(|block| most[*block] += 1);
        for b in 1..count {
            most[b] += most[b - 1];
        }
        // Of variables that are held no changes follow.
        let free = |mut runs: Vec<EntryRun>| {
            runs.retain(|run| {
                run.length > 1 || [run.row, run.column].iter().all(|k| *k >= n || standard.free[*k])
            });
            runs
        };
        Self {
            most,
            pattern: Pattern::new(&blocks, &parts),
            factors: Factors::default(),
            hessian: free(runs(&structure.hessian)),
            jacobian: free(runs(&jacobian)),
            held,
            diagonal: vec![0.0; n],
            rows: vec![0.0; m],
            n,
            m,
            identity: false,
            last_shift: 0.0,
            shift: 0.0,
            slack: vec![0.0; m],
            residual: Vec::new(),
        }
    }

    /// Factorises with shifts `dw` and `dc` and the barrier's diagonal `sigma` over w.
    fn factorise(&mut self, standard: &Standard, sigma: &[f64], dw: f64, dc: f64) -> Inertia {
        let (n, m) = (self.n, self.m);
        for j in 0..n {
            self.diagonal[j] = sigma[j] + dw;
        }
        for i in 0..m {
            self.slack[i] = (sigma[n + i] + dw).max(SMALLEST_SLACK);
            self.rows[i] = if standard.free[n + i] { -1.0 / self.slack[i] } else { 0.0 } - dc;
        }
        self.shift = dw;
        let parts = [self.curvatures(standard), &self.diagonal, &standard.derivatives.jacobian, &self.rows];
        let most = if self.identity { &[][..] } else { &self.most };
        self.factors.factorise(&self.pattern, &parts, PIVOT_THRESHOLD, most)
    }

    /// The Hessian, or nothing where the identity takes its place.
    fn curvatures<'s>(&self, standard: &'s Standard) -> &'s [f64] {
        if self.identity { &[] } else { &standard.derivatives.hessian }
    }

    /// Factorises so that the step is a descent direction: as many positive
    /// eigenvalues as free variables and `m` negative ones. False when no shift gives that.
    pub fn factorise_convex(&mut self, standard: &Standard, sigma: &[f64], barrier: f64) -> bool {
        self.identity = false;
        let wanted = Inertia { positive: self.n - self.held.len(), negative: self.m, zero: 0 };
        let mut inertia = self.factorise(standard, sigma, 0.0, 0.0);
        if inertia == wanted {
            return true;
        }
        let singular = 1e-8 * barrier.powf(0.25);
        let mut dc = if inertia.zero > 0 { singular } else { 0.0 };
        if dc > 0.0 {
            inertia = self.factorise(standard, sigma, 0.0, dc);
            if inertia == wanted {
                return true;
            }
        }
        let known = self.last_shift > 0.0;
        let mut dw = if known { (self.last_shift / 3.0).max(SMALLEST_SHIFT) } else { FIRST_SHIFT };
        while dw < LARGEST_SHIFT {
            inertia = self.factorise(standard, sigma, dw, dc);
            if inertia == wanted {
                self.last_shift = dw;
                return true;
            }
            if inertia.zero > 0 && dc == 0.0 {
                dc = singular;
                continue;
            }
            dw *= if known { 8.0 } else { 100.0 };
        }
        false
    }

    /// Factorises [[I, A'], [A, -D]], for multipliers by least squares.
    pub fn factorise_identity(&mut self, standard: &Standard) -> bool {
        let ones = vec![1.0; self.n + self.m];
        self.identity = true;
        let inertia = self.factorise(standard, &ones, 0.0, 0.0);
        inertia.zero == 0
    }

    /// Solves for (dw, dy) given r over w and c over rows:
    /// (H + Sigma) dx + A' dy = -r_x, Sigma_s ds - dy = -r_s, A dx - ds = -c.
    pub fn solve(&mut self, standard: &Standard, r: &[f64], c: &[f64], dw: &mut [f64], dy: &mut [f64]) {
        let (n, m) = (self.n, self.m);
        let mut rhs = vec![0.0; n + m];
        for j in 0..n {
            rhs[j] = if standard.free[j] { -r[j] } else { 0.0 };
        }
        for i in 0..m {
            rhs[n + i] = -c[i] - if standard.free[n + i] { r[n + i] / self.slack[i] } else { 0.0 };
        }
        let solution = self.solve_refined(standard, &rhs);
        dw[..n].copy_from_slice(&solution[..n]);
        dy.copy_from_slice(&solution[n..]);
        for i in 0..m {
            dw[n + i] = if standard.free[n + i] { (dy[i] - r[n + i]) / self.slack[i] } else { 0.0 };
        }
    }

    /// Solution with iterative refinement against the factorised matrix.
    fn solve_refined(&mut self, standard: &Standard, rhs: &[f64]) -> Vec<f64> {
        let mut x = rhs.to_vec();
        self.factors.solve(&mut x);
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut residual = std::mem::take(&mut self.residual);
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            residual.clear();
            residual.extend(rhs);
            for (j, d) in self.diagonal.iter().chain(&self.rows).enumerate() {
                residual[j] -= d * x[j];
            }
            if !self.identity {
                subtract(&self.hessian, &standard.derivatives.hessian, &x, &mut residual);
            }
            subtract(&self.jacobian, &standard.derivatives.jacobian, &x, &mut residual);
            self.held.iter().for_each(|&j| residual[j] = 0.0);
            let error = size(&residual);
            if error <= RESIDUAL * (size(rhs) + size(&x).min(1e6)) || !(error < 0.5 * best) {
                break;
            }
            best = error;
            self.factors.solve(&mut residual);
            for (x, d) in x.iter_mut().zip(&residual) {
                *x += d;
            }
        }
        self.residual = residual;
        x
    }
}

/// out -= M x, of the symmetric matrix whose entries on one side of the diagonal are `runs` of `values`.
fn subtract(runs: &[EntryRun], values: &[f64], x: &[f64], out: &mut [f64]) {
    for &EntryRun { row, column, entry, length } in runs {
        let own = x[row];
        if length == 1 {
            out[column] -= values[entry] * own;
            if column != row {
                out[row] -= values[entry] * x[column];
            }
            continue;
        }
        let values = &values[entry..][..length];
        let product = axpy_dot(&mut out[column..][..length], -own, values, &x[column..][..length]);
        out[row] -= product;
        if let Some(value) = values.get(row.wrapping_sub(column)) {
            out[row] += value * own;
        }
    }
}
