//! Limits of a wing in prescribed motion.

use super::Limit;
use crate::status::Status::{NotPeriodic, NotResolved, Outside};

/// With half a range the loads say nothing. *Choice.*
pub const STEPS: Limit = Limit::at_most("tether.step_change_fraction", 0.5, "", NotResolved)
    .on("largest change of a mean load with other steps per cycle, over the largest load,");
/// Ten times what the shipped cases reach. *Choice.*
pub const CYCLES: Limit = Limit::at_most("tether.cycle_change_fraction", 0.01, "", NotPeriodic)
    .on("largest change of a load from the last cycle but one, over the largest of its kind,");

/// Halves of the wing that pass through the middle plane more than a chord from the root.
pub const CROSSING: Limit = Limit::warn_above("tether.crossing_fraction", 0.0, "").on(
    "the halves of the wing pass through each other: share of the last cycle in which one lies beyond the middle plane",
);
/// The same for long. *Choice*: the published gait of Aerobat crosses for 0.06 of its cycle.
pub const CROSSED: Limit = Limit::at_most("tether.crossing_outside_fraction", 0.15, "", Outside)
    .on("share of the last cycle in which a half of the wing lies beyond the middle plane");
/// Cycles of a motion that repeats: the first begins at rest and is that of no periodic flow.
pub const FIRST: Limit = Limit::warn_below("tether.cycles", 2.0, "")
    .on("the motion repeats, but the loads are those of the first cycle from rest: number of cycles");

/// Ten times what the shipped case reaches with its coefficients. *Choice.*
pub const SPAR: Limit = Limit::at_most("tether.spar_grid_fraction", 0.02, "", NotResolved)
    .on("move of the tip at rest with one more coefficient of the spar's strains, over its displacement,");

/// A wing that flutters or diverges leaves the shape whose loads are told. Rounding makes 1e-9.
pub const GROWTH: Limit = Limit::at_most("tether.growth_1_s", 0.01, "1/s", Outside)
    .on("the wing flutters or diverges: growth rate of small disturbances of its shape at rest in the wind");

/// All of them.
pub const ALL: [Limit; 7] = [STEPS, CYCLES, CROSSING, CROSSED, FIRST, SPAR, GROWTH];
