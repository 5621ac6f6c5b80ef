//! Explicit Runge-Kutta methods; a method is its table and nothing else.

use super::Scalar;
use std::ops::ControlFlow;

/// Butcher table of an explicit method with `STAGES` stages. Its numbers are dimensionless; states are in the caller's units,
/// and slopes in those per unit of `t`.
#[derive(Clone, Copy, Debug)]
pub struct Tableau<const STAGES: usize> {
    /// Name in the literature.
    pub name: &'static str,
    /// Order of accuracy.
    pub order: usize,
    /// Stage coefficients, strictly lower triangular.
    pub a: [[f64; STAGES]; STAGES],
    /// Weights.
    pub b: [f64; STAGES],
    /// Stage times.
    pub c: [f64; STAGES],
}

/// The classical fourth-order method (Kutta 1901).
pub const RK4: Tableau<4> = Tableau {
    name: "rk4",
    order: 4,
    a: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    b: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    c: [0.0, 0.5, 0.5, 1.0],
};

/// Scratch of a method for one state size; made once, reused every step.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar> {
    stage: Vec<S>,
    slopes: Vec<S>,
}

impl<S: Scalar> Workspace<S> {
    /// Scratch for `states` states and `stages` stages.
    pub fn new(states: usize, stages: usize) -> Self {
        Self { stage: vec![S::ZERO; states], slopes: vec![S::ZERO; states * stages] }
    }
}

impl<const STAGES: usize> Tableau<STAGES> {
    /// Advances `x` from `t` by `h`: x += h sum b_i k_i with
    /// k_i = f(t + c_i h, x + h sum a_ij k_j).
    ///
    /// `f(t, x, dx)` may fail; `x` is then left as it was.
    pub fn step<S: Scalar, E>(
        &self,
        mut f: impl FnMut(S, &[S], &mut [S]) -> Result<(), E>,
        t: S,
        h: S,
        x: &mut [S],
        work: &mut Workspace<S>,
    ) -> Result<(), E> {
        let n = x.len();
        for i in 0..STAGES {
            let (done, rest) = work.slopes.split_at_mut(i * n);
            work.stage.copy_from_slice(x);
            for (j, k) in done.chunks_exact(n).enumerate() {
                if self.a[i][j] != 0.0 {
                    axpy(&mut work.stage, h * self.a[i][j], k);
                }
            }
            f(t + h * self.c[i], &work.stage, &mut rest[..n])?;
        }
        for i in 0..STAGES {
            axpy(x, h * self.b[i], &work.slopes[i * n..][..n]);
        }
        Ok(())
    }
}

/// Equal steps of time. Step `k` begins at `start + k length`, free of summed rounding. Times are in the caller's unit, s in
/// every model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EqualSteps<S = f64> {
    /// Time at which step 0 begins.
    pub start: S,
    /// Length of a step.
    pub length: S,
    /// First step to take.
    pub first: usize,
    /// Number of steps to take.
    pub count: usize,
}

impl<S: Scalar> EqualSteps<S> {
    /// `count` steps of `length` from `start`.
    pub fn new(start: S, length: S, count: usize) -> Self {
        Self { start, length, first: 0, count }
    }

    /// Time at which step `k` begins.
    pub fn time(&self, k: usize) -> S {
        self.start + self.length * k as f64
    }
}

/// What [`Tableau::integrate`] follows: a slope, and what is done between the steps. A closure `f(t, x, dx)` is a slope alone.
/// Time and states are in the caller's units, slopes in those per unit of time.
pub trait Dynamics<S: Scalar, E> {
    /// Writes dx/dt.
    ///
    /// # Errors
    /// What makes the slope unusable there.
    fn slope(&mut self, t: S, x: &[S], dx: &mut [S]) -> Result<(), E>;

    /// Sees the state at the end of step `k`, may correct it, and stops by `Break`.
    ///
    /// # Errors
    /// What makes the state unusable.
    fn after_step(&mut self, _k: usize, _t: S, _x: &mut [S]) -> Result<ControlFlow<()>, E> {
        Ok(ControlFlow::Continue(()))
    }
}

impl<S: Scalar, E, F: FnMut(S, &[S], &mut [S]) -> Result<(), E>> Dynamics<S, E> for F {
    fn slope(&mut self, t: S, x: &[S], dx: &mut [S]) -> Result<(), E> {
        self(t, x, dx)
    }
}

impl<const STAGES: usize> Tableau<STAGES> {
    /// Takes `steps` with the state `x`: the one place that advances a state step after step.
    /// True when all were taken, false when `dynamics` stopped before. Compiled once for all that moves: a call by reference is
    /// nothing beside a slope.
    ///
    /// # Errors
    /// The first that `dynamics` gives; a step that fails in its slope leaves `x` as it began.
    pub fn integrate<S: Scalar, E>(
        &self,
        dynamics: &mut dyn Dynamics<S, E>,
        steps: EqualSteps<S>,
        x: &mut [S],
        work: &mut Workspace<S>,
    ) -> Result<bool, E> {
        for k in steps.first..steps.first + steps.count {
            self.step(|t, x, dx| dynamics.slope(t, x, dx), steps.time(k), steps.length, x, work)?;
            if dynamics.after_step(k, steps.time(k + 1), x)?.is_break() {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// y += a x
#[inline]
fn axpy<S: Scalar>(y: &mut [S], a: S, x: &[S]) {
    let n = y.len().min(x.len());
    let (y, x) = (&mut y[..n], &x[..n]);
    for i in 0..n {
        y[i] += a * x[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Explicit midpoint rule (Runge 1895).
    const MIDPOINT: Tableau<2> =
        Tableau { name: "midpoint", order: 2, a: [[0.0, 0.0], [0.5, 0.0]], b: [0.0, 1.0], c: [0.0, 0.5] };

    fn error<const N: usize>(method: &Tableau<N>, steps: usize) -> f64 {
        let h = 2.0 / steps as f64;
        let mut x = [1.0, 0.0];
        let mut work = Workspace::new(2, N);
        for i in 0..steps {
            let oscillator = |_: f64, x: &[f64], dx: &mut [f64]| {
                (dx[0], dx[1]) = (-x[1], x[0]);
                Ok::<(), ()>(())
            };
            method.step(oscillator, i as f64 * h, h, &mut x, &mut work).unwrap();
        }
        (x[0] - 2.0_f64.cos()).hypot(x[1] - 2.0_f64.sin())
    }

    #[test]
    fn methods_reach_their_order() {
        let order = |coarse: f64, fine: f64| (coarse / fine).log2();
        let observed = order(error(&RK4, 40), error(&RK4, 80));
        assert!((observed - RK4.order as f64).abs() < 0.1, "rk4 order {observed}");
        let observed = order(error(&MIDPOINT, 40), error(&MIDPOINT, 80));
        assert!((observed - MIDPOINT.order as f64).abs() < 0.1, "midpoint order {observed}");
    }

    #[test]
    fn a_failing_model_leaves_the_state() {
        let mut x = [1.0];
        let result = RK4.step(
            |_, _: &[f64], _: &mut [f64]| Err("broken"),
            0.0,
            0.1,
            &mut x,
            &mut Workspace::new(1, 4),
        );
        assert_eq!((result, x[0]), (Err("broken"), 1.0));
    }
}
