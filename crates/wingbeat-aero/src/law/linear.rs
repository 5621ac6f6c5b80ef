//! Lift proportional to the wash at any angle of attack.

use super::{Attachment, CD0, CD90, LIFT_SLOPE, Law, Section, ZERO_LIFT_ANGLE};

pub(super) struct Linear;

impl Section for Linear {
    const LAW: Law = Law {
        name: "linear",
        meaning: "lift proportional to the wash at any angle of attack; knows no stall",
        parameters: &[ZERO_LIFT_ANGLE, LIFT_SLOPE, CD0, CD90],
        states: &[],
        attachment: Attachment::Whole,
        edge_vortex: false,
        holds_to_deg: None,
        beyond: "ignores stall, so its forces are not reliable there",
    };
}
