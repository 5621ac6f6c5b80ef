//! wingbeat: simulation, calibration and control of dynamic-morphing flapping flight.
//!
//! The rooms form a ladder: a room uses only rooms named before it here.

mod error;

pub mod parallel;

pub mod math;
pub mod plant;

pub mod aero;

pub mod body;

pub mod robot;

pub mod ocp;

pub mod simulate;

pub mod guide;

pub mod rig;

pub mod tether;

pub mod scenario;

pub use error::Error;
pub(crate) use error::require;
