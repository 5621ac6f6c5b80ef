//! From lags and motion to washes, state rates and impulses.

use super::influence::{Column, multiply, multiply_transposed};
use super::{Flow, StripModel};
use crate::aero::LiftLaw;
use crate::math::{Dual, Scalar};

/// Linear sums over the lags of each strip.
#[derive(Clone, Copy)]
pub(super) struct Lagged<S: Scalar, const N: usize> {
    /// sum gamma_k l_k, m/s.
    wash: Column<S, N>,
    /// sum q_k l_k, m/s.
    jump: Column<S, N>,
    /// sum a_m y_m, m2/s.
    delayed: Column<S, N>,
}

/// What the lags hold on each strip, and later its rates.
pub(super) struct LagSums<S: Scalar, const N: usize> {
    /// Circulation, m2/s.
    pub circulation: Column<S, N>,
    /// Potential jump left on the chord by the lags, over the chord, m2/s.
    pub jump: Column<S, N>,
    /// Circulation as the wash of the wake sees it, m2/s.
    pub delayed: Column<S, N>,
}

/// Washes and impulses of the strips.
pub(super) struct Response<S: Scalar, const N: usize> {
    /// Circulation, m2/s.
    pub circulation: Column<S, N>,
    /// Share of the lift that stays attached.
    pub attached: Column<S, N>,
    /// Wash at 3/4 chord, m/s.
    pub wash: Column<S, N>,
    /// Lift wash, m/s.
    pub lift_wash: Column<S, N>,
    /// Lift wash with the part that only turns the force, m/s.
    pub turning_wash: Column<S, N>,
    /// Normal impulse of the air on each strip, N s, and its rate, N.
    pub impulse: Column<S, N>,
    pub impulse_rate: Column<S, N>,
    /// Normal speed left by a unit normal speed of the whole wing.
    pub relief: Column<S, N>,
}

impl StripModel {
    /// Linear sums over the lags.
    #[inline(always)]
    pub(super) fn lagged<S: Scalar, const N: usize>(&self, x: &[S]) -> Lagged<S, N> {
        let (n, lags) = (self.settings.strips, self.lags);
        let zero = [S::ZERO; N];
        let mut sums = Lagged { wash: zero, jump: zero, delayed: zero };
        let (wash, wake) = x.split_at(lags.rate.len() * n);
        for (k, block) in wash.chunks_exact(n).enumerate() {
            let (circulation, jump) = (lags.circulation[k], lags.jump(k));
            for (i, lag) in block.iter().enumerate().take(N) {
                sums.wash[i] += *lag * circulation;
                sums.jump[i] += *lag * jump;
            }
        }
        for (weight, block) in lags.wake.iter().zip(wake.chunks_exact(n)) {
            for (i, lag) in block.iter().enumerate().take(N) {
                sums.delayed[i] += *lag * *weight;
            }
        }
        sums
    }

    /// Gamma = s g (sum gamma_k l_k), D = 2 s d (sum q_k l_k), Y = a0 Gamma + sum a_m y_m,
    /// where s is the share of the circulation that stays attached.
    ///
    /// Equation: aero.strip.lag_sums
    pub(super) fn lag_sums<S: Scalar, const N: usize>(
        &self,
        lagged: &Lagged<S, N>,
        attached: &Column<S, N>,
    ) -> LagSums<S, N> {
        let mut sums = LagSums { circulation: lagged.wash, jump: lagged.jump, delayed: lagged.delayed };
        let constants = self.slope.iter().zip(&self.doublet);
        for (i, (slope, doublet)) in constants.enumerate().take(N) {
            sums.circulation[i] *= attached[i] * *slope;
            sums.jump[i] *= attached[i] * (2.0 * doublet);
            sums.delayed[i] += sums.circulation[i] * self.lags.wake_at_once;
        }
        sums
    }

    /// Rates of the sums, the speeds held.
    fn lag_sum_rates<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        lagged: Lagged<S, N>,
        attached: &Column<S, N>,
        x: &[S],
        dx: &[S],
    ) -> LagSums<S, N> {
        let mut rates = self.lag_sums(&self.lagged(dx), attached);
        if self.settings.law == LiftLaw::Linear {
            return rates;
        }
        let n = self.settings.strips;
        let attached_rate = std::array::from_fn(|i| {
            let state =
                |k: usize| Dual::<1, S> { re: x[k * n + i.min(n - 1)], eps: [dx[k * n + i.min(n - 1)]] };
            self.attached(Dual::constant(flow.along[i]), Dual::constant(flow.wash[i]), state).eps[0]
        });
        let more = self.lag_sums(&Lagged { delayed: [S::ZERO; N], ..lagged }, &attached_rate);
        for i in 0..N {
            rates.circulation[i] += more.circulation[i];
            rates.jump[i] += more.jump[i];
            rates.delayed[i] += more.delayed[i];
        }
        rates
    }

    /// Share of the lift of each strip that stays attached.
    fn attached_shares<S: Scalar, const N: usize>(&self, flow: &Flow<S, N>, x: &[S]) -> Column<S, N> {
        if self.settings.law == LiftLaw::Linear {
            return [S::ONE; N];
        }
        let n = self.settings.strips;
        std::array::from_fn(|i| self.attached(flow.along[i], flow.wash[i], |k| x[k * n + i.min(n - 1)]))
    }

    /// Share of the lift that stays attached at the chordwise speed `along`, the wash of motion
    /// `wash` and the wash lags `state(k)`, from the mean square of what the section meets now
    /// and has met: (w34^2 + sum gamma_k l_k^2) / 2. The two vanish together only at rest, so
    /// that a section broadside on does not count as attached while its lags change sign.
    ///
    /// Equation: aero.strip.attached_share
    #[inline]
    fn attached<S: Scalar>(&self, along: S, wash: S, state: impl Fn(usize) -> S) -> S {
        let weights = self.lags.circulation.iter().enumerate();
        let lagged2 = weights.fold(S::ZERO, |sum, (k, weight)| sum + state(k).squared() * *weight);
        let wash2 = (lagged2 + wash.squared()) * 0.5;
        let sine2 = wash2 / (wash2 + along.squared() + self.floor * self.floor);
        self.settings.law.attached_share(sine2, self.separation_scale)
    }

    /// K (D - Y) + R Y: the three-dimensional wash of what the lags hold.
    fn held_wash<S: Scalar, const N: usize>(&self, flow: &Flow<S, N>, sums: &LagSums<S, N>) -> Column<S, N> {
        let n = self.settings.strips;
        let open = std::array::from_fn(|i| sums.jump[i] - sums.delayed[i]);
        let (jump, wake) = (multiply(&flow.doublet, &open, n), multiply(&flow.remainder, &sums.delayed, n));
        std::array::from_fn(|i| jump[i] + wake[i])
    }

    /// Washes, state rates and impulses.
    ///
    /// A0 w3 = K (d w12 + D - Y) + R Y; w = w34 + w3;
    /// l_k' = e_k V/b (w - l_k); y_m' = V/tau_m (Gamma - y_m).
    ///
    /// Equation: aero.strip.wash
    #[inline(always)]
    pub(super) fn respond<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        x: &[S],
        dx: &mut [S],
    ) -> Response<S, N> {
        let n = self.settings.strips;
        let lagged = self.lagged(x);
        let attached = self.attached_shares(flow, x);
        let sums = self.lag_sums(&lagged, &attached);
        let held_left = multiply(&flow.relief, &self.held_wash(flow, &sums), n);
        let half_left = multiply(&flow.relief, &flow.half, n);
        let wash = std::array::from_fn(|i| flow.wash[i] + half_left[i] + held_left[i] - flow.half[i]);
        let lift_wash = self.advance_lags(flow, &wash, &sums.circulation, x, dx);
        let mut response = Response {
            circulation: sums.circulation,
            attached,
            wash,
            lift_wash,
            turning_wash: self.turning_wash(flow, &sums, &lift_wash),
            impulse: [S::ZERO; N],
            impulse_rate: [S::ZERO; N],
            relief: multiply(&flow.relief, &[S::ONE; N], n),
        };
        if self.settings.added_mass {
            let held_rate = self.held_wash(flow, &self.lag_sum_rates(flow, lagged, &attached, x, dx));
            self.impulses(flow, [&half_left, &held_left], &held_rate, &mut response);
        }
        response
    }

    /// Rates of the lags; returns the lift wash w/2 + sum psi_k l_k.
    fn advance_lags<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        wash: &Column<S, N>,
        circulation: &Column<S, N>,
        x: &[S],
        dx: &mut [S],
    ) -> Column<S, N> {
        let (n, lags) = (self.settings.strips, self.lags);
        let mut lift_wash = wash.map(|w| w * 0.5);
        let blocks = x.chunks_exact(n).zip(dx.chunks_exact_mut(n));
        for (k, (block, rates)) in blocks.enumerate() {
            let pairs = block.iter().zip(rates).zip(&self.turnover).enumerate().take(N);
            if let Some((rate, lift)) = lags.rate.get(k).zip(lags.lift.get(k)) {
                for (i, ((lag, lag_rate), turnover)) in pairs {
                    lift_wash[i] += *lag * *lift;
                    *lag_rate = flow.speed[i] * (wash[i] - *lag) * (turnover * rate);
                }
            } else if let Some(inverse) = self.inverse_wake_length.get(k - lags.rate.len()) {
                for (i, ((lag, lag_rate), _)) in pairs {
                    *lag_rate = flow.speed[i] * (circulation[i] - *lag) * *inverse;
                }
            }
        }
        lift_wash
    }

    /// W = lw + (T - R)(2/3 Y + 1/3 Gamma): the wash that turns the force takes the trailing
    /// vortices at the bound vortex, half of their wash far behind (Munk), in place
    /// of 3/4 chord.
    ///
    /// Equation: aero.strip.turning_wash
    fn turning_wash<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        sums: &LagSums<S, N>,
        lift_wash: &Column<S, N>,
    ) -> Column<S, N> {
        let n = self.settings.strips;
        let seen: Column<S, N> =
            std::array::from_fn(|i| sums.delayed[i] * (2.0 / 3.0) + sums.circulation[i] * (1.0 / 3.0));
        let (far, near) = (multiply(&flow.far, &seen, n), multiply(&flow.remainder, &seen, n));
        std::array::from_fn(|i| lift_wash[i] + far[i] - near[i])
    }

    /// P = B w12 + rho dy ma A0^-1 [K (D - Y) + R Y], with B the
    /// symmetric part of rho dy ma A0^-1 (reciprocity); the rates of K and R are left out.
    ///
    /// Equation: aero.strip.impulse
    fn impulses<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        [half_left, held_left]: [&Column<S, N>; 2],
        held_rate: &Column<S, N>,
        response: &mut Response<S, N>,
    ) {
        let n = self.settings.strips;
        let rate_left = multiply(&flow.relief, &flow.half_rate, n);
        let held_rate_left = multiply(&flow.relief, held_rate, n);
        let (by_half, by_rate) = (self.reciprocal(flow, &flow.half), self.reciprocal(flow, &flow.half_rate));
        for (i, mass) in self.strip_mass.iter().enumerate().take(N) {
            response.impulse[i] = (half_left[i] * 0.5 + held_left[i]) * *mass + by_half[i] * 0.5;
            response.impulse_rate[i] = (rate_left[i] * 0.5 + held_rate_left[i]) * *mass + by_rate[i] * 0.5;
        }
    }

    /// The transpose of rho dy ma A0^-1 times `v`.
    fn reciprocal<S: Scalar, const N: usize>(&self, flow: &Flow<S, N>, v: &Column<S, N>) -> Column<S, N> {
        let mut weighted = *v;
        for (v, mass) in weighted.iter_mut().zip(&self.strip_mass) {
            *v *= *mass;
        }
        multiply_transposed(&flow.relief, &weighted, self.settings.strips)
    }
}
