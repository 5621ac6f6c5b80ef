//! Values that come again, exactly: codes that stand for samples that are missing, and stretches in which a channel was held.

use std::f64::consts::TAU;

use super::noise::{deviation, third};
use super::outliers::steps_beyond;
use super::plateau::{self, PlacedSamples};
use super::values::Extent;
use super::{Finding, MeasuredChannel, Series};
use crate::limits::data::{COPIED, COUNTS, LOST, REPEATED, TWICE};

/// Slots by which values are counted, and how often the most frequent value must come beside the next. *Choices.*
const SLOTS: usize = 1 << 11;
const ALONE: f64 = 8.0;
/// Samples in a row from which a value is held; fewer are a code, and fewer still where an instrument may have a dead band. *Choices.*
const HELD: usize = 8;
const CODE: usize = 4;
/// Part of a channel's range by which it leaps to where it stands still, or from there. *Choice.*
pub(super) const TO_REST: f64 = 0.2;
/// Steps of the converter that are no leap. *Choice.*
const STEPS: f64 = 4.0;
/// Part of a channel's range by which a code is off the samples beside it. *Choice.*
const APART: f64 = 0.05;
/// Part by which rests of a motion differ in distance and length. *Choice.*
const EVEN: f64 = 0.1;
/// Share of a channel above which a value that is held is how it is sampled. *Choice.*
const SAMPLED: f64 = 0.5;

/// The findings of a channel that moves.
pub(super) fn findings(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Vec<Finding> {
    if extent.range() < COUNTS.value * extent.count {
        return Vec::new();
    }
    let code = code(series, channel, extent).or_else(|| code_within(series, channel, extent));
    code.into_iter().chain(held(series, channel, extent)).collect()
}

/// Share of the leaps that go to one value, and length of the mean of the unit vectors of their phases below which they come at any
/// phase: of 26 at random phases it is 0.2, in a half of the cycle 0.64. *Choices.*
const MOSTLY: f64 = 0.5;
const ANY_PHASE: f64 = 0.9;

/// The same of a code within the range, which samples may have by themselves: a channel leaps to one value, stays for less than
/// [`CODE`] samples, and leaps back, at any phase. A knock comes at one phase, and spikes have no value of their own.
fn code_within(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let samples = channel.samples;
    let least = (APART * extent.range()).max(STEPS * extent.count);
    let far = steps_beyond(samples, least);
    let many = REPEATED.value / CODE as f64 * samples.len() as f64;
    if (far as f64) < 2.0 * many.max(FEWEST as f64) || far as f64 > NOISY * samples.len() as f64 {
        return None;
    }
    let mut leaps: Vec<(f64, f64, usize)> = Vec::new();
    let mut begin = 0;
    for end in 1..samples.len() {
        let back = samples[end] - samples[end - 1];
        if back == 0.0 {
            continue;
        }
        if begin > 0 && back.abs() > least {
            let to = samples[begin] - samples[begin - 1];
            if to.abs() > least && to * back < 0.0 && end - begin < CODE {
                leaps.push((samples[begin], series.phase[begin], end - begin));
            }
        }
        begin = end;
    }
    if (leaps.len() as f64) < many {
        return None;
    }
    let all = leaps.len() as f64;
    wingbeat_math::order::ascend_by(&mut leaps, |leap| leap.0);
    let own = leaps.chunk_by(|a, b| a.0 == b.0).max_by_key(|of| of.len())?;
    let (sin, cos) =
        own.iter().map(|leap| (TAU * leap.1).sin_cos()).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let together = f64::hypot(sin, cos) / own.len() as f64;
    let size = own.iter().map(|leap| leap.2).sum::<usize>() as f64 / samples.len() as f64;
    let text = format!(
        "leaps to {} {} and back {} times, at any phase, for {:.1} % of the samples: it stands for samples that are missing; cut them out of \
         the file",
        own[0].0,
        channel.unit,
        own.len(),
        100.0 * size
    );
    let told = own.len() as f64 > MOSTLY * all && own.len() >= FEWEST && together < ANY_PHASE;
    (told && !dead_band(samples, own[0].0, extent))
        .then(|| Finding::new("data.outliers", &REPEATED, series.about(channel.name), size, text))
}

/// Leaps to one value at least, and share of the steps that are leaps from which they are noise. *Choices.*
const FEWEST: usize = 6;
const NOISY: f64 = 0.2;

/// The finding that one value comes again and again by itself though others hardly do: what a logger writes for a sample that it lacks.
fn code(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
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
    // What mostly comes in long runs is a rest or a dead band.
    if near < APART || 2.0 * size < share || dead_band(channel.samples, value, extent) {
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

/// Samples of a stretch that is sought again, and how many of them change at least. *Choices.*
const STRETCH: usize = 32;
const CHANGES: usize = 4;
/// Samples of a longer one, as short ones of few counts agree by chance. *Choice.*
const LONG: usize = 512;
/// Stretches of a file that are looked at, some. *Choice.*
const MARKS: usize = 256;
/// Samples of a file at least, for it.
const FOR_COPIES: usize = 512;
/// Cycles up to which a load without noise comes again by itself.
const NEXT: f64 = 1.2;
/// Part of a cycle by which a copy lies off whole cycles, after which loads without noise come again if the rate is no multiple of their
/// frequency. *Choice.*
const OFF_WHOLE: f64 = 0.01;
/// Chance of the longest stretch that is told, where samples of one phase often agree; distances that are tried. *Choices.*
const CHANCE: f64 = 1e-9;
const DISTANCES: usize = 3;

/// The finding that stretches come again sample by sample: a buffer that was written twice, a file that was glued of copies.
///
/// Stretches are looked at where the sixteen samples up to their first one make a number whose first bits are zero, so that a copy has its
/// marks at the same places, wherever it lies (U. Manber, "Finding similar files in a large file system", USENIX 1994, 1-10). With noise
/// of a count and more two samples of one phase agree in less than 0.3 of the cases, and 32 in a row in 1e-17. With less noise
/// the share p of samples that agree with those so many samples later, elsewhere in the file, gives a stretch of n the chance p^n:
/// it is told where that is less than 1e-9 in all. A load without noise is the same after whole cycles, throughout the file, or again after
/// twice as long.
pub(super) fn copied(series: &Series, extents: &[Option<Extent>], placed: &PlacedSamples) -> Option<Finding> {
    let known = series.channels.iter().zip(extents);
    let mut known: Vec<(&MeasuredChannel, Extent)> = known
        .filter_map(|(channel, extent)| Some((channel, (*extent)?)))
        .filter(|(_, of)| of.range() > COUNTS.value * of.count)
        .collect();
    // That of the most counts first: it tells best.
    wingbeat_math::order::descend_by(&mut known, |(_, of)| of.range() / of.count);
    let found = known.iter().filter_map(|(channel, of)| copied_in(series, (channel, *of), placed));
    // One that refuses the data, else the first.
    found.reduce(|first, next| {
        let refuses = |of: &Finding| of.limit.id == TWICE.id && of.size > TWICE.value;
        if refuses(&next) && !refuses(&first) { next } else { first }
    })
}

/// The same of one channel.
fn copied_in(
    series: &Series,
    (channel, extent): (&MeasuredChannel, Extent),
    placed: &PlacedSamples,
) -> Option<Finding> {
    let samples = channel.samples;
    if samples.len() < FOR_COPIES {
        return None;
    }
    let marks = Marks::of(samples, STRETCH);
    if marks.again.is_empty() {
        return None;
    }
    let of = |limit, size: f64, later: usize| {
        let text = format!(
            "{:.0} % of its stretches come again sample by sample, {later} samples later: a buffer that was written twice, or a file that was \
             glued of copies",
            100.0 * size
        );
        Finding::new("data.copied", limit, series.about(channel.name), size, text).in_channel(channel.name)
    };
    if is_noisy(channel, extent, placed) {
        let size = marks.again.len() as f64 / marks.count as f64;
        return Some(of(&TWICE, size, marks.distances()[0]));
    }
    let cycles = |later: usize| (series.phase[later] - series.phase[0]).abs();
    let whole = |later: usize| {
        let cycles = cycles(later);
        cycles < NEXT || (cycles - cycles.round()).abs() < OFF_WHOLE
    };
    // Most of a load without noise comes again within a cycle; samples that are missing put the rest of it out of step.
    let next = marks.again.iter().filter(|later| cycles(**later) < NEXT).count();
    let without_noise = 2 * next > marks.count;
    let told = |later: &usize| {
        let by = Agreeing::of(samples, *later);
        let twice = || Agreeing::of(samples, 2 * *later).longest;
        if by.beside > 0.0 && !without_noise {
            let copy = cycles(*later) > NEXT && 2 * twice() < by.longest;
            copy.then(|| of(&TWICE, by.share, *later))
        } else {
            (!whole(*later)).then(|| of(&COPIED, by.share, *later))
        }
    };
    let long = if samples.len() > 2 * LONG { Marks::of(samples, LONG).distances() } else { Vec::new() };
    let distances = long.into_iter().take(DISTANCES).chain(marks.distances().into_iter().take(DISTANCES));
    distances.filter_map(|later| told(&later)).max_by(|a, b| a.size.total_cmp(&b.size))
}

/// The stretches of a channel that begin at its marks.
struct Marks {
    count: usize,
    /// After how many samples one of them comes again, of each that does.
    again: Vec<usize>,
}

impl Marks {
    /// Of stretches of `length` samples.
    fn of(samples: &[f64], length: usize) -> Self {
        let bits = (samples.len() / MARKS).max(1).ilog2();
        let below = u64::MAX >> bits;
        let (mut marks, mut before, mut mark) = (Vec::with_capacity(4 * MARKS), 0, 0_u64);
        for (k, x) in samples[..samples.len() - length].iter().enumerate() {
            let here = mixed(*x);
            mark = (mark << 4).wrapping_add(here);
            if mark <= below && here != before {
                let stretch = &samples[k..k + length];
                if stretch.windows(2).filter(|pair| pair[0] != pair[1]).count() >= CHANGES {
                    let sum = |sum: u64, x: &f64| (sum ^ mixed(*x)).wrapping_mul(MIX).rotate_left(23);
                    marks.push((stretch.iter().fold(0, sum), k));
                }
            }
            before = here;
        }
        marks.sort_unstable();
        let again = marks.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1 - pair[0].1);
        Self { count: marks.len(), again: again.collect() }
    }

    /// After how many samples they come again, the most frequent first.
    fn distances(&self) -> Vec<usize> {
        let mut all = self.again.clone();
        all.sort_unstable();
        let mut each: Vec<(usize, usize)> = all.chunk_by(|a, b| a == b).map(|of| (of.len(), of[0])).collect();
        each.sort_unstable_by(|a, b| b.cmp(a));
        each.into_iter().map(|(_, later)| later).collect()
    }
}

/// An odd number of which about half of the bits are set: 2^64 over the golden ratio.
const MIX: u64 = 0x9e37_79b9_7f4a_7c15;

/// The bits of a value, mixed.
fn mixed(x: f64) -> u64 {
    x.to_bits().wrapping_mul(MIX)
}

/// Samples that agree with those so many later, of those that change.
struct Agreeing {
    /// Share of all samples in stretches that are too long to agree by chance.
    share: f64,
    /// Of the others, those that disagree, as a share of all; none where the file agrees throughout.
    beside: f64,
    /// The longest stretch.
    longest: usize,
}

impl Agreeing {
    fn of(samples: &[f64], later: usize) -> Self {
        let count = samples.len().saturating_sub(later);
        let mut runs = Vec::new();
        let (mut run, mut all, mut equal) = (0_usize, 0_usize, 0_usize);
        for k in 1..count {
            if samples[k] == samples[k - 1] {
                continue;
            }
            all += 1;
            if samples[k] == samples[k + later] {
                (run, equal) = (run + 1, equal + 1);
            } else if run > 0 {
                runs.push(std::mem::take(&mut run));
            }
        }
        runs.push(run);
        let longest = runs.iter().copied().max().unwrap_or(0);
        // What agrees beside the longest stretch does so by chance.
        let beside = (equal - longest) as f64 / (all - longest).max(1) as f64;
        let by_chance = |run: usize| beside.max(1e-6).powf(run as f64) * all as f64;
        let long: usize = runs.iter().filter(|run| **run >= STRETCH && by_chance(**run) < CHANCE).sum();
        let changing = samples.windows(2).filter(|pair| pair[0] != pair[1]).count().max(1) as f64;
        // Where what is left is little, it tells no chance.
        let few = ((all - longest) as f64) < FEW * all as f64;
        let beside = if few { 0.0 } else { 1.0 - beside };
        Self { share: long as f64 / changing, beside, longest }
    }
}

/// Share of the samples beside the longest stretch from which they tell how often samples agree by chance. *Choice.*
const FEW: f64 = 0.1;

/// Part of the range and counts of the converter that its noise has at least for a stretch never to come again. *Choices.*
const NOISE: [f64; 2] = [0.002, 1.0];

/// Whether the samples of one phase differ by noise.
fn is_noisy(channel: &MeasuredChannel, extent: Extent, placed: &PlacedSamples) -> bool {
    let noise = placed.of(channel.samples).and_then(|places| plateau::noise(&places));
    // Loads without noise scatter within a place by their bends, but not from one sample to the next.
    let at_once = || deviation(&mut channel.samples.windows(4).map(third).collect::<Vec<f64>>());
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
fn held(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let samples = channel.samples;
    // Of few counts each is a leap.
    let least = (TO_REST * extent.range()).max(STEPS * extent.count);
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
    let rests = !series.purpose.is_loads() && even(&lost);
    (share(kept) < SAMPLED && times > 1 && !rests)
        .then(|| Finding::new("data.stuck", &LOST, series.about(channel.name), share(all), text))
}
