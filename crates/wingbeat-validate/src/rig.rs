//! Arm, load cell and processing.

mod arm;
mod runs;

pub use runs::processed_run;

use crate::Case;

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "rig.forward_kinematics", quick: true, run: arm::forward_kinematics },
    Case { id: "rig.inverse_kinematics", quick: true, run: arm::inverse_kinematics },
    Case { id: "rig.limits_respected", quick: false, run: runs::limits_respected },
    Case { id: "rig.wrench_static", quick: true, run: runs::wrench_static },
    Case { id: "rig.newton_euler", quick: false, run: runs::newton_euler },
    Case { id: "rig.filter", quick: true, run: runs::filter },
    Case { id: "rig.vacuum", quick: true, run: runs::vacuum },
    Case { id: "rig.pipeline_recovers_truth", quick: false, run: runs::pipeline_recovers_truth },
];
