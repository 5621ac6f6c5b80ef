//! Solution of an optimal-control problem on meshes refined until its own
//! error and the change of its objective are small.

use crate::collocation::{Collocation, Transcribed};
use crate::interior_point::{Iteration, Options, Quality, Solution, SolveStatus, Stopwatch, solve};
use crate::interpolant::Interpolant;
use crate::multipliers::Multipliers;
use crate::problem::{OptimalControl, Setup};
use crate::scaled::solve_in;
use crate::scheme::{InputShape, Scheme};
use crate::trajectory::Trajectory;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// A change of an input's slope over a node, times the interval, above this
/// share of the input's range marks both intervals as too long.
const KINK: f64 = 0.1;
/// Most parts an interval is divided into at once.
const MOST_PARTS: f64 = 4.0;
/// Intervals shorter than this share of the time span are not divided.
const SHORTEST: f64 = 1e-7;
/// Barrier and margin of the first and of later meshes' starts.
const WARM_BARRIER: f64 = 1e-4;
const WARM_MARGIN: f64 = 1e-6;
/// A solution whose error is within this factor of the tolerance is acceptable.
const NEARLY: f64 = 100.0;
/// Finer uniform meshes tried when the first gives no solution.
const RETRIES: usize = 2;

/// How an optimal-control problem is solved.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Collocation scheme.
    pub scheme: Scheme,
    /// Equal intervals of the first mesh.
    pub intervals: usize,
    /// Largest error of an interval at the end, relative ([`Interpolant::errors`]).
    pub tolerance: f64,
    /// Largest relative change of the objective from the last mesh but one.
    pub objective_tolerance: f64,
    /// Most meshes.
    pub meshes: usize,
    /// Most intervals.
    pub most_intervals: usize,
    /// Most iterations of the solver on all meshes together.
    pub iterations: usize,
    /// The solver on each mesh; its time limit holds for all meshes together.
    pub solver: Options,
}

impl Default for Refinement {
    fn default() -> Self {
        Self {
            scheme: Scheme::hermite_simpson(),
            intervals: 24,
            tolerance: 1e-8,
            objective_tolerance: 1e-7,
            meshes: 20,
            most_intervals: 2000,
            iterations: usize::MAX,
            solver: Options::default(),
        }
    }
}

/// A mesh that was solved.
#[derive(Clone, Debug)]
pub struct Pass {
    /// Number of the problem or of the guess that it is of, from 0, where several are solved one after another.
    pub stage: usize,
    /// Number of the mesh of that stage, from 0.
    pub number: usize,
    /// Intervals.
    pub intervals: usize,
    /// Solver's end.
    pub status: SolveStatus,
    /// Solver's iterations.
    pub iterations: usize,
    /// Objective, in the unit of the problem's cost.
    pub objective: f64,
    /// Largest error of an interval, relative.
    pub error: f64,
}

/// What an observer sees while a problem is solved.
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// An iteration of the solver on the present mesh.
    Iteration(&'a Iteration),
    /// A mesh is solved.
    Pass(&'a Pass),
}

/// The outcome of [`optimise`].
#[derive(Clone, Debug)]
pub struct Optimum {
    /// How it ended.
    pub status: SolveStatus,
    /// Objective on the last mesh, in the unit of the problem's cost.
    pub objective: f64,
    /// The solution as functions of time; none when nothing could be evaluated.
    pub solution: Option<Interpolant>,
    /// Largest error of an interval, relative; infinite when unknown.
    pub error: f64,
    /// How far the solution misses constraints and optimality; none when nothing could be evaluated.
    pub misses: Option<Misses>,
    /// Iterations of the solver on all meshes, those of meshes that gave nothing included.
    pub iterations: usize,
    /// The meshes, in order.
    pub passes: Vec<Pass>,
    /// Intervals of the mesh on which the solver ended with this status. Where the solution has others, that mesh gave nothing better.
    pub ended_on: usize,
    /// Multipliers on the last mesh; none when nothing could be evaluated.
    pub multipliers: Option<Multipliers>,
    /// Wall time.
    pub time: Duration,
    /// Processor time of the thread that solved.
    pub processor_time: Duration,
}

/// How far a solution on its mesh is from an optimum.
#[derive(Clone, Debug, PartialEq)]
pub struct Misses {
    /// Largest violation of a constraint, dimensionless: as the solver scales them.
    pub infeasibility: f64,
    /// Largest error of the optimality conditions, dimensionless: scaled likewise.
    pub residual: f64,
    /// Largest violation of a constraint in its own unit.
    pub violation: f64,
    /// Name of that constraint; empty without one.
    pub constraint: String,
}

/// Solves as [`optimise`] does, where its meshes are of the stage of number `stage`, from 0, of several solves.
pub fn optimise_stage<P: OptimalControl>(
    problem: &P,
    guess: &Trajectory,
    refinement: &Refinement,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    stage: usize,
) -> Optimum {
    let mut optimum = optimise(problem, guess, refinement, &mut |at| match at {
        Progress::Pass(pass) => observer(Progress::Pass(&Pass { stage, ..pass.clone() })),
        iteration @ Progress::Iteration(_) => observer(iteration),
    });
    optimum.passes.iter_mut().for_each(|pass| pass.stage = stage);
    optimum
}

impl Optimum {
    /// True when this is better than `other`: an optimum of the lower objective, else the better of two points that are none
    /// (of the feasible ones the lower, without any the one that misses its constraints less). Violations up to `acceptable`,
    /// scaled and dimensionless, are none.
    pub fn beats(&self, other: &Self, acceptable: f64) -> bool {
        match (self.status.is_success(), other.status.is_success()) {
            (true, true) => self.objective < other.objective,
            (false, false) => self.quality().beats(&other.quality(), acceptable),
            (own, _) => own,
        }
    }

    fn quality(&self) -> Quality {
        let of = |misses: &Misses| Quality { infeasibility: misses.infeasibility, objective: self.objective };
        self.misses.as_ref().map_or(Quality::NONE, of)
    }
}

/// Solves `problem` from `guess`, mesh after mesh. An end without an optimum comes with the best that was met: the optimum of
/// the last mesh that has one, without any the best point of all iterations.
pub fn optimise<P: OptimalControl>(
    problem: &P,
    guess: &Trajectory,
    refinement: &Refinement,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Optimum {
    let (begin, stopwatch) = (Instant::now(), Stopwatch::start());
    let mut run =
        MeshRun { problem, refinement, observer, stopwatch, iterations: 0, passes: Vec::new(), ended_on: 0 };
    let (status, last) = match refusal(&problem.setup(), guess) {
        Some(status) => (status, None),
        None => run.meshes(guess),
    };
    let (objective, error) = last.as_ref().map_or((f64::NAN, f64::INFINITY), |l| (l.objective, l.error));
    let misses = last.as_ref().map(|l| l.misses.clone());
    let (solution, multipliers) = last.map(|l| (l.interpolant, l.multipliers)).unzip();
    let (time, processor_time) = (begin.elapsed(), stopwatch.elapsed());
    let MeshRun { passes, iterations, ended_on, .. } = run;
    Optimum {
        status,
        objective,
        error,
        misses,
        iterations,
        solution,
        passes,
        ended_on,
        multipliers,
        time,
        processor_time,
    }
}

/// What makes a problem unsolvable before anything is computed.
fn refusal(setup: &Setup, guess: &Trajectory) -> Option<SolveStatus> {
    let trouble = |cause: String| Some(SolveStatus::NumericalTrouble { cause });
    if setup.states.is_empty() {
        return trouble("the problem has no states".into());
    }
    let counts = [setup.states.len(), setup.inputs.len(), setup.parameters.len()];
    if let Some(cause) = setup.scales.fault(counts) {
        return trouble(cause);
    }
    if guess.p.len() != setup.parameters.len() {
        return trouble(format!("the guess must hold {} parameters", setup.parameters.len()));
    }
    if let Some(cause) = guess.fault(setup.states.len(), setup.inputs.len()) {
        return trouble(cause);
    }
    let [initial, last] = setup.times;
    if !(last[1] > initial[0]) {
        let violation = initial[0] - last[1];
        return Some(SolveStatus::Infeasible {
            channel: "final time (the horizon is empty)".into(),
            violation,
        });
    }
    None
}

/// A solved mesh.
struct Solved {
    mesh: Vec<f64>,
    objective: f64,
    errors: Vec<f64>,
    error: f64,
    interpolant: Interpolant,
    multipliers: Multipliers,
    misses: Misses,
}

impl Solved {
    /// True when this is better than `other`, an end without an optimum each.
    fn beats(&self, other: &Self, acceptable: f64) -> bool {
        let quality = |of: &Self| Quality { infeasibility: of.misses.infeasibility, objective: of.objective };
        quality(self).beats(&quality(other), acceptable)
    }

    /// True when `finer`, an optimum that was found from elsewhere, is dearer and no more accurate: another one, and a worse.
    fn dominates(&self, finer: &Self) -> bool {
        self.objective < finer.objective && self.error <= finer.error
    }
}

struct MeshRun<'a, P> {
    problem: &'a P,
    refinement: &'a Refinement,
    observer: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    stopwatch: Stopwatch,
    /// Of the solver so far.
    iterations: usize,
    passes: Vec<Pass>,
    /// Intervals of the mesh that was solved last.
    ended_on: usize,
}

impl<P: OptimalControl> MeshRun<'_, P> {
    fn meshes(&mut self, guess: &Trajectory) -> (SolveStatus, Option<Solved>) {
        let (mut status, mut last) = self.first(guess);
        while let (true, Some(solved)) = (status.is_success(), &last) {
            let objective = solved.objective;
            let previous = self.passes.iter().rev().nth(1).filter(|p| p.status.is_success());
            let change = previous.map_or(f64::INFINITY, |p| (p.objective - objective).abs());
            let settled = change <= self.refinement.objective_tolerance * objective.abs().max(1e-3);
            if settled && solved.error <= self.refinement.tolerance {
                break;
            }
            let mesh = refine(solved, self.refinement, settled);
            let full = mesh.len() > self.refinement.most_intervals + 1 || mesh.len() == solved.mesh.len();
            if full || self.passes.len() >= self.refinement.meshes {
                let accurate = solved.error <= NEARLY * self.refinement.tolerance;
                status = if accurate {
                    SolveStatus::Acceptable
                } else {
                    SolveStatus::CoarseMesh { error: solved.error }
                };
                break;
            }
            let start = resample(solved, &mesh);
            let accurate = solved.error <= NEARLY * self.refinement.tolerance;
            let (warm, (next_status, next)) = self.finer(mesh, &start);
            match next {
                Some(next) if next_status.is_success() && (warm || !solved.dominates(&next)) => {
                    (status, last) = (next_status, Some(next));
                }
                _ => {
                    // The coarser solution stands, as far as it is accurate.
                    let stopped = next_status == SolveStatus::Stopped;
                    status = match next_status {
                        _ if accurate && !stopped => SolveStatus::Acceptable,
                        found if found.is_success() => SolveStatus::CoarseMesh { error: solved.error },
                        found => found,
                    };
                    break;
                }
            }
        }
        (status, last)
    }

    /// A finer mesh from the solution on a coarser one: a warm start, and a
    /// cold one where that fails; whether the end is that of the warm start.
    fn finer(&mut self, mesh: Vec<f64>, start: &Trajectory) -> (bool, (SolveStatus, Option<Solved>)) {
        let solver = self.refinement.solver.clone();
        let warm = Options { barrier: WARM_BARRIER, margin: WARM_MARGIN, ..solver.clone() };
        let (status, solved) = self.solve_mesh(mesh.clone(), start, warm);
        let over = status == SolveStatus::Stopped || self.is_over();
        if status.is_success() || over {
            (true, (status, solved))
        } else {
            (false, self.solve_mesh(mesh, start, solver))
        }
    }

    /// True when iterations or time are used up.
    fn is_over(&self) -> bool {
        self.iterations >= self.refinement.iterations
            || self.stopwatch.elapsed() >= self.refinement.solver.time
    }

    /// The first mesh, uniform; a finer one where the solver finds nothing.
    fn first(&mut self, guess: &Trajectory) -> (SolveStatus, Option<Solved>) {
        let mut intervals = self.refinement.intervals.max(1);
        let mut result = self.uniform(intervals, guess);
        for _ in 0..RETRIES {
            let again = matches!(
                result.0,
                SolveStatus::Infeasible { .. }
                    | SolveStatus::IterationLimit
                    | SolveStatus::NumericalTrouble { .. }
            );
            let &Refinement { most_intervals, meshes, .. } = self.refinement;
            let fits = 2 * intervals <= most_intervals && self.passes.len() < meshes && !self.is_over();
            if !again || result.1.is_none() || !fits {
                break;
            }
            intervals *= 2;
            let (status, next) = self.uniform(intervals, guess);
            // Of two that are no optima the better one stays.
            let acceptable = self.refinement.solver.acceptable;
            let better = |next: &Solved| {
                status.is_success() || result.1.as_ref().is_none_or(|last| next.beats(last, acceptable))
            };
            let kept = if next.as_ref().is_some_and(better) { next } else { result.1 };
            result = (status, kept);
        }
        result
    }

    fn uniform(&mut self, intervals: usize, guess: &Trajectory) -> (SolveStatus, Option<Solved>) {
        let mesh = (0..=intervals).map(|k| k as f64 / intervals as f64).collect();
        self.solve_mesh(mesh, guess, self.refinement.solver.clone())
    }

    fn solve_mesh(
        &mut self,
        mesh: Vec<f64>,
        guess: &Trajectory,
        options: Options,
    ) -> (SolveStatus, Option<Solved>) {
        self.ended_on = mesh.len() - 1;
        let time = options.time.saturating_sub(self.stopwatch.elapsed());
        let iterations = options.iterations.min(self.refinement.iterations.saturating_sub(self.iterations));
        let scheme = self.refinement.scheme.clone();
        let transcribed = Transcribed { scheme: scheme.clone(), mesh: mesh.clone(), cost_at_nodes: false };
        let mut program = Collocation::new(self.problem, transcribed, guess);
        let start = program.unknowns(guess);
        let observer = &mut *self.observer;
        let mut watch = |iteration: &Iteration| observer(Progress::Iteration(iteration));
        let options = Options { time, iterations, ..options };
        let solution = match self.problem.setup().scales.is_unit() {
            true => solve(&mut program, &start, &options, &mut watch),
            false => solve_in(&program.sizes(), &mut program, &start, &options, &mut watch),
        };
        self.iterations += solution.iterations;
        let multipliers = program.multipliers(&solution.x, &solution.multipliers, &solution.bounds);
        let misses = Misses {
            infeasibility: solution.infeasibility,
            residual: solution.error,
            violation: solution.violation,
            constraint: solution.missed.clone(),
        };
        let judged = program.trajectory(&solution.x).ok().and_then(|points| {
            let interpolant = Interpolant::new(self.problem, &scheme, points).ok()?;
            Some((interpolant.errors(self.problem).ok()?, interpolant))
        });
        let Solution { status, objective, iterations, .. } = solution;
        let (errors, interpolant) = match judged {
            Some(judged) => judged,
            None => return (status, None),
        };
        let error = errors.iter().fold(0.0_f64, |m, e| m.max(*e));
        let (number, intervals) = (self.passes.len(), mesh.len() - 1);
        let pass = Pass { stage: 0, number, intervals, status: status.clone(), iterations, objective, error };
        let stopped = (self.observer)(Progress::Pass(&pass)).is_break();
        self.passes.push(pass);
        let status = if stopped { SolveStatus::Stopped } else { status };
        (status, Some(Solved { mesh, objective, errors, error, interpolant, multipliers, misses }))
    }
}

/// The solution sampled at the points that a refined mesh will have.
fn resample(solved: &Solved, mesh: &[f64]) -> Trajectory {
    let points = &solved.interpolant.points;
    let (t0, t1) = (points.t[0], points.t[points.t.len() - 1]);
    let mut out = Trajectory { p: points.p.clone(), ..Trajectory::default() };
    let parts = 12;
    for k in 0..mesh.len() - 1 {
        for i in 0..parts {
            out.t.push(t0 + (t1 - t0) * (mesh[k] + (mesh[k + 1] - mesh[k]) * i as f64 / parts as f64));
        }
    }
    out.t.push(t1);
    for &t in &out.t {
        let (x, u) = solved.interpolant.at(t);
        out.x.push(x);
        out.u.push(u);
    }
    out
}

/// Divides the intervals whose error is too large or whose input has a kink;
/// all of them when neither explains that the objective still changes.
fn refine(solved: &Solved, refinement: &Refinement, settled: bool) -> Vec<f64> {
    let order = f64::from(refinement.scheme.order);
    let bent = if settled { vec![false; solved.errors.len()] } else { kinks(solved, refinement) };
    let mut parts: Vec<usize> = solved
        .errors
        .iter()
        .zip(&bent)
        .map(|(&error, &bent)| {
            let wanted = (error / refinement.tolerance).powf(1.0 / (order + 1.0)).ceil();
            if error > refinement.tolerance {
                wanted.clamp(2.0, MOST_PARTS) as usize
            } else {
                1 + usize::from(bent)
            }
        })
        .collect();
    let divisible = |k: usize| solved.mesh[k + 1] - solved.mesh[k] > SHORTEST;
    if !settled && (0..parts.len()).all(|k| parts[k] == 1 || !divisible(k)) {
        parts.fill(2);
    }
    let mut mesh = vec![0.0];
    for (k, &count) in parts.iter().enumerate() {
        let (a, b) = (solved.mesh[k], solved.mesh[k + 1]);
        let count = if divisible(k) { count } else { 1 };
        mesh.extend((1..=count).map(|i| if i == count { b } else { a + (b - a) * i as f64 / count as f64 }));
    }
    mesh
}

/// Intervals at whose ends an input changes its slope abruptly.
fn kinks(solved: &Solved, refinement: &Refinement) -> Vec<bool> {
    let inner = refinement.scheme.points() - 1;
    let u: Vec<&Vec<f64>> = solved.interpolant.points.u.iter().step_by(inner).collect();
    let mesh = &solved.mesh;
    let mut bent = vec![false; mesh.len() - 1];
    for j in 0..u[0].len() {
        let values = || u.iter().map(|u| u[j]);
        let range = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
        let slope = |k: usize| (u[k + 1][j] - u[k][j]) / (mesh[k + 1] - mesh[k]);
        for k in 1..bent.len() {
            let h = (mesh[k] - mesh[k - 1]).min(mesh[k + 1] - mesh[k]);
            if (slope(k) - slope(k - 1)).abs() * h > KINK * range.max(1e-6) {
                (bent[k - 1], bent[k]) = (true, true);
            }
        }
    }
    if refinement.scheme.input == InputShape::Polynomial {
        wiggles(solved, refinement, &mut bent);
    }
    bent
}

/// Marks intervals whose polynomial input leaves the line between its ends.
fn wiggles(solved: &Solved, refinement: &Refinement, bent: &mut [bool]) {
    let inner = refinement.scheme.points() - 1;
    let u = &solved.interpolant.points.u;
    for j in 0..u[0].len() {
        let values = || u.iter().map(|u| u[j]);
        let range = values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min);
        for (k, bent) in bent.iter_mut().enumerate() {
            for i in 1..inner {
                let (a, b) = (u[k * inner][j], u[(k + 1) * inner][j]);
                let line = a + (b - a) * refinement.scheme.c[i];
                *bent |= (u[k * inner + i][j] - line).abs() > KINK * range.max(1e-6);
            }
        }
    }
}

#[cfg(test)]
mod tests;
