//! The loop of the method: errors, barrier, Newton step, line search.

use super::super::nlp::{EvaluationError, Program};
use super::best::Best;
use super::filter::Filter;
use super::iterate::{Errors, Iterate, inside};
use super::kkt::Kkt;
use super::standard::Standard;
use super::status::{Iteration, Options, Solution, SolveStatus};
use super::stopwatch::Stopwatch;
use std::ops::ControlFlow;
use std::time::Duration;

/// Share by which limits are widened, so that a feasible set of one point has an inside.
const RELAXATION: f64 = 1e-10;
/// A barrier problem is solved when its error is below this times the barrier.
const BARRIER_ERROR: f64 = 10.0;
/// Steps towards a smaller barrier: a factor and a power.
const BARRIER_FACTOR: f64 = 0.2;
const BARRIER_POWER: f64 = 1.5;
/// Iterations in a row at the acceptable tolerance that end a solve.
const ACCEPTABLE_ITERATIONS: usize = 15;
/// Multipliers by least squares above this are not used.
const LARGEST_MULTIPLIER: f64 = 1e3;
/// An objective below this counts as unbounded.
const UNBOUNDED: f64 = -1e20;
/// Restarts from a feasible point at which no step was found.
const RESTARTS: usize = 3;

/// Who watches the iterations.
pub(super) type Hook<'h> = dyn FnMut(&Iteration, &Solver) -> ControlFlow<()> + 'h;

/// What a line search found.
pub(super) enum SearchStep {
    Taken,
    None,
}

/// A solve under way.
pub(super) struct Solver<'a> {
    pub standard: Standard<'a>,
    pub kkt: Kkt,
    pub options: &'a Options,
    /// Runs since the solve began.
    pub stopwatch: Stopwatch,
    pub filter: Filter,
    pub mu: f64,
    pub point: Iterate,
    pub trial: Iterate,
    /// Newton step over w and y.
    pub dw: Vec<f64>,
    pub dy: Vec<f64>,
    /// Gradient of phi, pull of the rows, gradient of the barrier Lagrangian, residuals, sigma.
    pub slope: Vec<f64>,
    pull: Vec<f64>,
    pub r: Vec<f64>,
    pub c: Vec<f64>,
    pub sigma: Vec<f64>,
    /// Infeasibility below which the objective alone may decide.
    pub theta_small: f64,
    pub count: usize,
    pub step: f64,
    /// True for the solve of a restoration.
    pub nested: bool,
    /// Restorations so far.
    pub restorations: usize,
    /// The filter alone refused the last trial point that was refused; steps
    /// in a row where it did; how often it was cleared for that.
    pub refused: bool,
    pub refusals: usize,
    pub clearings: usize,
    acceptable: usize,
    restarts: usize,
    best: Best,
}

impl<'a> Solver<'a> {
    pub fn new(program: &'a mut dyn Program, options: &'a Options, stopwatch: Stopwatch) -> Self {
        let standard = Standard::new(program, RELAXATION);
        let (n, m) = (standard.n, standard.m);
        let kkt = Kkt::new(&standard);
        let zeros = |k: usize| vec![0.0; k];
        let point = Iterate {
            w: zeros(n + m),
            y: zeros(m),
            z_low: zeros(n + m),
            z_high: zeros(n + m),
            objective: f64::NAN,
            g: zeros(m),
        };
        Self {
            standard,
            kkt,
            options,
            stopwatch,
            filter: Filter::default(),
            mu: options.barrier,
            trial: point.clone(),
            point,
            dw: zeros(n + m),
            dy: zeros(m),
            slope: zeros(n + m),
            pull: zeros(n + m),
            r: zeros(n + m),
            c: zeros(m),
            sigma: zeros(n + m),
            theta_small: 0.0,
            count: 0,
            step: 0.0,
            nested: false,
            restorations: 0,
            refused: false,
            refusals: 0,
            clearings: 0,
            acceptable: 0,
            restarts: 0,
            best: Best::default(),
        }
    }

    /// Moves `start` inside its limits, scales the program there and finds
    /// slacks and multipliers.
    pub fn begin(&mut self, start: &[f64]) -> Result<(), EvaluationError> {
        let n = self.standard.n;
        for j in 0..n {
            self.point.w[j] = if self.standard.free[j] {
                inside(start[j], self.standard.low[j], self.standard.high[j], self.options.margin)
            } else {
                self.standard.fixed[j]
            };
        }
        let mut g = std::mem::take(&mut self.point.g);
        let first = self.standard.evaluate(&self.point.w[..n], &mut g);
        self.point.g = g;
        first?;
        self.standard.scale_at(&self.point.w[..n])?;
        self.settle(self.options.margin)?;
        self.point.center_limits(&self.standard, self.mu, f64::INFINITY);
        if self.mu > 1e-2 {
            self.point.z_low.iter_mut().chain(&mut self.point.z_high).for_each(|z| *z = z.min(1.0));
            self.unit_limits();
        }
        self.fit_multipliers();
        let theta = self.point.theta(&self.standard);
        self.theta_small = 1e-4 * theta.max(1.0);
        self.filter = Filter::new(1e4 * theta.max(1.0));
        Ok(())
    }

    /// Evaluates the functions at x and puts every slack on its row's value,
    /// moved inside its limits.
    pub fn settle(&mut self, margin: f64) -> Result<(), EvaluationError> {
        let n = self.standard.n;
        self.point.objective = self.standard.evaluate(&self.point.w[..n], &mut self.point.g)?;
        for i in 0..self.standard.m {
            let k = n + i;
            self.point.w[k] = if self.standard.free[k] {
                inside(self.point.g[i], self.standard.low[k], self.standard.high[k], margin)
            } else {
                self.standard.fixed[k]
            };
        }
        Ok(())
    }

    /// Multipliers of the limits of a cold start: one.
    fn unit_limits(&mut self) {
        for k in 0..self.point.w.len() {
            self.point.z_low[k] = if self.standard.low[k].is_finite() { 1.0 } else { 0.0 };
            self.point.z_high[k] = if self.standard.high[k].is_finite() { 1.0 } else { 0.0 };
        }
    }

    /// Multipliers of the rows by least squares; zero where those are huge or the functions have no slopes.
    pub fn estimate_multipliers(&mut self) {
        self.point.y.fill(0.0);
        if self.standard.differentiate(&self.point.w[..self.standard.n], &self.point.y).is_ok() {
            self.fit_multipliers();
        }
    }

    /// The same where the slopes at the point are known, instead of multipliers of zero.
    fn fit_multipliers(&mut self) {
        if self.standard.m == 0 || !self.kkt.factorise_identity(&self.standard) {
            return;
        }
        let n = self.standard.n;
        self.r[..n].copy_from_slice(&self.standard.derivatives.gradient);
        self.r[n..].fill(0.0);
        for k in 0..self.r.len() {
            self.r[k] += self.point.z_high[k] - self.point.z_low[k];
        }
        self.c.fill(0.0);
        self.kkt.solve(&self.standard, &self.r, &self.c, &mut self.dw, &mut self.dy);
        let largest = self.dy.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
        if largest <= LARGEST_MULTIPLIER {
            self.point.y.copy_from_slice(&self.dy);
        }
    }

    /// Iterates to an end.
    pub fn run(&mut self, hook: &mut Hook) -> SolveStatus {
        loop {
            if let Err(error) = self.standard.differentiate(&self.point.w[..self.standard.n], &self.point.y) {
                return SolveStatus::NumericalTrouble { cause: error.to_string() };
            }
            let errors = self.errors(0.0);
            if !self.nested {
                self.best.see(&self.point, errors.feasibility, self.options.acceptable);
            }
            if hook(&self.line(&errors), self).is_break() {
                return SolveStatus::Stopped;
            }
            if let Some(status) = self.finished(&errors) {
                return status;
            }
            self.lower_barrier(&errors);
            let step = if self.newton_step() { self.search() } else { SearchStep::None };
            if let SearchStep::None = step
                && let Some(status) = self.without_step(&errors, hook)
            {
                return status;
            }
            self.count += 1;
        }
    }

    pub fn errors(&mut self, mu: f64) -> Errors {
        self.point.pull(&self.standard, &mut self.pull);
        self.point.errors(&self.standard, mu, &self.pull)
    }

    fn line(&self, errors: &Errors) -> Iteration {
        Iteration {
            number: self.count,
            objective: self.point.objective / self.standard.objective_scale,
            infeasibility: errors.feasibility,
            stationarity: errors.stationarity,
            barrier: self.mu,
            shift: self.kkt.shift,
            step: self.step,
            restoring: self.nested,
        }
    }

    fn finished(&mut self, errors: &Errors) -> Option<SolveStatus> {
        let options = self.options;
        let error = errors.largest();
        if error <= options.tolerance && errors.complementarity <= options.complementarity {
            return Some(SolveStatus::Solved);
        }
        self.acceptable = if error <= options.acceptable { self.acceptable + 1 } else { 0 };
        if self.acceptable >= ACCEPTABLE_ITERATIONS {
            return Some(SolveStatus::Acceptable);
        }
        if self.point.objective < UNBOUNDED && errors.feasibility <= options.acceptable {
            return Some(SolveStatus::Unbounded);
        }
        if self.count >= options.iterations {
            return Some(SolveStatus::IterationLimit);
        }
        (self.stopwatch.elapsed() >= self.options.time).then_some(SolveStatus::TimeLimit)
    }

    /// Lowers the barrier while its problem is solved well enough.
    fn lower_barrier(&mut self, errors: &Errors) {
        let least = self.options.complementarity.min(self.options.tolerance) / 10.0;
        let others = errors.stationarity.max(errors.feasibility);
        let error = |point: &Iterate, mu: f64| others.max(point.complementarity(&self.standard, mu));
        while self.mu > least && error(&self.point, self.mu) <= BARRIER_ERROR * self.mu {
            self.mu = least.max((BARRIER_FACTOR * self.mu).min(self.mu.powf(BARRIER_POWER)));
            self.filter.clear();
        }
    }

    /// The Newton step of the barrier problem at the point whose errors were found last; false when no shift of the
    /// Hessian makes it one of descent.
    fn newton_step(&mut self) -> bool {
        self.point.sigma(&self.standard, &mut self.sigma);
        if !self.kkt.factorise_convex(&self.standard, &self.sigma, self.mu) {
            return false;
        }
        self.point.phi_gradient(&self.standard, self.mu, &mut self.slope);
        for (k, free) in self.standard.free.iter().enumerate() {
            self.r[k] = if *free { self.slope[k] + self.pull[k] } else { 0.0 };
        }
        self.point.rows(&self.standard, &mut self.c);
        self.kkt.solve(&self.standard, &self.r, &self.c, &mut self.dw, &mut self.dy);
        self.dw.iter().chain(&self.dy).all(|d| d.is_finite())
    }

    /// What to do where no step was found: restore feasibility, or start anew
    /// with fresh multipliers, or end.
    fn without_step(&mut self, errors: &Errors, hook: &mut Hook) -> Option<SolveStatus> {
        let feasible = errors.feasibility <= self.options.tolerance.max(1e-8);
        if !feasible && !self.nested {
            return self.restore(hook);
        }
        if errors.largest() <= self.options.acceptable {
            return Some(SolveStatus::Acceptable);
        }
        if self.restarts >= RESTARTS {
            let cause = "no step improves the objective or the constraints".into();
            return Some(SolveStatus::NumericalTrouble { cause });
        }
        self.restarts += 1;
        self.restart();
        None
    }

    /// Forgets filter and multipliers, and keeps the point.
    pub fn restart(&mut self) {
        self.filter.clear();
        self.mu = (self.mu * 10.0).min(self.options.barrier);
        self.point.center_limits(&self.standard, self.mu, 1e3);
        self.estimate_multipliers();
    }

    /// Goes back to the best point, with the derivatives there.
    fn go_back(&mut self) {
        let rows = (0..self.standard.m).map(|i| self.point.row(&self.standard, i).abs());
        // A row that is no number stays one, and such a point is not taken.
        let missed = rows.fold(0.0_f64, |most, row| if row > most || row.is_nan() { row } else { most });
        self.best.see(&self.point, missed, self.options.acceptable);
        let Some(best) = std::mem::take(&mut self.best).take() else { return };
        self.point = best;
        // They could be taken there before, but for a point of the restoration, which was evaluated alone: where they cannot, those of the
        // last iterate stay.
        let _ = self.standard.differentiate(&self.point.w[..self.standard.n], &self.point.y);
    }

    /// Multipliers of the variables' limits, unscaled. That of a variable with one value is what stationarity asks of it.
    fn bounds(&self) -> Vec<f64> {
        let (standard, point) = (&self.standard, &self.point);
        let mut slope = standard.derivatives.gradient.clone();
        standard.add_transposed(&point.y, &mut slope);
        let of = |k: usize| if standard.free[k] { point.z_high[k] - point.z_low[k] } else { -slope[k] };
        (0..standard.n).map(|k| of(k) / standard.objective_scale).collect()
    }

    /// The result at the present point of an optimum, and at the best one of any other end.
    pub fn solution(mut self, status: SolveStatus) -> Solution {
        if !status.is_success() {
            self.go_back();
        }
        let errors = self.point.objective.is_finite().then(|| self.errors(0.0));
        let (missed, violation) = self.standard.worst_violation(&self.point.g);
        let scale = self.standard.objective_scale;
        let rows = || self.standard.row_scale.iter();
        Solution {
            status,
            objective: self.point.objective / scale,
            constraints: self.point.g.iter().zip(rows()).map(|(g, s)| g / s).collect(),
            multipliers: self.point.y.iter().zip(rows()).map(|(y, s)| y * s / scale).collect(),
            bounds: self.bounds(),
            iterations: self.count,
            error: errors.map_or(f64::INFINITY, |errors| errors.largest()),
            infeasibility: errors.map_or(f64::INFINITY, |errors| errors.feasibility),
            violation,
            missed,
            time: Duration::ZERO,
            x: self.point.w[..self.standard.n].to_vec(),
        }
    }
}
