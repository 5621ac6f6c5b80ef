//! Limits of a wing in prescribed motion.

use super::JudgedLimit;
use crate::status::Status::{NotJudged, NotPeriodic, NotResolved, Outside};

/// With half a range the loads say nothing. *Choice.*
pub const STEPS: JudgedLimit = JudgedLimit::at_most("tether.step_change_fraction", 0.5, "", NotResolved)
    .on("largest change of a mean load with half or twice the steps, over the largest load,");
/// With half a range the peaks say nothing either, however well the means hold. *Choice.*
pub const PEAKS: JudgedLimit = JudgedLimit::at_most("tether.peak_change_fraction", 0.5, "", NotResolved).on(
    "largest change of the least or largest of a load with half or twice the steps, over the largest load,",
);
/// With half of it the power says nothing. *Choice.*
pub const STEPS_OF_POWER: JudgedLimit =
    JudgedLimit::at_most("tether.power_change_fraction", 0.5, "", NotResolved)
        .on("change of the mean power with half or twice the steps, over the mean of its size,");
/// Ten times what the shipped cases reach. *Choice.*
pub const CYCLES: JudgedLimit = JudgedLimit::at_most("tether.cycle_change_fraction", 0.01, "", NotPeriodic)
    .on("largest change of a load from the last cycle but one, over the largest of its kind,");

/// Halves of the wing that pass through the middle plane more than a chord from the root.
pub const CROSSING: JudgedLimit = JudgedLimit::warn_above("tether.crossing_fraction", 0.0, "").on(
    "the halves of the wing pass through each other: share of the last cycle in which one lies beyond the middle plane",
);
/// The same for long. *Choice*: the published gait of Aerobat crosses for 0.06 of its cycle.
pub const CROSSED: JudgedLimit = JudgedLimit::at_most("tether.crossing_outside_fraction", 0.15, "", Outside)
    .on("share of the last cycle in which a half of the wing lies beyond the middle plane");
/// A wing on strips near the ground, which leave out the speed along the chord by the images: a rectangle of AR 4 at 5 deg lifts 5 % more
/// than in the lattice at 0.43 mean chords, 13 % at 0.28, 30 % at 0.18 and 88 % at 0.08. *Choice.*
pub const LOW: JudgedLimit = JudgedLimit::at_least("tether.ground_chords", 0.25, "", Outside).on(
    "strips so near to wind.ground_m lift far too much: least distance of the wing from it, in mean chords,",
);
/// A wing that passes through the ground or the ceiling.
pub const GROUND: JudgedLimit = JudgedLimit::at_least("tether.ground_distance_m", 0.0, "m", Outside)
    .on("least distance of the wing from wind.ground_m in the last cycle on the side of the start");
/// Cycles of a motion that repeats: the first begins at rest, and with no cycle before it nothing says how far it is from a periodic one.
pub const FIRST: JudgedLimit = JudgedLimit::at_least("tether.cycles", 2.0, "", NotJudged)
    .on("the motion repeats, but its loads are those of the first cycle from rest, which none before it judges: number of cycles");

/// Ten times what the shipped case reaches with its coefficients. *Choice.*
pub const SPAR: JudgedLimit = JudgedLimit::at_most("tether.spar_grid_fraction", 0.02, "", NotResolved)
    .on("move of the tip at rest with one more coefficient of the spar's strains, over its displacement,");
/// The frequency that a motion below resonance is amplified by: of a spar of one to four elements in heave, power errs by 2 to 4 times its
/// error. *Choice.*
pub const SPAR_LOWEST: JudgedLimit = JudgedLimit::at_most("tether.spar_lowest_fraction", 0.01, "", NotResolved)
    .on("a spar with so few coefficients bends at another frequency: change of its lowest with one more, over it,");
/// Frequencies that few coefficients get wrong: an eigenvalue errs by the square of its shape. *Choice.*
pub const SPAR_FREQUENCY: JudgedLimit = JudgedLimit::warn_above("tether.spar_frequency_fraction", 0.05, "").on(
    "a spar with so few coefficients bends or twists at another frequency: largest change of its three lowest with one more, over them",
);
/// Disturbances of a wing that is held at rest: beyond the speed of flutter or divergence it would leave the shape whose loads are
/// told. Rounding alone grows by 1e-9. *Choice.*
pub const FLUTTER: JudgedLimit = JudgedLimit::at_most("tether.growth_fraction", 1e-3, "", Outside).on(
    "small disturbances of a wing held at rest in the wind flutter or diverge: their growth rate over their angular frequency, or the lowest of the spar where that is larger",
);
/// The same of motions beyond a reduced frequency of 2 and the three lowest of the spar, which air hardly damps. *Choice.*
pub const FAST: JudgedLimit = JudgedLimit::warn_above("tether.fast_growth_fraction", 1e-3, "").on(
    "a spar vibrates too fast for the air of the strips, which says nothing of flutter (give spar.damping_s): growth rate over the angular frequency",
);
/// Stations of a spar without mass, or without inertia about the span, where the wing has a chord. *Choice.*
pub const MASSLESS: JudgedLimit = JudgedLimit::at_least("tether.spar_mass_fraction", 0.01, "", Outside).on(
    "least mass or inertia of a wing per length at a station of the spar, over the square or the fourth power of its chord, beside the median of all,",
);
/// A spar that is lighter than this part of the air about it, pi rho c^2 / 4 per length: films without a spar have 0.15 in air. *Choice.*
pub const LIGHT: JudgedLimit = JudgedLimit::warn_below("tether.spar_over_air", 0.1, "").on(
    "a wing that is lighter than the air about it (is its mass in kg/m?): mass of the spar per length over that of the fluid in the circle on the chord, median of the stations,",
);
/// Line and centres of mass of a spar beyond the edges of its chord, where no wing has them: mass balances reach some tenths. *Choice.*
pub const OFF_CHORD: JudgedLimit = JudgedLimit::at_most("tether.spar_off_chord", 1.0, "", Outside).on(
    "largest distance of the spar's line or of a centre of mass from the chord (are ahead_m, aft_m, up_m and outboard_m in m?), over the mean chord,",
);
/// Radius of gyration about the span over the chord: 0.29 of an even plate. *Choice.*
pub const GYRATION: JudgedLimit = JudgedLimit::at_most("tether.spar_gyration", 1.0, "", Outside).on(
    "an inertia that is large for its mass (is inertia_kg_m in kg m, inertia_kg_m2 in kg m2?): largest radius of gyration of a station or a mass over the mean chord,",
);
/// The same where a wing is a rod alone. *Choice.*
pub const ROD: JudgedLimit = JudgedLimit::warn_below("tether.spar_gyration_least", 0.005, "").on(
    "an inertia that is small for its mass (is inertia_kg_m in kg m?): least radius of gyration of a station about the span over the mean chord,",
);
/// A mass that hangs on a spar in a test of bending has ten times its mass. *Choice.*
pub const LUMP: JudgedLimit = JudgedLimit::warn_above("tether.spar_lump_fraction", 30.0, "").on(
    "a mass that is large for its spar (is mass_kg in kg?): largest of masses over the mass of the spar,",
);
/// Gravity that a spar feels: three times that of the earth. *Choice.*
pub const GRAVITY: JudgedLimit = JudgedLimit::warn_above("tether.spar_gravity_m_s2", 30.0, "m/s2")
    .on("a spar feels more than gravity (is gravity_m_s2 in m/s2?): acceleration");
/// Damping ratio of the lowest frequency of a spar: 0.5 omega damping_s. Structures have 0.05 and less. *Choice.*
pub const DAMPED: JudgedLimit = JudgedLimit::warn_above("tether.spar_damping_ratio", 0.3, "").on(
    "a spar that hardly oscillates (is damping_s in s?): damping ratio of its lowest frequency without air",
);
/// Span over mean chord below which strips and lifting line are far off: at one they give 4/3 of the lift of a slender wing (R. T. Jones,
/// NACA report 835, 1946), at a half 8/5.
pub const SLENDER: JudgedLimit = JudgedLimit::warn_below("tether.aspect_ratio", 1.0, "").on(
    "strips and lifting line hold for wings that are wide (are the chords in m?): span over the mean chord",
);
/// Reduced frequency by the root mean square of the speed. Lift is compared up to 1; beyond 2 the wing meets its own wake of the last
/// stroke within a chord or two, which rolls up where the models keep it in place. *Choice.*
pub const REDUCED: JudgedLimit = JudgedLimit::warn_above("tether.reduced_frequency", 2.0, "").on(
    "the wing hardly leaves its wake of the stroke before (are chords in m and the frequency in Hz?): pi f times the mean chord over the root mean square of its speed through the air",
);
/// Least power that momentum asks of any wing within the sphere of this one, over what it gives to the air: shipped cases have 0.91 and
/// less, an elliptic wing at rest nearly 1. Above it a model gives force for nothing. The margin is a *choice*.
pub const IDEAL: JudgedLimit = JudgedLimit::at_most("tether.ideal_power_fraction", 1.05, "", Outside).on(
    "the model gives more force than any wing of this reach can for its power, as where a wing comes back into its own wake: ideal power of the disc that it reaches over its power into the air,",
);
/// Cycles of a wing that goes on, as a rotor by a table does: the power of the first holds the start from rest.
pub const TURNING: JudgedLimit = JudgedLimit::warn_below("tether.turning_cycles", 2.0, "").on(
    "the power is not held against the ideal one (tether.ideal_power_fraction), as it holds the start from rest (take more time.cycles): cycles of a wing that goes on for more than some chords",
);
/// Way of the wind in a cycle over the longest way of a section in it. A revolving wing of two blades, with 0.32, has 3 % more
/// thrust by strips than by the prescribed lattice, and with 0.064 29 % more than by the free one; the shipped flapping cases have 0.25 and more. *Choice.*
pub const ADVANCE: JudgedLimit = JudgedLimit::warn_below("tether.advance_ratio", 0.2, "").on(
    "the wing comes back into its own wake, which strips take to lie straight behind them (free wakes of `wingbeat wake` do not): way of the wind in a cycle over that of the tips",
);
/// Reynolds number of the mean chord and speed below which no section law here was measured, thin plates from 1e3 on.
pub const VISCOUS: JudgedLimit = JudgedLimit::warn_below("tether.reynolds", 1e3, "").on(
    "the laws of sections are those of thin plates at Reynolds numbers of 1e3 to 1e5 (are lengths in m and speeds in m/s?): that of the mean chord and speed",
);

/// All of them.
pub const ALL: [JudgedLimit; 28] = [
    STEPS,
    STEPS_OF_POWER,
    PEAKS,
    CYCLES,
    CROSSING,
    CROSSED,
    GROUND,
    LOW,
    FIRST,
    SPAR,
    SPAR_LOWEST,
    SPAR_FREQUENCY,
    FLUTTER,
    FAST,
    MASSLESS,
    LIGHT,
    OFF_CHORD,
    GYRATION,
    ROD,
    LUMP,
    GRAVITY,
    DAMPED,
    SLENDER,
    REDUCED,
    IDEAL,
    TURNING,
    ADVANCE,
    VISCOUS,
];
