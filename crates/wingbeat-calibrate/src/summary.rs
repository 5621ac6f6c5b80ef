//! `summary.json`.

use crate::data::{DataFile, SampleFiles};
use crate::found::{CalibrationResult, FoundRun};
use crate::{Fit, Label, LearnedChannel, LearnedResidual, NextRun, Rival, RunRole, rms, student_95};
use serde::Serialize;
use std::collections::BTreeMap;
use wingbeat::judge::Verdict;
use wingbeat::math::order::filled;

/// Root mean square of those of the numbers that are measured; NaN of none.
fn pooled(mut of: Vec<f64>) -> f64 {
    of.retain(|x| !x.is_nan());
    let count = of.len() as f64;
    if of.is_empty() { f64::NAN } else { (of.iter().map(|x| x * x).sum::<f64>() / count).sqrt() }
}

impl CalibrationResult {
    /// Root mean square of what the model misses in a channel of the runs that were fitted, before and after the fit, N or
    /// N m; NaN where no run measured it.
    pub(crate) fn residuals(&self, channel: usize) -> [f64; 2] {
        let before = self.fitted().map(|run| rms(&run.observed, &run.before)[channel]).collect();
        let after = self.fitted().map(|run| rms(&run.observed, &run.after.cycle)[channel]).collect();
        [pooled(before), pooled(after)]
    }

    /// The contents of summary.json.
    pub fn summary(&self, files: &SampleFiles, verdict: &Verdict) -> CalibrationSummary {
        let (mut rmse, mut coverage, mut white, mut widths) =
            (BTreeMap::new(), BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for (channel, name) in self.channels().into_iter().enumerate() {
            let [before, after] = self.residuals(channel);
            let held = match self.held_out().next() {
                Some(_) => self.held_out().map(|run| rms(&run.observed, &run.after.cycle)[channel]).collect(),
                None => self.left_out.iter().map(|(_, rms)| rms[channel]).collect(),
            };
            let rms = Rmse { before, after, held_out: pooled(held) };
            rmse.insert(name.clone(), rms);
            let judged: Vec<&FoundRun> = match self.held_out().next() {
                Some(_) => self.held_out().collect(),
                None => self.fitted().collect(),
            };
            let judged: Vec<&FoundRun> =
                judged.into_iter().filter(|run| run.observed.is_measured(channel)).collect();
            let share = |of: &dyn Fn(&FoundRun) -> f64| {
                judged.iter().map(|run| of(run)).sum::<f64>() / judged.len() as f64
            };
            coverage.insert(
                name.clone(),
                share(&|run| run.after.coverage(&run.observed, &run.after.deviations)[channel]),
            );
            white.insert(
                name.clone(),
                share(&|run| run.after.coverage(&run.observed, &run.after.white)[channel]),
            );
            widths.insert(name, share(&|run| run.after.half_widths()[channel]));
        }
        let names = self.channels();
        let discrepancy = filled(names.iter().cloned().zip(self.discrepancy.iter().copied()));
        CalibrationSummary {
            verdict: verdict.clone(),
            parameters: (0..self.values.len()).map(|k| self.parameter(k)).collect(),
            held: filled(self.held.iter().cloned()),
            rmse,
            coverage,
            coverage_white: white,
            band_half_width: widths,
            chi_squared: self.chi_squared,
            discrepancy,
            residual_autocorrelation: self.residual_autocorrelation(),
            residual_over_noise: filled(names.iter().cloned().zip(self.residual_over_noise())),
            correlations: self.correlations.clone(),
            singular_values: self.singular.0.clone(),
            starts: self.starts.clone(),
            runs: self.runs.iter().map(SummaryRun::of).collect(),
            left_out: filled(self.left_out.iter().map(|(run, rms)| {
                let by = filled(names.iter().cloned().zip(rms.iter().copied()));
                (self.runs[*run].observed.name.clone(), by)
            })),
            structures: self.rivals.clone(),
            next_run: self.next.clone(),
            residual: self.residual.as_ref().map(|residual| SummaryResidual::of(residual, self)),
            cautions: self.cautions.clone(),
            data: files.0.clone(),
        }
    }

    fn parameter(&self, k: usize) -> SummaryParameter {
        let parameter = &self.parameters[k];
        let spread = student_95(self.freedom) * self.errors[k];
        SummaryParameter {
            name: parameter.name.clone(),
            value: self.values[k],
            standard_error: self.errors[k],
            standard_error_white: self.white_errors[k],
            low: self.values[k] - spread,
            high: self.values[k] + spread,
            label: self.label(k),
            profile_interval: self.profiles[k].interval,
            start: parameter.start,
            bounds: [parameter.low, parameter.high],
            prior: parameter.prior,
            at_bound: self.values[k] <= parameter.low || self.values[k] >= parameter.high,
        }
    }
}

/// The contents of summary.json.
#[derive(Serialize)]
pub struct CalibrationSummary {
    #[serde(flatten)]
    verdict: Verdict,
    parameters: Vec<SummaryParameter>,
    held: BTreeMap<String, f64>,
    rmse: BTreeMap<String, Rmse>,
    coverage: BTreeMap<String, f64>,
    coverage_white: BTreeMap<String, f64>,
    band_half_width: BTreeMap<String, f64>,
    chi_squared: f64,
    discrepancy: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    residual_autocorrelation: Option<f64>,
    residual_over_noise: BTreeMap<String, f64>,
    correlations: Vec<Vec<f64>>,
    singular_values: Vec<f64>,
    starts: Vec<Option<Fit>>,
    runs: Vec<SummaryRun>,
    left_out: BTreeMap<String, BTreeMap<String, f64>>,
    structures: Vec<Rival>,
    next_run: Vec<NextRun>,
    #[serde(skip_serializing_if = "Option::is_none")]
    residual: Option<SummaryResidual>,
    cautions: Vec<String>,
    data: Vec<DataFile>,
}

#[derive(Serialize)]
struct SummaryParameter {
    name: String,
    value: f64,
    standard_error: f64,
    standard_error_white: f64,
    low: f64,
    high: f64,
    label: Label,
    profile_interval: [Option<f64>; 2],
    start: f64,
    bounds: [f64; 2],
    prior: Option<[f64; 2]>,
    at_bound: bool,
}

#[derive(Serialize)]
struct Rmse {
    before: f64,
    after: f64,
    held_out: f64,
}

#[derive(Serialize)]
struct SummaryRun {
    name: String,
    held_out: bool,
    residual: bool,
    cycles: usize,
    left_out_cycles: usize,
    effective_cycles: f64,
    frequency_hz: f64,
}

/// What the model leaves of runs, learned.
#[derive(Serialize)]
struct SummaryResidual {
    runs: Vec<String>,
    /// Velocity of each run against the air, m/s in B.
    velocities_m_s: Vec<[f64; 3]>,
    terms: Vec<String>,
    channels: BTreeMap<String, SummaryLearned>,
}

#[derive(Serialize)]
struct SummaryLearned {
    /// Rms of what the model leaves.
    left: f64,
    /// What is missed of it of a run left out, in parts of it.
    missed: f64,
    told: bool,
}

impl SummaryResidual {
    fn of(residual: &LearnedResidual, found: &CalibrationResult) -> Self {
        let channel = |channel: &LearnedChannel| {
            let own = SummaryLearned { left: channel.left, missed: channel.missed, told: channel.is_told() };
            (channel.name.clone(), own)
        };
        Self {
            runs: residual.runs.iter().map(|(run, _)| found.runs[*run].observed.name.clone()).collect(),
            velocities_m_s: residual.runs.iter().map(|(_, velocity)| velocity.0).collect(),
            terms: residual.spec.terms.clone(),
            channels: filled(residual.channels.iter().map(channel)),
        }
    }
}

impl SummaryRun {
    fn of(run: &FoundRun) -> Self {
        let observed = &run.observed;
        Self {
            name: observed.name.clone(),
            held_out: observed.role == RunRole::HeldOut,
            residual: observed.role == RunRole::Residual,
            cycles: observed.cycles.len(),
            left_out_cycles: observed.left_out,
            effective_cycles: observed.effective(),
            frequency_hz: observed.frequency_hz,
        }
    }
}
