//! One coordinate as a function of time.

use wingbeat_math::{CubicSpline, Harmonics, Jet, Scalar};

/// A coordinate with its rate and acceleration at any time.
#[derive(Clone, Debug, PartialEq)]
pub enum Coordinate {
    /// Always the same, rad, or m of a displacement.
    Constant(f64),
    /// `mean + sum_n cos[n] cos((n+1) 2 pi f t) + sin[n] sin((n+1) 2 pi f t)`.
    Fourier {
        /// Frequency f of the first harmonic, Hz.
        frequency_hz: f64,
        /// Mean, rad or m.
        mean: f64,
        /// Cosine amplitudes from the first harmonic on, rad or m.
        cos: Vec<f64>,
        /// Sine amplitudes from the first harmonic on, rad or m.
        sin: Vec<f64>,
    },
    /// A table through which a smooth curve is drawn.
    Table(CubicSpline),
}

impl Coordinate {
    /// Value (rad or m), rate and acceleration at `t` s.
    pub fn at(&self, t: f64) -> Jet<f64> {
        match self {
            Self::Constant(value) => Jet::from(*value),
            Self::Fourier { frequency_hz, mean, cos, sin } => {
                let rate = std::f64::consts::TAU * frequency_hz;
                let harmonic = |n: usize| {
                    let order = (n + 1) as f64;
                    Jet::new(order * rate * t, order * rate, 0.0).sin_cos()
                };
                let mut sum = Jet::from(*mean);
                for n in 0..cos.len().max(sin.len()) {
                    let (s, c) = harmonic(n);
                    sum += c * cos.get(n).copied().unwrap_or(0.0) + s * sin.get(n).copied().unwrap_or(0.0);
                }
                sum
            }
            Self::Table(spline) => spline.at(t),
        }
    }

    /// Whether it moves and repeats its motion.
    pub fn repeats(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Fourier { cos, sin, .. } => cos.iter().chain(sin).any(|part| *part != 0.0),
            Self::Table(spline) => spline.is_periodic(),
        }
    }

    /// The harmonics up to `count` of `frequency_hz` nearest to the samples `y` at the times `t` (s), by least squares;
    /// none where the samples do not determine them.
    pub fn fitted(frequency_hz: f64, t: &[f64], y: &[f64], count: usize) -> Option<Self> {
        let Harmonics { mean, cos, sin } = Harmonics::fitted(frequency_hz, t, y, count)?;
        Some(Self::Fourier { frequency_hz, mean, cos, sin })
    }

    /// The coordinate times the factor `factor`: in another unit, of which so many are one of its own unit.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let all = |v: Vec<f64>| v.into_iter().map(|a| a * factor).collect();
        match self {
            Self::Constant(value) => Self::Constant(value * factor),
            Self::Fourier { frequency_hz, mean, cos, sin } => {
                Self::Fourier { frequency_hz, mean: mean * factor, cos: all(cos), sin: all(sin) }
            }
            Self::Table(spline) => Self::Table(spline.scaled(factor)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_found_in_uneven_samples_of_several_cycles() {
        let exact =
            Coordinate::Fourier { frequency_hz: 3.5, mean: 0.1, cos: vec![0.3, -0.2], sin: vec![0.0, 0.4] };
        let t: Vec<f64> = (0..90).map(|i| 0.011 * f64::from(i) + 0.003 * f64::from(i % 4)).collect();
        let y: Vec<f64> = t.iter().map(|t| exact.at(*t).x).collect();
        let found = Coordinate::fitted(3.5, &t, &y, 4).unwrap();
        assert!(t.iter().all(|t| (found.at(t + 0.07).dd - exact.at(t + 0.07).dd).abs() < 1e-8));
        // A quarter of the cycle alone tells four harmonics from one another as little as one sample.
        assert_eq!(Coordinate::fitted(0.25, &t, &y, 4), None);
        assert_eq!(Coordinate::fitted(3.5, &t[..1], &y[..1], 1), None);
    }

    #[test]
    fn rates_are_the_derivatives() {
        let fourier = Coordinate::Fourier {
            frequency_hz: 3.5,
            mean: 0.1,
            cos: vec![0.3, -0.2],
            sin: vec![0.0, 0.4, 0.1],
        };
        let x: Vec<f64> = (0..12).map(|i| i as f64 / 40.0).collect();
        let y: Vec<f64> = x.iter().map(|x| (20.0 * x).sin()).collect();
        let table = Coordinate::Table(CubicSpline::periodic(&x, &y, 0.3).unwrap());
        for coordinate in [fourier, table.scaled(2.0)] {
            let h = 1e-5;
            let [a, b, c] = [0.137 - h, 0.137, 0.137 + h].map(|t| coordinate.at(t));
            assert!(((c.x - a.x) / (2.0 * h) - b.d).abs() < 1e-5);
            assert!(((c.d - a.d) / (2.0 * h) - b.dd).abs() < 1e-3);
        }
    }
}
