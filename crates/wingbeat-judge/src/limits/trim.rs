//! Limits of a periodic flight. All values are choices; the shipped trims of level flight lie well within them.

use super::JudgedLimit;
use crate::status::Status::{NotFound, NotResolved, OffTarget, Outside};

/// Power that a flyer must be exceptional for. Birds and bats have flight muscles of 15 to 30 % of the body, and quail give
/// 350 to 400 W per kg of muscle in the strokes of a take-off, the most that was measured (Askew, Marsh & Ellington 2001,
/// J. Exp. Biol. 204, 3601): about 100 W/kg of the body. Cruising birds need 15 to 40 W/kg. Shipped cruises take 53 to 134.
pub const HIGH_POWER: JudgedLimit = JudgedLimit::warn_above("trim.high_power_w_kg", 200.0, "W/kg")
    .on("mean of the positive mechanical power over the mass");
/// Power that neither muscles nor the motors of robots of this size give over whole cycles.
pub const POWER: JudgedLimit = JudgedLimit::at_most("trim.power_w_kg", 400.0, "W/kg", Outside)
    .on("mean of the positive mechanical power over the mass");
/// Power at one instant that nothing gives, ten times what is `outside` over whole cycles. *Choice*: it holds for flights shorter than a cycle,
/// whose power has no mean.
pub const PEAK: JudgedLimit = JudgedLimit::at_most("trim.peak_power_w_kg", 4000.0, "W/kg", Outside).on(
    "size of the mechanical power at a recorded instant over the mass; on a rig of springs on pins alone",
);
/// Stall in which the wing does most of its work. The deepest shipped cruise, on the linkage, has 0.41.
pub const BEYOND_20: JudgedLimit = JudgedLimit::at_most("trim.stall_fraction_20", 0.5, "", Outside)
    .on("share of U^2 c dy dt beyond 20 deg angle of attack");
/// Wings that pass through each other or through the body.
pub const CLEARANCE: JudgedLimit = JudgedLimit::at_least("trim.clearance_m", 0.0, "m", Outside)
    .on("least clearance between parts of the robot");
/// Wings whose skins touch: a clearance is that of surfaces without thickness, and a skin takes 3 mm.
pub const SKIN: JudgedLimit = JudgedLimit::warn_below("trim.skin_clearance_m", 0.003, "m")
    .on("the wings touch where their skin is 3 mm: least clearance between surfaces without thickness");
/// Growth of a disturbance over a cycle. Instability is information, so the limit is one that only a document lowers.
pub const MULTIPLIER: JudgedLimit = JudgedLimit::at_most("trim.multiplier", 100.0, "", OffTarget)
    .on("largest magnitude of a Floquet multiplier, that of the heading left out");
/// Growth at which a small disturbance that no gains hold takes a flight from its orbit within some fifty cycles.
pub const GROWS: JudgedLimit = JudgedLimit::warn_above("trim.growing_multiplier", 1.02, "")
    .on("neither the orbit itself nor its gains hold a flight: growth of the worst disturbance over a cycle");
/// The same growth where gains hold what does not hold itself: flown without them, as `orbit.toml` is, the flight leaves its orbit.
pub const ALONE_GROWS: JudgedLimit = JudgedLimit::warn_above("trim.unheld_multiplier", 1.02, "")
    .on("only the feedback of gains.csv holds this flight: growth of the worst disturbance over a cycle without it");
/// The same growth under gains that are worse than none.
pub const GAINS_GROW: JudgedLimit = JudgedLimit::warn_above("trim.gains_multiplier", 1.02, "")
    .on("the orbit holds itself and its gains upset it: growth of the worst disturbance over a cycle under gains.csv");
/// Conditions of the orbit, which Newton's method meets to 1e-11.
pub const RESIDUAL: JudgedLimit = JudgedLimit::at_most("trim.residual", 1e-8, "", NotFound)
    .on("largest error of a condition of the orbit, in SI units");

/// Mean upward force of an orbit, which is the weight whatever its path: what differs is lost between the steps of the integration. Shipped
/// trims have 1e-6 and less. *Choice.*
pub const WEIGHT: JudgedLimit = JudgedLimit::at_most("trim.weight_error_fraction", 0.01, "", NotResolved)
    .on("the loads of the orbit do not carry its weight, and are lost between its steps (shorten trim.step_s): difference of the mean upward force from the weight, over it");
/// Steps of the orbit's cycle. With 17 the power of `cruise_20g` is 1.2 % above that of 170.
pub const STEPS: JudgedLimit = JudgedLimit::warn_below("trim.steps_per_cycle", 40.0, "")
    .on("the steps of the integration are long (shorten trim.step_s): number of steps of a cycle");

/// All of them.
pub const ALL: [JudgedLimit; 13] = [
    HIGH_POWER,
    POWER,
    PEAK,
    BEYOND_20,
    CLEARANCE,
    SKIN,
    MULTIPLIER,
    GROWS,
    ALONE_GROWS,
    GAINS_GROW,
    RESIDUAL,
    WEIGHT,
    STEPS,
];
