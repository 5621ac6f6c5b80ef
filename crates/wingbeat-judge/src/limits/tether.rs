//! Limits of a wing in prescribed motion.

use super::Limit;
use crate::status::Status::{NotPeriodic, NotResolved};

/// With half a range the loads say nothing. *Choice.*
pub const STEPS: Limit = Limit::at_most("tether.step_change_fraction", 0.5, "", NotResolved)
    .on("largest change of a mean load with other steps per cycle, over the largest load,");
/// Ten times what the shipped cases reach. *Choice.*
pub const CYCLES: Limit = Limit::at_most("tether.cycle_change_fraction", 0.01, "", NotPeriodic)
    .on("largest change of a load from the last cycle but one, over the largest of its kind,");

/// All of them.
pub const ALL: [Limit; 2] = [STEPS, CYCLES];
