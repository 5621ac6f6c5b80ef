//! The scatter from sample to sample.

use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Phases by which the scatter from sample to sample is taken.
const BINS: usize = 128;

/// Sums by phase, for the scatter from sample to sample.
pub struct Bins {
    count: Vec<f64>,
    sum: Vec<[f64; 6]>,
    square: DMatrix<f64>,
}

impl Bins {
    pub fn new() -> Self {
        Self { count: vec![0.0; BINS], sum: vec![[0.0; 6]; BINS], square: DMatrix::zeros(6, 6) }
    }

    pub fn add(&mut self, phase: f64, x: [f64; 6]) {
        if x.iter().any(|x| !x.is_finite()) {
            return;
        }
        let bin = ((phase / TAU).rem_euclid(1.0) * BINS as f64) as usize % BINS;
        self.count[bin] += 1.0;
        for a in 0..6 {
            self.sum[bin][a] += x[a];
            for b in 0..6 {
                self.square[(a, b)] += x[a] * x[b];
            }
        }
    }

    /// Covariance about the mean of each phase, in the units of the channels, squared.
    pub fn covariance(&self) -> DMatrix<f64> {
        let mut covariance = self.square.clone();
        let mut freedom = 0.0;
        for (count, sum) in self.count.iter().zip(&self.sum).filter(|(count, _)| **count > 0.0) {
            freedom += count - 1.0;
            for a in 0..6 {
                for b in 0..6 {
                    covariance[(a, b)] -= sum[a] * sum[b] / count;
                }
            }
        }
        covariance / f64::max(freedom, 1.0)
    }
}
