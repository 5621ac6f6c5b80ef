//! Which run to make next.

use crate::problem::FitProblem;
use crate::solve::SolvedCalibration;
use crate::uncertainty::inverse;
use crate::{Error, FittedParameter};

/// What a candidate would do.
#[derive(Clone, Debug)]
pub struct RunCandidate {
    /// Number among the candidates.
    pub index: usize,
    /// The parameter whose standard error is the largest part of its size now.
    pub parameter: usize,
    /// Standard errors of all parameters after the run, in the units of the parameters.
    pub errors: Vec<f64>,
}

/// The largest standard error in parts of the parameters' sizes.
pub fn largest(errors: &[f64], parameters: &[FittedParameter]) -> (usize, f64) {
    let share = errors.iter().zip(parameters).map(|(error, parameter)| error / parameter.scale().abs());
    share.enumerate().fold((0, 0.0), |most, next| if next.1 > most.1 { next } else { most })
}

/// What each run of `candidates` (the same parameters, other runs) would leave of the standard errors, with the noise of
/// the runs that were made: (J'C^-1 J + j'c^-1 j + prior)^-1, scaled as the clustered covariance is to the plain one.
/// The first is the one that leaves the least of the largest uncertainty.
///
/// Equation: calibrate.next_run
/// `(J'C^-1 J + j'c^-1 j + prior)^-1`
/// Source: Fedorov 1972.
/// Test: `a_next_run_promises_what_it_brings`.
///
/// # Errors
/// A model without an answer.
pub fn rank(solved: &SolvedCalibration, candidates: &FitProblem) -> Result<Vec<RunCandidate>, Error> {
    let parameters = solved.problem.parameters;
    let (square, _) = solved.at.normal(parameters, &solved.values, &[]);
    let now = inverse(&square);
    let clustered = solved.errors();
    let scale: Vec<f64> = clustered
        .iter()
        .enumerate()
        .map(|(k, error)| error / now[(k, k)].sqrt().max(f64::MIN_POSITIVE))
        .collect();
    let (parameter, _) = largest(&clustered, parameters);
    let of: Vec<usize> = (0..candidates.runs.len()).collect();
    let jacobians = candidates.jacobians(&of, &solved.values)?;
    let mut ranked: Vec<RunCandidate> = of
        .iter()
        .zip(&jacobians)
        .map(|(run, jacobian)| {
            let j = candidates.whiten_columns(*run, jacobian);
            let after = inverse(&(&square + j.transpose() * &j));
            let errors = (0..parameters.len()).map(|k| scale[k] * after[(k, k)].max(0.0).sqrt()).collect();
            RunCandidate { index: *run, parameter, errors }
        })
        .collect();
    wingbeat::math::order::ascend_by(&mut ranked, |item| item.errors[parameter]);
    Ok(ranked)
}
