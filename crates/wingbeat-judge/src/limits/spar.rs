//! Limits of the spars of links. Both values are choices: a chain of rigid pieces that turns by `a` between two of them lies inside of the
//! arc which it stands for, whose chord is shorter than the arc by 1 - sin(a/2)/(a/2), 1 % at 30 deg and 10 % at 90 deg.

use super::JudgedLimit;
use crate::Status::Outside;

/// Angle up to which rigid pieces follow a bent beam.
pub const ANGLE: JudgedLimit = JudgedLimit::warn_above("spar.angle_deg", 30.0, "deg")
    .on("a spar has too few segments for how it bends or twists: largest angle between two pieces");
/// A chain that is no beam.
pub const BEYOND_ANGLE: JudgedLimit = JudgedLimit::at_most("spar.angle_outside_deg", 90.0, "deg", Outside)
    .on("a spar winds up (are bending_n_m2 and torsion_n_m2 in N m2?): largest angle between two pieces");

/// All of them.
pub const ALL: [JudgedLimit; 2] = [ANGLE, BEYOND_ANGLE];
