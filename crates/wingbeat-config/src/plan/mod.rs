//! Offline planning: the quickest roll-in, the gait of least power.

mod gait_record;
mod least_power;
mod roll_in;

pub use least_power::{GaitNumbers, LeastPowerSummary};
pub use roll_in::RollInSummary;

use super::Scenario;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;
use wingbeat_flight::guide::{LeastPowerSpec, RollInSpec};
use wingbeat_flight::simulate::Record;
use wingbeat_math::Error;
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
        }
    }
}

/// `summary.json` of a plan.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named after what was planned")]
pub enum PlanSummary {
    RollIn(Box<RollInSummary>),
    LeastPower(Box<LeastPowerSummary>),
}

impl PlanSummary {
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
    /// `ok`, `failed`.
    pub status: &'static str,
    /// How the solver ended.
    pub solver: String,
    /// `local`: the method descends from one guess, and from another it may end lower.
    pub minimum: &'static str,
    /// Largest error of an interval between its nodes, relative.
    pub interval_error: f64,
    /// Intervals of the last mesh.
    pub intervals: usize,
    /// Meshes solved.
    pub meshes: usize,
    /// Solver iterations on all meshes.
    pub iterations: usize,
    /// Wall time of the solver, s.
    pub solve_s: f64,
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
    /// The plan as simulated under its inputs; none when nothing was found.
    pub record: Option<Record>,
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
        match &self.spec.plan {
            Some(PlanSpec::RollIn(spec)) => self.plan_roll_in(spec, observe),
            Some(PlanSpec::LeastPower(spec)) => self.plan_least_power(spec, observe),
            None => Err(Error::invalid("plan", "none", "a [plan.roll_in] or a [plan.least_power]")),
        }
    }

    fn solver_numbers(&self, optimum: &Optimum) -> SolverNumbers {
        let pass = |p: &wingbeat_ocp::Pass| PassNumbers {
            intervals: p.intervals,
            iterations: p.iterations,
            objective: p.objective,
            error: p.error,
        };
        SolverNumbers {
            status: if optimum.status.is_success() { "ok" } else { "failed" },
            solver: optimum.status.to_string(),
            minimum: "local",
            interval_error: optimum.error,
            intervals: optimum.passes.last().map_or(0, |p| p.intervals),
            meshes: optimum.passes.len(),
            iterations: optimum.passes.iter().map(|p| p.iterations).sum(),
            solve_s: optimum.time.as_secs_f64(),
            passes: optimum.passes.iter().map(pass).collect(),
            aero_preset: self.named(&self.model, self.spec.aero.preset.name(), |aero| aero.preset().name()),
            lift_law: self.named(&self.model, self.spec.aero.law.name(), |aero| aero.law().name()),
        }
    }
}
