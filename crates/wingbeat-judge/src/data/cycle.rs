//! What repeats with the cycle, what is noise, and what is neither.

use super::backwards::backwards;
use super::ends;
use super::frequency::{self, Frequency};
use super::noise::median;
use super::outliers::place;
use super::strokes::{self, StrokeVariation};
use super::values::Extent;
use super::{Cause, Finding, MeasuredChannel, Purpose, Series};
use crate::limits::RunLimits;
use crate::limits::data::{APERIODIC, DRIFT, FREQUENCY, ROUGH, SHARE, SIGNAL, SWINGS};
use std::cell::LazyCell;
use std::ops::Deref;
use wingbeat_math::Harmonics;

/// Harmonics of a cycle. *Choice*: loads of a flapping wing have five.
pub(super) const HARMONICS: usize = 8;
/// Samples at least for each number that is fitted. *Choice.*
const SPARE: usize = 2;
/// Cycles from which a drift is told from the cycle. *Choice.*
const FOR_DRIFT: f64 = 2.5;
/// Points to which long records are averaged, and points in a cycle at least. *Choice*: what they cost is below 1 ms.
const POINTS: usize = 1536;
const POINTS_PER_CYCLE: usize = 32;
/// Deviation of a channel in parts of the largest of its unit below which it is not judged. *Choice.*
const TELLING: f64 = 0.05;
/// The same below which it is small. *Choice.*
const SMALL: f64 = 0.2;
/// Deviation of a motion, in parts of its mean, below which it stands still. *Choice.*
const STILL: f64 = 1e-4;
/// Share of what does not repeat above which the frequency is sought. *Choice.*
const SEEKS: f64 = 0.02;
/// Share of the power that another frequency must explain for it to be believed. *Choice.*
const EXPLAINS: f64 = 0.5;
/// Samples from which a table of one cycle tells how long that is, and cycles of the frequency given that it may last. *Choice.*
const FEW: usize = 16;
const ONE_CYCLE: std::ops::Range<f64> = 0.7..1.5;
/// Steps from the last sample to the next cycle: none where the first is given again, else one; a lost sample is another
/// finding. *Choice.*
const NO_GAP: std::ops::Range<f64> = -0.5..2.5;
/// Third over second differences of what harmonics leave: white noise has 1.83, a smooth curve less than 1. *Choice.*
const WHITE: f64 = 1.2;

/// A channel apart: cycle, drift, noise, and what is left.
pub(super) struct ChannelParts {
    /// Variance about the mean.
    pub total: f64,
    /// Variance of the cycle.
    signal: f64,
    /// Variance of what changes from sample to sample.
    pub white: f64,
    /// Variance of what is neither.
    pub slow: f64,
    /// Change by the parabola through what the cycle leaves, begin to end at most, and the share of `slow` it is.
    drift: (f64, f64),
    /// Largest less least of the cycle.
    range: f64,
    pub mean: f64,
    /// Numbers fitted, samples.
    fitted: usize,
    count: usize,
}

/// A channel that moves, with its parts.
pub(super) struct SplitChannel<'a> {
    pub channel: &'a MeasuredChannel<'a>,
    pub at: Condensed,
    pub part: ChannelParts,
    /// What the harmonics leave.
    pub left: Vec<f64>,
}

impl<'a> SplitChannel<'a> {
    /// Of all channels that are finite and move.
    fn of_all(series: &'a Series, cycles: f64) -> Vec<Self> {
        let finite = |channel: &&MeasuredChannel| channel.samples.iter().all(|x| x.is_finite());
        let size = Condensed::size(series.phase.len(), cycles);
        let phase = means(series.phase, size);
        let condensed = |channel: &'a MeasuredChannel<'a>| {
            (channel, Condensed { phase: phase.clone(), values: means(channel.samples, size) })
        };
        let all: Vec<_> = series.channels.iter().filter(finite).map(condensed).collect();
        let values: Vec<&[f64]> = all.iter().map(|(_, at)| &at.values[..]).collect();
        let fits = harmonics(phase.len(), cycles)
            .and_then(|count| Harmonics::fitted_each(1.0, &phase, &values, count))
            .unwrap_or_default();
        let fitted = Harmonics::each_at(&fits, &phase);
        let apart = |((channel, at), (cycle, fitted)): (
            (&'a MeasuredChannel<'a>, Condensed),
            (&Harmonics, Vec<f64>),
        )| {
            let (part, left) = ChannelParts::of(&at, cycles, (cycle, fitted));
            let still = if series.purpose == Purpose::Motion { STILL * part.mean.abs() } else { 0.0 };
            (part.total.sqrt() > still).then_some(Self { channel, at, part, left })
        };
        all.into_iter().zip(fits.iter().zip(fitted)).filter_map(apart).collect()
    }

    /// Whether it repeats at the frequency that is given for it.
    fn repeats(&self) -> bool {
        let ChannelParts { slow, signal, total, .. } = self.part;
        slow <= SEEKS * total && signal > EXPLAINS * total
    }

    /// Whether it moves enough beside those of its unit: the noise of a channel without a load may be of any kind.
    pub fn is_telling(&self, all: &[Self]) -> bool {
        self.part.total > TELLING * TELLING * self.most(all)
    }

    /// Whether others of its unit that repeat dwarf it.
    fn is_small(&self, all: &[Self]) -> bool {
        self.part.total < SMALL * SMALL * self.most(all)
            && all.iter().any(|other| other.part.signal > EXPLAINS * other.part.total)
    }

    /// The largest variance of a channel of its unit.
    fn most(&self, all: &[Self]) -> f64 {
        let same = all.iter().filter(|other| other.channel.unit == self.channel.unit);
        same.map(|other| other.part.total).fold(0.0, f64::max)
    }
}

/// A channel at fewer points.
pub(super) struct Condensed {
    pub phase: Vec<f64>,
    pub values: Vec<f64>,
}

impl Condensed {
    pub fn of(phase: &[f64], samples: &[f64], cycles: f64) -> Self {
        let size = Self::size(phase.len(), cycles);
        Self { phase: means(phase, size), values: means(samples, size) }
    }

    /// How many of `count` samples become one.
    fn size(count: usize, cycles: f64) -> usize {
        let points = POINTS.max(POINTS_PER_CYCLE * cycles.min(1e6) as usize);
        count.div_ceil(points.max(1)).max(1)
    }
}

/// Means of so many values that follow one another.
fn means(of: &[f64], size: usize) -> Vec<f64> {
    of.chunks(size).map(|of| of.iter().sum::<f64>() / of.len() as f64).collect()
}

/// Findings of all channels.
pub fn findings(series: &Series, limits: &RunLimits) -> Vec<Finding> {
    let cycles = series.cycles();
    let lasting: Vec<Finding> = series.channels.iter().filter_map(|channel| lasts(series, channel)).collect();
    if !lasting.is_empty() {
        return lasting;
    }
    let mut found: Vec<Finding> = ends::gap(series, cycles).into_iter().collect();
    found.extend(ends::sparse(series, cycles));
    found.extend(series.channels.iter().filter_map(|channel| ends::apart(series, channel)));
    if !(cycles >= 0.9) {
        return found;
    }
    let all = SplitChannel::of_all(series, cycles);
    // All channels of a file have one frequency: where one repeats at that which is given, what others leave is no other frequency.
    let kept = all.iter().any(|one| one.is_telling(&all) && one.repeats());
    let strokes: Vec<StrokeVariation> = all.iter().map(|one| StrokeVariation::of(series, one)).collect();
    for (k, one) in all.iter().enumerate().filter(|(_, one)| one.is_telling(&all)) {
        let by_wings = LazyCell::new(|| strokes::are_of_wings(series, &all, &strokes, k));
        let own = of_channel(series, (one, &strokes[k]), (kept, &by_wings), limits).into_iter();
        // Beside a large load, a small one may hold what the mount does.
        let noted = |finding: Finding| match finding.id {
            "data.not_periodic" if one.is_small(&all) => finding.noted(),
            // Nor has a wind or a temperature beside loads a cycle.
            "data.not_periodic" | "data.drift" if !series.is_load(one.channel) => finding.noted(),
            _ => finding,
        };
        found.extend(own.map(noted));
        found.extend(rough(series, one));
        if one.part.slow > SEEKS * one.part.total && series.purpose.is_loads() {
            found.extend(backwards(series, one.channel, &one.at));
        }
    }
    if series.purpose.is_loads() {
        found.extend(all.iter().filter_map(|one| without_order(series, one, &all)));
        found.extend(without_signal(series, &all));
    }
    found
}

/// Harmonics that so many samples of so many cycles determine; none where there are too few.
fn harmonics(count: usize, cycles: f64) -> Option<usize> {
    let per_cycle = count as f64 / cycles.max(1.0);
    let harmonics = HARMONICS.min((per_cycle / (2.0 * SPARE as f64)) as usize);
    (harmonics > 0).then_some(harmonics)
}

impl ChannelParts {
    /// Of a channel whose harmonics are `cycle`, which have the values `fitted`, and what those leave of it.
    fn of(at: &Condensed, cycles: f64, (cycle, fitted): (&Harmonics, Vec<f64>)) -> (Self, Vec<f64>) {
        let values = &at.values;
        let count = values.len();
        let left: Vec<f64> = values.iter().zip(&fitted).map(|(x, fit)| x - fit).collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        let rest = variance(&left);
        let steps = left.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
        let white = (0.5 * steps / (count - 1).max(1) as f64).min(rest);
        let (low, high) = fitted.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
        let drift = if cycles >= FOR_DRIFT { drifted(&left, rest) } else { (0.0, 0.0) };
        let part = Self {
            total: variance(values),
            signal: variance(&fitted),
            white,
            slow: (rest - white).max(0.0) * (1.0 - drift.1),
            drift,
            range: high - low,
            mean,
            fitted: 2 * cycle.cos.len(),
            count,
        };
        (part, left)
    }

    /// Power of the cycle over what the noise makes of it, each by its degrees of freedom.
    fn over_noise(&self) -> f64 {
        let noise = (self.white + self.slow) / (self.count.saturating_sub(self.fitted + 1)).max(1) as f64;
        self.signal / self.fitted as f64 / noise.max(f64::MIN_POSITIVE)
    }
}

/// Places of a cycle by which it is looked what of a rest repeats beyond the harmonics. *Choice.*
const PLACES: usize = 64;

/// Variance of what of `left` repeats with the cycle: impacts have more harmonics than are fitted.
fn repeated(phase: &[f64], left: &[f64]) -> f64 {
    let mut sums = [(0.0, 0.0); PLACES];
    for (p, x) in phase.iter().zip(left) {
        let of = &mut sums[place(*p, PLACES)];
        *of = (of.0 + x, of.1 + 1.0);
    }
    let there = sums.iter().filter(|(_, count)| *count > 0.0);
    there.map(|(sum, count)| sum * sum / count).sum::<f64>() / left.len().max(1) as f64
}

/// Mean square about the mean.
pub(super) fn variance(of: &[f64]) -> f64 {
    let mean = of.iter().sum::<f64>() / of.len() as f64;
    of.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / of.len() as f64
}

/// Change by the straight line and parabola through `left`, and the share of its variance that they are.
fn drifted(left: &[f64], variance: f64) -> (f64, f64) {
    let count = left.len() as f64;
    let at = |k: usize| 2.0 * (k as f64 + 0.5) / count - 1.0;
    let (mut line, mut bow) = (0.0, 0.0);
    for (k, x) in left.iter().enumerate() {
        let u = at(k);
        line += x * u * 3.0 / count;
        bow += x * (u * u - 1.0 / 3.0) * 11.25 / count;
    }
    let value = |u: f64| line * u + bow * u * u;
    // The top of the parabola, where it lies within.
    let top = if bow == 0.0 { 0.0 } else { (-line / (2.0 * bow)).clamp(-1.0, 1.0) };
    let ends = [value(-1.0), value(1.0), value(top)];
    let change =
        ends.iter().copied().fold(f64::MIN, f64::max) - ends.iter().copied().fold(f64::MAX, f64::min);
    let own = line * line / 3.0 + bow * bow * 4.0 / 45.0;
    (change, if variance > 0.0 { (own / variance).min(1.0) } else { 0.0 })
}

/// Of a channel; `kept` says that the frequency given is that of the file, `by_wings` that the wings change the size of its cycles.
fn of_channel(
    series: &Series,
    (one, strokes): (&SplitChannel, &StrokeVariation),
    (kept, by_wings): (bool, &dyn Deref<Target = bool>),
    limits: &RunLimits,
) -> Vec<Finding> {
    let SplitChannel { channel, at, part, .. } = one;
    let about = || series.about(channel.name);
    let share = part.slow / part.total;
    if share > SEEKS
        && !kept
        && let Some(found) = frequency::estimate(&at.phase, &at.values)
        && let Some(finding) = other_frequency(series, channel, part, found, limits)
    {
        return vec![finding];
    }
    let mut found = Vec::new();
    if series.purpose.is_loads() || series.cycles() >= 2.0 {
        // Strokes of another size are strokes.
        let odd = |share: f64| share > limits.of(&APERIODIC).0;
        let may = series.purpose.allows(Cause::Strokes);
        let share =
            if odd(share) && may && **by_wings { share.min(strokes.left(part) / part.total) } else { share };
        let text = format!(
            "{:.0} % of its power neither repeats with the cycle nor is noise: the motion does not repeat, or the \
             file holds more than the steady part; cut it to that",
            100.0 * share
        );
        let swings = share - repeated(&at.phase, &one.left) / part.total;
        let (limit, share) = if odd(share) { (&APERIODIC, share) } else { (&SWINGS, swings) };
        let finding = Finding::new("data.not_periodic", limit, about(), share, text);
        // Where all but noise repeats, no cycle comes early or late.
        let late = if part.slow > SEEKS * part.total { strokes.phases(series, one) } else { Vec::new() };
        let of_size = || strokes.sizes(series, one).into_iter().filter(|of| of.breaks(limits));
        let sizes = of_size().map(|of| if **by_wings { strokes::explained(of, series.purpose) } else { of });
        let scatter = late.into_iter().filter(|of| of.breaks(limits)).chain(sizes);
        // Of several reasons one that refuses the data.
        let scatter = scatter.max_by_key(|finding| (finding.serious, finding.limit.status.is_some()));
        found.push(match scatter {
            Some(scatter) if !(finding.serious && finding.breaks(limits)) => scatter,
            _ => finding,
        });
        found.extend(strokes.runs_away(series, one, limits));
    }
    found.extend(drift(series, one).map(|of| {
        // The mean of a load changes with the size of the strokes.
        let wings = of.breaks(limits) && strokes.differ(part) && **by_wings;
        if wings { of.explained(Cause::Strokes, series.purpose) } else { of }
    }));
    found
}

/// The finding that the mean changes from start to end.
fn drift(series: &Series, one: &SplitChannel) -> Option<Finding> {
    let SplitChannel { channel, part, .. } = one;
    let scale = part.range.max(part.mean.abs());
    let told = part.drift.0 > 6.0 * (part.white / part.count as f64).sqrt() && part.drift.1 > 0.02;
    let size = part.drift.0 / scale;
    let text = format!(
        "drifts by {:.4} {} from start to end, {:.0} % of its cycle: means and tare are off; let the cell \
         warm up, take a rest before and after, or take the drift away before",
        part.drift.0,
        channel.unit,
        100.0 * size
    );
    (told && scale > 0.0).then(|| Finding::new("data.drift", &DRIFT, series.about(channel.name), size, text))
}

/// The finding that the data repeat at another frequency than the one given.
fn other_frequency(
    series: &Series,
    channel: &MeasuredChannel,
    part: &ChannelParts,
    found: Frequency,
    limits: &RunLimits,
) -> Option<Finding> {
    let Frequency { ratio, error, explained } = found;
    let size = (ratio - 1.0).abs();
    let believed = explained > EXPLAINS && explained > part.signal / part.total + SEEKS && size > 4.0 * error;
    if !(believed && size > limits.of(&FREQUENCY).0) {
        return None;
    }
    let (given, told) = match series.frequency_hz {
        Some(f) => (format!("{f} Hz"), format!("{:.4} +- {:.4} Hz", ratio * f, error * f)),
        None => ("a cycle".into(), format!("{:.4} +- {:.4} cycles per cycle", ratio, error)),
    };
    let text = format!(
        "repeats at {told}, but {given} is given for it: harmonics of {given} leave {:.0} % of its power; give the \
         frequency of the data",
        100.0 * (part.white + part.slow) / part.total
    );
    let finding = Finding::new("data.frequency", &FREQUENCY, series.about(channel.name), size, text);
    Some(Finding { certain: 1.0 / error, ..finding.in_channel(channel.name) })
}

/// The finding that a table of one cycle lasts longer or shorter than that of the frequency given: even steps, and the
/// last leads into the first.
fn lasts(series: &Series, channel: &MeasuredChannel) -> Option<Finding> {
    let (given, cycles, y) = (series.frequency_hz?, series.cycles(), channel.samples);
    if series.purpose != Purpose::Motion {
        return None;
    }
    let steps: Vec<f64> = series.phase.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = cycles / steps.len().max(1) as f64;
    let even = steps.iter().all(|one| (one - step).abs() < 0.5 * step);
    let gap = (1.0 - cycles) / step;
    let (first, last) = (*y.first()?, *y.last()?);
    if steps.len() < FEW || !even || !ONE_CYCLE.contains(&cycles) || NO_GAP.contains(&gap) {
        return None;
    }
    let moved: Vec<f64> = y.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let most = moved.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
    let turned = (moved.first()? - moved.last()?).abs();
    if !(most > 0.0 && (last - first).abs() <= 1.5 * most && turned <= 0.5 * most) {
        return None;
    }
    let whole = if (last - first).abs() < 0.25 * most { cycles } else { cycles + step };
    let text = format!(
        "its one cycle lasts {:.4} s, that of {:.4} Hz, but {given} Hz is given for it: the motion would jump from \
         the last sample to the first; give the frequency of the data",
        whole / given,
        given / whole
    );
    let size = (1.0 / whole - 1.0).abs();
    let finding = Finding::new("data.frequency", &FREQUENCY, series.about(channel.name), size, text);
    Some(finding.in_channel(channel.name))
}

/// The finding that the noise of a motion makes its acceleration.
fn rough(series: &Series, one: &SplitChannel) -> Option<Finding> {
    let SplitChannel { channel, at, left, .. } = one;
    if series.purpose != Purpose::Motion || at.values.len() < 16 || at.values.len() != channel.samples.len() {
        return None;
    }
    let fitted: Vec<f64> = at.values.iter().zip(left).map(|(x, left)| x - left).collect();
    let (noise, motion) = (differences(left, 2), differences(&fitted, 2));
    if !(differences(left, 3) > WHITE * noise && motion > 0.0) {
        return None;
    }
    let size = noise / motion;
    let text = format!(
        "noise of {:.3} {} makes accelerations of {size:.2} times those of the motion, and loads alike: \
         a fit of harmonics takes it away",
        noise / 6.0_f64.sqrt(),
        channel.unit
    );
    Some(Finding::new("data.rough", &ROUGH, series.about(channel.name), size, text))
}

/// Root mean square of the differences of that order.
fn differences(of: &[f64], order: usize) -> f64 {
    let mut of = of.to_vec();
    for _ in 0..order {
        of = of.windows(2).map(|pair| pair[1] - pair[0]).collect();
    }
    (of.iter().map(|x| x * x).sum::<f64>() / of.len().max(1) as f64).sqrt()
}

/// Deviation of what changes from sample to sample over the median of that of the other channels of its unit, and kurtosis (3 of a normal
/// distribution), from which a channel without a cycle is no noise of a cell. *Choices.*
const NOISIER: f64 = 5.0;
const PEAKED: f64 = 2.6;
/// Standard errors sqrt(24 / n) by which the kurtosis lies below 3, and steps of the converter that a channel spans, at least. *Choices.*
const SURE: f64 = 5.0;
const SPANS: f64 = 20.0;

/// The finding that a channel has no cycle where others of the file have, and is no noise of its cell: its rows are out of order, or its
/// cable is broken.
///
/// The channels of one unit have about the same noise. Of one alone of its unit it tells that noise of a cell is normally distributed, and a
/// load has a kurtosis of 1.5 to 2.5 in any order of its samples: normal noise is below 2.6 and five standard errors once in 3e6.
fn without_order(series: &Series, one: &SplitChannel, all: &[SplitChannel]) -> Option<Finding> {
    let SplitChannel { channel, part, .. } = one;
    let others = || all.iter().filter(|other| other.channel.name != channel.name);
    let repeats =
        others().any(|other| other.is_telling(all) && other.part.signal > EXPLAINS * other.part.total);
    let order = part.over_noise();
    if !repeats || order >= SIGNAL.value || part.white < EXPLAINS * part.total {
        return None;
    }
    if twice_a_cycle(&one.at) {
        return None;
    }
    let same = others().filter(|other| other.channel.unit == channel.unit);
    let mut noise: Vec<f64> = same.map(|other| other.part.white).collect();
    let noisier = !noise.is_empty() && part.white > NOISIER * NOISIER * median(&mut noise);
    let extent = Extent::of(channel.samples)?;
    let mean = part.mean;
    let (second, fourth) = channel.samples.iter().fold((0.0, 0.0), |(a, b), x| {
        let square = (x - mean).powi(2);
        (a + square, b + square * square)
    });
    let count = channel.samples.len() as f64;
    // Means over some samples have less of it.
    if second / count < SMALL * SMALL * one.most(all) {
        return None;
    }
    let peaked = fourth * count / (second * second);
    let bounded = noise.is_empty()
        && peaked < PEAKED.min(3.0 - SURE * (24.0 / count).sqrt())
        && extent.range() > SPANS * extent.count;
    let text = "has no cycle though others have, and is no noise of a cell: its rows are out of order, or its cable is broken";
    (noisier || bounded).then(|| {
        Finding::new("data.noise", &SIGNAL, series.about(channel.name), order, text).in_channel(channel.name)
    })
}

/// Whether two harmonics explain a channel: a load at twice the frequency of the cycle has so few samples a period at a low rate that it
/// changes from sample to sample as noise does.
fn twice_a_cycle(at: &Condensed) -> bool {
    let values = &at.values;
    let Some(cycle) = Harmonics::fitted(1.0, &at.phase, values, 2).filter(|_| values.len() > FEW) else {
        return false;
    };
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (left, all) = at.phase.iter().zip(values).fold((0.0, 0.0), |(left, all), (phase, x)| {
        (left + (x - cycle.at(*phase)).powi(2), all + (x - mean).powi(2))
    });
    left < (1.0 - EXPLAINS) * all
}

/// The findings that no channel has a cycle.
fn without_signal(series: &Series, all: &[SplitChannel]) -> Vec<Finding> {
    let parts = || all.iter().map(|one| &one.part);
    let Some(best) = parts().max_by(|a, b| a.over_noise().total_cmp(&b.over_noise())) else {
        return Vec::new();
    };
    let most = parts().map(|part| part.signal / part.total).fold(0.0, f64::max);
    let text = "no channel has a load that repeats with the cycle: noise, or another frequency; check the file, \
                its columns and the frequency";
    vec![
        Finding::new("data.noise", &SIGNAL, series.what, best.over_noise(), text),
        Finding::new("data.noise", &SHARE, series.what, most, text),
    ]
}
