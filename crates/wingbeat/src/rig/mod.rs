//! The test rig: arm, load cell, Net F/T, experiment, processing.

pub mod arm;
mod motion;
pub mod plan;
mod pose;
mod trajectory;

pub use motion::FrameMotion;
pub use pose::{Pose, rotation_vector};
pub use trajectory::Trajectory;
