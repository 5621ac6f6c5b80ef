//! What a file says of itself that is averaged over the cycles of its wings.

use super::{Finding, MeasuredChannel, Purpose, Series, SpectralLine, examined, not_finite};
use crate::limits::RunLimits;
use crate::limits::data::{CYCLES_LOST, FEW_CYCLES_LOST, LINE, LOST, OF_LINE, REST};
use crate::{Judge, Status, Verdict, Warning};

/// A file of loads, and how it was averaged.
#[derive(Clone, Debug)]
pub struct AveragedFile<'a> {
    /// Its name.
    pub file: &'a str,
    /// Time of each sample, s.
    pub time: &'a [f64],
    /// The channels, each as long as `time`; samples that are missing are not-a-number.
    pub channels: Vec<MeasuredChannel<'a>>,
    /// Samples that are missing between the first and the last.
    pub missing: usize,
    /// Samples per second, Hz.
    pub rate: f64,
    /// The rate by the file's own times, Hz, where another one is given.
    pub other_rate: Option<f64>,
    /// The frequency of its cycles, Hz; none where none was given and the data have none.
    pub frequency: Option<f64>,
    /// The line that was found where none was given.
    pub line: Option<SpectralLine>,
    /// Scatter at rest over that of what follows, where a rest is subtracted; infinite where no load changes behind it.
    pub rest_scatter: Option<f64>,
    /// Largest share of the cycles of a channel that is left out, dimensionless.
    pub left_out: Option<f64>,
}

/// Samples of a period of the strongest line below which its frequency may be another one. *Choice.*
const FEWEST: f64 = 4.0;

/// What mends gaps in the times.
const OF_ROWS: &str = "(by the times of the file; --rate HZ takes the rows at even steps instead)";

impl AveragedFile<'_> {
    /// What the samples say of themselves. Those that are missing are gaps.
    pub fn verdict(&self, limits: &RunLimits) -> Verdict {
        let mut judge = Judge::new(limits);
        let findings =
            [Self::gaps, Self::rest, Self::noise, Self::aliasing, Self::pace, Self::infinities, Self::cycles];
        findings.into_iter().for_each(|find| find(self, limits, &mut judge));
        judge.verdict()
    }

    fn gaps(&self, _: &RunLimits, judge: &mut Judge) {
        if let Some(share) = self.left_out.filter(|_| self.missing > 0) {
            judge.hold_about(&CYCLES_LOST, share, OF_ROWS);
            judge.hold_about(&FEW_CYCLES_LOST, share, OF_ROWS);
        }
    }

    /// A channel that is quiet at rest tells whether it was one: others may be noise throughout.
    fn rest(&self, _: &RunLimits, judge: &mut Judge) {
        let Some(scatter) = self.rest_scatter else { return };
        if scatter.is_infinite() {
            let text = "no load changes behind the rest that --rest takes: nothing was measured, or the column is another one";
            return judge.find(Status::SuspectData, text);
        }
        judge.hold_about(&REST, scatter, "(the wings move there, or the loads are noise; --rest)");
    }

    fn noise(&self, limits: &RunLimits, judge: &mut Judge) {
        let Some(SpectralLine { frequency, over_noise, .. }) = self.line else { return };
        judge.hold(&LINE, over_noise);
        if frequency.is_some() {
            return;
        }
        let text = format!(
            "{}: no channel has a load that repeats: noise, or less than four cycles; give the frequency with \
             --frequency HZ if you know it",
            self.file
        );
        judge.warn(Warning::new("data.noise", text).size(over_noise));
        let lines = "lines stand above the noise, but no channel repeats at one frequency: too short a file, a frequency that \
                     changes, or a jump of phase";
        if over_noise >= limits.of(&LINE).0 {
            judge.find(Status::NotFound, lines);
        }
    }

    fn aliasing(&self, _: &RunLimits, judge: &mut Judge) {
        let Some(SpectralLine { frequency: Some(_), strongest, .. }) = self.line else { return };
        let rate = self.rate;
        if rate < FEWEST * strongest {
            let size = rate / strongest;
            let text = format!(
                "{size:.2} samples a period of the strongest line: at {rate:.6} Hz a frequency of {:.6} Hz looks the same; sample \
                 faster, or give --frequency HZ",
                rate - strongest
            );
            judge.warn(Warning::new("data.aliased", text).size(size).key("--frequency"));
            judge.hold(&OF_LINE, size);
        }
    }

    fn pace(&self, _: &RunLimits, judge: &mut Judge) {
        if let Some(own) = self.other_rate {
            let text =
                format!("--rate {} was followed; by its own times {} has {own:.6} Hz", self.rate, self.file);
            judge.warn(Warning::new("data.rate", text).size(own).key("--rate"));
        }
    }

    fn infinities(&self, _: &RunLimits, judge: &mut Judge) {
        self.channels
            .iter()
            .filter_map(|channel| self.not_finite(channel))
            .for_each(|found| found.put(judge));
    }

    /// What is wrong with a channel that has values that are no numbers, beside the samples that are missing.
    fn not_finite(&self, channel: &MeasuredChannel) -> Option<Finding> {
        not_finite(self.file, channel, self.missing)
    }

    /// Without a frequency there is no cycle to judge by.
    fn cycles(&self, limits: &RunLimits, judge: &mut Judge) {
        let Some(frequency) = self.frequency else { return };
        let count = self.time.len();
        let numbers = self.channels.iter().filter(|channel| self.not_finite(channel).is_none());
        let all: Vec<&MeasuredChannel> = numbers.collect();
        let whole = |row: &usize| all.iter().all(|channel| channel.samples[*row].is_finite());
        let whole: Vec<usize> = (0..count).filter(whole).collect();
        let kept = |of: &[f64]| whole.iter().map(|row| of[*row]).collect::<Vec<f64>>();
        let phase: Vec<f64> = kept(self.time).iter().map(|t| frequency * t).collect();
        let samples: Vec<Vec<f64>> = all.iter().map(|channel| kept(channel.samples)).collect();
        let channels =
            all.iter().zip(&samples).map(|(channel, samples)| MeasuredChannel { samples, ..**channel });
        let series = Series {
            what: self.file,
            phase: &phase,
            frequency_hz: Some(frequency),
            channels: channels.collect(),
            purpose: Purpose::Loads,
        };
        let found = examined(&series, limits);
        if self.missing > 0 && !found.iter().any(|finding| finding.limit.id == LOST.id) {
            let is_missing = |row: &usize| self.channels.iter().all(|of| !of.samples[*row].is_finite());
            let missing = (0..count).filter(is_missing).count();
            judge.hold_about(&LOST, missing as f64 / count as f64, OF_ROWS);
        }
        let none = found.iter().find(|finding| !finding.serious && finding.has_no_mean_cycle(limits));
        if let Some(finding) = none {
            let why = "leave a rest at the start out by --rest SECONDS";
            judge.find(Status::NotPeriodic, format!("{}; {why}", finding.words()));
        }
        for finding in found {
            let key = (finding.id == "data.frequency").then(|| "--frequency".to_owned());
            finding.mended_by(key).put(judge);
        }
    }
}
