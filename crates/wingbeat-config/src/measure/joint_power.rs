//! Means of what drive and actuators give to the joints.

use super::Measure;
use crate::summary::{Settled, given, mean};

const DRIVE: &str = "drive_power";
const ACTUATORS: &str = "regulator_power";

fn of(settled: &Settled<'_>, column: &str) -> Option<f64> {
    mean(settled.in_strokes(column))
}

fn given_of(settled: &Settled<'_>, column: &str) -> Option<f64> {
    given(settled.in_strokes(column))
}

pub(super) const MEASURES: &[Measure] = &[
    Measure {
        key: "drive_power_w",
        meaning: "Mean power of the drive on the joints, W: what turning the crank takes.",
        line: None,
        always: true,
        swept: None,
        value: |settled| of(settled, DRIVE),
    },
    Measure {
        key: "regulator_power_w",
        meaning: "Mean power of the actuators on the joints, W: what displacing the structure takes.",
        line: None,
        always: true,
        swept: None,
        value: |settled| of(settled, ACTUATORS),
    },
    Measure {
        key: "drive_power_given_w",
        meaning: "Mean of what the drive gives alone, W: what comes back from the joints counts as lost.",
        line: Some(("power of the drive", 3, "W, that takes nothing back")),
        always: true,
        swept: None,
        value: |settled| given_of(settled, DRIVE),
    },
    Measure {
        key: "regulator_power_given_w",
        meaning: "Mean of what the actuators give alone, W: what those pay that cannot take back.",
        line: Some(("power of the actuators", 3, "W, likewise")),
        always: true,
        swept: None,
        value: |settled| given_of(settled, ACTUATORS),
    },
];
