//! Scalars, derivatives and Runge-Kutta tables.

mod derivatives;

use crate::{Case, ComparisonRow, Error};
use wingbeat::math::{EqualSteps, RK4, Workspace};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "math.rk4_order", quick: true, run: rk4_order },
    Case { id: "math.dual_against_num_dual", quick: true, run: derivatives::against_num_dual },
];

/// Error, dimensionless, at t = 2 of x' = x cos t, x(0) = 1, whose solution is exp(sin t), after `steps` steps.
pub fn error_of_rk4(steps: usize) -> f64 {
    let h = 2.0 / steps as f64;
    let (mut x, mut workspace) = ([1.0], Workspace::new(1, 4));
    let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| {
        dx[0] = x[0] * t.cos();
        Ok::<_, std::convert::Infallible>(())
    };
    let Ok(_) = RK4.integrate(&mut rates, EqualSteps::new(0.0, h, steps), &mut x, &mut workspace);
    (x[0] - 2f64.sin().exp()).abs()
}

fn rk4_order() -> Result<Vec<ComparisonRow>, Error> {
    let observed = (error_of_rk4(100) / error_of_rk4(200)).log2();
    Ok(vec![ComparisonRow::order("math.rk4_order", "exact solution exp(sin t)", observed, 4.0, 0.1)])
}
