//! The quadratic program of a step.

use super::descent::Slopes;
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use std::time::Duration;
use wingbeat_ocp::interior_point::{Options, solve};
use wingbeat_ocp::nlp::{Derivatives, EvaluationError, Program, Structure};
use wingbeat_ocp::plant::Channel;

/// A step and the multipliers of the limits.
pub struct QuadraticStep {
    /// Change of each coordinate, as a share of its range.
    pub d: Vec<f64>,
    /// Multiplier of each limit, dimensionless.
    pub multipliers: Vec<f64>,
    /// What the model of objective and limits says the merit falls by, dimensionless.
    pub gain: f64,
}

/// Equation: trim.search_step
/// `min g d + d B d/2 + w s, limits + A d <= s, s >= 0, abs(d) <= radius; B by the damped update of Broyden,
/// Fletcher, Goldfarb and Shanno`
/// Source: Nocedal & Wright 2006, Numerical Optimization, 18.3 and 18.5; Powell 1978.
/// Test: `a_step_is_where_its_conditions_say`.
///
/// min g d + d B d / 2 + weight s,  limits + A d <= s,  s >= 0,  |d| <= radius,  0 <= x + d <= 1
struct StepProblem<'a> {
    slopes: &'a Slopes,
    hessian: &'a DMatrix<f64>,
    weight: f64,
    variables: Vec<Channel>,
    constraints: Vec<Channel>,
}

/// The step from `x` with shares in 0 to 1, no longer than `radius` in any; `None` where the solver finds none.
pub fn step(
    x: &[f64],
    (limits, slopes): (&[f64], &Slopes),
    hessian: &DMatrix<f64>,
    weight: f64,
    radius: f64,
) -> Option<QuadraticStep> {
    let mut variables: Vec<Channel> =
        x.iter().map(|x| Channel::limited("step", "", "", (-radius).max(-x), radius.min(1.0 - x))).collect();
    variables.push(Channel::limited("excess", "", "", 0.0, f64::INFINITY));
    let constraints =
        limits.iter().map(|c| Channel::limited("limit", "", "", f64::NEG_INFINITY, -c)).collect();
    let mut program = StepProblem { slopes, hessian, weight, variables, constraints };
    let excess = |d: &[f64]| {
        let ahead = limits.iter().zip(&slopes.limits).map(|(c, row)| c + dot(row, d));
        ahead.fold(0.0, f64::max)
    };
    let n = x.len();
    let none = vec![0.0; n];
    let mut start = none.clone();
    start.push(excess(&none) + 0.1);
    let options = Options {
        tolerance: 1e-8,
        complementarity: 1e-9,
        iterations: 200,
        time: Duration::from_secs(10),
        ..Options::default()
    };
    let solution = solve(&mut program, &start, &options, &mut |_| ControlFlow::Continue(()));
    if !solution.status.is_success() {
        return None;
    }
    let d = solution.x[..n].to_vec();
    let v = DVector::from_column_slice(&d);
    let model = dot(&slopes.objective, &d) + 0.5 * v.dot(&(hessian * &v));
    let gain = weight * (excess(&none) - excess(&d)) - model;
    Some(QuadraticStep { d, multipliers: solution.multipliers, gain })
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Program for StepProblem<'_> {
    fn variables(&self) -> &[Channel] {
        &self.variables
    }
    fn constraints(&self) -> &[Channel] {
        &self.constraints
    }
    fn structure(&self) -> Structure {
        Structure::dense(self.variables.len(), self.constraints.len())
    }
    fn evaluate(&mut self, x: &[f64], constraints: &mut [f64]) -> Result<f64, EvaluationError> {
        let (d, excess) = (&x[..x.len() - 1], x[x.len() - 1]);
        for (value, row) in constraints.iter_mut().zip(&self.slopes.limits) {
            *value = dot(row, d) - excess;
        }
        let v = DVector::from_column_slice(d);
        Ok(dot(&self.slopes.objective, d) + 0.5 * v.dot(&(self.hessian * &v)) + self.weight * excess)
    }
    fn differentiate(
        &mut self,
        x: &[f64],
        weight: f64,
        _: &[f64],
        out: &mut Derivatives,
    ) -> Result<(), EvaluationError> {
        let n = x.len() - 1;
        let curved = self.hessian * DVector::from_column_slice(&x[..n]);
        for (i, gradient) in out.gradient[..n].iter_mut().enumerate() {
            *gradient = self.slopes.objective[i] + curved[i];
        }
        out.gradient[n] = self.weight;
        for (row, slopes) in out.jacobian.chunks_exact_mut(n + 1).zip(&self.slopes.limits) {
            row[..n].copy_from_slice(slopes);
            row[n] = -1.0;
        }
        let pairs = (0..=n).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for (value, (i, j)) in out.hessian.iter_mut().zip(pairs) {
            *value = if i < n { weight * self.hessian[(i, j)] } else { 0.0 };
        }
        Ok(())
    }
}
