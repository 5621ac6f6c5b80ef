//! A channel that was cut off before noise was added: its end is flat, and quieter than the rest of the cycle.

use super::noise::{OF_MEDIAN, median};
use super::outliers::place;
use super::spread::CycleSpread;
use super::{Finding, MeasuredChannel, Series};
use crate::limits::data::{CLIPPED, TWO_SOURCES};

/// Places of the cycle at least and at most, and samples of each at least. *Choice.*
const PLACES: [usize; 2] = [24, 64];
const SAME: usize = 12;
/// Samples of a place that tell its noise. *Choice.*
const ENOUGH: usize = 48;
/// Mean square of where samples lie in their place, below which they lie at one phase; evenly spread ones have 1 / 12. *Choice.*
const ONE_PHASE: f64 = 0.01;
/// Part of the range within which the end is flat, and the places on it, in parts of a cycle. A slack line is flat for longer. *Choices.*
const FLAT: f64 = 0.01;
const SHARE: std::ops::Range<f64> = 0.05..0.36;
/// Share of a cycle up to which one that is flat for longer, and not near zero, is noted. *Choice.*
const LONG: f64 = 0.6;
/// Part of the range that the errors of the mean cycle may have. *Choice.*
const BURIED: f64 = 0.05;
/// Part of the range within which an end is near zero. *Choice.*
const SLACK: f64 = 0.15;
/// Variance of the noise at the end over that elsewhere: what is cut off has that of the converter alone. Right loads went down to 0.55 in
/// the worst of 570 files with noise and with unsteady cranks (measured). *Choice.*
const QUIET: f64 = 0.4;
/// The share by which the variance at the end must be below that elsewhere, times the root of the samples there: four standard errors of a
/// variance, 4 sqrt(2 / 0.37 n), of which the median of magnitudes uses 0.37. *Choice.*
const SURE: f64 = 9.3;
/// Standard errors by which the variance elsewhere may be smaller, and its share that the slope may explain. *Choices.*
const ERRORS: f64 = 2.0;
const BY_SLOPE: f64 = 0.5;
/// Places elsewhere at least. *Choice.*
const ELSEWHERE: usize = 8;
/// Noise in parts of the range and in counts of the converter at least, for less of it to be seen. *Choice.*
const NOISE: [f64; 2] = [0.002, 2.0];

/// Mean, and noise about a line, of the samples of a place.
#[derive(Clone, Copy)]
pub(super) struct PlaceStatistics {
    mean: f64,
    noise: f64,
    count: f64,
    /// Variance about the line, and the fourth moment over its square.
    variance: f64,
    peaked: f64,
}

/// Part of the range that the samples of a place scatter by for their distribution to be looked at, share of the places that must, and share
/// of the scatter that comes from one sample to the next. *Choices.*
const SCATTERS: f64 = 0.05;
const MANY: f64 = 0.5;
const AT_ONCE: f64 = 0.3;

/// The finding that the samples of one phase have two values, and change between them from one to the next: two sources in one column.
pub(super) fn two_sources(
    series: &Series,
    channel: &MeasuredChannel,
    places: &[PlaceStatistics],
) -> Option<Finding> {
    let (low, high) = places.iter().fold((f64::MAX, f64::MIN), |(l, h), of| (l.min(of.mean), h.max(of.mean)));
    let wide: Vec<&PlaceStatistics> =
        places.iter().filter(|of| of.variance.sqrt() > SCATTERS * (high - low)).collect();
    if (wide.len() as f64) < MANY * places.len() as f64 {
        return None;
    }
    let count = wide.len() as f64;
    let size = wide.iter().map(|of| of.peaked).sum::<f64>() / count;
    if size > TWO_SOURCES.value {
        return None;
    }
    let variance = wide.iter().map(|of| of.variance).sum::<f64>() / count;
    let steps = channel.samples.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
    let text = "the samples of one phase have two values, and change between them from one to the next: two sources in one column";
    (0.5 * steps > AT_ONCE * variance * channel.samples.len() as f64).then(|| {
        let found = Finding::new("data.alternates", &TWO_SOURCES, series.about(channel.name), size, text)
            .in_channel(channel.name);
        if is_line(series, channel, places) { found.noted() } else { found }
    })
}

/// Samples after which what comes again is a line, the samples that tell, and their correlation. Of any period some few fill nearly a whole
/// number of samples. *Choices.*
const AGAIN: std::ops::RangeInclusive<usize> = 2..=64;
const TOLD: usize = 4096;
const LIKE: f64 = 0.7;

/// Whether what the mean cycle leaves comes again after few samples: a line, as of the mains or a motor driver.
fn is_line(series: &Series, channel: &MeasuredChannel, places: &[PlaceStatistics]) -> bool {
    let off = |(p, x): (&f64, &f64)| x - places[place(*p, places.len())].mean;
    let left: Vec<f64> = series.phase.iter().zip(channel.samples).take(TOLD).map(off).collect();
    let all = left.iter().map(|x| x * x).sum::<f64>();
    let with =
        |after: usize| left.iter().zip(&left[after.min(left.len())..]).map(|(a, b)| a * b).sum::<f64>();
    AGAIN.into_iter().any(|after| with(after) > LIKE * all)
}

/// Median of the noise of the places of a cycle.
pub(super) fn noise(places: &[PlaceStatistics]) -> Option<f64> {
    let noise = median(&mut places.iter().map(|of| of.noise).collect::<Vec<_>>());
    noise.is_finite().then_some(noise)
}

/// Part of the largest range of its unit below which a channel is dwarfed. *Choice.*
const DWARFED: f64 = 0.5;
/// Deviations of the noise at the end beyond it, and the share of all samples up to which they lie there: an amplifier lets none. *Choice.*
const BEYOND: f64 = 5.0;
const FEW: f64 = 0.003;
/// Slope at the corner over that two places further on: a sine cut off at 98 % has 0.5, a top that flattens by itself (tanh) 0.3. *Choice.*
const CORNER: f64 = 0.45;

/// The finding that an end is cut off under noise; `count` is that of the converter.
///
/// What goes beyond the range of an amplifier is lost with the noise that it has until there, so that the samples of one phase
/// scatter less at the end than elsewhere, more than an unsteady crank explains. A line that goes slack is flat and may be quiet as well,
/// but near zero, and for longer: an end near zero counts only where the other one is flat and quiet too. It is a warning of a channel
/// that others of its unit dwarf, where what moves the mount scatters more than noise does, and where samples lie beyond the end or
/// the load comes to it without a corner: a wing that stalls may have a flat top, and buffet beside it.
pub(super) fn cut_off(
    series: &Series,
    (channel, count): (&MeasuredChannel, f64),
    placed: &PlacedSamples,
    places: &[PlaceStatistics],
) -> Option<Finding> {
    let (low, high) = places.iter().fold((f64::MAX, f64::MIN), |(l, h), of| (l.min(of.mean), h.max(of.mean)));
    let range = high - low;
    let noise = median(&mut places.iter().map(|of| of.noise).collect::<Vec<_>>());
    let within = (FLAT * range).max(3.0 * noise / (series.phase.len() as f64 / places.len() as f64).sqrt());
    if within > BURIED * range {
        return None;
    }
    let near = |end: f64| places.iter().map(move |of| (of.mean - end).abs() <= within);
    // The other end may be cut off as well.
    let ends: Vec<bool> = near(low).zip(near(high)).map(|(low, high)| low || high).collect();
    let share = |end: f64| {
        let on: Vec<bool> = near(end).collect();
        let share = on.iter().filter(|on| **on).count() as f64 / places.len() as f64;
        // Of two bounds from below the larger one.
        let usual = [elsewhere(places, &on, end), elsewhere(places, &ends, end)]
            .into_iter()
            .flatten()
            .reduce(f64::max)?;
        let there = || places.iter().zip(&on).filter(|(_, on)| **on).map(|(of, _)| of);
        let noise = median(&mut there().map(|of| of.noise).collect::<Vec<_>>());
        let below = QUIET.min(1.0 - SURE / there().map(|of| of.count).sum::<f64>().sqrt());
        let seen = usual.sqrt() > (NOISE[0] * range).max(NOISE[1] * count);
        let cut = || beyond(channel, [end, noise, 0.5 * (high + low)]) < FEW && corner(places, &on) > CORNER;
        let flat = (SHARE.start..LONG).contains(&share) && noise * noise < below * usual;
        let noisy = || {
            unsteady(series, channel, placed, places) < UNSTEADY && at_once(series, channel, places) > AT_ONCE
        };
        (seen && flat && noisy()).then(|| (share, share < SHARE.end && cut()))
    };
    let far = |end: f64| end.abs() > SLACK * range;
    let (top, bottom) = (share(high), share(low));
    let (share, end, cut) = match (top, bottom) {
        (Some((top, a)), Some((bottom, b))) => (top + bottom, if top > bottom { high } else { low }, a || b),
        (Some((top, cut)), None) if far(high) => (top, high, cut),
        (None, Some((bottom, cut))) if far(low) => (bottom, low, cut),
        _ => {
            let found = flat_between_corners(series, channel, places, [low, high, within, count]);
            return found.filter(|_| unsteady(series, channel, placed, places) < UNSTEADY);
        }
    };
    let text = format!(
        "is flat at {end:.4} {} for {:.0} % of the cycle, and scatters far less there than elsewhere: cut off before the \
         noise came to it, so that means and harmonics are too small; take a wider range",
        channel.unit,
        100.0 * share
    );
    let of = |samples: &[f64]| samples.iter().fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(*x), h.max(*x)]);
    let same = series.channels.iter().filter(|other| other.unit == channel.unit);
    let most = same.map(|other| of(other.samples)).map(|[low, high]| high - low).fold(0.0, f64::max);
    let [lowest, highest] = of(channel.samples);
    let found = Finding::new("data.clipped", &CLIPPED, series.about(channel.name), share, text);
    Some(if !cut || highest - lowest < DWARFED * most { found.noted() } else { found })
}

/// Slopes beside a corner over those further on, between which the load is cut off there: a sine has 0.9 at seven tenths of its top. Part of
/// the range that it rises by from place to place beside the corner, share of the cycle, and that share over that of a sine, at least.
/// *Choices.*
const SHARP: std::ops::Range<f64> = 0.6..1.3;
const RISES: f64 = 0.015;
const WIDE: f64 = 0.1;
const WIDER: f64 = 1.7;

/// The note that an end is flat between two corners, and as noisy as the rest: cut off, and noise added after, or a load of that shape.
fn flat_between_corners(
    series: &Series,
    channel: &MeasuredChannel,
    places: &[PlaceStatistics],
    [low, high, within, count]: [f64; 4],
) -> Option<Finding> {
    let range = high - low;
    // A load of few counts has corners of its own.
    if range * FLAT < count {
        return None;
    }
    let of = |end: f64| {
        let on: Vec<bool> = places.iter().map(|of| (of.mean - end).abs() <= within).collect();
        let share = on.iter().filter(|on| **on).count() as f64 / places.len() as f64;
        let once = (0..on.len()).filter(|k| on[*k] && !on[(k + 1) % on.len()]).count() == 1;
        let [near, further] = slopes(places, &on);
        let sharp = SHARP.contains(&(near / further)) && near > 2.0 * RISES * range;
        // Of the same width is the top of a sine.
        let least = WIDE.max(WIDER * (1.0 - 2.0 * within / range).acos() / std::f64::consts::PI);
        (once && sharp && end.abs() > SLACK * range && (least..SHARE.end).contains(&share))
            .then_some((share, end))
    };
    let (share, end) = of(high).into_iter().chain(of(low)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let text = format!(
        "is flat at {end:.4} {} for {:.0} % of the cycle between two corners: cut off before noise was added, so that means and harmonics \
         are too small, or a load of that shape",
        channel.unit,
        100.0 * share
    );
    Some(Finding::new("data.clipped", &CLIPPED, series.about(channel.name), share, text).noted())
}

/// Cycles by which the cycles come early and late, rms, from which the ends of any load are quieter than its slopes; parts of the file that
/// are compared, and samples in each. *Choices.*
const UNSTEADY: f64 = 0.015;
const PARTS: usize = 64;
const OF_PART: usize = 32;

/// How early and late the parts of a file come, rms, in cycles: of each the part of the slope of the mean cycle that its samples hold beside
/// that cycle, sum(l g) / sum(g g).
fn unsteady(
    series: &Series,
    channel: &MeasuredChannel,
    placed: &PlacedSamples,
    places: &[PlaceStatistics],
) -> f64 {
    let count = places.len();
    let slope = |at: usize| 0.5 * (places[(at + 1) % count].mean - places[(at + count - 1) % count].mean);
    let parts = PARTS.min(series.cycles() as usize).min(placed.samples.len() / OF_PART).max(1);
    let mut sums = vec![[0.0; 2]; parts];
    for (k, at, within) in &placed.samples {
        let g = slope(*at);
        let [lg, gg] = &mut sums[k * parts / series.phase.len()];
        *lg += (channel.samples[*k] - places[*at].mean - g * within) * g;
        *gg += g * g;
    }
    CycleSpread::of(sums.into_iter(), 0.0).size() / count as f64
}

/// Part of a cycle after which noise is another one and the scatter of strokes of several sizes the same, and pairs of samples that tell.
/// *Choices.*
const SHORTLY: f64 = 1.0 / 16.0;
const PAIRS: usize = 4096;

/// The share of what the mean cycle leaves that is another after a sixteenth of a cycle, half the mean square of the change over the mean
/// square: noise has 1, even where a filter keeps its higher half away; strokes that come and go have 2 sin^2(pi / 16), 0.08.
fn at_once(series: &Series, channel: &MeasuredChannel, places: &[PlaceStatistics]) -> f64 {
    let later = ((SHORTLY * series.phase.len() as f64 / series.cycles()) as usize).max(1);
    let left = |k: usize| channel.samples[k] - places[place(series.phase[k], places.len())].mean;
    let count = series.phase.len().saturating_sub(later);
    let pairs = (0..count).step_by(count.div_ceil(PAIRS).max(1)).map(|k| (left(k), left(k + later)));
    let (changed, all) = pairs.fold((0.0, 0.0), |(changed, all), (a, b)| {
        (changed + 0.5 * (b - a).powi(2), all + 0.5 * (a * a + b * b))
    });
    changed / all.max(f64::MIN_POSITIVE)
}

/// The share of all samples that lie beyond the end by some of its deviations.
fn beyond(channel: &MeasuredChannel, [end, noise, middle]: [f64; 3]) -> f64 {
    let out = (end - middle).signum();
    let far = channel.samples.iter().filter(|x| out * (*x - end) > BEYOND * noise).count();
    far as f64 / channel.samples.len() as f64
}

/// The slopes of the mean cycle beside the end, over those two places further on.
fn corner(places: &[PlaceStatistics], on: &[bool]) -> f64 {
    let [near, further] = slopes(places, on);
    near / further.max(f64::MIN_POSITIVE)
}

/// The steps of the mean cycle beside the end, both sides together, and two places further on.
fn slopes(places: &[PlaceStatistics], on: &[bool]) -> [f64; 2] {
    let count = places.len();
    let step = |k: usize| (places[(k + 1) % count].mean - places[k % count].mean).abs();
    let (mut near, mut further) = (0.0, 0.0);
    for k in 0..count {
        // The place at the corner may lie on both sides of it.
        if on[k] && !on[(k + 1) % count] {
            near += step(k + 2);
            further += step(k + 4);
        }
        if !on[k] && on[(k + 1) % count] {
            near += step(k + count - 2);
            further += step(k + count - 4);
        }
    }
    [near, further]
}

/// Standard errors from which the noise is known to grow with the load. *Choice*: by chance once in 16,000 channels.
const GROWS: f64 = 4.0;

/// The variance that the noise has where the mean cycle does not change and lies at `end`, from the places away from there, less its error: a
/// crank that is unsteady adds one that grows with the square of the slope, and some cells have one that grows with the load. None where the
/// slope explains it.
fn elsewhere(places: &[PlaceStatistics], on: &[bool], end: f64) -> Option<f64> {
    let count = places.len();
    let beside = |k: usize| on[k] || on[(k + 1) % count] || on[(k + count - 1) % count];
    let slope = |k: usize| places[(k + 1) % count].mean - places[(k + count - 1) % count].mean;
    let points: Vec<[f64; 3]> = (0..count)
        .filter(|k| !beside(*k))
        .map(|k| [0.25 * slope(k).powi(2), places[k].noise.powi(2), places[k].mean])
        .collect();
    if points.len() < ELSEWHERE {
        return None;
    }
    let mean = |of: &dyn Fn(&[f64; 3]) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y, level) = (mean(&|p| p[0]), mean(&|p| p[1]), mean(&|p| p[2]));
    let (xx, xy) = (mean(&|p| (p[0] - x).powi(2)), mean(&|p| (p[0] - x) * (p[1] - y)));
    let rise = if xx > 0.0 { (xy / xx).max(0.0) } else { 0.0 };
    let rest = |p: &[f64; 3]| p[1] - y - rise * (p[0] - x);
    let left = mean(&|p| rest(p).powi(2));
    let free = (points.len() - 2) as f64;
    // What the slope leaves, by the load.
    let (of_level, both) = (mean(&|p| (p[2] - level).powi(2)), mean(&|p| (p[2] - level) * rest(p)));
    let grows = both / of_level.max(f64::MIN_POSITIVE);
    let sure = grows * grows * of_level * free > GROWS * GROWS * (left - grows * both);
    let by_load = if sure { grows * (end - level) } else { 0.0 };
    let error = (left * (1.0 + x * x / xx.max(f64::MIN_POSITIVE)) / free).sqrt();
    let least = y - rise * x + by_load - ERRORS * error;
    (rise * x < BY_SLOPE * y && least > 0.0).then_some(least)
}

/// Which samples tell of the places of the cycle, each with its place and where it lies in it, from -1/2 to 1/2; those of a place together.
pub(super) struct PlacedSamples {
    samples: Vec<(usize, usize, f64)>,
    count: usize,
}

/// The same of the samples of `series`; of none where a place has too few.
pub(super) fn placed(series: &Series) -> PlacedSamples {
    let (phase, cycles) = (series.phase, series.cycles());
    let count = PLACES[1].min(phase.len() / SAME).min((phase.len() as f64 / cycles.max(1.0)) as usize);
    if !series.purpose.is_loads() || count < PLACES[0] {
        return PlacedSamples { samples: Vec::new(), count: 0 };
    }
    let every = phase.len().div_ceil(count * ENOUGH);
    let mut seen = vec![0_usize; count];
    let mut samples = vec![Vec::with_capacity(phase.len() / every / count + SAME); count];
    for (k, p) in phase.iter().enumerate() {
        let at = place(*p, count);
        if seen[at].is_multiple_of(every) {
            samples[at].push((k, at, ((p - p.floor()) * count as f64).fract() - 0.5));
        }
        seen[at] += 1;
    }
    PlacedSamples { samples: samples.concat(), count }
}

impl PlacedSamples {
    pub fn of(&self, samples: &[f64]) -> Option<Vec<PlaceStatistics>> {
        let mut room = Vec::new();
        let place = |of: &[(usize, usize, f64)]| {
            room.clear();
            room.extend(of.iter().map(|(k, _, within)| (*within, samples[*k])));
            (of.len() >= SAME).then(|| PlaceStatistics::of(&room))
        };
        let places = self.samples.chunk_by(|a, b| a.1 == b.1).map(place);
        places
            .collect::<Option<Vec<PlaceStatistics>>>()
            .filter(|places| !places.is_empty() && places.len() == self.count)
    }
}

impl PlaceStatistics {
    fn of(samples: &[(f64, f64)]) -> Self {
        let count = samples.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| samples.iter().map(of).sum::<f64>() / count;
        let (u, x) = (mean(&|s| s.0), mean(&|s| s.1));
        let (uu, ux) = (mean(&|s| (s.0 - u).powi(2)), mean(&|s| (s.0 - u) * (s.1 - x)));
        // Of samples that nearly have one phase, as of a rate that is a multiple of the frequency, there is no slope.
        let slope = if uu > ONE_PHASE { ux / uu } else { 0.0 };
        let mut left: Vec<f64> = samples.iter().map(|s| (s.1 - x - slope * (s.0 - u)).abs()).collect();
        let (second, fourth) = left.iter().fold((0.0, 0.0), |(a, b), left| {
            let square = left * left;
            (a + square / count, b + square * square / count)
        });
        let peaked = fourth / (second * second).max(f64::MIN_POSITIVE);
        let noise = OF_MEDIAN * median(&mut left);
        Self { mean: x - slope * u, noise, count, variance: second, peaked }
    }
}
