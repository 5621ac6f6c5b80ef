//! The paper's problem of section IV whole, on FLAPBODY-14: cost with five entries of C, boundary conditions, stroke
//! inequalities and free final time together.

use std::ops::ControlFlow;

use wingbeat::math::Scalar;
use wingbeat::ocp::interior_point::{Options, Solution, SolveStatus, solve};
use wingbeat::ocp::nlp::Program;
use wingbeat::ocp::{Collocation, Ends, Instant, OptimalControl, Scheme, Setup, Transcribed};
use wingbeat::plant::Fault;

use crate::ocp_problems::flapbody::TurnIn;
use crate::shipped::scenario;
use crate::{Case, ComparisonRow, Error, ReferenceTable, reference_table};

const SOURCE: &str = "CasADi with its own equations and IPOPT, validation/paper_nlp";

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "paper.nlp", quick: true, run: compare },
    Case { id: "paper.nlp.robot", quick: false, run: robot },
];

/// The same functions and derivatives, by another solver.
const SERVED: &str = "IPOPT on the functions and derivatives of this program, validation/paper_nlp/serve.py";

/// The problem of `scenarios/paper_plan.toml` on the robot, on its first mesh, unknowns in the units of their channels.
///
/// # Errors
/// A scenario that does not fly up to its start.
pub fn on_the_robot(see: &mut dyn FnMut(&mut dyn Program, &[f64])) -> Result<(), Error> {
    Ok(scenario("paper_plan", &[])?.roll_in_program(see)?)
}

/// The optimum on the robot beside that of IPOPT.
fn robot() -> Result<Vec<ComparisonRow>, Error> {
    let table: ReferenceTable = reference_table!("paper_nlp/robot.csv")?;
    let (optimum, variables) = (table.column("objective")?, table.column("variables")?);
    let mut found = None;
    on_the_robot(&mut |program, start| {
        let options = Options { tolerance: 1e-8, ..Options::default() };
        let solution = solve(program, start, &options, &mut |_| ControlFlow::Continue(()));
        found = Some((solution, program.variables().len()));
    })?;
    let Some((solution, count)) = found else { return Err(Error::NoAnswer("no program".into())) };
    if solution.status != SolveStatus::Solved || count as f64 != variables[0] {
        return Err(Error::NoAnswer(format!("{}, {count} unknowns", solution.status)));
    }
    let error = (solution.objective - optimum[0]).abs() / optimum[0];
    let metric =
        format!("objective on the robot, {count} unknowns, relative; {} iterations", solution.iterations);
    Ok(vec![ComparisonRow::judged("paper.nlp.robot", SERVED, &metric, error, 1e-6, "")])
}

/// min t_f + int (z - z_ref)' C (z - z_ref) + 0.05 |u|^2 dt + 0.01 sum |du|^2 into a bank of 15 deg.
struct PaperTurn {
    turn: TurnIn,
    /// Entries of C: roll, pitch and the three rates.
    cost: [f64; 5],
}

impl OptimalControl for PaperTurn {
    fn setup(&self) -> Setup {
        self.turn.setup()
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        self.turn.rates(at, dx)
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        let bank = 15_f64.to_radians();
        let z = [at.x[0] - bank, at.x[1] + bank, at.x[3], at.x[4], at.x[5]];
        let tracking = z.iter().zip(self.cost).fold(S::ZERO, |sum, (z, c)| sum + z.squared() * c);
        tracking + self.turn.running_cost(at)
    }
    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        self.turn.constrain_path(at, values);
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        self.turn.end_cost(ends)
    }
}

impl PaperTurn {
    fn solve(&self, intervals: usize) -> Solution {
        let uniform = Transcribed::uniform(Scheme::hermite_simpson(), intervals);
        let guess = self.turn.guess();
        let mut program = Collocation::new(self, Transcribed { cost_at_nodes: true, ..uniform }, &guess);
        let start = program.unknowns(&guess);
        solve(&mut program, &start, &Options::default(), &mut |_| ControlFlow::Continue(()))
    }
}

fn compare() -> Result<Vec<ComparisonRow>, Error> {
    let table: ReferenceTable = reference_table!("paper_nlp/optima.csv")?;
    let column = |name: &str| table.column(name);
    let entries = ["roll", "pitch", "rate_x", "rate_y", "rate_z"].map(column);
    let [roll, pitch, x, y, z] = entries;
    let (roll, pitch, x, y, z) = (roll?, pitch?, x?, y?, z?);
    let (intervals, optimum) = (column("intervals")?, column("objective")?);
    let mut rows = Vec::new();
    for i in 0..table.len() {
        let problem = PaperTurn { turn: TurnIn::default(), cost: [roll[i], pitch[i], x[i], y[i], z[i]] };
        let n = intervals[i] as usize;
        let solution = problem.solve(n);
        if solution.status != SolveStatus::Solved {
            return Err(Error::NoAnswer(solution.status.to_string()));
        }
        let error = (solution.objective - optimum[i]).abs() / optimum[i];
        let what = if roll[i] == 0.0 { "without C" } else { "five entries of C" };
        let metric = format!("objective at N = {n}, {what}, relative; {} iterations", solution.iterations);
        let id =
            if i == 0 { "paper.nlp".into() } else { format!("paper.nlp.{n}_{}", what.replace(' ', "_")) };
        rows.push(ComparisonRow::judged(&id, SOURCE, &metric, error, 1e-6, ""));
    }
    Ok(rows)
}
