//! wingbeat: simulation, calibration and control of dynamic-morphing flapping flight.
//!
//! A scenario says robot, air, manoeuvre and controller; flown, it gives a record and a summary:
//!
//! ```
//! use std::ops::ControlFlow;
//! use wingbeat::scenario::{Document, Scenario};
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
//! let document = Document::file(path.as_ref())?.set("flight.duration_s=0.05").set("aero.preset=full");
//! let run = Scenario::new(document)?.fly(|_| ControlFlow::Continue(()))?;
//!
//! let roll = run.record.values("roll").ok_or("no such column")?;
//! println!("{} rows, last roll {:.3} rad", run.record.rows(), roll[roll.len() - 1]);
//! println!("{:.3} m down, drive {:?} W", -run.summary.altitude_change_m, run.summary.drive_power_w);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A document comes from a file, a text or a value; [`scenario::Doors`] adds manoeuvres, controllers and solvers of
//! one's own to those that a scenario may name. Below the scenario each room stands by itself: a wing in prescribed motion
//! ([`tether`]), one aerodynamic model ([`aero::Surfaces`]), a tree of links ([`body::Tree`]), a robot as a system of
//! differential equations ([`robot::Robot`]), collocation and real-time control of any plant ([`ocp`]).
//!
//! The rooms form a ladder: a room uses only rooms named before it here.

mod error;
mod names;
mod range;

pub mod parallel;
pub mod processor;

pub mod math;
pub mod plant;

pub mod aero;

pub mod body;

pub mod robot;

pub mod ocp;

pub mod simulate;

pub mod orbit;

pub mod guide;

pub mod rig;

pub mod tether;

pub mod scenario;

pub mod learn;

pub use error::Error;
pub(crate) use error::require;
