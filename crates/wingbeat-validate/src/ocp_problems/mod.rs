//! Optimal-control and nonlinear problems with known optima.

pub mod hock_schittkowski;
pub mod trajectories;
