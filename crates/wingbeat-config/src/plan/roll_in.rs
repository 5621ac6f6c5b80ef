//! The quickest roll-in, planned and flown open loop.

use super::{CHECK_STEPS, PlanNodes, PlanSpec, PlanSummary, Planned, SolverNumbers, nodes, verdict};
use crate::recorder::{Recorded, Recorder, momentum_change};
use crate::summary::{PartClearance, given, mean};
use crate::{Chosen, Scenario, ScenarioSpec, stall};
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use wingbeat_flight::guide::{Playback, RollIn, RollInSpec, Turn};
use wingbeat_flight::simulate::{Controller, Ending, Record, Sample, Schedule, Sensors, fly};
use wingbeat_judge::{Judge, Status};
use wingbeat_math::Error;
use wingbeat_math::order::filled;
use wingbeat_ocp::nlp::Program;
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_ocp::{Interpolant, Optimum, Progress};

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
    pub duration_s: Option<f64>,
    /// Duration plus the costs of effort and tracking, s.
    pub objective_s: Option<f64>,
    /// What several starts came to: whether their minima differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub starts: Option<String>,
    /// Largest distance of a re-simulation from the plan: each state by name, in its unit.
    pub resimulation_error: BTreeMap<String, f64>,
    /// Planned roll, pitch and yaw at the end, deg.
    pub final_angles_deg: Option<[f64; 3]>,
    /// The same as the robot flew it under the planned inputs, deg.
    pub flown_angles_deg: Option<[f64; 3]>,
    /// Length of the rotation vector from the start to the planned end, deg, of a reorientation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned_deg: Option<f64>,
    /// Largest change of the angular momentum about the centre of mass as the robot flew it, kg m2/s, in a vacuum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_momentum_change_kg_m2_s: Option<f64>,
    /// Least of all clearances from `start_s` on as the robot flew it, m.
    pub least_clearance_m: Option<f64>,
    /// Mean power of the drive on the joints from `start_s` on as the robot flew it, W.
    pub drive_power_w: Option<f64>,
    /// The same of the actuators, W.
    pub regulator_power_w: Option<f64>,
    /// Mean of what the actuators give alone, W.
    pub regulator_power_given_w: Option<f64>,
    /// Share of strips beyond the stall angle, over approach and roll-in as the robot flew them.
    pub stall_fraction: Option<f64>,
}

/// Key of the plan.
const KEY: &str = "plan.roll_in";

/// A plan that meets its constraints.
pub(super) struct RollInPlan<'a> {
    problem: &'a RollIn<'a, wingbeat_robot::Robot>,
    spec: &'a RollInSpec,
    pub solution: &'a Interpolant,
    nodes: &'a PlanNodes,
}

impl RollInPlan<'_> {
    /// Whether it turns to another attitude, from which nothing need fly on.
    fn turns(&self) -> bool {
        self.problem.is_reorientation()
    }
}

/// A flight that ends before the plan at `key` begins.
pub(super) fn broken_at(key: &str, fault: Fault) -> Error {
    Error::invalid(key, fault, "a scenario that flies up to the start of its plan")
}

fn broken(fault: Fault) -> Error {
    broken_at(KEY, fault)
}

impl Scenario {
    /// Plans the roll-in of `spec` from the scenario's approach.
    pub(super) fn plan_roll_in(
        &self,
        spec: &RollInSpec,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let (problem, spec) = self.approached(spec)?;
        self.plan_and_fly(&problem, &spec, KEY, observe)
    }

    /// Solves the `problem` at `key`, flies what meets its constraints, and judges it.
    pub(super) fn plan_and_fly(
        &self,
        problem: &RollIn<'_, wingbeat_robot::Robot>,
        spec: &RollInSpec,
        key: &str,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let starts = problem.planned(observe).map_err(|fault| broken_at(key, fault))?;
        let several = (spec.starts > 1).then(|| starts.words());
        let optimum = starts.best;
        let nodes = nodes::nodes(problem, &optimum, "s")?;
        let mut summary = self.roll_in_summary(spec, &optimum, nodes.as_ref());
        summary.starts = several;
        let mut judge = self.judge_of_plan();
        let met = verdict::judge_solver(&mut judge, &optimum, spec.tolerance);
        let (mut record, mut files) = (None, Vec::new());
        if let (true, Some(solution), Some(nodes)) = (met, &optimum.solution, &nodes) {
            let plan = RollInPlan { problem, spec, solution, nodes };
            record = Some(self.flown_roll_in(&plan, &mut summary, &mut judge)?);
            files = vec![match plan.turns() {
                true => ("flight.toml", self.played(&plan)?),
                false => ("track.toml", self.tracking(problem, spec, solution)?),
            }];
        }
        summary.solver.verdict = judge.verdict();
        Ok(Planned { record, nodes, summary: PlanSummary::RollIn(Box::new(summary)), files })
    }

    /// Flies a plan that meets its constraints, and judges it.
    fn flown_roll_in(
        &self,
        plan: &RollInPlan<'_>,
        summary: &mut RollInSummary,
        judge: &mut Judge,
    ) -> Result<Record, Error> {
        let RollInPlan { problem, spec, solution, nodes } = plan;
        match problem.resimulated(solution, CHECK_STEPS) {
            Ok(errors) => {
                let states = wingbeat_ocp::OptimalControl::setup(*problem).states.into_iter();
                summary.resimulation_error = filled(states.map(|channel| channel.name).zip(errors));
            }
            Err(fault) => judge.find(Status::Failed, format!("re-simulated: {fault}")),
        }
        verdict::judge_plan(judge, &summary.solver, &summary.resimulation_error, nodes);
        summary.final_angles_deg =
            solution.points.x.last().map(|end| problem.angles(end).map(f64::to_degrees));
        let (mut recorded, angles, ending) = self.fly_plan(solution)?;
        recorded.cut(&ending);
        let Recorded { record, means, .. } = recorded;
        let first = record.values("t").map_or(0, |t| t.partition_point(|t| *t < spec.start_s));
        if let Err(fault) = ending.check() {
            // What was recorded and can be is kept; of a flight that broke down nothing is judged.
            judge.find(Status::Failed, format!("flown open loop: {fault}"));
            return Ok(record);
        }
        let stalled = means.map(|means| means.stalled);
        summary.stall_fraction = stalled.map(|count| count.stalled());
        summary.flown_angles_deg = Some(angles.map(f64::to_degrees));
        let crossing = PartClearance::since(&record, self.model.clearances(), spec.start_s);
        summary.least_clearance_m = crossing.as_ref().map(|c| c.least_m);
        let power =
            |name: &str| record.values(name).and_then(|values| values.get(first..)).unwrap_or_default();
        summary.drive_power_w = mean(power("drive_power"));
        summary.regulator_power_w = mean(power("regulator_power"));
        summary.regulator_power_given_w = given(power("regulator_power"));
        summary.angular_momentum_change_kg_m2_s = momentum_change(&record);
        if plan.turns() {
            summary.turned_deg = problem.turned(solution).map(f64::to_degrees);
        }
        // In a vacuum a robot only falls, and keeps neither height nor speed.
        if plan.turns() && summary.angular_momentum_change_kg_m2_s.is_some() {
            summary.judge_turned(judge, crossing.as_ref());
        } else {
            summary.judge_flown(judge, &record, first, crossing.as_ref());
            stalled.iter().for_each(|count| stall::hold(judge, count, "aero.law"));
        }
        Ok(record)
    }

    /// [`plan_defects`](Self::plan_defects) of a roll-in.
    pub(super) fn roll_in_defects(
        &self,
        spec: &RollInSpec,
        points: &Record,
        parameters: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let problem = self.approached(spec)?.0;
        let setup = wingbeat_ocp::OptimalControl::setup(&problem);
        problem.defects(&nodes::trajectory(&setup, 1, points, parameters)?).map_err(broken)
    }

    /// Hands the roll-in of `[plan.roll_in]` on its first mesh to `see`, with the start of the first guess, in the units of its
    /// channels: objective, constraints and their derivatives, for any solver of nonlinear programs.
    ///
    /// # Errors
    /// A scenario without such a plan, or that does not fly up to its start.
    pub fn roll_in_program(&self, see: &mut dyn FnMut(&mut dyn Program, &[f64])) -> Result<(), Error> {
        let Some(PlanSpec::RollIn(spec)) = &self.spec.plan else {
            return Err(Error::invalid(KEY, "absent", "a [plan.roll_in]"));
        };
        self.approached(spec)?.0.see_program(see).map_err(broken)
    }

    /// The roll-in from the state to which the controller flies, and its settings with the time at which it does.
    fn approached(
        &self,
        spec: &RollInSpec,
    ) -> Result<(RollIn<'_, wingbeat_robot::Robot>, RollInSpec), Error> {
        let mut x = self.start_of(&self.model);
        let steps = (spec.start_s / self.schedule.step).round() as usize;
        let schedule = Schedule { steps, ..self.schedule };
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        let go_on = |_: &Sample, _: &(dyn Controller + '_)| Ok(ControlFlow::Continue(()));
        let flight =
            fly(model, &mut sensors, &mut *self.pilot(self.prepared.clone())?, &schedule, &mut x, go_on);
        flight.ending.check().map_err(broken)?;
        let spec = RollInSpec { start_s: steps as f64 * self.schedule.step, ..spec.clone() };
        let problem = RollIn::new(&self.model, &x, self.model.strokes(), &spec).map_err(|e| e.within(KEY))?;
        Ok((problem, spec))
    }

    /// Flies approach and planned inputs; the record, the last angles and how the flight ended.
    fn fly_plan(&self, solution: &Interpolant) -> Result<(Recorded, [f64; 3], Ending), Error> {
        let points = &solution.points;
        let (first, last) = (points.t[0], points.t[points.t.len() - 1]);
        // The approach must be the one that was planned from: the same steps.
        let step = self.schedule.step;
        let steps_per_sample = ((last - first) / SAMPLES as f64 / step).floor().max(1.0) as usize;
        let schedule = Schedule { steps: (last / step).ceil() as usize, steps_per_sample, ..self.schedule };
        let steps = schedule.steps;
        let mut player =
            Playback::new(self.pilot(self.prepared.clone())?, points.t.clone(), points.u.clone());
        let mut recorder = Recorder::new(
            &self.model,
            self.manoeuvre(),
            (&player, Vec::new()),
            steps / schedule.steps_per_sample + 1,
            None,
        )?;
        let mut x = self.start_of(&self.model);
        let (model, mut sensors) = (&self.model, Sensors::perfect(&self.model));
        let flight = fly(model, &mut sensors, &mut player, &schedule, &mut x, |sample, player| {
            recorder.sample(sample, player)?;
            Ok(ControlFlow::Continue(()))
        });
        let attitude = wingbeat_math::Quat::from_wxyz(&x[self.model.layout().attitude..]);
        Ok((recorder.finish(), attitude.matrix().roll_pitch_yaw().0, flight.ending))
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
            nose_up_deg: spec.nose_up_deg,
            yaw_rate_rad_s,
            track: Some(problem.track(&solution.points)),
        }));
        self.written(tracked).map_err(|e| Error::invalid("plan", e, "a scenario that TOML can hold"))
    }

    fn roll_in_summary(
        &self,
        spec: &RollInSpec,
        optimum: &Optimum,
        nodes: Option<&PlanNodes>,
    ) -> RollInSummary {
        let end = optimum.solution.as_ref().and_then(|s| s.points.t.last().copied());
        RollInSummary {
            solver: self.solver_numbers(optimum, nodes, self.model.inputs()),
            start_s: spec.start_s,
            duration_s: end.map(|t| t - spec.start_s),
            objective_s: Some(optimum.objective).filter(|objective| objective.is_finite()),
            starts: None,
            resimulation_error: BTreeMap::new(),
            final_angles_deg: None,
            flown_angles_deg: None,
            turned_deg: None,
            angular_momentum_change_kg_m2_s: None,
            least_clearance_m: None,
            drive_power_w: None,
            regulator_power_w: None,
            regulator_power_given_w: None,
            stall_fraction: None,
        }
    }
}
