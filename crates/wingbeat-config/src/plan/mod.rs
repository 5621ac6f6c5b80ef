//! Offline planning: the quickest roll-in, the gait of least power, the quickest reorientation.

mod gait_record;
mod least_power;
mod nodes;
mod reorientation;
mod roll_in;
mod verdict;

pub use least_power::{GaitNumbers, LeastPowerSummary};
pub use nodes::{PlanConstants, PlanNodes, PlanValue};
pub use roll_in::RollInSummary;

use super::Scenario;
use super::fit;
use super::summary::saturation;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use wingbeat_flight::guide::{LeastPowerSpec, ReorientationSpec, RollInSpec};
use wingbeat_flight::simulate::Record;
use wingbeat_judge::{Judge, Verdict};
use wingbeat_math::Error;
use wingbeat_ocp::plant::Channel;
use wingbeat_ocp::{Optimum, Progress};

/// Runge-Kutta steps per interval of the re-simulation.
const CHECK_STEPS: usize = 50;

/// What `wingbeat plan` is asked to plan.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum PlanSpec {
    /// The quickest roll-in to a bank.
    RollIn(RollInSpec),
    /// The periodic gait that needs the least power for a mean force.
    LeastPower(LeastPowerSpec),
    /// The quickest way to another attitude.
    Reorientation(ReorientationSpec),
}

impl PlanSpec {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        match self {
            Self::RollIn(spec) => spec.check().map_err(|e| e.within("roll_in")),
            Self::LeastPower(spec) => spec.check().map_err(|e| e.within("least_power")),
            Self::Reorientation(spec) => spec.check().map_err(|e| e.within("reorientation")),
        }
    }
}

/// The plans there are.
const KINDS: &str = "a [plan.roll_in], a [plan.least_power] or a [plan.reorientation]";

/// `summary.json` of a plan.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named after what was planned")]
pub enum PlanSummary {
    RollIn(Box<RollInSummary>),
    LeastPower(Box<LeastPowerSummary>),
}

impl PlanSummary {
    /// The verdict.
    pub fn verdict(&self) -> &Verdict {
        &self.solver().verdict
    }

    /// How the solver fared.
    pub fn solver(&self) -> &SolverNumbers {
        match self {
            Self::RollIn(summary) => &summary.solver,
            Self::LeastPower(summary) => &summary.solver,
        }
    }
}

/// What a solver has to say of its plan.
#[derive(Clone, Debug, Serialize)]
pub struct SolverNumbers {
    /// The verdict: `ok`, `off_target`, `outside`, `not_periodic`, `not_resolved`, `not_found`, `failed` or `interrupted`.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// How the solver ended.
    pub solver: String,
    /// Largest violation of a constraint, dimensionless, as the solver scales them; missing when nothing could be evaluated.
    pub violation: Option<f64>,
    /// Largest error of the optimality conditions, dimensionless, scaled likewise.
    pub residual: Option<f64>,
    /// Share of the inputs at a limit, over the nodes.
    pub saturated_fraction: Option<f64>,
    /// `local`: the method descends from one guess, and from another it may end lower.
    pub minimum: &'static str,
    /// Largest error of an interval between its nodes, relative.
    pub interval_error: Option<f64>,
    /// Intervals of the plan's mesh.
    pub intervals: usize,
    /// Meshes solved.
    pub meshes: usize,
    /// Solver iterations on all meshes.
    pub iterations: usize,
    /// Wall time of the solver, s.
    pub solve_s: f64,
    /// Processor time of the solver, s.
    pub processor_s: f64,
    /// The meshes, in order.
    pub passes: Vec<PassNumbers>,
    /// Aerodynamic preset.
    pub aero_preset: String,
    /// Lift law.
    pub lift_law: String,
}

/// A solved mesh.
#[derive(Clone, Debug, Serialize)]
pub struct PassNumbers {
    /// Intervals.
    pub intervals: usize,
    /// Solver iterations.
    pub iterations: usize,
    /// Objective, in the unit of the plan's.
    pub objective: f64,
    /// Largest error of an interval between its nodes, relative.
    pub error: f64,
}

/// What was planned.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The plan as simulated under its inputs; none of a plan that misses its constraints.
    pub record: Option<Record>,
    /// The plan as the solver has it, with its multipliers; none when nothing could be evaluated.
    pub nodes: Option<PlanNodes>,
    /// Numbers.
    pub summary: PlanSummary,
    /// Files that carry the plan on, by name: scenarios and cases that follow it.
    pub files: Vec<(&'static str, String)>,
}

impl Scenario {
    /// Plans the scenario's `[plan]` on the robot as the controller knows it, and
    /// simulates the plan open loop. `observe` sees the solver's progress.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no `[plan]` or a setting is out of range.
    pub fn plan(&self, observe: &mut dyn FnMut(Progress) -> ControlFlow<()>) -> Result<Planned, Error> {
        self.without_lattice()?;
        self.spec.without_ground("a plan")?;
        match &self.spec.plan {
            Some(PlanSpec::RollIn(spec)) => self.plan_roll_in(spec, observe),
            Some(PlanSpec::LeastPower(spec)) => self.plan_least_power(spec, observe),
            Some(PlanSpec::Reorientation(spec)) => self.plan_reorientation(spec, observe),
            None => Err(Error::invalid("plan", "none", KINDS)),
        }
    }

    /// How far the plan `points` ([`PlanNodes::points`]) with these `parameters` misses the dynamics of this scenario's model:
    /// the defect of each state, in its unit, one list per row, from states and inputs alone. A plan that was made elsewhere is
    /// held against the model by this.
    ///
    /// # Errors
    /// [`Error::Invalid`] without a `[plan]`, for a column that is not there, or a state that the model refuses.
    pub fn plan_defects(&self, points: &Record, parameters: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        match &self.spec.plan {
            Some(PlanSpec::RollIn(spec)) => self.roll_in_defects(spec, points, parameters),
            Some(PlanSpec::LeastPower(spec)) => self.least_power_defects(spec, points, parameters),
            Some(PlanSpec::Reorientation(spec)) => self.reorientation_defects(spec, points, parameters),
            None => Err(Error::invalid("plan", "none", KINDS)),
        }
    }

    /// A judge who knows the limits of the scenario and where the robot's numbers are from.
    fn judge_of_plan(&self) -> Judge<'_> {
        let mut judge = Judge::new(&self.limits);
        fit::of_known(&self.spec).chain(self.in_vain()).for_each(|warning| judge.warn(warning));
        judge
    }

    fn solver_numbers(
        &self,
        optimum: &Optimum,
        nodes: Option<&PlanNodes>,
        inputs: &[Channel],
    ) -> SolverNumbers {
        let misses = optimum.misses.as_ref();
        let pass = |p: &wingbeat_ocp::Pass| PassNumbers {
            intervals: p.intervals,
            iterations: p.iterations,
            objective: p.objective,
            error: p.error,
        };
        SolverNumbers {
            verdict: Judge::new(&self.limits).verdict(),
            solver: optimum.status.to_string(),
            violation: misses.map(|misses| misses.infeasibility),
            residual: misses.map(|misses| misses.residual),
            saturated_fraction: nodes.map(|nodes| saturation(&nodes.points, inputs)),
            minimum: "local",
            interval_error: Some(optimum.error).filter(|error| error.is_finite()),
            intervals: optimum.solution.as_ref().map_or(0, |solution| solution.intervals()),
            meshes: optimum.passes.len(),
            iterations: optimum.iterations,
            solve_s: optimum.time.as_secs_f64(),
            processor_s: optimum.processor_time.as_secs_f64(),
            passes: optimum.passes.iter().map(pass).collect(),
            aero_preset: self.named(&self.model, self.spec.aero.preset.name(), |aero| aero.preset().name()),
            lift_law: self.named(&self.model, self.spec.aero.law.name(), |aero| aero.law().name()),
        }
    }
}
