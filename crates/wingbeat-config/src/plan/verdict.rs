//! The verdict on a plan: how the solver ended, and what became of the plan when it was flown or replayed.

use super::nodes::PlanNodes;
use super::roll_in::RollInSummary;
use super::{LeastPowerSummary, SolverNumbers};
use crate::flight_verdict::velocity_at;
use crate::summary::PartClearance;
use std::collections::BTreeMap;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::limits::{flight, plan, trim};
use wingbeat_judge::{Judge, Status};
use wingbeat_ocp::interior_point::SolveStatus as Ended;
use wingbeat_ocp::{Misses, Optimum};

/// What an end of the solver makes of the plan, beside its numbers.
fn ended(end: &Ended) -> Option<Status> {
    match end {
        Ended::Solved | Ended::Acceptable => None,
        Ended::Infeasible { .. } => Some(Status::NotFound),
        Ended::IterationLimit | Ended::TimeLimit | Ended::CoarseMesh { .. } => Some(Status::NotResolved),
        Ended::NumericalTrouble { .. } | Ended::Unbounded => Some(Status::Failed),
        Ended::Stopped => Some(Status::Interrupted),
    }
}

/// Holds an optimum on its mesh against the limits; true when it is to be flown: it meets its constraints, and nobody waits for an end.
pub(super) fn judge_solver(judge: &mut Judge, optimum: &Optimum, tolerance: f64) -> bool {
    if let Some(status) = ended(&optimum.status) {
        let plan_on = optimum.solution.as_ref().map_or(0, |solution| solution.intervals());
        let on = match optimum.ended_on {
            mesh if plan_on > 0 && mesh != plan_on => {
                format!(
                    " on the mesh of {mesh} intervals; the plan and its numbers are those of {plan_on} intervals"
                )
            }
            _ => String::new(),
        };
        judge.find(status, format!("the solver ended: {}{on}", optimum.status));
    }
    let Some(Misses { infeasibility, residual, violation, constraint }) = &optimum.misses else {
        judge.find(Status::NotFound, "nothing could be evaluated");
        return false;
    };
    let missed = match constraint.as_str() {
        "" => String::new(),
        name => format!("({name} by {violation:.2e} in its unit)"),
    };
    let met = judge.hold_about(&plan::VIOLATION, *infeasibility, &missed);
    if met {
        judge.hold(&plan::RESIDUAL, *residual);
        judge.hold(&plan::INTERVAL_ERROR, optimum.error);
        judge.hold(&plan::OVER_TOLERANCE, optimum.error / tolerance);
        judge.hold_if(&plan::OBJECTIVE_CHANGE, objective_change(optimum));
    }
    met && optimum.status != Ended::Stopped
}

/// Relative change of the objective from the last mesh before that of the plan with an optimum; none of a single mesh.
fn objective_change(optimum: &Optimum) -> Option<f64> {
    let mut solved = optimum.passes.iter().rev().filter(|pass| pass.status.is_success());
    let last = solved.find(|pass| pass.objective == optimum.objective)?;
    let before = solved.next()?;
    Some((before.objective - last.objective).abs() / last.objective.abs().max(f64::MIN_POSITIVE))
}

/// Largest distance of a re-simulation from the plan, each state relative to 1 + its largest magnitude, as the error of an
/// interval is.
fn relative(errors: &BTreeMap<String, f64>, nodes: &PlanNodes) -> Option<f64> {
    let size = |name: &str| {
        let values = nodes.points.values(&name.replace(' ', "_")).unwrap_or_default();
        values.iter().fold(1.0, |size, value| f64::max(size, 1.0 + value.abs()))
    };
    // The largest that is no number stays one: NaN must not be lost.
    errors
        .iter()
        .map(|(name, error)| error / size(name))
        .reduce(|a, b| if a.is_nan() || a > b { a } else { b })
}

/// What is judged alike of every plan that meets its constraints.
pub(super) fn judge_plan(
    judge: &mut Judge,
    solver: &SolverNumbers,
    errors: &BTreeMap<String, f64>,
    nodes: &PlanNodes,
) {
    judge.hold_if(&plan::RESIMULATION, relative(errors, nodes));
    judge.hold_if(&plan::SATURATION, solver.saturated_fraction);
}

/// Speed below which a flight has none to keep, m/s (choice).
const LEAST_SPEED: f64 = 0.1;

impl RollInSummary {
    /// Largest difference of an angle between the planned and the flown end, deg.
    fn off(&self) -> Option<f64> {
        self.final_angles_deg.zip(self.flown_angles_deg).map(|(plan, flown)| {
            let apart = plan.iter().zip(flown).map(|(plan, flown)| angle_between(*plan, flown));
            // A number that is none stays one.
            apart.fold(0.0, |most: f64, off| if off > most || off.is_nan() { off } else { most })
        })
    }

    /// Holds the reorientation, as it was flown, against the limits.
    pub(super) fn judge_turned(&self, judge: &mut Judge, crossing: Option<&PartClearance>) {
        judge.hold_if(&plan::FLOWN, self.off());
        judge.hold_if(&flight::MOMENTUM, self.angular_momentum_change_kg_m2_s);
        if let Some(crossing) = crossing {
            crossing.hold(judge);
        }
    }

    /// Holds the roll-in, as it was flown from `record`'s row `first` on, against the limits.
    pub(super) fn judge_flown(
        &self,
        judge: &mut Judge,
        record: &Record,
        first: usize,
        crossing: Option<&PartClearance>,
    ) {
        judge.hold_if(&plan::FLOWN, self.off());
        let z = record.values("p_WB_z").and_then(|z| z.get(first..)).unwrap_or_default();
        let height = z.iter().map(|height| (height - z[0]).abs()).reduce(f64::max);
        judge.hold_if(&flight::ALTITUDE, height);
        let speed = |row| velocity_at(record, row).map(|velocity| velocity.norm());
        if let (Some(before), Some(after)) = (speed(first), speed(record.rows().saturating_sub(1))) {
            // A flight from rest has no speed to keep.
            judge.hold_if(&plan::SPEED, (before > LEAST_SPEED).then(|| (after / before - 1.0).abs()));
        }
        if let Some(crossing) = crossing {
            crossing.hold(judge);
        }
    }
}

/// Between two angles the short way round, deg.
fn angle_between(a: f64, b: f64) -> f64 {
    let off = (a - b).rem_euclid(360.0);
    off.min(360.0 - off)
}

impl LeastPowerSummary {
    /// Holds the gait, as it was replayed from rest, against the limits; `mass` is that of the robot, kg.
    pub(super) fn judge_replayed(&self, judge: &mut Judge, mass: f64, crossing: Option<&PartClearance>) {
        if let Some(means) = self.replay {
            let lacks = (self.asked_up_n - means.up_n).max(self.asked_forward_n - means.forward_n);
            judge.hold(&plan::REPLAYED, lacks.max(0.0) / self.weight_n);
            for limit in [&trim::POWER, &trim::HIGH_POWER] {
                judge.hold(limit, means.drive_power_w / mass);
            }
            if let Some(other) = self.replay_other {
                let change = (other.means.up_n - means.up_n).abs() / self.weight_n;
                judge.hold(&plan::MODELS, change);
            }
        }
        judge.hold_if(&plan::CLOSURE, self.replay_closure);
        if let Some(crossing) = crossing {
            crossing.hold(judge);
        }
    }
}
