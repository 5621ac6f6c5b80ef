//! The scatter from sample to sample.

use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Phases by which the scatter from sample to sample is taken.
const BINS: usize = 128;

/// Sums by phase, for the scatter from sample to sample.
pub struct Bins {
    count: Vec<f64>,
    /// Sums of where samples lie in their bin, in its width from its middle, and of the squares of that.
    place: Vec<[f64; 2]>,
    sum: Vec<[f64; 6]>,
    /// Sums of values times places.
    sloped: Vec<[f64; 6]>,
    square: DMatrix<f64>,
}

/// Variance of the places of the samples of a bin, in squares of its width, below which they lie at one phase and tell no slope; evenly
/// spread ones have 1 / 12. *Choice.*
const ONE_PHASE: f64 = 0.01;

impl Bins {
    pub fn new() -> Self {
        Self {
            count: vec![0.0; BINS],
            place: vec![[0.0; 2]; BINS],
            sum: vec![[0.0; 6]; BINS],
            sloped: vec![[0.0; 6]; BINS],
            square: DMatrix::zeros(6, 6),
        }
    }

    pub fn add(&mut self, phase: f64, x: [f64; 6]) {
        if x.iter().any(|x| !x.is_finite()) {
            return;
        }
        let place = (phase / TAU).rem_euclid(1.0) * BINS as f64;
        let bin = place as usize % BINS;
        let u = place.fract() - 0.5;
        self.count[bin] += 1.0;
        self.place[bin][0] += u;
        self.place[bin][1] += u * u;
        for a in 0..6 {
            self.sum[bin][a] += x[a];
            self.sloped[bin][a] += u * x[a];
            for b in 0..6 {
                self.square[(a, b)] += x[a] * x[b];
            }
        }
    }

    /// Covariance about the line through the samples of each bin, in the units of the channels, squared: a load that is steep there
    /// does not count as noise.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.square.clone();
        let mut freedom = 0.0;
        for (bin, count) in self.count.iter().enumerate().filter(|(_, count)| **count > 0.0) {
            let [u, uu] = self.place[bin];
            let sum = &self.sum[bin];
            let across = uu - u * u / count;
            let sloped = *count > 2.0 && across > ONE_PHASE * count;
            let slope = |a: usize| self.sloped[bin][a] - u * sum[a] / count;
            freedom += if sloped { count - 2.0 } else { count - 1.0 };
            for a in 0..6 {
                for b in 0..6 {
                    covariance[(a, b)] -= sum[a] * sum[b] / count;
                    if sloped {
                        covariance[(a, b)] -= slope(a) * slope(b) / across;
                    }
                }
            }
        }
        covariance / f64::max(freedom, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::math::Random;

    #[test]
    fn a_steep_load_adds_nothing_to_its_noise() {
        let mut random = Random::stream(5, 0);
        let mut bins = Bins::new();
        for k in 0..40_000 {
            let phase = 0.0137 * f64::from(k);
            let noise = 0.01 * random.normal();
            bins.add(phase, [3.0 * (2.0 * phase).sin() + noise, noise, 0.0, 0.0, 0.0, 0.0]);
        }
        let found = bins.covariance();
        for (a, b) in [(0, 0), (1, 1), (0, 1)] {
            assert!((found[(a, b)] / 1e-4 - 1.0).abs() < 0.05, "{a} {b}: {}", found[(a, b)]);
        }
        assert!(found[(2, 2)].abs() < 1e-20);
    }
}
