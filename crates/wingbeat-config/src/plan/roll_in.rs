//! The quickest roll-in, planned and flown open loop.

use super::{CHECK_STEPS, PlanSpec, PlanSummary, Planned, SolverNumbers};
use crate::recorder::{Recorded, Recorder};
use crate::summary::{Crossing, given, mean};
use crate::{Chosen, Scenario, ScenarioSpec};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use wingbeat_flight::guide::{HeldCommands, Playback, RollIn, RollInSpec, Turn};
use wingbeat_flight::simulate::{Controller, Sample, Schedule, Sensors, fly};
use wingbeat_math::Error;
use wingbeat_ocp::nlp::Program;
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_ocp::{Collocation, Interpolant, Optimum, Progress, Scheme, Transcribed};

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
    /// Duration plus the costs of effort and tracking, s.
    pub objective_s: f64,
    /// What several starts came to: whether their minima differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<String>,
    /// Largest distance of a re-simulation from the plan: each state by name, in its unit.
    pub resimulation_error: BTreeMap<String, f64>,
    /// Planned roll, pitch and yaw at the end, deg.
    pub final_angles_deg: [f64; 3],
    /// The same as the robot flew it under the planned inputs, deg.
    pub flown_angles_deg: [f64; 3],
    /// Least of all clearances from `start_s` on as the robot flew it, m.
    pub least_clearance_m: Option<f64>,
    /// Mean power of the drive on the joints from `start_s` on as the robot flew it, W.
    pub drive_power_w: Option<f64>,
    /// The same of the regulators, W.
    pub regulator_power_w: Option<f64>,
    /// Mean of what the regulators give alone, W.
    pub regulator_power_given_w: Option<f64>,
    /// Share of strips beyond the stall angle, over approach and roll-in as the robot flew them.
    pub stall_fraction: Option<f64>,
}

/// A flight that ends before the roll-in.
fn broken(fault: Fault) -> Error {
    Error::invalid("plan.roll_in", fault, "a scenario that flies up to start_s")
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

    /// Hands the roll-in of `[plan.roll_in]` on its first mesh to `see`, with the start of the first guess: objective,
    /// constraints and their derivatives, for any solver of nonlinear programs.
    ///
    /// # Errors
    /// A scenario without such a plan, or that does not fly up to its start.
    pub fn roll_in_program(&self, see: &mut dyn FnMut(&mut dyn Program, &[f64])) -> Result<(), Error> {
        let Some(PlanSpec::RollIn(spec)) = &self.spec.plan else {
            return Err(Error::invalid("plan.roll_in", "absent", "a [plan.roll_in]"));
        };
        let (problem, _) = match self.controller()? {
            Some(mut approach) => self.approached(spec, &mut approach)?,
            None => self.approached(spec, &mut HeldCommands(self.held_commands()))?,
        };
        let guess = problem.first_guess().map_err(broken)?;
        let mesh = Transcribed::uniform(Scheme::hermite_simpson(), spec.intervals);
        let mut program = Collocation::new(&problem, mesh, &guess);
        let start = program.unknowns(&guess);
        see(&mut program, &start);
        Ok(())
    }

    /// The roll-in from the state to which `approach` flies, and its settings with the time at which it does.
    fn approached<C: Controller>(
        &self,
        spec: &RollInSpec,
        approach: &mut C,
    ) -> Result<(RollIn<'_, wingbeat_robot::Robot>, RollInSpec), Error> {
        let mut x = self.start_of(&self.model);
        let steps = (spec.start_s / self.schedule.step).round() as usize;
        let schedule = Schedule { steps, ..self.schedule };
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        let go_on = |_: &Sample, _: &C| Ok(ControlFlow::Continue(()));
        let flight = fly(model, &mut sensors, approach, &schedule, &mut x, go_on);
        flight.ending.check().map_err(broken)?;
        let spec = RollInSpec { start_s: steps as f64 * self.schedule.step, ..spec.clone() };
        let problem = RollIn::new(&self.model, &x, self.model.strokes(), &spec)
            .map_err(|e| e.within("plan.roll_in"))?;
        Ok((problem, spec))
    }

    fn roll_in<C: Controller>(
        &self,
        spec: &RollInSpec,
        mut approach: C,
        again: C,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let (problem, spec) = self.approached(spec, &mut approach)?;
        let starts = problem.plan(observe).map_err(broken)?;
        let several = (spec.starts > 1).then(|| starts.words());
        let optimum = starts.best;
        let mut summary = self.roll_in_summary(&spec, &optimum);
        summary.starts = several;
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
            .zip(wingbeat_ocp::OptimalControl::setup(&problem).states)
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
        let first = record.values("t").map_or(0, |t| t.partition_point(|t| *t < spec.start_s));
        let power = |name: &str| record.values(name).map_or(&[][..], |values| &values[first..]);
        summary.drive_power_w = mean(power("drive_power"));
        summary.regulator_power_w = mean(power("regulator_power"));
        summary.regulator_power_given_w = given(power("regulator_power"));
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
        let mut x = self.start_of(&self.model);
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        fly(model, &mut sensors, &mut player, &schedule, &mut x, |sample, player| {
            recorder.sample(sample, player)?;
            Ok(ControlFlow::Continue(()))
        });
        let attitude = wingbeat_math::Quat::from_wxyz(&x[self.model.layout().attitude..]);
        Ok((recorder.finish(), attitude.matrix().roll_pitch_yaw().0))
    }

    /// This scenario with the plan as the reference of its controller.
    fn tracking(
        &self,
        problem: &RollIn<'_, wingbeat_robot::Robot>,
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
            starts: None,
            resimulation_error: BTreeMap::new(),
            final_angles_deg: [f64::NAN; 3],
            flown_angles_deg: [f64::NAN; 3],
            least_clearance_m: None,
            drive_power_w: None,
            regulator_power_w: None,
            regulator_power_given_w: None,
            stall_fraction: None,
        }
    }
}
