//! Real-time tracking: sequential quadratic programming on a Hermite-Simpson
//! horizon, with exact derivatives, Gauss-Newton curvature (corrected by secants
//! from the second iteration on) and warm starts. Allocates only when it is made.
//!
//! One iteration linearises the plant at nodes and midpoints, eliminates the
//! states interval by interval, and solves the dense program in the inputs.
//!
//! ```
//! use wingbeat_math::Scalar;
//! use wingbeat_ocp::realtime::{RealTime, Settings, UpdateStatus, Tracking};
//! use wingbeat_ocp::plant::{Channel, Fault, Plant};
//!
//! /// A mass of 1 kg on a rail.
//! struct Mass {
//!     states: [Channel; 2],
//!     inputs: [Channel; 1],
//! }
//!
//! impl Plant for Mass {
//!     fn states(&self) -> &[Channel] {
//!         &self.states
//!     }
//!     fn inputs(&self) -> &[Channel] {
//!         &self.inputs
//!     }
//!     fn rates<S: Scalar>(&self, _t: S, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault> {
//!         (dx[0], dx[1]) = (x[1], u[0]);
//!         Ok(())
//!     }
//! }
//!
//! /// Keeps the mass at the origin.
//! struct Origin;
//!
//! impl Tracking for Origin {
//!     fn residuals(&self, _node: usize) -> usize {
//!         3
//!     }
//!     fn residual<S: Scalar>(&self, _node: usize, _t: f64, x: &[S], u: &[S], r: &mut [S]) {
//!         (r[0], r[1], r[2]) = (x[0], x[1] * 0.5, u[0] * 0.1);
//!     }
//! }
//!
//! # fn main() -> Result<(), wingbeat_math::Error> {
//! let mass = Mass {
//!     states: [Channel::free("position", "m", "W"), Channel::free("speed", "m/s", "W")],
//!     inputs: [Channel::limited("force", "N", "W", -0.2, 0.2)],
//! };
//! let mut solver = RealTime::new(&mass, &Origin, Settings::new(10, 0.1))?;
//! let x = [1.0, 0.0];
//! solver.reset(&mass, &x);
//! assert_eq!(solver.solve(&mass, &Origin, 0.0, &x, 5), UpdateStatus::Solved);
//! assert_eq!(solver.input(0), [-0.2]);
//! solver.shift(&mass, 0.02); // the warm start of an update 20 ms later
//! # Ok(())
//! # }
//! ```

mod active_set;
mod condense;
mod curvature;
mod dense;
mod horizon;
mod plan;
mod reduced;
mod status;
mod tracking;

pub use active_set::{ActiveSet, QpEnd, QuadraticProgram};
pub use horizon::HorizonSolver;
pub use plan::{Horizon, Plan};
pub use status::{Limit, Statistics, UpdateStatus};
pub use tracking::{Component, LinearLimit, Tracking};

use crate::plant::{Fault, Linearisation, Plant};
use crate::{Midpoint, Transcription};
use condense::{Columns, Elimination};
use curvature::Correction;
use dense::padded;
use plan::check_finite;
use reduced::{Reduction, limited, rate_limited};
use wingbeat_math::Error;
use wingbeat_math::Workspace;
use wingbeat_math::rows;

/// How a horizon is cut and when it counts as solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Intervals N.
    pub intervals: usize,
    /// Length of an interval, s.
    pub step: f64,
    /// The input at node 0 is given, not chosen.
    pub hold_first_input: bool,
    /// Solved when the largest input step (as a share of half its range, or in its unit where it has none) and the largest
    /// defect are below this.
    pub tolerance: f64,
    /// Longest Runge-Kutta step beyond the old horizon when shifting, s.
    pub substep: f64,
    /// Updates can be in two phases, [`RealTime::prepare`] and [`RealTime::answer`], for which the linearisation of the whole horizon is
    /// kept.
    pub prepared: bool,
}

impl Settings {
    /// `intervals` of `step` seconds, first input free, tolerance 1e-8.
    pub fn new(intervals: usize, step: f64) -> Self {
        Self { intervals, step, hold_first_input: false, tolerance: 1e-8, substep: 2.5e-3, prepared: false }
    }
}

/// The solver with its plan and working storage.
#[derive(Clone, Debug)]
pub struct RealTime {
    settings: Settings,
    plan: Plan,
    trial: Plan,
    nodes: Vec<Linearisation>,
    /// In the middles of all intervals where updates are prepared, else of the last.
    middles: Vec<Linearisation>,
    point: Midpoint<f64>,
    defect: Vec<f64>,
    states: Elimination,
    reduction: Reduction,
    qp: QuadraticProgram,
    solver: ActiveSet,
    curvature: Correction,
    columns: Columns,
    work: Workspace<f64>,
    statistics: Statistics,
    /// Moves of the nodes' states by the measured one, in padded rows.
    moved: Vec<f64>,
    /// Whether an answer can be given.
    ready: bool,
    /// Whether the plan has no rates yet.
    without_rates: bool,
    /// Whether the model fails on the plan of the last answer.
    failed: bool,
}

impl RealTime {
    /// A solver for the sizes and limits of `plant` and `tracking`.
    ///
    /// # Errors
    /// An empty horizon, a step or a rate limit that is not positive, or crossed limits.
    pub fn new<P: Plant, T: Tracking>(plant: &P, tracking: &T, settings: Settings) -> Result<Self, Error> {
        check(plant, tracking, &settings)?;
        let (n, m) = (plant.states().len(), plant.inputs().len());
        let horizon = Horizon { states: n, inputs: m, intervals: settings.intervals, step: settings.step };
        let columns = Columns { inputs: m, first: usize::from(settings.hold_first_input) };
        let variables = columns.through(settings.intervals) - 1;
        let rates = rate_limited(tracking, m).count();
        let rows = settings.intervals * (limited(plant.states()).count() + tracking.limits().len() + rates);
        let residuals = (0..=settings.intervals).map(|k| tracking.residuals(k)).max().unwrap_or(0);
        let kept = if settings.prepared { settings.intervals } else { 1 };
        let nodes_kept = if settings.prepared { settings.intervals + 1 } else { 1 };
        Ok(Self {
            settings,
            plan: Plan::new(horizon),
            trial: Plan::new(horizon),
            nodes: vec![Linearisation::new(n, m); settings.intervals + 1],
            middles: vec![Linearisation::new(n, m); kept],
            point: Midpoint::new(n, m),
            defect: vec![0.0; n],
            states: Elimination::new(horizon, kept, plant.driven_states()),
            reduction: Reduction::new(horizon, residuals, rows, nodes_kept),
            qp: QuadraticProgram::new(variables, rows),
            solver: ActiveSet::new(variables),
            curvature: Correction::new(variables),
            columns,
            work: Workspace::new(n, 4),
            statistics: Statistics::default(),
            moved: vec![0.0; if settings.prepared { (settings.intervals + 1) * padded(n) } else { 0 }],
            ready: false,
            without_rates: false,
            failed: false,
        })
    }

    /// The plan: states, inputs and rates at the nodes.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The plan, to move its states into other coordinates or to set a guess.
    pub fn plan_mut(&mut self) -> &mut Plan {
        self.ready = false;
        &mut self.plan
    }

    /// State at node `k`, in the units of its channels.
    pub fn state(&self, k: usize) -> &[f64] {
        self.plan.state(k)
    }

    /// Input at node `k`, in the units of its channels.
    pub fn input(&self, k: usize) -> &[f64] {
        self.plan.input(k)
    }

    /// Derivative of the state at `node` by the inputs, at the point linearised last, in the units of the states over those of
    /// the inputs: states x (1 + free inputs up to `node`), row-major; column 0 is the step that closes the defects.
    pub fn sensitivity(&self, node: usize) -> &[f64] {
        self.states.state(node, self.columns)
    }

    /// Measures of the last update.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Fills the plan with the state `x0` and inputs of zero, or the nearest allowed, in the units of the plant's channels.
    pub fn reset<P: Plant>(&mut self, plant: &P, x0: &[f64]) {
        self.plan.rest(x0, plant.inputs(), 0);
        self.plan.f.fill(0.0);
        (self.ready, self.without_rates, self.failed) = (false, false, false);
    }

    /// Moves the plan on by `dt`, s: the warm start of the next update.
    pub fn shift<P: Plant>(&mut self, plant: &P, dt: f64) {
        self.complete(plant);
        self.ready = false;
        self.trial.shift_from(&self.plan, dt, plant, self.settings.substep, &mut self.work);
        std::mem::swap(&mut self.plan, &mut self.trial);
    }

    /// Takes another plan of the same sizes, with its step.
    pub fn take(&mut self, plan: &Plan) {
        self.plan.copy_from(plan);
        (self.ready, self.without_rates, self.failed) = (false, false, false);
        self.cut(plan.horizon.step);
    }

    /// Moves the nodes of the plan to intervals of `step` s from the same start, as [`shift`](Self::shift) moves them on.
    pub fn stretch<P: Plant>(&mut self, plant: &P, step: f64) {
        self.complete(plant);
        self.ready = false;
        self.trial.horizon.step = step;
        self.trial.shift_from(&self.plan, 0.0, plant, self.settings.substep, &mut self.work);
        std::mem::swap(&mut self.plan, &mut self.trial);
        self.cut(step);
    }

    /// Gives the plan of an answer the rates that its states are interpolated with; none where the model fails.
    fn complete<P: Plant>(&mut self, plant: &P) {
        if std::mem::take(&mut self.without_rates) && self.plan.evaluate_rates(plant).is_err() {
            self.plan.f.fill(0.0);
            self.failed = true;
        }
    }

    /// Has all storage know the length of an interval.
    fn cut(&mut self, step: f64) {
        self.settings.step = step;
        (self.plan.horizon.step, self.trial.horizon.step) = (step, step);
        self.states.cut(step);
        self.reduction.cut(step);
    }

    /// Improves the plan from the state `x0` at the time `t0`, s, by at most
    /// `iterations` steps of sequential quadratic programming. Where the plan
    /// leads nowhere (a fault of the model, a contradiction) one more attempt is
    /// made from rest at `x0`. The plan is left as it was unless the status says
    /// it was updated.
    pub fn solve<P: Plant, T: Tracking>(
        &mut self,
        plant: &P,
        tracking: &T,
        t0: f64,
        x0: &[f64],
        iterations: usize,
    ) -> UpdateStatus {
        self.statistics = Statistics::default();
        self.ready = false;
        self.complete(plant);
        self.trial.copy_from(&self.plan);
        self.trial.start = t0;
        self.trial.state_mut(0).copy_from_slice(x0);
        let mut end = self.attempt(plant, tracking, iterations);
        if end.is_err() {
            self.statistics = Statistics { restarted: true, ..Statistics::default() };
            self.trial.u.copy_from_slice(&self.plan.u);
            self.trial.rest(x0, plant.inputs(), self.columns.first);
            end = self.attempt(plant, tracking, iterations);
        }
        if end.is_ok() {
            std::mem::swap(&mut self.plan, &mut self.trial);
        }
        end.unwrap_or_else(|failure| failure)
    }

    /// First phase of an update: makes all iterations but the last from the first state of the plan, which is the state expected at the
    /// time `t0`, s, and linearises for the last. False where the whole update is left to [`solve`](Self::solve): where the plan leads
    /// nowhere, and without [`Settings::prepared`]. The plan is left as it is.
    pub fn prepare<P: Plant, T: Tracking>(
        &mut self,
        plant: &P,
        tracking: &T,
        t0: f64,
        iterations: usize,
    ) -> bool {
        self.complete(plant);
        if std::mem::take(&mut self.failed) || !self.settings.prepared {
            return false;
        }
        self.statistics = Statistics::default();
        self.trial.copy_from(&self.plan);
        self.trial.start = t0;
        self.curvature.start();
        self.ready = (1..iterations).try_for_each(|_| self.iterate(plant, tracking)).is_ok()
            && self.assemble(plant, tracking).is_ok();
        if self.ready {
            // Only what binds there is of use: the answer begins with it.
            self.solver.solve(&self.qp);
            self.statistics.qp_changes += self.solver.changes;
        }
        self.ready
    }

    /// Second phase of an update: improves the plan from the state `x0` that was found, in the units of the plant's channels, by the
    /// linearisation that was [prepared](Self::prepare); without one that is trouble. The plan is left as it was unless the status says it
    /// was updated. The rates at its nodes come with the next call: until then they are those of the plan that was linearised, and a model
    /// that fails there is found by then.
    pub fn answer<P: Plant, T: Tracking>(&mut self, plant: &P, tracking: &T, x0: &[f64]) -> UpdateStatus {
        if !std::mem::take(&mut self.ready) {
            return UpdateStatus::NumericalTrouble;
        }
        let expected = self.trial.state(0);
        for (moved, (x, expected)) in self.moved.iter_mut().zip(x0.iter().zip(expected)) {
            *moved = x - expected;
        }
        // The plan begins off the state that was found.
        let off = self.moved[..x0.len()].iter().fold(0.0_f64, |most, moved| most.max(moved.abs()));
        self.statistics.defect = self.statistics.defect.max(off);
        self.states.move_start(self.columns, &self.nodes, &self.middles, &mut self.moved);
        self.reduction.move_start(tracking, &self.moved, self.columns, &mut self.qp);
        if let Err(failure) = self.conclude(plant, ActiveSet::solve_moved) {
            return failure;
        }
        std::mem::swap(&mut self.plan, &mut self.trial);
        self.without_rates = true;
        if self.converged() { UpdateStatus::Solved } else { UpdateStatus::IterationLimit }
    }

    /// Iterates on the trial plan and checks that its nodes can be evaluated.
    fn attempt<P: Plant, T: Tracking>(
        &mut self,
        plant: &P,
        tracking: &T,
        iterations: usize,
    ) -> Result<UpdateStatus, UpdateStatus> {
        self.curvature.start();
        for _ in 0..iterations {
            self.iterate(plant, tracking)?;
            if self.converged() {
                break;
            }
        }
        self.trial.evaluate_rates(plant).map_err(UpdateStatus::ModelFault)?;
        Ok(if self.converged() { UpdateStatus::Solved } else { UpdateStatus::IterationLimit })
    }

    /// One full Gauss-Newton step of the trial plan.
    fn iterate<P: Plant, T: Tracking>(&mut self, plant: &P, tracking: &T) -> Result<(), UpdateStatus> {
        self.assemble(plant, tracking)?;
        self.conclude(plant, ActiveSet::solve)
    }

    /// Makes the quadratic program of a step of the trial plan.
    fn assemble<P: Plant, T: Tracking>(&mut self, plant: &P, tracking: &T) -> Result<(), UpdateStatus> {
        self.linearise(plant)?;
        self.reduction.cost(tracking, &self.trial, &self.states, self.columns, &mut self.qp);
        let channels = [plant.states(), plant.inputs()];
        self.reduction.limits(channels, tracking, &self.trial, &self.states, self.columns, &mut self.qp);
        self.curvature.learn(&self.qp.gradient, &self.qp.hessian);
        self.curvature.add_to(&mut self.qp.hessian);
        Ok(())
    }

    /// Solves the quadratic program and takes its step.
    fn conclude<P: Plant>(
        &mut self,
        plant: &P,
        solve: fn(&mut ActiveSet, &QuadraticProgram) -> QpEnd,
    ) -> Result<(), UpdateStatus> {
        let mut end = solve(&mut self.solver, &self.qp);
        if end == QpEnd::Trouble {
            self.curvature.withdraw(&mut self.qp.hessian);
            end = self.solver.solve(&self.qp);
        }
        self.curvature.record(&self.qp.gradient, &self.solver.z);
        self.statistics.iterations += 1;
        self.statistics.qp_changes += self.solver.changes;
        self.statistics.active = self.solver.active();
        match end {
            QpEnd::Solved => self.step(plant),
            QpEnd::Infeasible { worst } => Err(UpdateStatus::Infeasible { worst: self.meaning(worst) }),
            QpEnd::Trouble => Err(UpdateStatus::NumericalTrouble),
        }
    }

    /// Linearises the plant at nodes and midpoints and eliminates the states.
    fn linearise<P: Plant>(&mut self, plant: &P) -> Result<(), UpdateStatus> {
        let h = self.settings.step;
        for (k, node) in self.nodes.iter_mut().enumerate() {
            let (t, x, u) = (self.trial.time(k), self.trial.state(k), self.trial.input(k));
            // The first state is given, and unless it is found later only its inputs can move.
            let inputs_only = k == 0 && !self.settings.prepared;
            evaluate(node, plant, t, x, u, inputs_only)?;
            let n = node.f.len();
            self.trial.f[k * n..][..n].copy_from_slice(&node.f);
        }
        self.states.start(self.columns, &self.nodes[0]);
        self.statistics.defect = 0.0;
        for k in 0..self.settings.intervals {
            let interval = self.trial.interval(k);
            interval.middle(&mut self.point);
            let slot = k % self.middles.len();
            let middle = &mut self.middles[slot];
            evaluate(middle, plant, interval.t + 0.5 * h, &self.point.x, &self.point.u, false)?;
            let copy_rates = |_: f64, _: &[f64], _: &[f64], f: &mut [f64]| {
                f.copy_from_slice(&middle.f);
                Ok(())
            };
            Transcription::HermiteSimpson
                .defect(&interval, copy_rates, &mut self.point, &mut self.defect)
                .map_err(UpdateStatus::ModelFault)?;
            let largest = self.defect.iter().fold(0.0_f64, |d, x| d.max(x.abs()));
            self.statistics.defect = self.statistics.defect.max(largest);
            if !self.states.advance(k, self.columns, middle, &self.nodes[k + 1], &self.defect) {
                return Err(UpdateStatus::NumericalTrouble);
            }
        }
        Ok(())
    }

    /// Takes the step of the quadratic program.
    fn step<P: Plant>(&mut self, plant: &P) -> Result<(), UpdateStatus> {
        let z = &self.solver.z;
        if z.iter().any(|z| !z.is_finite()) {
            return Err(UpdateStatus::NumericalTrouble);
        }
        self.statistics.stationarity = (self.qp.hessian.chunks_exact(z.len()))
            .fold(0.0, |worst: f64, row| worst.max(rows::dot(row, z).abs()));
        self.statistics.step = 0.0;
        for node in 0..=self.settings.intervals {
            let (width, used) = (self.columns.width(node), self.columns.through(node));
            let rows = self.states.state(node, self.columns).chunks_exact(width);
            for (x, s) in self.trial.state_mut(node).iter_mut().zip(rows) {
                *x += s[0] + rows::dot(&s[1..used], z);
            }
            let Some(first) = self.columns.of(node) else { continue };
            let inputs = self.trial.input_mut(node).iter_mut().zip(plant.inputs());
            for ((u, channel), z) in inputs.zip(&z[first - 1..]) {
                *u = channel.clamp(*u + z);
                let range = 0.5 * (channel.high - channel.low);
                let relative = if range.is_finite() && range > 0.0 { z / range } else { *z };
                self.statistics.step = self.statistics.step.max(relative.abs());
            }
        }
        if self.trial.x.iter().any(|x| !x.is_finite()) {
            return Err(UpdateStatus::NumericalTrouble);
        }
        Ok(())
    }

    fn converged(&self) -> bool {
        let s = &self.statistics;
        s.iterations > 0 && s.step <= self.settings.tolerance && s.defect <= self.settings.tolerance
    }

    /// The limit behind a constraint of the quadratic program.
    fn meaning(&self, constraint: usize) -> Limit {
        let (variables, m) = (self.solver.z.len(), self.columns.inputs);
        if constraint < variables {
            Limit::Input { channel: constraint % m, node: constraint / m + self.columns.first }
        } else {
            self.reduction.meaning[constraint - variables]
        }
    }
}

/// Linearises and refuses rates that are not finite.
fn evaluate<P: Plant>(
    point: &mut Linearisation,
    plant: &P,
    t: f64,
    x: &[f64],
    u: &[f64],
    inputs_only: bool,
) -> Result<(), UpdateStatus> {
    let fault = |fault: Fault| UpdateStatus::ModelFault(fault);
    let end =
        if inputs_only { point.evaluate_inputs(plant, t, x, u) } else { point.evaluate(plant, t, x, u) };
    end.map_err(fault)?;
    check_finite(&point.f, t).map_err(fault)
}

/// Refuses empty horizons and crossed limits, naming them.
fn check<P: Plant, T: Tracking>(plant: &P, tracking: &T, settings: &Settings) -> Result<(), Error> {
    if settings.intervals == 0 {
        return Err(Error::invalid("horizon.intervals", 0, "at least 1"));
    }
    for (key, value) in [("horizon.step_s", settings.step), ("horizon.substep_s", settings.substep)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(Error::invalid(key, value, "a positive number"));
        }
    }
    if plant.inputs().is_empty() {
        return Err(Error::invalid("inputs", 0, "at least 1 input"));
    }
    for (j, channel) in plant.inputs().iter().enumerate() {
        if !(tracking.rate_limit(j) > 0.0) {
            let key = format!("rate_limit.{}", channel.name);
            return Err(Error::invalid(key, tracking.rate_limit(j), "a positive number"));
        }
    }
    let channels = plant.states().iter().chain(plant.inputs()).map(|c| (&c.name, c.low, c.high));
    for (name, low, high) in channels.chain(tracking.limits().iter().map(|l| (&l.name, l.low, l.high))) {
        if !(low <= high) {
            return Err(Error::invalid(format!("limits.{name}"), format!("[{low}, {high}]"), "low <= high"));
        }
    }
    Ok(())
}
