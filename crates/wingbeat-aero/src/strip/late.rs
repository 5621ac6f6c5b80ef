//! Derivatives of rates and loads by all states of the strips at once. What the lags hold acts on its own strip, and on all others by a few
//! washes alone, so that one pass carries the derivatives by the states of each strip and by those washes side by side, whatever the number
//! of strips; the washes follow by products of the matrices at hand. On a membrane so do the rates of its heights, by the derivatives of the
//! membrane alone, and its states take further passes.

use super::influence::{Matrix, StripColumn, multiply, sum};
use super::membrane::{Camber, Membrane, MembraneLoads, Shapes};
use super::response::{LagSums, Spread};
use super::{Room, StripFlow, StripModel};
use crate::{Coupling, MAX_STRIPS, Sections, Wrench};
use arrayvec::ArrayVec;
use std::ops::Range;
use wingbeat_math::{Dual, Scalar, Vec3, append_copies, kept};

/// Most derivatives that a pass carries: by the states of a strip and by washes. *Choice*: two registers of AVX2.
const LANES: usize = 8;
/// The same on a membrane, whose strips have more states. *Choice*: three registers.
const MORE_LANES: usize = 12;
/// The washes: what is left on the chord, what the wakes turn, and the rate of the first.
const WASHES: usize = 3;
/// The same on a membrane, where the rates of its two shapes follow.
const WITH_RATES: usize = WASHES + 2;
/// Lanes of columns, and most strips for which this is done.
const WIDE: usize = 16;
/// Most states of a strip.
const BLOCKS: usize = 12;
/// Most states.
const MOST: usize = WIDE * BLOCKS;

/// Derivatives of a number on each strip by one lane.
type StripSlopes = StripColumn<f64, WIDE>;
/// Derivatives of the rates of both shapes on each strip by something on one strip.
type BaySlopes = [StripSlopes; 2];

/// Derivatives by all states of a surface.
#[derive(Clone, Debug, Default)]
pub struct ByStates {
    /// Number n of states.
    pub states: usize,
    /// Of the rates of the states, n x n, row-major, in the unit of the row over that of the column, per s.
    pub rates: Vec<f64>,
    /// Of the force (N) and the moment (N m) about the body origin, in B, 6 x n, row-major, over the unit of the column.
    pub loads: Vec<f64>,
    /// Of the rates of a membrane's heights by the loads on its shapes, then by the heights over the chord.
    of_heights: Vec<BaySlopes>,
}

/// What spreads over the strips, found in plain numbers; derivatives begin anew from it.
struct Cut<'a, const L: usize> {
    model: &'a StripModel,
    flow: &'a StripFlow<f64, f64, WIDE>,
    /// The first lane of the washes, and how many have been found.
    first: usize,
    found: usize,
    /// What the washes were found of.
    delayed: [StripColumn<Dual<L>, WIDE>; 2],
    open: [StripColumn<Dual<L>, WIDE>; 2],
    seen: StripColumn<Dual<L>, WIDE>,
    /// The states of the strips.
    x: &'a [f64],
    /// Of a membrane what its heights were found of: loads less what resists the rates as they are.
    pressed: Option<[StripColumn<Dual<L>, WIDE>; 2]>,
    /// See [`ByStates`].
    of_heights: &'a mut Vec<BaySlopes>,
}

impl<const L: usize> Cut<'_, L> {
    fn fresh(&mut self, lane: usize, values: &StripColumn<f64, WIDE>) -> StripColumn<Dual<L>, WIDE> {
        let mut column = [Dual::ZERO; WIDE];
        for i in 0..self.model.strips() {
            column[i] = Dual::variable(values[i], self.first + lane);
        }
        column
    }
}

impl<const L: usize> Spread<Dual<L>, WIDE> for Cut<'_, L> {
    fn left(&mut self, sums: &LagSums<Dual<L>, WIDE>) -> Option<StripColumn<Dual<L>, WIDE>> {
        let values = |of: &StripColumn<Dual<L>, WIDE>| of.map(|value| value.re);
        let plain = LagSums {
            circulation: values(&sums.circulation),
            jump: values(&sums.jump),
            delayed: values(&sums.delayed),
        };
        let left = self.model.held_left(self.flow, &plain);
        let (turn, lane) = (self.found, [0, 2][self.found]);
        self.found += 1;
        self.delayed[turn] = sums.delayed;
        for i in 0..self.model.strips() {
            self.open[turn][i] = (sums.jump[i] - sums.delayed[i]) * self.model.tables.inverse_doublet[i];
        }
        Some(self.fresh(lane, &left))
    }
    fn turned(&mut self, seen: &StripColumn<Dual<L>, WIDE>) -> Option<[StripColumn<Dual<L>, WIDE>; 2]> {
        self.seen = *seen;
        let (values, n) = (seen.map(|value| value.re), self.model.strips());
        let (far, near) = (multiply(&self.flow.far, &values, n), multiply(&self.flow.remainder, &values, n));
        Some([self.fresh(1, &far), near.map(Dual::constant)])
    }
    fn heights(&mut self, pressed: &mut MembraneLoads<Dual<L>>) -> bool {
        let (n, Some(membrane)) = (self.model.strips(), self.model.membrane.as_ref()) else { return false };
        let heights = self.model.cambers(self.x);
        if self.of_heights.is_empty() {
            slopes_of_heights(membrane, heights, pressed, self.of_heights);
        }
        let plain = |of: &ArrayVec<Dual<L>, MAX_STRIPS>| of.iter().map(|value| value.re).collect();
        let mut numbers = MembraneLoads {
            rates: pressed.rates.each_ref().map(plain),
            resistances: pressed.resistances.each_ref().map(plain),
            crossings: plain(&pressed.crossings),
        };
        membrane.give_way(heights, &mut numbers);
        let MembraneLoads { rates: [first, second], .. } = &numbers;
        let mut found = [[Dual::ZERO; WIDE]; 2];
        for i in 0..n {
            let [on_first, on_second] = pressed.rates.each_ref().map(|of| of[i]);
            let [resists, resists_second] = pressed.resistances.each_ref().map(|of| of[i]);
            found[0][i] = on_first - resists * first[i];
            found[1][i] = on_second + pressed.crossings[i] * first[i] - resists_second * second[i];
        }
        self.pressed = Some(found);
        for (mode, rates) in pressed.rates.iter_mut().enumerate() {
            for (rate, value) in rates.iter_mut().zip(&numbers.rates[mode]) {
                *rate = Dual::variable(*value, self.first + WASHES + mode);
            }
        }
        true
    }
}

/// Derivatives of the rates of a membrane's heights by the loads on both shapes and by both heights over the chord, `heights`, at what is
/// `pressed`, all else held: by each load, then by each height, a strip after another. Bays do not know each other: of each the strip at the same
/// place moves at once.
fn slopes_of_heights<const L: usize>(
    membrane: &Membrane<f64>,
    heights: Shapes<&[f64]>,
    pressed: &MembraneLoads<Dual<L>>,
    slopes: &mut Vec<BaySlopes>,
) {
    let (places, most) = (membrane.places(), membrane.largest_bay());
    slopes.resize(4 * places.len(), [[0.0; WIDE]; 2]);
    let number = |value: f64| Dual::<L>::constant(value);
    let held = |of: &[Dual<L>]| of.iter().map(|value| number(value.re)).collect::<ArrayVec<_, MAX_STRIPS>>();
    let heights =
        heights.map(|of| of.iter().map(|value| number(*value)).collect::<ArrayVec<_, MAX_STRIPS>>());
    let [on_first, on_second] = pressed.rates.each_ref().map(|of| held(of));
    let [first, second] = heights;
    let still = [on_first, on_second, first, second];
    for from in (0..4 * most).step_by(L) {
        let mut moved = still.clone();
        for direction in from..(from + L).min(4 * most) {
            let of_place = moved[direction / most].iter_mut().zip(places);
            let there = of_place.filter(|(_, place)| **place == direction % most);
            there.for_each(|(value, _)| value.eps[direction - from] = 1.0);
        }
        let [on_first, on_second, first, second] = moved;
        let mut pressed = MembraneLoads {
            rates: [on_first, on_second],
            resistances: pressed.resistances.each_ref().map(|of| held(of)),
            crossings: held(&pressed.crossings),
        };
        membrane.give_way([&first, &second], &mut pressed);
        for direction in from..(from + L).min(4 * most) {
            let (kind, place) = (direction / most, direction % most);
            for (i, own) in places.iter().enumerate() {
                // The strip at this place of the bay of strip `i`; one behind its end has moved nothing there.
                let mover = i - own + place;
                if places.get(mover) == Some(&place) {
                    for (mode, rates) in pressed.rates.iter().enumerate() {
                        slopes[kind * places.len() + mover][mode][i] = rates[i].eps[direction - from];
                    }
                }
            }
        }
    }
}

/// Derivatives of a number on each strip by the washes there, as many as act on it.
struct ByWashes<const W: usize> {
    slopes: [StripSlopes; W],
    acting: ArrayVec<usize, W>,
}

impl<const W: usize> ByWashes<W> {
    fn of<const L: usize>(first: usize, n: usize, value: impl Fn(usize) -> Dual<L>) -> Self {
        let mut slopes = [[0.0; WIDE]; W];
        for i in 0..n {
            let value = value(i);
            for k in 0..W {
                slopes[k][i] = value.eps[first + k];
            }
        }
        let acts = |k: &usize| slopes[*k].iter().any(|slope| *slope != 0.0);
        Self { acting: (0..W).filter(acts).collect(), slopes }
    }
    /// The derivatives along a direction in which the washes change so.
    #[inline(always)]
    fn along(&self, washes: &[StripSlopes; W]) -> StripSlopes {
        let mut sum = [0.0; WIDE];
        for &k in &self.acting {
            for i in 0..WIDE {
                sum[i] = self.slopes[k][i].mul_add(washes[k][i], sum[i]);
            }
        }
        sum
    }
}

impl StripModel {
    /// Whether [`by_states`](Self::by_states) takes this model: a flap has states of its own.
    pub(crate) fn knows_by_states(&self) -> bool {
        let (n, rigid) = (self.settings.strips, self.membrane.is_none());
        let most = if rigid { LANES - WASHES } else { BLOCKS };
        n <= WIDE && self.hinges.is_none() && self.states() <= most * n
    }

    /// As an evaluation of one surface alone, with the derivatives by all of its states.
    ///
    /// Equation: aero.strip.by_states
    /// `h = A0^-1 (R Y + o) - o, t = (T - R) s: df_i/dx_j = df_i/dx_i [i = j] + df_i/dh_i dh_i/dx_j + df_i/dt_i dt_i/dx_j; of a membrane
    /// likewise by r = h_1', h_2', dr = dr/dQ (dQ - dR r) + dr/dh dh`
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
                self.couple(&room.flow, sections, coupling.mass);
                if let (Some(rates), true) = (coupling.impulses, self.follows()) {
                    self.follow(&room.flow, sections, rates);
                }
                (self.differentiate(&room.flow, x, dx, out), room.flow.added_mass)
            },
        )
    }

    /// Rates, loads and their derivatives in the air that `flow` tells.
    fn differentiate(
        &self,
        flow: &StripFlow<f64, f64, WIDE>,
        x: &[f64],
        dx: &mut [f64],
        out: &mut ByStates,
    ) -> Wrench<f64> {
        let (n, states) = (self.settings.strips, self.states());
        out.states = states;
        out.rates.resize(states * states, 0.0);
        out.loads.resize(6 * states, 0.0);
        out.of_heights.clear();
        if self.membrane.is_none() {
            return self.pass::<WASHES, LANES>(flow, 0..states / n, x, dx, out);
        }
        let (blocks, mut load) = (states / n, Wrench::ZERO);
        for from in (0..blocks).step_by(MORE_LANES - WITH_RATES) {
            let to = blocks.min(from + MORE_LANES - WITH_RATES);
            load = self.pass::<WITH_RATES, MORE_LANES>(flow, from..to, x, dx, out);
        }
        load
    }

    /// The same with the derivatives by some of the `states` of each strip alone.
    fn pass<const W: usize, const L: usize>(
        &self,
        flow: &StripFlow<f64, f64, WIDE>,
        of: Range<usize>,
        x: &[f64],
        dx: &mut [f64],
        out: &mut ByStates,
    ) -> Wrench<f64> {
        let (n, states) = (self.settings.strips, self.states());
        let mut seeded = ArrayVec::<Dual<L>, MOST>::new();
        for (s, value) in x[..states].iter().enumerate() {
            seeded.push(if of.contains(&(s / n)) {
                Dual::variable(*value, s / n - of.start)
            } else {
                Dual::constant(*value)
            });
        }
        let mut rates = ArrayVec::<Dual<L>, MOST>::new();
        append_copies(&mut rates, Dual::ZERO, states);
        let mut strips = [Wrench::ZERO; WIDE];
        let zero = [Dual::ZERO; WIDE];
        let mut of_heights = std::mem::take(&mut out.of_heights);
        let mut cut = Cut {
            model: self,
            flow,
            first: of.len(),
            found: 0,
            delayed: [zero; 2],
            open: [zero; 2],
            seen: zero,
            x,
            pressed: None,
            of_heights: &mut of_heights,
        };
        let mut camber = Camber::none();
        let response = self.respond(flow, None, &seeded, &mut rates, &mut camber, &mut cut);
        let total = self.load_strips(flow, &response, None, Some(&mut strips[..n]));
        for (dx, rate) in dx.iter_mut().zip(&rates) {
            *dx = rate.re;
        }
        self.assemble::<W, L>(&cut, of.start, &rates, &strips, out);
        out.of_heights = of_heights;
        Wrench { force: total.force.each(|f| f.re), moment: total.moment.each(|m| m.re) }
    }

    /// Puts the derivatives together, by the states of each strip from the one at `from` on.
    fn assemble<const W: usize, const L: usize>(
        &self,
        cut: &Cut<'_, L>,
        from: usize,
        rates: &[Dual<L>],
        strips: &[Wrench<Dual<L>>; WIDE],
        out: &mut ByStates,
    ) {
        let (n, states, first) = (self.settings.strips, out.states, cut.first);
        let StripFlow { relief, remainder, far, .. } = cut.flow;
        let mut of_delayed: Matrix<f64, WIDE> = [[0.0; WIDE]; WIDE];
        for j in 0..n {
            of_delayed[j] = multiply(relief, &remainder[j], n);
        }
        let by = |value: &dyn Fn(usize) -> Dual<L>| ByWashes::<W>::of(first, n, value);
        let [delayed, open] = [by(&|i| cut.delayed[1][i]), by(&|i| cut.open[1][i])];
        let pressed = cut.pressed.as_ref().map(|of| of.each_ref().map(|of| by(&|i| of[i])));
        let load = |i: usize, r: usize| {
            let Wrench { force, moment } = &strips[i];
            if r < 3 { force[r] } else { moment[r - 3] }
        };
        let of_loads: [ByWashes<W>; 6] = std::array::from_fn(|r| by(&|i| load(i, r)));
        let of_rates: ArrayVec<ByWashes<W>, BLOCKS> =
            (0..states / n).map(|block| by(&|i| rates[block * n + i])).collect();
        for (block, j) in (0..first).flat_map(|block| (0..n).map(move |j| (block, j))) {
            let s = (from + block) * n + j;
            let [d, o] = [&cut.delayed[0], &cut.open[0]].map(|of| of[j].eps[block]);
            let seen = cut.seen[j].eps[block];
            let mut washes = [[0.0; WIDE]; W];
            for i in 0..WIDE {
                washes[0][i] = of_delayed[j][i].mul_add(d, relief[j][i] * o);
                washes[1][i] = (far[j][i] - remainder[j][i]) * seen;
            }
            washes[0][j] -= o;
            if let (Some(pressed), Some(by_pressed)) = (&cut.pressed, &pressed) {
                let mut along = by_pressed.each_ref().map(|of| of.along(&washes));
                (0..2).for_each(|mode| along[mode][j] += pressed[mode][j].eps[block]);
                let heights = self.heights_along(cut.of_heights, &along, s);
                washes[WASHES..].copy_from_slice(&heights);
            }
            if cut.found == 2 {
                let [mut d, mut o] = [delayed.along(&washes), open.along(&washes)];
                d[j] += cut.delayed[1][j].eps[block];
                o[j] += cut.open[1][j].eps[block];
                let (of_d, of_o) = (multiply(&of_delayed, &d, n), multiply(relief, &o, n));
                for i in 0..WIDE {
                    washes[2][i] = of_d[i] + (of_o[i] - o[i]);
                }
            }
            for (k, of_rates) in of_rates.iter().enumerate() {
                let mut column = of_rates.along(&washes);
                column[j] += rates[k * n + j].eps[block];
                let rows = out.rates[k * n * states + s..].iter_mut().step_by(states);
                rows.zip(&column[..n]).for_each(|(rate, value)| *rate = *value);
            }
            for (r, of_loads) in of_loads.iter().enumerate() {
                let column = of_loads.along(&washes);
                out.loads[r * states + s] = sum(&column) + load(j, r).eps[block];
            }
        }
    }

    /// How the rates of a membrane's heights change where the loads on its shapes change by `along` and the state `s` by one, by the slopes
    /// of [`slopes_of_heights`].
    fn heights_along(&self, slopes: &[BaySlopes], along: &[StripSlopes; 2], s: usize) -> BaySlopes {
        let (n, at, mut rates) = (self.settings.strips, self.camber_states(), [[0.0; WIDE]; 2]);
        let heights =
            s.checked_sub(at).filter(|height| *height < 2 * n).map(|height| (&1.0, &slopes[2 * n + height]));
        let shares = along.iter().flat_map(|along| &along[..n]).zip(slopes);
        for (share, of) in shares.filter(|(share, _)| **share != 0.0).chain(heights) {
            for (rates, slopes) in rates.iter_mut().zip(of) {
                *rates = added(rates, *share, slopes);
            }
        }
        rates
    }
}

/// A column with a share of another.
#[inline(always)]
fn added(column: &StripSlopes, share: f64, other: &StripSlopes) -> StripSlopes {
    let mut sum = *column;
    for i in 0..WIDE {
        sum[i] = other[i].mul_add(share, sum[i]);
    }
    sum
}
