//! The quickest roll-in, planned and flown open loop.

use super::{CHECK_STEPS, PlanSummary, Planned, SolverNumbers};
use crate::Error;
use crate::guide::{HeldCommands, Playback, RollIn, RollInSpec, Turn};
use crate::ocp::{Interpolant, Optimum, Progress};
use crate::plant::{Fault, Plant};
use crate::scenario::recorder::{Recorded, Recorder};
use crate::scenario::summary::Crossing;
use crate::scenario::{Chosen, Scenario, ScenarioSpec};
use crate::simulate::{Controller, Sample, Schedule, Sensors, fly};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Samples of the record over the planned manoeuvre.
const SAMPLES: usize = 200;

/// `summary.json` of a planned roll-in.
#[derive(Clone, Debug, Serialize)]
pub struct RollInSummary {
    /// How the solver fared.
    #[serde(flatten)]
    pub solver: SolverNumbers,
    /// Start of the manoeuvre, s.
    pub start_s: f64,
    /// Duration of the manoeuvre, s.
    pub duration_s: f64,
    /// Duration plus the cost of effort, s.
    pub objective_s: f64,
    /// Largest distance of a re-simulation from the plan: each state by name, in its unit.
    pub resimulation_error: BTreeMap<String, f64>,
    /// Planned roll, pitch and yaw at the end, deg.
    pub final_angles_deg: [f64; 3],
    /// The same as the robot flew it under the planned inputs, deg.
    pub flown_angles_deg: [f64; 3],
    /// Least of all clearances from `start_s` on as the robot flew it, m.
    pub least_clearance_m: Option<f64>,
    /// Share of strips beyond the stall angle, over approach and roll-in as the robot flew them.
    pub stall_fraction: Option<f64>,
}

impl Scenario {
    /// Plans the roll-in of `spec` from the scenario's approach.
    pub(super) fn plan_roll_in(
        &self,
        spec: &RollInSpec,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        match (self.controller()?, self.controller()?) {
            (Some(approach), Some(again)) => self.roll_in(spec, approach, again, observe),
            _ => {
                let held = || HeldCommands(self.held_commands());
                self.roll_in(spec, held(), held(), observe)
            }
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
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        let go_on = |_: &Sample, _: &C| Ok(ControlFlow::Continue(()));
        let flight = fly(model, &mut sensors, &mut approach, &schedule, &mut x, go_on);
        flight.ending.check().map_err(broken)?;
        let spec = RollInSpec { start_s: steps as f64 * self.schedule.step, ..spec.clone() };
        let problem = RollIn::new(&self.model, &x, &spec).map_err(|e| e.within("plan.roll_in"))?;
        let optimum = problem.plan(observe).map_err(broken)?;
        let mut summary = self.roll_in_summary(&spec, &optimum);
        let Some(solution) = optimum.solution.filter(|_| optimum.status.is_success()) else {
            return Ok(Planned {
                record: None,
                summary: PlanSummary::RollIn(Box::new(summary)),
                files: Vec::new(),
            });
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
        let (Recorded { record, stall_fraction, .. }, angles) = self.fly_plan(&solution, again)?;
        summary.stall_fraction = Some(stall_fraction);
        summary.flown_angles_deg = angles.map(f64::to_degrees);
        let planned = Crossing::since(&record, self.model.clearances(), spec.start_s);
        summary.least_clearance_m = planned.map(|c| c.least_m);
        let tracking = self.tracking(&problem, &spec, &solution)?;
        let files = vec![("track.toml", tracking)];
        Ok(Planned { record: Some(record), summary: PlanSummary::RollIn(Box::new(summary)), files })
    }

    /// Flies approach and planned inputs; the record and the last angles.
    fn fly_plan<C: Controller>(
        &self,
        solution: &Interpolant,
        approach: C,
    ) -> Result<(Recorded, [f64; 3]), Error> {
        let points = &solution.points;
        let (first, last) = (points.t[0], points.t[points.t.len() - 1]);
        // The approach must be the one that was planned from: the same steps.
        let step = self.schedule.step;
        let steps_per_sample = ((last - first) / SAMPLES as f64 / step).floor().max(1.0) as usize;
        let schedule = Schedule { steps: (last / step).ceil() as usize, steps_per_sample, ..self.schedule };
        let steps = schedule.steps;
        let mut player = Playback::new(approach, points.t.clone(), points.u.clone());
        let mut recorder = Recorder::new(
            &self.model,
            self.manoeuvre(),
            &player,
            steps / schedule.steps_per_sample + 1,
            None,
        )?;
        let mut x = self.start();
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        fly(model, &mut sensors, &mut player, &schedule, &mut x, |sample, player| {
            recorder.sample(sample, player)?;
            Ok(ControlFlow::Continue(()))
        });
        let attitude = crate::math::Quat::from_wxyz(&x[self.model.layout().attitude..]);
        Ok((recorder.finish(), attitude.matrix().roll_pitch_yaw().0))
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
        let turn = self.spec.manoeuvre.as_ref().and_then(Chosen::shipped);
        let yaw_rate_rad_s = turn.map_or(0.0, |turn| turn.yaw_rate_rad_s);
        tracked.manoeuvre = Some(Chosen::Shipped(Turn {
            turn_start_s: spec.start_s,
            roll_deg: spec.roll_deg,
            pitch_deg: spec.pitch_deg,
            yaw_rate_rad_s,
            track: Some(problem.track(&solution.points)),
        }));
        toml::to_string(&tracked).map_err(|e| Error::invalid("plan", e, "a scenario that TOML can hold"))
    }

    fn roll_in_summary(&self, spec: &RollInSpec, optimum: &Optimum) -> RollInSummary {
        let end = optimum.solution.as_ref().and_then(|s| s.points.t.last().copied());
        RollInSummary {
            solver: self.solver_numbers(optimum),
            start_s: spec.start_s,
            duration_s: end.map_or(f64::NAN, |t| t - spec.start_s),
            objective_s: optimum.objective - spec.start_s,
            resimulation_error: BTreeMap::new(),
            final_angles_deg: [f64::NAN; 3],
            flown_angles_deg: [f64::NAN; 3],
            least_clearance_m: None,
            stall_fraction: None,
        }
    }
}
