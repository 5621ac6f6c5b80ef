//! Limits of a flap, of all that flies or is held with one. All values are choices.

use super::JudgedLimit;
use crate::Status::Outside;

/// Angle up to which the flow over a plain flap stays attached and its effect grows with the angle.
pub const ANGLE: JudgedLimit = JudgedLimit::warn_above("flap.angle_deg", 15.0, "deg").on(
    "the flow over a plain flap separates at its hinge, which no law here knows: largest angle of a flap",
);
/// A flap that leaves thin-aerofoil theory.
pub const BEYOND_ANGLE: JudgedLimit =
    JudgedLimit::at_most("flap.angle_outside_deg", 40.0, "deg", Outside).on("largest angle of a flap");
/// What is left out of the weight of a flap: in a robot its moment along the chord, on a tether all of it.
pub const WEIGHT: JudgedLimit = JudgedLimit::warn_above("flap.weight_fraction", 0.1, "").on(WEIGHT_SHARE);
/// Weight left out that turns a flap as much as what is known of it: its angle has no error bound then.
pub const BEYOND_WEIGHT: JudgedLimit =
    JudgedLimit::at_most("flap.weight_outside_fraction", 1.0, "", Outside).on(WEIGHT_SHARE);
const WEIGHT_SHARE: &str = "weight of a flap that is left out over what its spring bears: in a robot along its chord, on a tether all of it,";
/// A flap cannot be heavier than the link whose mass holds its own.
pub const MASS: JudgedLimit = JudgedLimit::at_most("flap.mass_fraction", 1.0, "", Outside)
    .on("largest mass of a flap on a link over that of the link, which holds it");

/// All of them.
pub const ALL: [JudgedLimit; 5] = [ANGLE, BEYOND_ANGLE, WEIGHT, BEYOND_WEIGHT, MASS];
