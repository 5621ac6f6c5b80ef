//! Limits of the spars of links. All values are choices. Of an angle a between two pieces: the chord over an arc that turns by a is shorter
//! than the arc by 1 - sin(a/2)/(a/2), 1 % at 30 deg and 10 % at 90 deg.

use super::JudgedLimit;
use crate::Status::Outside;

/// Angle up to which rigid pieces follow a bent beam.
pub const ANGLE: JudgedLimit = JudgedLimit::warn_above("spar.angle_deg", 30.0, "deg")
    .on("a spar has too few segments for how it bends or twists: largest angle between two pieces");
/// A chain that is no beam.
pub const BEYOND_ANGLE: JudgedLimit = JudgedLimit::at_most("spar.angle_outside_deg", 90.0, "deg", Outside)
    .on("a spar winds up (are bending_n_m2 and torsion_n_m2 in N m2?): largest angle between two pieces");
/// Error that the few pieces of a chain make.
pub const FREQUENCY: JudgedLimit = JudgedLimit::warn_above("spar.frequency_fraction", 0.1, "")
    .on("a spar of so few segments bends or twists at another frequency: size of its largest error");
/// A spar that ends short of its wing or beyond it.
pub const END: JudgedLimit = JudgedLimit::warn_above("spar.end_fraction", 0.1, "")
    .on("a spar does not end where its wing ends (is length_m in m?): distance over its length");
/// Centres of mass beyond the edges of the chord, where mass balances reach some tenths.
pub const OFF_CHORD: JudgedLimit = JudgedLimit::at_most("spar.off_chord", 1.0, "", Outside)
    .on("distance of a spar's mass from the chord of its wing (is ahead_m in m?), over the mean chord,");
/// Radius of gyration about the span over the chord: 0.29 of an even plate.
pub const GYRATION: JudgedLimit = JudgedLimit::at_most("spar.gyration", 1.0, "", Outside).on(
    "an inertia that is large for its mass (is inertia_kg_m in kg m?): radius of gyration about the span over the mean chord,",
);

/// All of them.
pub const ALL: [JudgedLimit; 6] = [ANGLE, BEYOND_ANGLE, FREQUENCY, END, OFF_CHORD, GYRATION];
