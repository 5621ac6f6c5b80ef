//! Values that come again, exactly: codes that stand for samples that are missing, and stretches in which a channel was held.

use super::outliers::{OF_MEDIAN, median};
use super::plateau::{self, Placed};
use super::values::Extent;
use super::{Channel, Finding, Purpose, Series};
use crate::limits::data::{COPIED, COUNTS, LOST, REPEATED, TWICE};

/// Slots by which values are counted, and how often the most frequent value must come beside the next. *Choices.*
const SLOTS: usize = 1 << 11;
const ALONE: f64 = 8.0;
/// Samples in a row from which a value is held; fewer are a code, and fewer still where an instrument may have a dead band. *Choices.*
const HELD: usize = 8;
const CODE: usize = 4;
/// Part of a channel's range by which it leaps to where it is held, or from there. *Choice.*
const LEAPS: f64 = 0.2;
/// Steps of the converter that are no leap. *Choice.*
const STEPS: f64 = 4.0;
/// Part of a channel's range by which a code is off the samples beside it. *Choice.*
const APART: f64 = 0.05;
/// Part by which rests of a motion differ in distance and length. *Choice.*
const EVEN: f64 = 0.1;
/// Share of a channel above which a value that is held is how it is sampled. *Choice.*
const SAMPLED: f64 = 0.5;

/// The findings of a channel that moves.
pub(super) fn findings(series: &Series, channel: &Channel, extent: Extent) -> Vec<Finding> {
    if extent.range() < COUNTS.value * extent.count {
        return Vec::new();
    }
    code(series, channel, extent).into_iter().chain(held(series, channel, extent)).collect()
}

/// The finding that one value comes again and again by itself though others hardly do: what a logger writes for a sample that it lacks.
fn code(series: &Series, channel: &Channel, extent: Extent) -> Option<Finding> {
    let slot = |x: &f64| (x.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 53) as usize;
    let mut counts = vec![0_u32; SLOTS];
    channel.samples.iter().for_each(|x| counts[slot(x)] += 1);
    let most = (0..SLOTS).max_by_key(|k| counts[*k])?;
    let next = (0..SLOTS).filter(|k| *k != most).map(|k| counts[k]).max()?;
    let share = f64::from(counts[most]) / channel.samples.len() as f64;
    if share < REPEATED.value || f64::from(counts[most]) < ALONE * f64::from(next) {
        return None;
    }
    let value = *channel.samples.iter().find(|x| slot(x) == most)?;
    // Where an instrument may have a dead band, its value comes in runs, and what lies beside it is near.
    let near = near(channel.samples, value) / extent.range();
    let longest = if near > BAND { HELD } else { CODE };
    let runs = channel.samples.chunk_by(|a, b| a == b).filter(|run| run[0] == value && run.len() < longest);
    let size = runs.map(<[f64]>::len).sum::<usize>() as f64 / channel.samples.len() as f64;
    if near < APART || dead_band(channel.samples, value, extent) {
        return None;
    }
    let text = format!(
        "{:.1} % of the samples are {value} {} exactly, here and there, and hardly another value comes twice: it stands for samples that \
         are missing; cut them out of the file",
        100.0 * size,
        channel.unit
    );
    Some(Finding::new("data.outliers", &REPEATED, series.about(channel.name), size, text))
}

/// Width to either side of a dead band, in parts of a channel's range, at most, and samples in the stretch of that width beyond it, over
/// those that read its value, at least; some lie on either side. *Choices.*
const BAND: f64 = 0.15;
const BESIDE: f64 = 0.25;

/// Whether `value` is what an instrument with a dead band reads all about it: no sample lies nearer to it than the width of the band, and as
/// far again beyond that many do, on either side. About a code lie samples at any distance, or none.
pub(super) fn dead_band(samples: &[f64], value: f64, extent: Extent) -> bool {
    let off = || samples.iter().map(|x| x - value).filter(|off| *off != 0.0);
    let width = off().fold(f64::INFINITY, |least, off| least.min(off.abs()));
    let beyond = off().filter(|off| off.abs() <= 2.0 * width);
    let (above, below) = beyond.fold((0, 0), |(a, b), off| if off > 0.0 { (a + 1, b) } else { (a, b + 1) });
    let there = samples.len() - off().count();
    let both = above.min(below) > 0 && f64::from(above + below) > BESIDE * there as f64;
    width < BAND * extent.range() && both
}

/// Samples of a stretch that is sought again, stretches of a file, and parts of a cycle after which loads without noise have it again.
/// *Choices.*
const STRETCH: usize = 32;
const STRETCHES: usize = 8;
const NEXT: f64 = 1.2;
/// Part of a cycle by which a copy lies off whole cycles, after which loads without noise come again if the rate is no multiple of their
/// frequency. *Choice.*
const OFF_WHOLE: f64 = 0.01;

/// The finding that stretches come again sample by sample: a buffer that was written twice, a file that was glued of copies. A load without
/// noise is the same after whole cycles, and so is one of few counts.
pub(super) fn copied(series: &Series, extents: &[Option<Extent>], placed: &Placed) -> Option<Finding> {
    let moves = |of: &[f64]| of.windows(2).all(|pair| pair[0] != pair[1]);
    let (mut again, mut after, count) = (0, 0, series.phase.len());
    if count < 2 * STRETCHES * STRETCH {
        return None;
    }
    let (channel, extent) = series
        .channels
        .iter()
        .zip(extents)
        .filter_map(|(channel, extent)| Some((channel, (*extent)?)))
        .find(|(channel, _)| moves(&channel.samples[..STRETCH]))?;
    let mut noisy = None;
    for k in 0..STRETCHES {
        let from = k * (count - STRETCH) / STRETCHES;
        let [here, later] = [&channel.samples[from..from + STRETCH], &channel.samples[from + STRETCH..]];
        let same = |at: &usize| later[*at] == here[0] && later[*at..].starts_with(here);
        let found = (0..later.len()).find(same).filter(|_| moves(here));
        let apart = |at: usize| series.phase[from + STRETCH + at] - series.phase[from];
        let Some(at) = found else { continue };
        let noisy = *noisy.get_or_insert_with(|| is_noisy(channel, extent, placed));
        let whole = apart(at) < NEXT || (apart(at) - apart(at).round()).abs() < OFF_WHOLE;
        if noisy || !whole {
            (again, after) = (again + 1, STRETCH + at);
        }
    }
    let limit = if noisy == Some(true) { &TWICE } else { &COPIED };
    let size = f64::from(again) / STRETCHES as f64;
    let text = format!(
        "{again} of {STRETCHES} stretches come again sample by sample, {after} samples later: a buffer that was written twice, or a file \
         that was glued of copies"
    );
    Some(Finding::new("data.copied", limit, series.about(channel.name), size, text).in_channel(channel.name))
}

/// Part of the range and counts of the converter that its noise has at least for a stretch never to come again. *Choices.*
const NOISE: [f64; 2] = [0.002, 2.0];
/// Deviation of the third differences of white noise over that of the noise, sqrt(1 + 9 + 9 + 1).
const OF_THIRD: f64 = 4.472_135_954_999_58;

/// Whether the samples of one phase differ by noise.
fn is_noisy(channel: &Channel, extent: Extent, placed: &Placed) -> bool {
    let noise = placed.of(channel.samples).and_then(|places| plateau::noise(&places));
    // Loads without noise scatter within a place by their bends, but not from one sample to the next.
    let third = channel.samples.windows(4).map(|of| (of[3] - of[0] - 3.0 * (of[2] - of[1])).abs());
    let at_once = || OF_MEDIAN * median(&mut third.collect::<Vec<f64>>()) / OF_THIRD;
    let least = (NOISE[0] * extent.range()).max(NOISE[1] * extent.count);
    noise.is_some_and(|noise| noise > least) && at_once() > least
}

/// Median of what the samples beside those of `value` are off it: little where an instrument has a dead band about it.
fn near(samples: &[f64], value: f64) -> f64 {
    let beside = samples.windows(2).filter(|pair| (pair[0] == value) != (pair[1] == value));
    let mut off: Vec<f64> = beside.map(|pair| (pair[1] - pair[0]).abs()).collect();
    wingbeat_math::order::ascend(&mut off);
    off.get(off.len() / 2).copied().unwrap_or(0.0)
}

/// Whether stretches, each by its begin and length, come as evenly as a motion that rests in every cycle.
fn even(stretches: &[(usize, usize)]) -> bool {
    let apart = stretches.windows(2).map(|pair| (pair[1].0 - pair[0].0) as f64);
    let lengths = stretches.iter().map(|(_, length)| *length as f64);
    let spread = |of: &mut dyn Iterator<Item = f64>| {
        let (low, high) = of.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        (high - low) / high
    };
    stretches.len() > 2 && spread(&mut apart.into_iter()) < EVEN && spread(&mut lengths.into_iter()) < EVEN
}

/// The finding that a channel leaps to a value, or from it, and keeps it exactly meanwhile.
fn held(series: &Series, channel: &Channel, extent: Extent) -> Option<Finding> {
    let samples = channel.samples;
    // Of few counts each is a leap.
    let least = (LEAPS * extent.range()).max(STEPS * extent.count);
    let leap = |k: usize| k > 0 && k < samples.len() && (samples[k] - samples[k - 1]).abs() > least;
    let (mut lost, mut kept, mut begin) = (Vec::new(), 0, 0);
    for run in samples.chunk_by(|a, b| a == b) {
        let end = begin + run.len();
        kept += if run.len() >= HELD { run.len() } else { 0 };
        if run.len() >= HELD && (leap(begin) || leap(end)) {
            lost.push((begin, run.len()));
        }
        begin = end;
    }
    let share = |of: usize| of as f64 / samples.len() as f64;
    let (times, all) = (lost.len(), lost.iter().map(|(_, length)| length).sum());
    let text = format!(
        "leaps and keeps its value {times} times, for {:.1} % of the samples: it was held, or blanked; leave those parts out",
        100.0 * share(all)
    );
    // A motion may rest in every cycle.
    let rests = series.purpose == Purpose::Motion && even(&lost);
    (share(kept) < SAMPLED && times > 1 && !rests)
        .then(|| Finding::new("data.stuck", &LOST, series.about(channel.name), share(all), text))
}
