//! What a run says of the spars of its links.

use serde::Serialize;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::spar::{ANGLE, BEYOND_ANGLE, END, FREQUENCY, GYRATION, OFF_CHORD};
use wingbeat_robot::Robot;

/// Spars of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LinkSparSummary {
    /// Largest angle by which a piece of a spar turns against the one before it, deg.
    pub angle_max_deg: f64,
    /// Error of the lowest frequencies of bending and of twist by the few segments, the larger, as a share: that of the chain over that of the
    /// beam, less one.
    pub frequency_error: f64,
}

impl LinkSparSummary {
    /// Of the spars of `robot` from the columns that `record` has of their joints; none without a spar or a row.
    pub fn of(robot: &Robot, record: &Record) -> Option<Self> {
        let names: Vec<&str> = robot.joint_names().collect();
        let angles = robot.spar_joints().into_iter().filter_map(|joint| record.values(names[joint]));
        let largest = angles.flatten().map(|angle| angle.abs()).reduce(f64::max)?;
        Self::new(robot, largest)
    }

    /// Of the largest angle between two pieces, rad; none without a spar.
    pub fn new(robot: &Robot, angle: f64) -> Option<Self> {
        let frequency_error = robot.spar_shape()?.frequency_error;
        Some(Self { angle_max_deg: angle.to_degrees(), frequency_error })
    }

    /// Holds them against their limits.
    pub fn judge(&self, judge: &mut Judge) {
        judge.hold(&ANGLE, self.angle_max_deg);
        judge.hold(&BEYOND_ANGLE, self.angle_max_deg);
    }
}

/// Holds the spars of `robot` against what spars have.
pub fn hold_shape(judge: &mut Judge, robot: &Robot) {
    let Some(shape) = robot.spar_shape() else { return };
    judge.hold(&FREQUENCY, shape.frequency_error.abs());
    judge.hold_if(&END, shape.in_wing.map(|spar| spar.end_fraction));
    judge.hold_if(&OFF_CHORD, shape.in_wing.map(|spar| spar.off_chord));
    judge.hold_if(&GYRATION, shape.in_wing.map(|spar| spar.gyration));
}
