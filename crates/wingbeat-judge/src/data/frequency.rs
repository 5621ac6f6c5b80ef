//! The frequency at which a channel repeats.

use std::f64::consts::TAU;
use wingbeat_math::Harmonics;

/// Frequencies among which the strongest line is sought, in parts of the one given. *Choice.*
const SOUGHT: (f64, f64) = (0.25, 6.0);
/// Cycles over which it is sought first. *Choice.*
const FIRST: f64 = 64.0;
/// Steps of the search in a line's width. *Choice.*
const FINE: f64 = 4.0;
/// Harmonics with which it is judged. *Choice.*
const HARMONICS: usize = 4;
/// Rounds in which the maximum is narrowed down, each to 0.6 of its width.
const ROUNDS: usize = 24;
/// Width in which all harmonics narrow it down, in parts of a line's. *Choice.*
const NEAR: f64 = 0.2;

/// A frequency, in parts of the one given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frequency {
    /// The frequency over the one given.
    pub ratio: f64,
    /// Its relative standard error (Cramer and Rao's bound for a line in white noise).
    pub error: f64,
    /// Share of the channel's power that a cycle of this frequency explains.
    pub explained: f64,
}

/// The frequency of the strongest line of `values` at `phase` (cycles of the frequency given), or of its fundamental
/// where it is a harmonic; none of less than a cycle.
///
/// Error of a line of amplitude A in n samples over T with noise s: sqrt(6) s / (pi A T sqrt(n)).
pub fn estimate(phase: &[f64], values: &[f64]) -> Option<Frequency> {
    let (first, last) = (phase.first()?, phase.last()?);
    let cycles = last - first;
    if !(cycles >= 1.0) || phase.len() < 4 * HARMONICS {
        return None;
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let apart: Vec<f64> = values.iter().map(|x| x - mean).collect();
    // A channel that stands still has every frequency, and without an error.
    let all = apart.iter().map(|x| x * x).sum::<f64>();
    if !(all > 0.0 && all.is_finite()) {
        return None;
    }
    let early = phase.partition_point(|p| *p - first <= FIRST);
    let width = 1.0 / cycles.min(FIRST);
    let most = SOUGHT.1.min(0.45 * phase.len() as f64 / cycles);
    let count = ((most - SOUGHT.0) * FINE / width).max(0.0) as usize;
    let coarse = (0..=count).map(|k| SOUGHT.0 + k as f64 * width / FINE);
    let power = |line: f64, end: usize| power(&phase[..end], &apart[..end], line);
    let line = coarse
        .map(|line| (line, power(line, early)))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(line, _)| line)?;
    // The whole record has narrower lines.
    let line = narrowed(line, width, &|line| power(line, early));
    let line = narrowed(line, 1.0 / cycles, &|line| power(line, phase.len()));
    let ratio = line / line.round().max(1.0);
    // Other lines pull the strongest a little: what all harmonics leave is the better measure.
    let ratio = narrowed(ratio, NEAR / cycles, &|ratio| -left(phase, &apart, ratio));
    let left = left(phase, &apart, ratio);
    let amplitude = 2.0 * power(line, phase.len()).sqrt() / phase.len() as f64;
    let error = (6.0 * left).sqrt() / (std::f64::consts::PI * amplitude * cycles * phase.len() as f64);
    Some(Frequency { ratio, error: error / line.round().max(1.0), explained: 1.0 - left / all })
}

/// Sum of the squares of what the harmonics of `ratio` leave; infinite where they are not determined.
fn left(phase: &[f64], values: &[f64], ratio: f64) -> f64 {
    Harmonics::fitted(ratio, phase, values, HARMONICS).map_or(f64::INFINITY, |cycle| {
        phase.iter().zip(values).map(|(p, x)| (x - cycle.at(ratio * p)).powi(2)).sum()
    })
}

/// Square of the sum of the values turned by `line`.
fn power(phase: &[f64], values: &[f64], line: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (p, x) in phase.iter().zip(values) {
        let (sin, cos) = (TAU * line * p).sin_cos();
        re += x * cos;
        im += x * sin;
    }
    re * re + im * im
}

/// The maximum of `of` within `width` of `at`, by the golden section.
fn narrowed(at: f64, width: f64, of: &dyn Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (at - 0.5 * width, at + 0.5 * width);
    for _ in 0..ROUNDS {
        let (a, b) = (high - share * (high - low), low + share * (high - low));
        if of(a) > of(b) { high = b } else { low = a }
    }
    0.5 * (low + high)
}
