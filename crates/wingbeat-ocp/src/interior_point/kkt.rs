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
/// condensed slacks of inequalities and dc for equations.
pub(super) struct Kkt {
    pattern: Pattern,
    factors: Factors,
    values: Vec<f64>,
    /// The entries of the Hessian and the Jacobian, by rows.
    entries: Vec<EntryRun>,
    /// Entries that belong to variables that are not free.
    fixed: Vec<usize>,
    /// Diagonal of the variables' part: barrier, or one where not free.
    diagonal: Vec<f64>,
    n: usize,
    m: usize,
    hessian: usize,
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
        let mut entries = structure.hessian.clone();
        let hessian = entries.len();
        entries.extend((0..n).map(|j| (j, j)));
        entries.extend(structure.jacobian.iter().map(|&(i, j)| (n + i, j)));
        entries.extend((0..m).map(|i| (n + i, n + i)));
        let mut by_rows = runs(&structure.hessian);
        by_rows.extend(runs(&structure.jacobian).into_iter().map(|run| EntryRun {
            row: n + run.row,
            entry: hessian + n + run.entry,
            ..run
        }));
        let mut blocks = structure.variable_block.clone();
        blocks.extend(&structure.constraint_block);
        let free = |k: usize| k >= n || standard.free[k];
        let fixed = entries.iter().enumerate().filter(|(_, e)| !(free(e.0) && free(e.1)));
        Self {
            pattern: Pattern::new(&blocks, &entries),
            factors: Factors::default(),
            values: vec![0.0; entries.len()],
            fixed: fixed.map(|(k, _)| k).collect(),
            entries: by_rows,
            diagonal: vec![0.0; n],
            n,
            m,
            hessian,
            last_shift: 0.0,
            shift: 0.0,
            slack: vec![0.0; m],
            residual: Vec::new(),
        }
    }

    /// Enters the derivatives and the barrier's diagonal `sigma` over w.
    /// Without a Hessian the identity takes its place.
    fn assemble(&mut self, standard: &Standard, sigma: &[f64], with_hessian: bool) {
        let (n, h) = (self.n, self.hessian);
        let derivatives = &standard.derivatives;
        if with_hessian {
            self.values[..h].copy_from_slice(&derivatives.hessian);
        } else {
            self.values[..h].fill(0.0);
        }
        let jacobian = derivatives.jacobian.len();
        self.values[h + n..h + n + jacobian].copy_from_slice(&derivatives.jacobian);
        self.fixed.iter().for_each(|&k| self.values[k] = 0.0);
        for (j, d) in self.diagonal.iter_mut().enumerate() {
            *d = if standard.free[j] && with_hessian { sigma[j] } else { 1.0 };
        }
    }

    /// Factorises with shifts `dw` and `dc`.
    fn factorise(&mut self, standard: &Standard, sigma: &[f64], dw: f64, dc: f64) -> Inertia {
        let (n, m, h) = (self.n, self.m, self.hessian);
        for j in 0..n {
            self.values[h + j] = self.diagonal[j] + if standard.free[j] { dw } else { 0.0 };
        }
        let first = self.values.len() - m;
        for i in 0..m {
            self.slack[i] = (sigma[n + i] + dw).max(SMALLEST_SLACK);
            self.values[first + i] = if standard.free[n + i] { -1.0 / self.slack[i] } else { 0.0 } - dc;
        }
        self.shift = dw;
        self.factors.factorise(&self.pattern, &self.values, PIVOT_THRESHOLD)
    }

    /// Factorises so that the step is a descent direction: `n` positive and `m`
    /// negative eigenvalues. False when no shift gives that.
    pub fn factorise_convex(&mut self, standard: &Standard, sigma: &[f64], barrier: f64) -> bool {
        self.assemble(standard, sigma, true);
        let wanted = Inertia { positive: self.n, negative: self.m, zero: 0 };
        let mut inertia = self.factorise(standard, sigma, 0.0, 0.0);
        if inertia == wanted {
            return true;
        }
        let dc = if inertia.zero > 0 { 1e-8 * barrier.powf(0.25) } else { 0.0 };
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
            dw *= if known { 8.0 } else { 100.0 };
        }
        false
    }

    /// Factorises [[I, A'], [A, -D]], for multipliers by least squares.
    pub fn factorise_identity(&mut self, standard: &Standard) -> bool {
        let ones = vec![1.0; self.n + self.m];
        self.assemble(standard, &ones, false);
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
        let solution = self.solve_refined(&rhs);
        dw[..n].copy_from_slice(&solution[..n]);
        dy.copy_from_slice(&solution[n..]);
        for i in 0..m {
            dw[n + i] = if standard.free[n + i] { (dy[i] - r[n + i]) / self.slack[i] } else { 0.0 };
        }
    }

    /// Solution with iterative refinement against the factorised matrix.
    fn solve_refined(&mut self, rhs: &[f64]) -> Vec<f64> {
        let mut x = rhs.to_vec();
        self.factors.solve(&mut x);
        let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let mut residual = std::mem::take(&mut self.residual);
        let mut best = f64::INFINITY;
        for _ in 0..5 {
            residual.clear();
            residual.extend(rhs);
            let (curvature, slack) =
                (&self.values[self.hessian..], &self.values[self.values.len() - self.m..]);
            for j in 0..self.n {
                residual[j] -= curvature[j] * x[j];
            }
            for i in 0..self.m {
                residual[self.n + i] -= slack[i] * x[self.n + i];
            }
            for run in &self.entries {
                let (values, columns) = (run.of(&self.values), run.columns());
                let product =
                    axpy_dot(&mut residual[columns.clone()], -x[run.row], values, &x[columns.clone()]);
                residual[run.row] -= product;
                if columns.contains(&run.row) {
                    residual[run.row] += values[run.row - run.column] * x[run.row];
                }
            }
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
