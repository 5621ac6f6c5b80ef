//! A primal-dual interior-point method with a filter line search, after Waechter & Biegler 2006 (Mathematical Programming
//! 106:25-57), for sparse programs with exact second derivatives. Variables, objective and constraints are in the caller's units;
//! inside, all is scaled.

mod best;
mod filter;
mod iterate;
mod kkt;
mod line_search;
mod restoration;
mod runs;
mod solver;
mod standard;
mod status;
mod stopwatch;

pub use status::{Iteration, Options, Solution, SolveStatus};
pub(crate) use {best::Quality, stopwatch::Stopwatch};

use super::nlp::Program;
use solver::Solver;
use std::ops::ControlFlow;
use std::time::Instant;

/// Solves `program` from `start`. `observer` sees every iteration and may stop
/// the solve by returning `ControlFlow::Break`. Where the solve ends without
/// an optimum the solution is the best point that was met: of the feasible ones
/// that of the lowest objective, without any the one that misses least.
///
/// Equation: ocp.barrier
/// `min f(x) - mu sum log of the distances to the bounds, c(x) = 0, mu to 0`
/// Source: Waechter & Biegler 2006.
/// Test: `hs71_is_solved_with_its_multipliers`.
pub fn solve(
    program: &mut dyn Program,
    start: &[f64],
    options: &Options,
    observer: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
) -> Solution {
    let begin = Instant::now();
    if let Some(status) = refusal(program, start) {
        return refused(program, start, status);
    }
    let mut hook = |iteration: &Iteration, _: &Solver| observer(iteration);
    let mut solver = Solver::new(program, options, Stopwatch::start());
    let status = match solver.begin(start) {
        Ok(()) => solver.run(&mut hook),
        Err(error) => SolveStatus::NumericalTrouble { cause: error.to_string() },
    };
    Solution { time: begin.elapsed(), ..solver.solution(status) }
}

/// What makes a program unsolvable before any iteration.
fn refusal(program: &dyn Program, start: &[f64]) -> Option<SolveStatus> {
    let channels = || program.variables().iter().chain(program.constraints());
    if start.len() != program.variables().len() {
        let (given, wanted) = (start.len(), program.variables().len());
        let cause = format!("the start has {given} values for {wanted} variables");
        return Some(SolveStatus::NumericalTrouble { cause });
    }
    if let Some(c) = channels().find(|c| c.low.is_nan() || c.high.is_nan()) {
        let cause = format!("a limit of {} is not a number", c.name);
        return Some(SolveStatus::NumericalTrouble { cause });
    }
    if let Some(c) = channels().find(|c| c.low > c.high || c.low == f64::INFINITY || c.high == -f64::INFINITY)
    {
        let violation = c.low - c.high;
        return Some(SolveStatus::Infeasible { channel: c.name.clone(), violation });
    }
    let bad = start.iter().position(|x| !x.is_finite())?;
    let cause = format!("the start of {} is {}", program.variables()[bad].name, start[bad]);
    Some(SolveStatus::NumericalTrouble { cause })
}

fn refused(program: &dyn Program, start: &[f64], status: SolveStatus) -> Solution {
    let m = program.constraints().len();
    Solution {
        status,
        x: start.to_vec(),
        objective: f64::NAN,
        constraints: vec![f64::NAN; m],
        multipliers: vec![0.0; m],
        bounds: vec![0.0; start.len()],
        iterations: 0,
        error: f64::INFINITY,
        infeasibility: f64::INFINITY,
        violation: f64::INFINITY,
        missed: String::new(),
        time: std::time::Duration::ZERO,
    }
}

#[cfg(test)]
mod tests;
