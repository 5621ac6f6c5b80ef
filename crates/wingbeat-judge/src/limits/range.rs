//! Limits of the range in which the models hold, of all that moves in air.

use super::JudgedLimit;
use crate::status::Status::Outside;

/// Speed of sound in dry air at 20 degrees C, m/s (ISO 9613-1).
pub const SOUND_M_S: f64 = 343.2;

/// Mach number from which air is compressed: loads of thin wings grow by 1/sqrt(1 - M^2), 5 % at 0.3 (Prandtl & Glauert).
pub const COMPRESSED: JudgedLimit = JudgedLimit::warn_above("range.mach", 0.3, "")
    .on("the models are those of air that is not compressed: largest speed over that of sound");
/// Mach number at which loads would be 40 % larger, and shocks are near.
pub const MACH: JudgedLimit =
    JudgedLimit::at_most("range.mach_outside", 0.7, "", Outside).on("largest speed over that of sound");
/// Radius of gyration of a body, over the span: no body that is carried by its wings reaches far beyond them. *Choice.*
pub const GYRATION: JudgedLimit = JudgedLimit::warn_above("range.gyration_over_span", 2.0, "")
    .on("an inertia that is large for its mass (is it in kg m2?): largest radius of gyration of a body over the span");
/// The same of the body that carries the wings. Shipped robots have 0.05 and more. *Choice.*
pub const COMPACT: JudgedLimit = JudgedLimit::warn_below("range.gyration_of_body_over_span", 0.005, "")
    .on("an inertia that is small for its mass (is it in kg m2?): least radius of gyration of the body over the span");
/// Distance of a centre of mass from the joint that carries it, over the span. *Choice.*
pub const CENTRE: JudgedLimit = JudgedLimit::warn_above("range.centre_over_span", 1.0, "")
    .on("a centre of mass far off (is it in m?): largest distance from the joint of a body over the span");
/// Distance between two panels of a surface on the hinge where they meet, over the chord there: the model takes them for one wing. Shipped
/// robots have 3e-13 and less. *Choice.*
pub const APART: JudgedLimit = JudgedLimit::warn_above("range.panels_apart_fraction", 0.05, "")
    .on("panels of a surface do not meet on their hinge (see origin_m of links and panels, and from_arc_m): largest distance between their chord lines there over the chord");
/// The same where they are no wing any more. *Choice.*
pub const TORN: JudgedLimit = JudgedLimit::at_most("range.panels_torn_fraction", 0.25, "", Outside)
    .on("a surface is torn on a hinge (see origin_m of links and panels, and from_arc_m): largest distance between the chord lines of two panels there over the chord");
/// Weight over the square of the span: 19 N/m2 of 10 kg on 2.3 m, a heavy bird, and 2180 of 20 kg in place of 20 g on 0.3 m. *Choice.*
pub const LOADING: JudgedLimit = JudgedLimit::warn_above("range.span_loading_n_m2", 100.0, "N/m2")
    .on("the robot is heavy for its wings (is its mass in kg?): weight over the square of the span");
/// Mass of a link over that of the body that carries it. Shipped robots have 0.3 and less. *Choice.*
pub const LINK: JudgedLimit = JudgedLimit::warn_above("range.link_over_body", 5.0, "")
    .on("a link that is heavy for its body (is it in kg?): largest mass of a link over that of the body");
/// Means and amplitudes of the angles of joints: no wing turns by more than half a turn. *Choice.*
pub const ANGLE: JudgedLimit = JudgedLimit::warn_above("range.joint_angle_rad", 3.2, "rad")
    .on("a joint that turns far (is its angle in rad?): largest mean or amplitude of a driven joint");
/// Phases of the angles of joints: any is one within a turn, 6.283 rad. *Choice.*
pub const PHASE: JudgedLimit = JudgedLimit::warn_above("range.joint_phase_rad", 6.3, "rad")
    .on("a phase beyond a whole turn (is it in rad?): largest phase or lag of a driven joint");
/// Density of the fluid: air has 1.2 kg/m3 at sea level and 0.09 at 20 km, in which nothing here flies (ISO 2533). *Choice.*
pub const THIN: JudgedLimit = JudgedLimit::warn_below("range.density_kg_m3", 0.05, "kg/m3")
    .on("air that is nearly a vacuum (is its density in kg/m3?): density");

/// As [`tether.reynolds`](super::tether::VISCOUS), of the strips of a robot.
pub const VISCOUS: JudgedLimit = JudgedLimit::warn_below("range.reynolds", 1e3, "").on(
    "the laws of sections are those of thin plates at Reynolds numbers of 1e3 to 1e5 (are lengths in m and speeds in m/s?): mean of that of the strips",
);

/// Distance of two surfaces that lie on one another, over the larger chord: equal plates 0.138 chords apart wash each other without end
/// at any step, and with 0.15 they do not. The margin is a *choice*.
pub const NEAR: JudgedLimit = JudgedLimit::at_least("range.surfaces_apart_chords", 0.2, "", Outside)
    .on("surfaces lie so near to each other that their wash grows whatever the step (make them one surface, or move them apart): least distance over the larger chord");

/// Sections that the wind meets from behind. No law here knows them: they take lift at the quarter chord behind the nominal leading
/// edge, where it acts at three quarters. *Choice.*
pub const REVERSED: JudgedLimit = JudgedLimit::warn_above("range.reversed_fraction", 0.1, "")
    .on("no law knows wind from behind (is the leading edge ahead?): share of strips and time with an angle of attack above 135 deg");
/// Mostly so: lift acts at the wrong end of the chord. Shipped flights have none. *Choice.*
pub const REVERSED_OUTSIDE: JudgedLimit =
    JudgedLimit::at_most("range.reversed_outside_fraction", 0.5, "", Outside)
        .on("share of strips and time with the wind from behind, an angle of attack above 135 deg");

/// Strips past the angle of attack up to which their law holds: from it on laws `linear` and `stall` are poor, and `lev` and `lev3d` were
/// measured up to 45 deg (`aero.mancini`, `aero.plates`). Any share that would not be printed as 0 % is told.
pub const STALLED: JudgedLimit = JudgedLimit::warn_above("range.stall_fraction", 5e-4, "")
    .on("share of strips and time past what their lift law holds for");
/// Nearly all of a wing: what comes out is a guess at the drag of a plate. Aerobat on its stand in a slow wind has .52, in the first half
/// second of its flight on springs .62, in its turn .15. *Choice.*
pub const STALLED_OUTSIDE: JudgedLimit =
    JudgedLimit::at_most("range.stall_outside_fraction", 0.75, "", Outside)
        .on("no lift law was measured there: share of strips and time with an angle of attack above 45 deg");

/// Springs that carry an inertance: above these harmonics of the gait they vibrate too slowly. *Choice.*
pub const FOLLOWED: JudgedLimit = JudgedLimit::warn_below("range.followed_harmonics", 10.0, "")
    .on("springs carry an inertance for the sake of long steps (shorten them, or flight.inertance_s): frequency up to which it slows vibrations by at most half a per cent, over that of the gait or 1 Hz");
/// Springs that cannot follow the gait itself. *Choice.*
pub const NOT_FOLLOWED: JudgedLimit = JudgedLimit::at_least("range.followed_outside_harmonics", 1.0, "", Outside)
    .on("springs carry so much inertance that they do not follow the motion (flight.inertance_s): frequency up to which it slows vibrations by at most half a per cent, over that of the gait or 1 Hz");

/// Dynamic viscosity, Pa s, of the fluid with a density in kg/m3: air at 20 degrees C (ISO 2533), from 100 kg/m3 on water (IAPWS 2008).
pub fn viscosity(density: f64) -> f64 {
    if density < 100.0 { 1.81e-5 } else { 1.002e-3 }
}

/// All of them.
pub const ALL: [JudgedLimit; 20] = [
    FOLLOWED,
    NOT_FOLLOWED,
    COMPRESSED,
    MACH,
    GYRATION,
    COMPACT,
    CENTRE,
    APART,
    TORN,
    LOADING,
    LINK,
    ANGLE,
    PHASE,
    THIN,
    VISCOUS,
    NEAR,
    STALLED,
    STALLED_OUTSIDE,
    REVERSED,
    REVERSED_OUTSIDE,
];
