//! Universal constants of the strip model: lags of the wash on the chord and
//! of the wash of the wake, fitted once to a linear lifting surface.

use crate::{LagNumbers, MAX_WASH_LAGS};
use arrayvec::ArrayVec;
use wingbeat_math::Scalar;

/// Time T, s, within which the followed impulse is drawn to the impulse of the air. *Choice*: short against a stroke, and no
/// shorter than what coarse steps of a case (20 a cycle) and the intervals of a predictive controller (25 ms) still follow.
pub(super) const FOLLOWING_TIME: f64 = 1e-2;

/// One set of lags. Rates are per semichord travelled, wake times per mean
/// chord travelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lags {
    /// Rates e_k of the wash lags, dimensionless.
    pub rate: &'static [f64],
    /// Weights psi_k of the lags in the lift wash; they sum to 1/2.
    pub lift: &'static [f64],
    /// Weights gamma_k of the lags in the circulation; they sum to 1.
    pub circulation: &'static [f64],
    /// Weight beta of the wash of the chord doublet, dimensionless.
    pub doublet: f64,
    /// Share of the circulation whose wake wash follows at once.
    pub wake_at_once: f64,
    /// Weights of the delayed wake washes; with `wake_at_once` they sum to 1.
    pub wake: &'static [f64],
    /// Delays of the wake washes, in mean chords over (aspect ratio)^-exponent.
    pub wake_delay: &'static [f64],
    /// Exponent of the aspect ratio in the delays.
    pub exponent: f64,
    /// Whether what pitching adds to the chord doublet has its own place: see aero.strip.carried_place.
    pub places: bool,
}

/// Two wash lags and one wake lag: three states per strip.
///
/// A fit: the least worst of the errors of lift against a linear lifting surface (plunge and sudden start of rectangles, plunge
/// and pitch of other wings, loads along the span, thrust in pitch), each in parts of the size asked of it, together with
/// the mean thrust of Garrick 1936, which the square of C(k) decides.
pub const THREE_LAGS: Lags = Lags {
    rate: &[0.10792, 0.53449],
    lift: &[0.32956, 0.17044],
    circulation: &[0.3382857913120942, 0.6617142086879058],
    doublet: 0.66946,
    wake_at_once: 0.25462,
    wake: &[0.74538],
    wake_delay: &[2.8989],
    exponent: 0.19827,
    places: false,
};

/// Three wash lags and two wake lags: five states per strip.
pub const FIVE_LAGS: Lags = Lags {
    rate: &[0.061284885630933504, 0.24565130431580148, 1.2344872068276207],
    lift: &[0.17531713959734113, 0.2829580337181959, 0.04172482668446299],
    circulation: &[0.19854751096950332, 0.3549461692241535, 0.44650631980634314],
    doublet: 0.8515627078003459,
    wake_at_once: 0.0,
    wake: &[0.7128378060464248, 0.28716219395357523],
    wake_delay: &[0.874302267660053, 4.768861216944018],
    exponent: 0.429521803562794,
    places: true,
};

impl Lags {
    /// Weights in the lift wash and rates of the wash lags.
    pub fn numbers(&self) -> ArrayVec<LagNumbers, MAX_WASH_LAGS> {
        self.lift.iter().zip(self.rate).map(|(&weight, &rate)| LagNumbers { weight, rate }).collect()
    }
    /// States per strip.
    pub fn states_per_strip(&self) -> usize {
        self.rate.len() + self.wake.len()
    }
    /// Weights of the lags in the potential jump left on the chord:
    /// (gamma_k - psi_k) / e_k. They sum to 1, so that the steady doublet is
    /// the one of a flat plate.
    pub fn jump<P: Scalar>(&self, k: usize, lag: &LagNumbers<P>) -> P {
        (P::from(self.circulation[k]) - lag.weight) / lag.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_meet_the_steady_limits() {
        for lags in [THREE_LAGS, FIVE_LAGS] {
            let sum = |xs: &[f64]| xs.iter().sum::<f64>();
            assert!((sum(lags.lift) - 0.5).abs() < 1e-12);
            assert!((sum(lags.circulation) - 1.0).abs() < 1e-12);
            assert!((lags.wake_at_once + sum(lags.wake) - 1.0).abs() < 1e-12);
            let jump: f64 = lags.numbers().iter().enumerate().map(|(k, lag)| lags.jump(k, lag)).sum();
            assert!((jump - 1.0).abs() < 1e-9, "{jump}");
        }
    }
}
