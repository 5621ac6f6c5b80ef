//! Sequential quadratic programming from one start, in shares of the ranges.

use super::quadratic::{dot, step};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Weight of the worst limit in the merit against the objective, both scaled to the order of one: choice, well above the
/// multipliers of limits.
const WEIGHT: f64 = 20.0;
/// First, longest and shortest step, as shares of the ranges.
const RADIUS: [f64; 3] = [0.03, 0.2, 1e-4];
/// Steps are taken that gain this share of what the model says; the radius shrinks and grows below and above these.
const TAKEN: f64 = 0.05;
const SHARES: [f64; 2] = [0.25, 0.75];
/// By what it shrinks and grows.
const FACTORS: [f64; 2] = [0.4, 2.0];
/// Gain of the merit below which nothing is left to gain.
const GAIN: f64 = 1e-5;
/// What counts as keeping to a limit, in its scale: 1e-3 is .01 mm of clearance.
pub(super) const KEPT: f64 = 1e-3;

/// What is seen at a point: objective and limits, all scaled: they are dimensionless; a limit is kept where its number is at
/// most 0.
#[derive(Clone, Debug)]
pub struct DescentPoint<P> {
    /// Value of the objective.
    pub objective: f64,
    /// Values of the limits, kept where at most 0.
    pub limits: Vec<f64>,
    /// What else is known there.
    pub more: P,
}

impl<P> DescentPoint<P> {
    /// The worst limit missed, dimensionless.
    pub fn violation(&self) -> f64 {
        self.limits.iter().fold(0.0, |most, c| c.max(most))
    }
    fn merit(&self) -> f64 {
        self.objective + WEIGHT * self.violation()
    }
}

/// Derivatives of the objective, and of each limit. All are dimensionless: coordinates are shares of their ranges.
#[derive(Clone, Debug)]
pub struct Slopes {
    /// Of the objective, by coordinate.
    pub objective: Vec<f64>,
    /// Of each limit, by coordinate.
    pub limits: Vec<Vec<f64>>,
}

/// Where a descent goes.
pub trait Landscape {
    /// What belongs to a point beside its numbers.
    type More;
    /// What is at `x`, close to `near`; `None` where there is nothing.
    fn look(&self, x: &[f64], near: &DescentPoint<Self::More>) -> Option<DescentPoint<Self::More>>;
    /// Derivatives at `x`; `None` where there are none.
    fn slopes(&self, x: &[f64], seen: &mut DescentPoint<Self::More>) -> Option<Slopes>;
}

/// How a descent ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Nothing is left to gain.
    Converged,
    /// No step as short as allowed gains anything, though there are gaits at its end.
    NoStep,
    /// The iterations allowed were used up.
    IterationLimit,
    /// Beside the last gait one has no orbit, or is refused: there are no derivatives, or the shortest step leads to nothing.
    NoSlopes,
}

impl Ended {
    /// All ends, in the order of their numbers in tables.
    pub const ALL: [Self; 4] = [Self::Converged, Self::NoStep, Self::IterationLimit, Self::NoSlopes];

    /// Whether nothing near was found to be better.
    pub fn is_minimum(self) -> bool {
        matches!(self, Self::Converged | Self::NoStep)
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Converged => "converged",
            Self::NoStep => "no shorter step gains",
            Self::IterationLimit => "iteration limit",
            Self::NoSlopes => "no gait beside the last one",
        }
    }
}

/// Where a descent came to.
pub struct Descent<P> {
    pub x: Vec<f64>,
    pub seen: DescentPoint<P>,
    /// Steps that were tried, also those that were refused.
    pub iterations: usize,
    pub ended: Ended,
}

/// Hears the number of an iteration and where it stands; may stop the descent.
pub(super) type Tell<'a, P> = dyn FnMut(usize, &DescentPoint<P>) -> ControlFlow<()> + 'a;

/// Follows the landscape down from the shares `x` of the ranges; `tell` hears iteration, objective and violation, and may stop
/// it.
pub fn descend<L: Landscape>(
    landscape: &L,
    mut x: Vec<f64>,
    mut seen: DescentPoint<L::More>,
    most: usize,
    tell: &mut Tell<L::More>,
) -> Option<Descent<L::More>> {
    let n = x.len();
    let [mut radius, longest, shortest] = RADIUS;
    let mut hessian = DMatrix::<f64>::identity(n, n);
    let end = |x, seen, iterations, ended| Some(Descent { x, seen, iterations, ended });
    let Some(mut slopes) = landscape.slopes(&x, &mut seen) else { return end(x, seen, 0, Ended::NoSlopes) };
    for iteration in 1..=most {
        if tell(iteration, &seen).is_break() {
            return None;
        }
        let Some(found) = step(&x, (&seen.limits, &slopes), &hessian, WEIGHT, radius) else {
            return end(x, seen, iteration - 1, Ended::NoStep);
        };
        if found.gain < GAIN {
            return end(x, seen, iteration - 1, Ended::Converged);
        }
        let at = (&x[..], &seen);
        let mut trial = TriedStep::new(landscape, at, found.d, found.gain);
        if trial.share < SHARES[0]
            && let Some(limits) = trial.bent_limits(&slopes, at)
            && let Some(second) = step(&x, (&limits, &slopes), &hessian, WEIGHT, radius)
        {
            let second = TriedStep::new(landscape, at, second.d, found.gain);
            trial = if second.share > trial.share { second } else { trial };
        }
        let length = trial.d.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        if trial.share < SHARES[0] {
            radius = FACTORS[0] * length;
        } else if trial.share > SHARES[1] && length > 0.9 * radius {
            radius = longest.min(FACTORS[1] * radius);
        }
        let nowhere = trial.there.is_none();
        if trial.share > TAKEN
            && let Some(mut there) = trial.there
        {
            let Some(next) = landscape.slopes(&trial.x, &mut there) else {
                return end(trial.x, there, iteration, Ended::NoSlopes);
            };
            let bend = bend(&slopes, &next, &found.multipliers);
            curve(&mut hessian, &trial.d, &bend);
            (x, seen, slopes) = (trial.x, there, next);
        } else if radius < shortest {
            return end(x, seen, iteration, if nowhere { Ended::NoSlopes } else { Ended::NoStep });
        }
    }
    end(x, seen, most, Ended::IterationLimit)
}

/// A step that is tried.
struct TriedStep<P> {
    d: Vec<f64>,
    x: Vec<f64>,
    /// What is at its end, where there is anything.
    there: Option<DescentPoint<P>>,
    /// What the merit falls by there, as a share of what the model says; below 0 where there is nothing.
    share: f64,
}

impl<P> TriedStep<P> {
    /// The step `d` from a point, for which the model says a `gain`.
    fn new<L: Landscape<More = P>>(
        landscape: &L,
        (from, seen): (&[f64], &DescentPoint<P>),
        d: Vec<f64>,
        gain: f64,
    ) -> Self {
        let x: Vec<f64> = from.iter().zip(&d).map(|(x, d)| (x + d).clamp(0.0, 1.0)).collect();
        let there = landscape.look(&x, seen);
        let share = there.as_ref().map_or(-1.0, |there| (seen.merit() - there.merit()) / gain);
        Self { d, x, there, share }
    }

    /// The limits with the bend that the step has met: a second step by them gives back what the first misses by it, where a merit
    /// would refuse also good steps along a curved limit.
    ///
    /// Equation: trim.second_order_step
    /// `c(x + d) - A d + A d2 <= s in place of c(x) + A d <= s`
    /// Source: Fletcher 1982, Second order corrections for non-differentiable optimization; Nocedal & Wright 2006, 15.6.
    /// Test: `a_step_along_a_curved_limit_is_corrected`.
    fn bent_limits(&self, slopes: &Slopes, (_, seen): (&[f64], &DescentPoint<P>)) -> Option<Vec<f64>> {
        let there = self.there.as_ref()?;
        let along: Vec<f64> = slopes.limits.iter().map(|row| dot(row, &self.d)).collect();
        let foreseen = seen.limits.iter().zip(&along).map(|(c, along)| c + along).fold(0.0, f64::max);
        let bent = || there.limits.iter().zip(&along).map(|(c, along)| c - along).collect();
        (there.violation() > foreseen).then(bent)
    }
}

/// Growth of the Lagrangian's gradient.
fn bend(before: &Slopes, after: &Slopes, multipliers: &[f64]) -> Vec<f64> {
    let gradient = |slopes: &Slopes, i: usize| {
        let limits = slopes.limits.iter().zip(multipliers).map(|(row, m)| m.max(0.0) * row[i]);
        slopes.objective[i] + limits.sum::<f64>()
    };
    (0..before.objective.len()).map(|i| gradient(after, i) - gradient(before, i)).collect()
}

/// The damped update of Broyden, Fletcher, Goldfarb and Shanno (Powell 1978), which keeps the matrix positive definite.
fn curve(hessian: &mut DMatrix<f64>, d: &[f64], bend: &[f64]) {
    let (s, y) = (DVector::from_column_slice(d), DVector::from_column_slice(bend));
    let bs = &*hessian * &s;
    let (sbs, sy) = (s.dot(&bs), dot(d, bend));
    if !(sbs > 0.0) {
        return;
    }
    let damping = if sy < 0.2 * sbs { 0.8 * sbs / (sbs - sy) } else { 1.0 };
    let r = y * damping + &bs * (1.0 - damping);
    *hessian += &r * r.transpose() / s.dot(&r) - &bs * bs.transpose() / sbs;
}
