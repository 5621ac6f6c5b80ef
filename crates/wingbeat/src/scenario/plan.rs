//! Offline planning of a scenario's manoeuvre.

use super::recorder::Recorder;
use super::{Scenario, ScenarioSpec};
use crate::Error;
use crate::flight::{AtRest, Controller, Ending, Record, Schedule, fly};
use crate::guide::{Manoeuvre, Playback, RollIn, RollInSpec};
use crate::ocp::{Interpolant, Optimum, Progress};
use crate::plant::Fault;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Samples of the record and of the track over the planned manoeuvre.
const SAMPLES: usize = 200;
/// Runge-Kutta steps per interval of the re-simulation.
const CHECK_STEPS: usize = 50;

/// What `wingbeat plan` is asked to plan.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PlanSpec {
    /// The quickest roll-in to a bank.
    pub roll_in: RollInSpec,
}

/// `summary.json` of a plan.
#[derive(Clone, Debug, Serialize)]
pub struct PlanSummary {
    /// `ok`, `failed`.
    pub status: &'static str,
    /// How the solver ended.
    pub solver: String,
    /// Start of the manoeuvre, s.
    pub start_s: f64,
    /// Duration of the manoeuvre, s.
    pub duration_s: f64,
    /// Duration plus the cost of effort, s.
    pub objective_s: f64,
    /// Largest error of an interval between its nodes, relative.
    pub interval_error: f64,
    /// Largest distance of a re-simulation from the plan: each state by name, in its unit.
    pub resimulation_error: BTreeMap<String, f64>,
    /// Planned roll, pitch and yaw at the end, deg.
    pub final_angles_deg: [f64; 3],
    /// The same as the robot flew it under the planned inputs, deg.
    pub flown_angles_deg: [f64; 3],
    /// Intervals of the last mesh.
    pub intervals: usize,
    /// Meshes solved.
    pub meshes: usize,
    /// Solver iterations on all meshes.
    pub iterations: usize,
    /// Wall time of the solver, s.
    pub solve_s: f64,
    /// Aerodynamic preset.
    pub aero_preset: String,
    /// Lift law.
    pub lift_law: String,
}

/// A planned manoeuvre.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Approach and manoeuvre as flown under the planned inputs; empty when
    /// nothing was found.
    pub record: Option<Record>,
    /// Numbers.
    pub summary: PlanSummary,
    /// A scenario in which the controller follows the plan, as TOML.
    pub tracking: Option<String>,
}

impl Scenario {
    /// Plans the scenario's `[plan]` on the robot as the controller knows it,
    /// and flies the plan open loop. `observe` sees the solver's progress.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no `[plan]` or a setting is out of range.
    pub fn plan(&self, observe: &mut dyn FnMut(Progress) -> ControlFlow<()>) -> Result<Planned, Error> {
        let spec =
            self.spec.plan.as_ref().ok_or_else(|| Error::invalid("plan", "none", "a [plan.roll_in]"))?;
        let spec = &spec.roll_in;
        spec.check().map_err(|e| e.within("plan.roll_in"))?;
        match (self.controller()?, self.controller()?) {
            (Some(approach), Some(again)) => self.roll_in(spec, approach, again, observe),
            _ => self.roll_in(spec, AtRest, AtRest, observe),
        }
    }

    fn roll_in<C: Controller>(
        &self,
        spec: &RollInSpec,
        mut approach: C,
        again: C,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let broken =
            |fault: Fault| Error::invalid("plan.roll_in", fault, "a scenario that flies up to start_s");
        let mut x = self.start();
        let steps = (spec.start_s / self.schedule.step).round() as usize;
        let schedule = Schedule { steps, ..self.schedule };
        let flight = fly(&self.model, &mut approach, &schedule, &mut x, |_, _| ControlFlow::Continue(()));
        if let Ending::Fault(fault) = flight.ending {
            return Err(broken(fault));
        }
        let spec = RollInSpec { start_s: steps as f64 * self.schedule.step, ..spec.clone() };
        let problem = RollIn::new(&self.model, &x, &spec).map_err(|e| e.within("plan.roll_in"))?;
        let optimum = problem.plan(observe).map_err(broken)?;
        let mut summary = self.plan_summary(&spec, &optimum);
        let Some(solution) = optimum.solution.filter(|_| optimum.status.is_success()) else {
            return Ok(Planned { record: None, summary, tracking: None });
        };
        summary.resimulation_error = solution
            .resimulate(&problem, CHECK_STEPS)
            .map_err(broken)?
            .into_iter()
            .zip(crate::ocp::OptimalControl::setup(&problem).states)
            .map(|(error, channel)| (channel.name, error))
            .collect();
        if let Some(end) = solution.points.x.last() {
            summary.final_angles_deg = problem.angles(end).map(f64::to_degrees);
        }
        let (record, angles) = self.fly_plan(&solution, again)?;
        summary.flown_angles_deg = angles.map(f64::to_degrees);
        let tracking = self.tracking(&problem, &spec, &solution)?;
        Ok(Planned { record: Some(record), summary, tracking: Some(tracking) })
    }

    /// Flies approach and planned inputs; the record and the last angles.
    fn fly_plan<C: Controller>(
        &self,
        solution: &Interpolant,
        approach: C,
    ) -> Result<(Record, [f64; 3]), Error> {
        let points = &solution.points;
        let (first, last) = (points.t[0], points.t[points.t.len() - 1]);
        // The approach must be the one that was planned from: the same steps.
        let step = self.schedule.step;
        let steps_per_sample = ((last - first) / SAMPLES as f64 / step).floor().max(1.0) as usize;
        let schedule = Schedule { steps: (last / step).ceil() as usize, steps_per_sample, ..self.schedule };
        let steps = schedule.steps;
        let mut player = Playback::new(approach, points.t.clone(), points.u.clone());
        let mut recorder = Recorder::new(&self.model, &player, steps / schedule.steps_per_sample + 1)?;
        let mut x = self.start();
        fly(&self.model, &mut player, &schedule, &mut x, |sample, player| {
            match recorder.sample(sample, player) {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        });
        let attitude = crate::math::Quat::from_wxyz(&x[self.model.layout().attitude..]);
        Ok((recorder.finish().0, attitude.matrix().roll_pitch_yaw().0))
    }

    /// This scenario with the plan as the reference of its controller.
    fn tracking(
        &self,
        problem: &RollIn<'_, crate::robot::Robot>,
        spec: &RollInSpec,
        solution: &Interpolant,
    ) -> Result<String, Error> {
        let mut tracked = ScenarioSpec { plan: None, ..self.spec.clone() };
        tracked.name = format!("{}-tracked", self.spec.name);
        let yaw_rate_rad_s = self.spec.manoeuvre.as_ref().map_or(0.0, |m| m.yaw_rate_rad_s);
        tracked.manoeuvre = Some(Manoeuvre {
            turn_start_s: spec.start_s,
            roll_deg: spec.roll_deg,
            pitch_deg: spec.pitch_deg,
            yaw_rate_rad_s,
            track: Some(problem.track(&solution.points)),
        });
        toml::to_string(&tracked).map_err(|e| Error::invalid("plan", e, "a scenario that TOML can hold"))
    }

    fn plan_summary(&self, spec: &RollInSpec, optimum: &Optimum) -> PlanSummary {
        let last = optimum.passes.last();
        let end = optimum.solution.as_ref().and_then(|s| s.points.t.last().copied());
        PlanSummary {
            status: if optimum.status.is_success() { "ok" } else { "failed" },
            solver: optimum.status.to_string(),
            start_s: spec.start_s,
            duration_s: end.map_or(f64::NAN, |t| t - spec.start_s),
            objective_s: optimum.objective - spec.start_s,
            interval_error: optimum.error,
            resimulation_error: BTreeMap::new(),
            final_angles_deg: [f64::NAN; 3],
            flown_angles_deg: [f64::NAN; 3],
            intervals: last.map_or(0, |p| p.intervals),
            meshes: optimum.passes.len(),
            iterations: optimum.passes.iter().map(|p| p.iterations).sum(),
            solve_s: optimum.time.as_secs_f64(),
            aero_preset: self.spec.aero.preset.name().into(),
            lift_law: self.spec.aero.law.name().into(),
        }
    }
}
