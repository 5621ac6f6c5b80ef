//! Other structures of the model, and other runs, beside those that were fitted.

use crate::design::{RunCandidate, largest, rank};
use crate::observed::{Common, sized};
use crate::problem::group;
use crate::{
    Error, FitProblem, HarmonicLayout, ModelStructure, ObservedCycles, RigTarget, RunRole, SolvedCalibration,
    channel_name, rms,
};
use nalgebra::DMatrix;
use serde::Serialize;
use std::collections::BTreeMap;
use wingbeat::math::order::ascend_by;

/// A structure of the model with what it leaves.
#[derive(Clone, Debug, Serialize)]
pub struct Rival {
    /// Name.
    pub name: String,
    /// Sum of squares over freedom, a ratio, with the noise of the cycles alone.
    pub chi_squared: f64,
    /// Rms in runs left out, mean over the runs, by channel, in its unit.
    pub left_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub left_out_share: f64,
    /// Rms in runs held out, by channel, in its unit.
    pub held_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub held_out_share: Option<f64>,
    /// Values, in the units of the parameters.
    pub values: Vec<f64>,
}

/// Mean over runs of the rms by channel, and that in parts of the measured rms.
fn shares(runs: &[ObservedCycles], of: &[(usize, Vec<f64>)]) -> (BTreeMap<String, f64>, f64) {
    let Some((first, _)) = of.first() else { return (BTreeMap::new(), f64::NAN) };
    let layout = runs[*first].layout;
    let (mut by_channel, mut share) = (BTreeMap::new(), 0.0);
    let mut told = 0.0_f64;
    for channel in 0..layout.channels {
        let measured: Vec<&(usize, Vec<f64>)> =
            of.iter().filter(|(run, _)| runs[*run].is_measured(channel)).collect();
        if measured.is_empty() {
            continue;
        }
        let mean = measured.iter().map(|(_, rms)| rms[channel]).sum::<f64>() / measured.len() as f64;
        let own = |run: usize| runs[run].layout.mean_square(&runs[run].mean, channel).sqrt();
        let size = measured.iter().map(|(run, _)| own(*run)).sum::<f64>() / measured.len() as f64;
        by_channel.insert(channel_name(layout, channel), mean);
        share += mean / size.max(f64::MIN_POSITIVE);
        told += 1.0;
    }
    (by_channel, share / told.max(1.0))
}

impl Rival {
    /// Of a fitted structure.
    pub fn of(name: &str, runs: &[ObservedCycles], solved: &SolvedCalibration) -> Result<Self, Error> {
        let (left_out_rms, left_out_share) = shares(runs, &solved.left_out()?);
        let mut held = Vec::new();
        for run in (0..runs.len()).filter(|run| runs[*run].role == RunRole::HeldOut) {
            let predicted = solved.problem.model.predict(run, &solved.values)?;
            held.push((run, rms(&runs[run], &predicted)));
        }
        let (held_out_rms, share) = shares(runs, &held);
        Ok(Self {
            name: name.into(),
            chi_squared: solved.chi_squared,
            left_out_rms,
            left_out_share,
            held_out_share: (!held.is_empty()).then_some(share),
            held_out_rms,
            values: solved.values.clone(),
        })
    }
}

/// A candidate for the next run.
#[derive(Clone, Debug, Serialize)]
pub struct NextRun {
    /// Name.
    pub name: String,
    /// The parameter that is known worst.
    pub parameter: String,
    /// Its standard error now, in its unit.
    pub error_now: f64,
    /// What it will be, in its unit.
    pub error_then: f64,
    /// Standard errors of all parameters then, in the units of these.
    pub errors: Vec<f64>,
    /// Largest load on the cell of the cycle predicted, in parts of its range: above 1 the cell does not read it.
    pub load_share: f64,
}

impl NextRun {
    /// All candidates, those that the cell can read before the others, the best first, each with as many passes as the runs made had.
    ///
    /// # Errors
    /// A model without an answer.
    pub fn all(
        candidates: &ModelStructure,
        solved: &SolvedCalibration,
        passes: usize,
    ) -> Result<Vec<Self>, Error> {
        let values = &solved.values;
        let template = &solved.problem.runs[solved.at.of[0]];
        let observed = candidates.model.targets.iter().map(|target| {
            let mean = target.predict(&candidates.model.numbers(values))?;
            let cycles = target.cycles() * passes;
            // The tare is read as before the runs that were made, where those are of the same kind.
            let alike = template.layout == target.layout() && target.tilts().is_none();
            let common = if alike {
                Common { groups: Vec::new(), ..template.common.clone() }
            } else {
                Common::default()
            };
            Ok(ObservedCycles {
                common,
                unmeasured: Vec::new(),
                name: target.name.clone(),
                layout: target.layout(),
                weights: vec![1.0; cycles],
                cycles: vec![mean.clone(); cycles],
                mean,
                role: RunRole::Fitted,
                left_out: 0,
                ..template.clone()
            })
        });
        let observed = observed.collect::<Result<Vec<ObservedCycles>, Error>>()?;
        let noise = expected_noise(solved, &candidates.model.targets, &observed);
        let parameters = solved.problem.parameters;
        let problem = FitProblem::with_noise(&candidates.model, &observed, parameters, noise)?;
        let ranked = rank(solved, &problem)?;
        let (worst, _) = largest(&solved.errors(), parameters);
        let of = |candidate: RunCandidate| {
            let (target, observed) = (&candidates.model.targets[candidate.index], &observed[candidate.index]);
            Self {
                name: observed.name.clone(),
                parameter: parameters[worst].name.clone(),
                error_now: solved.errors()[worst],
                error_then: candidate.errors[worst],
                errors: candidate.errors,
                load_share: target.load_share(&observed.mean),
            }
        };
        let mut all: Vec<Self> = ranked.into_iter().map(of).collect();
        ascend_by(&mut all, |run| if run.load_share > 1.0 { 1.0 } else { 0.0 });
        Ok(all)
    }
}

/// Share of the whole force or moment that every channel's load counts at least where noise is held against it. *Choice.*
const LEAST_LOAD: f64 = 0.1;

/// Noise of runs that were not made, in the units of the channels, squared. The cell's own is known; what cycles scatter beyond
/// it (gusts, arm, structure) is in proportion to the load of each channel, as in the first of the runs made.
///
/// Equation: calibrate.expected_noise
/// `S' = E S E, e^2 = (cell' + (s^2 - cell) load'^2/load^2)/s^2`
/// Source: own; in proportion: choice.
/// Test: `the_noise_of_a_run_to_come_is_that_of_its_samples`.
pub fn expected_noise(
    solved: &SolvedCalibration,
    targets: &[RigTarget],
    candidates: &[ObservedCycles],
) -> Vec<Vec<DMatrix<f64>>> {
    let first = solved.at.of[0];
    let (made, noise) = (&solved.problem.runs[first], &solved.problem.noise[first]);
    let layout = made.layout;
    let Some(made_target) = solved.problem.model.target(first) else {
        return vec![noise.clone(); candidates.len()];
    };
    let own = loads(made);
    let cell = made_target.cell_noise();
    let scatter = |channel: usize| -> f64 {
        let part = |part: usize| {
            HarmonicLayout::share(part) * noise[HarmonicLayout::harmonic(part)][(channel, channel)]
        };
        (0..layout.width()).map(part).sum()
    };
    let one = |(target, candidate): (&RigTarget, &ObservedCycles)| {
        let (then, floor) = (loads(candidate), target.cell_noise());
        let by = |channel: usize| {
            let now = scatter(channel).max(f64::MIN_POSITIVE);
            let beyond = (now - cell[channel]).max(0.0) * then[channel] / own[channel].max(f64::MIN_POSITIVE);
            ((floor[channel] + beyond) / now).sqrt()
        };
        let by: Vec<f64> = (0..layout.channels).map(by).collect();
        sized(noise, &by)
    };
    targets.iter().zip(candidates).map(one).collect()
}

/// Mean square about the mean of each channel of a run, and a share of that of the whole force or moment.
fn loads(run: &ObservedCycles) -> Vec<f64> {
    let layout = run.layout;
    let own =
        |channel: usize| layout.mean_square(&run.mean, channel) - run.mean[layout.at(channel, 0)].powi(2);
    let of = |channel: usize| {
        own(channel) + LEAST_LOAD * LEAST_LOAD * group(layout, channel).map(own).sum::<f64>()
    };
    (0..layout.channels).map(of).collect()
}
