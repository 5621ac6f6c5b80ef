//! Restoration of feasibility: the elastic program
//! min rho sum (p + q) + zeta/2 |D (x - x_0)|^2, g(x) - p + q within its
//! limits, p, q >= 0 (Waechter & Biegler 2006, 3.3).

use super::super::nlp::{Derivatives, EvaluationError, Program, Structure};
use super::iterate::inside;
use super::solver::{Hook, Solver};
use super::status::{Iteration, Options, SolveStatus};
use crate::plant::Channel;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Weight of the violations.
const PENALTY: f64 = 1000.0;
/// Shares of the infeasibility that the first, second ... restoration may leave.
const LEFT: [f64; 4] = [0.9, 0.1, 1e-2, 1e-4];
/// Growth of the infeasibility that is allowed after a restoration.
const GROWTH: f64 = 10.0;

/// The elastic form of a program around a reference.
struct Elastic<'a> {
    program: &'a mut dyn Program,
    variables: Vec<Channel>,
    constraints: Vec<Channel>,
    reference: Vec<f64>,
    weight: Vec<f64>,
    penalty: Vec<f64>,
    inner: Derivatives,
    /// Objective of the program at the last evaluation.
    objective: &'a Cell<f64>,
}

impl<'a> Elastic<'a> {
    fn new(
        program: &'a mut dyn Program,
        reference: &[f64],
        penalty: &[f64],
        zeta: f64,
        objective: &'a Cell<f64>,
    ) -> Self {
        let constraints = program.constraints().to_vec();
        let mut variables = program.variables().to_vec();
        let inner = Derivatives::new(variables.len(), &program.structure());
        for sign in ["above", "below"] {
            let violation = |c: &Channel| {
                Channel::limited(format!("{} {sign}", c.name), c.unit, c.frame, 0.0, f64::INFINITY)
            };
            variables.extend(constraints.iter().map(violation));
        }
        let weight = reference.iter().map(|x| zeta * (1.0 / x.abs()).min(1.0).powi(2)).collect();
        Self {
            program,
            variables,
            constraints,
            reference: reference.to_vec(),
            weight,
            penalty: penalty.iter().map(|s| PENALTY * s).collect(),
            inner,
            objective,
        }
    }

    fn sizes(&self) -> (usize, usize) {
        (self.reference.len(), self.constraints.len())
    }
}

impl Program for Elastic<'_> {
    fn variables(&self) -> &[Channel] {
        &self.variables
    }
    fn constraints(&self) -> &[Channel] {
        &self.constraints
    }
    fn structure(&self) -> Structure {
        let (n, m) = self.sizes();
        let mut structure = self.program.structure();
        structure.jacobian.extend((0..m).map(|i| (i, n + i)));
        structure.jacobian.extend((0..m).map(|i| (i, n + m + i)));
        structure.hessian.extend((0..n).map(|j| (j, j)));
        for _ in 0..2 {
            structure.variable_block.extend(&structure.constraint_block);
        }
        structure
    }
    fn evaluate(&mut self, x: &[f64], g: &mut [f64]) -> Result<f64, EvaluationError> {
        let (n, m) = self.sizes();
        self.objective.set(self.program.evaluate(&x[..n], g)?);
        let mut value = 0.0;
        for i in 0..m {
            let (p, q) = (x[n + i], x[n + m + i]);
            g[i] += q - p;
            value += self.penalty[i] * (p + q);
        }
        for j in 0..n {
            value += 0.5 * self.weight[j] * (x[j] - self.reference[j]).powi(2);
        }
        Ok(value)
    }
    fn differentiate(
        &mut self,
        x: &[f64],
        weight: f64,
        multipliers: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        let (n, m) = self.sizes();
        self.program.differentiate(&x[..n], 0.0, multipliers, &mut self.inner)?;
        let (entries, second) = (self.inner.jacobian.len(), self.inner.hessian.len());
        out.jacobian[..entries].copy_from_slice(&self.inner.jacobian);
        out.jacobian[entries..entries + m].fill(-1.0);
        out.jacobian[entries + m..].fill(1.0);
        out.hessian[..second].copy_from_slice(&self.inner.hessian);
        for j in 0..n {
            out.gradient[j] = self.weight[j] * (x[j] - self.reference[j]);
            out.hessian[second + j] = weight * self.weight[j];
        }
        out.gradient[n..n + m].copy_from_slice(&self.penalty);
        out.gradient[n + m..].copy_from_slice(&self.penalty);
        Ok(())
    }
}

/// p and q that minimise the barrier of a violation c = p - q.
fn split(c: f64, penalty: f64, mu: f64) -> (f64, f64) {
    let half = (mu - penalty * c) / (2.0 * penalty);
    let q = half + (half * half + mu * c.max(0.0) / (2.0 * penalty)).sqrt();
    let q = q.max(1e-8);
    ((c + q).max(1e-8), q)
}

impl Solver<'_> {
    /// Looks for a point that the filter accepts and that is clearly less
    /// infeasible; returns the end of the solve when there is none.
    pub(super) fn restore(&mut self, hook: &mut Hook) -> Option<SolveStatus> {
        let (n, m) = (self.standard.n, self.standard.m);
        let (theta, phi) = (self.point.theta(&self.standard), self.point.phi(&self.standard, self.mu));
        self.filter.add(theta, phi);
        let worst = (0..m).fold(0.0_f64, |w, i| w.max(self.point.row(&self.standard, i).abs()));
        let options = Options {
            barrier: self.mu.max(worst).min(1e3),
            iterations: self.options.iterations.saturating_sub(self.count),
            margin: 1e-8,
            ..self.options.clone()
        };
        let mut start = self.point.w[..n].to_vec();
        let (mut above, mut below) = (vec![0.0; m], vec![0.0; m]);
        for i in 0..m {
            let (penalty, scale) = (PENALTY * self.standard.row_scale[i], self.standard.row_scale[i]);
            let c = self.point.row(&self.standard, i) / scale;
            (above[i], below[i]) = split(c, penalty, options.barrier);
        }
        start.extend(above.iter().chain(&below));
        let (status, x, used) = self.solve_elastic(&start, &options, theta, hook);
        self.count += used;
        self.point.w[..n].copy_from_slice(&x);
        if let Err(error) = self.settle(1e-8) {
            // Its functions are those of another point.
            self.point.objective = f64::NAN;
            return Some(SolveStatus::NumericalTrouble { cause: error.to_string() });
        }
        self.judge(status, theta)
    }

    /// Runs the elastic program until its point would do for the filter.
    /// Returns its end, its x and the iterations it took.
    fn solve_elastic(
        &mut self,
        start: &[f64],
        options: &Options,
        theta: f64,
        hook: &mut Hook,
    ) -> (Restored, Vec<f64>, usize) {
        let (n, m, mu) = (self.standard.n, self.standard.m, self.mu);
        let (low, high) = (self.standard.low[n..].to_vec(), self.standard.high[n..].to_vec());
        let (fixed, free) = (self.standard.fixed[n..].to_vec(), self.standard.free[n..].to_vec());
        let scales = self.standard.row_scale.clone();
        let objective = Cell::new(f64::NAN);
        let reference = self.point.w[..n].to_vec();
        let scratch = std::cell::RefCell::new(self.point.clone());
        let (count, stopwatch) = (self.count, self.stopwatch);
        let program = &mut *self.standard.program;
        let mut elastic = Elastic::new(program, &reference, &scales, mu.sqrt(), &objective);
        let left = LEFT[self.restorations.min(LEFT.len() - 1)];
        let mut inner = Solver::new(&mut elastic, options, stopwatch);
        inner.nested = true;
        let mut enough = false;
        let mut watch = |iteration: &Iteration, inner: &Solver| -> ControlFlow<()> {
            let shown = Iteration { number: count + iteration.number, ..*iteration };
            hook(&shown, inner)?;
            let w = &inner.point.w;
            let residual: f64 = (0..m)
                .map(|i| {
                    let own = inner.point.g[i] / inner.standard.row_scale[i];
                    let g = (own + w[n + i] - w[n + m + i]) * scales[i];
                    let s = if free[i] { inside(g, low[i], high[i], 1e-8) } else { fixed[i] };
                    let mut point = scratch.borrow_mut();
                    (point.g[i], point.w[n + i]) = (g, s);
                    (g - s).abs()
                })
                .sum();
            enough = residual <= left * theta && objective.get().is_finite();
            if enough { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let status = match inner.begin(start) {
            Ok(()) => inner.run(&mut watch),
            Err(error) => SolveStatus::NumericalTrouble { cause: error.to_string() },
        };
        let x = inner.point.w[..n].to_vec();
        let used = inner.count;
        let end = if enough { Restored::Enough } else { Restored::Ended(status) };
        (end, x, used)
    }

    /// Goes on from the restored point, or names what cannot be met.
    fn judge(&mut self, end: Restored, before: f64) -> Option<SolveStatus> {
        let theta = self.point.theta(&self.standard);
        match end {
            Restored::Enough => {}
            Restored::Ended(status) if status.is_success() => {
                if theta > 1e-6 * before.max(1.0) && theta > self.options.acceptable {
                    let (channel, violation) = self.standard.worst_violation(&self.point.g);
                    return Some(SolveStatus::Infeasible { channel, violation });
                }
            }
            Restored::Ended(SolveStatus::NumericalTrouble { .. }) if theta > self.options.acceptable => {
                let (channel, violation) = self.standard.worst_violation(&self.point.g);
                return Some(SolveStatus::Infeasible { channel, violation });
            }
            Restored::Ended(SolveStatus::NumericalTrouble { .. }) => {}
            Restored::Ended(status) => return Some(status),
        }
        self.restorations += 1;
        self.filter.lower_ceiling(GROWTH * before.max(self.theta_small));
        self.point.center_limits(&self.standard, self.mu, PENALTY);
        self.estimate_multipliers();
        None
    }
}

/// How a restoration ended.
enum Restored {
    /// The point improves enough.
    Enough,
    /// The elastic program ended by itself.
    Ended(SolveStatus),
}
