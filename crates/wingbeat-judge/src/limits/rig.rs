//! Limits of a simulated run of the rig. All values are choices.

use super::JudgedLimit;
use crate::status::Status::Outside;

/// Samples at the end of the cell's range: the loads that they stand for were larger.
pub const SATURATED: JudgedLimit = JudgedLimit::at_most("rig.saturated_fraction", 0.01, "", Outside)
    .on("share of the samples in which a channel is at the end of the cell's range");

/// Wings that pass through each other or through the body.
pub const CROSSING: JudgedLimit = JudgedLimit::warn_above("rig.crossing_fraction", 0.0, "")
    .on("share of the cycle of the gait in which parts of the robot pass through each other");
/// The same for long. *Choice*: the published gait of Aerobat crosses for 0.09 of its cycle.
pub const CROSSED: JudgedLimit = JudgedLimit::at_most("rig.crossing_outside_fraction", 0.2, "", Outside)
    .on("share of the cycle of the gait in which parts of the robot pass through each other");

/// All of them.
pub const ALL: [JudgedLimit; 3] = [SATURATED, CROSSING, CROSSED];
