//! The verdict on a flight: its goal, the limits of the task without one, and what a reader must know.

use super::plausible;
use super::spec::GoalSpec;
use super::stall;
use super::summary::{Context, PartClearance, Summary, mean};
use std::f64::consts::TAU;
use wingbeat_flight::simulate::{Cost, Ending, Flight, Record};
use wingbeat_judge::limits::{asked, flight, linkage, range, trim, wake};
use wingbeat_judge::{Judge, JudgedLimit, RunLimits, Status, Verdict, Warning};
use wingbeat_math::Vec3;
use wingbeat_ocp::plant::Fault;

/// A flight and what is judged of it.
pub(super) struct JudgedFlight<'a> {
    pub summary: &'a Summary,
    pub record: &'a Record,
    pub flight: &'a Flight,
    pub context: &'a Context<'a>,
    pub crossing: Option<&'a PartClearance>,
    /// First row that counts as settled.
    pub first: usize,
    /// Cycles of the gait from it on, where the gait moves.
    pub cycles: Option<f64>,
}

/// The verdict, and the keys of the goal that could not be judged.
pub(super) type FlightVerdict = (Verdict, Vec<&'static str>);

/// Duration from which the mean power of a flight is that of whole cycles, and the mean force of wings at rest that of a fall or a glide, s.
/// *Choice*: three cycles of the slowest gaits.
const LONG_ENOUGH: f64 = 1.0;

impl JudgedFlight<'_> {
    /// Judges by the goal, the task and the limits.
    pub fn judged(&self, limits: &RunLimits) -> FlightVerdict {
        let mut judge = Judge::new(limits);
        let mut not_judged = Vec::new();
        match self.broken() {
            Some((status, reason)) => judge.find(status, reason),
            None => {
                not_judged = self.goal(&mut judge);
                self.task(&mut judge);
                if let Some((spec, perch)) = self.context.perch.zip(self.summary.perch.as_ref()) {
                    perch.judge(spec, &mut judge);
                }
            }
        }
        self.model(&mut judge);
        (judge.verdict(), not_judged)
    }

    /// Why the flight ended before its time.
    fn broken(&self) -> Option<(Status, String)> {
        let shorter = || plausible::of_short_periods(self.context.robot, "a shorter flight.step_s");
        match self.flight.ending {
            Ending::Complete => None,
            Ending::Stopped => Some((Status::Interrupted, "stopped from outside".into())),
            Ending::Fault(Fault::NotRecorded { column, time }) => {
                let name =
                    self.record.columns().get(column).map_or("a column", |column| column.name.as_str());
                Some((Status::Failed, format!("{name} is not finite at t = {time:.4} s{}", shorter())))
            }
            Ending::Fault(fault) if fault.is_not_finite() => {
                Some((Status::Failed, format!("{fault}{}", shorter())))
            }
            Ending::Fault(fault) => {
                let text = format!("{fault}, after {:.4} s{}", self.flight.duration, shorter());
                Some((Status::Failed, text))
            }
        }
    }

    /// Judges by `[goal]`; returns the keys that could not be judged.
    fn goal(&self, judge: &mut Judge) -> Vec<&'static str> {
        let Some(goal) = self.context.goal else { return Vec::new() };
        let mut open = Vec::new();
        let mut why = "";
        for (limit, bound, value, reason) in self.asked(goal) {
            match value {
                Some(value) => _ = judge.hold_to(limit, bound, value),
                None => {
                    why = reason;
                    if open.last() != Some(&limit.id) {
                        open.push(limit.id);
                    }
                }
            }
        }
        if !open.is_empty() {
            let reason = format!("not judged: {}; {why}", open.join(", "));
            judge.warn(Warning::new("flight.goal_not_judged", &reason).key(open[0]));
            judge.find(Status::NotJudged, reason);
        }
        open
    }

    /// What the goal asks: limit, bound, value where there is one, and why there may be none.
    fn asked(&self, goal: &GoalSpec) -> Vec<(&'static JudgedLimit, f64, Option<f64>, &'static str)> {
        const UNSETTLED: &str = "the flight ended before the goal's settling time";
        let reference = self.context.manoeuvre.is_some();
        let angle = |value: Option<f64>| value.filter(|_| reference);
        let why = if reference { UNSETTLED } else { "without [manoeuvre] there is no reference to hold" };
        let summary = self.summary;
        let mut asked = vec![
            (&asked::ROLL, goal.roll_within_deg, angle(summary.roll_rms_error_deg), why),
            (&asked::PITCH, goal.pitch_within_deg, angle(summary.pitch_rms_error_deg), why),
        ];
        if let Some(within) = goal.altitude_within_m {
            asked.push((&asked::ALTITUDE, within, self.altitude_change(), UNSETTLED));
        }
        if let Some([low, high]) = goal.speed_between_m_s {
            asked.push((&asked::SLOWEST, low, summary.mean_speed_m_s, UNSETTLED));
            asked.push((&asked::FASTEST, high, summary.mean_speed_m_s, UNSETTLED));
        }
        if let Some(least) = goal.clearance_m {
            asked.push((&asked::CLEARANCE, least, summary.least_clearance_m, "the robot has no clearances"));
        }
        asked
    }

    /// Judges what the goal leaves open by what the controller is there for.
    fn task(&self, judge: &mut Judge) {
        let (summary, goal) = (self.summary, self.context.goal);
        if self.is_carried_by_air() {
            match self.weight_carried() {
                Some(carried) => _ = judge.hold(&flight::CARRIED, carried),
                None => judge.find(Status::NotJudged, NO_MEAN_FORCE),
            }
        }
        if self.context.period_s.is_none() {
            for limit in [&flight::FREE_PATH_ANGLE, &flight::FALLS] {
                judge.hold_if(limit, self.path_angle().filter(|_| self.context.perch.is_none()));
            }
            return;
        }
        let height = summary.height_max_error_m.filter(|_| summary.path.is_none());
        judge.hold_if(&flight::ALTITUDE, height);
        if self.tracks_attitude() && goal.is_none() {
            judge.hold_if(&flight::ATTITUDE, summary.roll_rms_error_deg);
            judge.hold_if(&flight::ATTITUDE, summary.pitch_rms_error_deg);
        }
        if let Some(governed) = &summary.governed {
            governed.judge(judge);
        }
        if let Some(prepared) = &summary.prepared {
            prepared.judge(judge);
        }
        if let Some(plan) = &summary.plan {
            plan.judge(judge);
        }
        match &summary.dive {
            Some(dive) => dive.judge(judge),
            None if self.record.values("orbit_dive").is_some() => {
                judge.find(
                    Status::NotResolved,
                    "the flight ends before its dive has begun and a cycle has passed",
                );
            }
            None => {}
        }
        judge.hold_if(&flight::PATH, summary.path.as_ref().map(|path| path.cross_max_m));
        judge.hold_if(&flight::PLACE, summary.hover.as_ref().map(|hover| hover.place_rms_m));
        let has_height = height.is_some() || summary.path.is_some() || summary.hover.is_some();
        let asks_height = goal.is_some_and(|goal| goal.altitude_within_m.is_some());
        if !has_height && !asks_height {
            judge.hold_if(&flight::PATH_ANGLE, self.path_angle());
        }
        if !self.context.inputs.is_empty() {
            judge.hold(&flight::SATURATION, summary.input_saturation_fraction);
        }
        if summary.controller.updates > 0 {
            let share = summary.controller.failures as f64 / summary.controller.updates as f64;
            judge.hold(&flight::FAILURES, share);
        }
    }

    /// True when there is an attitude to hold: that of an orbit, or of a manoeuvre that has had its time to settle.
    fn tracks_attitude(&self) -> bool {
        let orbit = self.record.values("orbit_roll_error").is_some();
        orbit || (self.context.manoeuvre.is_some() && self.flight.duration >= SETTLED)
    }

    /// Largest speed through the mean wind, m/s.
    fn largest_airspeed(&self) -> f64 {
        let wind = self.context.robot.wind_over_time().mean();
        let speed = |row| velocity_at(self.record, row).map_or(0.0, |v| (v - wind).norm());
        (0..self.record.rows()).map(speed).fold(0.0, f64::max)
    }

    /// Holds the flight against the range in which its model, its fit and its steps are good.
    fn model(&self, judge: &mut Judge) {
        plausible::hold(judge, self.context.robot);
        judge.hold_if(&linkage::CRANK_RATE, self.crank_rate_fraction());
        for limit in [&range::COMPRESSED, &range::MACH] {
            judge.hold(limit, self.largest_airspeed() / range::SOUND_M_S);
        }
        if let Some([chordwise, spanwise]) = self.context.panels {
            judge.hold(&wake::ALONG, chordwise as f64);
            judge.hold(&wake::FEW_ALONG, chordwise as f64);
            judge.hold(&wake::ACROSS, spanwise as f64);
            judge.hold(&wake::FEW_ACROSS, spanwise as f64);
            judge.hold_if(&wake::INFLOW, self.summary.lattice.map(|lattice| lattice.inflow_fraction));
        }
        if let Some(crossing) = self.crossing {
            crossing.hold(judge);
        }
        if let Some(beyond) = self.summary.beyond_residual_fraction {
            judge.hold(&flight::LEAVES_RESIDUAL, beyond);
            judge.hold(&flight::BEYOND_RESIDUAL, beyond);
        }
        if let Some(error) = self.summary.step_error_m {
            judge.hold(&flight::STEP_ERROR, error);
            judge.hold(&flight::STEPS_LOST, error);
            judge.hold_if(&flight::STEPS_ASKED, self.context.asked_error_m.map(|asked| error / asked));
        }
        judge.hold_if(&flight::GROUND, self.summary.ground_distance_m);
        // A perch turns the robot that hits it.
        let alone = self.context.perch.is_none();
        judge.hold_if(&flight::MOMENTUM, self.summary.angular_momentum_change_kg_m2_s.filter(|_| alone));
        if let Some(membrane) = self.summary.membrane {
            membrane.judge(judge);
        }
        if let Some(flap) = self.summary.flap {
            flap.judge(judge);
        }
        if let Some(spar) = self.summary.spar {
            spar.judge(judge);
        }
        if let Some(pins) = self.summary.pin_springs {
            pins.judge(judge);
        }
        judge.hold_if(&trim::PEAK, self.peak_power().map(|power| power / self.context.robot.mass()));
        if self.flight.duration >= LONG_ENOUGH {
            for limit in [&trim::POWER, &trim::HIGH_POWER] {
                judge.hold_if(limit, self.summary.cost.positive_power_w_kg);
            }
        }
        if let Some(turbulence) = &self.context.turbulence {
            let most = turbulence.deviation.into_iter().fold(0.0, f64::max);
            for limit in [&flight::TURBULENCE, &flight::TURBULENCE_STRONG] {
                judge.hold(limit, most / turbulence.airspeed);
            }
            let of = turbulence.airspeed;
            let airspeed = mean_velocity(self.record, 0, self.context.wind);
            let apart = airspeed.map(|(speed, _)| (speed / of).max(of / speed) - 1.0);
            for limit in [&flight::TURBULENCE_SPEED, &flight::TURBULENCE_ELSEWHERE] {
                judge.hold_if(limit, apart);
            }
        }
        judge.hold_if(&flight::AVERAGED, self.cycles.map(|cycles| cycles + ROUNDING));
        if let Some(means) = self.context.means {
            judge.hold(&range::REVERSED, means.reversed_fraction);
            if self.context.robot.density() > 0.0 {
                stall::hold(judge, &means.stalled, "aero.law");
            }
        }
    }

    /// Largest size of the power of the driven joints, W; none of a flight that grew without bound.
    fn peak_power(&self) -> Option<f64> {
        self.context.means?;
        self.record.values("joint_power")?.iter().map(|power| power.abs()).reduce(f64::max)
    }

    /// True of a robot that flies: a vacuum carries nothing, and a perch carries what hangs from it.
    fn is_carried_by_air(&self) -> bool {
        self.context.robot.density() > 0.0 && self.context.perch.is_none() && self.context.means.is_some()
    }

    /// Share of the weight that is carried over whole cycles of the part that counts, else of the whole flight; with the wings at rest over
    /// [`LONG_ENOUGH`]. None of a shorter flight.
    fn weight_carried(&self) -> Option<f64> {
        let whole = |cycles: f64| cycles + ROUNDING >= 1.0;
        if self.cycles.is_some_and(whole) {
            return self.summary.cost.weight_carried;
        }
        let [start, .., end] = self.record.values("phase")? else { return None };
        let turned = (end - start) / TAU;
        let (says, counted) = match turned > 0.0 {
            true => (whole(turned), None),
            false => (self.flight.duration >= LONG_ENOUGH, self.summary.cost.weight_carried),
        };
        let all = || Cost::of_record(self.record, 0).map(|cost| cost.carried());
        counted.or_else(all).filter(|_| says)
    }

    /// Mean rate of a crank under a motor over that of the gait, once settled.
    fn crank_rate_fraction(&self) -> Option<f64> {
        let settled = self.record.values("crank_rate")?.get(self.first..)?;
        Some(mean(settled)? / (TAU * self.context.robot.frequency_hz()))
    }

    /// Largest distance from the altitude at the start once settled, m.
    fn altitude_change(&self) -> Option<f64> {
        let z = self.record.values("p_WB_z")?;
        let start = *z.first()?;
        z.iter().skip(self.first).map(|z| (z - start).abs()).reduce(f64::max)
    }

    /// Angle between the path and the horizon over the whole flight, deg: height over length on the ground. Missing for a
    /// flight that is too short to say, or that stays where it is.
    fn path_angle(&self) -> Option<f64> {
        if self.flight.duration < SETTLED {
            return None;
        }
        let along = |name: &str| self.record.values(name);
        let (x, y) = (along("p_WB_x")?, along("p_WB_y")?);
        let ground: f64 = (1..x.len()).map(|row| (x[row] - x[row - 1]).hypot(y[row] - y[row - 1])).sum();
        let height = self.summary.altitude_change_m.abs();
        (ground.max(height) > STAYS).then(|| height.atan2(ground).to_degrees())
    }
}

/// Why it is open whether a short flight is carried.
const NO_MEAN_FORCE: &str = "not judged: flight.weight_carried; the flight is shorter than a cycle of its gait, or with its wings at rest than 1 s (lengthen flight.duration_s)";
/// Cycles that rounding takes from a whole one.
const ROUNDING: f64 = 1e-6;
/// Time after which a flight has a path that can be judged, s. *Choice.*
const SETTLED: f64 = 2.0;
/// Way below which a flight has no path angle, m. *Choice.*
const STAYS: f64 = 1.0;

/// Velocity in a row, m/s.
pub(super) fn velocity_at(record: &Record, row: usize) -> Option<Vec3> {
    let along = |axis: &str| record.values(&format!("v_WB_W_{axis}"))?.get(row).copied();
    Some(Vec3::new(along("x")?, along("y")?, along("z")?))
}

/// Mean magnitude of the velocity against the steady `wind`, and mean of the upward component of the velocity, from the row `first`
/// on, m/s.
pub(super) fn mean_velocity(record: &Record, first: usize, wind: Vec3) -> Option<(f64, f64)> {
    let axes = ["x", "y", "z"].map(|axis| record.values(&format!("v_WB_W_{axis}")));
    let [Some(x), Some(y), Some(z)] = axes else { return None };
    let rows = x.len().checked_sub(first).filter(|rows| *rows > 0)? as f64;
    let speed: f64 = (first..x.len()).map(|row| (Vec3::new(x[row], y[row], z[row]) - wind).norm()).sum();
    Some((speed / rows, z[first..].iter().sum::<f64>() / rows))
}
