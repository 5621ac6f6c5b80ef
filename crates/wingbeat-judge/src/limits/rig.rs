//! Limits of a simulated run of the rig. All values are choices.

use super::Limit;
use crate::status::Status::Outside;

/// Samples at the end of the cell's range: the loads that they stand for were larger.
pub const SATURATED: Limit = Limit::at_most("rig.saturated_fraction", 0.01, "", Outside)
    .on("share of the samples in which a channel is at the end of the cell's range");
/// Strips past stall, where two published experiments alone test the lift laws.
pub const STALLED: Limit = Limit::warn_above("rig.stall_fraction", 0.5, "")
    .on("only two published experiments test the lift laws in stall: share of strips and samples past their stall angle");

/// All of them.
pub const ALL: [Limit; 2] = [SATURATED, STALLED];
