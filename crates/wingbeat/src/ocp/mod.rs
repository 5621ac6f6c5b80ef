//! Optimal control by direct collocation: states and inputs at the nodes of a
//! mesh are the unknowns, the dynamics hold at collocation points. Knows no wing.
//!
//! A [`Transcription`] turns an interval into quadrature weights and a defect;
//! [`realtime`] tracks a reference over a short horizon, many times a second;
//! [`interior_point`] solves sparse nonlinear programs ([`nlp`]) offline.

pub mod interior_point;
pub mod nlp;
pub mod realtime;
mod transcription;

pub use transcription::{Interval, Midpoint, Transcription};
