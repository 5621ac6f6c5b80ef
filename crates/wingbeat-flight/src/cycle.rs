//! Cycles: phase, average, envelope, comparison.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use wingbeat_math::{CubicSpline, Error};

/// Where the phase of the stroke comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PhaseSource {
    /// The encoder's column.
    Encoder,
    /// The fundamental of the vertical force near the given frequency.
    Force,
    /// The given frequency; phase 0 at t = 0.
    Frequency,
}

/// Phase of every sample, rad, ascending. `frequency` (Hz) is the nominal one.
///
/// # Errors
/// An encoder column that is missing; a force without a visible stroke.
pub fn phase_of(
    source: PhaseSource,
    time: &[f64],
    encoder: Vec<f64>,
    force: &[f64],
    frequency: f64,
) -> Result<Vec<f64>, Error> {
    match source {
        PhaseSource::Encoder if encoder.len() == time.len() => Ok(encoder),
        PhaseSource::Encoder => {
            Err(Error::invalid("process.phase", "encoder", "force or frequency: there is no phase column"))
        }
        PhaseSource::Frequency => Ok(time.iter().map(|t| TAU * frequency * t).collect()),
        PhaseSource::Force => {
            let found = fundamental(time, force, frequency)?;
            Ok(time.iter().map(|t| TAU * found.0 * t + found.1).collect())
        }
    }
}

/// Frequency (Hz) and phase at t = 0 (rad) of the strongest oscillation within
/// 20 % of `near`, by scanning and refining the projection on cosine and sine under
/// a Hann window, which keeps other harmonics out. The scan is as fine as the record is
/// long: the peak of a record of T seconds is 4 / T wide.
fn fundamental(time: &[f64], x: &[f64], near: f64) -> Result<(f64, f64), Error> {
    let nothing = || {
        let allowed = format!("encoder or frequency: the force shows no stroke near {near} Hz");
        Error::invalid("process.phase", "force", allowed)
    };
    let (Some(begin), Some(end)) = (time.first(), time.last()) else { return Err(nothing()) };
    let span = end - begin;
    let spread = spread(x);
    let parts = |per_turn: f64| {
        let rate = time.len() as f64 / span.max(f64::MIN_POSITIVE);
        Windowed::of(time, x, (rate / (per_turn * near)) as usize)
    };
    let (coarse, fine) = (parts(SCANNED), parts(REFINED));
    let (low, high) = (0.8 * near, 1.2 * near);
    let steps = ((high - low) * 2.0 * span).ceil().clamp(20.0, MOST_SCANNED);
    let scan = (0..=steps as usize).map(|k| low + (high - low) * k as f64 / steps);
    let mut best = strongest(&coarse, scan).ok_or_else(nothing)?;
    let mut width = (high - low) / steps;
    for _ in 0..12 {
        let trial = (-10..=10).map(|k| best + width * f64::from(k) / 10.0);
        best = strongest(&fine, trial).ok_or_else(nothing)?;
        width *= 0.3;
    }
    if !(fine.power(best) >= 0.02 * spread) || spread == 0.0 {
        return Err(nothing());
    }
    let (c, s) = fine.projection(best);
    Ok((best, (-s).atan2(c)))
}

/// Parts of a turn over which samples are averaged for the scan, and for the refinement.
const SCANNED: f64 = 8.0;
const REFINED: f64 = 64.0;
/// Most frequencies of the scan: an hour at 3.5 Hz.
const MOST_SCANNED: f64 = 1e4;

/// The frequency with the largest power.
fn strongest(of: &Windowed, trials: impl Iterator<Item = f64>) -> Option<f64> {
    let powers = trials.map(|f| (of.power(f), f));
    powers.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, f)| f)
}

/// Samples under a Hann window, some averaged into one, less their mean.
struct Windowed {
    /// Weight, value, time of each.
    samples: Vec<(f64, f64, f64)>,
    weight: f64,
}

/// Hann's window at sample `k` of `n`, twice its usual height.
fn hann(k: f64, n: usize) -> f64 {
    1.0 - (TAU * k / n.max(1) as f64).cos()
}

/// Mean square of `x` about its mean under the window.
fn spread(x: &[f64]) -> f64 {
    let there = || x.iter().enumerate().filter(|(_, value)| value.is_finite());
    let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
        there().map(|(k, value)| hann(k as f64, x.len()) * of(*value)).sum()
    };
    let weight = sum(&|_| 1.0).max(f64::MIN_POSITIVE);
    let mean = sum(&|value| value) / weight;
    sum(&|value| (value - mean).powi(2)) / weight
}

impl Windowed {
    /// Of `count` samples together (0 counts as 1), those that are missing left out.
    fn of(time: &[f64], x: &[f64], count: usize) -> Self {
        let count = count.max(1);
        let together = |(k, (part, time)): (usize, (&[f64], &[f64]))| {
            let middle = (k * count) as f64 + 0.5 * (part.len() as f64 - 1.0);
            let there = || part.iter().zip(time).filter(|(value, _)| value.is_finite());
            let n = there().count() as f64;
            let sum = there().fold((0.0, 0.0), |(v, t), (value, time)| (v + value, t + time));
            (n > 0.0).then(|| (n * hann(middle, x.len()), sum.0 / n, sum.1 / n))
        };
        let mut samples: Vec<(f64, f64, f64)> =
            x.chunks(count).zip(time.chunks(count)).enumerate().filter_map(together).collect();
        let weight = samples.iter().map(|s| s.0).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = samples.iter().map(|s| s.0 * s.1).sum::<f64>() / weight;
        samples.iter_mut().for_each(|sample| sample.1 -= mean);
        Self { samples, weight }
    }

    /// Amplitudes of cosine and sine at `f`.
    fn projection(&self, f: f64) -> (f64, f64) {
        let (mut c, mut s) = (0.0, 0.0);
        for (w, v, t) in &self.samples {
            let (sin, cos) = (TAU * f * t).sin_cos();
            c += w * v * cos;
            s += w * v * sin;
        }
        (2.0 * c / self.weight, 2.0 * s / self.weight)
    }

    fn power(&self, f: f64) -> f64 {
        let (c, s) = self.projection(f);
        c * c + s * s
    }
}

/// One channel averaged over whole cycles, by phase. Values are in the unit of the channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CycleAverage {
    /// Mean over the cycles at equal steps of phase from 0, in the unit of the channel.
    pub mean: Vec<f64>,
    /// Smallest over the cycles, in the unit of the channel.
    pub low: Vec<f64>,
    /// Largest over the cycles, in the unit of the channel.
    pub high: Vec<f64>,
    /// Standard deviation over the cycles, in the unit of the channel, n - 1 in the denominator; zero of a single cycle.
    pub deviation: Vec<f64>,
    /// Whole cycles averaged.
    pub cycles: usize,
    /// Whole cycles left out because samples are missing in them.
    pub left_out: usize,
}

/// Samples of a cycle below which a straight line between two of them takes too much of a harmonic, and cycles from which a curve through
/// all of them does better; fewer are points of a drawing. *Choices.*
const SPARSE: f64 = 64.0;
const FOR_CURVE: usize = 4;

/// Averages `x`, in its unit, over the whole cycles of `phase` (rad) at `bins` phases, by linear interpolation. A cycle in
/// which samples are missing (not-a-number) is left out.
///
/// A straight line between samples at N phases of a cycle leaves sinc^2(h / N) of harmonic h in the mean, 0.85 of the second one
/// with nine samples. Below 64 samples a natural cubic spline stands in its place, which leaves (1 - f)^4 / ((1 - f)^4 + f^4) of it, f = h / N,
/// 0.993 (M. Unser, IEEE Signal Process. Mag. 16(6) (1999) 22-38).
///
/// # Errors
/// Less than one whole cycle, or none without gaps.
pub fn phase_average(phase: &[f64], x: &[f64], bins: usize) -> Result<CycleAverage, Error> {
    let (Some(first), Some(last)) = (phase.first(), phase.last()) else {
        return Err(Error::invalid("process.window_s", "no samples", "at least one whole cycle"));
    };
    let begin = first / TAU;
    let cycles = ((last - first) / TAU + 1e-6).floor() as usize;
    if cycles == 0 {
        let given = format!("{:.2} cycles", (last - first) / TAU);
        return Err(Error::invalid("process.window_s", given, "at least one whole cycle"));
    }
    if cycles > phase.len() {
        let given = format!("{cycles} cycles of {} samples", phase.len());
        return Err(Error::invalid("process.window_s", given, "at least one sample per cycle"));
    }
    let whole: Vec<usize> =
        (0..cycles).filter(|cycle| is_whole(phase, x, first + TAU * *cycle as f64)).collect();
    if whole.is_empty() {
        let allowed = "at least one cycle without missing samples; process.input.bridge_samples bridges short gaps, process.input.rate_hz takes \
             the rows at even steps";
        return Err(Error::invalid("process.window_s", format!("{cycles} cycles, each with a gap"), allowed));
    }
    let mut average = CycleAverage {
        mean: vec![0.0; bins],
        low: vec![f64::INFINITY; bins],
        high: vec![f64::NEG_INFINITY; bins],
        deviation: vec![0.0; bins],
        cycles: whole.len(),
        left_out: cycles - whole.len(),
    };
    let curve = if phase.len() < (SPARSE * (last - first) / TAU) as usize && whole.len() >= FOR_CURVE {
        through(phase, x)
    } else {
        None
    };
    for bin in 0..bins {
        let share = bin as f64 / bins as f64;
        // The first turn number at which this phase lies in the window.
        let turn = (begin - share).ceil();
        let at = |cycle: &usize| {
            let p = TAU * (turn + share + *cycle as f64).min(last / TAU);
            curve.as_ref().map_or_else(|| sample(phase, x, p), |curve| curve.at(p).x)
        };
        for value in whole.iter().map(at) {
            average.mean[bin] += value / whole.len() as f64;
            average.low[bin] = average.low[bin].min(value);
            average.high[bin] = average.high[bin].max(value);
        }
        let squares: f64 = whole.iter().map(|cycle| (at(cycle) - average.mean[bin]).powi(2)).sum();
        average.deviation[bin] = (squares / (whole.len() - 1).max(1) as f64).sqrt();
    }
    Ok(average)
}

/// True when the cycle that begins at `phase[..] = begin` has samples and none of them is missing.
fn is_whole(phase: &[f64], x: &[f64], begin: f64) -> bool {
    let from = phase.partition_point(|p| *p < begin);
    let to = phase.partition_point(|p| *p <= begin + TAU);
    let near = from.saturating_sub(1)..(to + 1).min(x.len());
    from < to && x[near].iter().all(|value| value.is_finite())
}

/// The curve through the samples that are there; none where their phases do not ascend.
fn through(phase: &[f64], x: &[f64]) -> Option<CubicSpline> {
    let there = || phase.iter().zip(x).filter(|(_, x)| x.is_finite());
    let (phase, x): (Vec<f64>, Vec<f64>) = there().map(|(phase, x)| (*phase, *x)).unzip();
    CubicSpline::natural(&phase, &x).ok()
}

/// `x` at the phase `p`.
fn sample(phase: &[f64], x: &[f64], p: f64) -> f64 {
    wingbeat_math::interpolation::piecewise_linear(phase, x, p)
}

impl CycleAverage {
    /// Takes another average away, phase by phase: what is common to both.
    pub fn subtract(&mut self, other: &Self) {
        for (k, common) in other.mean.iter().enumerate() {
            self.mean[k] -= common;
            self.low[k] -= common;
            self.high[k] -= common;
        }
    }
}

/// One curve against another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Root mean square of the difference, in the unit of the curves.
    pub rmse: f64,
    /// Range of the reference, in the unit of the curves, largest less smallest.
    pub range: f64,
    /// Pearson correlation.
    pub correlation: f64,
    /// Ratio of the range of the curve to the range of the reference.
    pub peak_ratio: f64,
}

/// Compares `curve` with `reference`, sample by sample, both in the unit of one quantity.
pub fn compare(curve: &[f64], reference: &[f64]) -> Comparison {
    let n = curve.len().min(reference.len()) as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let range = |x: &[f64]| {
        x.iter().copied().fold(f64::NEG_INFINITY, f64::max) - x.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let (mc, mr) = (mean(curve), mean(reference));
    let (mut square, mut cc, mut rr, mut cr) = (0.0, 0.0, 0.0, 0.0);
    for (c, r) in curve.iter().zip(reference) {
        square += (c - r) * (c - r);
        cc += (c - mc) * (c - mc);
        rr += (r - mr) * (r - mr);
        cr += (c - mc) * (r - mr);
    }
    Comparison {
        rmse: (square / n).sqrt(),
        range: range(reference),
        correlation: cr / (cc * rr).sqrt(),
        peak_ratio: range(curve) / range(reference),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_samples_of_a_cycle_keep_its_second_harmonic() {
        let phase: Vec<f64> = (0..640).map(|k| TAU * f64::from(k) / 9.13).collect();
        let x: Vec<f64> = phase.iter().map(|p| p.sin() + (2.0 * p).cos()).collect();
        let mean = phase_average(&phase, &x, 36).unwrap().mean;
        let of = |bin: usize| (TAU * bin as f64 / 36.0).sin() + (2.0 * TAU * bin as f64 / 36.0).cos();
        let off = (0..36).map(|bin| (mean[bin] - of(bin)).abs()).fold(0.0, f64::max);
        assert!(off < 0.02, "{off}");
    }

    #[test]
    fn cycles_average_to_the_common_shape() {
        let time: Vec<f64> = (0..6020).map(|k| 0.313 + k as f64 / 7000.0).collect();
        let phase = phase_of(PhaseSource::Frequency, &time, vec![], &[], 3.5).unwrap();
        let x: Vec<f64> = phase.iter().map(|p| p.sin() + 0.3 * (2.0 * p).cos()).collect();
        let average = phase_average(&phase, &x, 100).unwrap();
        assert_eq!(average.cycles, 3);
        for (bin, value) in average.mean.iter().enumerate() {
            let p = TAU * bin as f64 / 100.0;
            assert!((value - p.sin() - 0.3 * (2.0 * p).cos()).abs() < 1e-5, "{bin}");
        }
        assert!(phase_average(&phase[..1000], &x[..1000], 100).is_err());
        let mut gap = x.clone();
        gap[2500] = f64::NAN;
        let rest = phase_average(&phase, &gap, 100).unwrap();
        assert_eq!((rest.cycles, rest.left_out), (2, 1));
        assert!(rest.mean.iter().zip(&average.mean).all(|(a, b)| (a - b).abs() < 1e-5));
        assert!(phase_average(&phase, &vec![f64::NAN; x.len()], 100).is_err());
    }

    #[test]
    fn the_stroke_is_found_in_the_force() {
        let time: Vec<f64> = (0..14_000).map(|k| k as f64 / 7000.0).collect();
        let force: Vec<f64> = time.iter().map(|t| 0.4 * (TAU * 3.62 * t + 0.7).cos() - 0.1).collect();
        let phase = phase_of(PhaseSource::Force, &time, vec![], &force, 3.5).unwrap();
        let found = (phase[7000] - phase[0]) / TAU;
        assert!((found - 3.62).abs() < 5e-3, "{found}");
        // In ten minutes the peak is a hundredth of the step that found it in two seconds.
        let time: Vec<f64> = (0..600_000).map(|k| k as f64 / 1000.0).collect();
        let force: Vec<f64> = time.iter().map(|t| 0.4 * (TAU * 3.3217 * t + 0.7).cos() - 0.1).collect();
        let phase = phase_of(PhaseSource::Force, &time, vec![], &force, 3.5).unwrap();
        assert!(((phase[500_000] - phase[0]) / TAU - 500.0 * 3.3217).abs() < 1e-4);
        assert!((phase[0] - 0.7).abs() < 1e-3, "{}", phase[0]);
        let nothing = vec![0.0; time.len()];
        assert!(phase_of(PhaseSource::Force, &time, vec![], &nothing, 3.5).is_err());
    }

    #[test]
    fn comparisons_of_known_curves() {
        let r: Vec<f64> = (0..1000).map(|k| (TAU * k as f64 / 1000.0).sin()).collect();
        let c: Vec<f64> = r.iter().map(|x| 1.1 * x).collect();
        let k = compare(&c, &r);
        assert!((k.rmse - 0.1 / 2f64.sqrt()).abs() < 1e-12 && (k.correlation - 1.0).abs() < 1e-12);
        assert!((k.peak_ratio - 1.1).abs() < 1e-12 && (k.range - 2.0).abs() < 1e-12);
    }
}
