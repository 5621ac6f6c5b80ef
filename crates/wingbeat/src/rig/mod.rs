//! The test rig: arm, load cell, Net F/T, experiment, processing.

pub mod arm;
pub mod carrier;
pub mod cell;
mod experiment;
mod motion;
pub mod netft;
pub mod plan;
mod pose;
pub mod process;
mod trajectory;
pub mod unit;

pub use experiment::{Experiment, Outcome};
pub use motion::FrameMotion;
pub use pose::{Pose, rotation_vector};
pub use trajectory::Trajectory;
