//! A perch beside the flight: what a scenario says of it, and what became of the landing.

use serde::{Deserialize, Serialize};
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::{asked, flight};
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, Vec3, require};
use wingbeat_robot::{Contact, Perch, PerchShape, Robot, Seen};

/// Columns that a flight beside a perch has.
pub(super) const COLUMNS: [[&str; 3]; 8] = [
    ["perch_x", "m", "W"],
    ["perch_y", "m", "W"],
    ["perch_z", "m", "W"],
    ["perch_distance", "m", ""],
    ["perch_speed", "m/s", ""],
    ["perch_attitude", "rad", ""],
    ["perch_force", "N", ""],
    ["perch_clearance", "m", ""],
];

/// What there is to land on.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PerchKind {
    /// A round bar.
    #[default]
    Bar,
    /// A ceiling, of which the claw holds a disc about the place.
    Ceiling,
}

/// A perch at rest. The claw is a point fixed in the body. It latches as soon as distance, speed and attitude are within what follows, and
/// the flight ends there; a claw that does not latch bounces off.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct PerchSpec {
    /// Its middle in W, m.
    pub place_m: [f64; 3],
    /// What it is.
    #[serde(default)]
    pub kind: PerchKind,
    /// Direction along a bar, in W, dimensionless.
    #[serde(default = "across")]
    pub direction: [f64; 3],
    /// Length of a bar, m.
    #[serde(default = "default_length")]
    pub length_m: f64,
    /// Radius of a bar, or of the disc of a ceiling, m.
    #[serde(default = "default_radius")]
    pub radius_m: f64,
    /// Place of the claw in B, m.
    #[serde(default)]
    pub claw_m: [f64; 3],
    /// Distance from claw to perch within which it latches, m.
    pub capture_m: f64,
    /// Speed of the claw up to which it latches, m/s.
    pub speed_within_m_s: f64,
    /// Angle between the back of the robot and straight down up to which it latches, deg: 0 hangs heel above head.
    pub attitude_within_deg: f64,
    /// Speed after a central hit of the whole mass over that before.
    #[serde(default = "half")]
    pub restitution: f64,
    /// Coefficient of friction.
    #[serde(default = "half")]
    pub friction: f64,
    /// Duration of such a hit, s: ten steps of the flight or more.
    #[serde(default = "default_contact")]
    pub contact_s: f64,
}

fn across() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn default_length() -> f64 {
    0.1
}

fn default_radius() -> f64 {
    0.005
}

fn half() -> f64 {
    0.5
}

fn default_contact() -> f64 {
    0.01
}

ranges!(PerchSpec {
    length_m: Range::POSITIVE,
    radius_m: Range::POSITIVE,
    capture_m: Range::between(1e-4, 1.0),
    speed_within_m_s: Range::between(1e-3, 20.0),
    attitude_within_deg: Range::between(0.1, 180.0),
    restitution: Range::between(0.2, 1.0),
    friction: Range::between(0.0, 10.0),
    contact_s: Range::POSITIVE,
});

/// Records within a hit, so that its largest force is recorded.
const SEEN: f64 = 10.0;

/// Steps of the flight that a hit must take at least, for the steps to follow it.
const STEPS: f64 = 10.0;

/// By how much of its limits the claw is within them where it is taken to latch: the state at that instant is still normalised.
const ROUNDED: f64 = 1e-9;

impl PerchSpec {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::finite("place_m", &self.place_m)?;
        require::finite("claw_m", &self.claw_m)?;
        require::finite("direction", &self.direction)?;
        let length = Vec3(self.direction).norm();
        if !(length > 1e-6 && length.is_finite()) {
            return Err(Error::invalid("direction", format!("{:?}", self.direction), "a direction"));
        }
        Ok(())
    }

    /// Refuses a hit that steps or records of the flight do not see.
    pub(super) fn seen_by(&self, step_s: f64, record_every_s: f64) -> Result<(), Error> {
        if !(self.contact_s >= STEPS * step_s * (1.0 - 1e-9)) {
            let allowed = format!("{} or more, ten steps of the flight", STEPS * step_s);
            return Err(Error::invalid("contact_s", self.contact_s, allowed));
        }
        if record_every_s > self.contact_s / SEEN * (1.0 + 1e-9) {
            let allowed = format!(
                "{} or more, ten times flight.record_every_s: the force of a hit is recorded with every record",
                SEEN * record_every_s
            );
            return Err(Error::invalid("contact_s", self.contact_s, allowed));
        }
        Ok(())
    }

    /// The perch beside `robot`.
    pub(super) fn beside(&self, robot: &Robot) -> Perch {
        let shape = match self.kind {
            PerchKind::Bar => PerchShape::Bar {
                axis: Vec3(self.direction).unit(),
                half_length: 0.5 * self.length_m,
                radius: self.radius_m,
            },
            PerchKind::Ceiling => PerchShape::Ceiling { radius: self.radius_m },
        };
        let contact =
            Contact { restitution: self.restitution, friction: self.friction, duration: self.contact_s };
        Perch::new(Vec3(self.place_m), shape, Vec3(self.claw_m), contact, robot.mass())
    }

    /// Refuses a robot that begins at the perch or beyond it.
    pub(super) fn begins(&self, seen: &Seen) -> Result<(), Error> {
        if seen.distance > 0.0 && seen.force == 0.0 && !self.latches(seen) {
            return Ok(());
        }
        let allowed = "a perch that the robot does not begin at, in or beyond";
        Err(Error::invalid("place_m", format!("{:?}", self.place_m), allowed))
    }

    /// Whether the claw latches.
    pub(super) fn latches(&self, seen: &Seen) -> bool {
        self.off(seen.distance, seen.speed, seen.off_hanging) <= 1.0
    }

    /// What falls to 0 where the claw latches, whatever the state is rounded to from there on, dimensionless.
    pub(super) fn short_of_latching(&self, seen: &Seen) -> f64 {
        self.off(seen.distance, seen.speed, seen.off_hanging) - (1.0 - ROUNDED)
    }

    /// The largest of distance, speed and angle (rad), each over that at which the claw latches.
    fn off(&self, distance: f64, speed: f64, angle: f64) -> f64 {
        let angle = angle.to_degrees() / self.attitude_within_deg;
        (distance / self.capture_m).max(speed / self.speed_within_m_s).max(angle)
    }
}

/// A flight to a perch. Without a catch the numbers are those of the instant at which the claw was closest to latching.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PerchSummary {
    /// Whether the claw latched, which ends the flight.
    pub caught: bool,
    /// Whether claw and perch met: a catch, or a hit without one.
    pub touched: bool,
    /// Time of that instant, s.
    pub touch_s: f64,
    /// Distance of the claw from the perch, m.
    pub distance_m: f64,
    /// Speed of the claw, m/s.
    pub speed_m_s: f64,
    /// Angle between the back and straight down, deg.
    pub attitude_error_deg: f64,
    /// Pitch less that of a robot that hangs heel above head, deg; positive is too far over.
    pub pitch_error_deg: f64,
    /// Least distance over the flight, m.
    pub least_distance_m: f64,
    /// Largest force between claw and perch, N.
    pub largest_force_n: f64,
    /// Least distance of surfaces and capsules from the perch over the flight, m.
    pub least_clearance_m: Option<f64>,
    /// Share of its cost that the last iteration of the plan of `controller.orbit.landing` saved.
    pub plan_saved_fraction: Option<f64>,
    /// Speed of the claw at the end of that plan, m/s.
    pub plan_speed_m_s: Option<f64>,
    /// Pitch off half a turn at the end of that plan, deg.
    pub plan_pitch_deg: Option<f64>,
}

impl PerchSummary {
    /// Of a record beside the perch `spec`.
    pub(super) fn new(record: &Record, spec: &PerchSpec) -> Option<Self> {
        let column = |name: &str| record.values(name);
        let (t, distance, speed) = (column("t")?, column("perch_distance")?, column("perch_speed")?);
        let (angle, force) = (column("perch_attitude")?, column("perch_force")?);
        let [w, x, y, z] = ["w", "x", "y", "z"].map(|axis| column(&format!("quat_{axis}")));
        let (w, x, y, z) = (w?, x?, y?, z?);
        let off = |row: usize| spec.off(distance[row], speed[row], angle[row]);
        let row = (0..t.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
        let largest = force.iter().copied().fold(0.0, f64::max);
        // Heights of nose and back, of which hanging has 0 and -1; a nose below is one that went too far over.
        let nose = 2.0 * (x[row] * z[row] - w[row] * y[row]);
        let back = 1.0 - 2.0 * (x[row] * x[row] + y[row] * y[row]);
        let caught = off(row) <= 1.0;
        let clear = column("perch_clearance").and_then(|clear| clear.iter().copied().reduce(f64::min));
        let planned = |of: &str| column(&format!("orbit_landing_{of}"))?.first().copied();
        Some(Self {
            caught,
            touched: caught || largest > 0.0,
            touch_s: t[row],
            distance_m: distance[row],
            speed_m_s: speed[row],
            attitude_error_deg: angle[row].to_degrees(),
            pitch_error_deg: (-nose).atan2(-back).to_degrees(),
            least_distance_m: distance.iter().copied().fold(f64::INFINITY, f64::min),
            largest_force_n: largest,
            least_clearance_m: clear,
            plan_saved_fraction: planned("saved"),
            plan_speed_m_s: planned("speed"),
            plan_pitch_deg: planned("pitch").map(f64::to_degrees),
        })
    }

    pub(super) fn judge(&self, spec: &PerchSpec, judge: &mut Judge) {
        judge.hold_to(&asked::PERCH_DISTANCE, spec.capture_m, self.distance_m);
        judge.hold_to(&asked::PERCH_SPEED, spec.speed_within_m_s, self.speed_m_s);
        judge.hold_to(&asked::PERCH_ATTITUDE, spec.attitude_within_deg, self.attitude_error_deg);
        judge.hold_if(&flight::PERCH_CLEARANCE, self.least_clearance_m);
        judge.hold_if(&flight::LANDING_PLAN, self.plan_saved_fraction);
        let ends = self.plan_speed_m_s.zip(self.plan_pitch_deg);
        let over = |(speed, pitch): (f64, f64)| {
            (speed / spec.speed_within_m_s).max(pitch / spec.attitude_within_deg)
        };
        judge.hold_if(&flight::LANDING_ASKED, ends.map(over));
    }
}
