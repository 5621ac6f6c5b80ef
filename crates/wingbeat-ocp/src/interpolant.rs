//! The continuous trajectory behind a collocated one, and its own error.

use super::problem::{Instant, OptimalControl};
use super::scheme::Scheme;
use super::trajectory::Trajectory;
use crate::plant::Fault;
use wingbeat_math::{EqualSteps, RK4, Workspace};

/// Where the defect is looked at inside an interval.
const BETWEEN: [f64; 6] = [0.03, 0.15, 0.38, 0.62, 0.85, 0.97];

/// A solution as functions of time: states by the collocation polynomial,
/// inputs as the scheme shapes them.
#[derive(Clone, Debug)]
pub struct Interpolant {
    scheme: Scheme,
    /// Times, states and inputs at every collocation point.
    pub points: Trajectory,
    /// Rates at every collocation point.
    rates: Vec<Vec<f64>>,
}

impl Interpolant {
    /// The interpolant through the collocation points of `scheme`.
    pub fn new<P: OptimalControl>(problem: &P, scheme: &Scheme, points: Trajectory) -> Result<Self, Fault> {
        let mut rates = Vec::with_capacity(points.t.len());
        for (t, (x, u)) in points.t.iter().zip(points.x.iter().zip(&points.u)) {
            let mut dx = vec![0.0; x.len()];
            problem.rates(Instant { t: *t, x, u, p: &points.p }, &mut dx)?;
            rates.push(dx);
        }
        Ok(Self { scheme: scheme.clone(), points, rates })
    }

    /// The scheme whose points these are.
    pub fn scheme(&self) -> &Scheme {
        &self.scheme
    }

    /// True for a point whose state is an unknown of the collocated problem: all but those inside the intervals of a compressed
    /// scheme.
    pub fn is_unknown(&self, point: usize) -> bool {
        !self.scheme.compressed || point.is_multiple_of(self.scheme.points() - 1)
    }

    /// The points whose states are unknowns.
    pub fn unknowns(&self) -> Trajectory {
        let Trajectory { t, x, u, p } = &self.points;
        let kept = |point: &usize| self.is_unknown(*point);
        let rows = || (0..t.len()).filter(kept);
        Trajectory {
            t: rows().map(|k| t[k]).collect(),
            x: rows().map(|k| x[k].clone()).collect(),
            u: rows().map(|k| u[k].clone()).collect(),
            p: p.clone(),
        }
    }

    /// Number of intervals.
    pub fn intervals(&self) -> usize {
        (self.points.t.len() - 1) / (self.scheme.points() - 1)
    }

    /// First point and start and length of interval `k`.
    fn interval(&self, k: usize) -> (usize, f64, f64) {
        let inner = self.scheme.points() - 1;
        let (first, last) = (k * inner, (k + 1) * inner);
        (first, self.points.t[first], self.points.t[last] - self.points.t[first])
    }

    /// State, input and slope of the state at the fraction `s` of interval `k`.
    fn inside(&self, k: usize, s: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (first, _, h) = self.interval(k);
        let sum = |weights: &[f64], values: &[Vec<f64>], i: usize| -> f64 {
            weights.iter().zip(&values[first..]).map(|(w, v)| w * v[i]).sum()
        };
        let (integrals, slopes, shares) =
            (self.scheme.integrals(s), self.scheme.rate_weights(s), self.scheme.input_weights(s));
        let n = self.rates[0].len();
        let x = (0..n).map(|i| self.points.x[first][i] + h * sum(&integrals, &self.rates, i)).collect();
        let u = (0..self.points.u[0].len()).map(|j| sum(&shares, &self.points.u, j)).collect();
        (x, u, (0..n).map(|i| sum(&slopes, &self.rates, i)).collect())
    }

    /// State and input at time `t` (s), in the units of their channels, held at the ends.
    pub fn at(&self, t: f64) -> (Vec<f64>, Vec<f64>) {
        let inner = self.scheme.points() - 1;
        let nodes = self.points.t.iter().step_by(inner);
        let k = nodes.filter(|&&node| node <= t).count().clamp(1, self.intervals()) - 1;
        let (_, start, h) = self.interval(k);
        let (x, u, _) = self.inside(k, ((t - start) / h).clamp(0.0, 1.0));
        (x, u)
    }

    /// Error of each interval: the integral of |dx/dt - f| over it, the
    /// largest state, relative to its typical size (1 without [`Scales`](super::Scales)) + its largest magnitude.
    ///
    /// Equation: ocp.error
    /// `integral of abs(dx/dt - f) over an interval, relative to its typical size (1) + max abs(x)`
    /// Source: Betts 2010, section 4.7.
    /// Test: `bang_bang_is_found_and_its_input_drives_the_model_there`.
    pub fn errors<P: OptimalControl>(&self, problem: &P) -> Result<Vec<f64>, Fault> {
        let n = self.rates[0].len();
        let scales = problem.setup().scales;
        let largest = |i: usize| self.points.x.iter().fold(0.0_f64, |m, x| m.max(x[i].abs()));
        let size = |i: usize| scales.state(i) + largest(i);
        let sizes: Vec<f64> = (0..n).map(size).collect();
        let mut f = vec![0.0; n];
        let mut errors = Vec::with_capacity(self.intervals());
        for k in 0..self.intervals() {
            let (_, start, h) = self.interval(k);
            let mut sums = vec![0.0; n];
            for s in BETWEEN {
                let (x, u, slope) = self.inside(k, s);
                problem.rates(Instant { t: start + s * h, x: &x, u: &u, p: &self.points.p }, &mut f)?;
                for i in 0..n {
                    sums[i] += (slope[i] - f[i]).abs() * h.abs() / BETWEEN.len() as f64;
                }
            }
            errors.push(sums.iter().zip(&sizes).fold(0.0, |m: f64, (e, s)| m.max(e / s)));
        }
        Ok(errors)
    }

    /// Integrates the dynamics from the initial state with the interpolated input, `steps` Runge-Kutta steps per interval, and
    /// returns the largest distance of each state from the interpolant at the nodes, in the unit of the state.
    pub fn resimulate<P: OptimalControl>(&self, problem: &P, steps: usize) -> Result<Vec<f64>, Fault> {
        let mut x = self.points.x[0].clone();
        let mut worst = vec![0.0_f64; x.len()];
        let mut work = Workspace::new(x.len(), 4);
        for k in 0..self.intervals() {
            let (first, start, h) = self.interval(k);
            let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| {
                let u = self.inside(k, (t - start) / h).1;
                problem.rates(Instant { t, x, u: &u, p: &self.points.p }, dx)
            };
            RK4.integrate(&mut rates, EqualSteps::new(start, h / steps as f64, steps), &mut x, &mut work)?;
            let node = &self.points.x[first + self.scheme.points() - 1];
            for (w, (a, b)) in worst.iter_mut().zip(x.iter().zip(node)) {
                *w = w.max((a - b).abs());
            }
        }
        Ok(worst)
    }
}
