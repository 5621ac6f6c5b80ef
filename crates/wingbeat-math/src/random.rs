//! Reproducible random numbers: the same seed gives the same run on every machine.

use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, StandardNormal};

/// A stream of random numbers (ChaCha, 8 rounds).
#[derive(Clone, Debug)]
pub struct Random {
    stream: ChaCha8Rng,
}

impl Random {
    /// A stream chosen by `seed`.
    pub fn new(seed: u64) -> Self {
        Self { stream: ChaCha8Rng::seed_from_u64(seed) }
    }
    /// The stream numbered `stream` of the family chosen by `seed`.
    pub fn stream(seed: u64, stream: u64) -> Self {
        let mut random = Self::new(seed);
        random.stream.set_stream(stream);
        random
    }
    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.stream.next_u64()
    }
    /// A share, uniform in [0, 1).
    #[inline]
    pub fn unit(&mut self) -> f64 {
        self.stream.random()
    }
    /// Uniform in [low, high), in the unit of both.
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    /// Normal with mean 0 and deviation 1, dimensionless: a number of standard deviations.
    #[inline]
    pub fn normal(&mut self) -> f64 {
        self.stream.sample(StandardNormal)
    }
    /// Chi squared with so many degrees of freedom, dimensionless: of whole ones the sum of the squares of so many normal numbers.
    /// Not a number where they are not above 0.
    pub fn chi_squared(&mut self, freedom: f64) -> f64 {
        ChiSquared::new(freedom).map_or(f64::NAN, |squares| self.stream.sample(squares))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_chi_squared() {
        let mut random = Random::new(8);
        let n = 100_000;
        let xs: Vec<f64> = (0..n).map(|_| random.chi_squared(6.5)).collect();
        let mean = xs.iter().sum::<f64>() / n as f64;
        let variance = xs.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        // Of v degrees of freedom v and 2 v.
        assert!((mean - 6.5).abs() < 0.05 && (variance - 13.0).abs() < 0.4, "{mean} {variance}");
        assert!(random.chi_squared(0.0).is_nan());
    }

    #[test]
    fn moments_of_the_normal() {
        let mut random = Random::new(7);
        let n = 200_000;
        let xs: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let moment = |p: i32| xs.iter().map(|x| x.powi(p)).sum::<f64>() / n as f64;
        assert!(moment(1).abs() < 0.01 && (moment(2) - 1.0).abs() < 0.02 && (moment(4) - 3.0).abs() < 0.1);
    }
}
