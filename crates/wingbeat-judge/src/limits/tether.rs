//! Limits of a wing in prescribed motion.

use super::Limit;
use crate::status::Status::{NotPeriodic, NotResolved};

/// With half a range the loads say nothing. *Choice.*
pub const STEPS: Limit = Limit::at_most("tether.step_change_fraction", 0.5, "", NotResolved)
    .on("largest change of a mean load with other steps per cycle, over the largest load,");
/// Ten times what the shipped cases reach. *Choice.*
pub const CYCLES: Limit = Limit::at_most("tether.cycle_change_fraction", 0.01, "", NotPeriodic)
    .on("largest change of a load from the last cycle but one, over the largest of its kind,");
/// Camber beyond which thin-aerofoil theory is poor. *Choice.*
pub const MEMBRANE_CAMBER: Limit = Limit::warn_above("tether.membrane_camber_fraction", 0.15, "")
    .on("largest rise of a membrane over its chord, beyond which thin-aerofoil theory does not hold");
/// Membranes that are slack for long. *Choice.*
pub const MEMBRANE_SLACK: Limit = Limit::warn_above("tether.membrane_slack_fraction", 0.05, "")
    .on("share of the strips on which a membrane is slack along the chord and wrinkles, which the model does not know");
/// Frequency of the motion that lets a membrane follow without inertia, which is of the order of the square. *Choice.*
pub const MEMBRANE_FREQUENCY: Limit = Limit::warn_above("tether.membrane_frequency_fraction", 0.25, "")
    .on("frequency of the motion over that of the membrane, whose inertia is left out");

/// All of them.
pub const ALL: [Limit; 5] = [STEPS, CYCLES, MEMBRANE_CAMBER, MEMBRANE_SLACK, MEMBRANE_FREQUENCY];
