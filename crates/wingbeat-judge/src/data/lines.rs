//! The frequency of channels of which none is known: the strongest line of their spectra, and what it is a harmonic of.

use super::cycle::Condensed;
use super::{MeasuredChannel, frequency, noise};
use std::f64::consts::TAU;
use wingbeat_math::power_spectrum;

/// Most samples whose spectrum is taken. *Choice*: a quarter of an hour at 1 kHz, a tenth of a second of work per channel.
const MOST: usize = 1 << 20;
/// Cycles that the samples must hold for a line to be told from a drift. *Choice.*
const FEWEST: f64 = 4.0;
/// Points of the spectrum in the width 1 / T of a line, at least. *Choice.*
const FINE: usize = 4;
/// Distances from a line, in its widths, between which the noise beside it is taken, the larger of two: near it where
/// noise falls with the frequency, and far enough for chance to be small. A line under Hann's window is two wide to
/// either side. *Choice.*
const BESIDE: [(f64, f64); 2] = [(3.0, 10.0), (3.0, 40.0)];
/// The share of the points beside a line of which other lines leave the noise free. *Choice.*
const QUARTILE: f64 = 0.25;
/// The quartile of a spectrum of noise, whose powers are distributed exponentially, over its mean: -ln(3 / 4).
const OF_MEAN: f64 = 0.287_682_072_451_780_9;
/// Lines of a channel whose leakage counts. *Choice.*
const LEAKING: usize = 16;
/// Harmonics among which the strongest line is sought. *Choice*: two strokes and two wings give the second and the fourth.
const HIGHEST: usize = 6;
/// Error of the place of a line, in its widths: half a point of the spectrum, and what others pull it by. *Choice.*
const PLACED: f64 = 0.15;
/// Largest difference of a channel's frequency from the one found first, in line widths. *Choice.*
const NEAR: f64 = 1.0;

/// The frequency at which channels repeat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// The frequency, Hz; none where no line stands above the noise.
    pub frequency: Option<f64>,
    /// Its standard error, Hz.
    pub error: f64,
    /// The strongest line, Hz: the frequency or a harmonic.
    pub strongest: f64,
    /// Power of the most distinct line over the noise beside it.
    pub over_noise: f64,
}

/// A spectrum under Hann's window, at points of which [`FINE`] or more lie in a line's width.
struct Spectrum {
    power: Vec<f64>,
    /// Sum of the powers of all points.
    all: f64,
    /// The largest lines, by point and power, which leak into what lies beside them.
    lines: Vec<(usize, f64)>,
}

/// The frequency of the `channels` sampled at `time` (s), whose steps may be uneven; `over_noise` is what a line must reach.
///
/// The powers of noise beside a line are distributed exponentially (A. Schuster, "On the investigation of hidden
/// periodicities", Terrestrial Magnetism 3 (1898) 13-41), which tells how large a line noise makes. The strongest line is
/// the one with the largest share of the channels' powers. It is the harmonic k of the frequency where lines stand
/// at multiples of its k-th part that have no divisor in common with k. [`frequency::estimate`] then tells the frequency of
/// each channel with its standard error, and their mean is weighed by those.
pub fn find_frequency(time: &[f64], channels: &[MeasuredChannel], over_noise: f64) -> SpectralLine {
    let nothing = SpectralLine { frequency: None, error: 0.0, strongest: 0.0, over_noise: 0.0 };
    let count = time.len().min(MOST);
    let (Some(first), Some(last)) = (time.first(), time[..count].last()) else { return nothing };
    let span = last - first;
    if !(span > 0.0 && span.is_finite()) || count < 16 {
        return nothing;
    }
    let grid = EvenSteps { first: *first, rate: (count - 1) as f64 / span, count };
    let spectra = channels.iter().map(|channel| (channel, Spectrum::of(&grid, time, channel.samples)));
    let spectra = spectra.filter_map(|(channel, spectrum)| Some((channel, spectrum?)));
    let (moving, spectra): (Vec<&MeasuredChannel>, Vec<Spectrum>) = spectra.unzip();
    let (step, width) = (grid.step(), grid.points(1.0));
    let from = grid.points(FEWEST) as usize;
    let to = grid.highest().min(spectra.first().map_or(0, |spectrum| spectrum.power.len()));
    let (mut best, mut distinct) = ((0.0, 0), 0.0_f64);
    for k in from..to {
        let over = most_over(&spectra, k, width);
        distinct = distinct.max(over);
        let share: f64 = spectra.iter().map(|spectrum| spectrum.power[k] / spectrum.all).sum();
        if over >= over_noise && share > best.0 {
            best = (share, k);
        }
    }
    let line = SpectralLine { over_noise: distinct, ..nothing };
    if best.1 == 0 {
        return line;
    }
    let strongest = best.1 as f64 * step;
    let part = harmonic(&spectra, best.1, width, over_noise);
    let share = |of: &Spectrum| of.power[best.1] / of.all;
    let clearest = moving.iter().zip(&spectra).max_by(|a, b| share(a.1).total_cmp(&share(b.1)));
    let agrees = |part: &usize| {
        clearest.is_some_and(|(channel, _)| {
            mostly_agrees(time, channel.samples, *part as f64 / strongest, strongest)
        })
    };
    let gaps = clearest.is_some_and(|(channel, _)| has_gaps(time, channel.samples));
    let place = if gaps && part > 1 { refined(time, channels, strongest, width * step) } else { None };
    let place = place.map_or(strongest, |told| told.0);
    let suffices = |of: &usize| {
        gaps && part.is_multiple_of(*of)
            && clearest.is_some_and(|(channel, _)| suffices(time, channel.samples, place, [*of, part]))
    };
    let rough = strongest / (1..part).find(|of| agrees(of) || suffices(of)).unwrap_or(part) as f64;
    let told = refined(time, channels, rough, width * step);
    SpectralLine {
        frequency: told.map(|told| told.0),
        error: told.map_or(0.0, |told| told.1),
        strongest,
        ..line
    }
}

/// Even steps over the samples.
struct EvenSteps {
    first: f64,
    rate: f64,
    count: usize,
}

impl EvenSteps {
    /// Samples with the zeros behind them.
    fn length(&self) -> usize {
        (FINE * self.count).next_power_of_two()
    }

    /// Step of the spectrum, Hz.
    fn step(&self) -> f64 {
        self.rate / self.length() as f64
    }

    /// Points of the spectrum in so many widths of a line, that is up to so many cycles of all samples.
    fn points(&self, widths: f64) -> f64 {
        widths * self.length() as f64 / self.count as f64
    }

    /// Points below nine tenths of half the rate.
    fn highest(&self) -> usize {
        (0.45 * self.length() as f64) as usize
    }
}

impl Spectrum {
    /// None of a channel that never changes.
    fn of(grid: &EvenSteps, time: &[f64], samples: &[f64]) -> Option<Self> {
        let at = |t: f64| (((t - grid.first) * grid.rate).round().max(0.0) as usize).min(grid.count - 1);
        let pairs = || time.iter().zip(samples).take(grid.count).filter(|(_, x)| x.is_finite());
        let level = SampleTrend::of(pairs().map(|(t, x)| (at(*t) as f64 / grid.count as f64, *x)));
        let mut even = vec![0.0; grid.count];
        for (t, x) in pairs() {
            let k = at(*t);
            let hann = 1.0 - (TAU * (k as f64 + 0.5) / grid.count as f64).cos();
            even[k] = hann * (x - level.at(k as f64 / grid.count as f64));
        }
        let power = power_spectrum(&even, grid.length());
        let all = power.iter().sum::<f64>();
        let mut lines: Vec<(usize, f64)> =
            (1..power.len()).filter(|k| is_top(&power, *k)).map(|k| (k, power[k])).collect();
        wingbeat_math::order::descend_by(&mut lines, |item| item.1);
        lines.truncate(LEAKING);
        (all > 0.0 && all.is_finite()).then_some(Self { power, all, lines })
    }

    /// What larger lines leave at `k`: a line of power P leaves P / (pi d (d^2 - 1))^2 at the distance of d widths under Hann's
    /// window (F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978) 51-83), and is two wide.
    fn leaked(&self, k: usize, width: f64) -> f64 {
        let larger = self.lines.iter().filter(|line| line.0 != k && line.1 > self.power[k]);
        let left = |(at, power): &(usize, f64)| {
            let d = at.abs_diff(k) as f64 / width;
            if d < 2.0 { *power } else { power / (std::f64::consts::PI * d * (d * d - 1.0)).powi(2) }
        };
        larger.map(left).sum()
    }

    /// Power at `k` over the mean of the noise beside it; zero where `k` is no top. `width` is that of a line, in points.
    fn over(&self, k: usize, width: f64) -> f64 {
        let power = &self.power;
        if !is_top(power, k) {
            return 0.0;
        }
        let noise =
            BESIDE.map(|(near, far)| beside(power, k, [near * width, far * width].map(|far| far as usize)));
        let noise = noise[0].max(noise[1]);
        // Rounding leaves noise of its own.
        power[k] / noise.max(1e-20 * self.all).max(self.leaked(k, width))
    }
}

/// Mean power of noise at points `near` to `far` from `k`, by their lower quartile; zero where there are none.
fn beside(power: &[f64], k: usize, [near, far]: [usize; 2]) -> f64 {
    let below = k.saturating_sub(far)..k.saturating_sub(near);
    let above = (k + near).min(power.len())..(k + far).min(power.len());
    let mut there: Vec<f64> = below.chain(above).map(|k| power[k]).collect();
    let place = (QUARTILE * there.len() as f64) as usize;
    if there.is_empty() { 0.0 } else { *there.select_nth_unstable_by(place, f64::total_cmp).1 / OF_MEAN }
}

/// Whether a point is no lower than those beside it.
fn is_top(power: &[f64], k: usize) -> bool {
    k > 0 && k + 1 < power.len() && power[k] >= power[k - 1] && power[k] >= power[k + 1]
}

/// The straight line through samples, at places from 0 to 1.
struct SampleTrend {
    middle: f64,
    slope: f64,
}

impl SampleTrend {
    fn of(samples: impl Iterator<Item = (f64, f64)>) -> Self {
        let (mut n, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (at, value) in samples {
            let at = at - 0.5;
            n += 1.0;
            x += at;
            y += value;
            xx += at * at;
            xy += at * value;
        }
        let spread = n * xx - x * x;
        let slope = if spread > 0.0 { (n * xy - x * y) / spread } else { 0.0 };
        Self { middle: (y - slope * x) / f64::max(n, 1.0), slope }
    }

    fn at(&self, place: f64) -> f64 {
        self.middle + self.slope * (place - 0.5)
    }
}

fn most_over(spectra: &[Spectrum], k: usize, width: f64) -> f64 {
    spectra.iter().map(|spectrum| spectrum.over(k, width)).fold(0.0, f64::max)
}

/// Which harmonic of the frequency the line at point `k` is: of a half where one line says so, of a smaller part where its own
/// line does or those of two multiples do. One line alone may lie there by chance, as that of another machine.
fn harmonic(spectra: &[Spectrum], k: usize, width: f64, over_noise: f64) -> usize {
    let stands = |at: f64, within: f64| {
        let from = (at - within).ceil().max(FEWEST * width) as usize;
        (from..=(at + within) as usize).any(|k| most_over(spectra, k, width) >= over_noise)
    };
    let is = |part: &usize| {
        let step = k as f64 / *part as f64;
        let multiples = (1..2 * part).filter(|m| common(*m, *part) == 1);
        let at = |m: &usize| stands(*m as f64 * step, PLACED * width * (1.0 + *m as f64 / *part as f64));
        let there: Vec<usize> = multiples.filter(at).collect();
        step >= FEWEST * width && (there.len() > 1 || there.contains(&1) || (*part == 2 && !there.is_empty()))
    };
    (2..=HIGHEST).rev().find(is).unwrap_or(1)
}

/// Parts of a period over which samples are averaged. *Choice.*
const PARTS: f64 = 8.0;
/// Median of the changes over their root mean square below which most samples agree: noise has 0.67, and what differs by a load all the
/// time more; strokes of which two in ten come after a rest, or go before one, 0.1. *Choice.*
const AGREES: f64 = 0.3;

/// Whether most of a channel is the same after `period` s, and some is far off, as where strokes come in bouts with rests between: the
/// bouts make lines at parts of the frequency, but no cycle. `line` is the frequency of a line, Hz, over whose eighths samples are averaged.
fn mostly_agrees(time: &[f64], samples: &[f64], period: f64, line: f64) -> bool {
    let Some(first) = time.first() else { return false };
    let mut parts: Vec<(f64, f64)> = Vec::new();
    for (t, x) in time.iter().zip(samples).filter(|(_, x)| x.is_finite()) {
        let at = ((t - first) * line * PARTS) as usize;
        if parts.len() <= at {
            parts.resize(at + 1, (0.0, 0.0));
        }
        parts[at] = (parts[at].0 + x, parts[at].1 + 1.0);
    }
    let later = (period * line * PARTS).round() as usize;
    let pairs = parts.iter().zip(parts.iter().skip(later)).filter(|(a, b)| a.1 > 0.0 && b.1 > 0.0);
    let mut changes: Vec<f64> = pairs.map(|(a, b)| (b.0 / b.1 - a.0 / a.1).abs()).collect();
    let squares = changes.iter().map(|x| x * x).sum::<f64>() / changes.len().max(1) as f64;
    // A bout that ends changes a whole stroke, a knock in each cycle a part of it.
    let least = AGREES * squares.sqrt();
    let stroke = PARTS as usize;
    let whole = changes.windows(stroke).any(|of| 2 * of.iter().filter(|x| **x > least).count() > stroke);
    whole && noise::median(&mut changes) < least
}

/// Harmonics of the strongest line with which a part of it is tried. *Choice.*
const TRIED: usize = 4;
/// Share of what the harmonics of a part explain that they must add to those of the whole. *Choice*: strokes that differ by turns by 14 % of
/// their size are told otherwise.
const ADDS: f64 = 0.02;
/// Steps over the median from which samples have a gap. *Choice.*
const GAP: f64 = 1.5;

/// Whether samples are missing, or values of the channel.
fn has_gaps(time: &[f64], samples: &[f64]) -> bool {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let median = noise::median(&mut steps);
    samples.iter().any(|x| !x.is_finite()) || steps.iter().any(|step| *step > GAP * median)
}

/// Whether the samples that are there, by least squares over the harmonics, need no lower frequency than `line / of` (Hz) where `line / part` is
/// tried: gaps that come again make lines of their own in a spectrum, of which the samples beside them know nothing.
fn suffices(time: &[f64], samples: &[f64], line: f64, [of, part]: [usize; 2]) -> bool {
    let there = || time.iter().zip(samples).filter(|(_, x)| x.is_finite());
    let phase: Vec<f64> = there().map(|(t, _)| t * line).collect();
    let values: Vec<f64> = there().map(|(_, x)| *x).collect();
    let (Some(first), Some(last)) = (phase.first(), phase.last()) else { return false };
    let at = Condensed::of(&phase, &values, last - first);
    let left = |of: usize| {
        let ratio = 1.0 / of as f64;
        let cycle = wingbeat_math::Harmonics::fitted(ratio, &at.phase, &at.values, TRIED * of)?;
        Some(at.phase.iter().zip(&at.values).map(|(p, x)| (x - cycle.at(ratio * p)).powi(2)).sum::<f64>())
    };
    let mean = at.values.iter().sum::<f64>() / at.values.len() as f64;
    let all: f64 = at.values.iter().map(|x| (x - mean).powi(2)).sum();
    let Some(whole) = left(of) else { return false };
    // What the samples do not determine adds nothing.
    let least = left(part).unwrap_or(0.0);
    whole - least < ADDS * (all - least)
}

/// The largest divisor of both.
fn common(a: usize, b: usize) -> usize {
    if b == 0 { a } else { common(b, a % b) }
}

/// Frequency and standard error, Hz, by all channels whose own lies near `rough`.
fn refined(time: &[f64], channels: &[MeasuredChannel], rough: f64, width: f64) -> Option<(f64, f64)> {
    let cycles = (time.last()? - time.first()?) * rough;
    let (mut weights, mut sum) = (0.0, 0.0);
    for channel in channels {
        let there = || time.iter().zip(channel.samples).filter(|(_, x)| x.is_finite());
        let phase: Vec<f64> = there().map(|(t, _)| t * rough).collect();
        let samples: Vec<f64> = there().map(|(_, x)| *x).collect();
        let at = Condensed::of(&phase, &samples, cycles);
        let Some(own) = frequency::estimate(&at.phase, &at.values) else { continue };
        if (own.ratio - 1.0).abs() * rough < NEAR * width {
            // A file without noise tells its frequency to rounding.
            let weight = own.error.max(1e-12).powi(-2);
            weights += weight;
            sum += weight * own.ratio;
        }
    }
    (weights > 0.0).then(|| (rough * sum / weights, rough / weights.sqrt()))
}
