//! The verdict on a flight: its goal, the limits of the task without one, and what a reader must know.

use super::measure::asked_speed;
use super::moved::fraction_of;
use super::plausible;
use super::spec::GoalSpec;
use super::stall;
use super::summary::{Context, ControllerSummary, PartClearance, Summary, mean};
use std::f64::consts::{FRAC_PI_2, TAU};
use wingbeat_aero::induced_power;
use wingbeat_flight::guide::{Reference, angle_error};
use wingbeat_flight::simulate::{Cost, Ending, Flight, Record};
use wingbeat_judge::limits::{asked, flight, linkage, range, trim, wake};
use wingbeat_judge::{Judge, JudgedLimit, RunLimits, Status, Verdict, Warning};
use wingbeat_math::{GRAVITY, Vec3};
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

/// Least turn of the heading that a manoeuvre asks for which the heading is judged, rad. *Choice.*
const TURN: f64 = 0.1;

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
        let shorter = || {
            let soft = plausible::of_short_periods(self.context.robot, "a shorter flight.step_s");
            // At the start no step was taken yet.
            let rigid = soft.is_empty() && self.flight.duration > 0.0;
            if rigid { STEPS_TOO_LONG.to_owned() } else { soft }
        };
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
                let of_steps = matches!(fault, Fault::MassMatrix { .. });
                let mend = match of_steps {
                    true if self.flight.duration > 0.0 => shorter(),
                    true => plausible::of_no_inertia(self.context.robot),
                    false => String::new(),
                };
                let text = format!("{fault}, after {:.4} s{mend}", self.flight.duration);
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
        const BRIEF: &str = "less than a cycle of the gait, or a single record, is left after goal.settle_s";
        let brief = !self.counts();
        let reference = self.context.manoeuvre.is_some();
        let counted = |value: Option<f64>| value.filter(|_| !brief);
        let angle = |value: Option<f64>| counted(value).filter(|_| reference);
        let settled = if brief && self.settled_rows() > 0 { BRIEF } else { UNSETTLED };
        let why = if reference { settled } else { "without [manoeuvre] there is no reference to hold" };
        let summary = self.summary;
        let mut asked = vec![
            (&asked::ROLL, goal.roll_within_deg, angle(summary.roll_rms_error_deg), why),
            (&asked::PITCH, goal.pitch_within_deg, angle(summary.pitch_rms_error_deg), why),
        ];
        if let Some(within) = goal.altitude_within_m {
            asked.push((&asked::ALTITUDE, within, counted(self.altitude_change()), settled));
        }
        if let Some([low, high]) = goal.speed_between_m_s {
            asked.push((&asked::SLOWEST, low, counted(summary.mean_speed_m_s), settled));
            asked.push((&asked::FASTEST, high, counted(summary.mean_speed_m_s), settled));
        }
        if let Some(least) = goal.clearance_m {
            asked.push((&asked::CLEARANCE, least, summary.least_clearance_m, "the robot has no clearances"));
        }
        asked
    }

    /// Records of the part that counts.
    fn settled_rows(&self) -> usize {
        self.record.rows().saturating_sub(self.first)
    }

    /// True where the part that counts says something of a goal: a whole cycle of the gait, or of wings at rest more than an instant.
    fn counts(&self) -> bool {
        self.cycles.map_or(self.settled_rows() > 1, |cycles| cycles + ROUNDING >= 1.0)
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
            if self.context.perch.is_none() {
                for limit in [&flight::FREE_PATH_ANGLE, &flight::FALLS] {
                    judge.hold_if(limit, self.path_angle());
                }
                self.open_path(judge);
            }
            return;
        }
        let height = summary.height_max_error_m;
        judge.hold_if(&flight::ALTITUDE, height);
        if self.tracks_attitude() && goal.is_none() {
            judge.hold_if(&flight::ATTITUDE, summary.roll_rms_error_deg);
            judge.hold_if(&flight::ATTITUDE, summary.pitch_rms_error_deg);
        }
        if self.tracks_attitude() {
            let turned = self.turned_fraction();
            if turned.is_none_or(|turned| judge.hold(&flight::TURNED, turned)) {
                judge.hold_if(&flight::TURNED_IN_PART, turned);
            }
        }
        judge
            .hold_if(&flight::ESTIMATE, summary.estimate.as_ref().map(|estimate| estimate.normalised_square));
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
        judge.hold_if(&flight::ALONG, summary.path.as_ref().map(|path| path.along_max_m));
        // A landing and a dive have speeds of their own.
        if summary.perch.is_none() && summary.dive.is_none() {
            judge.hold_if(&flight::SPEED, summary.measured.get(asked_speed::FRACTION));
        }
        judge.hold_if(&flight::PLACE, summary.hover.as_ref().map(|hover| hover.place_rms_m));
        let has_height = height.is_some() || summary.hover.is_some();
        let asks_height = goal.is_some_and(|goal| goal.altitude_within_m.is_some());
        if !has_height && !asks_height {
            judge.hold_if(&flight::PATH_ANGLE, self.path_angle());
            self.open_path(judge);
        }
        if !self.context.inputs.is_empty() {
            judge.hold(&flight::SATURATION, summary.input_saturation_fraction);
        }
        if summary.controller.updates > 0 {
            let ControllerSummary { failures, dropped, updates, .. } = summary.controller;
            judge.hold(&flight::FAILURES, (failures + dropped) as f64 / updates as f64);
        }
    }

    /// True when there is an attitude to hold: that of an orbit, or of a manoeuvre that has had its time to settle.
    fn tracks_attitude(&self) -> bool {
        let orbit = self.record.values("orbit_roll_error").is_some();
        orbit || (self.context.manoeuvre.is_some() && self.flight.duration >= SETTLED)
    }

    /// Heading flown over the heading that the manoeuvre asks, over the part of the flight that counts; none where it asks for less than [`TURN`].
    ///
    /// Equation: flight.turned_fraction
    /// `sum r d psi / sum r^2 dt, r = (w_y sin phi + w_z cos phi) / cos theta of the reference`
    /// Source: least squares of the flown rate of heading by the asked one.
    /// Test: `a_turn_to_the_other_side_is_off_target`.
    fn turned_fraction(&self) -> Option<f64> {
        let manoeuvre = self.context.manoeuvre?;
        let [t, yaw] = ["t", "yaw"].map(|name| self.record.values(name)?.get(self.first..));
        let (t, yaw) = (t?, yaw?);
        let (mut asked, mut flown, mut square) = (0.0, 0.0, 0.0);
        for (t, yaw) in t.windows(2).zip(yaw.windows(2)) {
            let Reference { roll, pitch, w } = manoeuvre.reference(0.5 * (t[0] + t[1]));
            let rate = (w[1] * roll.sin() + w[2] * roll.cos()) / pitch.cos();
            asked += rate * (t[1] - t[0]);
            flown += rate * angle_error(yaw[1], yaw[0]);
            square += rate * rate * (t[1] - t[0]);
        }
        (asked.abs() >= TURN).then(|| flown / square)
    }

    /// Least distance from the ground over the largest mean chord of a surface, of strips.
    fn ground_chords(&self) -> Option<f64> {
        Some(self.summary.ground_distance_m? / self.context.strips_chord_m?)
    }

    /// Largest speed of body and strips through the mean wind, m/s.
    fn largest_airspeed(&self) -> f64 {
        let wind = self.context.robot.wind_over_time().mean();
        let speed = |row| velocity_at(self.record, row).map_or(0.0, |v| (v - wind).norm());
        let strips = self.context.means.map_or(0.0, |means| means.fastest_m_s);
        (0..self.record.rows()).map(speed).fold(strips, f64::max)
    }

    /// Holds the flight against the range in which its model, its fit and its steps are good.
    fn model(&self, judge: &mut Judge) {
        let (summary, robot) = (self.summary, self.context.robot);
        plausible::hold(judge, robot);
        self.speed_and_panels(judge);
        if let Some(crossing) = self.crossing {
            crossing.hold(judge);
        }
        self.fit_and_steps(judge);
        // A perch turns the robot that hits it.
        let alone = self.context.perch.is_none();
        judge.hold_each(&[
            (&[&flight::VERTICAL], self.steepest_deg()),
            (&[&flight::GROUND], summary.ground_distance_m),
            (&[&flight::LOW], self.ground_chords().filter(|_| alone)),
            (&[&flight::MOMENTUM], summary.angular_momentum_change_kg_m2_s.filter(|_| alone)),
        ]);
        summary.membrane.iter().for_each(|membrane| membrane.judge(judge));
        summary.flap.iter().for_each(|flap| flap.judge(judge));
        summary.spar.iter().for_each(|spar| spar.judge(judge));
        summary.pin_springs.iter().for_each(|pins| pins.judge(judge));
        self.power_and_turbulence(judge);
        let Some(means) = self.context.means else { return };
        means.hold(judge);
        if robot.density() > 0.0 {
            stall::hold(judge, &means.stalled, "aero.law");
        }
        // No law of wings carries what hangs from a perch or from its thrusters, or flies where there is no air.
        // Of less than a cycle the shares are those of how it starts.
        let flies = self.is_carried_by_air() && robot.thrusters().is_empty();
        if flies && self.weight_carried().is_some() {
            judge.hold(&range::REVERSED_OUTSIDE, means.reversed_fraction);
            judge.hold(&range::STALLED_OUTSIDE, means.stalled.untested());
            judge.hold_if(&flight::IDEAL, self.ideal_power_fraction());
        }
    }

    fn speed_and_panels(&self, judge: &mut Judge) {
        let panels = self.context.panels.map(|panels| panels.map(|count| count as f64));
        let lattice = self.summary.lattice.filter(|_| panels.is_some());
        let mach = self.largest_airspeed() / range::SOUND_M_S;
        judge.hold_each(&[
            (&[&linkage::CRANK_RATE], self.crank_rate_fraction()),
            (&[&range::COMPRESSED, &range::MACH], Some(mach)),
            (&[&wake::ALONG, &wake::FEW_ALONG], panels.map(|[along, _]| along)),
            (&[&wake::ACROSS, &wake::FEW_OF_FLIGHT], panels.map(|[_, across]| across)),
            (&[&wake::INFLOW], lattice.map(|lattice| lattice.inflow_fraction)),
        ]);
    }

    fn fit_and_steps(&self, judge: &mut Judge) {
        let (error, grown) = (self.context.step_error_m, self.context.grown_error_m);
        let over_asked = |error: Option<f64>| Some(error? / self.context.asked_error_m?);
        let beyond = self.summary.beyond_residual_fraction;
        judge.hold_each(&[
            (&[&flight::LEAVES_RESIDUAL, &flight::BEYOND_RESIDUAL], beyond),
            (&[&flight::STEP_ERROR, &flight::STEPS_LOST], error),
            (&[&flight::STEPS_ASKED], over_asked(error)),
            (&[&flight::ERROR_GROWN], over_asked(grown)),
        ]);
        if let Some(records) = self.records_per_cycle()
            && judge.hold(&flight::RECORDS, records)
        {
            judge.hold(&flight::FEW_RECORDS, records);
        }
    }

    fn power_and_turbulence(&self, judge: &mut Judge) {
        let long = self.flight.duration >= LONG_ENOUGH;
        let turbulence = self.context.turbulence;
        let deviation = turbulence.map(|air| air.deviation.into_iter().fold(0.0, f64::max) / air.airspeed);
        let apart = turbulence.map(|air| air.airspeed).and_then(|of| {
            let (speed, _) = mean_velocity(self.record, 0, self.context.wind)?;
            Some((speed / of).max(of / speed) - 1.0)
        });
        judge.hold_each(&[
            (&[&trim::PEAK], self.peak_power().map(|power| power / self.context.robot.mass())),
            (&[&trim::POWER, &trim::HIGH_POWER], self.summary.cost.positive_power_w_kg.filter(|_| long)),
            (&[&flight::TURBULENCE, &flight::TURBULENCE_STRONG], deviation),
            (&[&flight::TURBULENCE_SPEED, &flight::TURBULENCE_ELSEWHERE], apart),
            (&[&flight::AVERAGED], self.cycles.map(|cycles| cycles + ROUNDING)),
        ]);
    }

    /// Least power of the disc that the surfaces reach over what the air gets of joints and of height, of at least two whole cycles that count. A kinetic
    /// energy that changes counts as given to it. None in gusts, which give power, and over ground.
    ///
    /// Equation: flight.ideal_power_fraction
    /// `P_ideal / (P - m g v_z + abs(m v_1^2 - m v_0^2)/(2 T)), P_ideal by aero.induced_power with F = m g + m (v_1 - v_0)/T`
    /// Source: balance of work in the air that is at rest far off.
    /// Test: `the_power_of_a_flight_is_above_the_ideal_one`.
    fn ideal_power_fraction(&self) -> Option<f64> {
        let robot = self.context.robot;
        let gusty = self.context.gusty || self.context.turbulence.is_some();
        let still = !gusty && self.summary.ground_distance_m.is_none();
        let whole = self.cycles.is_some_and(|cycles| cycles + ROUNDING >= 2.0);
        let t = self.record.values("t").filter(|_| still && whole)?.get(self.first..)?;
        let time = t.last()? - t.first()?;
        let through_air = |row: usize| Some(velocity_at(self.record, row)? - self.context.wind);
        let (start, end) = (through_air(self.first)?, through_air(self.record.rows() - 1)?);
        let mean = |name: &str| mean(self.record.values(name)?.get(self.first..)?);
        let [x, y, z] = ["x", "y", "z"].map(|axis| mean(&format!("v_WB_W_{axis}")));
        let velocity = Vec3::new(x?, y?, z?) - self.context.wind;
        let (mass, carried) = (robot.mass(), self.summary.cost.weight_carried?);
        let force = Vec3::new(0.0, 0.0, carried * GRAVITY) + (end - start) * (1.0 / time);
        let ideal = induced_power(force * mass, -velocity, robot.density(), plausible::reach(robot));
        let kinetic = 0.5 * (end.norm_squared() - start.norm_squared()).abs() / time;
        let joints = self.summary.cost.net_power_w? + mean("regulator_power").unwrap_or_default().max(0.0);
        let given = joints + mass * (kinetic - GRAVITY * velocity[2]);
        (ideal > 0.0).then(|| fraction_of(ideal, given))
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

    /// Says of a flight that is to keep up, and is too short for its path to tell, that this is open.
    fn open_path(&self, judge: &mut Judge) {
        if self.flight.duration < SETTLED && self.is_carried_by_air() {
            judge.find(Status::NotJudged, NO_PATH);
        }
    }

    /// Angle between the path through the steady wind and the horizon over the whole flight, deg: height over length along the horizon.
    /// Missing for a flight that is too short to say, or that stays where it is in its air.
    fn path_angle(&self) -> Option<f64> {
        if self.flight.duration < SETTLED {
            return None;
        }
        let along = |name: &str| self.record.values(name);
        let (t, x, y) = (along("t")?, along("p_WB_x")?, along("p_WB_y")?);
        let Vec3([wind_x, wind_y, wind_z]) = self.context.wind;
        let way = |row: usize| {
            let time = t[row] - t[row - 1];
            (x[row] - x[row - 1] - wind_x * time).hypot(y[row] - y[row - 1] - wind_y * time)
        };
        let length: f64 = (1..x.len()).map(way).sum();
        let height = (self.summary.altitude_change_m - wind_z * (t.last()? - t.first()?)).abs();
        (length.max(height) > STAYS).then(|| height.atan2(length).to_degrees())
    }

    /// Records in a cycle of the gait, in a second where it stands still; none of a single record.
    fn records_per_cycle(&self) -> Option<f64> {
        let span = |name: &str| match self.record.values(name)? {
            [first, .., last] => Some(last - first),
            _ => None,
        };
        let (time, turned) = (span("t")?, span("phase")? / TAU);
        let of = if turned > 0.0 { turned } else { time };
        Some((self.record.rows() - 1) as f64 / of * (1.0 + ROUNDING))
    }

    /// Largest size of the pitch, deg; 90 where the roll leaps by more than a quarter of a turn from a record to the next, as it does where the
    /// nose passes the vertical between them.
    fn steepest_deg(&self) -> Option<f64> {
        let (pitch, roll) = (self.record.values("pitch")?, self.record.values("roll")?);
        let leaps = roll.windows(2).any(|pair| angle_error(pair[1], pair[0]).abs() > FRAC_PI_2);
        let largest = pitch.iter().map(|pitch| pitch.abs()).reduce(f64::max)?;
        Some(if leaps { FRAC_PI_2 } else { largest }.to_degrees())
    }
}

/// What mends steps that end in a mass matrix or a number that cannot be.
const STEPS_TOO_LONG: &str =
    ": steps are too long for such loads and speeds, if these are meant (shorten flight.step_s)";
/// Why it is open whether a short flight falls.
const NO_PATH: &str =
    "not judged: the angle of the path; the flight is shorter than 2 s (lengthen flight.duration_s)";

/// Why it is open whether a short flight is carried.
const NO_MEAN_FORCE: &str = "not judged: flight.weight_carried; the flight is shorter than a cycle of its gait, or with its wings at rest than 1 s (lengthen flight.duration_s, or mend the drive of a gait that does not turn)";
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
