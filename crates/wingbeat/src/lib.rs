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
//! println!("{:.3} m down, drive {:?} W", -run.summary.altitude_change_m, run.summary.measured.get("drive_power_w"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A document comes from a file, a text or a value; [`scenario::Doors`] adds manoeuvres, controllers and solvers of
//! one's own to those that a scenario may name. Below the scenario each part stands by itself: a wing in prescribed motion
//! ([`tether`]), one aerodynamic model ([`aero::Surfaces`]), a tree of links ([`body::Tree`]), a robot as a system of
//! differential equations ([`robot::Robot`]), collocation and real-time control of any plant ([`ocp`]).
//!
//! This crate holds no code: each name below is a crate, or a module of one, that can be used without those above it.

pub use wingbeat_aero as aero;
pub use wingbeat_config as scenario;
#[cfg(feature = "learn")]
pub use wingbeat_config::learn;
pub use wingbeat_flight::{guide, orbit, simulate, tether};
pub use wingbeat_judge as judge;
pub use wingbeat_math as math;
pub use wingbeat_math::{Error, parallel, processor};
pub use wingbeat_ocp as ocp;
pub use wingbeat_ocp::plant;
pub use wingbeat_rig as rig;
pub use wingbeat_robot as robot;
pub use wingbeat_robot::body;
pub use wingbeat_structure as structure;
