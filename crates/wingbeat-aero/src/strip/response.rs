//! From lags and motion to washes, state rates and impulses.

use super::constants::FOLLOWING_TIME;
use super::influence::{StripColumn, column, lanes, large, multiply};
use super::membrane::{Camber, SectionAirs};
use super::motion::{Strips, Wakes};
use super::mutual::Foreign;
use super::{StripFlow, StripModel};
use crate::LagNumbers;
use crate::law::{Attachment, Polar, lev};
use crate::section::suction_share;
use wingbeat_math::{Dual, Meets, Over, Scalar};

/// Linear sums over the lags of each strip.
#[derive(Clone, Copy)]
pub(super) struct Lagged<S: Scalar, const N: usize> {
    /// sum gamma_k l_k, m/s.
    pub wash: StripColumn<S, N>,
    /// sum q_k l_k, m/s.
    pub jump: StripColumn<S, N>,
    /// sum a_m y_m, m2/s.
    pub delayed: StripColumn<S, N>,
}

/// What the lags hold on each strip, and later its rates.
pub(super) struct LagSums<S: Scalar, const N: usize> {
    /// Circulation, m2/s.
    pub circulation: StripColumn<S, N>,
    /// Potential jump left on the chord by the lags, over the chord, m2/s.
    pub jump: StripColumn<S, N>,
    /// Circulation as the wash of the wake sees it, m2/s.
    pub delayed: StripColumn<S, N>,
}

/// Washes and impulses of the strips.
pub(super) struct StripResponse<'a, S: Scalar, const N: usize> {
    /// Circulation, m2/s.
    pub circulation: &'a StripColumn<S, N>,
    /// Share of the lift that stays attached.
    pub attached: &'a StripColumn<S, N>,
    /// Circulation of the lift times the density, kg/(m s), as the strips beside feel it; zero where they do not.
    pub beside: &'a StripColumn<S, N>,
    /// Wash at 3/4 chord, m/s.
    pub wash: &'a StripColumn<S, N>,
    /// Lift wash, m/s.
    pub lift_wash: &'a StripColumn<S, N>,
    /// Lift wash with the part that only turns the force, m/s.
    pub turning_wash: &'a StripColumn<S, N>,
    /// What law `lev` says of the leading edges.
    pub edges: Option<&'a LeadingEdges<S, N>>,
    /// What a membrane does.
    pub camber: Option<&'a Camber<'a, S, N>>,
    /// Normal impulse of the air on each strip, N s, and its rate, N.
    pub impulse: &'a StripColumn<S, N>,
    pub impulse_rate: &'a StripColumn<S, N>,
}

/// The leading edges under law `lev`.
pub(super) struct LeadingEdges<S: Scalar, const N: usize> {
    /// Share of the linear suction that they hold.
    pub held: StripColumn<S, N>,
    /// Normal force of the vortex over `drag_scale`, m2/s2.
    pub vortex: StripColumn<S, N>,
}

/// How what the lags hold on each strip acts on all of them. None of it is given where it is carried through with all derivatives.
pub(super) trait Spread<S: Scalar, const N: usize> {
    /// What is left on the chord of the wash of what the lags hold, m/s.
    #[inline(always)]
    fn left(&mut self, _sums: &LagSums<S, N>) -> Option<StripColumn<S, N>> {
        None
    }
    /// The wash of the circulation that is seen, m2/s, far behind and at 3/4 chord, m/s.
    #[inline(always)]
    fn turned(&mut self, _seen: &StripColumn<S, N>) -> Option<[StripColumn<S, N>; 2]> {
        None
    }
    /// The circulation that acts on the strips beside.
    #[inline(always)]
    fn beside(&mut self, _bound: &mut StripColumn<S, N>) {}
    /// The squared sines of incidence that ask for separation, before they spread along the span.
    #[inline(always)]
    fn sines(&mut self, _sines: &mut StripColumn<S, N>) {}
    /// The same once they are spread, and the rate at which a strip that is all attached follows one, 1/s.
    #[inline(always)]
    fn spread_sines(&mut self, _sines: &StripColumn<S, N>, _rate: impl Fn(usize, S) -> S) {}
}

/// With all derivatives.
pub(super) struct FullSpread;

impl<S: Scalar, const N: usize> Spread<S, N> for FullSpread {}

impl<P: Scalar> StripModel<P> {
    /// Linear sums over the lags.
    #[inline(always)]
    pub(super) fn lagged<S: Scalar + Meets<P>, const N: usize>(&self, x: &[S]) -> Lagged<S, N> {
        let (n, lags) = (self.settings.strips, self.lags);
        let (wash, wake) = x.split_at(lags.rate.len() * n);
        if const { large::<S>() } {
            let weighted = |i: usize, jump: bool| {
                (0..lags.rate.len()).fold(S::ZERO, |sum, k| {
                    let lag = wash[k * n + i];
                    sum + lag * if jump { self.tables.jump_weights[k] } else { self.tables.circulation[k] }
                })
            };
            let delayed = |i: usize| {
                lags.wake.iter().enumerate().fold(S::ZERO, |sum, (k, weight)| sum + wake[k * n + i] * *weight)
            };
            return Lagged {
                wash: column(n, |i| weighted(i, false)),
                jump: column(n, |i| weighted(i, true)),
                delayed: column(n, delayed),
            };
        }
        let zero = [S::ZERO; N];
        let mut sums = Lagged { wash: zero, jump: zero, delayed: zero };
        for (k, block) in wash.chunks_exact(n).enumerate() {
            let (circulation, jump) = (self.tables.circulation[k], self.tables.jump_weights[k]);
            for i in 0..n.min(N) {
                sums.wash[i] += block[i] * circulation;
                sums.jump[i] += block[i] * jump;
            }
        }
        for (k, weight) in lags.wake.iter().enumerate() {
            let block = &wake[k * n..][..n];
            for i in 0..n.min(N) {
                sums.delayed[i] += block[i] * *weight;
            }
        }
        sums
    }

    /// Gamma = s g (sum gamma_k l_k), D = s (g - d) (sum q_k l_k), Y = a0 Gamma + sum a_m y_m,
    /// where s is the share of the circulation that stays attached.
    ///
    /// Equation: aero.strip.lag_sums
    /// `Gamma = s g sum(gamma_k l_k), D = s (g - d) sum(q_k l_k), Y = a0 Gamma + sum(a_m y_m), q_k = (gamma_k -
    /// psi_k)/e_k`
    /// Source: Wagner 1925, Jones 1940 (form); own constants.
    /// Test: `weights_meet_the_steady_limits`.
    pub(super) fn lag_sums<S: Scalar + Meets<P>, const N: usize>(
        &self,
        lagged: &Lagged<S, N>,
        attached: &StripColumn<S, N>,
    ) -> LagSums<S, N> {
        let n = self.settings.strips;
        // What is left in a gap's lags has no wing to shed it.
        let delayed = |i: usize, circulation: S| {
            lagged.delayed[i] * self.tables.covered[i] + circulation * self.lags.wake_at_once
        };
        if const { large::<S>() } {
            let circulation = column(n, |i| self.attached_sums(i, lagged, attached).0);
            let jump = column(n, |i| self.attached_sums(i, lagged, attached).1);
            return LagSums { delayed: column(n, |i| delayed(i, circulation[i])), circulation, jump };
        }
        let zero = [S::ZERO; N];
        let mut sums = LagSums { circulation: zero, jump: zero, delayed: zero };
        for i in 0..lanes::<S, N>(n) {
            (sums.circulation[i], sums.jump[i]) = self.attached_sums(i, lagged, attached);
            sums.delayed[i] = delayed(i, sums.circulation[i]);
        }
        sums
    }

    /// What is attached of circulation and jump of strip `i`.
    #[inline(always)]
    fn attached_sums<S: Scalar + Meets<P>, const N: usize>(
        &self,
        i: usize,
        lagged: &Lagged<S, N>,
        attached: &StripColumn<S, N>,
    ) -> (S, S) {
        let circulation = lagged.wash[i] * (attached[i] * self.tables.slope[i]);
        (circulation, lagged.jump[i] * (attached[i] * self.tables.jump[i]))
    }

    /// Rates of the sums, the speeds held.
    fn lag_sum_rates<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        lagged: &Lagged<S, N>,
        attached: &StripColumn<S, N>,
        x: &[S],
        dx: &[S],
    ) -> LagSums<S, N> {
        let mut rates = self.lag_sums(&self.lagged(dx), attached);
        let (n, strips) = (self.settings.strips, &flow.strips);
        let attached_rate = match self.settings.section.law.about().attachment {
            Attachment::Whole => return rates,
            Attachment::AtOnce => std::array::from_fn(|i| {
                let polar = self.polar.map(|number| Dual::<1, S>::constant(S::from(number)));
                let state =
                    |k: usize| Dual::<1, S> { re: x[k * n + i.min(n - 1)], eps: [dx[k * n + i.min(n - 1)]] };
                let held = |speed: G| Dual::<1, S>::constant(S::from(speed));
                self.attached(&polar, held(strips.along[i]), held(strips.wash[i]), state).eps[0]
            }),
            Attachment::Lagging { state, .. } => {
                let mut rates = self.law_column(dx, state);
                for i in 0..lanes::<S, N>(n) {
                    rates[i] = -rates[i];
                }
                rates
            }
        };
        for i in 0..lanes::<S, N>(n) {
            let (circulation, jump) = self.attached_sums(i, lagged, &attached_rate);
            rates.circulation[i] += circulation;
            rates.jump[i] += jump;
            rates.delayed[i] += circulation * self.lags.wake_at_once;
        }
        rates
    }

    /// Share of the lift of each strip that stays attached.
    pub(super) fn attached_shares<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        x: &[S],
    ) -> StripColumn<S, N> {
        let n = self.settings.strips;
        match self.settings.section.law.about().attachment {
            Attachment::Whole => [S::ONE; N],
            Attachment::AtOnce => {
                let mut shares = [S::ONE; N];
                for i in 0..lanes::<S, N>(self.settings.strips) {
                    let state = |k: usize| x[k * n + i.min(n - 1)];
                    shares[i] = self.attached(&self.polar, strips.along[i], strips.wash[i], state);
                }
                shares
            }
            Attachment::Lagging { state, .. } => {
                let mut shares = self.law_column(x, state);
                for i in 0..lanes::<S, N>(self.settings.strips) {
                    shares[i] = S::ONE - shares[i];
                }
                shares
            }
        }
    }

    /// State `k` of the law on each strip, of `x` or its rates; zero beyond the last strip.
    pub(super) fn law_column<S: Scalar + Meets<P>, const N: usize>(
        &self,
        x: &[S],
        k: usize,
    ) -> StripColumn<S, N> {
        let n = self.settings.strips;
        let mut column = [S::ZERO; N];
        column[..n].copy_from_slice(&x[self.law_states() + k * n..][..n]);
        column
    }

    /// Share of the lift that stays attached at the chordwise speed `along`, the wash of motion
    /// `wash` and the wash lags `state(k)`, from the mean square of what the section meets now
    /// and has met: (w34^2 + sum gamma_k l_k^2) / 2. The two vanish together only at rest, so
    /// that a section broadside on does not count as attached while its lags change sign.
    ///
    /// Equation: aero.strip.attached_share
    /// `aero.attached_share at sin^2 a = q/(q + uc^2 + delta^2), q = (w34^2 + sum(gamma_k l_k^2))/2`
    /// Source: choice: what the section meets now and has met.
    /// Test: `a_strip_broadside_on_stays_separated_while_its_lags_change_sign`.
    #[inline]
    fn attached<Q: Scalar, G: Scalar, S: Over<G> + Meets<Q>>(
        &self,
        polar: &Polar<Q>,
        along: G,
        wash: G,
        state: impl Fn(usize) -> S,
    ) -> S {
        let weights = self.lags.circulation.iter().enumerate();
        let lagged2 = weights.fold(S::ZERO, |sum, (k, weight)| sum + state(k).squared() * *weight);
        let wash2 = (lagged2 + wash.squared()) * 0.5;
        let sine2 = wash2 / (wash2 + (along.squared() + self.floor * self.floor));
        polar.attached_share(sine2)
    }

    /// A0^-1 [K (D - Y) + R Y]: what is left on the chord of the wash of what the lags hold.
    /// K = (1 - A0) / d, so that A0^-1 K v = A0^-1 (v/d) - v/d.
    pub(super) fn held_left<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        sums: &LagSums<S, N>,
    ) -> StripColumn<S, N> {
        let n = self.settings.strips;
        let open: StripColumn<S, N> =
            column(n, |i| (sums.jump[i] - sums.delayed[i]) * self.tables.inverse_doublet[i]);
        let mut held = multiply(&flow.remainder, &sums.delayed, n);
        for i in 0..lanes::<S, N>(self.settings.strips) {
            held[i] += open[i];
        }
        let mut left = multiply(&flow.relief, &held, n);
        for i in 0..lanes::<S, N>(self.settings.strips) {
            left[i] -= open[i];
        }
        left
    }

    /// The impulse of the air on each strip, P: see [`carry_air`](Self::carry_air) for the part by the motion.
    fn impulse<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        held_left: &StripColumn<S, N>,
    ) -> StripColumn<S, N> {
        column(self.settings.strips, |i| held_left[i] * self.tables.mass[i] + flow.impulse[i])
    }

    /// P^' = F + (P - P^)/T: the followed impulse P^, driven by the force F of the impulse P whose influence
    /// coefficients are held, is drawn to P. Its rate is the force: over a cycle its mean vanishes, whatever F leaves out,
    /// and what F leaves out is left out faster than T only. Replaces impulse and force.
    ///
    /// Equation: aero.strip.followed_impulse
    /// `P^' = F + (P - P^)/T: F the force with the influence coefficients held, P the impulse itself, T = 10 ms`
    /// Source: Kirchhoff 1869: the force is minus the rate of the impulse; a complementary filter, T a choice.
    /// Test: `the_impulse_is_followed_and_its_rate_has_no_mean`.
    fn follow_impulse<S: Scalar, const N: usize>(
        &self,
        x: &[S],
        dx: &mut [S],
        impulse: &mut StripColumn<S, N>,
        force: &mut StripColumn<S, N>,
    ) {
        let (at, n) = (self.followed_states(), self.settings.strips);
        let (followed, rates) = (&x[at..], &mut dx[at..]);
        for i in 0..n.min(N) {
            rates[i] = force[i] + (impulse[i] - followed[i]) * (1.0 / FOLLOWING_TIME);
            (impulse[i], force[i]) = (followed[i], rates[i]);
        }
    }

    /// Sets the followed impulses to those of the air, as if the wing had moved on as it does.
    pub(super) fn settle_impulse<S: Scalar + Meets<P>, const N: usize>(
        &self,
        flow: &StripFlow<S, S, N>,
        x: &mut [S],
    ) {
        let attached = self.attached_shares(&flow.strips, x);
        let sums = self.lag_sums(&self.lagged(x), &attached);
        let impulse = self.impulse(flow, &self.held_left(flow, &sums));
        x[self.followed_states()..][..self.settings.strips]
            .iter_mut()
            .zip(impulse)
            .for_each(|(x, impulse)| *x = impulse);
    }

    /// Washes, state rates and impulses, which are shown to `then`, with the rates, where they lie.
    ///
    /// A0 w3 = K (d w12 + D - Y) + R Y; w = w34 + w3, both winds of motion raised by the
    /// wash of other surfaces; l_k' = e_k V/b (w - l_k); y_m' = V/tau_m (Gamma - y_m).
    ///
    /// Equation: aero.strip.wash
    /// `A0 w3 = K (d w12 + D - Y) + R Y, l_k' = e_k V/b (w - l_k), y_m' = V/tau_m (Gamma - y_m)`
    /// Source: own derivation; steady limit Weissinger 1947.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface_and_the_drag_of_their_wake`.
    #[inline(always)]
    pub(super) fn respond<
        'a,
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        T,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        foreign: Option<&Foreign<S, N>>,
        x: &'a [S],
        dx: &mut [S],
        camber: &'a mut Camber<'a, S, N>,
        spread: &mut impl Spread<S, N>,
        then: impl FnOnce(&StripResponse<'_, S, N>, &mut [S]) -> T,
    ) -> T {
        let lagged = self.lagged(x);
        let attached = self.attached_shares(&flow.strips, x);
        let sums = self.lag_sums(&lagged, &attached);
        let held_left = match spread.left(&sums) {
            Some(left) => left,
            None => self.held_left(flow, &sums),
        };
        let mut wash: StripColumn<S, N> = column(self.settings.strips, |i| {
            let of_motion = flow.strips.wash[i] + flow.half_left[i] - flow.strips.wash_half[i];
            held_left[i] + of_motion
        });
        if let Some(foreign) = foreign {
            // K d = 1 - A0 leaves A0^-1 of a wind that is the same along the chord.
            let left = multiply(&flow.relief, &foreign.at_control, self.settings.strips);
            for i in 0..lanes::<S, N>(self.settings.strips) {
                wash[i] += left[i];
            }
        }
        let mut airs = SectionAirs::new();
        let skin = self.skin(flow, &mut airs, x);
        if let Some(skin) = &skin {
            self.wash_of_slope(skin, &mut wash);
        }
        let flaps = self.flaps(flow, x);
        if let Some(flaps) = &flaps {
            self.wash_of_flaps(flow, flaps, &mut wash);
        }
        let mut lift_wash = self.advance_lags(flow, &wash, &sums.circulation, x, dx);
        if skin.is_some() || flaps.is_some() {
            camber.open(lanes::<S, N>(self.settings.strips));
        }
        if let Some(flaps) = &flaps {
            self.turn_flaps((flow, flaps), [&attached, &lift_wash], x, dx, camber);
        }
        let bulging = skin.map(|skin| {
            let Camber { of_chord, couple, flat, nose, followed, slope, given, .. } = &mut *camber;
            *of_chord = self.cambers(x);
            let washes = [&mut wash, &mut lift_wash, &mut flat[..], &mut nose[..], &mut couple[..]];
            let moving = [followed, slope].map(|of| of.each_mut().map(|column| &mut column[..]));
            let power = self.bulge(&skin, &attached, washes, (moving, given.is_some()), x, dx);
            *given = given.map(|_| power);
        });
        let camber = (bulging.is_some() || flaps.is_some()).then_some(&*camber);
        // What the slope of a camber adds is borne by it, not by the leading edge.
        let flat = camber.map_or(&lift_wash[..], |camber| &camber.flat);
        let turning_wash = self.turning_wash(flow, foreign, &sums, flat, spread);
        let law = self.settings.section.law.about();
        // The leading edge meets the flat chord's wash less what its own slope takes.
        let lags = matches!(law.attachment, Attachment::Lagging { .. });
        let edge_washes = camber.filter(|_| law.edge_vortex || lags).map(|camber| {
            let less = |of: &[S]| {
                let mut column = [S::ZERO; N];
                let left = of.iter().zip(&camber.nose).map(|(wash, nose)| *wash - *nose);
                column.iter_mut().zip(left).for_each(|(column, left)| *column = left);
                column
            };
            [less(&camber.flat), less(&turning_wash)]
        });
        let [edge_wash, edge_turning] =
            edge_washes.as_ref().map_or([&lift_wash, &turning_wash], |[wash, turning]| [wash, turning]);
        if let Attachment::Lagging { state, chords } = law.attachment {
            self.advance_separation(&flow.strips, edge_wash, (state, chords), x, dx, spread);
        }
        let edges = law.edge_vortex.then(|| {
            let mut edges = LeadingEdges { held: [S::ONE; N], vortex: [S::ZERO; N] };
            self.advance_edges(&flow.strips, [edge_wash, edge_turning], x, dx, &mut edges);
            edges
        });
        let (mut impulse, mut impulse_rate): (StripColumn<S, N>, StripColumn<S, N>);
        if self.settings.section.added_mass {
            let rates = self.lag_sum_rates(flow, &lagged, &attached, x, dx);
            let held_rate_left = match spread.left(&rates) {
                Some(left) => left,
                None => self.held_left(flow, &rates),
            };
            impulse = self.impulse(flow, &held_left);
            impulse_rate = column(self.settings.strips, |i| {
                held_rate_left[i] * self.tables.mass[i] + flow.impulse_rate[i]
            });
            if let Some(camber) = camber {
                self.push_back(flow, camber, [&mut impulse, &mut impulse_rate]);
            }
            if self.follows() {
                self.follow_impulse(x, dx, &mut impulse, &mut impulse_rate);
            }
        } else {
            (impulse, impulse_rate) = ([S::ZERO; N], [S::ZERO; N]);
        }
        if let (Some(camber), Some(_)) = (camber, &flaps) {
            for i in 0..self.settings.strips {
                impulse[i] += camber.slope[0][i];
                impulse_rate[i] += camber.slope[1][i];
            }
        }
        let mut beside;
        if self.pulls_at_tips() {
            beside = column(self.settings.strips, |i| self.bound(i, lift_wash[i], attached[i]));
            spread.beside(&mut beside);
        } else {
            beside = [S::ZERO; N];
        }
        let response = StripResponse {
            turning_wash: &turning_wash,
            edges: edges.as_ref(),
            camber,
            beside: &beside,
            circulation: &sums.circulation,
            attached: &attached,
            wash: &wash,
            lift_wash: &lift_wash,
            impulse: &impulse,
            impulse_rate: &impulse_rate,
        };
        then(&response, dx)
    }

    /// One over the share to which the delays of the wakes shrink as the wing folds. Far behind, what is left of a wake acts by its
    /// area alone: rows of vortices shed at s leave the wash G B.n / (4 pi s^2) for each length of it, B the vector between
    /// its edges. So the span b by which a wake is near or far is the distance between the tips, as they lie now, and the law
    /// tau ~ (b/c)^p of the flat wings holds with it. Beside the mean chord c the distance is nothing, where the tips meet.
    /// So with five lags; the one delay of three lags is that of the near wake, and no power of the distance made their fit better.
    ///
    /// Equation: aero.strip.wake_delay
    /// `tau = t c (b/c)^p ((B^2 + c^2)/(B_0^2 + c^2))^(p/2), B between the tips' quarter chords, B_0 on the flat wing`
    /// Source: far field of a vortex sheet: Saffman 1992, section 3.2; c^2 a choice.
    /// Test: `the_wake_of_a_folded_wing_comes_sooner`.
    pub(super) fn sooner<K: Scalar + Meets<P>, S: Over<K>, const N: usize>(
        &self,
        wakes: &Wakes<K, S, N>,
    ) -> K {
        if self.lags.folding == 0.0 {
            return K::ONE;
        }
        let between = wakes.edge(0).bound - wakes.edge(self.settings.strips).bound;
        let reach = between.norm_squared() + self.tables.chord_square;
        (reach * self.tables.inverse_reach).powf(-0.5 * self.lags.folding)
    }

    /// Rates of the lags; returns the lift wash w/2 + sum psi_k l_k.
    fn advance_lags<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        wash: &StripColumn<S, N>,
        circulation: &StripColumn<S, N>,
        x: &[S],
        dx: &mut [S],
    ) -> StripColumn<S, N> {
        let (n, lags) = (self.settings.strips, self.lags);
        let speed = &flow.strips.speed;
        let mut lift_wash: StripColumn<S, N> = column(n, |i| wash[i] * self.tables.at_once);
        for (k, block) in x.chunks_exact(n).enumerate() {
            let rates = &mut dx[k * n..][..n];
            if let Some(LagNumbers { weight, rate }) = self.tables.lags.get(k) {
                for i in 0..n.min(N) {
                    lift_wash[i] += block[i] * *weight;
                    rates[i] = (wash[i] - block[i]) * (speed[i] * (*rate * self.tables.turnover[i]));
                }
            } else if let Some(inverse) = self.tables.inverse_wake_length.get(k - lags.rate.len()) {
                let inverse = flow.sooner * *inverse;
                for i in 0..n.min(N) {
                    rates[i] = (circulation[i] - block[i]) * (speed[i] * inverse);
                }
            }
        }
        lift_wash
    }

    /// Rates of the leading edges' vortices, and what the `edges` do, which are written for all strips. The linear suction over rho c dy / 2 is
    /// a0 cos L [lw W - b q lw + (b q/2)^2], the wash at the edge lw - b q/2; in reversed flow there is none.
    ///
    /// Equation: aero.strip.edge_suction
    /// `c_s V^2 = a0 cos L [lw W - b q lw + (b q/2)^2], incidence of s_0 by lw`
    /// Source: Garrick 1936 with the wash that turns the force; own derivation.
    /// Test: `law_lev_turns_the_suction_that_the_edge_cannot_hold_into_normal_force`.
    fn advance_edges<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        [lift_wash, turning_wash]: [&StripColumn<S, N>; 2],
        x: &[S],
        dx: &mut [S],
        edges: &mut LeadingEdges<S, N>,
    ) {
        let (n, at, delta2) = (self.settings.strips, self.law_states(), self.floor * self.floor);
        edges.vortex[..n].copy_from_slice(&x[at..][..n]);
        for i in 0..n {
            let (along, speed, lw) = (strips.along[i], strips.speed[i], lift_wash[i]);
            let turn = if self.settings.section.pitch_suction {
                strips.pitch[i] * (self.tables.chord[i] * 0.25)
            } else {
                G::ZERO
            };
            let wind2 = lw.squared() + (along.squared() + delta2);
            let forward = suction_share(wind2.sqrt().recip() * along);
            let square = lw * (turning_wash[i] - turn * 2.0) + turn.squared();
            let suction = square * forward * self.tables.edge_slope[i];
            let edge = lev::edge(&self.polar, suction, lw - turn, speed.squared(), self.floor);
            edges.held[i] = edge.held;
            let rate = speed * (self.tables.turnover[i] * 0.5);
            dx[at + i] = lev::vortex_rate(edges.vortex[i], edge.lost, rate);
        }
    }

    /// Rates of the separated shares, the `state` of the law that follows in so many `chords` of travel the incidence
    /// of the lift wash.
    fn advance_separation<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        strips: &Strips<K, G, N>,
        lift_wash: &StripColumn<S, N>,
        (state, chords): (usize, f64),
        x: &[S],
        dx: &mut [S],
        spread: &mut impl Spread<S, N>,
    ) {
        let (n, delta2) = (self.settings.strips, self.floor * self.floor);
        let at = self.law_states() + state * n;
        let mut sines = column(n, |i| {
            let lw2 = lift_wash[i].squared();
            lw2 / (lw2 + (strips.along[i].squared() + delta2))
        });
        let rate = |i: usize, separated: S, sine2: S| {
            let chords_per_second = strips.speed[i] * (self.tables.turnover[i] * 0.5);
            Polar::<P>::separation_rate(
                separated,
                self.polar.separated_share(sine2),
                chords_per_second,
                chords,
            )
        };
        spread.sines(&mut sines);
        self.tables.reach.spread(&mut sines[..n]);
        spread.spread_sines(&sines, |i, sine2| rate(i, S::ZERO, sine2));
        for i in 0..n {
            dx[at + i] = rate(i, x[at + i], sines[i]);
        }
    }

    /// W = lw + (T - R)(2/3 Y + 1/3 Gamma): the wash that turns the force takes the trailing
    /// vortices at the bound vortex, half of their wash far behind (Munk), in place
    /// of 3/4 chord; so does what other surfaces wash there.
    ///
    /// Equation: aero.strip.turning_wash
    /// `W = lw + (T - R)(2/3 Y + 1/3 Gamma)`
    /// Source: Munk 1921; weights 2/3, 1/3 a choice.
    /// Test: `rectangles_have_the_slope_of_the_lifting_surface_and_the_drag_of_their_wake`.
    fn turning_wash<
        K: Scalar + Meets<P>,
        G: Over<K> + Meets<P>,
        S: Over<G> + Over<K> + Meets<P>,
        const N: usize,
    >(
        &self,
        flow: &StripFlow<K, G, N>,
        foreign: Option<&Foreign<S, N>>,
        sums: &LagSums<S, N>,
        lift_wash: &[S],
        spread: &mut impl Spread<S, N>,
    ) -> StripColumn<S, N> {
        let n = self.settings.strips;
        let seen: StripColumn<S, N> =
            column(n, |i| sums.delayed[i] * (2.0 / 3.0) + sums.circulation[i] * (1.0 / 3.0));
        let turn = |far: &StripColumn<S, N>, near: &StripColumn<S, N>| -> StripColumn<S, N> {
            column(n, |i| lift_wash[i] + (far[i] - near[i]))
        };
        let mut wash = match spread.turned(&seen) {
            Some([far, near]) => turn(&far, &near),
            None => turn(&multiply(&flow.far, &seen, n), &multiply(&flow.remainder, &seen, n)),
        };
        if let Some(foreign) = foreign {
            for i in 0..lanes::<S, N>(self.settings.strips) {
                wash[i] += foreign.at_bound[i] - foreign.at_control[i];
            }
        }
        wash
    }
}
