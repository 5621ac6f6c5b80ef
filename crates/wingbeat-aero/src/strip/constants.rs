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
    /// What the logarithms of the rates gain with 2/(A + 2), the share of its lift slope that an elliptic wing
    /// of the aspect ratio A lacks: see [`Lags::of_wing`].
    pub rate_gain: &'static [f64],
    /// What the weights in the lift wash gain with it: nothing in all.
    pub lift_gain: &'static [f64],
    /// Exponent of the aspect ratio in the delays.
    pub exponent: f64,
    /// Dimensionless exponent of the distance between the tips in the delays: see aero.strip.wake_delay.
    pub folding: f64,
    /// Whether strips carry what the outline has beyond the straight lines between their edges: see aero.strip.bulge.
    pub fills: bool,
}

/// Two wash lags and one wake lag: three states per strip.
///
/// A fit: least errors of lift against a linear lifting surface, each in parts of the size asked of it: plunge, pitch and flapping of 17 wings
/// (rectangles, sweeps, tapers, an ellipse, Aerobat's flat and folded) of 9, 16 and 32 strips up to k = 3, the sudden start of rectangles,
/// loads along their span, their mean thrust in pitch, that of Garrick 1936, which the square of C(k) decides, and row `aero.yeo.lift`. 16 wings were kept aside.
/// One delay stands for the near wake, which folds leave as it is: the fit found no power of the distance between the tips.
pub const THREE_LAGS: Lags = Lags {
    rate: &[0.09963, 0.51],
    lift: &[0.31717, 0.18283],
    circulation: &[0.3195978090503692, 0.6804021909496307],
    doublet: 0.71432,
    wake_at_once: 0.16595,
    wake: &[0.83405],
    wake_delay: &[1.32632],
    rate_gain: &[1.39093, 1.27804],
    lift_gain: &[0.27822, -0.27822],
    exponent: 0.3312,
    folding: 0.0,
    fills: true,
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
    rate_gain: &[0.0; 3],
    lift_gain: &[0.0; 3],
    exponent: 0.429521803562794,
    folding: 0.429521803562794,
    fills: false,
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
    /// The lags of a wing of the aspect ratio `aspect` from those of plane flow, and their weights in the circulation. The wash of a short wing
    /// follows sooner, and less of it late. Of the weights in the circulation the first two shift so that those in the potential jump
    /// sum to 1: the steady doublet is the one of a flat plate.
    ///
    /// Equation: aero.strip.lags_by_aspect
    /// `e = e_0 exp(g z), psi = psi_0 + h z, z = 2/(A + 2); sum((gamma - psi)/e) = 1`
    /// Source: Jones 1940, NACA Rep. 681 (form: rates that grow as A falls); a fit.
    /// Test: `weights_meet_the_steady_limits`.
    pub fn of_wing<P: Scalar>(
        &self,
        plane: &[LagNumbers<P>],
        aspect: P,
    ) -> (ArrayVec<LagNumbers<P>, MAX_WASH_LAGS>, ArrayVec<P, MAX_WASH_LAGS>) {
        let lack = (aspect + 2.0).recip() * 2.0;
        let own = |(k, lag): (usize, &LagNumbers<P>)| LagNumbers {
            weight: lag.weight + lack * self.lift_gain[k],
            rate: lag.rate * (lack * self.rate_gain[k]).exp(),
        };
        let lags: ArrayVec<_, MAX_WASH_LAGS> = plane.iter().enumerate().map(own).collect();
        let mut circulation: ArrayVec<P, MAX_WASH_LAGS> =
            self.circulation.iter().map(|g| P::from(*g)).collect();
        let jump = jump_weights(&lags, &circulation).into_iter().fold(P::ZERO, |sum, weight| sum + weight);
        let shift = (P::ONE - jump) / (lags[0].rate.recip() - lags[1].rate.recip());
        circulation[0] += shift;
        circulation[1] -= shift;
        (lags, circulation)
    }
}

/// Weights of the lags in the potential jump left on the chord: (gamma_k - psi_k) / e_k.
pub(super) fn jump_weights<P: Scalar>(
    lags: &[LagNumbers<P>],
    circulation: &[P],
) -> ArrayVec<P, MAX_WASH_LAGS> {
    lags.iter().zip(circulation).map(|(lag, gamma)| (*gamma - lag.weight) / lag.rate).collect()
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
            assert!(sum(lags.lift_gain).abs() < 1e-12);
            let plane = jump_weights(&lags.numbers(), lags.circulation).iter().sum::<f64>();
            assert!((plane - 1.0).abs() < 1e-9, "{plane}");
            for aspect in [1.0, 3.0, 20.0] {
                let (own, circulation) = lags.of_wing(&lags.numbers(), aspect);
                assert!((own.iter().map(|lag| lag.weight).sum::<f64>() - 0.5).abs() < 1e-12);
                assert!((sum(&circulation) - 1.0).abs() < 1e-12);
                let jump = jump_weights(&own, &circulation).iter().sum::<f64>();
                assert!((jump - 1.0).abs() < 1e-12, "{jump}");
            }
        }
    }
}
