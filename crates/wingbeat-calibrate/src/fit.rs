//! Levenberg-Marquardt with priors and bounds, in stages, from several starts.

use crate::problem::{FitProblem, Whitened, priors};
use crate::{Error, FittedParameter};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Most steps of a fit.
const STEPS: usize = 40;
/// A step that lowers the cost by less than this share ends the fit.
const ENOUGH: f64 = 1e-7;
/// Largest damping that is tried.
const MOST_DAMPING: f64 = 1e8;
/// The same with a Jacobian that only follows.
const FOLLOWED_DAMPING: f64 = 1e-1;
/// Share of the gain that a Jacobian told which a step must bring for it to be followed on.
const FOLLOWED: f64 = 0.5;

/// Differences from where another start ended, of the cost in parts of it and of the values in parts of their sizes, by which
/// a fit has come there. *Choice.*
const JOINED: [f64; 2] = [1e-2, 2e-2];

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FitEnding {
    /// No step lowers the cost.
    Converged,
    /// The steps are used up.
    Steps,
    /// It came to where another start had ended.
    Joined,
}

/// A fit under way, for who watches.
#[derive(Clone, Debug)]
pub struct FitProgress<'a> {
    /// Which start, from 0.
    pub start: usize,
    /// Which stage, from 1.
    pub stage: usize,
    /// Steps taken.
    pub step: usize,
    /// Sum of squares of deviations, dimensionless.
    pub cost: f64,
    /// Values, in the units of the parameters.
    pub values: &'a [f64],
}

/// Who watches; may stop the fit.
pub type FitWatch<'a> = dyn FnMut(&FitProgress) -> ControlFlow<()> + 'a;

/// Where a fit ended.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fit {
    /// Values of all parameters, in their own units.
    pub values: Vec<f64>,
    /// Sum of squares of deviations there, dimensionless.
    pub cost: f64,
    /// How it ended.
    pub ended: FitEnding,
    /// Steps taken.
    pub steps: usize,
}

/// Keeps fits that are done, so that who was interrupted need not make them again.
pub trait Keep {
    /// The fit from start `number`, if it is done.
    fn kept(&self, number: usize) -> Option<Fit>;
    /// Keeps it.
    fn keep(&mut self, number: usize, fit: &Fit);
}

/// Keeps nothing.
impl Keep for () {
    fn kept(&self, _: usize) -> Option<Fit> {
        None
    }
    fn keep(&mut self, _: usize, _: &Fit) {}
}

/// Residuals and Jacobian of several runs, in deviations, at some values.
#[derive(Clone, Debug)]
pub struct LinearisedRuns {
    /// The runs.
    pub of: Vec<usize>,
    /// Model less measurement.
    pub residuals: Whitened,
    /// Derivatives: deviations over the units of the parameters.
    pub jacobians: Vec<DMatrix<f64>>,
}

impl LinearisedRuns {
    /// Of the runs `of` at `values`, in the units of the parameters.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn at(problem: &FitProblem, of: &[usize], values: &[f64]) -> Result<Self, Error> {
        let residuals = problem.residuals(of, &problem.predictions(of, values)?);
        let plain = problem.jacobians(of, values)?;
        let jacobians = of.iter().zip(&plain).map(|(run, j)| problem.whiten_columns(*run, j)).collect();
        Ok(Self { of: of.to_vec(), residuals, jacobians })
    }

    /// By how much the step between the values would lower the cost, were the model linear.
    fn gain(&self, parameters: &[FittedParameter], (from, to): (&[f64], &[f64]), cost: f64) -> f64 {
        let moved = DVector::from_fn(from.len(), |k, _| to[k] - from[k]);
        let then: f64 =
            self.residuals.iter().zip(&self.jacobians).map(|(r, j)| (r + j * &moved).norm_squared()).sum();
        cost - then - priors(parameters, to)
    }

    /// Moves to other values where the residuals are known; the Jacobian follows by the least change that explains them, the
    /// parameters in parts of their sizes (Broyden 1965).
    fn follow(&mut self, parameters: &[FittedParameter], (from, to): (&[f64], &[f64]), residuals: Whitened) {
        let moved = DVector::from_fn(from.len(), |k, _| to[k] - from[k]);
        let weighed = DVector::from_fn(from.len(), |k, _| moved[k] / parameters[k].scale().powi(2));
        let size = moved.dot(&weighed).max(f64::MIN_POSITIVE);
        for ((j, before), after) in self.jacobians.iter_mut().zip(&self.residuals).zip(&residuals) {
            let unexplained = after - before - &*j * &moved;
            *j += unexplained * weighed.transpose() / size;
        }
        self.residuals = residuals;
    }

    /// J'J and J'r with the priors at `values`, over the units of the parameters, without the runs of `leave`.
    pub fn normal(
        &self,
        parameters: &[FittedParameter],
        values: &[f64],
        leave: &[usize],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let n = parameters.len();
        let (mut square, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for ((run, j), r) in self.of.iter().zip(&self.jacobians).zip(&self.residuals) {
            if !leave.contains(run) {
                square += j.transpose() * j;
                gradient += j.transpose() * r;
            }
        }
        for (k, (parameter, value)) in parameters.iter().zip(values).enumerate() {
            if let Some([mean, deviation]) = parameter.prior {
                square[(k, k)] += deviation.powi(-2);
                gradient[k] += (value - mean) / deviation.powi(2);
            }
        }
        (square, gradient)
    }
}

/// The step, in the units of the parameters, -(A + damping diag A)^-1 g of the parameters in `free`, cut to the bounds. Those
/// that would leave theirs stay there, and the others are solved again.
pub fn step(
    (square, gradient): &(DMatrix<f64>, DVector<f64>),
    damping: f64,
    parameters: &[FittedParameter],
    values: &[f64],
    free: &[usize],
) -> Vec<f64> {
    let mut free = free.to_vec();
    let mut next = values.to_vec();
    loop {
        let n = free.len();
        if n == 0 {
            return next;
        }
        let a = DMatrix::from_fn(n, n, |i, j| {
            let own = square[(free[i], free[j])];
            if i == j { own * (1.0 + damping) + f64::MIN_POSITIVE } else { own }
        });
        // Bound parameters have moved already: what they changed of the gradient counts.
        let g = DVector::from_fn(n, |i, _| {
            let moved: f64 = (0..parameters.len())
                .filter(|k| !free.contains(k))
                .map(|k| square[(free[i], k)] * (next[k] - values[k]))
                .sum();
            gradient[free[i]] + moved
        });
        let Some(solved) = scaled_solve(&a, &g) else { return next };
        let wanted = |i: usize| values[free[i]] - solved[i];
        let inside = |i: &usize| {
            let FittedParameter { low, high, .. } = parameters[free[*i]];
            (low..=high).contains(&wanted(*i))
        };
        let (within, beyond): (Vec<usize>, Vec<usize>) = (0..n).partition(inside);
        if beyond.is_empty() {
            within.iter().for_each(|i| next[free[*i]] = wanted(*i));
            return next;
        }
        for i in beyond {
            let FittedParameter { low, high, .. } = parameters[free[i]];
            next[free[i]] = wanted(i).clamp(low, high);
        }
        free = within.into_iter().map(|i| free[i]).collect();
    }
}

/// A^-1 g, in the units of these, of a positive semidefinite matrix, scaled to a unit diagonal; small singular values count as
/// none.
pub fn scaled_solve(a: &DMatrix<f64>, g: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = DVector::from_fn(a.nrows(), |i, _| a[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * scale[i] * scale[j]);
    let eigen = scaled.symmetric_eigen();
    let rotated = eigen.eigenvectors.transpose() * g.component_mul(&scale);
    let solved = DVector::from_fn(a.nrows(), |i, _| {
        let value = eigen.eigenvalues[i];
        if value > 1e-13 { rotated[i] / value } else { 0.0 }
    });
    let back = (eigen.eigenvectors * solved).component_mul(&scale);
    back.iter().all(|x| x.is_finite()).then_some(back)
}

/// Fits from `start` (values in the units of the parameters), first the parameters of stage 1, then those of stages 1 and 2,
/// and so on. Where wings are still in some of the runs, all stages but the last are fitted to those alone. A fit that comes to
/// where `known` ended ends there.
///
/// # Errors
/// A model without an answer at the start; [`Error::Stopped`].
pub fn fit(
    problem: &FitProblem,
    start: &[f64],
    number: usize,
    known: Option<&Fit>,
    watch: &mut FitWatch,
) -> Result<Fit, Error> {
    let parameters = problem.parameters;
    let mut stages: Vec<usize> = parameters.iter().map(|parameter| parameter.stage).collect();
    stages.sort_unstable();
    stages.dedup();
    let of = problem.fitted();
    let is_still = |run: &usize| problem.model.target(*run).is_some_and(|target| target.tilts().is_some());
    let still: Vec<usize> = of.iter().copied().filter(is_still).collect();
    let last = stages.last().copied();
    let mut values = start.to_vec();
    let mut ended = None;
    for stage in stages {
        let of = if Some(stage) == last || still.is_empty() { &of } else { &still };
        let free: Vec<usize> = (0..parameters.len()).filter(|k| parameters[*k].stage <= stage).collect();
        let known = known.filter(|_| Some(stage) == last);
        let fit = fit_free(problem, of, (&values, known), &free, (number, stage), watch)?;
        values.clone_from(&fit.values);
        ended = Some(fit);
    }
    ended.ok_or_else(|| Error::Uninformed("parameters: none is fitted".into()))
}

fn fit_free(
    problem: &FitProblem,
    of: &[usize],
    (start, known): (&[f64], Option<&Fit>),
    free: &[usize],
    (number, stage): (usize, usize),
    watch: &mut FitWatch,
) -> Result<Fit, Error> {
    let mut values = start.to_vec();
    let mut now = LinearisedRuns::at(problem, of, &values)?;
    // Whether the Jacobian is that of the values; in between it follows by Broyden's updates.
    let mut exact = true;
    let mut cost = problem.cost(&now.residuals, &values);
    let mut damping = 1e-3;
    for taken in 0..STEPS {
        let progress = FitProgress { start: number, stage, step: taken, cost, values: &values };
        if watch(&progress).is_break() {
            return Err(Error::Stopped);
        }
        if let Some(known) = known.filter(|known| joined(problem.parameters, (&values, cost), known)) {
            return Ok(Fit { ended: FitEnding::Joined, steps: taken, ..known.clone() });
        }
        let normal = now.normal(problem.parameters, &values, &[]);
        let most = if exact { MOST_DAMPING } else { FOLLOWED_DAMPING };
        let better = loop {
            let next = step(&normal, damping, problem.parameters, &values, free);
            // Where the model has no answer the step was too long.
            let tried = problem.possible(of, &next).ok().map(|predictions| {
                let residuals = problem.residuals(of, &predictions);
                (problem.cost(&residuals, &next), residuals)
            });
            match tried.filter(|(tried, _)| *tried < cost) {
                Some((lower, residuals)) => break Some((next, lower, residuals)),
                None if damping > most => break None,
                None => damping *= 8.0,
            }
        };
        let converged = Fit { values: values.clone(), cost, ended: FitEnding::Converged, steps: taken };
        let Some((next, lower, residuals)) = better else {
            if exact {
                return Ok(converged);
            }
            (now, exact, damping) = (LinearisedRuns::at(problem, of, &values)?, true, 1e-3);
            continue;
        };
        let gained = (cost - lower) / cost.max(f64::MIN_POSITIVE);
        if gained < ENOUGH && exact {
            return Ok(Fit { values: next, cost: lower, steps: taken + 1, ..converged });
        }
        damping = (damping * 0.1).max(1e-9);
        // A Jacobian that told the gain well is followed, one that did not, or that gains no more, is taken anew.
        let told = now.gain(problem.parameters, (&values, &next), cost);
        exact = gained < ENOUGH || (cost - lower) < FOLLOWED * told;
        if exact {
            now = LinearisedRuns::at(problem, of, &next)?;
        } else {
            now.follow(problem.parameters, (&values, &next), residuals);
        }
        (values, cost) = (next, lower);
    }
    Ok(Fit { values, cost, ended: FitEnding::Steps, steps: STEPS })
}

/// Whether a fit at these values and this cost has come to where `known` ended.
fn joined(parameters: &[FittedParameter], (values, cost): (&[f64], f64), known: &Fit) -> bool {
    let near = |(k, value): (usize, &f64)| {
        (value - known.values[k]).abs() <= JOINED[1] * parameters[k].scale().abs()
    };
    (cost - known.cost).abs() <= JOINED[0] * known.cost && values.iter().enumerate().all(near)
}
