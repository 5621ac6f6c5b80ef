//! What a calibration found, as numbers.

use std::collections::BTreeMap;

use serde::Serialize;
use wingbeat::simulate::{Column, Record};
use wingbeat_calibrate::design::{largest, rank};
use wingbeat_calibrate::{
    Calibration, Failure, Fit, Information, Keep, Label, Observed, PHASES, Parameter, Predicted, Problem,
    Profile, Solved, Structure, channel_name, phase_of, rms,
};

use super::data::{DataFile, Files};
use crate::error::Error;
use crate::run_folder::RunFolder;

/// Fits that are done, kept in the folder for a command that goes on.
pub struct Kept<'a> {
    folder: &'a RunFolder,
    fits: BTreeMap<usize, Fit>,
}

/// The file of fits that are done.
const KEPT: &str = "starts.json";

impl<'a> Kept<'a> {
    /// What an interrupted command left.
    pub fn open(folder: &'a RunFolder) -> Self {
        let text = std::fs::read_to_string(folder.file(KEPT)).unwrap_or_default();
        Self { folder, fits: serde_json::from_str(&text).unwrap_or_default() }
    }

    /// Removes the file: the summary holds what it held.
    pub fn remove(folder: &RunFolder) {
        let _ = std::fs::remove_file(folder.file(KEPT));
    }
}

impl Keep for Kept<'_> {
    fn kept(&self, number: usize) -> Option<Fit> {
        self.fits.get(&number).cloned()
    }
    fn keep(&mut self, number: usize, fit: &Fit) {
        self.fits.insert(number, fit.clone());
        // Without the file the command begins anew: nothing else is lost.
        let _ = self.folder.write_json(KEPT, &self.fits);
    }
}

/// A structure of the model with what it leaves.
#[derive(Clone, Debug, Serialize)]
pub struct Rival {
    /// Name.
    pub name: String,
    /// Sum of squares over freedom with the noise of the cycles alone.
    pub chi_squared: f64,
    /// Rms in runs left out, mean over the runs, by channel.
    pub left_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub left_out_share: f64,
    /// Rms in runs held out, by channel.
    pub held_out_rms: BTreeMap<String, f64>,
    /// The same in parts of the channels' measured rms, mean over the channels.
    pub held_out_share: Option<f64>,
    /// Values.
    pub values: Vec<f64>,
}

/// Mean over runs of the rms by channel, and that in parts of the measured rms.
fn shares(runs: &[Observed], of: &[(usize, Vec<f64>)]) -> (BTreeMap<String, f64>, f64) {
    let Some((first, _)) = of.first() else { return (BTreeMap::new(), f64::NAN) };
    let layout = runs[*first].layout;
    let (mut by_channel, mut share) = (BTreeMap::new(), 0.0);
    for channel in 0..layout.channels {
        let mean = of.iter().map(|(_, rms)| rms[channel]).sum::<f64>() / of.len() as f64;
        let own = |run: usize| layout.mean_square(&runs[run].mean, channel).sqrt();
        let size = of.iter().map(|(run, _)| own(*run)).sum::<f64>() / of.len() as f64;
        by_channel.insert(channel_name(layout, channel), mean);
        share += mean / size.max(f64::MIN_POSITIVE) / layout.channels as f64;
    }
    (by_channel, share)
}

impl Rival {
    /// Of a fitted structure.
    pub fn of(name: &str, runs: &[Observed], solved: &Solved) -> Result<Self, Error> {
        let (left_out_rms, left_out_share) = shares(runs, &solved.left_out().map_err(Failure::from)?);
        let mut held = Vec::new();
        for run in (0..runs.len()).filter(|run| runs[*run].held_out) {
            let predicted = solved.problem.model.predict(run, &solved.values).map_err(Failure::from)?;
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
    /// Its standard error now.
    pub error_now: f64,
    /// What it will be.
    pub error_then: f64,
    /// Standard errors of all parameters then.
    pub errors: Vec<f64>,
}

impl NextRun {
    /// All candidates, the best first, each with as many passes as the runs made had.
    pub fn all(candidates: &Structure, solved: &Solved, passes: usize) -> Result<Vec<Self>, Failure> {
        let values = &solved.values;
        let template = &solved.problem.runs[solved.at.of[0]];
        let observed = candidates.model.targets.iter().enumerate().map(|(k, target)| {
            let mean = target.predict(&candidates.model.numbers(values))?;
            let cycles = target.cycles() * passes;
            Ok(Observed {
                name: candidates.model.targets[k].name.clone(),
                weights: vec![1.0; cycles],
                cycles: vec![mean.clone(); cycles],
                mean,
                held_out: false,
                left_out: 0,
                ..template.clone()
            })
        });
        let observed = observed.collect::<Result<Vec<Observed>, wingbeat_calibrate::Error>>()?;
        let noise = vec![solved.problem.noise[solved.at.of[0]].clone(); observed.len()];
        let parameters = solved.problem.parameters;
        let problem = Problem::with_noise(&candidates.model, &observed, parameters, noise)?;
        let ranked = rank(solved, &problem)?;
        let (worst, _) = largest(&solved.errors(), parameters);
        Ok(ranked
            .into_iter()
            .map(|candidate| Self {
                name: observed[candidate.index].name.clone(),
                parameter: parameters[worst].name.clone(),
                error_now: solved.errors()[worst],
                error_then: candidate.errors[worst],
                errors: candidate.errors,
            })
            .collect())
    }
}

/// A run with what was measured and predicted.
pub struct FoundRun {
    /// What was measured.
    pub observed: Observed,
    /// Predicted with the values that the fit began with.
    pub before: Vec<f64>,
    /// Predicted with the fit.
    pub after: Predicted,
    /// Covariance of the noise of its mean, by harmonic and channel.
    pub noise: Vec<Vec<f64>>,
}

/// All that was found.
pub struct Found {
    /// Name.
    pub name: String,
    /// The model's overrides.
    pub model: Vec<String>,
    /// What was fitted.
    pub parameters: Vec<Parameter>,
    /// Names and values of what was held.
    pub held: Vec<(String, f64)>,
    /// Values.
    pub values: Vec<f64>,
    /// Standard errors, cycles as clusters.
    pub errors: Vec<f64>,
    /// Standard errors as if samples were independent.
    pub white_errors: Vec<f64>,
    /// Profiles.
    pub profiles: Vec<Profile>,
    /// Correlations.
    pub correlations: Vec<Vec<f64>>,
    /// Singular values with their directions.
    pub singular: (Vec<f64>, Vec<Vec<f64>>),
    /// Cost and values of every start.
    pub starts: Vec<Option<Fit>>,
    /// Sum of squares over freedom with the noise of the cycles alone.
    pub chi_squared: f64,
    /// What the model cannot say, in parts of the amplitude, by channel.
    pub discrepancy: Vec<f64>,
    /// The runs.
    pub runs: Vec<FoundRun>,
    /// Rms of runs left out.
    pub left_out: Vec<(usize, Vec<f64>)>,
    /// What the runs tell.
    pub information: Information,
    /// Structures of the model, this one first.
    pub rivals: Vec<Rival>,
    /// Candidates for a next run.
    pub next: Vec<NextRun>,
    /// What is odd of the samples.
    pub cautions: Vec<String>,
}

impl Found {
    /// Of what was solved.
    pub fn of(
        calibration: &Calibration,
        structure: &Structure,
        runs: &[Observed],
        solved: &Solved,
        information: Information,
        cautions: Vec<String>,
    ) -> Result<Self, Error> {
        let starts: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
        let correlations = solved.correlations();
        let one = |run: usize| -> Result<FoundRun, Failure> {
            let observed = runs[run].clone();
            let count = observed.effective();
            let channels = observed.layout.channels;
            let of = |k: usize| (0..channels).map(|c| solved.problem.noise[run][k][(c, c)] / count).collect();
            Ok(FoundRun {
                before: solved.problem.model.predict(run, &starts)?,
                after: solved.predicted(run)?,
                noise: (0..=observed.layout.harmonics).map(of).collect(),
                observed,
            })
        };
        let own = Rival::of("as calibrated", runs, solved)?;
        Ok(Self {
            name: calibration.spec.name.clone(),
            model: calibration.spec.model.clone(),
            parameters: structure.parameters.clone(),
            held: structure.model.held.clone(),
            values: solved.values.clone(),
            errors: solved.errors(),
            white_errors: solved.white_errors(),
            profiles: solved.profiles().map_err(Failure::from)?,
            correlations: (0..correlations.nrows())
                .map(|i| correlations.row(i).iter().copied().collect())
                .collect(),
            singular: (solved.covariances.singular_values.clone(), solved.covariances.directions.clone()),
            starts: solved.starts.iter().map(|start| start.fit.clone()).collect(),
            chi_squared: solved.chi_squared,
            discrepancy: solved.problem.discrepancy.clone(),
            runs: (0..runs.len()).map(one).collect::<Result<_, _>>()?,
            left_out: solved.left_out().map_err(Failure::from)?,
            information,
            rivals: vec![own],
            next: Vec::new(),
            cautions,
        })
    }

    /// Orders the structures by their error in runs left out.
    pub fn rank_structures(&mut self) {
        self.rivals.sort_by(|a, b| a.left_out_share.total_cmp(&b.left_out_share));
    }

    /// Runs that are only predicted.
    pub fn held_out(&self) -> impl Iterator<Item = &FoundRun> {
        self.runs.iter().filter(|run| run.observed.held_out)
    }

    /// Runs that were fitted.
    pub fn fitted(&self) -> impl Iterator<Item = &FoundRun> {
        self.runs.iter().filter(|run| !run.observed.held_out)
    }

    /// Names of the channels.
    pub fn channels(&self) -> Vec<String> {
        let layout = self.runs[0].observed.layout;
        (0..layout.channels).map(|channel| channel_name(layout, channel)).collect()
    }

    /// The label of parameter `k`.
    pub fn label(&self, k: usize) -> Label {
        self.profiles[k].label
    }

    /// The contents of summary.json.
    pub fn summary(&self, files: &Files) -> Summary {
        let (mut rmse, mut coverage, mut white, mut widths) =
            (BTreeMap::new(), BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for (channel, name) in self.channels().into_iter().enumerate() {
            let mean = |of: Vec<f64>| {
                let count = of.len() as f64;
                if of.is_empty() { f64::NAN } else { (of.iter().map(|x| x * x).sum::<f64>() / count).sqrt() }
            };
            let before = self.fitted().map(|run| rms(&run.observed, &run.before)[channel]).collect();
            let after = self.fitted().map(|run| rms(&run.observed, &run.after.cycle)[channel]).collect();
            let held = match self.held_out().next() {
                Some(_) => self.held_out().map(|run| rms(&run.observed, &run.after.cycle)[channel]).collect(),
                None => self.left_out.iter().map(|(_, rms)| rms[channel]).collect(),
            };
            let rms = Rmse { before: mean(before), after: mean(after), held_out: mean(held) };
            rmse.insert(name.clone(), rms);
            let judged: Vec<&FoundRun> = match self.held_out().next() {
                Some(_) => self.held_out().collect(),
                None => self.fitted().collect(),
            };
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
        let discrepancy = names.iter().cloned().zip(self.discrepancy.iter().copied()).collect();
        Summary {
            status: "ok",
            parameters: (0..self.values.len()).map(|k| self.parameter(k)).collect(),
            held: self.held.iter().cloned().collect(),
            rmse,
            coverage,
            coverage_white: white,
            band_half_width: widths,
            chi_squared: self.chi_squared,
            discrepancy,
            correlations: self.correlations.clone(),
            singular_values: self.singular.0.clone(),
            starts: self.starts.clone(),
            runs: self.runs.iter().map(SummaryRun::of).collect(),
            left_out: self
                .left_out
                .iter()
                .map(|(run, rms)| {
                    let by = names.iter().cloned().zip(rms.iter().copied()).collect();
                    (self.runs[*run].observed.name.clone(), by)
                })
                .collect(),
            structures: self.rivals.clone(),
            next_run: self.next.clone(),
            cautions: self.cautions.clone(),
            data: files.0.clone(),
        }
    }

    fn parameter(&self, k: usize) -> SummaryParameter {
        let parameter = &self.parameters[k];
        let spread = wingbeat_calibrate::NORMAL_95 * self.errors[k];
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

    /// The cycles of all runs: measured, before, after, band.
    pub fn record(&self) -> Result<Record, Error> {
        let mut columns = columns();
        for (number, run) in self.runs.iter().enumerate() {
            let curves = run.curves();
            columns[0].values.extend(std::iter::repeat_n(number as f64, curves.len()));
            columns[1].values.extend((0..PHASES).map(|k| k as f64 / PHASES as f64));
            for (at, column) in columns[2..].iter_mut().enumerate() {
                let (channel, which) = (at / CURVES.len(), at % CURVES.len());
                column.values.extend(curves.iter().map(|phase| phase[channel][which]));
            }
        }
        Ok(Record::new(columns, 0)?)
    }
}

/// What is told of every channel over the cycle.
const CURVES: [&str; 5] = ["measured", "before", "after", "low", "high"];

/// The columns of the record, empty.
pub fn columns() -> Vec<Column> {
    let channels = wingbeat::rig::cell::CHANNELS.iter();
    let of =
        |(name, unit): &(&str, &str)| CURVES.map(|curve| Column::new(format!("{curve}_{name}"), *unit, "B"));
    let first = [Column::new("run", "", ""), Column::new("cycle", "", "")];
    first.into_iter().chain(channels.flat_map(of)).collect()
}

impl FoundRun {
    /// By phase and channel: measured, before, after, low and high end of the band.
    pub fn curves(&self) -> Vec<Vec<[f64; 5]>> {
        let layout = self.observed.layout;
        let at = |k: usize| {
            let channel = |channel: usize| {
                let of = |cycle: &[f64]| layout.value(cycle, channel, phase_of(k));
                let after = of(&self.after.cycle);
                let half = wingbeat_calibrate::NORMAL_95 * self.after.deviations[channel][k];
                [of(&self.observed.mean), of(&self.before), after, after - half, after + half]
            };
            (0..layout.channels).map(channel).collect()
        };
        (0..PHASES).map(at).collect()
    }
}

/// The contents of summary.json.
#[derive(Serialize)]
pub struct Summary {
    status: &'static str,
    parameters: Vec<SummaryParameter>,
    held: BTreeMap<String, f64>,
    rmse: BTreeMap<String, Rmse>,
    coverage: BTreeMap<String, f64>,
    coverage_white: BTreeMap<String, f64>,
    band_half_width: BTreeMap<String, f64>,
    chi_squared: f64,
    discrepancy: BTreeMap<String, f64>,
    correlations: Vec<Vec<f64>>,
    singular_values: Vec<f64>,
    starts: Vec<Option<Fit>>,
    runs: Vec<SummaryRun>,
    left_out: BTreeMap<String, BTreeMap<String, f64>>,
    structures: Vec<Rival>,
    next_run: Vec<NextRun>,
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
    cycles: usize,
    left_out_cycles: usize,
    effective_cycles: f64,
    frequency_hz: f64,
}

impl SummaryRun {
    fn of(run: &FoundRun) -> Self {
        let observed = &run.observed;
        Self {
            name: observed.name.clone(),
            held_out: observed.held_out,
            cycles: observed.cycles.len(),
            left_out_cycles: observed.left_out,
            effective_cycles: observed.effective(),
            frequency_hz: observed.frequency_hz,
        }
    }
}
