//! The verdict on a fit.

use crate::Label;
use crate::found::{CalibrationResult, FoundRun};
use crate::measured::{PhaseShift, shift, variation};
use crate::problem::group;
use crate::solve::rms;
use std::ops::Range;
use wingbeat::judge::limits::calibration;
use wingbeat::judge::{Judge, RunLimits, Verdict, Warning};

/// Power of the residuals of a channel over that of the noise above which noise alone does not make them. *Choice.*
const MISSED: f64 = 9.0;
/// Smallest correlation, once shifted, at which a shift means something. *Choice.*
const ALIKE: f64 = 0.8;
/// Smallest gain of the correlation by the shift, in parts of what the measured cycle itself loses by it. *Choice.*
const GAINED: f64 = 0.5;
/// Relative scatter of the cycles below which they repeat to the last digits of their file. *Choice.*
const REPEATS: f64 = 1e-12;

impl CalibrationResult {
    /// Judges the fit by `limits`; findings about the data come first.
    pub fn verdict(&self, limits: &RunLimits) -> Verdict {
        let mut judge = Judge::new(limits);
        self.findings.iter().cloned().for_each(|finding| finding.put(&mut judge));
        self.unchecked.iter().cloned().for_each(|warning| judge.warn(warning));
        for (name, share) in self.explained() {
            judge.hold_about(&calibration::EXPLAINED, share, &format!("in the {name}"));
            judge.hold_about(&calibration::MODEL_ERROR, share, &format!("in the {name}"));
        }
        if let Some((growth, name)) = self.most_grown() {
            judge.hold_about(&calibration::WORSE, growth, &format!("of {name}"));
            judge.hold_about(&calibration::WORSE_TOLD, growth, &format!("of {name}"));
        }
        judge.hold(&calibration::CHI_SQUARED, self.chi_squared);
        judge.hold(&calibration::BEYOND_NOISE, self.chi_squared);
        judge.hold(&calibration::WRONG_MODEL, self.chi_squared);
        for run in self.fitted() {
            if let Some(by) = run.left_shift() {
                judge.hold_about(
                    &calibration::PHASE,
                    by.to_degrees().abs(),
                    &format!("of {}", run.observed.name),
                );
            }
            if let Some([by, error]) = run.behind {
                let side = if by > 0.0 { "behind" } else { "ahead" };
                let about = format!(
                    "of {}, {:.2} +- {:.2} deg {side},",
                    run.observed.name,
                    by.abs().to_degrees(),
                    error.to_degrees()
                );
                let errors = (by / error).abs();
                judge.hold_about(&calibration::LATE, errors, &about);
                if errors > limits.of(&calibration::LATE).0 {
                    judge.hold_about(&calibration::LEFT, by.abs().to_degrees(), &about);
                }
            }
        }
        judge.hold_if(&calibration::COLOURED, self.residual_autocorrelation());
        if let Some((share, name)) = self.most_reversed() {
            judge.hold_about(&calibration::REVERSED, share, &format!("of {name}"));
        }
        self.judge_parameters(&mut judge);
        judge.verdict()
    }

    /// Names of forces and moments with the share of their variation that the fit explains; only those that vary by measurement
    /// or by the model.
    fn explained(&self) -> Vec<(&'static str, f64)> {
        let of = |(name, channels): (&'static str, Range<usize>)| {
            let (mut left, mut all, mut said) = (0.0, 0.0, 0.0);
            for run in self.fitted().filter(|run| run.observed.frequency_hz > 0.0) {
                let (layout, measured) = (run.observed.layout, &run.observed.mean);
                let apart: Vec<f64> = run.after.cycle.iter().zip(measured).map(|(a, b)| a - b).collect();
                for channel in channels.clone().filter(|channel| run.observed.is_measured(*channel)) {
                    left += variation(layout, &apart, channel);
                    all += variation(layout, measured, channel);
                    said += variation(layout, &run.after.cycle, channel);
                }
            }
            (said > 0.0 || all > 0.0).then(|| (name, 1.0 - left / all))
        };
        let layout = self.runs[0].observed.layout;
        let names: &[&'static str] = if layout.channels == 6 { &["forces", "moments"] } else { &["loads"] };
        let groups = names.iter().enumerate().map(|(i, name)| match layout.channels {
            6 => (*name, group(layout, 3 * i)),
            channels => (*name, 0..channels),
        });
        groups.filter_map(of).collect()
    }

    /// The channel whose residuals are most times what they were before the fit, and how many times.
    fn most_grown(&self) -> Option<(f64, String)> {
        let grown = self.channels().into_iter().enumerate().map(|(channel, name)| {
            let [before, after] = self.residuals(channel);
            (after / before, name)
        });
        grown.filter(|(growth, _)| growth.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The channel that is missed beyond the noise whose residuals lose most if its sign is the other one, and what share is left of them.
    fn most_reversed(&self) -> Option<(f64, String)> {
        let missed = self.residual_over_noise();
        let channels = self.channels().into_iter().enumerate().filter(|(k, _)| missed[*k] > MISSED);
        let shares = channels.map(|(channel, name)| {
            let power = |sign: f64| -> f64 {
                let of = |run: &FoundRun| {
                    let cycle: Vec<f64> = run.after.cycle.iter().map(|load| sign * load).collect();
                    rms(&run.observed, &cycle)[channel].powi(2)
                };
                self.fitted().filter(|run| run.observed.is_measured(channel)).map(of).sum()
            };
            (power(-1.0) / power(1.0), name)
        });
        shares.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn judge_parameters(&self, judge: &mut Judge) {
        let known = (0..self.values.len()).filter(|k| self.label(*k) == Label::Identified).count();
        judge.hold(&calibration::IDENTIFIED, known as f64 / self.values.len() as f64);
        for (k, parameter) in self.parameters.iter().enumerate() {
            let (name, value) = (&parameter.name, self.values[k]);
            if value <= parameter.low || value >= parameter.high {
                let text = format!(
                    "{name} = {value} is at its bound: the fit would leave it, so the value is the bound's"
                );
                judge.warn(
                    Warning::new("calibration.at_bound", text).size(value).key(format!("parameters[{k}]")),
                );
            }
            if self.label(k) != Label::Identified {
                let text = format!(
                    "{name} is not identified: its profile is {}; hold it or add runs",
                    self.label(k).word()
                );
                judge.warn(
                    Warning::new("calibration.not_identified", text).key(format!("parameters[{k}].held")),
                );
            }
            if !(self.white_errors[k] > REPEATS * parameter.scale().abs()) {
                let text = format!(
                    "the samples show no noise of their own: the error (white) of {name} means nothing"
                );
                judge.warn(Warning::new("calibration.no_noise", text).size(self.white_errors[k]));
            }
        }
        if let Some((largest, i, j)) = self.closest() {
            let pair = format!("({} and {})", self.parameters[i].name, self.parameters[j].name);
            judge.hold_about(&calibration::CORRELATION, largest, &pair);
        }
    }

    /// The largest |correlation| of two parameters, and which.
    fn closest(&self) -> Option<(f64, usize, usize)> {
        let pairs = (0..self.values.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        pairs.map(|(i, j)| (self.correlations[i][j].abs(), j, i)).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl FoundRun {
    /// The shift between the measured and the fitted cycle, rad, where they are alike once it is taken off.
    fn left_shift(&self) -> Option<f64> {
        if self.observed.frequency_hz <= 0.0 {
            return None;
        }
        let PhaseShift { by, correlation: [now, then], own_loss } =
            shift(self.observed.layout, &self.observed.mean, &self.after.cycle);
        let believed = then > ALIKE && then - now >= GAINED * own_loss;
        believed.then_some(by)
    }
}
