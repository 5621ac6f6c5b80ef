//! Limits of a membrane, of all that flies or is held with one. All values are choices.

use super::JudgedLimit;
use crate::status::Status::Outside;

/// Camber beyond which thin-aerofoil theory is poor.
pub const CAMBER: JudgedLimit = JudgedLimit::warn_above("membrane.camber_fraction", 0.15, "")
    .on("thin-aerofoil theory becomes poor: largest rise of a membrane over its chord");
/// Camber at which slopes are no longer small: an arc of 0.3 leaves its ends at 62 degrees.
pub const BEYOND_CAMBER: JudgedLimit =
    JudgedLimit::at_most("membrane.camber_outside_fraction", 0.3, "", Outside)
        .on("largest rise of a membrane over its chord");
/// Membranes that are slack for long.
pub const SLACK: JudgedLimit = JudgedLimit::warn_above("membrane.slack_fraction", 0.05, "")
    .on("a slack membrane wrinkles, which the model does not know: share of the strips and of the time in which it is slack along the chord");
/// A membrane that is slack along its span at rest, where ribs hold it: it wrinkles until its bulge takes it up.
pub const SLACK_SPAN: JudgedLimit = JudgedLimit::warn_below("membrane.prestrain_span", 0.0, "").on(
    "a membrane that is slack along its span wrinkles, which the model does not know: strain along the span at rest",
);
/// Frequency of the motion up to which a membrane may feel its inertia late; what is lost is of the order of the square.
pub const FREQUENCY: JudgedLimit = JudgedLimit::warn_above("membrane.frequency_fraction", 0.25, "").on(
    "only a membrane's first shape feels inertia, and late: frequency of the motion over that of the membrane",
);
/// A motion above the membrane's own frequency, which would move against it.
pub const BEYOND_FREQUENCY: JudgedLimit =
    JudgedLimit::at_most("membrane.frequency_outside_fraction", 1.0, "", Outside)
        .on("frequency of the motion over that of the membrane");
/// Lag of 9 degrees; the load of inertia falls by 1 - 1/sqrt(1 + 0.15^2), 1 %.
pub const LAG: JudgedLimit = JudgedLimit::warn_above("membrane.lag_rad", 0.15, "rad")
    .on("damping_s lets a membrane and the load of its inertia lag: angular frequency of the motion times damping_s");
/// Lag of 45 degrees.
pub const BEYOND_LAG: JudgedLimit = JudgedLimit::at_most("membrane.lag_outside_rad", 1.0, "rad", Outside)
    .on("angular frequency of the motion times damping_s of a membrane");
/// Weight of a membrane, which bends no membrane here.
pub const WEIGHT: JudgedLimit = JudgedLimit::warn_above("membrane.weight_fraction", 0.1, "")
    .on("gravity does not bend a membrane here: rise by its weight over its largest rise");
/// Bending stiffness, which is left out: the tension at which a strip would buckle over its mean one.
pub const BENDING: JudgedLimit = JudgedLimit::warn_above("membrane.bending_fraction", 0.1, "")
    .on("the bending stiffness of a membrane is left out: what it would bear of the load, over what its tension bears,");
/// A sheet so thick that it bears more by bending than by tension.
pub const BEYOND_BENDING: JudgedLimit =
    JudgedLimit::at_most("membrane.bending_outside_fraction", 1.0, "", Outside)
        .on("load that the bending stiffness of a membrane would bear, over what its tension bears,");
/// A membrane cannot be heavier than the link whose mass holds its own.
pub const MASS: JudgedLimit = JudgedLimit::at_most("membrane.mass_fraction", 1.0, "", Outside)
    .on("largest mass of a membrane on a link over that of the link, which holds it");

/// Strain up to which the tension of rubber grows with it; films of plastic yield below a tenth of it.
pub const STRAIN: JudgedLimit = JudgedLimit::warn_above("membrane.strain", 0.3, "")
    .on("the tension of a membrane grows with its strain, which materials leave: largest strain");
/// Strain at which the tension of an ideal rubber, E (l - 1/l^2)/3 at the stretch l = 1 + e (Treloar 1975), is 0.58 of E e.
pub const BEYOND_STRAIN: JudgedLimit = JudgedLimit::at_most("membrane.strain_outside", 1.0, "", Outside)
    .on("largest strain of a membrane, whose tension grows with it,");

/// All of them.
pub const ALL: [JudgedLimit; 14] = [
    STRAIN,
    BEYOND_STRAIN,
    CAMBER,
    BEYOND_CAMBER,
    SLACK,
    SLACK_SPAN,
    FREQUENCY,
    BEYOND_FREQUENCY,
    LAG,
    BEYOND_LAG,
    WEIGHT,
    BENDING,
    BEYOND_BENDING,
    MASS,
];
