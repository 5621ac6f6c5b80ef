//! Limits of a flight. All values are choices; each stands beside what shipped flights that hold their task reach.

use super::JudgedLimit;
use crate::status::Status::{NotResolved, OffTarget, Outside};

/// Height against the reference of a controller that tracks. Held flights stay within 0.02 m; lost ones pass 5 m.
pub const ALTITUDE: JudgedLimit = JudgedLimit::at_most("flight.altitude_m", 2.0, "m", OffTarget)
    .on("largest distance from the reference height");
/// Roll and pitch against the reference, each. Held flights stay within 7 deg, of which the body's own motion in a stroke
/// is the most.
pub const ATTITUDE: JudgedLimit =
    JudgedLimit::at_most("flight.attitude_rms_deg", 10.0, "deg", OffTarget).on("rms error of roll or pitch");
/// Heading flown over the heading that the manoeuvre asks, from the settling time on: below 0 the robot turns to the other side, whatever its bank.
pub const TURNED: JudgedLimit = JudgedLimit::at_least("flight.turned_fraction", 0.0, "", OffTarget)
    .on("the robot turns to the other side than manoeuvre.yaw_rate_rad_s asks (controller.weights.rate_axes weighs the heading rate): heading flown over the heading asked");
/// The same of a turn that is flown in part. *Choice.*
pub const TURNED_IN_PART: JudgedLimit = JudgedLimit::warn_below("flight.turned_in_part_fraction", 0.5, "")
    .on("the robot hardly turns (controller.weights.rate_axes weighs the heading rate that manoeuvre.yaw_rate_rad_s asks): heading flown over the heading asked");
/// Errors of an estimator, of height, velocity, roll, pitch and rates, over what its filter expects: 1 of one that knows how well it knows.
/// The shipped flight has .73; beyond 4 the errors are twice what it says. *Choice.*
pub const ESTIMATE: JudgedLimit = JudgedLimit::warn_above("flight.estimate_normalised_square", 4.0, "")
    .on("the estimator believes too much: mean square of its errors over the variances that it states");
/// Distance from the path. Held flights stay within 0.1 m.
pub const PATH: JudgedLimit =
    JudgedLimit::at_most("flight.path_m", 2.0, "m", OffTarget).on("largest distance across the path");
/// Place along the path, beside that which time and speed ask. Shipped flights stay within 0.5 m.
pub const ALONG: JudgedLimit = JudgedLimit::at_most("flight.path_along_m", 2.0, "m", OffTarget)
    .on("largest distance along the path from where time and speed ask the robot to be");
/// Velocity along the heading beside that of the orbit. Shipped flights stay within 0.04; one with three times its drag flies at 0.26 less.
pub const SPEED: JudgedLimit = JudgedLimit::at_most("flight.speed_error_fraction", 0.15, "", OffTarget)
    .on("rms error of the velocity along the heading over the mean velocity asked");
/// Distance from the place to hover at. Held flights stay within 0.02 m.
pub const PLACE: JudgedLimit = JudgedLimit::at_most("flight.place_rms_m", 1.0, "m", OffTarget)
    .on("rms distance from the place of the hover");
/// Steepness of a controlled flight that has no reference for its height. The banking turn sinks by 15 deg.
pub const PATH_ANGLE: JudgedLimit = JudgedLimit::at_most("flight.path_angle_deg", 30.0, "deg", OffTarget)
    .on("mean angle of the path above or below the horizon");
/// The same of a flight that nothing controls: it falls as its robot does.
pub const FREE_PATH_ANGLE: JudgedLimit = JudgedLimit::warn_above("flight.free_path_angle_deg", 45.0, "deg")
    .on("nothing controls this flight: mean angle of the path above or below the horizon");
/// A path steeper than any glide that was shipped: what carries the weight there is drag. Gliders keep below 30 deg. *Choice.*
pub const FALLS: JudgedLimit = JudgedLimit::at_most("flight.falling_path_angle_deg", 75.0, "deg", OffTarget)
    .on("nothing controls this flight, and it falls: mean angle of the path above or below the horizon");
/// What carries the weight over whole cycles: a glide and a level flight have 1, a fall 0, a robot that dives because it is nose heavy .5 at first.
/// The least of shipped flights without a controller has .86. *Choice.*
pub const CARRIED: JudgedLimit = JudgedLimit::at_least("flight.weight_carried", 0.3, "", OffTarget)
    .on("the robot falls: mean upward force of air and thrusters over the weight");
/// Commands at their limits, where the controller has no more to give. Held flights stay within 0.64.
pub const SATURATION: JudgedLimit = JudgedLimit::at_most("flight.saturation_fraction", 0.7, "", OffTarget)
    .on("share of the commands at a limit");
/// A robot that passes through the ground or the ceiling, where its mirror image passes through it: impossible, so the limit is zero.
pub const GROUND: JudgedLimit = JudgedLimit::at_least("flight.ground_distance_m", 0.0, "m", Outside)
    .on("least distance of body and wings from air.ground_m on the side of the start");
/// As [`tether.ground_chords`](super::tether::LOW), of a robot on strips.
pub const LOW: JudgedLimit = JudgedLimit::at_least("flight.ground_chords", 0.25, "", Outside).on(
    "strips so near to air.ground_m lift far too much: least distance of body and wings from it, in mean chords,",
);
/// Wings that pass through each other or through the body: impossible, so the limit is zero.
pub const CROSSING: JudgedLimit = JudgedLimit::at_most("flight.crossing_fraction", 0.0, "", Outside)
    .on("share of the time in which parts of the robot pass through each other");
/// Some time beyond the velocities at which `robot.residual` was measured.
pub const LEAVES_RESIDUAL: JudgedLimit = JudgedLimit::warn_above("flight.leaves_residual_fraction", 0.05, "")
    .on("share of the time beyond the velocities at which robot.residual was measured");
/// Most of the time beyond them.
pub const BEYOND_RESIDUAL: JudgedLimit =
    JudgedLimit::at_most("flight.beyond_residual_fraction", 0.5, "", Outside)
        .on("share of the time beyond the velocities at which robot.residual was measured");
/// Updates that failed, so that the previous plan was flown.
pub const FAILURES: JudgedLimit =
    JudgedLimit::at_most("flight.controller_failures_fraction", 0.1, "", NotResolved)
        .on("share of the updates in which the controller found no solution, or none by its deadline");
/// Error of the integration's steps that a reader must know.
pub const STEP_ERROR: JudgedLimit = JudgedLimit::warn_above("flight.step_error_m", 0.01, "m")
    .on("the steps of the integration are too long (shorten flight.step_s): error of the last position, by a second flight in half steps, of a controller of your own as it is estimated,");
/// Error of the integration's steps that leaves nothing of the flight.
pub const STEPS_LOST: JudgedLimit = JudgedLimit::at_most("flight.steps_lost_m", 1.0, "m", NotResolved)
    .on("the steps of the integration are too long (shorten flight.step_s): error of the last position, by a second flight in half steps, of a controller of your own as it is estimated,");
/// Error of steps that were chosen by an error.
pub const STEPS_ASKED: JudgedLimit = JudgedLimit::at_most("flight.error_asked_fraction", 1.0, "", NotResolved)
    .on("flight.error_m cannot be kept by steps of flight.step_s / 64 or more: the error of the last position as it was measured, over flight.error_m");

/// Angular momentum in a vacuum, which nothing can change but the error of the steps. The shipped turn of a 20 g robot leaves 2e-12.
pub const MOMENTUM: JudgedLimit = JudgedLimit::at_most("flight.angular_momentum_kg_m2_s", 1e-9, "kg m2/s", NotResolved)
    .on("the steps of the integration are too long (shorten flight.step_s): largest change of the angular momentum in a vacuum");

/// Deviation of the turbulence over its airspeed. Taylor 1938: a frozen field needs it small; 0.3 is a choice.
pub const TURBULENCE: JudgedLimit = JudgedLimit::warn_above("flight.turbulence_over_airspeed", 0.3, "")
    .on("largest deviation of turbulence that is taken to fly past frozen over air.dryden.airspeed_m_s");
/// Turbulence as strong as the stream that carries it past, which no frozen field is.
pub const TURBULENCE_STRONG: JudgedLimit =
    JudgedLimit::at_most("flight.turbulence_beyond_airspeed", 1.0, "", Outside)
        .on("largest deviation of turbulence, too strong to fly past frozen, over air.dryden.airspeed_m_s");
/// Mean airspeed of the flight against that at which its turbulence passes: the larger over the smaller, less one.
pub const TURBULENCE_SPEED: JudgedLimit = JudgedLimit::warn_above("flight.turbulence_speed", 0.3, "")
    .on("the turbulence passes at another speed than the robot flies: larger of its mean airspeed and air.dryden.airspeed_m_s over the smaller, less one");
/// The same where the spectra by time are those of another turbulence.
pub const TURBULENCE_ELSEWHERE: JudgedLimit = JudgedLimit::at_most("flight.turbulence_other_speed", 1.0, "", Outside)
    .on("the turbulence passes at quite another speed than the robot flies: larger of its mean airspeed and air.dryden.airspeed_m_s over the smaller, less one");

/// Height that a dive takes from level flight to level flight, over the velocity head v^2/(2 g) of that flight: robots that fly alike at
/// other sizes dive alike. The shipped dive, with the nose down by 60 deg, takes 1.42 of 0.93 m.
pub const DIVE_HEIGHT: JudgedLimit = JudgedLimit::at_most("flight.dive_velocity_heads", 1.6, "", OffTarget)
    .on("height lost in a dive and its pull-out over v^2/(2 g) of the level flight before it");
/// What the plan of a dive would still gain by going on: it ends when an iteration saves less.
pub const DIVE_PLAN: JudgedLimit = JudgedLimit::warn_above("flight.dive_plan_fraction", 1e-3, "")
    .on("the plan of the dive is not at its least after its most iterations: share of its cost that the last one saved");
/// The same of a landing.
pub const LANDING_PLAN: JudgedLimit = JudgedLimit::warn_above("flight.landing_plan_fraction", 1e-3, "")
    .on("the plan of the landing is not at its least after its most iterations: share of its cost that the last one saved");
/// What the plan ends with over what `[perch]` asks of the claw: beyond one a flight on the plan misses it.
pub const LANDING_ASKED: JudgedLimit = JudgedLimit::warn_above("flight.landing_end_fraction", 1.0, "")
    .on("the plan of the landing ends faster or further from hanging than the claw latches (controller.orbit.landing): the larger of both over what perch allows");
/// Distance of wings and body from the perch, but for the claw, which is a point: with less, skins of 3 mm meet it.
pub const PERCH_CLEARANCE: JudgedLimit =
    JudgedLimit::at_least("flight.perch_clearance_m", 0.003, "m", Outside)
        .on("least distance of the surfaces and capsules of the robot from the perch");
/// Clearance that the controller is asked to keep: two of what its program allows for rounding.
pub const KEPT: JudgedLimit = JudgedLimit::at_most("flight.clearance_short_fraction", 0.01, "", OffTarget)
    .on("shortfall of the least clearance, as a share of controller.orbit.clearance_m");
/// Updates whose best commands left a clearance too small somewhere in the cycle ahead: a later one may mend it.
pub const NOT_KEPT: JudgedLimit = JudgedLimit::warn_above("flight.clearance_not_kept_fraction", 0.0, "")
    .on("share of the updates at which no commands keep controller.orbit.clearance_m over the cycle ahead");
/// Pitch against the plan of a dive. The shipped one stays within 2 deg in still air.
pub const DIVE_PITCH: JudgedLimit = JudgedLimit::at_most("flight.dive_pitch_deg", 10.0, "deg", OffTarget)
    .on("largest error of the pitch in a dive");
/// What a plan that leaves out the structure missed at the next update: *choice*, a tenth of the deviation that costs a full command. The
/// shipped soft robots miss .002 and .04; one on spars four times as soft, which does not hold its turn, .41.
pub const PLAN_ERROR: JudgedLimit = JudgedLimit::warn_above("flight.plan_error", 0.1, "")
    .on("rms difference of height, velocity, roll, pitch and rates from the plan, one update later, each over the deviation that costs a full command (controller.orbit.predictive.structure)");

/// Attitude that an update found against that which it was prepared for: *choice*, from where the linearisation of the attitude is off by some
/// .4 % (1 - sin x/x).
pub const PREPARED_MISSED: JudgedLimit = JudgedLimit::warn_above("flight.prepared_missed_deg", 9.0, "deg")
    .on("largest angle between the attitude that an update found and that which it was prepared for (controller.prepared)");

/// Cycles of the gait over which a flight's means are taken: of less than one they are those of the part of the stroke that was flown.
pub const AVERAGED: JudgedLimit = JudgedLimit::warn_below("flight.cycles_averaged", 1.0, "")
    .on("means are not those of whole cycles (lengthen flight.duration_s, or mend a drive that does not turn): number of cycles of the gait in the part of the flight that counts");

/// Records of a cycle from which means, shares and extremes are taken. Of 53 of 58 shipped flights whose last cycle alone is read at equal parts,
/// wherever these begin, the positive power errs by 11 % at most with 12 and by 1.4 % with 32 (52 of them 7 and 1.1 %). Where commands leap within
/// a cycle (`banking_turn_short`, `paper_plan`, `roll_in`, `loaded_bank15`) or wings pause (`bounding_20g`) it errs by 8 to 32 % with 32, by 1 to
/// 7 % with 50; over several cycles that are no multiple of the interval these errors cancel in part.
pub const FEW_RECORDS: JudgedLimit = JudgedLimit::warn_below("flight.few_records_per_cycle", 32.0, "")
    .on("powers, means and least clearance are those of few records (shorten flight.record_every_s): number of records in a cycle of the gait, or in a second of wings at rest");
/// Records that are so few that nothing taken from them holds: *choice*, where the positive power of most gaits errs by up to 7 %.
pub const RECORDS: JudgedLimit = JudgedLimit::at_least("flight.records_per_cycle", 12.0, "", NotResolved)
    .on("powers, means and least clearance are lost between the records (shorten flight.record_every_s): number of records in a cycle of the gait, or in a second of wings at rest");
/// Distance of the ends of two flights under a controller, the second by steps of a tenth of the error asked, over that error: what the loop
/// makes of the errors of steps.
pub const ERROR_GROWN: JudgedLimit = JudgedLimit::at_most("flight.error_grown_fraction", 1.0, "", NotResolved)
    .on("flight.error_m is not kept, since the closed loop lets errors grow (ask for less, if rounding leaves it): distance from where a flight of a tenth of flight.error_m ends, over flight.error_m");
/// As [`tether.ideal_power_fraction`](super::tether::IDEAL), over whole cycles of a flight: of shipped ones that are `ok` it is 0.45 and less. The margin is a
/// *choice*.
pub const IDEAL: JudgedLimit = JudgedLimit::at_most("flight.ideal_power_fraction", 1.05, "", Outside).on(
    "the models carry the robot with less power than any wings of its span can, as where wings come back into their own wake: ideal power of the disc on the span over the power into the air,",
);
/// Pitch up to which roll and heading are those of a body: beyond 85 deg a turn about the vertical axis is a turn of roll too, and an error of
/// either is multiplied by 11 (1/cos). *Choice.*
pub const VERTICAL: JudgedLimit = JudgedLimit::warn_above("flight.vertical_deg", 85.0, "deg")
    .on("roll, pitch and heading say nothing of a flight whose nose points straight up or down, and are left out: largest pitch");

/// All of them.
pub const ALL: [JudgedLimit; 44] = [
    FEW_RECORDS,
    RECORDS,
    ERROR_GROWN,
    VERTICAL,
    IDEAL,
    DIVE_HEIGHT,
    PERCH_CLEARANCE,
    DIVE_PLAN,
    LANDING_PLAN,
    LANDING_ASKED,
    DIVE_PITCH,
    KEPT,
    NOT_KEPT,
    ALTITUDE,
    ATTITUDE,
    TURNED,
    TURNED_IN_PART,
    ESTIMATE,
    PATH,
    ALONG,
    SPEED,
    PLACE,
    PATH_ANGLE,
    FREE_PATH_ANGLE,
    FALLS,
    CARRIED,
    SATURATION,
    CROSSING,
    LEAVES_RESIDUAL,
    BEYOND_RESIDUAL,
    FAILURES,
    STEP_ERROR,
    STEPS_LOST,
    STEPS_ASKED,
    MOMENTUM,
    GROUND,
    LOW,
    TURBULENCE,
    TURBULENCE_STRONG,
    TURBULENCE_SPEED,
    TURBULENCE_ELSEWHERE,
    PLAN_ERROR,
    PREPARED_MISSED,
    AVERAGED,
];
