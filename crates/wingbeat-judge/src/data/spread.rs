//! A number of each cycle, or of each part of a file, and how far they differ.

/// Numbers by least squares, each a numerator over a denominator.
pub(super) struct CycleSpread {
    pub of: Vec<f64>,
    pub mean: f64,
    /// Mean square about the mean.
    pub spread: f64,
    /// That which white noise of the variance s2 gives it: s2 over the mean of the denominators.
    pub noise: f64,
}

/// Numbers from which they are compared. *Choice.*
const FOR_SCATTER: usize = 4;
/// Variance over that which noise gives, above which it is told. *Choice.*
const ABOVE_NOISE: f64 = 4.0;

impl CycleSpread {
    /// By numerators and denominators; `white` is the variance of the noise, the square of the unit of the values.
    pub fn of(sums: impl Iterator<Item = [f64; 2]>, white: f64) -> Self {
        let sums: Vec<[f64; 2]> = sums.collect();
        let (count, all) = (sums.len() as f64, sums.iter().map(|[_, below]| below).sum::<f64>());
        let ratio = |[above, below]: [f64; 2]| if below > 0.0 { above / below } else { 0.0 };
        let of: Vec<f64> = sums.into_iter().map(ratio).collect();
        let mean = of.iter().sum::<f64>() / count;
        let spread = of.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        Self { mean, spread, noise: white * count / all.max(f64::MIN_POSITIVE), of }
    }

    pub fn is_told(&self) -> bool {
        self.of.len() >= FOR_SCATTER && self.spread > ABOVE_NOISE * self.noise
    }

    /// Root mean square about the mean, without what noise gives, in the unit of the values.
    pub fn size(&self) -> f64 {
        (self.spread - self.noise).max(0.0).sqrt()
    }

    /// Change from start to end by a straight line, and its standard error, in the unit of the values. The squares of places that lie evenly from -1/2 to 1/2 have
    /// the mean (1 - 1 / n^2) / 12.
    pub fn trend(&self) -> [f64; 2] {
        let count = self.of.len() as f64;
        let at = |k: usize| (k as f64 + 0.5) / count - 0.5;
        let squares = (count - 1.0 / count) / 12.0;
        let slope = self.of.iter().enumerate().map(|(k, x)| at(k) * x).sum::<f64>() / squares;
        let left = (self.spread - slope * slope * squares / count).max(self.noise);
        [slope, (left / squares).sqrt()]
    }
}
