//! Which run and channel informs which parameter, before anything is fitted.

use crate::fit::LinearisedRuns;
use crate::problem::FitProblem;
use crate::uncertainty::{correlations, inverse};
use crate::{Error, HarmonicLayout};
use nalgebra::{DMatrix, DVector};

/// Correlation from which a pair is shown as hard to part. *Choice.*
pub const CLOSE: f64 = 0.9;
/// Standard error, in parts of a parameter's size, beyond which the runs say nothing of it. *Choice.*
const NOTHING: f64 = 1.0;
/// Smallest eigenvalue of the information with a unit diagonal: below it directions are of rounding. *Choice.*
const LEAST: f64 = 1e-7;
/// Slope of the loads by a parameter, in parts of its size and of the largest, below which no load depends on it: what rounding leaves.
const SILENT: f64 = 1e-9;

/// What the runs say of the parameters at their starts.
#[derive(Clone, Debug)]
pub struct Information {
    /// By run: names of the runs.
    pub runs: Vec<String>,
    /// By channel of the first run's layout: number of channels.
    pub channels: usize,
    /// Standard error of each parameter (column), in parts of its size, from one run and channel alone (row, channel
    /// fastest), the others known.
    pub alone: Vec<Vec<f64>>,
    /// Standard error, in parts of the size, from all runs, all others fitted too; infinite where they are not told apart.
    pub together: Vec<f64>,
    /// The same with the others known: never above that from one run and channel.
    pub known: Vec<f64>,
    /// Correlations of the estimates.
    pub correlations: DMatrix<f64>,
    /// Groups of parameters of which only a combination is told, with its weights in parts of their sizes.
    pub inseparable: Vec<Vec<(usize, f64)>>,
    /// Parameters on which no load depends, whatever their priors say.
    pub silent: Vec<usize>,
    /// Pairs that are close, with their correlation.
    pub close: Vec<(usize, usize, f64)>,
    /// Runs, of those given, that suffice for every parameter's standard error to be below its size, in order of what
    /// they add.
    pub suffice: Option<Vec<usize>>,
}

impl Information {
    /// Of the linearisation `at` about `values`, in the units of the parameters.
    pub fn of(problem: &FitProblem, at: &LinearisedRuns, values: &[f64]) -> Self {
        let parameters = problem.parameters;
        let n = parameters.len();
        let sizes: Vec<f64> = parameters.iter().map(|parameter| parameter.scale().abs()).collect();
        let channels = problem.runs[at.of[0]].layout.channels;
        let mut alone = Vec::new();
        for (run, j) in at.of.iter().zip(&at.jacobians) {
            let observed = &problem.runs[*run];
            let layout = observed.layout;
            let slopes: Vec<Vec<f64>> =
                j.column_iter().map(|column| problem.coloured(*run, &column.into_owned())).collect();
            for channel in 0..layout.channels {
                let covariance = problem.covariance_of_channel(*run, channel);
                let factor =
                    Some(covariance).filter(|_| observed.is_measured(channel)).and_then(|c| c.cholesky());
                let square = |k: usize| {
                    let own = DVector::from_fn(layout.width(), |part, _| slopes[k][layout.at(channel, part)]);
                    factor.as_ref().map_or(0.0, |factor| own.dot(&factor.solve(&own)))
                };
                alone.push((0..n).map(|k| 1.0 / (square(k).sqrt() * sizes[k])).collect());
            }
        }
        let (square, _) = at.normal(parameters, values, &[]);
        let known = (0..n).map(|k| 1.0 / (square[(k, k)].sqrt() * sizes[k])).collect();
        let (together, inseparable) = told(&square, &sizes);
        let slope = |k: usize| at.jacobians.iter().map(|j| j.column(k).norm_squared()).sum::<f64>();
        let by_size: Vec<f64> = (0..n).map(|k| slope(k).sqrt() * sizes[k]).collect();
        let largest = by_size.iter().copied().fold(0.0, f64::max);
        let correlations = correlations(&inverse(&square));
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i)));
        let among = |i: usize| inseparable.iter().any(|group| group.iter().any(|(k, _)| *k == i));
        let close = pairs
            .map(|(j, i)| (j, i, correlations[(i, j)]))
            .filter(|(j, i, c)| c.abs() >= CLOSE && !(among(*j) && among(*i)))
            .collect();
        Self {
            runs: at.of.iter().map(|run| problem.runs[*run].name.clone()).collect(),
            channels,
            alone,
            together,
            known,
            correlations,
            inseparable,
            silent: (0..n).filter(|k| !(by_size[*k] > SILENT * largest)).collect(),
            close,
            suffice: suffice(problem, at, values, &sizes),
        }
    }

    /// Refuses parameters that the runs do not tell, by name.
    ///
    /// # Errors
    /// [`Error::Uninformed`] with groups, single parameters, and what could be done.
    pub fn check(&self, problem: &FitProblem) -> Result<(), Error> {
        let name = |k: &usize| problem.parameters[*k].name.as_str();
        let mut told = Vec::new();
        for group in &self.inseparable {
            let names: Vec<&str> = group.iter().map(|(k, _)| name(k)).collect();
            told.push(match names.as_slice() {
                [one] => format!("{one}: {NO_LOAD}"),
                _ => format!(
                    "{}: only {} is told, not each; hold all but one, give priors, or add runs that part them",
                    names.join(" and "),
                    product(group, problem)
                ),
            });
        }
        let prior = |k: &usize| problem.parameters[*k].prior.is_some();
        told.extend(self.silent.iter().filter(|k| prior(k)).map(|k| format!("{}: {NO_LOAD}", name(k))));
        let grouped = |k: usize| {
            self.silent.contains(&k)
                || self.inseparable.iter().any(|group| group.iter().any(|(i, _)| *i == k))
        };
        for (k, error) in self.together.iter().enumerate() {
            if *error > NOTHING && !grouped(k) {
                told.push(format!(
                    "{}: its standard error would be {:.1} times its size; hold it, {} prior, or add runs",
                    name(&k),
                    error,
                    if prior(&k) { "give a narrower" } else { "give a" }
                ));
            }
        }
        if told.is_empty() { Ok(()) } else { Err(Error::Uninformed(told.join("\n"))) }
    }
}

/// What is said of a parameter on which no load depends.
const NO_LOAD: &str =
    "no load of the runs depends on it, as other laws (aero.law) or presets might: leave it out";

/// The combination that a group tells: powers of a product, as relative changes add up.
fn product(group: &[(usize, f64)], problem: &FitProblem) -> String {
    // The direction of no information is d; what is told is any product whose powers are normal to it.
    let [(a, x), (b, y)] = group else { return "some combinations of them".into() };
    let (a, b) = (&problem.parameters[*a].name, &problem.parameters[*b].name);
    let ratio = -x / y;
    if (ratio - 1.0).abs() < 0.02 {
        format!("the product {a} x {b}")
    } else if (ratio + 1.0).abs() < 0.02 {
        format!("the ratio {a} / {b}")
    } else {
        format!("{a}^{:.2} x {b}^{:.2}", -y / x.hypot(*y), x / x.hypot(*y))
    }
}

/// Standard errors in parts of the sizes, and the groups that are not told apart, from the eigenvectors of the information
/// with a unit diagonal.
fn told(square: &DMatrix<f64>, sizes: &[f64]) -> (Vec<f64>, Vec<Vec<(usize, f64)>>) {
    let n = sizes.len();
    let diagonal: Vec<f64> = (0..n).map(|k| square[(k, k)].sqrt()).collect();
    let largest = (0..n).map(|k| diagonal[k] * sizes[k]).fold(0.0, f64::max);
    let silent = |k: usize| !(diagonal[k] * sizes[k] > SILENT * largest);
    let unit = DMatrix::from_fn(n, n, |i, j| match (silent(i) || silent(j), i == j) {
        (true, true) => 1.0,
        (true, false) => 0.0,
        _ => square[(i, j)] / (diagonal[i] * diagonal[j]),
    });
    let eigen = unit.symmetric_eigen();
    let mut groups: Vec<Vec<(usize, f64)>> = (0..n).filter(|k| silent(*k)).map(|k| vec![(k, 1.0)]).collect();
    let mut unknown = vec![false; n];
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > LEAST {
            continue;
        }
        // In parts of the sizes, the largest 1.
        let scaled: Vec<f64> =
            (0..n).map(|k| vector[k] / (diagonal[k].max(f64::MIN_POSITIVE) * sizes[k])).collect();
        let most = scaled.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let group: Vec<(usize, f64)> =
            (0..n).filter(|k| scaled[*k].abs() > 0.05 * most).map(|k| (k, scaled[k] / most)).collect();
        group.iter().for_each(|(k, _)| unknown[*k] = true);
        groups.push(group);
    }
    let covariance = inverse(square);
    let error = |k: usize| {
        if silent(k) || unknown[k] { f64::INFINITY } else { covariance[(k, k)].sqrt() / sizes[k] }
    };
    ((0..n).map(error).collect(), groups)
}

/// The fewest runs, taken one by one for what they add, with which all parameters are told; none if all together do not.
fn suffice(problem: &FitProblem, at: &LinearisedRuns, values: &[f64], sizes: &[f64]) -> Option<Vec<usize>> {
    let worst = |taken: &[usize]| {
        let leave: Vec<usize> = at.of.iter().copied().filter(|run| !taken.contains(run)).collect();
        let (square, _) = at.normal(problem.parameters, values, &leave);
        told(&square, sizes).0.into_iter().fold(0.0, f64::max)
    };
    let mut taken: Vec<usize> = Vec::new();
    while taken.len() < at.of.len() {
        let left = at.of.iter().filter(|run| !taken.contains(run));
        let gain = |run: &usize| {
            let mut more = taken.clone();
            more.push(*run);
            worst(&more)
        };
        let next = left.copied().map(|run| (run, gain(&run))).min_by(|a, b| a.1.total_cmp(&b.1))?;
        taken.push(next.0);
        if next.1 < NOTHING {
            return Some(taken);
        }
    }
    None
}

/// What a channel is called.
pub fn channel_name(layout: HarmonicLayout, channel: usize) -> String {
    if layout.channels == 6 {
        wingbeat::rig::cell::CHANNELS[channel].0.into()
    } else {
        format!("channel {}", channel + 1)
    }
}
