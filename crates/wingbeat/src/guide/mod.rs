//! Guidance: what to fly and the predictive controller that flies it.

mod manoeuvre;
mod mpc;

pub use manoeuvre::{Manoeuvre, Reference, angle_error};
pub use mpc::{Mpc, MpcSpec, Weights};
