//! The scaled program with slacks: min f(x), g(x) - s = 0, low <= (x, s) <= high.

use super::super::nlp::{Derivatives, EvaluationError, Program, Structure};
use super::runs::{EntryRun, runs};
use wingbeat_math::rows::{all_finite, axpy};

/// Gradients above this are scaled down to it (Waechter & Biegler 2006, 3.8).
const LARGEST_GRADIENT: f64 = 100.0;
/// Smallest scale factor.
const SMALLEST_SCALE: f64 = 1e-8;

/// A program in the solver's form. The unknowns w = (x, s) are `n` variables
/// and one slack per constraint; those that are fixed are not `free`.
pub(super) struct Standard<'a> {
    pub program: &'a mut dyn Program,
    pub n: usize,
    pub m: usize,
    pub structure: Structure,
    /// Limits of w; infinite where a component is not free.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub free: Vec<bool>,
    /// Values of the components that are not free.
    pub fixed: Vec<f64>,
    pub objective_scale: f64,
    pub row_scale: Vec<f64>,
    /// Scaled derivatives at the last differentiated point.
    pub derivatives: Derivatives,
    multipliers: Vec<f64>,
    /// The Jacobian's entries, by rows.
    rows: Vec<EntryRun>,
}

impl<'a> Standard<'a> {
    /// The unscaled standard form; `relaxation` widens limits by that share.
    pub fn new(program: &'a mut dyn Program, relaxation: f64) -> Self {
        let structure = program.structure();
        let (n, m) = (program.variables().len(), program.constraints().len());
        let channels: Vec<_> =
            program.variables().iter().chain(program.constraints()).map(|c| (c.low, c.high)).collect();
        let widen = |b: f64| if b.is_finite() { relaxation * b.abs().max(1.0) } else { 0.0 };
        let free: Vec<bool> = channels.iter().map(|(low, high)| low < high).collect();
        let low = channels.iter().map(|&(l, h)| if l < h { l - widen(l) } else { f64::NEG_INFINITY });
        let high = channels.iter().map(|&(l, h)| if l < h { h + widen(h) } else { f64::INFINITY });
        let derivatives = Derivatives::new(n, &structure);
        Self {
            program,
            n,
            m,
            rows: runs(&structure.jacobian),
            structure,
            low: low.collect(),
            high: high.collect(),
            free,
            fixed: channels.iter().map(|c| c.0).collect(),
            objective_scale: 1.0,
            row_scale: vec![1.0; m],
            derivatives,
            multipliers: vec![0.0; m],
        }
    }

    /// Chooses the scales from the gradients at `x` and scales the slacks'
    /// limits with them. The scaled first derivatives at `x` are then known.
    pub fn scale_at(&mut self, x: &[f64]) -> Result<(), EvaluationError> {
        let none = vec![0.0; self.m];
        self.differentiate(x, &none)?;
        let scale =
            |g: f64| if g > LARGEST_GRADIENT { (LARGEST_GRADIENT / g).max(SMALLEST_SCALE) } else { 1.0 };
        let mut steepest = 0.0_f64;
        for (g, free) in self.derivatives.gradient.iter().zip(&self.free) {
            steepest = if *free { steepest.max(g.abs()) } else { steepest };
        }
        self.objective_scale = scale(steepest);
        let mut rows = vec![0.0_f64; self.m];
        for (&(i, j), v) in self.structure.jacobian.iter().zip(&self.derivatives.jacobian) {
            if self.free[j] {
                rows[i] = rows[i].max(v.abs());
            }
        }
        for (i, row) in rows.into_iter().enumerate() {
            let (k, factor) = (self.n + i, scale(row));
            self.row_scale[i] = factor;
            self.low[k] *= factor;
            self.high[k] *= factor;
            self.fixed[k] *= factor;
        }
        self.scale_slopes();
        Ok(())
    }

    /// Scaled objective at `x`; writes the scaled constraint values.
    pub fn evaluate(&mut self, x: &[f64], g: &mut [f64]) -> Result<f64, EvaluationError> {
        let f = self.program.evaluate(x, g)?;
        for (g, scale) in g.iter_mut().zip(&self.row_scale) {
            *g *= scale;
        }
        Ok(f * self.objective_scale)
    }

    /// Scales the first derivatives.
    fn scale_slopes(&mut self) {
        let out = &mut self.derivatives;
        for g in &mut out.gradient {
            *g *= self.objective_scale;
        }
        for run in self.rows.iter().filter(|run| self.row_scale[run.row] != 1.0) {
            let scale = self.row_scale[run.row];
            out.jacobian[run.entry..run.entry + run.length].iter_mut().for_each(|v| *v *= scale);
        }
    }

    /// Scaled derivatives at `x` for the scaled multipliers `y`.
    pub fn differentiate(&mut self, x: &[f64], y: &[f64]) -> Result<(), EvaluationError> {
        for (out, (y, scale)) in self.multipliers.iter_mut().zip(y.iter().zip(&self.row_scale)) {
            *out = y * scale;
        }
        let out = &mut self.derivatives;
        self.program.differentiate(x, self.objective_scale, &self.multipliers, out)?;
        self.scale_slopes();
        let out = &self.derivatives;
        let looked = || all_finite(&out.jacobian) && all_finite(&out.hessian);
        if all_finite(&out.gradient) && self.program.derivatives_are_finite().unwrap_or_else(looked) {
            return Ok(());
        }
        Err(EvaluationError(self.culprit()))
    }

    /// Names the first derivative that is not finite.
    fn culprit(&self) -> String {
        let (variables, constraints) = (self.program.variables(), self.program.constraints());
        if let Some(j) = self.derivatives.gradient.iter().position(|g| !g.is_finite()) {
            return format!("the objective's derivative along {} is not finite", variables[j].name);
        }
        let entry = self.derivatives.jacobian.iter().position(|v| !v.is_finite());
        if let Some((i, j)) = entry.map(|k| self.structure.jacobian[k]) {
            let (row, column) = (&constraints[i].name, &variables[j].name);
            return format!("the derivative of {row} along {column} is not finite");
        }
        "a second derivative is not finite".into()
    }

    /// out += A' y over x.
    pub fn add_transposed(&self, y: &[f64], out: &mut [f64]) {
        for run in &self.rows {
            axpy(&mut out[run.columns()], y[run.row], run.of(&self.derivatives.jacobian));
        }
    }

    /// The constraint most violated by the scaled values `g`: its name and by
    /// how much, in its own unit.
    pub fn worst_violation(&self, g: &[f64]) -> (String, f64) {
        let mut worst = (String::new(), 0.0);
        let mut largest = 0.0;
        for (i, channel) in self.program.constraints().iter().enumerate() {
            let value = g[i] / self.row_scale[i];
            let violation = (channel.low - value).max(value - channel.high);
            if violation * self.row_scale[i] > largest {
                largest = violation * self.row_scale[i];
                worst = (channel.name.clone(), violation);
            }
        }
        worst
    }
}
