//! Limits of the crank and of the springs on the pins of a linkage. All values are choices but the deflection that a file states.

use super::JudgedLimit;
use crate::Status::Outside;

/// Deflection up to which a bent strip stands for a pin and its spring is even.
pub const ANGLE: JudgedLimit = JudgedLimit::warn_above("linkage.spring_angle_deg", 60.0, "deg").on(
    "a flexure that bends so far is no even spring on a pin (is rest in rad?): largest deflection from rest",
);
/// Beyond what the file says that it bears.
pub const BEYOND: JudgedLimit = JudgedLimit::at_most("linkage.spring_fraction", 1.0, "", Outside)
    .on("a spring on a pin of the linkage bears so much: largest deflection from rest over its `limit`");

/// A crank that stands, or all but: what it turns does not flap.
pub const CRANK_RATE: JudgedLimit = JudgedLimit::at_least("linkage.crank_rate_fraction", 0.1, "", Outside)
    .on("the motor does not turn the crank: mean rate of the crank over that of the gait");

/// All of them.
pub const ALL: [JudgedLimit; 3] = [ANGLE, BEYOND, CRANK_RATE];
