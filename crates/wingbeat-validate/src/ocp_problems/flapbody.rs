//! FLAPBODY-14, problem B: the quickest turn into a bank of 15 deg.

use crate::flapbody::{DIFFERENCE, FlapBody, initial_state};
use crate::{Case, ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat::math::Scalar;
use wingbeat::ocp::interior_point::{Options, Solution, SolveStatus, solve};
use wingbeat::ocp::{
    Collocation, Ends, FREE, Instant, Limits, OptimalControl, Scheme, Setup, Trajectory, Transcribed,
};
use wingbeat::plant::{Channel, Fault, Plant};

const SOURCE: &str = "CasADi 3.8.2 + IPOPT on the same transcription";

/// Problem B: J = t_f + 0.05 sum h |u|^2 + 0.01 sum |du|^2.
#[derive(Clone, Debug, Default)]
pub struct TurnIn {
    plant: FlapBody,
}

impl OptimalControl for TurnIn {
    fn setup(&self) -> Setup {
        let mut states = self.plant.states().to_vec();
        let limit = |channel: &mut Channel, size: f64| (channel.low, channel.high) = (-size, size);
        states[..2].iter_mut().for_each(|c| limit(c, 60_f64.to_radians()));
        states[3..6].iter_mut().for_each(|c| limit(c, 15.0));
        let bank = 15_f64.to_radians();
        let mut end: Vec<Limits> = vec![[bank; 2], [-bank; 2], FREE];
        end.extend([[0.0; 2]; 3]);
        let start = initial_state().map(|x| [x; 2]);
        let mut setup = Setup::new(states, self.plant.inputs().to_vec(), [0.10, 0.60]).between(&start, &end);
        setup.path = ["stroke_1 - stroke_2", "stroke_3 - stroke_4"]
            .map(|name| Channel::limited(name, "", "", -DIFFERENCE, DIFFERENCE))
            .into();
        setup.input_change = 0.01;
        setup
    }
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault> {
        self.plant.rates(at.t, at.x, at.u, dx)
    }
    fn running_cost<S: Scalar>(&self, at: Instant<S>) -> S {
        at.u.iter().fold(S::ZERO, |sum, u| sum + *u * *u) * 0.05
    }
    fn constrain_path<S: Scalar>(&self, at: Instant<S>, values: &mut [S]) {
        values[0] = at.x[9] - at.x[10];
        values[1] = at.x[11] - at.x[12];
    }
    fn end_cost<S: Scalar>(&self, ends: Ends<S>) -> S {
        ends.t[1]
    }
}

impl TurnIn {
    /// Roll linear, the rest as at the start, no input, t_f = 0.3 s.
    pub fn guess(&self) -> Trajectory {
        let (first, mut last) = (initial_state().to_vec(), initial_state().to_vec());
        last[0] = 15_f64.to_radians();
        Trajectory { t: vec![0.0, 0.3], x: vec![first, last], u: vec![vec![0.0; 4]; 2], p: Vec::new() }
    }

    /// Solves the problem on `intervals` equal intervals.
    pub fn solve(&self, intervals: usize, options: &Options) -> Solution {
        let uniform = Transcribed::uniform(Scheme::hermite_simpson(), intervals);
        let guess = self.guess();
        let mut program = Collocation::new(self, Transcribed { cost_at_nodes: true, ..uniform }, &guess);
        let start = program.unknowns(&guess);
        let mut quiet = |_: &_| ControlFlow::Continue(());
        solve(&mut program, &start, options, &mut quiet)
    }
}

fn compare() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    let instances = [("ocp.flapbody_B", 50, 0.255202142811), ("ocp.flapbody_B.fine", 100, 0.252703900518)];
    for (id, intervals, optimum) in instances {
        let solution = TurnIn::default().solve(intervals, &Options::default());
        if solution.status != SolveStatus::Solved {
            return Err(Error::NoAnswer(solution.status.to_string()));
        }
        let value = (solution.objective - optimum).abs() / optimum;
        let metric = format!("objective at N = {intervals}, relative; {} iterations", solution.iterations);
        rows.push(ComparisonRow::judged(id, SOURCE, &metric, value, 1e-8, ""));
    }
    Ok(rows)
}

/// The comparisons.
pub const CASES: &[Case] = &[Case { id: "ocp.flapbody_B", quick: true, run: compare }];
