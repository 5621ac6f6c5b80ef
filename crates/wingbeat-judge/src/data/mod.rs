//! What measured data say of themselves, and against what is computed: pure functions over channels.
//!
//! [`find_frequency`] tells the frequency of samples of which none is known, [`examined`] looks at the samples of a file,
//! [`compared`] at mean cycles beside those of a model.
//!
//! ```
//! use wingbeat_judge::data::{MeasuredChannel, Purpose, Series, examined};
//! use wingbeat_judge::{Judge, RunLimits, Status};
//!
//! let phase: Vec<f64> = (0..2000).map(|k| f64::from(k) / 200.0).collect();
//! let lift: Vec<f64> = phase.iter().map(|p| (6.5 * p).sin()).collect();
//! let channels = vec![MeasuredChannel { name: "Fz", unit: "N", samples: &lift }];
//! let series = Series { what: "pass1.csv", phase: &phase, frequency_hz: Some(5.0), channels, purpose: Purpose::Loads };
//!
//! let limits = RunLimits::default();
//! let mut judge = Judge::new(&limits);
//! for finding in examined(&series, &limits) {
//!     finding.put(&mut judge);
//! }
//! let verdict = judge.verdict();
//! assert_eq!(verdict.status, Status::SuspectData);
//! assert!(verdict.warnings[0].text.contains("5.17"), "{}", verdict.warnings[0].text);
//! ```

mod averaged;
mod backwards;
mod cycle;
mod ends;
mod finding;
mod frequency;
mod leaps;
mod lines;
mod noise;
mod outliers;
mod plateau;
mod rectified;
mod reference;
mod rest;
mod same;
mod spread;
mod strokes;
mod time;
mod values;

pub use averaged::AveragedFile;
pub use finding::Finding;
pub use frequency::{Frequency, estimate};
pub use lines::{SpectralLine, find_frequency};
pub use reference::{CyclePair, compared, mean_apart, reversed_among};
pub use rest::{mean, rest_scatter};

use crate::limits::RunLimits;
use crate::unit;

/// What the channels are, and what they are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Forces and moments, which follow a stroke, to be averaged as they are.
    Loads,
    /// The same, whose mean cycle stands for a steady case: it is held beside a model, or one is fitted to it.
    Datum,
    /// A prescribed motion, which may stop and stay, and is differentiated twice.
    Motion,
}

/// What may explain a finding, so that the samples are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// The wings rest, start, or change their strokes.
    Strokes,
    /// A knock comes in most cycles, at one phase of them.
    Knock,
    /// A motion meets a stop, and stays there.
    Stop,
    /// A motion is flown again, step by step.
    Again,
}

impl Purpose {
    /// Whether the channels are forces and moments.
    fn is_loads(self) -> bool {
        self != Self::Motion
    }

    /// Which findings are noted, as the samples are right and serve the purpose; the others refuse the data.
    fn allows(self, cause: Cause) -> bool {
        match cause {
            Cause::Strokes | Cause::Knock => self == Self::Loads,
            Cause::Stop | Cause::Again => self == Self::Motion,
        }
    }
}

/// A measured channel.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredChannel<'a> {
    /// What the file or its reader calls it.
    pub name: &'a str,
    /// Unit, for words.
    pub unit: &'a str,
    /// Its samples, in its unit.
    pub samples: &'a [f64],
}

/// Channels that were sampled together.
#[derive(Clone, Debug)]
pub struct Series<'a> {
    /// The file, or the key that names it.
    pub what: &'a str,
    /// When, in cycles of the frequency that is given for them.
    pub phase: &'a [f64],
    /// That frequency, for words; none of a table by phase.
    pub frequency_hz: Option<f64>,
    /// The channels, each as long as `phase`.
    pub channels: Vec<MeasuredChannel<'a>>,
    /// What they are.
    pub purpose: Purpose,
}

impl Series<'_> {
    /// Cycles from the first sample to the last.
    fn cycles(&self) -> f64 {
        match self.phase {
            [first, .., last] => last - first,
            _ => 0.0,
        }
    }

    /// Whether a channel is a force or a moment, or may be, as none of the file is known to be.
    fn is_load(&self, channel: &MeasuredChannel) -> bool {
        let known = |channel: &MeasuredChannel| unit::is_load(channel.name, channel.unit);
        known(channel) || !self.channels.iter().any(known)
    }

    /// A finding about one channel.
    fn about(&self, channel: &str) -> String {
        if channel.is_empty() { self.what.into() } else { format!("{channel} of {}", self.what) }
    }
}

/// What is wrong with the samples, the channels in their order.
pub fn examined(series: &Series, limits: &RunLimits) -> Vec<Finding> {
    let mut found = time::findings(series);
    // A gap that is small leaves the rest to be judged.
    if !found.iter().any(|finding| finding.breaks(limits)) {
        let extents: Vec<Option<values::Extent>> =
            series.channels.iter().map(|channel| values::Extent::of(channel.samples)).collect();
        found.extend(values::findings(series, &extents, limits));
        found.extend(outliers::findings(series, &extents, limits));
        found.extend(cycle::findings(series, limits));
        found.extend(outliers::equals(series));
    }
    found.retain(|finding| finding.breaks(limits));
    alike(series, found)
}

/// Which channels of forces and moments, as their instrument gave them, have too few counts: once they are turned, moved or filtered they no
/// longer tell.
pub fn of_few_counts(series: &Series, limits: &RunLimits) -> Vec<Finding> {
    let extents: Vec<Option<values::Extent>> =
        series.channels.iter().map(|channel| values::Extent::of(channel.samples)).collect();
    let found = values::coarse(series, &extents).into_iter();
    found.filter(|finding| finding.breaks(limits)).collect()
}

/// Which channels of forces and moments, as their instrument gave them, are cut off: less a drift, turned or moved they are flat no more.
pub fn cut_off(series: &Series, limits: &RunLimits) -> Vec<Finding> {
    let extents: Vec<Option<values::Extent>> =
        series.channels.iter().map(|channel| values::Extent::of(channel.samples)).collect();
    values::cut_off(series, &extents, limits)
}

/// One finding of a frequency that several channels have: it is that of the file.
fn alike(series: &Series, found: Vec<Finding>) -> Vec<Finding> {
    let mut told: Vec<Finding> = Vec::new();
    for finding in found {
        let same = |other: &&mut Finding| {
            ["data.frequency", "data.runs_away"].contains(&other.id)
                && finding.id == other.id
                && near(other.size, finding.size)
        };
        match told.iter_mut().find(same) {
            Some(first) => {
                let channel = format!("{}, {}", first.channel, finding.channel);
                let about = series.about(&channel);
                // Of several the one with the smallest error is told.
                let best = if finding.certain > first.certain { finding } else { first.clone() };
                *first = Finding { channel, about, ..best };
            }
            None => told.push(finding),
        }
    }
    told
}

/// Whether two differences of a frequency from the one given are one. *Choice.*
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 0.05 * a.max(b)
}

/// What is wrong with a channel that has values that are no numbers beside the `missing` samples of a file with gaps.
pub fn not_finite(what: &str, channel: &MeasuredChannel, missing: usize) -> Option<Finding> {
    let samples = channel.samples.iter().filter(|x| !x.is_finite()).count().saturating_sub(missing);
    values::not_finite(what, channel.name, samples)
}
