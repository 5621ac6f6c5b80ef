//! Values that come again, exactly: codes that stand for samples that are missing, and stretches in which a channel was held.

use super::values::Extent;
use super::{Channel, Finding, Series};
use crate::limits::data::{COUNTS, LOST, REPEATED};

/// Slots by which values are counted, and how often the most frequent value must come beside the next. *Choices.*
const SLOTS: usize = 1 << 10;
const ALONE: f64 = 8.0;
/// Samples in a row up to which a value is a code, and from which it is held. *Choices.*
const CODE: usize = 4;
const HELD: usize = 8;
/// Part of a channel's range by which it leaps to where it is held, or from there. *Choice.*
const LEAPS: f64 = 0.2;
/// Share of a channel above which a value that is held is how it is sampled. *Choice.*
const SAMPLED: f64 = 0.5;

/// The findings of a channel that moves.
pub(super) fn findings(series: &Series, channel: &Channel, extent: Extent) -> Vec<Finding> {
    if extent.range() < COUNTS.value * extent.count {
        return Vec::new();
    }
    code(series, channel).into_iter().chain(held(series, channel, extent)).collect()
}

/// The finding that one value comes again and again by itself though others hardly do: what a logger writes for a sample that it lacks.
fn code(series: &Series, channel: &Channel) -> Option<Finding> {
    let slot = |x: &f64| (x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 54) as usize;
    let mut counts = vec![0_u32; SLOTS];
    channel.samples.iter().for_each(|x| counts[slot(x)] += 1);
    let most = (0..SLOTS).max_by_key(|k| counts[*k])?;
    let next = (0..SLOTS).filter(|k| *k != most).map(|k| counts[k]).max()?;
    let share = f64::from(counts[most]) / channel.samples.len() as f64;
    if share < REPEATED.value || f64::from(counts[most]) < ALONE * f64::from(next) {
        return None;
    }
    let value = *channel.samples.iter().find(|x| slot(x) == most)?;
    let runs = channel.samples.chunk_by(|a, b| a == b).filter(|run| run[0] == value && run.len() < CODE);
    let size = runs.map(<[f64]>::len).sum::<usize>() as f64 / channel.samples.len() as f64;
    let text = format!(
        "{:.1} % of the samples are {value} {} exactly, here and there, and hardly another value comes twice: it stands for samples that \
         are missing; cut them out of the file",
        100.0 * size,
        channel.unit
    );
    Some(Finding::new("data.outliers", &REPEATED, series.about(channel.name), size, text))
}

/// The finding that a channel leaps to a value, or from it, and keeps it exactly meanwhile.
fn held(series: &Series, channel: &Channel, extent: Extent) -> Option<Finding> {
    let samples = channel.samples;
    let leap =
        |k: usize| k > 0 && k < samples.len() && (samples[k] - samples[k - 1]).abs() > LEAPS * extent.range();
    let (mut lost, mut times, mut kept, mut begin) = (0, 0, 0, 0);
    for run in samples.chunk_by(|a, b| a == b) {
        let end = begin + run.len();
        kept += if run.len() >= HELD { run.len() } else { 0 };
        if run.len() >= HELD && (leap(begin) || leap(end)) {
            (lost, times) = (lost + run.len(), times + 1);
        }
        begin = end;
    }
    let share = |of: usize| of as f64 / samples.len() as f64;
    let text = format!(
        "leaps and keeps its value {times} times, for {:.1} % of the samples: it was held, or blanked; leave those parts out",
        100.0 * share(lost)
    );
    (share(kept) < SAMPLED && times > 1)
        .then(|| Finding::new("data.stuck", &LOST, series.about(channel.name), share(lost), text))
}
