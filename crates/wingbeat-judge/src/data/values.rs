//! What the values of a channel say by themselves: not finite, tiny, huge, constant, stuck, clipped.

use super::rectified::rectified;
use super::{Cause, Finding, MeasuredChannel, Series, plateau, same};
use crate::limits::RunLimits;
use crate::limits::data::{CLIPPED, COUNTS, FEW_COUNTS, HUGE, LOST, NOT_FINITE, STEPS, STUCK, TINY};

/// Counts that a channel must span elsewhere for a stay within one of them to be odd. *Choice.*
const SPAN: f64 = 8.0;
/// Samples that a flat end must hold in a row. *Choice*: a cycle that repeats exactly has two.
const ROW: usize = 4;
/// A flat end must hold so many times the samples of the band below it. A quantised sine, the flattest smooth top,
/// has 2.4. *Choice.*
const STEEP: f64 = 5.0;
/// Width of that band in parts of the range. *Choice.*
const BAND: f64 = 1.0 / 200.0;

/// Times that width by which a dead band leaves out what is beside zero. *Choice.*
const APART: f64 = 3.0;

/// Least and largest value and the least step between values that follow one another.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub low: f64,
    pub high: f64,
    pub count: f64,
}

impl Extent {
    /// Of finite samples, in the unit of the channel; `None` where one is not.
    pub fn of(samples: &[f64]) -> Option<Self> {
        let first = *samples.first()?;
        let (mut low, mut high) = ([first; LANES], [first; LANES]);
        let (mut count, mut odd) = ([f64::INFINITY; LANES], [0.0 * first; LANES]);
        // Each sample with the one before it, several at once.
        let mut add = |before: &[f64; LANES], after: &[f64; LANES]| {
            for k in 0..LANES {
                let x = after[k];
                let step = (x - before[k]).abs();
                // Rounding of a decimal number is no step.
                let step = if step > 1e-9 * x.abs() { step } else { f64::INFINITY };
                low[k] = if x < low[k] { x } else { low[k] };
                high[k] = if x > high[k] { x } else { high[k] };
                count[k] = if step < count[k] { step } else { count[k] };
                // Not a number once a sample is not finite.
                odd[k] += 0.0 * x;
            }
        };
        let (before, after) = (samples.as_chunks().0, samples[1..].as_chunks());
        before.iter().zip(after.0).for_each(|(before, after)| add(before, after));
        let done = samples.len() - 1 - after.1.len();
        after.1.iter().zip(&samples[done..]).for_each(|(x, before)| add(&[*before; LANES], &[*x; LANES]));
        let least = |of: [f64; LANES]| of.into_iter().fold(f64::INFINITY, f64::min);
        let of = Self { low: least(low), high: -least(high.map(|x| -x)), count: least(count) };
        (odd == [0.0; LANES]).then_some(of)
    }

    pub fn range(self) -> f64 {
        self.high - self.low
    }
}

/// Samples that are looked at together: four numbers fill a register of AVX2.
pub(super) const LANES: usize = 4;

/// What is wrong with the values.
pub fn findings(series: &Series, extents: &[Option<Extent>], limits: &RunLimits) -> Vec<Finding> {
    let mut found = Vec::new();
    let placed = plateau::placed(series);
    for (channel, extent) in series.channels.iter().zip(extents) {
        match extent {
            None => {
                let count = channel.samples.iter().filter(|x| !x.is_finite()).count();
                found.extend(not_finite(series.what, channel.name, count));
            }
            Some(extent) => {
                let own = of_channel(series, (channel, *extent), &placed, limits);
                found.extend(own.into_iter().map(|finding| finding.in_channel(channel.name)));
            }
        }
    }
    found.extend(nothing(series, extents));
    if series.purpose.is_loads() {
        found.extend(coarse(series, extents));
    } else {
        found.extend(in_steps(series, extents));
    }
    let copied = same::copied(series, extents, &placed);
    found.extend(copied.map(|copied| copied.explained(Cause::Again, series.purpose)));
    found.extend(standing(series, extents));
    found
}

/// Part of the largest range of its unit that a channel has for its counts to be judged. *Choice.*
const TELLING: f64 = 0.05;
/// Part of it below which a channel of few counts is no reason to refuse the file. *Choice.*
const HALF: f64 = 0.5;

/// Channels of few counts, but for what is only on or off.
pub(super) fn coarse(series: &Series, extents: &[Option<Extent>]) -> Vec<Finding> {
    let all = || series.channels.iter().zip(extents);
    let most = |unit: &str| {
        let same = all().filter(|(other, _)| other.unit == unit);
        same.filter_map(|(_, extent)| Some((*extent)?.range())).fold(0.0, f64::max)
    };
    let told = |(channel, extent): (&MeasuredChannel, &Option<Extent>)| {
        let extent = (*extent)?;
        // What triggers is on or off, and beside others in whole units it is one of them.
        let whole = |(other, of): (&MeasuredChannel, &Option<Extent>)| {
            other.name != channel.name && other.unit == channel.unit && of.is_some_and(|of| of.count == 1.0)
        };
        let switch = channel.samples.iter().all(|x| *x == 0.0 || *x == 1.0) && !all().any(whole);
        let counts = extent.range() / extent.count;
        // What is held stands at values of any size.
        let step = |x: &f64| (x - extent.low) / extent.count;
        let even = || channel.samples.iter().all(|x| (step(x) - step(x).round()).abs() < 0.01);
        let judged = extent.range() > TELLING * most(channel.unit) && extent.count.is_finite() && !switch;
        let text = format!(
            "spans {counts:.0} steps of {:.3e} {}: the range of the converter is far too wide",
            extent.count, channel.unit
        );
        // One that finer ones of its unit dwarf may flip a bit, and one alone of its unit leaves the others good.
        let dwarfed = all().any(|(other, own)| {
            own.is_some_and(|own| {
                other.unit == channel.unit
                    && extent.range() < HALF * own.range()
                    && own.range() > FEW_COUNTS.value * own.count
            })
        });
        let fine = |(other, extent): (&MeasuredChannel, &Option<Extent>)| {
            extent.is_some_and(|extent| {
                other.unit != channel.unit && extent.range() > FEW_COUNTS.value * extent.count
            })
        };
        let alone = all().filter(|(other, _)| other.unit == channel.unit).count() == 1 && all().any(fine);
        let limit = if counts < COUNTS.value && !dwarfed && !alone { &COUNTS } else { &FEW_COUNTS };
        let found = || Finding::new("data.coarse", limit, series.about(channel.name), counts, text);
        (judged && counts < FEW_COUNTS.value && even()).then(|| found().in_channel(channel.name))
    };
    all().filter_map(told).collect()
}

/// Loads that are cut off, as their instrument gave them, but for those that are small beside another one of their unit.
pub(super) fn cut_off(series: &Series, extents: &[Option<Extent>], limits: &RunLimits) -> Vec<Finding> {
    let all =
        || series.channels.iter().zip(extents).filter_map(|(channel, extent)| Some((channel, (*extent)?)));
    let most = |unit: &str| {
        all().filter(|(other, _)| other.unit == unit).map(|(_, extent)| extent.range()).fold(0.0, f64::max)
    };
    let told = |(channel, extent): (&MeasuredChannel, Extent)| {
        let breaks = |finding: &Finding| finding.breaks(limits);
        // Samples that were bridged lie between the counts of the others.
        let extent = Extent { count: extent.count.max(usual_step(channel.samples)), ..extent };
        let at_ends = clipped(series, channel, extent, &[extent.high, extent.low]).filter(breaks);
        let found = at_ends.or_else(|| clipped_within(series, channel, extent).filter(breaks))?;
        Some(found.in_channel(channel.name))
    };
    let large = |(channel, extent): &(&MeasuredChannel, Extent)| {
        extent.range() > 0.0 && extent.range() > TELLING * most(channel.unit)
    };
    all().filter(large).filter_map(told).collect()
}

/// Steps that tell the usual one. *Choice.*
const STEPS_SEEN: usize = 20_000;

/// The median of the steps between samples that differ.
fn usual_step(samples: &[f64]) -> f64 {
    let every = samples.len().div_ceil(STEPS_SEEN).max(1);
    let steps = samples.windows(2).step_by(every).map(|pair| (pair[1] - pair[0]).abs());
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    if steps.is_empty() { 0.0 } else { super::noise::median(&mut steps) }
}

/// Share of the rows at which a motion stands still from which its steps are those of an encoder or of a table by hand; rounded rows that
/// are near to one another stand still at the ends of the stroke alone. *Choice.*
const STANDS: f64 = 0.4;
/// Values that it takes at least: a motion may go to and fro between two. *Choice.*
const VALUES: f64 = 3.0;

/// Motions that stand still and go on by even steps: an encoder of few marks, or angles rounded by hand.
fn in_steps(series: &Series, extents: &[Option<Extent>]) -> Vec<Finding> {
    let told = |(channel, extent): (&MeasuredChannel, &Option<Extent>)| {
        let extent = (*extent)?;
        let steps = || channel.samples.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let still = steps().filter(|step| *step <= 1e-9 * extent.range()).count() as f64;
        let size = extent.range() / extent.count;
        let even = |step: f64| (step / extent.count - (step / extent.count).round()).abs() < 0.01;
        let text = format!(
            "moves in {size:.0} steps of {:.3} {} and stands still between them: as rounded, with accelerations that it does not have; give \
             finer angles, or harmonics",
            extent.count, channel.unit
        );
        let about = series.about(channel.name);
        (still > STANDS * channel.samples.len() as f64 && size > VALUES - 1.5 && steps().all(even))
            .then(|| Finding::new("data.coarse", &STEPS, about, size, text).in_channel(channel.name))
    };
    series.channels.iter().zip(extents).filter_map(told).collect()
}

/// Samples in a row in which all channels stand still for it to be odd. *Choice.*
const TOGETHER: usize = 8;
/// Rests of one length above which they are a rate. *Choice.*
const HELD: usize = 5;

/// The finding that all loads stand still together, leaping there: a plug that is loose, a logger that waits.
fn standing(series: &Series, extents: &[Option<Extent>]) -> Option<Finding> {
    let moving: Vec<(&MeasuredChannel, Extent)> = series
        .channels
        .iter()
        .zip(extents)
        .filter_map(|(channel, extent)| Some((channel, (*extent)?)))
        .filter(|(channel, extent)| extent.range() > COUNTS.value * extent.count && series.is_load(channel))
        .collect();
    if moving.is_empty() {
        return None;
    }
    let still = |k: usize| moving.iter().all(|(channel, _)| channel.samples[k] == channel.samples[k - 1]);
    let leaps = |k: usize| {
        let leap = |(channel, extent): &(&MeasuredChannel, Extent)| {
            (channel.samples[k] - channel.samples[k - 1]).abs() > same::TO_REST * extent.range()
        };
        k > 0 && moving.iter().any(leap)
    };
    let count = series.phase.len();
    let (mut lost, mut times, mut begin) = (0, 0, 0);
    // Shortest and longest of the rests: those of a lower rate that is held are alike.
    let mut rests = [usize::MAX, 0];
    for k in 1..=count {
        if k < count && still(k) {
            continue;
        }
        let odd = k - begin >= TOGETHER && (leaps(begin) || (k < count && leaps(k)));
        lost += if odd { k - begin } else { 0 };
        times += usize::from(odd);
        // The first and the last may be cut off.
        if odd && begin > 0 && k < count {
            rests = [rests[0].min(k - begin), rests[1].max(k - begin)];
        }
        begin = k;
    }
    let share = lost as f64 / count.max(1) as f64;
    let text = format!(
        "all channels leap and stand still together {times} times, for {:.1} % of the samples: a loose plug, or records that were \
         filled in; cut them out",
        100.0 * share
    );
    let found = || Finding::new("data.lost", &LOST, series.what, share, text);
    if times > HELD && rests[1] <= rests[0] + 1 {
        let text = format!(
            "all channels stand still for {} samples again and again: values of a lower rate, held in between",
            rests[0]
        );
        return Some(Finding::new("data.lost", &LOST, series.what, share, text).noted());
    }
    (times > 0).then(found)
}

/// So many values of a channel that are no numbers.
pub fn not_finite(what: &str, channel: &str, count: usize) -> Option<Finding> {
    let text = format!("{count} samples are not finite: cut them out of the file");
    let about = format!("{channel} of {what}");
    (count > 0)
        .then(|| Finding::new("data.not_finite", &NOT_FINITE, about, count as f64, text).in_channel(channel))
}

fn of_channel(
    series: &Series,
    (channel, extent): (&MeasuredChannel, Extent),
    placed: &plateau::PlacedSamples,
    limits: &RunLimits,
) -> Vec<Finding> {
    let about = || series.about(channel.name);
    let largest = extent.high.abs().max(extent.low.abs());
    let text = format!("the largest value is {largest:.3e} {}: check the unit and the scale", channel.unit);
    let huge = Finding::new("data.huge", &HUGE, about(), largest, text);
    let mut found = vec![huge];
    found.extend(same::findings(series, channel, extent));
    if series.purpose.is_loads() && extent.range() > 0.0 {
        found.extend(stuck(series, channel, extent));
        let breaks = |finding: &Finding| finding.breaks(limits);
        let clipped = clipped(series, channel, extent, &[extent.high, extent.low]).filter(breaks);
        let within = || clipped_within(series, channel, extent).filter(breaks);
        let places = placed.of(channel.samples);
        found.extend(places.iter().filter_map(|places| plateau::two_sources(series, channel, places)));
        found.extend(rectified(series, channel, extent));
        let cut = || plateau::cut_off(series, (channel, extent.count), placed, places.as_ref()?);
        found.extend(clipped.or_else(within).or_else(cut));
    } else if extent.range() > 0.0 {
        let clipped = clipped(series, channel, extent, &[extent.high, extent.low]);
        found.extend(clipped.map(|clipped| clipped.explained(Cause::Stop, series.purpose)));
    }
    found
}

/// Channels of which none moves, or none that moves is of a size that can be measured.
fn nothing(series: &Series, extents: &[Option<Extent>]) -> Option<Finding> {
    let known: Vec<Extent> = extents.iter().copied().collect::<Option<_>>()?;
    let many = series.phase.len() > 1 && !known.is_empty();
    let most = known.iter().map(|extent| extent.high.abs().max(extent.low.abs())).fold(0.0, f64::max);
    if many && series.purpose.is_loads() && known.iter().all(|extent| extent.range() == 0.0) {
        let names: Vec<&str> = series.channels.iter().map(|channel| channel.name).collect();
        let text = format!(
            "{} never change: is the cell connected, is it the right file, and are these the right columns?",
            names.join(", ")
        );
        return Some(Finding::new("data.dead", &TINY, series.what, 0.0, text));
    }
    let text = format!("the largest value of all channels is {most:.1e}: check the unit and the scale");
    (most > 0.0).then(|| Finding::new("data.tiny", &TINY, series.what, most, text))
}

/// The longest stay within one count of a channel that spans many.
fn stuck(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    if extent.range() < SPAN * extent.count {
        return None;
    }
    let (from, to) = longest_stay(channel.samples, extent.count);
    let cycles = series.phase[to] - series.phase[from];
    if cycles > STUCK.value && rests(series, channel, from..to) {
        let text = format!(
            "stays within {:.3e} {} for {cycles:.2} cycles from sample {} on, as all loads do: the wings rest; average the strokes alone",
            extent.count,
            channel.unit,
            from + 1
        );
        let found = Finding::new("data.stuck", &STUCK, series.about(channel.name), cycles, text);
        return Some(found.explained(Cause::Strokes, series.purpose));
    }
    let text = format!(
        "stays within {:.3e} {} for {cycles:.2} cycles from sample {} on, though it moves by {:.3e} elsewhere: \
         the channel was stuck; leave that part out",
        extent.count,
        channel.unit,
        from + 1,
        extent.range()
    );
    let found = Finding::new("data.stuck", &STUCK, series.about(channel.name), cycles, text);
    // What is no load, as a temperature, may stand still beside loads.
    Some(if series.is_load(channel) { found } else { found.noted() })
}

/// Part of its range that a channel moves by while the wings rest, at most. *Choice.*
const RESTS: f64 = 0.1;

/// Whether the other loads rest meanwhile as well; of a file of one whether it is the start.
fn rests(series: &Series, channel: &MeasuredChannel, there: std::ops::Range<usize>) -> bool {
    let range = |of: &[f64]| Extent::of(of).map_or(0.0, Extent::range);
    let others = || {
        let all = series.channels.iter().filter(|other| other.name != channel.name && series.is_load(other));
        all.filter(|other| range(other.samples) > 0.0)
    };
    let rest = |other: &MeasuredChannel| range(&other.samples[there.clone()]) < RESTS * range(other.samples);
    if others().next().is_none() { there.start == 0 } else { others().all(rest) }
}

/// First and last sample of the longest stretch whose values lie within `count` of its first.
fn longest_stay(samples: &[f64], count: f64) -> (usize, usize) {
    let (mut best, mut from) = ((0, 0), 0);
    let within = 1.0001 * count;
    for (k, x) in samples.iter().enumerate() {
        if (x - samples[from]).abs() > within {
            from = k;
        } else if k - from > best.1 - best.0 {
            best = (from, k);
        }
    }
    best
}

/// The same at a level within: what clips at times only. Zero is that of a line that goes slack, and of drop-outs.
fn clipped_within(series: &Series, channel: &MeasuredChannel, extent: Extent) -> Option<Finding> {
    let mut levels: Vec<(f64, usize)> = Vec::new();
    for run in channel.samples.chunk_by(|a, b| a == b) {
        if run.len() >= ROW && run[0] != 0.0 {
            levels.push((run[0], run.len()));
        }
    }
    wingbeat_math::order::ascend_by(&mut levels, |item| item.0);
    let most = levels.chunk_by(|a, b| a.0 == b.0).filter(|level| level.len() > 1);
    let most = most.max_by_key(|level| level.iter().map(|run| run.1).sum::<usize>())?;
    if same::dead_band(channel.samples, most[0].0, extent) {
        return None;
    }
    clipped(series, channel, extent, &[most[0].0])
}

/// The share of the samples on flat ends that the values below do not lead to.
fn clipped(series: &Series, channel: &MeasuredChannel, extent: Extent, ends: &[f64]) -> Option<Finding> {
    let band = (BAND * extent.range()).max(1.5 * extent.count);
    let mut worst: Option<(f64, f64)> = None;
    for end in ends.iter().copied() {
        if channel.samples.iter().filter(|x| **x == end).count() < ROW {
            continue;
        }
        let (mut at, mut near, mut row, mut rows) = (0_usize, 0_usize, 0_usize, 0_usize);
        for x in channel.samples {
            let on = *x == end;
            near += usize::from(!on && (x - end).abs() <= band);
            row = if on { row + 1 } else { 0 };
            rows = rows.max(row);
            at += usize::from(on);
        }
        // The values lead to where a load is cut off, and not to the zero about which an instrument has a dead band.
        let off = channel.samples.iter().map(|x| (x - end).abs()).filter(|off| *off > 0.0);
        if end == 0.0 && off.fold(f64::INFINITY, f64::min) > APART * band {
            continue;
        }
        let share = at as f64 / channel.samples.len() as f64;
        let flat = rows >= ROW && at as f64 > STEEP * near as f64;
        if flat && worst.is_none_or(|(most, _)| share > most) {
            worst = Some((share, end));
        }
    }
    let (share, end) = worst?;
    let text = format!(
        "{:.1} % of the samples stand at {end:.6} {}: clipped, so that means and harmonics are too small; \
         take a wider range, or leave those cycles out",
        100.0 * share,
        channel.unit
    );
    Some(Finding::new("data.clipped", &CLIPPED, series.about(channel.name), share, text))
}
