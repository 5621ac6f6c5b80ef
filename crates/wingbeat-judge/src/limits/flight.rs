//! Limits of a flight.

use super::Limit;
use crate::status::Status::{Failed, OffTarget, Outside};

/// Height against the reference of the controller.
pub const ALTITUDE: Limit =
    Limit::at_most("flight.altitude_m", 2.0, "m", OffTarget).on("largest distance from the reference height");
/// Roll and pitch against the reference.
pub const ATTITUDE: Limit =
    Limit::at_most("flight.attitude_rms_deg", 15.0, "deg", OffTarget).on("rms error of roll or pitch");
/// Commands at their limits.
pub const SATURATION: Limit =
    Limit::at_most("flight.saturation_fraction", 0.6, "", OffTarget).on("share of the commands at a limit");
/// Wings that pass through each other or the body.
pub const CROSSING: Limit = Limit::at_most("flight.crossing_fraction", 0.0, "", Outside)
    .on("share of the time in which parts pass through each other");
/// Beyond the velocities at which `robot.residual` was measured.
pub const BEYOND_RESIDUAL: Limit = Limit::at_most("flight.beyond_residual_fraction", 0.5, "", Outside)
    .on("share of the time beyond the velocities at which `robot.residual` was measured");
/// Updates of the controller that gave no command.
pub const FAILURES: Limit = Limit::at_most("flight.controller_failures_fraction", 0.1, "", Failed)
    .on("share of the controller's updates without an answer");

/// All of them.
pub const ALL: [Limit; 6] = [ALTITUDE, ATTITUDE, SATURATION, CROSSING, BEYOND_RESIDUAL, FAILURES];
