//! What a document asks of a flight by keys of its own: the key is the limit, and stands in the place of the value here.

use super::JudgedLimit;
use crate::status::Status::OffTarget;

/// `goal.roll_within_deg`.
pub const ROLL: JudgedLimit =
    JudgedLimit::at_most("goal.roll_within_deg", 0.0, "deg", OffTarget).on("rms error of roll");
/// `goal.pitch_within_deg`.
pub const PITCH: JudgedLimit =
    JudgedLimit::at_most("goal.pitch_within_deg", 0.0, "deg", OffTarget).on("rms error of pitch");
/// `goal.altitude_within_m`.
pub const ALTITUDE: JudgedLimit =
    JudgedLimit::at_most("goal.altitude_within_m", 0.0, "m", OffTarget).on("change of altitude");
/// The first of `goal.speed_between_m_s`.
pub const SLOWEST: JudgedLimit =
    JudgedLimit::at_least("goal.speed_between_m_s", 0.0, "m/s", OffTarget).on("mean speed");
/// The second of `goal.speed_between_m_s`.
pub const FASTEST: JudgedLimit =
    JudgedLimit::at_most("goal.speed_between_m_s", 0.0, "m/s", OffTarget).on("mean speed");
/// `goal.clearance_m`.
pub const CLEARANCE: JudgedLimit =
    JudgedLimit::at_least("goal.clearance_m", 0.0, "m", OffTarget).on("least clearance");
/// `perch.capture_m`.
pub const PERCH_DISTANCE: JudgedLimit =
    JudgedLimit::at_most("perch.capture_m", 0.0, "m", OffTarget).on("distance of the claw from the perch");
/// `perch.speed_within_m_s`.
pub const PERCH_SPEED: JudgedLimit = JudgedLimit::at_most("perch.speed_within_m_s", 0.0, "m/s", OffTarget)
    .on("speed of the claw at the perch");
/// `perch.attitude_within_deg`.
pub const PERCH_ATTITUDE: JudgedLimit =
    JudgedLimit::at_most("perch.attitude_within_deg", 0.0, "deg", OffTarget)
        .on("angle between the back and straight down at the perch");

/// All of them. They are none of the limits that a table `[limits]` replaces.
pub const ALL: [JudgedLimit; 9] =
    [ROLL, PITCH, ALTITUDE, SLOWEST, FASTEST, CLEARANCE, PERCH_DISTANCE, PERCH_SPEED, PERCH_ATTITUDE];
