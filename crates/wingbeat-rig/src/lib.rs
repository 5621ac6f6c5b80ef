//! The test rig: arm, load cell, Net F/T, experiment, processing.

// Its derive writes nothing: schemas are made by tests alone.
#[cfg(not(feature = "schema"))]
extern crate wingbeat_no_schema as schemars;

pub mod arm;
pub mod carrier;
pub mod cell;
mod deviations;
mod experiment;
mod motion;
pub mod netft;
mod numbers;
pub mod plan;
mod pose;
pub mod process;
mod sensitivity;
mod trajectory;
pub use wingbeat_judge::unit;

pub use deviations::{BenchDeviations, Sinusoid, Unrest, rms_about_mean};
pub use experiment::{Experiment, Outcome};
pub use motion::FrameMotion;
pub use numbers::RigNumbers;
pub use pose::{Pose, rotation_vector};
pub use sensitivity::{Instants, Wrenches};
pub use trajectory::JointTrajectory;
