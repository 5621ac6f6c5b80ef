//! The gait of least power, planned and replayed on the stand.

use super::gait_record::{Replay, beside, cycle_mean, means, stalled};
use super::{CHECK_STEPS, PlanNodes, PlanSummary, Planned, SolverNumbers, nodes, verdict};
use crate::summary::PartClearance;
use crate::{
    ClockSpec, CompareSpec, CoordinateSpec, HingeSpec, ReferenceSpec, Scenario, TableSpec, TetherSpec,
    TetheredBodySpec, TetheredWingSpec, WindSpec, stall, written,
};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::ops::ControlFlow;
use wingbeat_aero::{LoadSource, Preset};
use wingbeat_flight::guide::{CYCLES, Flapping, LeastPower, LeastPowerSpec, Means, Stand};
use wingbeat_flight::simulate::Record;
use wingbeat_flight::tether::{HingeKind, Side};
use wingbeat_judge::{Judge, Status};
use wingbeat_math::Error;
use wingbeat_math::order::filled;
use wingbeat_math::{Vec3, pitch_of_nose_up};
use wingbeat_ocp::plant::{Fault, Plant};
use wingbeat_ocp::{Interpolant, OptimalControl, Optimum, Progress};
use wingbeat_robot::WingSpec;

/// Steps per cycle of the tethered replay.
const TETHER_STEPS: usize = 800;
/// Hinges of the left wing from body to tip: name, kind, true at the elbow.
const HINGES: [(&str, HingeKind, bool); 4] = [
    ("sweep", HingeKind::Sweep, false),
    ("shoulder", HingeKind::Flap, false),
    ("elbow", HingeKind::Fold, true),
    ("twist", HingeKind::Twist, true),
];

/// A gait with its means.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct GaitNumbers {
    /// Flapping frequency, Hz.
    pub frequency_hz: f64,
    /// Pitch, deg; negative is nose up.
    pub pitch_deg: f64,
    /// Means over the cycle.
    #[serde(flatten)]
    pub means: Means,
}

/// `summary.json` of a planned gait of least power.
#[derive(Clone, Debug, Serialize)]
pub struct LeastPowerSummary {
    /// How the solver fared.
    #[serde(flatten)]
    pub solver: SolverNumbers,
    /// Drive power and cost of effort, W.
    pub objective_w: Option<f64>,
    /// Share of negative joint power that is stored.
    pub storage: f64,
    /// Mean upward and forward force asked for, N.
    pub asked_up_n: f64,
    /// Mean forward force asked for, N.
    pub asked_forward_n: f64,
    /// Weight of the robot, N.
    pub weight_n: f64,
    /// The plan.
    pub plan: Option<GaitNumbers>,
    /// Mean drive power of the plan with the sharp corner of its losses, W: the solver rounds it off.
    pub plan_unrounded_power_w: Option<f64>,
    /// Upward force of the replay by source, N, cycle means; drag of the body beside.
    pub replay_up_by_source_n: BTreeMap<String, f64>,
    /// The same replay under preset `full`, or `paper` where the plan is of `full`.
    pub replay_other: Option<OtherReplay>,
    /// The plan's inputs simulated from rest with both wings until periodic.
    pub replay: Option<Means>,
    /// Least of all clearances over the last cycle of that replay, m.
    pub least_clearance_m: Option<f64>,
    /// The same of the robot's own gait, actuators at rest.
    pub own_least_clearance_m: Option<f64>,
    /// Mean share of the strips past stall over the last cycle of that replay.
    pub stall_fraction: Option<f64>,
    /// The same of the robot's own gait.
    pub own_stall_fraction: Option<f64>,
    /// Largest difference of a state over the last cycle of that replay, in its own unit.
    pub replay_closure: Option<f64>,
    /// The robot's own gait, actuators at rest.
    pub own: GaitNumbers,
    /// Largest distance of a re-simulation over one cycle from the plan: each state by name, in its unit.
    pub resimulation_error: BTreeMap<String, f64>,
}

/// A replay under another aerodynamic model than that of the plan.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct OtherReplay {
    /// Its preset.
    pub preset: &'static str,
    /// Means over the cycle.
    #[serde(flatten)]
    pub means: Means,
}

/// A plan that meets its constraints.
struct LeastPowerPlan<'a> {
    problem: &'a LeastPower<'a>,
    storage: f64,
    own: Flapping,
    solution: &'a Interpolant,
    nodes: &'a PlanNodes,
}

/// A gait of which the model cannot be evaluated.
fn broken(fault: Fault) -> Error {
    Error::invalid("plan.least_power", fault, "a range in which the model can be evaluated")
}

impl Scenario {
    /// Plans the gait of `spec` with the body carried as the scenario starts.
    pub(super) fn plan_least_power(
        &self,
        spec: &LeastPowerSpec,
        observe: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Result<Planned, Error> {
        let problem = self.least_power_problem(spec)?;
        let own = Flapping {
            frequency_hz: self.model.frequency_hz(),
            pitch: pitch_of_nose_up(self.spec.start.nose_up_deg),
        };
        let optimum = problem.plan(observe).map_err(broken)?;
        let nodes = nodes::nodes(&problem, &optimum, "W")?;
        let mut summary = self.least_power_summary(spec, &problem, &own, &optimum, nodes.as_ref());
        let mut judge = self.judge_of_plan();
        let met = verdict::judge_solver(&mut judge, &optimum, spec.tolerance);
        let (mut record, mut files) = (None, Vec::new());
        if let (true, Some(solution), Some(nodes)) = (met, &optimum.solution, &nodes) {
            let plan = LeastPowerPlan { problem: &problem, storage: spec.storage, own, solution, nodes };
            match self.replayed(&plan, &mut summary, &mut judge)? {
                Ok((cycle, own)) => {
                    files = self.replay_case(&problem.flapping(&solution.points), &cycle)?;
                    record = Some(beside(&cycle, &own)?);
                }
                Err(fault) => judge.find(Status::Failed, format!("replayed from rest: {fault}")),
            }
        }
        summary.solver.verdict = judge.verdict();
        Ok(Planned { record, nodes, summary: PlanSummary::LeastPower(Box::new(summary)), files })
    }

    /// The problem of `spec`, the body carried as the scenario starts.
    fn least_power_problem(&self, spec: &LeastPowerSpec) -> Result<LeastPower<'_>, Error> {
        let start = &self.spec.start;
        if start.roll_deg != 0.0 {
            return Err(Error::invalid("start.roll_deg", start.roll_deg, "0: both wings move alike"));
        }
        let [low, high] = spec.frequency_hz;
        if let Some([least, most]) = self.model.residual_frequencies().filter(|[l, m]| low < *l || high > *m)
        {
            let allowed = format!("{least:.4} to {most:.4}, where robot.residual was measured");
            return Err(Error::invalid("plan.least_power.frequency_hz", format!("[{low}, {high}]"), allowed)
                .against(["robot.residual.frequency_hz"]));
        }
        let (pitch, yaw) = (pitch_of_nose_up(start.nose_up_deg), start.yaw_deg.to_radians());
        let stand = Stand::new(&self.model, Vec3(start.velocity_m_s), yaw)?;
        LeastPower::new(stand, pitch, spec).map_err(|e| e.within("plan.least_power"))
    }

    /// Simulates a plan that meets its constraints, and the robot's own gait, from rest, and judges the plan: the last cycle of
    /// each.
    fn replayed(
        &self,
        plan: &LeastPowerPlan<'_>,
        summary: &mut LeastPowerSummary,
        judge: &mut Judge,
    ) -> Result<Result<(Record, Record), Fault>, Error> {
        let LeastPowerPlan { problem, storage, own, solution, nodes } = plan;
        let flapping = problem.flapping(&solution.points);
        summary.plan = Some(numbers(&flapping, problem.means(&solution.points)));
        summary.plan_unrounded_power_w = problem.unrounded_power(solution).ok();
        match solution.resimulate(*problem, CHECK_STEPS) {
            Ok(errors) => {
                let states = problem.setup().states.into_iter().map(|channel| channel.name);
                summary.resimulation_error = filled(states.zip(errors));
            }
            Err(fault) => judge.find(Status::Failed, format!("re-simulated: {fault}")),
        }
        verdict::judge_plan(judge, &summary.solver, &summary.resimulation_error, nodes);
        let replay = |flapping, commands: &dyn Fn(f64, &mut [f64])| {
            Replay { stand: problem.stand(), flapping, commands, storage: *storage }.record()
        };
        let commands = |t: f64, u: &mut [f64]| u.copy_from_slice(&solution.at(t).1);
        let (record, closure, stalled_strips) = match replay(flapping, &commands) {
            Ok(replayed) => replayed?,
            Err(fault) => return Ok(Err(fault)),
        };
        let (own_record, ..) = match replay(*own, &|_, u| u.fill(0.0)) {
            Ok(replayed) => replayed?,
            Err(fault) => return Ok(Err(fault)),
        };
        summary.replay_up_by_source_n = upward(&record, flapping.pitch);
        summary.replay_other = self.replay_other(flapping, &commands, *storage);
        (summary.replay, summary.replay_closure) = (Some(means(&record)), Some(closure));
        (summary.stall_fraction, summary.own_stall_fraction) =
            (Some(stalled(&record)), Some(stalled(&own_record)));
        let crossing = |record| PartClearance::new(record, self.model.clearances());
        let least = |record| crossing(record).map(|c| c.least_m);
        (summary.least_clearance_m, summary.own_least_clearance_m) = (least(&record), least(&own_record));
        stall::hold(judge, &stalled_strips, "aero.law");
        summary.judge_replayed(judge, self.model.mass(), crossing(&record).as_ref());
        Ok(Ok((record, own_record)))
    }

    /// [`plan_defects`](Self::plan_defects) of a gait.
    pub(super) fn least_power_defects(
        &self,
        spec: &LeastPowerSpec,
        points: &Record,
        parameters: &[f64],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let problem = self.least_power_problem(spec)?;
        let unknowns = nodes::trajectory(&problem.setup(), problem.rows_of_interval(), points, parameters)?;
        problem.defects(&unknowns).map_err(broken)
    }

    /// The commands on the same robot under the other preset; none where that cannot be built or evaluated, or
    /// where a wrench belongs to the model.
    fn replay_other(
        &self,
        flapping: Flapping,
        commands: &dyn Fn(f64, &mut [f64]),
        storage: f64,
    ) -> Option<OtherReplay> {
        let preset = if self.spec.aero.preset == Preset::Full { Preset::Paper } else { Preset::Full };
        if self.spec.robot.residual.is_some() {
            return None;
        }
        let document = self.document.clone().set(format!("aero.preset=\"{}\"", preset.name()));
        let other = Scenario::new(document).ok()?;
        let start = &self.spec.start;
        let stand = Stand::new(&other.model, Vec3(start.velocity_m_s), start.yaw_deg.to_radians()).ok()?;
        let (record, ..) = Replay { stand: &stand, flapping, commands, storage }.record().ok()?.ok()?;
        Some(OtherReplay { preset: preset.name(), means: means(&record) })
    }

    fn least_power_summary(
        &self,
        spec: &LeastPowerSpec,
        problem: &LeastPower,
        own: &Flapping,
        optimum: &Optimum,
        nodes: Option<&PlanNodes>,
    ) -> LeastPowerSummary {
        let [asked_up_n, asked_forward_n] = problem.asked();
        LeastPowerSummary {
            solver: self.solver_numbers(optimum, nodes, &problem.setup().inputs),
            objective_w: Some(optimum.objective).filter(|objective| objective.is_finite()),
            storage: spec.storage,
            asked_up_n,
            asked_forward_n,
            weight_n: self.model.mass() * wingbeat_math::GRAVITY,
            plan: None,
            plan_unrounded_power_w: None,
            replay_up_by_source_n: BTreeMap::new(),
            replay_other: None,
            replay: None,
            least_clearance_m: None,
            own_least_clearance_m: None,
            stall_fraction: None,
            own_stall_fraction: None,
            replay_closure: None,
            own: numbers(own, problem.own_means()),
            resimulation_error: BTreeMap::new(),
        }
    }

    /// The planned motion of the wing as a case for `wingbeat tether`, with its table of angles.
    fn replay_case(
        &self,
        flapping: &Flapping,
        record: &Record,
    ) -> Result<Vec<(&'static str, String)>, Error> {
        let broken = |what: String| Error::invalid("plan", what, "a case that TOML can hold");
        let Some(wing) = &self.spec.robot.wing else { return Ok(Vec::new()) };
        let mut tethered = self.tethered(wing, flapping);
        // The case is of the wing alone: what other surfaces have counts for nothing.
        if let Some((_, model)) = self.model.surfaces().find(|(name, _)| *name == "wing") {
            tethered.aero.full.alone(model);
        }
        let case = written::toml(&tethered).map_err(|e| broken(e.to_string()))?;
        let columns: Vec<&[f64]> = std::iter::once("t".into())
            .chain(HINGES.map(|(name, _, _)| format!("{name}_left")))
            .map(|name| record.values(&name).ok_or_else(|| broken(name)))
            .collect::<Result<_, _>>()?;
        let mut table = String::from("t,sweep,shoulder,elbow,twist\n");
        for row in 0..record.rows() {
            let angles = columns[1..].iter().map(|c| c[row].to_degrees());
            let line: Vec<String> =
                std::iter::once(columns[0][row]).chain(angles).map(|v| v.to_string()).collect();
            let _ = writeln!(table, "{}", line.join(","));
        }
        Ok(vec![("tether.toml", case), ("joints.csv", table)])
    }

    fn tethered(&self, wing: &WingSpec, flapping: &Flapping) -> TetherSpec {
        let (air, start) = (&self.spec.air, &self.spec.start);
        let mut planform = wing.planform.clone();
        for station in &mut planform {
            station.leading_edge_m += wing.planform_shift_m;
            station.trailing_edge_m += wing.planform_shift_m;
        }
        let root = wing.shoulder_m[1];
        let table = |name: &str| TableSpec::repeating("joints.csv".into(), name);
        let hinge = |(name, kind, outer): (&str, HingeKind, bool)| HingeSpec {
            name: name.into(),
            kind,
            side: Side::Both,
            arc_m: if outer { root + wing.proximal.length_m } else { root },
            to_arc_m: None,
            ahead_m: 0.0,
            angle_deg: CoordinateSpec::Table(table(name)),
        };
        let against = Vec3(start.velocity_m_s) - Vec3(air.wind_m_s);
        let along = against[0].hypot(against[1]);
        TetherSpec {
            limits: Default::default(),
            name: format!("{}-tethered", self.spec.name),
            wing: TetheredWingSpec {
                planform,
                side: Side::Both,
                cd0: Some(wing.cd0),
                cd90: Some(wing.cd90),
                section: wing.section,
                membrane: wing.membrane.clone(),
                flap: wing.flap,
                hinges: HINGES.map(hinge).into(),
                gaps: Vec::new(),
            },
            spar: None,
            body: TetheredBodySpec {
                nose_up_deg: CoordinateSpec::Constant(-flapping.pitch.to_degrees()),
                ..TetheredBodySpec::default()
            },
            wind: WindSpec {
                speed_m_s: against.norm(),
                incidence_deg: (-against[2]).atan2(along).to_degrees(),
                sideslip_deg: 0.0,
                density_kg_m3: air.density_kg_m3,
                ground_m: None,
            },
            aero: self.spec.aero.clone(),
            time: ClockSpec {
                frequency_hz: flapping.frequency_hz,
                cycles: CYCLES,
                steps_per_cycle: TETHER_STEPS,
            },
            reference: ReferenceSpec::default(),
            compare: CompareSpec::default(),
            numbers: self.spec.robot.numbers.clone(),
        }
    }
}

/// Mean upward force of each source over a recorded cycle, N, the body pitched by `pitch`.
fn upward(record: &Record, pitch: f64) -> BTreeMap<String, f64> {
    let (sine, cosine) = pitch.sin_cos();
    let up = |source: LoadSource| {
        let of = |axis: &str| cycle_mean(record, &format!("force_{}_{axis}", source.name()));
        (source.name().to_owned(), cosine * of("z") - sine * of("x"))
    };
    let air = LoadSource::ALL.into_iter().filter(|source| !["gravity", "inertia"].contains(&source.name()));
    filled(air.map(up))
}

fn numbers(flapping: &Flapping, means: Means) -> GaitNumbers {
    GaitNumbers { frequency_hz: flapping.frequency_hz, pitch_deg: flapping.pitch.to_degrees(), means }
}
