//! Flight: what advances a robot in time and what steers it.
//!
//! [`simulate`] holds the one stepper, the instruments and the record; [`orbit`] finds periodic flight; [`guide`] holds
//! manoeuvres and controllers; [`tether`] moves a wing through air as prescribed; [`cycle`] averages over the phase of a cycle.

// Its derive writes nothing: schemas are made by tests alone.
#[cfg(not(feature = "schema"))]
extern crate wingbeat_no_schema as schemars;

pub mod cycle;
pub mod guide;
pub mod orbit;
pub mod simulate;
pub mod tether;
