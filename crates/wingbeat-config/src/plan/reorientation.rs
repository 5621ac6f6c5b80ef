//! The quickest way to another attitude, planned and flown open loop.

use super::roll_in::{RollInPlan, broken_at};
use super::{Planned, nodes};
use crate::chosen::Named;
use crate::{Chosen, Scenario, ScenarioSpec};
use std::ops::ControlFlow;
use wingbeat_flight::guide::{CommandsSpec, ReorientationSpec, RollIn};
use wingbeat_flight::simulate::Record;
use wingbeat_math::Error;
use wingbeat_math::order::filled;
use wingbeat_ocp::plant::Plant;
use wingbeat_ocp::{OptimalControl, Progress};
use wingbeat_robot::Robot;

/// Key of the plan.
const KEY: &str = "plan.reorientation";

impl Scenario {
    /// Plans the reorientation of `spec` from the scenario's start.
    pub(super) fn plan_reorientation(
        &self,
        spec: &ReorientationSpec,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let problem = self.turning(spec)?;
        self.plan_and_fly(&problem, &spec.roll_in(), KEY, observe)
    }

    /// The problem from the scenario's start.
    fn turning(&self, spec: &ReorientationSpec) -> Result<RollIn<'_, Robot>, Error> {
        let x = self.start_of(&self.model);
        RollIn::reorientation(&self.model, &x, self.model.strokes(), spec).map_err(|e| e.within(KEY))
    }

    /// [`plan_defects`](Self::plan_defects) of a reorientation.
    pub(super) fn reorientation_defects(
        &self,
        spec: &ReorientationSpec,
        points: &Record,
        parameters: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let problem = self.turning(spec)?;
        let plan = nodes::trajectory(&problem.setup(), 1, points, parameters)?;
        problem.defects(&plan).map_err(|fault| broken_at(KEY, fault))
    }

    /// This scenario with the plan's commands played in place of a plan and a controller.
    pub(super) fn played(&self, plan: &RollInPlan<'_>) -> Result<String, Error> {
        let points = &plan.solution.points;
        let step = self.schedule.step;
        let command = |(i, channel): (usize, &wingbeat_ocp::plant::Channel)| {
            (channel.name.clone(), points.u.iter().map(|u| u[i]).collect())
        };
        let commands = CommandsSpec {
            period_s: step,
            time_s: points.t.clone(),
            commands: filled(self.model.inputs().iter().enumerate().map(command)),
        };
        let mut played = ScenarioSpec { plan: None, ..self.spec.clone() };
        played.name = format!("{}-flown", self.spec.name);
        played.flight.duration_s = (points.t[points.t.len() - 1] / step).ceil() * step;
        let text = toml::Table::try_from(&commands).and_then(|keys| {
            played.controller = Some(Chosen::Own(Named { name: "commands".into(), keys }));
            self.written(played)
        });
        text.map_err(|e| Error::invalid("plan", e, "a scenario that TOML can hold"))
    }
}
