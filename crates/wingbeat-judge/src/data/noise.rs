//! Noise, by the third differences of samples: those of a smooth load vanish beside it.

/// The deviation of white noise over the median of its magnitudes: 1 / Phi^-1(3 / 4), and over their lower quartile: 1 / Phi^-1(5 / 8).
pub(super) const OF_MEDIAN: f64 = 1.482_602_218_505_602;
const OF_QUARTILE: f64 = 3.138_334_148_463_79;
/// Deviation of the third differences of white noise over that of the noise, sqrt(1 + 9 + 9 + 1).
pub(super) const OF_THIRD: f64 = 4.472_135_954_999_58;
/// Correlation of the third differences of one sample and the next below which they are those of noise: white noise has -3/4, smooth loads
/// 1. *Choice.*
const WHITE: f64 = -0.5;

/// The middle one; not a number of none.
pub(super) fn median(of: &mut [f64]) -> f64 {
    let middle = of.len() / 2;
    if of.is_empty() { f64::NAN } else { *of.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The lower quartile; not a number of none.
fn quartile(of: &mut [f64]) -> f64 {
    let place = of.len() / 4;
    if of.is_empty() { f64::NAN } else { *of.select_nth_unstable_by(place, f64::total_cmp).1 }
}

/// The third difference of four samples.
pub(super) fn third(of: &[f64]) -> f64 {
    of[3] - of[0] - 3.0 * (of[2] - of[1])
}

/// Deviation of the noise, in the unit of the samples, by the median of the magnitudes of third differences.
pub(super) fn deviation(thirds: &mut [f64]) -> f64 {
    thirds.iter_mut().for_each(|x| *x = x.abs());
    OF_MEDIAN * median(thirds) / OF_THIRD
}

/// The same by their lower quartile, which three quarters of them may lie far from; of zeros none.
pub(super) fn deviation_beside(thirds: &mut [f64]) -> f64 {
    thirds.iter_mut().for_each(|x| *x = x.abs());
    OF_QUARTILE * quartile(thirds) / OF_THIRD
}

/// Whether third differences are those of noise, by how each goes with the one before.
#[derive(Default)]
pub(super) struct Order {
    before: f64,
    turned: f64,
    squares: f64,
}

impl Order {
    pub fn add(&mut self, third: f64) {
        self.turned += third * self.before;
        self.squares += third * third;
        self.before = third;
    }

    pub fn is_noise(&self) -> bool {
        self.turned < WHITE * self.squares
    }
}
