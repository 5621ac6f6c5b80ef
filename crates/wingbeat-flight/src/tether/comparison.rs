//! Measured against computed over the cycle.

use crate::cycle::{CycleAverage, phase_average};
use std::f64::consts::TAU;
use wingbeat_math::CubicSpline;
use wingbeat_math::Error;

/// Phases at which a cycle is compared.
pub const PHASES: usize = 360;
/// Rounds in which the lag is refined, each to a tenth of the step.
const ROUNDS: usize = 8;

/// measured(phase) = offset + gain computed(phase - lag), by least squares: a fit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CycleFit {
    /// Cycles by which the measured one comes later, from -1/2 to 1/2.
    pub lag_cycles: f64,
    /// Gain, in the unit of the measured cycle over that of the computed one; above zero, and zero where the measured cycle
    /// does not vary.
    pub gain: f64,
    /// Offset, in the unit of the measured cycle.
    pub offset: f64,
    /// Root of the mean square of measured less computed as they are, in the unit of the measured cycle.
    pub rms_before: f64,
    /// The same after the fit.
    pub rms: f64,
    /// Range of the measured cycle, in its unit, largest less smallest.
    pub range: f64,
}

/// Mean, least and most of `values` over the whole cycles of `phase` (cycles, ascending), at [`PHASES`] phases from 0.
/// A single cycle without its end is closed by its begin.
///
/// # Errors
/// Less than one whole cycle.
pub fn cycle_of(phase: &[f64], values: &[f64]) -> Result<CycleAverage, Error> {
    let mut turn: Vec<f64> = phase.iter().map(|phase| TAU * phase).collect();
    let mut values = values.to_vec();
    if let [first, .., last] = phase
        && last - first < 1.0
        && last - first + 1.5 * (last - first) / (phase.len() - 1) as f64 >= 1.0
    {
        turn.push(TAU * (first + 1.0));
        values.push(values[0]);
    }
    phase_average(&turn, &values, PHASES)
}

/// Fits the cycle `computed`, equally spaced from phase 0, to the cycle `measured`, likewise: linear regression at
/// every lag, the lag with the least squares among those of a positive gain.
///
/// Equation: tether.comparison
/// `measured(p) = offset + gain computed(p - lag), least squares over one cycle`
/// Source: linear regression at every lag; a fit.
/// Test: `a_known_lag_gain_and_offset_are_found`.
///
/// # Errors
/// A computed curve that does not vary, or a measured one that is not finite.
pub fn fit(measured: &[f64], computed: &[f64]) -> Result<CycleFit, Error> {
    let curve = Curve::new(measured, computed)?;
    if range(measured) == 0.0 {
        return Ok(CycleFit { lag_cycles: 0.0, gain: 0.0, offset: curve.mean, rms: 0.0, ..curve.at(0.0) });
    }
    let mut best = (0..2 * PHASES)
        .map(|k| k as f64 / (2 * PHASES) as f64)
        .max_by(|a, b| curve.correlation(*a).total_cmp(&curve.correlation(*b)))
        .unwrap_or(0.0);
    let mut step = 0.5 / PHASES as f64;
    for _ in 0..ROUNDS {
        let near = (-10..=10).map(|k| best + step * f64::from(k) / 10.0);
        best = near.max_by(|a, b| curve.correlation(*a).total_cmp(&curve.correlation(*b))).unwrap_or(best);
        step /= 10.0;
    }
    Ok(curve.at(best))
}

/// The curve of a cycle, equally spaced from phase 0, at any phase (cycles).
///
/// # Errors
/// Too few samples, or such that are not finite.
pub fn smooth(cycle: &[f64]) -> Result<CubicSpline, Error> {
    let phase: Vec<f64> = (0..cycle.len()).map(|i| i as f64 / cycle.len() as f64).collect();
    CubicSpline::periodic(&phase, cycle, 1.0)
}

/// A measured cycle and a computed one at any phase.
struct Curve<'a> {
    measured: &'a [f64],
    mean: f64,
    computed: CubicSpline,
}

impl<'a> Curve<'a> {
    fn new(measured: &'a [f64], computed: &[f64]) -> Result<Self, Error> {
        let (own, theirs) = (range(computed), range(measured));
        if !(own > 0.0 && own.is_finite()) {
            return Err(Error::invalid("computed", format!("a range of {own}"), "a curve that varies"));
        }
        if !theirs.is_finite() {
            return Err(Error::invalid("measured", format!("a range of {theirs}"), "a finite one"));
        }
        let mean = measured.iter().sum::<f64>() / measured.len() as f64;
        Ok(Self { measured, mean, computed: smooth(computed)? })
    }

    fn computed(&self, lag: f64) -> impl Iterator<Item = f64> {
        let count = self.measured.len() as f64;
        (0..self.measured.len()).map(move |i| self.computed.at(i as f64 / count - lag).x)
    }

    /// Means of c, c c and c (m - mean m) with the computed curve c at a lag and the measured one m.
    fn moments(&self, lag: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (c, m) in self.computed(lag).zip(self.measured) {
            sum[0] += c;
            sum[1] += c * c;
            sum[2] += c * (m - self.mean);
        }
        sum.map(|sum| sum / self.measured.len() as f64)
    }

    /// Covariance over the deviation of the computed curve: the larger, the less is left.
    fn correlation(&self, lag: f64) -> f64 {
        let [mean, square, product] = self.moments(lag);
        product / (square - mean * mean).max(f64::MIN_POSITIVE).sqrt()
    }

    fn at(&self, lag: f64) -> CycleFit {
        let [mean, square, product] = self.moments(lag);
        let gain = product / (square - mean * mean);
        let offset = self.mean - gain * mean;
        let left = |lag: f64, gain: f64, offset: f64| {
            let left = self.computed(lag).zip(self.measured).map(|(c, m)| (m - offset - gain * c).powi(2));
            (left.sum::<f64>() / self.measured.len() as f64).sqrt()
        };
        CycleFit {
            lag_cycles: lag - (lag + 0.5).floor(),
            gain,
            offset,
            rms_before: left(0.0, 1.0, 0.0),
            rms: left(lag, gain, offset),
            range: range(self.measured),
        }
    }
}

fn range(values: &[f64]) -> f64 {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(phase: f64) -> f64 {
        (TAU * phase).sin() + 0.4 * (2.0 * TAU * phase + 0.3).cos() + 0.2
    }

    #[test]
    fn a_known_lag_gain_and_offset_are_found() {
        let computed: Vec<f64> = (0..192).map(|i| shape(f64::from(i) / 192.0)).collect();
        for lag in [-0.31, 0.0, 0.0123, 0.47] {
            let measured: Vec<f64> =
                (0..PHASES).map(|i| 0.7 + 2.5 * shape(i as f64 / PHASES as f64 - lag)).collect();
            let found = fit(&measured, &computed).unwrap();
            assert!((found.lag_cycles - lag).abs() < 1e-6, "{found:?}");
            assert!((found.gain - 2.5).abs() < 1e-5 && (found.offset - 0.7).abs() < 1e-5, "{found:?}");
            assert!(found.rms < 1e-5 && found.rms_before > 0.5, "{found:?}");
        }
        let flat = fit(&[1.0; PHASES], &computed).unwrap();
        assert_eq!((flat.gain, flat.offset, flat.rms, flat.range), (0.0, 1.0, 0.0, 0.0));
        assert!(flat.rms_before > 0.5 && fit(&computed, &[1.0; PHASES]).is_err());
    }

    #[test]
    fn a_single_cycle_is_closed() {
        let phase: Vec<f64> = (0..100).map(|i| f64::from(i) / 100.0).collect();
        let values: Vec<f64> = phase.iter().map(|phase| shape(*phase)).collect();
        let cycle = cycle_of(&phase, &values).unwrap();
        assert_eq!(cycle.cycles, 1);
        let apart = |i: usize| (cycle.mean[i] - shape(i as f64 / PHASES as f64)).abs();
        assert!((0..PHASES).all(|i| apart(i) < 3e-3));
        assert!(cycle_of(&phase[..80], &values[..80]).is_err());
    }

    #[test]
    fn cycles_without_samples_are_not_averaged() {
        let message = cycle_of(&[0.0, 5e11, 1e12], &[1.0, 2.0, 1.0]).unwrap_err().to_string();
        assert!(message.contains("1000000000000 cycles of 3 samples"), "{message}");
        // Three cycles of eight samples, the middle one left out.
        let phase: Vec<f64> =
            (0..=24).filter(|i| !(8..=16).contains(i)).map(|i| f64::from(i) / 8.0).collect();
        let cycle = cycle_of(&phase, &vec![1.0; phase.len()]).unwrap();
        assert_eq!((cycle.cycles, cycle.left_out), (2, 1));
    }
}
