//! The numbers of a flight that are compared.

use super::cost::CostSummary;
use super::dived::DiveSummary;
use super::estimate::{EstimateSummary, Estimated};
use super::flight_verdict::{JudgedFlight, mean_velocity};
use super::followed::PathSummary;
use super::governed::GovernedSummary;
use super::grounded::ground_distance;
use super::hinged::FlapSummary;
use super::hovered::HoverSummary;
use super::lattice::LatticeSummary;
use super::link_spar::LinkSparSummary;
use super::measure::Measured;
use super::perch::{PerchSpec, PerchSummary};
use super::pinned::PinSummary;
use super::planned::{PreparedSummary, ReducedPlanSummary};
use super::recorder::{FlightMeans, momentum_change};
use super::skin::MembraneSummary;
use super::sound;
use super::spec::GoalSpec;
use super::told_errors::{TrueErrors, Updates};
use super::turned;
use serde::Serialize;
use std::f64::consts::TAU;
use std::time::Duration;
use wingbeat_flight::guide::{Manoeuvre, PathSpec, Reference, angle_error};
use wingbeat_flight::simulate::{Cost, Flight, Record, whole_strokes};
use wingbeat_judge::limits::{flight, trim};
use wingbeat_judge::{Judge, Judged, RunLimits, Status, Warning};
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::Channel;
use wingbeat_robot::{Dryden, Robot};

/// `summary.json` of a flight. What is optional is taken from the goal's settling
/// time (2 s without a goal) on, and missing when the flight ended before.
/// Pitch is FLU: negative is nose up.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct Summary {
    /// The verdict: `ok`, `not_judged`, `off_target`, `outside`, `not_resolved`, `failed` or `interrupted`.
    #[schemars(skip)]
    pub status: Status,
    /// Why, when the status is not `ok`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What the status rests on: each value with its limit.
    #[schemars(skip)]
    pub judged: Vec<Judged>,
    /// What the goal asked and could not be judged, by key.
    pub not_judged: Vec<&'static str>,
    /// Number of records of the part that counts (dimensionless).
    #[serde(skip)]
    pub settled_records: usize,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Ratio of simulated to wall time.
    pub real_time_factor: f64,
    /// Travel along world x, m.
    pub distance_x_m: f64,
    /// Travel along world y, m; left is positive.
    pub distance_y_m: f64,
    /// Climb, m; negative is sink.
    pub altitude_change_m: f64,
    /// Mean ground speed, m/s.
    pub mean_speed_m_s: Option<f64>,
    /// Mean rate at which height is lost, m/s; negative in a climb.
    pub sink_rate_m_s: Option<f64>,
    /// Largest |height - reference| from the settling time on, at the updates of the controller, m; under `[controller.orbit]`. The true
    /// height counts, whatever the controller is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_max_error_m: Option<f64>,
    /// How well an estimator knew the flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub estimate: Option<EstimateSummary>,
    /// How well the path was followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathSummary>,
    /// What a dive took.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dive: Option<DiveSummary>,
    /// What became of the landing on a perch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perch: Option<PerchSummary>,
    /// How still the robot hovered.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hover: Option<HoverSummary>,
    /// Mean roll, deg.
    pub roll_mean_deg: Option<f64>,
    /// Mean roll over the whole cycles over which the mean bank that is asked is that of the turn, deg; where the settled flight holds other
    /// parts too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turn_roll_mean_deg: Option<f64>,
    /// Root mean square of roll minus reference, deg: that of the manoeuvre; without one that of the orbit at the same
    /// phase, at the updates; level without either.
    pub roll_rms_error_deg: Option<f64>,
    /// Largest |roll - reference|, deg.
    pub roll_max_error_deg: Option<f64>,
    /// Mean pitch, deg; negative is nose up.
    pub pitch_mean_deg: Option<f64>,
    /// Root mean square of pitch minus reference, deg, likewise.
    pub pitch_rms_error_deg: Option<f64>,
    /// Largest |pitch - reference|, deg.
    pub pitch_max_error_deg: Option<f64>,
    /// Half of the pitch range, deg.
    pub pitch_half_amplitude_deg: Option<f64>,
    /// Change of heading over the whole flight, deg; left is positive.
    pub yaw_change_deg: Option<f64>,
    /// What the flight cost: power of the joints, and what carried the weight.
    #[serde(flatten)]
    pub cost: CostSummary,
    /// What the record tells in [`measures`](super::measures).
    #[serde(flatten)]
    pub measured: Measured,
    /// Aerodynamic preset.
    pub aero_preset: String,
    /// How motion and vortex lattice were brought together, where one takes the place of the preset's attached flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lattice: Option<LatticeSummary>,
    /// Lift law.
    pub lift_law: String,
    /// Share of strips beyond the stall angle, over all samples; none of a flight that grew without bound.
    pub stall_fraction: Option<f64>,
    /// Mean separated share of the flow over strips and samples, likewise.
    pub separated_fraction: Option<f64>,
    /// Mean share of the linear leading-edge suction that law `lev` takes away, likewise.
    pub suction_lost_fraction: Option<f64>,
    /// Membranes: largest rise over the chord, slack share, frequency of the gait over theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub membrane: Option<MembraneSummary>,
    /// Flaps: largest angle, and that by their weight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flap: Option<FlapSummary>,
    /// Spars: largest angle between two pieces, error by their number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spar: Option<LinkSparSummary>,
    /// Springs on pins of the linkage: largest deflection from rest, that over its limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pin_springs: Option<PinSummary>,
    /// Means of the states that the flown laws declare; not part of the file.
    #[serde(skip)]
    pub law_states: Vec<LawState>,
    /// Share of the samples in which the wings are beyond the velocities at which `robot.residual` was measured, where its wrench stays as
    /// it is at their ends. Missing without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beyond_residual_fraction: Option<f64>,
    /// Share of input samples within 1 % of their range of a limit.
    pub input_saturation_fraction: f64,
    /// Least of all clearances over the records of the whole flight, m; negative where parts pass through each
    /// other, or a wing through the middle plane. Missing for a robot without clearances.
    pub least_clearance_m: Option<f64>,
    /// Between what it is, where it is the same all the time.
    #[serde(skip)]
    pub constant_clearance: Option<String>,
    /// How the clearance that the controller is asked to keep was kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub governed: Option<GovernedSummary>,
    /// How well a plan that leaves out the structure foretold the flight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<ReducedPlanSummary>,
    /// How far what was found lay from what updates were prepared for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prepared: Option<PreparedSummary>,
    /// Share of the records in which a clearance is below zero.
    pub crossing_fraction: Option<f64>,
    /// Least distance of the body's origin and of the wings from `air.ground_m`, m; negative where something passes through it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground_distance_m: Option<f64>,
    /// Largest change of the angular momentum about the centre of mass, kg m2/s, in a vacuum, where nothing can change it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angular_momentum_change_kg_m2_s: Option<f64>,
    /// Error of the integration in the last position, m: as the most that the errors of steps may do, measured by halved steps at instants
    /// of the flight, if nothing damps or amplifies them. Where that is beyond the limits, or `flight.error_m` is given under a controller,
    /// it is the distance to the end of a second flight in finer steps, with all that a closed loop makes of it; a controller of the
    /// caller's own is not flown twice.
    pub step_error_m: Option<f64>,
    /// Steps that `flight.error_m` made it take.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steps_taken: Option<usize>,
    /// Time of the inertance of springs, s: see `flight.inertance_s`. Missing where they have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertance_s: Option<f64>,
    /// What a reader must know.
    #[schemars(skip)]
    pub warnings: Vec<Warning>,
    /// Controller timing and failures.
    pub controller: ControllerSummary,
}

/// Mean over strips and samples of a state that a lift law declares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawState {
    /// What it is.
    pub meaning: &'static str,
    /// Unit; empty when it is a share.
    pub unit: &'static str,
    /// The mean, in `unit`.
    pub mean: f64,
}

/// Timing and failures of the controller.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct ControllerSummary {
    /// Updates asked for.
    pub updates: usize,
    /// Updates that failed and kept the previous plan.
    pub failures: usize,
    /// Updates that took longer than the period by the wall clock, or missed their deadline and kept the previous
    /// plan.
    pub late: usize,
    /// Those of them that missed their deadline.
    pub dropped: usize,
    /// Time between updates, s; none without a controller.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Wall time of an update, microseconds.
    pub median_us: f64,
    /// The same at the 99th percentile.
    pub p99_us: f64,
    /// The same at the 99.9th percentile.
    pub p999_us: f64,
    /// Longest, microseconds.
    pub max_us: f64,
    /// Wall time from a measurement to its commands, microseconds: less than an update where updates are prepared.
    pub answer_median_us: f64,
    /// The same at the 99.9th percentile.
    pub answer_p999_us: f64,
}

impl ControllerSummary {
    /// Order statistics of the update times.
    pub fn new(flight: &Flight, period_s: Option<f64>) -> Self {
        let ascending = |times: &[Duration]| {
            let mut us: Vec<f64> = times.iter().map(|d| d.as_secs_f64() * 1e6).collect();
            wingbeat_math::order::ascend(&mut us);
            us
        };
        let [us, answers] = [&flight.updates, &flight.answers].map(|times| ascending(times));
        let among = |us: &[f64], q: f64| match us.len() {
            0 => 0.0,
            n => us[((n as f64 * q).ceil() as usize).clamp(1, n) - 1],
        };
        let quantile = |q: f64| among(&us, q);
        Self {
            updates: us.len(),
            failures: flight.failures,
            late: flight
                .late
                .max(us.iter().filter(|us| period_s.is_some_and(|period| **us > 1e6 * period)).count()),
            dropped: flight.late,
            period_s,
            median_us: quantile(0.5),
            p99_us: quantile(0.99),
            p999_us: quantile(0.999),
            max_us: quantile(1.0),
            answer_median_us: among(&answers, 0.5),
            answer_p999_us: among(&answers, 0.999),
        }
    }
}

/// The part of a flight's record that the summary averages.
pub(super) struct Settled<'a> {
    record: &'a Record,
    first: usize,
    /// Where there is a controller.
    pub truth: Option<TrueErrors<'a>>,
}

impl Settled<'_> {
    /// The samples of a column that count, in its unit; none of a column that is not there.
    pub fn column(&self, name: &str) -> &[f64] {
        self.record.values(name).map_or(&[], |v| &v[self.first.min(v.len())..])
    }
    /// Those of the last whole strokes, in its unit, over which powers are averaged; all where there is none.
    pub fn in_strokes(&self, name: &str) -> &[f64] {
        let first = whole_strokes(self.record, self.first).unwrap_or(self.first);
        self.record.values(name).map_or(&[], |v| &v[first.min(v.len())..])
    }
    /// The angle `name` minus its reference at every sample, rad: that of the manoeuvre, or of the orbit, or level.
    fn errors(&self, name: &str, context: &Context, angle: impl Fn(Reference) -> f64) -> Vec<f64> {
        if context.manoeuvre.is_none() {
            let about_orbit = self.truth.as_ref().and_then(|truth| truth.angle(name));
            if let Some(errors) = about_orbit.filter(|errors| !errors.is_empty()) {
                return errors;
            }
        }
        let samples = self.column(name).iter().zip(self.column("t"));
        samples.map(|(&is, &t)| angle_error(is, context.reference(t).map_or(0.0, &angle))).collect()
    }
    /// Mean roll in the turn, deg, of a flight with these errors of the roll, rad.
    fn turn_roll_deg(&self, errors: &[f64]) -> Option<f64> {
        let roll = self.column("roll");
        let asked: Vec<f64> = match self.column("orbit_roll_asked") {
            [] => roll.iter().zip(errors).map(|(is, error)| angle_error(*is, *error)).collect(),
            asked => asked.to_vec(),
        };
        turned::mean_roll(self.column("phase"), roll, &asked).map(f64::to_degrees)
    }
    /// Number of cycles of the gait that it holds, dimensionless, none of a single sample; missing where the gait stands still, and without
    /// samples.
    pub fn cycles(&self) -> Option<f64> {
        let turned = |phase: &[f64]| match phase {
            [first, .., last] => (last - first) / TAU,
            _ => 0.0,
        };
        let phase = self.column("phase");
        let moves = turned(self.record.values("phase")?) > 0.0;
        // A motor that stalls may turn back.
        (moves && !phase.is_empty()).then(|| turned(phase).max(0.0))
    }
    /// Mean of an angle, deg, from -180 to 180: of one that passes half a turn, the way that it goes.
    fn mean_deg(&self, name: &str) -> Option<f64> {
        let angles = self.column(name);
        let first = *angles.first()?;
        let (mut turns, mut before) = (0.0, first);
        let whole = |&angle: &f64| {
            turns -= ((angle - before) / TAU).round();
            before = angle;
            angle + turns * TAU
        };
        let mean = mean(&angles.iter().map(whole).collect::<Vec<_>>())?;
        Some((mean - (mean / TAU).round() * TAU).to_degrees())
    }
}

/// Mean; missing where there are no values.
pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Mean of the positive part.
pub(super) fn given(power: &[f64]) -> Option<f64> {
    mean(&power.iter().map(|power| power.max(0.0)).collect::<Vec<f64>>())
}

fn rms_deg(errors: &[f64]) -> Option<f64> {
    let squares: Vec<f64> = errors.iter().map(|e| e * e).collect();
    mean(&squares).map(|m| m.sqrt().to_degrees())
}

fn largest_deg(errors: &[f64]) -> Option<f64> {
    errors.iter().map(|e| e.abs()).reduce(f64::max).map(f64::to_degrees)
}

fn half_range_deg(angles: &[f64]) -> Option<f64> {
    let low = angles.iter().copied().reduce(f64::min)?;
    let high = angles.iter().copied().reduce(f64::max)?;
    Some((0.5 * (high - low)).to_degrees())
}

/// What the summary needs beside record and flight.
pub(super) struct Context<'a> {
    pub manoeuvre: Option<&'a dyn Manoeuvre>,
    pub goal: Option<&'a GoalSpec>,
    pub limits: RunLimits,
    pub inputs: &'a [Channel],
    pub clearances: &'a [Channel],
    pub robot: &'a Robot,
    /// How motion and lattice were brought together, of a flight in one.
    pub lattice: Option<LatticeSummary>,
    /// Panels along chord and span, of a flight in a lattice.
    pub panels: Option<[usize; 2]>,
    /// Largest mean chord of a surface of strips, m.
    pub strips_chord_m: Option<f64>,
    pub preset: String,
    pub law: String,
    /// Means over all samples; none of a flight whose last samples were cut off.
    pub means: Option<&'a FlightMeans>,
    /// Time between updates of the controller, s.
    pub period_s: Option<f64>,
    /// Estimate of the error of the steps, m, and what was asked.
    pub step_error_m: Option<f64>,
    pub asked_error_m: Option<f64>,
    /// Distance from where a flight in finer steps ends, m.
    pub grown_error_m: Option<f64>,
    /// The perch beside the flight.
    pub perch: Option<&'a PerchSpec>,
    /// The path to follow.
    pub path: Option<&'a PathSpec>,
    /// Turbulence of the air, and its steady wind, m/s.
    pub turbulence: Option<Dryden>,
    /// Whether gusts are added to it.
    pub gusty: bool,
    pub wind: Vec3,
}

impl Context<'_> {
    fn reference(&self, t: f64) -> Option<Reference> {
        self.manoeuvre.map(|m| m.reference(t))
    }
}

/// Start of the means where no goal says it, s; half of a flight at most.
const SETTLE: f64 = 2.0;

impl Summary {
    pub(super) fn new(record: &Record, flight: &Flight, context: &Context) -> Self {
        let settle = context.goal.map_or(SETTLE.min(0.5 * flight.duration), |g| g.settle_s);
        // Of a flight whose numbers grew without bound no means are taken, and the way is that before.
        let grew = context.means.is_none();
        let t = record.values("t").unwrap_or_default();
        let first = if grew { t.len() } else { t.partition_point(|&t| t < settle) };
        let updates = context.period_s.map(|period| Updates { period, count: flight.updates.len() });
        let truth = updates.map(|updates| TrueErrors::new(record, first..record.rows(), updates));
        let settled = Settled { record, first, truth };
        let crossing = PartClearance::new(record, context.clearances);
        let mut summary = Self::of_run(flight, context)
            .with_way(&settled, crossing.as_ref(), context)
            .with_attitude(&settled, context);
        summary.settled_records = record.rows().saturating_sub(first);
        if let Some(means) = context.means {
            summary = summary.with_means(means);
        }
        if let Some(updates) = updates {
            summary = summary.with_guidance(&settled, updates, context);
        }
        let flown = JudgedFlight {
            summary: &summary,
            record,
            flight,
            context,
            crossing: crossing.as_ref(),
            first: settled.first,
            cycles: settled.cycles(),
        };
        let (verdict, not_judged) = flown.judged(&context.limits);
        (summary.status, summary.reason) = (verdict.status, verdict.reason);
        (summary.judged, summary.not_judged) = (verdict.judged, not_judged);
        summary.warnings = verdict.warnings;
        if summary.warnings.iter().any(|warning| warning.id == flight::VERTICAL.id) {
            summary.leave_out_attitude();
        }
        summary.warnings.extend(grew.then(|| sound::left_out(t.last().copied())));
        summary
    }

    /// How it ran, and in which models.
    fn of_run(flight: &Flight, context: &Context) -> Self {
        let errors = [context.step_error_m, context.grown_error_m];
        Self {
            status: Status::Ok,
            duration_s: flight.duration,
            real_time_factor: flight.duration / flight.wall.as_secs_f64(),
            aero_preset: context.preset.clone(),
            lattice: context.lattice,
            lift_law: context.law.clone(),
            step_error_m: errors.into_iter().flatten().reduce(f64::max),
            steps_taken: flight.taken.map(|taken| taken.steps),
            inertance_s: Some(context.robot.inertance_s()).filter(|time| *time > 0.0),
            controller: ControllerSummary::new(flight, context.period_s),
            ..Self::default()
        }
    }

    /// The same with what the record shows of its way, its cost, its inputs and its clearances.
    fn with_way(self, settled: &Settled, crossing: Option<&PartClearance>, context: &Context) -> Self {
        let record = settled.record;
        let change = |name| match record.values(name) {
            Some([first, .., last]) => last - first,
            _ => f64::NAN,
        };
        let (speed, climb) = mean_velocity(record, settled.first, Vec3::ZERO).unzip();
        Self {
            distance_x_m: change("p_WB_x"),
            distance_y_m: change("p_WB_y"),
            altitude_change_m: change("p_WB_z"),
            mean_speed_m_s: speed,
            sink_rate_m_s: climb.map(|climb| -climb),
            cost: CostSummary::new(Cost::of_record(record, settled.first), context.robot),
            measured: Measured::new(settled),
            perch: context.perch.and_then(|perch| PerchSummary::new(record, perch)),
            input_saturation_fraction: saturation(record, context.inputs),
            plan: ReducedPlanSummary::new(record),
            prepared: PreparedSummary::new(record),
            least_clearance_m: crossing.map(|c| c.least_m),
            constant_clearance: crossing.and_then(PartClearance::constant),
            governed: crossing.and_then(|c| GovernedSummary::new(record, c.least_m, self.controller.updates)),
            crossing_fraction: crossing.map(|c| c.fraction),
            ground_distance_m: context.robot.ground().and_then(|ground| ground_distance(record, ground)),
            angular_momentum_change_kg_m2_s: momentum_change(record),
            ..self
        }
    }

    /// The same with its angles.
    fn with_attitude(self, settled: &Settled, context: &Context) -> Self {
        let roll_errors = settled.errors("roll", context, |reference| reference.roll);
        let pitch_errors = settled.errors("pitch", context, |reference| reference.pitch);
        Self {
            roll_mean_deg: settled.mean_deg("roll"),
            // A half loop to a perch ends with half a turn of roll, and is no turn.
            turn_roll_mean_deg: settled.turn_roll_deg(&roll_errors).filter(|_| context.perch.is_none()),
            roll_rms_error_deg: rms_deg(&roll_errors),
            roll_max_error_deg: largest_deg(&roll_errors),
            pitch_mean_deg: settled.mean_deg("pitch"),
            pitch_rms_error_deg: rms_deg(&pitch_errors),
            pitch_max_error_deg: largest_deg(&pitch_errors),
            pitch_half_amplitude_deg: half_range_deg(settled.column("pitch")),
            yaw_change_deg: settled.record.values("yaw").map(|yaw| unwrapped_change(yaw).to_degrees()),
            ..self
        }
    }

    /// The same with the means over its samples.
    fn with_means(self, means: &FlightMeans) -> Self {
        Self {
            stall_fraction: Some(means.stalled.stalled()),
            separated_fraction: Some(means.separated_fraction),
            suction_lost_fraction: Some(means.suction_lost_fraction),
            membrane: means.membrane,
            flap: means.flap,
            spar: means.spar,
            pin_springs: means.pin_springs,
            law_states: means.law_states.clone(),
            beyond_residual_fraction: means.beyond_residual_fraction,
            ..self
        }
    }

    /// The same with how a controller that is asked at `updates` led it.
    fn with_guidance(self, settled: &Settled, updates: Updates, context: &Context) -> Self {
        let (record, truth) = (settled.record, settled.truth.as_ref());
        let height = truth.and_then(TrueErrors::height);
        let estimated = Estimated::new(record, settled.first, updates);
        let dive = DiveSummary::new(record, 1.0 / context.robot.frequency_hz(), context.wind, updates);
        Self {
            height_max_error_m: height.and_then(|off| off.iter().map(|e| e.abs()).reduce(f64::max)),
            path: truth.zip(context.path).and_then(|(truth, path)| PathSummary::new(truth, path)),
            dive: dive.filter(|_| context.means.is_some()),
            hover: truth.and_then(|truth| HoverSummary::new(record, settled.first, truth)),
            estimate: estimated.as_ref().and_then(Estimated::summary),
            ..self
        }
    }

    /// Leaves out angles of which nothing can be said where the nose passes the vertical. What was judged of them stays, and the largest errors,
    /// which say that the flight was lost.
    fn leave_out_attitude(&mut self) {
        let angles = [
            &mut self.roll_mean_deg,
            &mut self.turn_roll_mean_deg,
            &mut self.roll_rms_error_deg,
            &mut self.pitch_mean_deg,
            &mut self.pitch_rms_error_deg,
            &mut self.pitch_half_amplitude_deg,
            &mut self.yaw_change_deg,
        ];
        angles.into_iter().for_each(|angle| *angle = None);
    }

    /// True when the whole duration was flown.
    pub fn completed(&self) -> bool {
        self.status < Status::Failed
    }
}

/// Sum of the steps of an angle, each the short way round.
fn unwrapped_change(angles: &[f64]) -> f64 {
    angles.windows(2).map(|a| angle_error(a[1], a[0])).sum()
}

/// Part of its range within which an input counts as on a limit.
const LIMIT_BAND: f64 = 0.01;

/// Share of input samples within 1 % of their range of a limit.
pub(super) fn saturation(record: &Record, inputs: &[Channel]) -> f64 {
    let (mut on, mut all) = (0, 0);
    for input in inputs {
        let (values, band) =
            (record.values(&input.name).unwrap_or(&[]), LIMIT_BAND * (input.high - input.low));
        all += values.len();
        on += values.iter().filter(|&&v| v <= input.low + band || v >= input.high - band).count();
    }
    on as f64 / (all as f64).max(1.0)
}

/// Change below which a clearance is the same all the time, m: rounding leaves 1e-17. *Choice.*
pub(super) const SAME: f64 = 1e-9;

/// The least clearance of parts that do not pass through each other, m: what its skins may close.
pub(super) fn touching(least: f64) -> Option<f64> {
    Some(least).filter(|least| *least >= 0.0)
}

/// What the clearance of this name is between, in words.
pub(super) fn apart(name: &str) -> String {
    let parts = name.trim_start_matches("clearance_").replace('_', " ");
    parts.strip_suffix(" middle").map_or(parts.clone(), |wing| format!("{wing} to middle plane"))
}

/// How close the parts of a robot come over a record.
pub(super) struct PartClearance {
    /// Least of all clearances, m.
    pub least_m: f64,
    /// Share of the rows in which one is below zero.
    pub fraction: f64,
    /// The clearance that is the least.
    name: String,
    /// Whether that one stays the same.
    is_constant: bool,
}

impl PartClearance {
    /// Of the columns `clearances`; none where there are no rows or columns.
    pub fn new(record: &Record, clearances: &[Channel]) -> Option<Self> {
        Self::since(record, clearances, f64::NEG_INFINITY)
    }

    /// The same from the time `start` (s) on.
    pub fn since(record: &Record, clearances: &[Channel], start: f64) -> Option<Self> {
        let t = record.values("t")?;
        let first = t.partition_point(|&t| t < start);
        let columns = clearances.iter().filter_map(|c| Some((&c.name, &record.values(&c.name)?[first..])));
        let columns: Vec<(&String, &[f64])> = columns.collect();
        let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        let (name, values, least_m) = columns
            .iter()
            .map(|(name, values)| ((*name).clone(), *values, least(values)))
            .min_by(|a, b| a.2.total_cmp(&b.2))?;
        let rows = t.len() - first;
        let crossing = (0..rows).filter(|&row| columns.iter().any(|(_, values)| values[row] < 0.0)).count();
        let is_constant = values.iter().all(|value| value - least_m < SAME);
        (rows > 0).then(|| Self { least_m, fraction: crossing as f64 / rows as f64, name, is_constant })
    }

    /// Between what it is, where it is the same all the time.
    fn constant(&self) -> Option<String> {
        self.is_constant.then(|| apart(&self.name))
    }

    /// Holds it against the limits, the same in every run of a robot: parts that pass through each other, and skins that touch.
    pub fn hold(&self, judge: &mut Judge) {
        let Self { least_m, name, .. } = self;
        judge.hold_about(
            &flight::CROSSING,
            self.fraction,
            &format!("({name} falls to {:.1} mm)", 1e3 * least_m),
        );
        judge.hold_if(&trim::SKIN, touching(*least_m));
    }
}
