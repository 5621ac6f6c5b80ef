//! Derivatives of rates and loads by all states of the strips at once. What the lags hold acts on its own strip, and on all others by a few
//! washes alone, so that one pass carries the derivatives by the states of each strip and by those washes side by side, whatever the number
//! of strips; the washes follow by products of the matrices at hand.

use super::influence::{Matrix, StripColumn, dot, multiply};
use super::membrane::Camber;
use super::response::{LagSums, Lagged, Spread, StripResponse};
use super::settings::SpanForce;
use super::{Room, StripFlow, StripModel};
use crate::law::Attachment;
use crate::{Coupling, Sections, Wrench};
use arrayvec::ArrayVec;
use wingbeat_math::{Dual, Scalar, Vec3, append_copies, kept};
use wingbeat_ocp::plant::MAX_DEGREES;

/// Most derivatives that the pass carries: by the states of a strip, five at most, and by three washes. *Choice*: two registers of AVX2.
const LANES: usize = 8;
/// The washes: what is left on the chord, what the wakes turn, and the rate of the first.
const WASHES: usize = 3;
/// Lanes of columns, and most strips for which this is done.
const WIDE: usize = 16;
/// Most states, those that are given too, of which there are as many.
const MOST: usize = 2 * WIDE * (LANES - WASHES);

/// Most pairs of strips of which one acts on the other: those side by side, and three beside each tip.
const MOST_PUSHES: usize = 2 * WIDE + 6;

type Local = Dual<LANES>;
/// Derivatives of a number on each strip by one lane.
type StripSlopes = StripColumn<f64, WIDE>;

/// Derivatives by all states of a surface.
#[derive(Clone, Debug, Default)]
pub struct ByStates {
    /// Number n of states.
    pub states: usize,
    /// Of the rates of the states, n x n, row-major, in the unit of the row over that of the column, per s.
    pub rates: Vec<f64>,
    /// Of the force (N) and the moment (N m) about the body origin, in B, then of the forces on coordinates (in N m over their unit), a
    /// row of n for each, over the unit of the column.
    pub loads: Vec<f64>,
    /// What the force (N) and the moment (N m) of each strip about the body origin, in B, weigh in the force on each coordinate: one
    /// coordinate after another, given by the caller.
    pub weights: Vec<[f64; 6]>,
}

/// A load without its derivatives.
pub(crate) fn without_slopes<const N: usize>(load: &Wrench<Dual<N>>) -> Wrench<f64> {
    Wrench { force: load.force.each(|f| f.re), moment: load.moment.each(|m| m.re) }
}

/// What the load of strip `i` of `n` weighs in row `r` of the loads.
#[inline(always)]
pub(crate) fn row<S: Scalar>(r: usize, i: usize, weights: &[[f64; 6]], n: usize, load: &Wrench<S>) -> S {
    let ([a, b, c], [d, e, f]) = (load.force.0, load.moment.0);
    let parts = [a, b, c, d, e, f];
    match r.checked_sub(6) {
        None => parts[r],
        Some(coordinate) => {
            let weights = &weights[coordinate * n + i];
            let mut sum = S::ZERO;
            for k in 0..6 {
                sum += parts[k] * weights[k];
            }
            sum
        }
    }
}

/// What spreads over the strips, found in plain numbers; derivatives begin anew from it.
struct Cut<'a> {
    model: &'a StripModel,
    flow: &'a StripFlow<f64, f64, WIDE>,
    /// The first lane of the washes, and how many have been found.
    first: usize,
    found: usize,
    of: &'a mut CutColumns,
    /// What the rate of the separated share adds to the rates of what [`CutColumns::delayed`] and [`CutColumns::open`] hold, over it.
    of_separation: [StripColumn<f64, WIDE>; 2],
}

/// What is noted of the strips. A thread keeps it; what a model does not note, it does not read.
struct CutColumns {
    /// What the washes were found of.
    delayed: [StripColumn<Local, WIDE>; 2],
    open: [StripColumn<Local, WIDE>; 2],
    seen: StripColumn<Local, WIDE>,
    /// The circulation of each strip that acts on those beside it.
    beside: StripColumn<Local, WIDE>,
    /// The squared sine of incidence of each strip before it spreads, and how the rate of the separated share goes with it once it is
    /// spread, 1/s.
    sines: StripColumn<Local, WIDE>,
    following: StripColumn<f64, WIDE>,
}

impl CutColumns {
    const ZERO: Self = {
        let zero = [Local::ZERO; WIDE];
        Self {
            delayed: [zero; 2],
            open: [zero; 2],
            seen: zero,
            beside: zero,
            sines: zero,
            following: [0.0; WIDE],
        }
    };
}

impl Cut<'_> {
    fn fresh(&mut self, lane: usize, values: &StripColumn<f64, WIDE>) -> StripColumn<Local, WIDE> {
        let mut column = [Local::ZERO; WIDE];
        for i in 0..self.model.strips() {
            column[i] = Local::variable(values[i], self.first + lane);
        }
        column
    }
}

impl Spread<Local, WIDE> for Cut<'_> {
    fn left(&mut self, sums: &LagSums<Local, WIDE>) -> Option<StripColumn<Local, WIDE>> {
        let values = |of: &StripColumn<Local, WIDE>| of.map(|value| value.re);
        let plain = LagSums {
            circulation: values(&sums.circulation),
            jump: values(&sums.jump),
            delayed: values(&sums.delayed),
        };
        let left = self.model.held_left(self.flow, &plain);
        let (turn, lane) = (self.found, [0, 2][self.found]);
        self.found += 1;
        self.of.delayed[turn] = sums.delayed;
        for i in 0..self.model.strips() {
            self.of.open[turn][i] = (sums.jump[i] - sums.delayed[i]) * self.model.tables.inverse_doublet[i];
        }
        Some(self.fresh(lane, &left))
    }
    fn turned(&mut self, seen: &StripColumn<Local, WIDE>) -> Option<[StripColumn<Local, WIDE>; 2]> {
        self.of.seen = *seen;
        let (values, n) = (seen.map(|value| value.re), self.model.strips());
        let (far, near) = (multiply(&self.flow.far, &values, n), multiply(&self.flow.remainder, &values, n));
        Some([self.fresh(1, &far), near.map(Local::constant)])
    }
    fn beside(&mut self, bound: &mut StripColumn<Local, WIDE>) {
        self.of.beside = *bound;
        for value in bound {
            *value = Local::constant(value.re);
        }
    }
    fn sines(&mut self, sines: &mut StripColumn<Local, WIDE>) {
        self.of.sines = *sines;
        for sine2 in sines {
            *sine2 = Local::constant(sine2.re);
        }
    }
    fn spread_sines(&mut self, sines: &StripColumn<Local, WIDE>, rate: impl Fn(usize, Local) -> Local) {
        for i in 0..self.model.strips() {
            self.of.following[i] = rate(i, Local::variable(sines[i].re, 0)).eps[0];
        }
    }
}

/// Derivatives of a number on each strip by the washes there.
struct ByWashes {
    slopes: [StripSlopes; WASHES],
}

impl ByWashes {
    fn of(first: usize, n: usize, value: impl Fn(usize) -> Local) -> Self {
        let mut slopes = [[0.0; WIDE]; WASHES];
        for i in 0..n {
            let value = value(i);
            for k in 0..WASHES {
                slopes[k][i] = value.eps[first + k];
            }
        }
        Self { slopes }
    }
    /// The derivatives along a direction in which the washes change so.
    #[inline(always)]
    fn along(&self, washes: &[StripSlopes; WASHES]) -> StripSlopes {
        let ([a, b, c], [x, y, z]) = (&self.slopes, washes);
        let mut sum = [0.0; WIDE];
        for i in 0..WIDE {
            sum[i] = a[i].mul_add(x[i], b[i].mul_add(y[i], c[i] * z[i]));
        }
        sum
    }
    /// The sum of the same over all strips.
    #[inline(always)]
    fn sum_along(&self, washes: &[StripSlopes; WASHES]) -> f64 {
        let of = |k: usize| dot(&self.slopes[k], &washes[k], WIDE);
        (of(0) + of(1)) + of(2)
    }
}

impl StripModel {
    /// Whether [`by_states`](Self::by_states) takes this model: a membrane that is not given spreads over the strips too, and a flap has
    /// states of its own.
    pub(crate) fn knows_by_states(&self) -> bool {
        let n = self.settings.strips;
        n <= WIDE
            && (self.membrane.is_none() || self.given() > 0)
            && self.hinges.is_none()
            && self.states() - self.given() + WASHES * n <= LANES * n
    }

    /// As an evaluation of one surface alone, with the derivatives by all of its states.
    ///
    /// Equation: aero.strip.by_states
    /// `h = A0^-1 (R Y + o) - o, t = (T - R) s: df_i/dx_j = df_i/dx_i [i = j] + df_i/dh_i dh_i/dx_j + df_i/dt_i dt_i/dx_j`
    /// Source: chain rule.
    /// Test: `what_has_no_derivative_is_left_out_and_nothing_else`.
    pub(crate) fn by_states(
        &self,
        sections: &dyn Sections<f64>,
        wind: Vec3,
        x: &[f64],
        dx: &mut [f64],
        coupling: Coupling<'_, f64, f64>,
        out: &mut ByStates,
    ) -> (Wrench<f64>, [[f64; 6]; 6]) {
        kept(
            || Box::new(Room::<f64, f64, WIDE>::NEW),
            |room| {
                self.flow(sections, wind, room);
                if let Some(mass) = coupling.mass {
                    self.couple(&room.flow, sections, mass);
                }
                if let (Some(rates), true) = (coupling.impulses, self.follows()) {
                    self.follow(&room.flow, sections, rates);
                }
                let load = kept(
                    || Box::new((CutColumns::ZERO, [Wrench::ZERO; WIDE])),
                    |cut| self.differentiate(&room.flow, x, (dx, coupling.strips), cut, out),
                );
                (load, room.flow.added_mass)
            },
        )
    }

    /// Rates, loads and their derivatives in the air that `flow` tells.
    fn differentiate(
        &self,
        flow: &StripFlow<f64, f64, WIDE>,
        x: &[f64],
        (dx, by_strip): (&mut [f64], &mut [Wrench<f64>]),
        (of, strips): &mut (CutColumns, [Wrench<Local>; WIDE]),
        out: &mut ByStates,
    ) -> Wrench<f64> {
        let (n, all) = (self.settings.strips, self.states());
        let states = all - self.given();
        let first = states / n;
        let mut seeded = ArrayVec::<Local, MOST>::new();
        for (s, value) in x[..states].iter().enumerate() {
            seeded.push(Local::variable(*value, s / n));
        }
        seeded.extend(x[states..all].iter().map(|value| Local::constant(*value)));
        let mut rates = ArrayVec::<Local, MOST>::new();
        append_copies(&mut rates, Local::ZERO, all);
        let of_separation = self.of_separation(&x[..states]);
        let mut cut = Cut { model: self, flow, first, found: 0, of, of_separation };
        let mut camber = Camber::none();
        let load = |response: &StripResponse<'_, Local, WIDE>, _: &mut [Local]| {
            self.load_strips(flow, response, None, Some(&mut strips[..n]))
        };
        let total = self.respond(flow, None, &seeded, &mut rates, &mut camber, &mut cut, load);
        for (dx, rate) in dx.iter_mut().zip(&rates) {
            *dx = rate.re;
        }
        out.states = states;
        out.rates.resize(states * states, 0.0);
        self.assemble(&cut, &rates, strips, out);
        for (load, strip) in by_strip.iter_mut().zip(&strips[..n]) {
            *load = without_slopes(strip);
        }
        without_slopes(&total)
    }

    /// What a rate of one of the separated share adds to the rates of the circulation that is seen and of what is left open.
    fn of_separation(&self, x: &[f64]) -> [StripColumn<f64, WIDE>; 2] {
        let still = Lagged { delayed: [0.0; WIDE], ..self.lagged(x) };
        let LagSums { jump, delayed, .. } = self.lag_sums(&still, &[-1.0; WIDE]);
        let mut open = [0.0; WIDE];
        for i in 0..self.settings.strips {
            open[i] = (jump[i] - delayed[i]) * self.tables.inverse_doublet[i];
        }
        [delayed, open]
    }

    /// Where edges bear a force: a strip that bears a load, another whose circulation times density does it, and force, m2/s,
    /// and moment, m3/s, over that.
    fn pushes(&self, cut: &Cut<'_>) -> ArrayVec<(usize, usize, Wrench<f64>), MOST_PUSHES> {
        let (n, strips) = (self.settings.strips, &cut.flow.strips);
        let mut pushes = ArrayVec::new();
        let drifting = if self.span_force == SpanForce::Edges { n } else { 0 };
        for i in 0..drifting {
            let [left, right] = self.edge_weights(i);
            for (k, weight) in [(i.wrapping_sub(1), left), (i + 1, right)].into_iter().filter(|(k, _)| *k < n)
            {
                pushes.push((i, k, strips.wrench(i, self.spread(i, weight * strips.drift[i]))));
            }
        }
        for (i, k, force) in self.by_others(|k| cut.of.beside[k].re) {
            pushes.push((i, k, strips.wrench(i, force)));
        }
        pushes
    }

    /// Puts the derivatives together.
    fn assemble(&self, cut: &Cut<'_>, rates: &[Local], strips: &[Wrench<Local>; WIDE], out: &mut ByStates) {
        let (n, states, first) = (self.settings.strips, out.states, cut.first);
        let StripFlow { relief, remainder, far, .. } = cut.flow;
        let mut of_delayed: Matrix<f64, WIDE> = [[0.0; WIDE]; WIDE];
        for j in 0..n {
            of_delayed[j] = multiply(relief, &remainder[j], n);
        }
        let by = |value: &dyn Fn(usize) -> Local| ByWashes::of(first, n, value);
        let [delayed, open] = [by(&|i| cut.of.delayed[1][i]), by(&|i| cut.of.open[1][i])];
        let mut loads = ArrayVec::<[Local; WIDE], MAX_DEGREES>::new();
        let pushes = self.pushes(cut);
        for r in 0..6 + out.weights.len() / n {
            loads.push([Local::ZERO; WIDE]);
            for i in 0..n {
                loads[r][i] = row(r, i, &out.weights[..], n, &strips[i]);
            }
            // What a strip does to the loads of those beside it counts as its own: only sums are wanted.
            for (i, k, push) in &pushes {
                loads[r][*k] += cut.of.beside[*k] * row(r, *i, &out.weights[..], n, push);
            }
        }
        let mut of_loads = ArrayVec::<ByWashes, MAX_DEGREES>::new();
        for of in &loads {
            of_loads.push(by(&|i| of[i]));
        }
        out.loads.resize(loads.len() * states, 0.0);
        let mut of_rates = ArrayVec::<ByWashes, LANES>::new();
        for block in 0..first {
            of_rates.push(by(&|i| rates[block * n + i]));
        }
        let of_sines = by(&|i| cut.of.sines[i]);
        let separated = match self.settings.section.law.about().attachment {
            Attachment::Lagging { state, .. } => Some(self.law_states() / n + state),
            Attachment::Whole | Attachment::AtOnce => None,
        };
        for s in 0..states {
            let (block, j) = (s / n, s % n);
            let [d, o] = [&cut.of.delayed[0], &cut.of.open[0]].map(|of| of[j].eps[block]);
            let seen = cut.of.seen[j].eps[block];
            let mut washes = [[0.0; WIDE]; WASHES];
            for i in 0..WIDE {
                washes[0][i] = of_delayed[j][i].mul_add(d, relief[j][i] * o);
                washes[1][i] = (far[j][i] - remainder[j][i]) * seen;
            }
            washes[0][j] -= o;
            // What the incidence of strips beside does to the rate of the separated share.
            let mut pulled = [0.0; WIDE];
            if separated.is_some() {
                let mut sines = of_sines.along(&washes);
                sines[j] += cut.of.sines[j].eps[block];
                self.tables.reach.spread(&mut sines[..n]);
                for i in 0..n {
                    pulled[i] = sines[i] * cut.of.following[i];
                }
            }
            if cut.found == 2 {
                let [mut d, mut o] = [delayed.along(&washes), open.along(&washes)];
                d[j] += cut.of.delayed[1][j].eps[block];
                o[j] += cut.of.open[1][j].eps[block];
                let [of_d, of_o] = &cut.of_separation;
                for i in 0..WIDE {
                    d[i] = of_d[i].mul_add(pulled[i], d[i]);
                    o[i] = of_o[i].mul_add(pulled[i], o[i]);
                }
                let (of_d, of_o) = (multiply(&of_delayed, &d, n), multiply(relief, &o, n));
                for i in 0..WIDE {
                    washes[2][i] = of_d[i] + (of_o[i] - o[i]);
                }
            }
            for (k, of_rates) in of_rates.iter().enumerate() {
                let mut column = of_rates.along(&washes);
                column[j] += rates[k * n + j].eps[block];
                if separated == Some(k) {
                    (0..n).for_each(|i| column[i] += pulled[i]);
                }
                let rows = out.rates[k * n * states + s..].iter_mut().step_by(states);
                rows.zip(&column[..n]).for_each(|(rate, value)| *rate = *value);
            }
            for (r, of_loads) in of_loads.iter().enumerate() {
                out.loads[r * states + s] = of_loads.sum_along(&washes) + loads[r][j].eps[block];
            }
        }
    }
}
