//! Steps as long as a stated error of the last position allows, by the pair of Dormand and Prince and its dense output.

use super::stepper::finite;
use wingbeat_math::{Dynamics, EqualSteps, Vec3};
use wingbeat_ocp::plant::Fault;

/// Stages of the pair; the last is the first of the next step.
const STAGES: usize = 7;
/// Rows of the stages behind the first, the last of which is the step itself.
const A: [[f64; STAGES - 1]; STAGES - 1] = [
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
const C: [f64; STAGES - 1] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
/// Weights of the fifth order less those of the fourth.
const E: [f64; STAGES] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Weights of the dense output.
const D: [f64; STAGES] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];
/// Of a method of fifth order the error of a step is its distance from two steps of half its length over 1 - 2^-5.
const ORDER: f64 = 1.0 - 1.0 / 32.0;
/// Instants of a flight at which the error is measured. *Choice.*
const INSTANTS: f64 = 100.0;
/// Longest step as a share of the flight, and shortest as a share of a step of the clock. *Choices.*
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1.0 / 64.0;
/// By how much a step may change, and what is aimed at of what is allowed. *Choices.*
const CHANGE: [f64; 2] = [0.2, 5.0];
const AIM: f64 = 0.9;
/// Times that are one, as a share of a step of the clock.
const SAME: f64 = 1e-9;
/// Standard errors of the mean over the instants. *Choice.*
const SURE: f64 = 2.0;

/// By how much the first of two states at a time (s), in place of the second, moves the last position, in W, m.
pub type Reach<'a> = &'a dyn Fn(f64, [&[f64]; 2]) -> Vec3;

/// What the steps of a flight are chosen by.
#[derive(Clone, Copy)]
pub struct Accuracy<'a> {
    /// Error of the last position that all steps together may make, m.
    pub error: f64,
    /// What an error does to the last position.
    pub reach: Reach<'a>,
    /// Times at which rates may break, s, in their order: a step ends at each.
    pub breaks: &'a [f64],
}

/// The steps that were taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Taken {
    /// How many.
    pub steps: usize,
    /// How many more were tried and were too long.
    pub rejected: usize,
    /// Error of the last position as it was measured, m, by steps of half the length.
    pub error: f64,
}

/// The error of the last position after `duration` s, m, of errors per second (m/s) at instants: those of one stroke and the next cancel as
/// vectors do; to their mean come two standard errors of what the instants in between may add.
pub fn mean_error(rates: &[Vec3], duration: f64) -> Option<f64> {
    let count = rates.len() as f64;
    let mean = rates.iter().fold(Vec3::ZERO, |sum, of| sum + *of) * (1.0 / count);
    let spread = rates.iter().map(|of| (*of - mean).norm().powi(2)).sum::<f64>() / count;
    (!rates.is_empty()).then(|| (mean.norm() + SURE * (spread / count).sqrt()) * duration)
}

/// A system on the steps of a clock, whose ends [`Dynamics::after_step`] sees.
pub(super) trait Clocked: Dynamics<f64, Fault> {
    /// The next step of the clock after `k` before which something is decided.
    fn next(&self, k: usize) -> usize;
    /// Puts the state `x` at the time `t`, after a step of `length` s, back onto its constraints.
    fn settle(&mut self, t: f64, length: f64, x: &mut [f64]) -> Result<(), Fault>;
}

/// A step of the pair.
struct StepPair {
    slopes: [Vec<f64>; STAGES],
    /// The state at its end, the same by the fourth order, and the stage under way.
    end: Vec<f64>,
    lower: Vec<f64>,
    stage: Vec<f64>,
}

impl StepPair {
    fn new(states: usize) -> Self {
        let room = || vec![0.0; states];
        Self { slopes: std::array::from_fn(|_| room()), end: room(), lower: room(), stage: room() }
    }

    /// The slope at the start of a step.
    fn begin(&mut self, of: &mut dyn Clocked, t: f64, x: &[f64]) -> Result<(), Fault> {
        of.slope(t, x, &mut self.slopes[0])
    }

    /// A step of `h` s from the state `x` at the time `t`, whose slope is known.
    ///
    /// Equation: flight.pair
    /// `k_i = f(t + c_i h, x + h sum a_ij k_j), x(t + h) = x + h sum b_i k_i, error h sum (b_i - b_i*) k_i`
    /// Source: Dormand & Prince 1980, J. Comput. Appl. Math. 6: orders 5 and 4; Hairer, Norsett & Wanner 1993, II.5 and II.6.
    /// Test: `the_pair_and_its_dense_output_have_their_orders`.
    fn step(&mut self, of: &mut dyn Clocked, t: f64, h: f64, x: &[f64]) -> Result<(), Fault> {
        for (i, row) in A.iter().enumerate() {
            let (done, rest) = self.slopes.split_at_mut(i + 1);
            let stage = if i + 2 == STAGES { &mut self.end } else { &mut self.stage };
            combine(stage, x, h, row, done);
            of.slope(t + C[i] * h, stage, &mut rest[0])?;
        }
        combine(&mut self.lower, &self.end, -h, &E, &self.slopes);
        Ok(())
    }

    /// The state after the share `s` of the step from `x` of `h` s, of fourth order.
    fn dense(&self, x: &[f64], h: f64, s: f64, at: &mut [f64]) {
        let r = 1.0 - s;
        for (i, at) in at.iter_mut().enumerate() {
            let (whole, k) = (self.end[i] - x[i], |j: usize| h * self.slopes[j][i]);
            let begin = k(0) - whole;
            let last: f64 = (0..STAGES).map(|j| D[j] * k(j)).sum();
            *at = x[i] + s * (whole + r * (begin + s * (whole - k(STAGES - 1) - begin + r * last)));
        }
    }
}

/// out = x + h sum factors_j slopes_j
fn combine(out: &mut [f64], x: &[f64], h: f64, factors: &[f64], slopes: &[Vec<f64>]) {
    out.copy_from_slice(x);
    for (factor, slope) in factors.iter().zip(slopes).filter(|(factor, _)| **factor != 0.0) {
        let factor = h * factor;
        out.iter_mut().zip(slope).for_each(|(out, slope)| *out = factor.mul_add(*slope, *out));
    }
}

/// What is known of the errors: those of steps per second as they were measured, and the sums of their sizes and of the sizes of the
/// differences in the pair at the same steps.
#[derive(Default)]
struct MeasuredErrors {
    rates: Vec<Vec3>,
    size: f64,
    told: f64,
    due: f64,
}

impl MeasuredErrors {
    /// What the difference in the pair may be in a step for the flight to keep to `error` m in `duration` s, with one more measured. Both
    /// it and the error per second are of fifth order, so that their ratio does not depend on the steps.
    fn allowed(&self, error: f64, duration: f64, more: Option<(Vec3, f64)>) -> f64 {
        let (rate, told) = more.map_or((0.0, 0.0), |(rate, told)| (rate.norm(), told));
        let size = self.size + rate;
        if size > 0.0 { error * (self.told + told) / (size * duration) } else { f64::INFINITY }
    }
    fn take(&mut self, (rate, told): (Vec3, f64)) {
        self.rates.push(rate);
        self.size += rate.norm();
        self.told += told;
    }
}

/// A flight by steps of a stated error.
struct AccurateFlight<'a> {
    asked: &'a Accuracy<'a>,
    clock: EqualSteps,
    end: f64,
    pair: StepPair,
    /// The same step in two halves.
    halves: [StepPair; 2],
    measured: MeasuredErrors,
    taken: Taken,
}

impl AccurateFlight<'_> {
    /// The next time after `t` that a step has to end at, and the step of the clock that it is the start of, if it is one.
    fn stop(&self, t: f64, next: usize) -> (f64, Option<usize>) {
        let (near, at) = (SAME * self.clock.length, self.clock.time(next));
        let broken = self.asked.breaks.iter().find(|broken| **broken > t + near && **broken < at - near);
        broken.map_or((at, Some(next)), |broken| (*broken, None))
    }

    /// Tries a step of `h` s from `x`: what its error is as a share of what is allowed; where it was measured, its error per second and the
    /// difference in the pair.
    fn attempt(
        &mut self,
        of: &mut dyn Clocked,
        (t, h): (f64, f64),
        x: &[f64],
    ) -> Result<(f64, Option<(Vec3, f64)>), Fault> {
        self.pair.step(of, t, h, x)?;
        let StepPair { end, lower, slopes, .. } = &self.pair;
        let told = (self.asked.reach)(t + h, [lower, end]).norm();
        let mut more = None;
        if t >= self.measured.due {
            let [first, second] = &mut self.halves;
            first.slopes[0].copy_from_slice(&slopes[0]);
            first.step(of, t, 0.5 * h, x)?;
            second.slopes[0].copy_from_slice(&first.slopes[STAGES - 1]);
            second.step(of, t + 0.5 * h, 0.5 * h, &first.end)?;
            let off = (self.asked.reach)(t + h, [end, &second.end]);
            more = Some((off * (1.0 / (ORDER * h)), told));
        }
        let duration = self.end - self.clock.time(self.clock.first);
        let allowed = self.measured.allowed(self.asked.error, duration, more);
        Ok((if told > 0.0 { told / allowed } else { 0.0 }, more))
    }

    /// Shows the ends of steps of the clock behind the one before step `k` that lie within the step of `h` s from `x` at `t`, before
    /// `stop`; false where the flight was ended, whose state `x` is then.
    fn pass(
        &self,
        of: &mut dyn Clocked,
        k: &mut usize,
        (t, h): (f64, f64),
        before: f64,
        x: &mut [f64],
    ) -> Result<bool, Fault> {
        let mut at = x.to_vec();
        while self.clock.time(*k + 1) < before - SAME * self.clock.length {
            let time = self.clock.time(*k + 1);
            self.pair.dense(x, h, (time - t) / h, &mut at);
            if of.after_step(*k, time, &mut at)?.is_break() {
                x.copy_from_slice(&at);
                return Ok(false);
            }
            *k += 1;
        }
        Ok(true)
    }
}

/// Advances the state `x` over the steps of `clock` by steps as long as `asked` allows, which end where something is decided or breaks; all
/// other ends of steps of the clock are met by dense output. False when the system stopped before.
///
/// Equation: flight.accuracy
/// `told <= error sum told / (T sum e), told the size of reach(x - x*), e that of reach(x_h - x_h/2)/((1 - 2^-5) h), sums over the instants measured`
/// Source: Shampine 1980, Numer. Math. 35: with local extrapolation the error of a flight is proportional to the tolerance of a step.
/// Test: `the_error_stated_is_kept_and_stops_are_met`.
///
/// # Errors
/// The first that the system gives where no shorter step avoids it.
pub(super) fn integrate(
    of: &mut dyn Clocked,
    asked: &Accuracy,
    clock: EqualSteps,
    x: &mut [f64],
) -> Result<(bool, Taken), Fault> {
    let (n, last) = (x.len(), clock.first + clock.count);
    let (mut t, mut k, end) = (clock.time(clock.first), clock.first, clock.time(last));
    let measured = MeasuredErrors { due: t, ..MeasuredErrors::default() };
    let (pair, halves) = (StepPair::new(n), [StepPair::new(n), StepPair::new(n)]);
    let mut way = AccurateFlight { asked, clock, end, pair, halves, measured, taken: Taken::default() };
    let longest = (LONGEST * (end - t)).max(clock.length);
    let shortest = SHORTEST * clock.length;
    // From the longest on down: of a step that is too short the error is lost in rounding.
    let (mut length, mut known, mut whole) = (longest, false, true);
    while k < last && whole {
        let (stop, lands) = way.stop(t, of.next(k).min(last));
        let left = stop - t;
        let ends = length >= left * (1.0 - SAME);
        // Two like steps in place of one and a rest.
        let h = if ends { left } else { length.min(0.5 * left) };
        // A rest may be longer than the shortest step by rounding.
        let divisible = h > shortest * (1.0 + 2.0 * SAME);
        if !known {
            way.pair.begin(of, t, x)?;
            known = true;
        }
        let (share, more) = match way.attempt(of, (t, h), x) {
            Ok(tried) => tried,
            Err(_) if divisible => (f64::INFINITY, None),
            Err(fault) => return Err(fault),
        };
        let change =
            if share.is_nan() { CHANGE[0] } else { (AIM * share.powf(-0.2)).clamp(CHANGE[0], CHANGE[1]) };
        if !(share <= 1.0) && divisible {
            way.taken.rejected += 1;
            length = (h * change).max(shortest);
            continue;
        }
        way.taken.steps += 1;
        if let Some(more) = more {
            way.measured.take(more);
            way.measured.due = t + (end - clock.time(clock.first)) / INSTANTS;
        }
        length = if ends { length.max(h * change) } else { h * change }.clamp(shortest, longest);
        let to = if ends { stop } else { t + h };
        whole = way.pass(of, &mut k, (t, h), to, x)?;
        if !whole {
            break;
        }
        x.copy_from_slice(&way.pair.end);
        t = to;
        if let Some(step) = lands.filter(|_| ends) {
            (k, known) = (step, false);
            whole = of.after_step(step - 1, t, x)?.is_continue();
        } else {
            finite(x, t)?;
            of.settle(t, h, x)?;
            known = !ends;
            way.pair.slopes.swap(0, STAGES - 1);
        }
    }
    way.taken.error = mean_error(&way.measured.rates, t - clock.time(clock.first)).unwrap_or(0.0);
    Ok((whole, way.taken))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    /// x'' = p - x with a push p between two times, whose slope leaps there; the ends of steps that were seen.
    #[derive(Default)]
    struct Oscillator {
        push: Option<[f64; 2]>,
        every: usize,
        decided: Vec<f64>,
        seen: Vec<(f64, f64)>,
    }

    fn pushed([from, to]: [f64; 2], t: f64) -> f64 {
        ((t - from) * (to - t)).max(0.0)
    }

    impl Dynamics<f64, Fault> for Oscillator {
        fn slope(&mut self, t: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
            (dx[0], dx[1]) = (x[1], self.push.map_or(0.0, |push| pushed(push, t)) - x[0]);
            Ok(())
        }
        fn after_step(&mut self, k: usize, t: f64, x: &mut [f64]) -> Result<ControlFlow<()>, Fault> {
            self.seen.push((t, x[0]));
            if (k + 1).is_multiple_of(self.every) {
                self.decided.push(t);
            }
            Ok(ControlFlow::Continue(()))
        }
    }

    impl Clocked for Oscillator {
        fn next(&self, k: usize) -> usize {
            (k / self.every + 1) * self.every
        }
        fn settle(&mut self, _: f64, _: f64, _: &mut [f64]) -> Result<(), Fault> {
            Ok(())
        }
    }

    #[test]
    fn the_pair_and_its_dense_output_have_their_orders() {
        let errors = [0.2, 0.1].map(|h| {
            let (mut of, mut pair, x) = (Oscillator::default(), StepPair::new(2), [1.0, 0.0]);
            pair.begin(&mut of, 0.0, &x).unwrap();
            pair.step(&mut of, 0.0, h, &x).unwrap();
            let mut at = [0.0; 2];
            pair.dense(&x, h, 0.3, &mut at);
            let off = |x: &[f64], t: f64| (x[0] - t.cos()).hypot(x[1] + t.sin());
            [off(&pair.end, h), off(&pair.lower, h), off(&at, 0.3 * h)]
        });
        let orders: [f64; 3] = std::array::from_fn(|i| (errors[0][i] / errors[1][i]).log2() - 1.0);
        for (order, is) in orders.iter().zip([5.0, 4.0, 4.0]) {
            assert!((order - is).abs() < 0.15, "{orders:?}");
        }
    }

    /// The last place is that of x, an error of either state moves it along the circle.
    fn flown(error: f64, of: &mut Oscillator, breaks: &[f64]) -> (f64, Taken) {
        let end = 10.0_f64;
        let reach = |t: f64, [wrong, right]: [&[f64]; 2]| {
            let (s, c) = (end - t).sin_cos();
            Vec3::new((wrong[0] - right[0]) * c + (wrong[1] - right[1]) * s, 0.0, 0.0)
        };
        let mut x = [1.0, 0.0];
        let asked = Accuracy { error, reach: &reach, breaks };
        let (whole, taken) = integrate(of, &asked, EqualSteps::new(0.0, 0.01, 1000), &mut x).unwrap();
        assert!(whole && of.seen.len() == 1000, "{}", of.seen.len());
        (x[0], taken)
    }

    #[test]
    fn the_error_stated_is_kept_and_stops_are_met() {
        let mut before = usize::MAX;
        for error in [1e-11, 1e-9, 1e-7] {
            let mut of = Oscillator { every: 250, ..Oscillator::default() };
            let (end, taken) = flown(error, &mut of, &[]);
            let off = (end - 10.0_f64.cos()).abs();
            assert!(off <= error && taken.error <= error && off > 1e-3 * error, "{error}: {off} {taken:?}");
            // Of fifth order: a hundredth of the error takes 2.5 times the steps.
            assert!(taken.steps < before, "{error}: {taken:?} {before}");
            before = taken.steps / 2;
            assert_eq!(of.decided, [2.5, 5.0, 7.5, 10.0]);
            let worst = of.seen.iter().map(|(t, x)| (x - t.cos()).abs()).fold(0.0, f64::max);
            assert!(worst <= 10.0 * error, "{error}: {worst}");
        }
    }

    #[test]
    fn an_error_that_no_step_keeps_ends_and_is_told() {
        for count in 1..=40 {
            let mut of = Oscillator { every: 250, ..Oscillator::default() };
            let reach = |_: f64, _: [&[f64]; 2]| Vec3::new(1.0, 0.0, 0.0);
            let asked = Accuracy { error: 1e-9, reach: &reach, breaks: &[] };
            let (whole, taken) =
                integrate(&mut of, &asked, EqualSteps::new(0.0, 1e-3, count), &mut [1.0, 0.0]).unwrap();
            assert!(whole && of.seen.len() == count && taken.error > 1e-9, "{count}: {taken:?}");
            assert!((64 * count..=64 * count + 2).contains(&taken.steps), "{count}: {taken:?}");
        }
    }

    #[test]
    fn a_push_between_the_ends_of_steps_is_met_where_it_is_told() {
        let push = [1.2345, 4.321];
        // Simpson's rule of the push times sin(10 - t).
        let part = (push[1] - push[0]) / 2000.0;
        let weight = |i: usize| if i.is_multiple_of(2) { 2.0 } else { 4.0 };
        let of = |i: usize| {
            let t = push[0] + part * i as f64;
            weight(i) * pushed(push, t) * (10.0 - t).sin()
        };
        let right = 10.0_f64.cos() + (1..2000).map(of).sum::<f64>() * part / 3.0;
        let off = |breaks: &[f64]| {
            let mut of = Oscillator { push: Some(push), every: 1000, ..Oscillator::default() };
            let (end, taken) = flown(1e-8, &mut of, breaks);
            ((end - right).abs(), taken.rejected)
        };
        let (met, rejected) = off(&push);
        assert!(met < 1e-8 && rejected < off(&[]).1, "{met} {rejected}");
    }
}
