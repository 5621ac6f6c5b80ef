//! The test rig: arm, load cell, Net F/T, experiment, processing.

pub mod arm;
mod motion;
mod pose;

pub use motion::FrameMotion;
pub use pose::{Pose, rotation_vector};
