//! Optimal-control and nonlinear problems with known optima.

pub mod classics;
pub mod flapbody;
pub mod hock_schittkowski;
pub mod trajectories;
