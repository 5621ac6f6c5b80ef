//! Arm, load cell and processing.

mod arm;

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "rig.forward_kinematics", quick: true, run: arm::forward_kinematics },
    Case { id: "rig.inverse_kinematics", quick: true, run: arm::inverse_kinematics },
];
