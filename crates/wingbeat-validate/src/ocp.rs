//! Transcription and derivatives of optimal-control problems.

use crate::flapbody::{self, FlapBody};
use crate::{Case, ComparisonRow, Error};
use wingbeat::math::{EqualSteps, RK4, Scalar, Workspace};
use wingbeat::ocp::realtime::{RealTime, Settings, Tracking, UpdateStatus};
use wingbeat::plant::Plant;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "ocp.hermite_simpson_order", quick: true, run: hermite_simpson_order },
    Case { id: "ocp.derivatives", quick: true, run: derivatives },
    Case { id: "ocp.flapbody_A", quick: true, run: flapbody_a },
];

/// Follows given inputs, node by node, whatever the states do: its plan is the
/// collocated motion under these inputs.
struct Prescribed(Vec<[f64; 4]>);

impl Tracking for Prescribed {
    fn residuals(&self, _node: usize) -> usize {
        4
    }
    fn residual<S: Scalar>(&self, node: usize, _t: f64, _x: &[S], u: &[S], r: &mut [S]) {
        for (i, r) in r.iter_mut().enumerate() {
            *r = u[i] - self.0[node][i];
        }
    }
}

/// The motion of FLAPBODY-14 from its initial state under inputs at the nodes
/// of `intervals` intervals that fill `duration`, s.
fn collocated(duration: f64, inputs: Vec<[f64; 4]>) -> Result<RealTime, Error> {
    let (plant, x0, intervals) = (FlapBody::default(), flapbody::initial_state(), inputs.len() - 1);
    let prescribed = Prescribed(inputs);
    let settings = Settings { tolerance: 1e-11, ..Settings::new(intervals, duration / intervals as f64) };
    let mut solver = RealTime::new(&plant, &prescribed, settings)?;
    solver.reset(&plant, &x0);
    match solver.solve(&plant, &prescribed, 0.0, &x0, 30) {
        UpdateStatus::Solved => Ok(solver),
        other => Err(Error::NoAnswer(format!("{other:?}"))),
    }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

/// Largest error of the end state, in the unit of that state, of 0.1 s of flight on each number of `intervals`, against
/// Runge-Kutta steps of 0.01 ms.
///
/// # Errors
/// [`Error`] when the model fails or the collocation is not solved.
pub fn collocation_errors(intervals: &[usize]) -> Result<Vec<f64>, Error> {
    const DURATION: f64 = 0.1;
    const STEPS: usize = 10_000;
    let (plant, u) = (FlapBody::default(), [0.3, -0.2, 0.25, -0.15]);
    let (mut x, mut work) = (flapbody::initial_state(), Workspace::new(14, 4));
    let dt = DURATION / STEPS as f64;
    let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| plant.rates_in_numbers(t, x, &u, dx);
    RK4.integrate(&mut rates, EqualSteps::new(0.0, dt, STEPS), &mut x, &mut work)?;
    let error = |&intervals: &usize| -> Result<f64, Error> {
        let solver = collocated(DURATION, vec![u; intervals + 1])?;
        Ok(largest_difference(solver.state(intervals), &x))
    };
    intervals.iter().map(error).collect()
}

fn hermite_simpson_order() -> Result<Vec<ComparisonRow>, Error> {
    let errors = collocation_errors(&[8, 16])?;
    let observed = (errors[0] / errors[1]).log2();
    let source = "Hargraves & Paris 1987 (order 4)";
    Ok(vec![ComparisonRow::order("ocp.hermite_simpson_order", source, observed, 4.0, 0.2)])
}

/// Sensitivity of every node's state to every input, from the exact
/// linearisations, against central differences of the solved collocation.
fn derivatives() -> Result<Vec<ComparisonRow>, Error> {
    const INTERVALS: usize = 5;
    const DURATION: f64 = 0.025;
    const EPSILON: f64 = 1e-4;
    let inputs: Vec<[f64; 4]> =
        (0..=INTERVALS).map(|k| [0.3, -0.2, 0.25, -0.15].map(|u: f64| u * (1.0 + k as f64).cos())).collect();
    let exact = collocated(DURATION, inputs.clone())?;
    let mut worst = 0.0_f64;
    for j in 0..4 * (INTERVALS + 1) {
        let moved = |by: f64| {
            let mut inputs = inputs.clone();
            inputs[j / 4][j % 4] += by;
            collocated(DURATION, inputs)
        };
        let (above, below) = (moved(EPSILON)?, moved(-EPSILON)?);
        for node in j / 4..=INTERVALS {
            let sensitivity = exact.sensitivity(node);
            let width = sensitivity.len() / 14;
            for i in 0..14 {
                let difference = (above.state(node)[i] - below.state(node)[i]) / (2.0 * EPSILON);
                let slope = sensitivity[i * width + 1 + j];
                worst = worst.max((slope - difference).abs() / (1.0 + slope.abs()));
            }
        }
    }
    let metric = "max relative error of the states' sensitivities to the inputs";
    Ok(vec![ComparisonRow::judged("ocp.derivatives", "central differences", metric, worst, 1e-6, "")])
}

/// All recorded instances of FLAPBODY-14 A, cold-started.
fn flapbody_a() -> Result<Vec<ComparisonRow>, Error> {
    let plant = FlapBody::default();
    let mut solver = flapbody::solver(&plant)?;
    let (mut error, mut iterations) = (0.0_f64, 0);
    for instance in flapbody::instances()? {
        solver.reset(&plant, &instance.state);
        let status = solver.solve(&plant, &instance.problem, instance.time, &instance.state, 20);
        if status != UpdateStatus::Solved {
            return Err(Error::NoAnswer(format!("t = {} s: {status:?}", instance.time)));
        }
        error = error.max(largest_difference(&solver.plan().u, &instance.inputs));
        iterations = iterations.max(solver.statistics().iterations);
    }
    let source = "CasADi 3.8.2 + IPOPT 3.14.19, tol 1e-10";
    Ok(vec![
        ComparisonRow::judged(
            "ocp.flapbody_A",
            source,
            "max error of the optimal inputs, 200 instances",
            error,
            1e-6,
            "",
        ),
        ComparisonRow::shown("ocp.flapbody_A.iterations", source, "most iterations", iterations as f64, ""),
    ])
}
