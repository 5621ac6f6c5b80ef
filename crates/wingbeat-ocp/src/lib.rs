//! Optimal control by direct collocation: states and inputs at the nodes of a
//! mesh are the unknowns, the dynamics hold at collocation points. Knows no wing.
//!
//! A [`Transcription`] turns an interval into quadrature weights and a defect;
//! [`realtime`] tracks a reference over a short horizon, many times a second;
//! [`interior_point`] solves sparse nonlinear programs ([`nlp`]) offline.

mod collocation;
mod defects;
pub mod interior_point;
mod interpolant;
mod mesh;
mod multipliers;
pub mod nlp;
pub mod plant;
mod problem;
pub mod realtime;
mod scaled;
mod scheme;
mod starts;
mod trajectory;
mod transcription;

pub use collocation::{Collocation, Transcribed};
pub use defects::defects;
pub use interpolant::Interpolant;
pub use mesh::{Misses, Optimum, Pass, Progress, Refinement, optimise, optimise_stage};
pub use multipliers::Multipliers;
pub use problem::{Ends, FREE, Instant, Limits, OptimalControl, Scales, Setup};
pub use scheme::{InputShape, Scheme};
pub use starts::Starts;
pub use starts::optimise_from;
pub use trajectory::Trajectory;
pub use transcription::Midpoint;
pub use transcription::{IntervalEnds, Transcription};
