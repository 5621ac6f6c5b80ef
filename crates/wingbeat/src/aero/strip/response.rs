//! From lags and motion to washes, state rates and impulses.

use super::influence::{Column, Matrix, multiply};
use super::motion::Strip;
use super::{Flow, StripModel};
use crate::math::{Dual, Scalar};

/// Sums over the lags of each strip, and later their rates.
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
    /// Wash at 3/4 chord, m/s.
    pub wash: Column<S, N>,
    /// Lift wash, m/s.
    pub lift_wash: Column<S, N>,
    /// Lift wash with the part that only turns the force, m/s.
    pub turning_wash: Column<S, N>,
    /// Normal impulse of the air on each strip, N s, and its rate, N.
    pub impulse: Column<S, N>,
    pub impulse_rate: Column<S, N>,
    /// Impulse per normal speed, symmetric, kg.
    pub inertia: Matrix<S, N>,
    /// Normal speed left by a unit normal speed of the whole wing.
    pub relief: Column<S, N>,
}

impl StripModel {
    /// Sums over the lags of all strips.
    pub(super) fn lag_sums<S: Scalar, const N: usize>(
        &self,
        strips: &[Strip<S>; N],
        x: &[S],
    ) -> LagSums<S, N> {
        let n = self.settings.strips;
        let mut sums = LagSums { circulation: [S::ZERO; N], jump: [S::ZERO; N], delayed: [S::ZERO; N] };
        for i in 0..n {
            let [circulation, jump, delayed] = self.lag_sum(i, strips[i].along, |k| x[k * n + i]);
            sums.circulation[i] = circulation;
            sums.jump[i] = jump;
            sums.delayed[i] = delayed;
        }
        sums
    }

    /// Rates of the sums, the chordwise speed held.
    fn lag_sum_rates<S: Scalar, const N: usize>(
        &self,
        strips: &[Strip<S>; N],
        x: &[S],
        dx: &[S],
    ) -> LagSums<S, N> {
        let n = self.settings.strips;
        let mut rates = LagSums { circulation: [S::ZERO; N], jump: [S::ZERO; N], delayed: [S::ZERO; N] };
        for i in 0..n {
            let state = |k: usize| Dual::<1, S> { re: x[k * n + i], eps: [dx[k * n + i]] };
            let [circulation, jump, delayed] = self.lag_sum(i, Dual::constant(strips[i].along), state);
            rates.circulation[i] = circulation.eps[0];
            rates.jump[i] = jump.eps[0];
            rates.delayed[i] = delayed.eps[0];
        }
        rates
    }

    /// Gamma, D and Y of strip `i`, which meets the chordwise speed `along` and has the states `state(k)`.
    /// Gamma = s g (sum gamma_k l_k), D = 2 s d (sum q_k l_k), Y = a0 Gamma + sum a_m y_m,
    /// where s is the share of the circulation that stays attached at the mean square of the lags.
    ///
    /// Equation: aero.strip.lag_sums
    #[inline]
    fn lag_sum<S: Scalar>(&self, i: usize, along: S, state: impl Fn(usize) -> S) -> [S; 3] {
        let lags = self.lags;
        let (mut wash, mut wash2, mut jump) = (S::ZERO, S::ZERO, S::ZERO);
        for k in 0..lags.rate.len() {
            let lag = state(k);
            wash += lag * lags.circulation[k];
            wash2 += lag.squared() * lags.circulation[k];
            jump += lag * lags.jump(k);
        }
        let attached = self.attached(along, wash2);
        let circulation = wash * attached * self.slope[i];
        let mut delayed = circulation * lags.wake_at_once;
        for (m, weight) in lags.wake.iter().enumerate() {
            delayed += state(lags.rate.len() + m) * *weight;
        }
        [circulation, jump * attached * (2.0 * self.doublet[i]), delayed]
    }

    /// Share of the lift that stays attached at the chordwise speed `along` and
    /// the squared normal wash `wash2`.
    #[inline]
    pub(super) fn attached<S: Scalar>(&self, along: S, wash2: S) -> S {
        let sine2 = wash2 / (wash2 + along.squared() + self.floor * self.floor);
        self.settings.law.attached_share(sine2, self.separation_scale)
    }

    /// K (D - Y) + R Y: the three-dimensional wash of what the lags hold.
    fn held_wash<S: Scalar, const N: usize>(&self, flow: &Flow<S, N>, sums: &LagSums<S, N>) -> Column<S, N> {
        let n = self.settings.strips;
        let mut open = [S::ZERO; N];
        for i in 0..n {
            open[i] = sums.jump[i] - sums.delayed[i];
        }
        let (jump, wake) = (multiply(&flow.doublet, &open, n), multiply(&flow.remainder, &sums.delayed, n));
        std::array::from_fn(|i| jump[i] + wake[i])
    }

    /// Washes, state rates and impulses.
    ///
    /// A0 w3 = K (d w12 + D - Y) + R Y; w = w34 + w3;
    /// l_k' = e_k V/b (w - l_k); y_m' = V/tau_m (Gamma - y_m).
    ///
    /// Equation: aero.strip.wash
    pub(super) fn respond<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        sums: &LagSums<S, N>,
        x: &[S],
        dx: &mut [S],
    ) -> Response<S, N> {
        let (n, lags) = (self.settings.strips, self.lags);
        let held = self.held_wash(flow, sums);
        let held_left = multiply(&flow.relief, &held, n);
        let half: Column<S, N> = std::array::from_fn(|i| flow.strips[i].wash_half);
        let half_left = multiply(&flow.relief, &half, n);
        let (mut washes, mut lift_wash) = ([S::ZERO; N], [S::ZERO; N]);
        for i in 0..n {
            let wash = flow.strips[i].wash + half_left[i] + held_left[i] - half[i];
            washes[i] = wash;
            lift_wash[i] = wash * 0.5;
            let turnover = flow.strips[i].speed * (2.0 / self.grid.chord[i]);
            for k in 0..lags.rate.len() {
                lift_wash[i] += x[k * n + i] * lags.lift[k];
                dx[k * n + i] = turnover * (wash - x[k * n + i]) * lags.rate[k];
            }
            for (m, length) in self.wake_length.iter().enumerate() {
                let at = (lags.rate.len() + m) * n + i;
                dx[at] = flow.strips[i].speed * (sums.circulation[i] - x[at]) * (1.0 / length);
            }
        }
        let mut response = Response {
            circulation: sums.circulation,
            wash: washes,
            lift_wash,
            turning_wash: self.turning_wash(flow, sums, &lift_wash),
            impulse: [S::ZERO; N],
            impulse_rate: [S::ZERO; N],
            inertia: [[S::ZERO; N]; N],
            relief: multiply(&flow.relief, &[S::ONE; N], n),
        };
        if self.settings.added_mass {
            self.impulses(flow, &half, &held_left, x, dx, &mut response);
        }
        response
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

    /// Added mass of strip `i` as part of an infinite wing, kg.
    pub(super) fn strip_mass(&self, i: usize) -> f64 {
        self.settings.density_kg_m3 * self.grid.width[i] * self.apparent[i]
    }

    /// P = B w12 + rho dy ma A0^-1 [K (D - Y) + R Y], with B the
    /// symmetric part of rho dy ma A0^-1 (reciprocity); the rates of K and R are left out.
    ///
    /// Equation: aero.strip.impulse
    fn impulses<S: Scalar, const N: usize>(
        &self,
        flow: &Flow<S, N>,
        half: &Column<S, N>,
        held_left: &Column<S, N>,
        x: &[S],
        dx: &[S],
        response: &mut Response<S, N>,
    ) {
        let n = self.settings.strips;
        let mass = |i: usize| self.strip_mass(i);
        for j in 0..n {
            for i in 0..n {
                response.inertia[j][i] =
                    flow.relief[j][i] * (0.5 * mass(i)) + flow.relief[i][j] * (0.5 * mass(j));
            }
        }
        let half_rate: Column<S, N> = std::array::from_fn(|i| flow.strips[i].wash_half_rate);
        let held_rate = self.held_wash(flow, &self.lag_sum_rates(&flow.strips, x, dx));
        let held_rate_left = multiply(&flow.relief, &held_rate, n);
        let (by_half, by_rate) =
            (multiply(&response.inertia, half, n), multiply(&response.inertia, &half_rate, n));
        for i in 0..n {
            response.impulse[i] = by_half[i] + held_left[i] * mass(i);
            response.impulse_rate[i] = by_rate[i] + held_rate_left[i] * mass(i);
        }
    }
}
