//! Optimal-control and nonlinear problems with known optima.

pub mod classics;
pub mod flapbody;
pub mod hock_schittkowski;
mod problem;
pub mod trajectories;
