//! What a calibration found, as numbers.

use crate::{
    CalibrationFile, Error, Fit, FittedParameter, HarmonicLayout, Information, Label, LearnedResidual,
    ModelStructure, NORMAL_95, NextRun, ObservedCycles, PHASES, Predicted, Profile, Rival, RunRole,
    SolvedCalibration, channel_name, phase_of, rms,
};
use wingbeat::judge::Warning;
use wingbeat::judge::data::Finding;
use wingbeat::robot::FittedModel;
use wingbeat::simulate::{Column, Record};

/// Variance far below any cell's resolution, of channels that repeat to the last digit.
const LEAST_NOISE: f64 = 1e-24;

/// A run with what was measured and predicted.
pub struct FoundRun {
    /// What was measured.
    pub observed: ObservedCycles,
    /// Predicted with the values that the fit began with, in the units of the channels (N and N m).
    pub before: Vec<f64>,
    /// Predicted with the fit.
    pub after: Predicted,
    /// Covariance of the noise of its mean, by harmonic and channel, in the units of the channels, squared.
    pub noise: Vec<Vec<f64>>,
    /// By how much the measured cycles are behind, and the standard error of that, rad, were it fitted beside the parameters; none where it
    /// is not told.
    pub behind: Option<[f64; 2]>,
}

/// All that was found.
pub struct CalibrationResult {
    /// Name.
    pub name: String,
    /// The model's overrides.
    pub model: Vec<String>,
    /// Robot, preset and law of the model.
    pub fitted_with: FittedModel,
    /// What was fitted.
    pub parameters: Vec<FittedParameter>,
    /// Names and values of what was held, in their declared units.
    pub held: Vec<(String, f64)>,
    /// Values, in the units of the parameters.
    pub values: Vec<f64>,
    /// Standard errors, cycles as clusters.
    pub errors: Vec<f64>,
    /// Standard errors as if samples were independent, in the units of the parameters.
    pub white_errors: Vec<f64>,
    /// Number of degrees of freedom of their 95 %.
    pub freedom: f64,
    /// Profiles.
    pub profiles: Vec<Profile>,
    /// Correlations.
    pub correlations: Vec<Vec<f64>>,
    /// Singular values with their directions, of parameters in parts of their sizes.
    pub singular: (Vec<f64>, Vec<Vec<f64>>),
    /// Cost and values of every start.
    pub starts: Vec<Option<Fit>>,
    /// Sum of squares over freedom, a ratio, with the noise of the cycles alone.
    pub chi_squared: f64,
    /// What the model cannot say, in parts of the amplitude, by channel.
    pub discrepancy: Vec<f64>,
    /// The runs.
    pub runs: Vec<FoundRun>,
    /// Rms of runs left out, in the units of the channels.
    pub left_out: Vec<(usize, Vec<f64>)>,
    /// What the runs tell.
    pub information: Information,
    /// Structures of the model, this one first.
    pub rivals: Vec<Rival>,
    /// Candidates for a next run.
    pub next: Vec<NextRun>,
    /// What the model leaves of the runs whose role it is, learned.
    pub residual: Option<LearnedResidual>,
    /// What is odd of the samples.
    pub cautions: Vec<String>,
    /// What is wrong with the data of cases.
    pub findings: Vec<Finding>,
    /// That no run checks the gain of the cell.
    pub unchecked: Option<Warning>,
}

impl CalibrationResult {
    /// Of what was solved.
    pub fn of(
        calibration: &CalibrationFile,
        structure: &ModelStructure,
        runs: &[ObservedCycles],
        solved: &SolvedCalibration,
        information: Information,
        cautions: Vec<String>,
    ) -> Result<Self, Error> {
        let starts: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
        let correlations = solved.correlations();
        let one = |run: usize| -> Result<FoundRun, Error> {
            let observed = runs[run].clone();
            let count = observed.effective();
            let channels = observed.layout.channels;
            let layout = observed.layout;
            let tare = |k: usize, c: usize| match k {
                0 => observed.tare_variance(layout.at(c, 0)),
                k => {
                    let of = |part| 0.5 * observed.tare_variance(layout.at(c, part));
                    of(2 * k - 1) + of(2 * k)
                }
            };
            let one = |k: usize, c: usize| solved.problem.noise[run][k][(c, c)] / count + tare(k, c);
            let of = |k: usize| (0..channels).map(|c| one(k, c)).collect();
            Ok(FoundRun {
                before: solved.problem.model.predict(run, &starts)?,
                after: solved.predicted(run)?,
                behind: solved.left_shift(run)?,
                noise: (0..=observed.layout.harmonics).map(of).collect(),
                observed,
            })
        };
        let own = Rival::of("as calibrated", runs, solved)?;
        let found: Vec<FoundRun> = (0..runs.len()).map(one).collect::<Result<_, _>>()?;
        let said = |run: usize| Ok(found[run].after.cycle.clone());
        let residual = LearnedResidual::of(&structure.model, runs, &solved.values, &said)?;
        Ok(Self {
            name: calibration.spec.name.clone(),
            model: calibration.spec.model.clone(),
            fitted_with: structure.fitted_with(),
            parameters: structure.parameters.clone(),
            held: structure.model.held.clone(),
            values: solved.values.clone(),
            errors: solved.errors(),
            white_errors: solved.white_errors(),
            freedom: solved.covariances.freedom,
            profiles: solved.profiles()?,
            correlations: (0..correlations.nrows())
                .map(|i| correlations.row(i).iter().copied().collect())
                .collect(),
            singular: (solved.covariances.singular_values.clone(), solved.covariances.directions.clone()),
            starts: solved.starts.iter().map(|start| start.fit.clone()).collect(),
            chi_squared: solved.chi_squared,
            discrepancy: solved.problem.discrepancy.clone(),
            runs: found,
            left_out: solved.left_out()?,
            information,
            rivals: vec![own],
            next: Vec::new(),
            residual,
            cautions,
            findings: Vec::new(),
            unchecked: None,
        })
    }

    /// Orders the structures by their error in runs left out.
    pub fn rank_structures(&mut self) {
        wingbeat::math::order::ascend_by(&mut self.rivals, |item| item.left_out_share);
    }

    /// Runs that are only predicted.
    pub fn held_out(&self) -> impl Iterator<Item = &FoundRun> {
        self.runs.iter().filter(|run| run.observed.role == RunRole::HeldOut)
    }

    /// Runs that were fitted.
    pub fn fitted(&self) -> impl Iterator<Item = &FoundRun> {
        self.runs.iter().filter(|run| run.observed.role == RunRole::Fitted)
    }

    /// Numbers of the cycle of run `run` with the learned wrench, in the units of the channels, where it is learned from that
    /// run.
    pub fn with_residual(&self, run: usize) -> Option<&[f64]> {
        let residual = self.residual.as_ref()?;
        let place = residual.runs.iter().position(|(own, _)| *own == run)?;
        Some(&residual.predicted[place])
    }

    /// Names of the channels.
    pub fn channels(&self) -> Vec<String> {
        let layout = self.runs[0].observed.layout;
        (0..layout.channels).map(|channel| channel_name(layout, channel)).collect()
    }

    /// Power of the residuals of the fitted runs over that of the noise in their means, by channel: 1 where nothing but
    /// noise is left, NaN where no run measured it.
    pub fn residual_over_noise(&self) -> Vec<f64> {
        let channel = |channel: usize| {
            let (mut left, mut noise) = (0.0, 0.0);
            if !self.fitted().any(|run| run.observed.is_measured(channel)) {
                return f64::NAN;
            }
            for run in self.fitted().filter(|run| run.observed.is_measured(channel)) {
                left += rms(&run.observed, &run.after.cycle)[channel].powi(2);
                noise += run.noise.iter().map(|by_channel| by_channel[channel]).sum::<f64>();
            }
            left / noise.max(f64::MIN_POSITIVE)
        };
        (0..self.channels().len()).map(channel).collect()
    }

    /// Correlation of what is left of the cycles of the fitted runs with itself one phase on, all channels in deviations of the noise: 0
    /// where nothing but noise is left, near 1 where it is a slow curve of its own. Of the z_p of a channel, its W numbers over their
    /// deviations, at W even phases the correlation is sum z_p^2 cos(2 pi k_p / W) / sum z_p^2 with the harmonic k_p of each; none without
    /// a cycle.
    ///
    /// Equation: calibrate.residual_autocorrelation
    /// `sum z_p^2 cos(2 pi k_p/W) / sum z_p^2, z_p the numbers of the residual over their deviations, k_p their
    /// harmonic`
    /// Source: circular serial correlation of lag 1, Anderson 1942, Ann. Math. Statist. 13; Durbin & Watson 1950.
    /// Test: `what_a_wrong_model_leaves_is_told_from_noise`.
    pub fn residual_autocorrelation(&self) -> Option<f64> {
        let (mut next, mut all) = (0.0, 0.0);
        for run in self.fitted().filter(|run| run.observed.frequency_hz > 0.0) {
            let layout = run.observed.layout;
            let turn = std::f64::consts::TAU / layout.width() as f64;
            for channel in (0..layout.channels).filter(|channel| run.observed.is_measured(*channel)) {
                for part in 0..layout.width() {
                    let (at, k) = (layout.at(channel, part), HarmonicLayout::harmonic(part));
                    let left = run.observed.mean[at] - run.after.cycle[at];
                    let square = left * left / (run.noise[k][channel] + LEAST_NOISE);
                    next += square * (turn * k as f64).cos();
                    all += square;
                }
            }
        }
        (all > 0.0).then(|| next / all)
    }

    /// The label of parameter `k`.
    pub fn label(&self, k: usize) -> Label {
        self.profiles[k].label
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
    /// By phase and channel, in the unit of the channel: measured, before, after, low and high end of the band.
    pub fn curves(&self) -> Vec<Vec<[f64; 5]>> {
        let layout = self.observed.layout;
        let at = |k: usize| {
            let channel = |channel: usize| {
                let of = |cycle: &[f64]| layout.value(cycle, channel, phase_of(k));
                let after = of(&self.after.cycle);
                let half = NORMAL_95 * self.after.deviations[channel][k];
                let mean =
                    if self.observed.is_measured(channel) { of(&self.observed.mean) } else { f64::NAN };
                [mean, of(&self.before), after, after - half, after + half]
            };
            (0..layout.channels).map(channel).collect()
        };
        (0..PHASES).map(at).collect()
    }
}
