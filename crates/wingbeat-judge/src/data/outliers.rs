//! Samples that cannot be loads: codes of faults, spikes, counts that wrap around, channels of a multiplexer mixed up.

use super::cycle::variance;
use super::leaps::Leaps;
use super::noise::{OF_MEDIAN, median, third};
use super::same::dead_band;
use super::values::Extent;
use super::{Cause, Finding, MeasuredChannel, Series};
use crate::limits::RunLimits;
use crate::limits::data::{ALTERNATES, BIT, BY_TURNS, HOLE, OUTLIERS, PAIRS, SWAPPED, TURNS, WRAPPED};

/// Samples of one phase at least, and places of the cycle at most, by which a sample is known to lie apart. *Choice.*
const SAME: usize = 8;
const PLACES: usize = 64;
/// Samples of a place that tell its median. *Choice.*
const ENOUGH: usize = 64;
/// Robust deviations beyond which a sample lies apart: of 1e15 samples with white noise one does. *Choice.*
const BEYOND: f64 = 8.0;
/// Parts of the cycle's range, and of the largest range of its unit, below which no sample lies apart: so much do cycles differ. *Choice.*
const APART: [f64; 2] = [0.1, 0.05];
/// Part of its distance that the signal jumps where a run of such samples begins and ends; a load grows by and by. *Choice.*
const JUMPS: f64 = 0.5;
/// A step of so much of the range is a leap across it where the usual one is below the second part, which a sine of 45 samples a cycle
/// has, and hardly any lies between: those of a value that is held do. *Choice.*
const ACROSS: [f64; 2] = [0.75, 0.05];
/// Counts that a channel must span for a leap to be one: the last digit of an idle one toggles. *Choice.*
const COUNTS: f64 = 40.0;
/// Cycles of a motion from which its rows are compared with those of their phase. *Choice.*
const FOR_PLACES: f64 = 4.0;
/// Part of its range that a channel passes through by itself between two leaps. *Choice.*
const PASSES: f64 = 0.5;
/// Least mean part of its range that a channel leaps over where its counts wrap around: it then goes on from the other end, where a knock
/// starts from anywhere. *Choice.*
const WHOLE: f64 = 0.9;
/// Share of the cycles in which samples far from their phase come at one place of it for them to come with the cycle, and part of the
/// cycle that such places have at most: spikes that are dense enough come everywhere in as many. *Choices.*
const EACH_CYCLE: f64 = 0.5;
const OF_CYCLE: f64 = 0.125;
/// Samples of a cycle from which every second one is told from the others. *Choice.*
const FOR_SECOND: f64 = 8.0;

/// Of all channels whose samples are finite; `extents` are those of all channels.
pub(super) fn findings(series: &Series, extents: &[Option<Extent>], limits: &RunLimits) -> Vec<Finding> {
    let cycles = series.cycles();
    let channels = series.channels.iter().copied().zip(extents);
    let all: Vec<(MeasuredChannel, Extent)> =
        channels.filter_map(|(channel, extent)| Some((channel, (*extent)?))).collect();
    if !(cycles >= 0.9) || series.phase.len() < 2 * SAME {
        return Vec::new();
    }
    let breaks = |finding: &Finding| finding.breaks(limits);
    let at = CyclePlaces::of(series.phase, cycles);
    if !series.purpose.is_loads() {
        let of = |(channel, extent): &(MeasuredChannel, Extent)| {
            let far = jagged(series, channel, *extent).filter(breaks);
            let apart = || {
                let usual = Usual::of(&at, channel, *extent);
                usual.apart(series, channel, &at, usual.range).filter(breaks)
            };
            let far = far.or_else(|| if cycles >= FOR_PLACES { apart() } else { None });
            far.or_else(|| alternating(series, channel, *extent, cycles).pop())
        };
        return all.iter().filter_map(of).collect();
    }
    let usual: Vec<Usual> = all.iter().map(|(channel, extent)| Usual::of(&at, channel, *extent)).collect();
    let mut found = Vec::new();
    for ((channel, extent), own) in all.iter().zip(&usual) {
        let same = all.iter().zip(&usual).filter(|((other, _), _)| other.unit == channel.unit);
        let most = same.map(|(_, usual)| usual.range).fold(0.0, f64::max);
        // Of one cause one finding.
        let turns = alternating(series, channel, *extent, cycles);
        let first = turns.iter().find(|finding| finding.serious && breaks(finding)).cloned();
        let leaps = Leaps::of(channel.samples, *extent);
        let by_turns = leaps.turns(series, channel).filter(breaks);
        let first = first.or_else(|| by_turns.clone().filter(|finding| finding.serious));
        let apart = own.apart(series, channel, &at, most).filter(breaks);
        let first = first.or_else(|| apart.clone().filter(|finding| finding.serious));
        // Both leap over a part of the range.
        let leaps = steps_beyond(channel.samples, 0.9 * HOLE.value * extent.range()) > 0;
        let odd = || wrapped(series, channel, *extent, cycles).filter(breaks);
        let hole = || hole(series, channel, *extent, cycles).filter(breaks);
        let first = first.or_else(|| if leaps { odd().or_else(hole) } else { None });
        // A knock is noted, and so is what it looks like.
        let noted = apart.or_else(|| turns.into_iter().find(breaks)).or(by_turns);
        found.extend(match (first, noted) {
            (Some(first), Some(noted)) if !first.serious => Some(noted),
            (first, noted) => first.or(noted),
        });
    }
    found
}

/// How many steps from one sample to the next are larger than `least`.
pub(super) fn steps_beyond(samples: &[f64], least: f64) -> usize {
    let after = samples.get(1..).unwrap_or_default();
    // Counted as wide as the samples are, several at once.
    samples.iter().zip(after).map(|(a, b)| u64::from((b - a).abs() > least)).sum::<u64>() as usize
}

/// The place of the cycle that each sample lies in.
struct CyclePlaces {
    of: Vec<u8>,
    /// Of each place samples taken evenly from the whole file, from which its median is known well enough.
    taken: Vec<Vec<u32>>,
}

impl CyclePlaces {
    fn of(phase: &[f64], cycles: f64) -> Self {
        let per_cycle = phase.len() as f64 / cycles.max(1.0);
        let count = PLACES.min(phase.len() / SAME).min(per_cycle as usize).max(1);
        let of: Vec<u8> = phase.iter().map(|p| place(*p, count) as u8).collect();
        let every = phase.len().div_ceil(count * ENOUGH);
        let mut taken = vec![Vec::with_capacity(phase.len() / count / every + SAME); count];
        let mut seen = vec![0_usize; count];
        for (k, place) in of.iter().enumerate() {
            let place = usize::from(*place);
            if seen[place].is_multiple_of(every) {
                taken[place].push(k as u32);
            }
            seen[place] += 1;
        }
        Self { of, taken }
    }
}

/// What the samples of one phase usually are.
struct Usual {
    /// Median and robust deviation at each place of the cycle.
    places: Vec<[f64; 2]>,
    /// Range of the medians.
    range: f64,
    extent: Extent,
}

impl Usual {
    fn of(at: &CyclePlaces, channel: &MeasuredChannel, extent: Extent) -> Self {
        let mut of: Vec<f64> = Vec::new();
        let known = |taken: &Vec<u32>| {
            of.clear();
            of.extend(taken.iter().map(|k| channel.samples[*k as usize]));
            let middle = median(&mut of);
            of.iter_mut().for_each(|x| *x = (*x - middle).abs());
            [middle, OF_MEDIAN * median(&mut of)]
        };
        let mut places: Vec<[f64; 2]> = at.taken.iter().map(known).collect();
        // Few samples of a place tell little of its noise.
        let all = median(&mut places.iter().map(|place| place[1]).collect::<Vec<f64>>());
        places.iter_mut().for_each(|place| place[1] = place[1].max(all));
        let middles = || places.iter().map(|place| place[0]).filter(|x| x.is_finite());
        let range = middles().fold(f64::MIN, f64::max) - middles().fold(f64::MAX, f64::min);
        Self { range: range.max(0.0), places, extent }
    }

    /// The finding that samples lie far from those of their phase, in jumps, and what they add. `most` is the largest range of the
    /// unit.
    fn apart(
        &self,
        series: &Series,
        channel: &MeasuredChannel,
        at: &CyclePlaces,
        most: f64,
    ) -> Option<Finding> {
        let (samples, places) = (channel.samples, self.places.len());
        let count = self.extent.count;
        let least = (APART[0] * self.range).max(APART[1] * most);
        let least = if count.is_finite() { least.max(BEYOND * count) } else { least };
        let bounds = |here: usize| {
            let [middle, noise] = self.places[here];
            // A sample at the edge of a place may be of the next one.
            let beside = [1, places - 1].map(|by| self.places[(here + by) % places][0]);
            let by = (BEYOND * noise).max(least);
            [middle.min(beside[0]).min(beside[1]) - by, middle.max(beside[0]).max(beside[1]) + by, middle]
        };
        let bounds: Vec<[f64; 3]> = (0..places).map(bounds).collect();
        let of = |(place, x): (&u8, &f64)| {
            let [low, high, middle] = bounds[usize::from(*place)];
            if *x < low || *x > high { (x - middle).abs() } else { 0.0 }
        };
        let far: Vec<f64> = at.of.iter().zip(samples).map(of).collect();
        if far.iter().all(|far| *far == 0.0) {
            return None;
        }
        let step = |k: usize| (samples[k] - samples[k - 1]).abs();
        let (mut sum, mut many, mut begin) = (0.0, 0_usize, 0);
        let mut runs = vec![0_usize; places];
        for end in 1..=samples.len() {
            if end < samples.len() && (far[end] > 0.0) == (far[begin] > 0.0) {
                continue;
            }
            let run = &far[begin..end];
            let jumps = (begin == 0 || step(begin) > JUMPS * run[0])
                && (end == samples.len() || step(end) > JUMPS * run[run.len() - 1]);
            if run[0] > 0.0 && jumps {
                sum += run.iter().sum::<f64>();
                many += run.len();
                runs[usize::from(at.of[begin])] += 1;
            }
            begin = end;
        }
        let noise = self.places.iter().map(|place| place[1]).fold(0.0, f64::max);
        let scale = self.range.max(BEYOND * noise).max(least) * samples.len() as f64;
        let text = format!(
            "{many} of {} samples lie far from all others of their phase, by {:.3e} {} in the mean, and the signal jumps there: \
             codes of a fault, spikes or drop-outs; cut them out of the file",
            samples.len(),
            sum / many.max(1) as f64,
            channel.unit
        );
        let found = |text: String| {
            Finding::new("data.outliers", &OUTLIERS, series.about(channel.name), sum / scale, text)
                .in_channel(channel.name)
        };
        let all: usize = runs.iter().sum();
        let often = EACH_CYCLE * series.cycles();
        let at_one: usize = runs.iter().filter(|count| **count as f64 > often.max(1.0)).sum();
        let wide = runs.iter().filter(|count| **count as f64 > often.max(1.0)).count();
        let mut values: Vec<f64> =
            samples.iter().zip(&far).filter(|of| *of.1 > 0.0).map(|of| *of.0).collect();
        let usual = median(&mut values);
        let code = values.len() > 2 && 2 * values.iter().filter(|x| **x == usual).count() > values.len();
        // What comes in most cycles at one phase is a load, but for a value that is always the same.
        if 2 * at_one > all && wide as f64 <= (OF_CYCLE * places as f64).max(1.0) && !code {
            let text = format!(
                "{many} of {} samples lie far from others of their phase, at one phase in most cycles, and the signal jumps there: a knock, \
                 or spikes that come with the cycle",
                samples.len()
            );
            return Some(found(text).explained(Cause::Knock, series.purpose));
        }
        (sum > 0.0).then(|| found(text))
    }
}

pub(super) fn place(phase: f64, places: usize) -> usize {
    // The remainder of a division takes ten times as long.
    (((phase - phase.floor()) * places as f64) as usize).min(places - 1)
}

/// Part of the range by which the samples beyond the leaps of a channel whose counts wrap around lie further in than those next to the
/// leaps, and standard errors of that, at least, in the mean. *Choices*: a knock on the extreme of a sine, of a twentieth of its cycle, has
/// 0.004.
const BEYOND_LEAP: f64 = 0.006;
const ERRORS: f64 = 4.0;

/// The finding that a channel leaps across its range, up and down: a phase that begins again leaps one way.
///
/// What wraps around enters at the other end of the range, goes on from there, and leaves by the same end: its samples lie further in than
/// those next to the leaps. A knock at an extreme leaps across the range as well, and has one height, or is highest in its middle. The means of
/// n and m of its samples, whose deviation is s, differ by s sqrt(1 / n + 1 / m): by four times that once in 30,000 of such knocks.
fn wrapped(series: &Series, channel: &MeasuredChannel, extent: Extent, cycles: f64) -> Option<Finding> {
    let range = extent.range();
    let steps = || channel.samples.windows(2).map(|pair| pair[1] - pair[0]);
    let leaps = steps().filter(|step| step.abs() > ACROSS[0] * range).count();
    if leaps == 0 {
        return None;
    }
    let large = steps().filter(|step| step.abs() > 2.0 * ACROSS[1] * range).count();
    let up = steps().filter(|step| *step > ACROSS[0] * range).count();
    let sizes: f64 = steps().map(f64::abs).filter(|step| *step > ACROSS[0] * range).sum();
    let whole = sizes > WHOLE * range * leaps as f64;
    let usual = || median(&mut steps().map(f64::abs).collect::<Vec<f64>>());
    let smooth = range > COUNTS * extent.count && 2 * large < 3 * leaps && usual() < ACROSS[1] * range;
    let leaps = 2 * up.min(leaps - up);
    // A square wave stays where it leapt to.
    let own = channel.samples.chunk_by(|a, b| (b - a).abs() <= ACROSS[0] * range);
    let passes: Vec<&[f64]> = own.collect();
    let most = passes.iter().filter_map(|of| Extent::of(of)).map(Extent::range).fold(0.0, f64::max);
    if !(smooth && whole && most > PASSES * range) {
        return None;
    }
    // Between two leaps it is by turns within its range and beyond it, there for less time.
    let side = |of: usize| passes.iter().skip(1 + of).step_by(2);
    let time = |of: usize| side(of).map(|of| of.len()).sum::<usize>();
    let beyond = usize::from(time(0) > time(1));
    let middle = 0.5 * (extent.high + extent.low);
    let all: Vec<f64> = side(beyond).flat_map(|of| of.iter()).map(|x| (x - middle).abs()).collect();
    let next: Vec<f64> =
        side(beyond).flat_map(|of| [of[0], of[of.len() - 1]]).map(|x| (x - middle).abs()).collect();
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len().max(1) as f64;
    let error = (variance(&next) * (1.0 / all.len() as f64 + 1.0 / next.len() as f64)).sqrt();
    let knocks = !(mean(&next) - mean(&all) > (BEYOND_LEAP * range).max(ERRORS * error));
    let why = if knocks {
        "a knock in each cycle, or counts that wrap around at their end for a moment"
    } else {
        "its counts wrap around at their end; take a wider range, or unwrap them"
    };
    let text = format!("leaps across its range at {leaps} samples and is smooth elsewhere: {why}");
    let found =
        Finding::new("data.wrapped", &WRAPPED, series.about(channel.name), leaps as f64 / cycles, text);
    Some(if knocks { found.explained(Cause::Knock, series.purpose) } else { found })
}

/// The finding that single rows of a motion lie far from those before and after them, which agree.
fn jagged(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let range = extent.range();
    let off = |of: &[f64]| of[1] - 0.5 * (of[0] + of[2]);
    let usual = median(&mut channel.samples.windows(3).map(|of| off(of).abs()).collect::<Vec<f64>>());
    let least = (APART[0] * range).max(BEYOND * OF_MEDIAN * usual);
    let far = |of: &&[f64]| off(of).abs() > least && (of[2] - of[0]).abs() < JUMPS * off(of).abs();
    let (mut sum, mut many) = (0.0, 0_usize);
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for of in channel.samples.windows(3) {
        if far(&of) {
            (sum, many) = (sum + off(of).abs(), many + 1);
        } else {
            (low, high) = (low.min(of[1]), high.max(of[1]));
        }
    }
    let size = sum / ((high - low).max(f64::MIN_POSITIVE) * channel.samples.len() as f64);
    let text = format!(
        "{many} of {} rows lie far from those before and after them: spikes or drop-outs, of which harmonics take a part; cut them out \
         of the file",
        channel.samples.len()
    );
    (many > 0).then(|| {
        Finding::new("data.outliers", &OUTLIERS, series.about(channel.name), size, text)
            .in_channel(channel.name)
    })
}

/// Stretches of the range in which samples are counted, samples in the stretches beside a hole at least, and times that it is leapt over, in
/// a cycle and in all. *Choices.*
const STRETCHES: usize = 128;
const BESIDE: f64 = 0.02;
const LEAPT: [f64; 2] = [0.5, 8.0];

/// The finding that a smooth channel leaps over a part of its range, up and down, and never takes a value of it: a bit of the converter is
/// dead, or two ranges do not meet.
fn hole(series: &Series, channel: &MeasuredChannel, extent: Extent, cycles: f64) -> Option<Finding> {
    let (samples, range) = (channel.samples, extent.range());
    if range < COUNTS * extent.count {
        return None;
    }
    let mut there = [0_u32; STRETCHES];
    let scale = STRETCHES as f64 / range;
    samples.iter().for_each(|x| there[(((x - extent.low) * scale) as usize).min(STRETCHES - 1)] += 1);
    // The longest stretch without a sample, by its end and length.
    let (mut run, mut most) = (0, (0, 0));
    for (k, count) in there.iter().enumerate() {
        run = if *count == 0 { run + 1 } else { 0 };
        most = if run > most.1 { (k + 1, run) } else { most };
    }
    let (end, run) = most;
    let size = run as f64 / STRETCHES as f64;
    if size < HOLE.value {
        return None;
    }
    let count = |of: &[u32]| f64::from(of.iter().sum::<u32>());
    let begin = end - run;
    let beside = [&there[begin.saturating_sub(run)..begin], &there[end..(end + run).min(STRETCHES)]];
    let dense = beside.iter().all(|of| count(of) > BESIDE * samples.len() as f64);
    let middle = extent.low + 0.5 * (begin + end) as f64 / scale;
    let leaps = samples.windows(2).filter(|pair| (pair[0] < middle) != (pair[1] < middle)).count() as f64;
    let mut steps: Vec<f64> = samples.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let smooth = median(&mut steps) < 0.25 * size * range;
    // An instrument with a dead band leaves out both sides of it.
    let edges = samples.iter().fold([f64::MIN, f64::MAX], |[low, high], x| {
        if *x < middle { [low.max(*x), high] } else { [low, high.min(*x)] }
    });
    let banded = || edges.iter().any(|edge| dead_band(samples, *edge, extent));
    if !(dense && leaps > LEAPT[1].max(LEAPT[0] * cycles) && smooth && !banded()) {
        return None;
    }
    let [back, on] = beside_leaps(
        samples,
        middle,
        size * range,
        (samples.len() as f64 / cycles / STEPS).max(1.0) as usize,
    );
    let (limit, why) = match (back > OFTEN * leaps, on > OFTEN * leaps) {
        (true, _) => (&BIT, "a bit of the converter is dead"),
        (false, true) => (&HOLE, "two ranges do not meet"),
        // A load that leaps and stays where it leapt to, or comes to a leap by and by, takes no value there by itself.
        _ => return None,
    };
    let text = format!(
        "leaps over {:.0} % of its range, from {:.4} to {:.4} {}, and never takes a value there: {why}",
        100.0 * size,
        edges[0],
        edges[1],
        channel.unit
    );
    Some(Finding::new("data.hole", limit, series.about(channel.name), size, text))
}

/// Stretches of a cycle over which slopes are compared, their largest ratio where a curve goes on, and the share of the leaps that must be
/// of a kind. *Choices.*
const STEPS: f64 = 60.0;
const GOES_ON: f64 = 3.0;
const OFTEN: f64 = 0.4;

/// How often a smooth channel falls back by about `size` against the way that it goes on, and how often its slope is the same before and
/// after it leaps, by more than it rises beside, across `middle`; slopes are those over `by` samples.
fn beside_leaps(samples: &[f64], middle: f64, size: f64, by: usize) -> [f64; 2] {
    let (mut back, mut on) = (0.0, 0.0);
    let alike = |a: f64, b: f64| a * b > 0.0 && a.abs().max(b.abs()) < GOES_ON * a.abs().min(b.abs());
    for k in 2 * by..samples.len().saturating_sub(2 * by + 1) {
        let leap = samples[k + 1] - samples[k];
        if leap.abs() < 0.5 * size {
            continue;
        }
        let before = [samples[k] - samples[k - by], samples[k - by] - samples[k - 2 * by]];
        let after = [samples[k + 1 + by] - samples[k + 1], samples[k + 1 + 2 * by] - samples[k + 1 + by]];
        let across = (samples[k] < middle) != (samples[k + 1] < middle);
        let against = leap * before[0] < 0.0 && leap * after[0] < 0.0;
        let smooth = alike(before[0], before[1]) && alike(after[0], after[1]);
        back += f64::from(u8::from(!across && against && leap.abs() < 2.0 * size));
        let far = leap.abs() * by as f64 > GOES_ON * before[0].abs().max(after[0].abs());
        on += f64::from(u8::from(across && smooth && far && leap * before[0] > 0.0 && leap * after[0] > 0.0));
    }
    [back, on]
}

/// Part of the range that second differences have at least, rms, for their order to be looked at. *Choice.*
const BENT: f64 = 0.02;

/// The findings that every second sample is of something else: neighbours differ by more than those two apart do, or second differences
/// have one sign and the other by turns.
fn alternating(series: &Series, channel: &MeasuredChannel, extent: Extent, cycles: f64) -> Vec<Finding> {
    let samples = channel.samples;
    let (mut one, mut two, mut bent, mut turned, mut before) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for of in samples.windows(3) {
        let by = (of[2] - of[1]) - (of[1] - of[0]);
        one += (of[1] - of[0]).powi(2);
        two += (of[2] - of[0]).powi(2);
        bent += by * by;
        turned += by * before;
        before = by;
    }
    let count = samples.len() as f64;
    if !(one > 0.0 && count > FOR_SECOND * cycles) {
        return Vec::new();
    }
    let loads = series.purpose.is_loads();
    let signs = one / two.max(1e-12 * one);
    let text = "every second sample is of something else: channels of a multiplexer are mixed up, or signs alternate";
    let about = || series.about(channel.name);
    let mut found = Vec::new();
    if loads {
        found.push(Finding::new("data.alternates", &ALTERNATES, about(), signs, text));
    }
    if loads {
        found.extend(by_turns(series, channel, extent));
    }
    if bent > count * (BENT * extent.range()).powi(2) {
        let put_back = if turned < TURNED * bent { exchanged(samples) } else { f64::INFINITY };
        found.push(if put_back < PAIRS.value {
            let text = "is smooth if the rows of each pair are exchanged: they were written in the wrong order";
            Finding::new("data.alternates", &PAIRS, about(), put_back, text)
        } else {
            let text = "leaps up and down by turns from sample to sample: two sources by turns, or a line near half the rate";
            Finding::new("data.alternates", &BY_TURNS, about(), turned / bent, text)
        });
    }
    found
}

/// Samples that tell, in the middle of a file, lengths of turns that are sought, and the correlation of the steps between turns and the next ones below which they go up and down.
/// *Choices.*
const FOR_TURNS: usize = 512;
const OF_TURN: std::ops::RangeInclusive<usize> = 2..=8;
const UP_AND_DOWN: f64 = -0.6;
/// Part of the range and counts that the steps between turns have at least, in the mean. *Choices.*
const OF_TURNS: [f64; 2] = [0.01, 2.0];
/// Deviation of the steps between turns over their mean below which they are those of a ripple on the load. *Choice.*
const STEADY: f64 = 0.3;

/// The finding that samples come from two sources by turns of m samples.
///
/// The steps b from one turn to the next go up and down by turns, with a correlation of -1 from each to the next, where those of a value
/// that is held have 1 and those of noise -1/2. Beside the steps before and after them, b - (a + c) / 2, they are far larger than the second
/// differences within a turn. For a line at half the frequency of the turns the ratio is (1 - cos w) / (2 (1 - cos w)), 1/2, with
/// w = pi / m, for white noise sqrt(5 / 6), and for smooth loads 1/2 as for lines. Turns of two have no second differences within, and are
/// told from nothing but a line at a quarter of the rate: they are noted. So are turns whose steps are all alike: those of a ripple that is
/// added to the load, as of a chopper or of hum with harmonics; what two sources differ by changes with the load.
fn by_turns(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let from = channel.samples.len().saturating_sub(FOR_TURNS) / 2;
    let samples = &channel.samples[from..channel.samples.len().min(from + FOR_TURNS)];
    let steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let beside: Vec<f64> = steps.windows(3).map(|of| (of[1] - 0.5 * (of[0] + of[2])).abs()).collect();
    let bent: Vec<f64> = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    let least = (OF_TURNS[0] * extent.range()).max(OF_TURNS[1] * extent.count);
    let of = |m: usize| {
        let mean = |of: &[f64], k: usize| {
            let all = of.iter().skip(k).step_by(m);
            all.clone().sum::<f64>() / all.count() as f64
        };
        // Step k + 1 is that of `beside` k, and of the second differences k and k + 1.
        let sizes: Vec<f64> = (0..m).map(|k| mean(&beside, k)).collect();
        let at = (0..m).max_by(|a, b| sizes[*a].total_cmp(&sizes[*b]))?;
        let size = sizes[at];
        let meets = || steps.iter().skip(at + 1).step_by(m);
        let next = || meets().zip(meets().skip(1)).map(|(a, b)| a * b).sum::<f64>();
        let all = || meets().map(|step| step * step).sum::<f64>();
        if size < least || next() > UP_AND_DOWN * all() {
            return None;
        }
        let within = match m {
            2 => sizes[1 - at],
            _ => (2..m).map(|k| mean(&bent, (at + k) % m)).sum::<f64>() / (m - 2) as f64,
        };
        let squares = beside.iter().skip(at).step_by(m).map(|step| (step - size).powi(2));
        // White noise of deviation s gives these steps sqrt(5) s, and the magnitude of second differences sqrt(2 / pi) sqrt(6) s.
        let noise = 5.0 / (6.0 * std::f64::consts::FRAC_2_PI) * within * within;
        let spread = squares.sum::<f64>() * m as f64 / beside.len() as f64 - noise;
        Some((size / within.max(1e-3 * size), m, spread < (STEADY * size).powi(2)))
    };
    let all = OF_TURN.filter(|m| steps.len() > 8 * m).filter_map(of);
    let (size, m, steady) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let or = match m {
        2 => ", or a line at a quarter of the rate",
        _ if steady => ", or a ripple of that period",
        _ => "",
    };
    let text = format!(
        "leaps up and down every {m} samples and is smooth between: two sources by turns in one column{or}"
    );
    let found = Finding::new("data.alternates", &TURNS, series.about(channel.name), size, text);
    let found = found.in_channel(channel.name);
    Some(if m == 2 || steady { found.noted() } else { found })
}

/// Correlation of the second differences of one sample and the next below which it is tried whether rows are exchanged; white noise has
/// -2/3. *Choice.*
const TURNED: f64 = -0.5;

/// Sum of the squares of the second differences with the rows of each pair exchanged over that without, the less of the two ways to pair
/// them, of samples in the middle of the file.
fn exchanged(samples: &[f64]) -> f64 {
    let from = samples.len().saturating_sub(TOLD) / 2;
    let samples = &samples[from..samples.len().min(from + TOLD)];
    // Samples a and b, c and d are pairs: written b, a, d, c.
    let of = |first: usize| {
        let (mut sum, mut without) = (0.0, 0.0);
        for four in samples[first..].windows(4).step_by(2) {
            let [a, b, c, d] = [four[1], four[0], four[3], four[2]];
            sum += (c - 2.0 * b + a).powi(2) + (d - 2.0 * c + b).powi(2);
            without += (d - 2.0 * a + b).powi(2) + (c - 2.0 * d + a).powi(2);
        }
        sum / without
    };
    of(0).min(of(1))
}

/// The findings that two channels that move are one.
pub(super) fn equals(series: &Series) -> Vec<Finding> {
    let mut found = Vec::new();
    for (k, channel) in series.channels.iter().enumerate() {
        let same = |other: &&MeasuredChannel| channel.samples == other.samples;
        let moves =
            |_: &&MeasuredChannel| Extent::of(channel.samples).is_some_and(|extent| extent.range() > 0.0);
        let before = &series.channels[..k];
        let (other, text) = match before.iter().find(same).filter(moves) {
            Some(other) => (other, "holds the very values of"),
            None => match before.iter().find(|other| one_noise(other.samples, channel.samples)) {
                Some(other) => (other, "has even the noise, by a factor, of"),
                None => continue,
            },
        };
        let text = format!("{text} {}: one column for two", other.name);
        let about = series.about(channel.name);
        found.push(Finding::new("data.equal", &SWAPPED, about, 1.0, text).noted().in_channel(channel.name));
    }
    found
}

/// Samples whose order and noise are compared, the part of the range and the counts that it has at least, and the part of it that differs at most.
/// *Choices.*
const TOLD: usize = 1024;
const NOISE: f64 = 0.002;
const STEPS_OF_NOISE: f64 = 2.0;
const DIFFERS: f64 = 0.02;

/// Whether third differences, which are those of the noise, are a multiple of those of another channel. Loads that are computed may be, and
/// have no noise.
fn one_noise(a: &[f64], b: &[f64]) -> bool {
    let (mut aa, mut ab, mut bb, mut turned, mut before) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for k in 0..a.len().min(TOLD).saturating_sub(3) {
        let (x, y) = (third(&a[k..]), third(&b[k..]));
        (aa, ab, bb, turned) = (aa + x * x, ab + x * y, bb + y * y, turned + y * before);
        before = y;
    }
    let Some(extent) = Extent::of(&b[..b.len().min(TOLD)]).filter(|extent| extent.range() > 0.0) else {
        return false;
    };
    // Loads of few counts have the steps of the converter for noise.
    let least = (NOISE * extent.range()).max(STEPS_OF_NOISE * extent.count);
    // Third differences of white noise have 20 times its variance, and -3/4 as correlation from one to the next; smooth loads have 1.
    let noisy = bb > 20.0 * least.powi(2) * b.len().min(TOLD) as f64 && aa > 0.0;
    noisy && turned < TURNED * bb && 1.0 - ab * ab / (aa * bb) < DIFFERS * DIFFERS
}
