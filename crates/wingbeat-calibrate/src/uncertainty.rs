//! How well a fit knows its parameters.

use crate::fit::{LinearisedRuns, scaled_solve, step};
use crate::problem::FitProblem;
use crate::{Error, FittedParameter, HarmonicLayout};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use wingbeat::parallel;

/// Two-sided 95 % of the normal distribution, as a number of standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// 95 % of chi squared with one degree of freedom.
const CHI_95: f64 = 3.841_458_820_694_124;
/// Points of a profile on each side.
const SIDE: usize = 3;
/// Most steps of the other parameters at every point of a profile.
const INNER: usize = 2;
/// Share of the rise of the cost that the linear model may miss for one step to be enough. *Choice.*
const TOLD: f64 = 0.05;

/// Covariances of the estimates.
#[derive(Clone, Debug)]
pub struct Covariances {
    /// In the units of the parameters, squared: cycles as clusters (sandwich), with what the model cannot say and what priors
    /// leave open.
    pub clustered: DMatrix<f64>,
    /// That part of it which is of what the model cannot say, in the units of the parameters, squared.
    pub unsaid: DMatrix<f64>,
    /// As if every sample were independent of the one before, in the units of the parameters, squared.
    pub white: DMatrix<f64>,
    /// Cycles beyond their means of which the noise was told, those of the runs of which the fewest tell it.
    pub freedom: f64,
    /// Singular values of the Jacobian with every parameter in parts of its size, largest first.
    pub singular_values: Vec<f64>,
    /// Directions of the parameters, in parts of their sizes, of those singular values.
    pub directions: Vec<Vec<f64>>,
}

/// Inverse of a positive semidefinite matrix, in the units of the parameters or over them, by eigenvalues of its form with a
/// unit diagonal; directions that it does not know stay out.
pub fn inverse(a: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let columns: Vec<DVector<f64>> = (0..n)
        .map(|k| {
            let unit = DVector::from_fn(n, |i, _| f64::from(u8::from(i == k)));
            scaled_solve(a, &unit).unwrap_or_else(|| DVector::zeros(n))
        })
        .collect();
    DMatrix::from_columns(&columns)
}

/// Two-sided 95 % of Student's distribution, as a number of standard deviations, by its expansion about the normal one: within
/// 2e-3 from 6 degrees of freedom on.
///
/// Equation: calibrate.student
/// `z + (z^3 + z)/(4 v) + (5 z^5 + 16 z^3 + 3 z)/(96 v^2) + (3 z^7 + 19 z^5 + 17 z^3 - 15 z)/(384 v^3)`
/// Source: Abramowitz & Stegun 1964, 26.7.5.
/// Test: `student_s_quantiles`.
pub fn student_95(freedom: f64) -> f64 {
    let z = NORMAL_95;
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
    ];
    z + terms.iter().zip(1..).map(|(term, power)| term / freedom.powi(power)).sum::<f64>()
}

/// By how much the variance of estimates is larger than what is stated of it where the weights are the inverse of a covariance that the
/// same few cycles told, with `freedom` v of them beyond their means: v/(v - m) (v - 1)/(v - 1 - m), m the `spare` numbers, those of a
/// cycle less the parameters that they tell.
///
/// With y = J x of covariance C/n, S independent of y and v S Wishart of freedom v and mean v C, the estimates (J'S^-1 J)^-1 J'S^-1 y have the
/// variance (v - 1)/(v - 1 - m) (J'C^-1 J)^-1/n: the weights are wrong. The covariance stated, (J'S^-1 J)^-1/n, has the mean
/// (v - m)/v (J'C^-1 J)^-1/n: an inverse is smaller than that of its mean where S is larger (Rao 1967, "Least squares theory using an
/// estimated dispersion matrix"; for every form of covariance to first order, 1 + 2 m/v, Kenward & Roger 1997). Harmonics are independent, so
/// that each is such a y by itself, of the channels. Where what the model cannot say outweighs the noise, the weights hardly depend
/// on S and this is too large: it is of the noise alone, which then hardly counts.
///
/// Equation: calibrate.estimated_weights
/// `v/(v - m) (v - 1)/(v - 1 - m), v cycles beyond the means, m channels less the parameters a part of a cycle
/// tells`
/// Source: Rao 1967; for all covariances to first order Kenward & Roger 1997.
/// Test: `standard_errors_of_three_passes_are_those_of_many_seeds`.
fn estimated_weights(freedom: f64, spare: f64) -> f64 {
    if freedom.is_infinite() {
        return 1.0;
    }
    let spare = spare.max(0.0);
    // `scatter` asks for so many cycles that none of this is below zero.
    let least = |x: f64| x.max(0.5);
    freedom / least(freedom - spare) * (freedom - 1.0) / least(freedom - 1.0 - spare)
}

/// Covariances of the estimates at the linearisation `at`: B^-1 (sum over cycles of g g' + J'C^-1 T C^-1 J) B^-1 with
/// B = J'C^-1 J + prior, g = J'C^-1 (cycle - mean)/n sqrt(n/(n - m)) for n cycles about m means, and T the covariance of what the tares
/// put into the mean, each harmonic of both made larger as its weights were estimated (`estimated_weights`). What the model cannot say
/// counts as common to all runs.
///
/// Equation: calibrate.cluster_covariance
/// `B^-1 (sum over cycles g g' + J'C^-1 T C^-1 J) B^-1, B = J'C^-1 J + prior`
/// Source: Liang & Zeger 1986.
/// Test: `clustered_errors_are_those_of_many_fits`.
pub fn covariances(problem: &FitProblem, at: &LinearisedRuns, values: &[f64]) -> Covariances {
    let parameters = problem.parameters;
    let n = parameters.len();
    let (square, _) = at.normal(parameters, values, &[]);
    let bread = inverse(&square);
    let (mut clustered, mut white) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let parts: usize = at.of.iter().map(|run| problem.runs[*run].layout.width()).sum();
    let told = n as f64 / parts.max(1) as f64;
    for ((run, j), _) in at.of.iter().zip(&at.jacobians).zip(&at.residuals) {
        let observed = &problem.runs[*run];
        let layout = observed.layout;
        let total: f64 = observed.weights.iter().sum();
        let count = observed.cycles.len() as f64;
        let correction = (count / observed.freedom().max(1.0)).sqrt();
        let spare = (layout.channels - observed.unmeasured.len()) as f64 - told;
        let larger = |part: usize| {
            // Cosines and sines tell of one harmonic.
            let of_harmonic = if part == 0 { 1.0 } else { 2.0 };
            estimated_weights(of_harmonic * problem.freedom[*run], spare).sqrt()
        };
        let larger: Vec<f64> = (0..layout.width()).map(larger).collect();
        for (apart, weight) in observed.deviations().iter().zip(&observed.weights) {
            let apart: Vec<f64> =
                apart.iter().enumerate().map(|(i, x)| x * larger[i % layout.width()]).collect();
            let g = j.transpose() * problem.whiten(*run, &apart) * (weight / total * correction);
            clustered += &g * g.transpose();
        }
        if let Some(common) = &observed.common.mean {
            let columns = common.column_iter().map(|column| problem.whiten(*run, column.as_slice()));
            let once = DMatrix::from_columns(&columns.collect::<Vec<_>>());
            let columns =
                once.row_iter().map(|row| problem.whiten(*run, &row.iter().copied().collect::<Vec<_>>()));
            let twice = DMatrix::from_columns(&columns.collect::<Vec<_>>());
            clustered += j.transpose() * twice * j * estimated_weights(observed.common.tare_freedom, spare);
        }
        // One cycle does not scatter: its noise is what is known of it.
        if observed.freedom() < 1.0 {
            for part in 0..layout.width() {
                let noise = problem.noise[*run][HarmonicLayout::harmonic(part)].clone();
                for column in noise
                    .cholesky()
                    .iter()
                    .flat_map(|of| of.l().column_iter().map(|c| c.into_owned()).collect::<Vec<_>>())
                {
                    let mut unit = vec![0.0; layout.len()];
                    (0..layout.channels).for_each(|c| unit[layout.at(c, part)] = column[c] * larger[part]);
                    let g = j.transpose() * problem.whiten(*run, &unit);
                    clustered += &g * g.transpose();
                }
            }
        }
        // Independent samples: variance s/N of a mean, 2 s/N of a harmonic, over all cycles.
        let noise = &observed.sample_noise;
        // Channels without noise, and those that are not measured, have no factor.
        let noisy: Vec<usize> = (0..layout.channels).filter(|c| noise[(*c, *c)] > 0.0).collect();
        if let Some(factor) = noise.select_rows(&noisy).select_columns(&noisy).cholesky() {
            let samples = observed.samples_per_cycle * count;
            for part in 0..layout.width() {
                let variance = HarmonicLayout::share(part).recip() / samples;
                for column in factor.l().column_iter() {
                    let mut unit = vec![0.0; layout.len()];
                    let of = noisy.iter().zip(column.iter());
                    of.for_each(|(c, x)| unit[layout.at(*c, part)] = x * variance.sqrt());
                    let g = j.transpose() * problem.whiten(*run, &unit);
                    white += &g * g.transpose();
                }
            }
        }
    }
    let priors = DMatrix::from_fn(n, n, |i, k| match (i == k, parameters[i].prior) {
        (true, Some([_, deviation])) => deviation.powi(-2),
        _ => 0.0,
    });
    let unsaid = &bread * unsaid(problem, at, n) * &bread;
    let scaled: Vec<DMatrix<f64>> = at.jacobians.iter().map(|j| scaled_by_size(j, parameters)).collect();
    let (singular_values, directions) = singular(&scaled, n);
    Covariances {
        clustered: &bread * (clustered + priors) * &bread + &unsaid,
        unsaid,
        white: &bread * white * &bread,
        freedom: at.of.iter().map(|run| problem.freedom[*run]).fold(f64::INFINITY, f64::min),
        singular_values,
        directions,
    }
}

/// What the discrepancy does to the gradient, the same error in all runs of one layout: per channel and part one vector summed over runs.
fn unsaid(problem: &FitProblem, at: &LinearisedRuns, n: usize) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(n, n);
    let mut layouts: Vec<HarmonicLayout> = at.of.iter().map(|run| problem.runs[*run].layout).collect();
    layouts.dedup();
    for (number, layout) in layouts.iter().enumerate() {
        if layouts[..number].contains(layout) {
            continue;
        }
        for channel in 0..layout.channels {
            let share = problem.discrepancy.get(channel).copied().unwrap_or(0.0);
            if share == 0.0 {
                continue;
            }
            for part in 0..layout.width() {
                let mut g = DVector::zeros(n);
                for (run, j) in at.of.iter().zip(&at.jacobians) {
                    if problem.runs[*run].layout != *layout {
                        continue;
                    }
                    let squares = problem.amplitudes(*run);
                    let mut unit = vec![0.0; layout.len()];
                    unit[layout.at(channel, part)] =
                        share * squares[channel][HarmonicLayout::harmonic(part)].sqrt();
                    g += j.transpose() * problem.whiten(*run, &unit);
                }
                sum += &g * g.transpose();
            }
        }
    }
    sum
}

fn scaled_by_size(jacobian: &DMatrix<f64>, parameters: &[FittedParameter]) -> DMatrix<f64> {
    DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, k| jacobian[(i, k)] * parameters[k].scale())
}

/// Singular values, largest first, with their right vectors, of matrices one above another.
fn singular(blocks: &[DMatrix<f64>], n: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let square = blocks.iter().fold(DMatrix::zeros(n, n), |sum, block| sum + block.transpose() * block);
    let eigen = square.symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    wingbeat::math::order::descend_by(&mut order, |item| eigen.eigenvalues[*item]);
    let values = order.iter().map(|k| eigen.eigenvalues[*k].max(0.0).sqrt()).collect();
    let directions = order.iter().map(|k| eigen.eigenvectors.column(*k).iter().copied().collect()).collect();
    (values, directions)
}

/// Correlations of a covariance.
pub fn correlations(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        if scale > 0.0 { covariance[(i, j)] / scale } else { f64::from(u8::from(i == j)) }
    })
}

/// What a profile says of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Label {
    /// The cost rises beyond its 95 % on both sides.
    Identified,
    /// It does on one side only.
    OneSided,
    /// It does on neither.
    Flat,
}

impl Label {
    /// The label in words.
    pub fn word(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::OneSided => "one-sided",
            Self::Flat => "flat",
        }
    }
}

/// The cost along one parameter, the others fitted again.
#[derive(Clone, Debug)]
pub struct Profile {
    /// Values of the parameter, ascending, in its unit.
    pub values: Vec<f64>,
    /// Cost above the least, dimensionless, in the scale in which 3.84 is its 95 %.
    pub cost: Vec<f64>,
    /// What it says.
    pub label: Label,
    /// Ends of the 95 % interval where the cost passes 3.84, in the unit of the parameter; none where it does not.
    pub interval: [Option<f64>; 2],
}

/// Profiles of all parameters about `values`, in the units of the parameters. The others take Gauss-Newton steps on the
/// Jacobian at the fit and the model's own residuals. `errors` are the standard errors; the cost is measured in the scale that
/// makes its curvature theirs.
///
/// # Errors
/// A model without an answer at the fit.
pub fn profiles(
    problem: &FitProblem,
    at: &LinearisedRuns,
    values: &[f64],
    errors: &[f64],
) -> Result<Vec<Profile>, Error> {
    let normal = at.normal(problem.parameters, values, &[]);
    let known = inverse(&normal.0);
    let plain: Vec<f64> = (0..values.len()).map(|k| known[(k, k)].sqrt()).collect();
    // The cost counts in the larger of both errors.
    let reach: Vec<f64> = errors.iter().zip(&plain).map(|(error, plain)| error.max(*plain)).collect();
    let points: Vec<(usize, f64)> =
        (0..values.len()).flat_map(|k| abscissae(problem, values, &reach, k).map(move |x| (k, x))).collect();
    let least = problem.cost(&at.residuals, values);
    let costs = parallel::map(&points, |_, (k, x)| {
        let rise = ((x - values[*k]) / plain[*k]).powi(2);
        along(problem, at, &normal, values, (*k, *x), least..least + rise)
    });
    let mut profiles = Vec::new();
    for (k, parameter) in problem.parameters.iter().enumerate() {
        // The curvature of the cost is 1/plain^2; that of the clustered covariance 1/error^2.
        let scale = if errors[k] > 0.0 { (plain[k] / errors[k]).powi(2).min(1.0) } else { 1.0 };
        let own = points.iter().zip(&costs).filter(|((of, _), _)| *of == k);
        let mut curve: Vec<(f64, f64)> =
            own.filter_map(|((_, x), cost)| cost.map(|cost| (*x, scale * (cost - least).max(0.0)))).collect();
        curve.push((values[k], 0.0));
        wingbeat::math::order::ascend_by(&mut curve, |item| item.0);
        profiles.push(profile(parameter, values[k], curve));
    }
    Ok(profiles)
}

fn profile(parameter: &FittedParameter, value: f64, curve: Vec<(f64, f64)>) -> Profile {
    let crossing = |side: f64| {
        let mut outwards: Vec<(f64, f64)> =
            curve.iter().copied().filter(|(x, _)| side * (x - value) >= 0.0).collect();
        wingbeat::math::order::ascend_by(&mut outwards, |item| side * item.0);
        // The square root of the cost is nearly straight.
        outwards.windows(2).find(|pair| pair[0].1 <= CHI_95 && pair[1].1 > CHI_95).map(|pair| {
            let (a, b, c) = (pair[0].1.sqrt(), pair[1].1.sqrt(), CHI_95.sqrt());
            pair[0].0 + (pair[1].0 - pair[0].0) * (c - a) / (b - a)
        })
    };
    let interval = [crossing(-1.0), crossing(1.0)];
    let at_bound = value <= parameter.low || value >= parameter.high;
    let label = match (interval[0].is_some(), interval[1].is_some()) {
        (true, true) => Label::Identified,
        (false, false) => Label::Flat,
        _ => Label::OneSided,
    };
    let label = if at_bound && label == Label::Identified { Label::OneSided } else { label };
    let (values, cost) = curve.into_iter().unzip();
    Profile { values, cost, label, interval }
}

/// Values at which the profile of parameter `k` is taken: to 3 standard errors on both sides, within the bounds.
fn abscissae(
    problem: &FitProblem,
    values: &[f64],
    errors: &[f64],
    k: usize,
) -> impl Iterator<Item = f64> + use<> {
    let parameter = &problem.parameters[k];
    let (low, high, value) = (parameter.low, parameter.high, values[k]);
    // What is hardly known is looked at over all of its size.
    let widest = 3.0 * parameter.scale().abs();
    let error = if errors[k].is_finite() { errors[k].clamp(0.0, widest) } else { widest };
    let side = move |sign: f64| {
        (1..=SIDE).map(move |i| (value + sign * error * 3.0 * i as f64 / SIDE as f64).clamp(low, high))
    };
    let mut all: Vec<f64> = side(-1.0).chain(side(1.0)).filter(|x| *x != value).collect();
    all.dedup();
    all.into_iter()
}

/// The cost with parameter `k` at `x`; none where the model has no answer. `told` are the cost at the fit and what the linear model says
/// of it at `x`.
fn along(
    problem: &FitProblem,
    at: &LinearisedRuns,
    (square, gradient): &(DMatrix<f64>, DVector<f64>),
    values: &[f64],
    (k, x): (usize, f64),
    told: Range<f64>,
) -> Option<f64> {
    let free: Vec<usize> = (0..values.len()).filter(|i| *i != k).collect();
    let mut now = values.to_vec();
    now[k] = x;
    // The gradient at the moved value by the linear model, then by the residuals themselves.
    let mut g = gradient.clone() + square.column(k) * (x - values[k]);
    let mut least = f64::INFINITY;
    for _ in 0..INNER {
        let next = step(&(square.clone(), g.clone()), 0.0, problem.parameters, &now, &free);
        let predictions: Result<Vec<_>, _> =
            at.of.iter().map(|run| problem.model.predict(*run, &next)).collect();
        let residuals = problem.residuals(&at.of, &predictions.ok()?);
        let cost = problem.cost(&residuals, &next);
        if !(cost < least) {
            break;
        }
        least = cost;
        if (cost - told.end).abs() <= TOLD * (told.end - told.start) {
            break;
        }
        g = LinearisedRuns { of: at.of.clone(), residuals, jacobians: at.jacobians.clone() }
            .normal(problem.parameters, &next, &[])
            .1;
        now = next;
    }
    least.is_finite().then_some(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_s_quantiles() {
        for (freedom, quantile) in [(6.0, 2.4469), (10.0, 2.2281), (30.0, 2.0423), (120.0, 1.9799)] {
            let own = student_95(freedom);
            assert!((own - quantile).abs() < 2e-3, "{freedom}: {own}");
        }
        assert_eq!(student_95(f64::INFINITY), NORMAL_95);
    }
}
