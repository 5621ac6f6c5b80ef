//! Aerodynamics of a flapping, folding wing: planform, station, section laws,
//! Wagner lags, lifting line, added mass. Knows no body: stations come in, loads go out.

mod loads;
mod planform;
mod station;

pub use crate::math::Wrench;
pub use loads::{Loads, StripLoads};
pub use planform::{Planform, PlanformStation};
pub use station::SectionMotion;

/// Largest number of strips; loads live on the stack.
pub const MAX_STRIPS: usize = 32;
