use super::super::nlp::{Dense, Functions};
use super::*;
use crate::plant::Channel;
use wingbeat_math::Scalar;

struct Hs71;

impl Functions for Hs71 {
    fn variables(&self) -> Vec<Channel> {
        (1..=4).map(|i| Channel::limited(format!("x{i}"), "", "", 1.0, 5.0)).collect()
    }
    fn constraints(&self) -> Vec<Channel> {
        vec![
            Channel::limited("product", "", "", 25.0, f64::INFINITY),
            Channel::limited("sphere", "", "", 40.0, 40.0),
        ]
    }
    fn objective<S: Scalar>(&self, x: &[S]) -> S {
        x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2]
    }
    fn constrain<S: Scalar>(&self, x: &[S], g: &mut [S]) {
        g[0] = x[0] * x[1] * x[2] * x[3];
        g[1] = x.iter().fold(S::ZERO, |sum, &x| sum + x * x);
    }
}

fn run<F: Functions>(functions: &F, start: &[f64]) -> Solution {
    let mut log = |i: &Iteration| {
        println!("{i}");
        ControlFlow::Continue(())
    };
    println!("{}", Iteration::HEADING);
    let solution = solve(&mut Dense::new(functions), start, &Options::default(), &mut log);
    println!("{} {:?}", solution.status, solution.x);
    solution
}

#[test]
fn hs71_is_solved_with_its_multipliers() {
    let solution = run(&Hs71, &[1.0, 5.0, 5.0, 1.0]);
    assert_eq!(solution.status, SolveStatus::Solved);
    assert!((solution.objective - 17.0140172891520).abs() < 1e-8);
    assert!(solution.multipliers[0] < 0.0 && solution.multipliers[1].abs() > 0.1);
}

/// A disc and a line that do not meet, x + y = `sum`.
struct DiscAndLine {
    sum: f64,
}

impl Functions for DiscAndLine {
    fn variables(&self) -> Vec<Channel> {
        ["x", "y"].map(|n| Channel::free(n, "m", "")).into()
    }
    fn constraints(&self) -> Vec<Channel> {
        vec![
            Channel::limited("disc", "m2", "", f64::NEG_INFINITY, 1.0),
            Channel::limited("line", "m", "", self.sum, self.sum),
        ]
    }
    fn objective<S: Scalar>(&self, x: &[S]) -> S {
        x[0]
    }
    fn constrain<S: Scalar>(&self, x: &[S], g: &mut [S]) {
        g[0] = x[0] * x[0] + x[1] * x[1];
        g[1] = x[0] + x[1];
    }
}

#[test]
fn infeasible_constraints_are_named() {
    assert!((run(&DiscAndLine { sum: 1.0 }, &[3.0, 1.0]).objective).abs() < 1e-7);
    let solution = run(&DiscAndLine { sum: 5.0 }, &[3.0, 1.0]);
    assert!(matches!(solution.status, SolveStatus::Infeasible { .. }), "{}", solution.status);
}

/// ln x with a start where it is not a number.
struct Logarithm {
    low: f64,
}

impl Functions for Logarithm {
    fn variables(&self) -> Vec<Channel> {
        vec![Channel::limited("x", "m", "", self.low, 10.0)]
    }
    fn constraints(&self) -> Vec<Channel> {
        vec![]
    }
    fn objective<S: Scalar>(&self, x: &[S]) -> S {
        x[0] - x[0].ln()
    }
    fn constrain<S: Scalar>(&self, _: &[S], _: &mut [S]) {}
}

#[test]
fn broken_models_and_limits_get_an_answer() {
    assert!((run(&Logarithm { low: -1.0 }, &[4.0]).objective - 1.0).abs() < 1e-9);
    let broken = run(&Logarithm { low: -5.0 }, &[-3.0]);
    assert!(matches!(broken.status, SolveStatus::NumericalTrouble { .. }), "{}", broken.status);
    let empty = run(&Logarithm { low: 11.0 }, &[4.0]);
    assert_eq!(empty.status, SolveStatus::Infeasible { channel: "x".into(), violation: 1.0 });
}

/// The point of a circle that is farthest to the right, with an objective that rises steeply off the circle.
struct SteepCircle {
    steepness: f64,
}

impl Functions for SteepCircle {
    fn variables(&self) -> Vec<Channel> {
        ["x", "y"].map(|n| Channel::free(n, "m", "")).into()
    }
    fn constraints(&self) -> Vec<Channel> {
        vec![Channel::limited("circle", "m2", "", 1.0, 1.0)]
    }
    fn objective<S: Scalar>(&self, x: &[S]) -> S {
        (x[0].squared() + x[1].squared() - 1.0) * self.steepness - x[0]
    }
    fn constrain<S: Scalar>(&self, x: &[S], g: &mut [S]) {
        g[0] = x[0].squared() + x[1].squared();
    }
}

/// Maratos 1978 (thesis, Imperial College): along straight steps the solver takes hundreds of iterations.
#[test]
fn steps_follow_constraints_that_bend() {
    for steepness in [100.0, 1000.0, 10_000.0] {
        for angle in [60.0_f64, 80.0, 100.0].map(f64::to_radians) {
            let solution = run(&SteepCircle { steepness }, &[angle.cos(), angle.sin()]);
            assert_eq!(solution.status, SolveStatus::Solved);
            assert!((solution.x[0] - 1.0).abs() < 1e-8, "{:?}", solution.x);
            assert!(solution.iterations <= 45, "{} iterations", solution.iterations);
        }
    }
}
