//! Whether a result can be used: one list of statuses, one table of limits, one kind of verdict.
//!
//! A verb makes a [`Judge`] with the [`RunLimits`] of its document, holds each of its quantities against a [`JudgedLimit`], and
//! writes the [`Verdict`] into its summary:
//!
//! ```
//! use wingbeat_judge::{Judge, RunLimits, Status, limits::flight};
//!
//! let limits = RunLimits::default().with("flight.altitude_m", 3.0)?;
//! let mut judge = Judge::new(&limits);
//! judge.hold(&flight::SATURATION, 0.1);
//! judge.hold(&flight::ALTITUDE, 6.6);
//!
//! let verdict = judge.verdict();
//! assert_eq!(verdict.status, Status::OffTarget);
//! assert!(verdict.judged[1].overridden && !verdict.judged[0].overridden);
//! # Ok::<(), wingbeat_judge::UnknownLimit>(())
//! ```
//!
//! Measured data go to [`data`] first, whose findings are held against the limits of kind `data`.
//!
//! This crate knows no robot, no file and no verb, so that every other crate can use it.

pub mod data;
pub mod limits;
mod status;
pub mod unit;
mod verdict;

pub use limits::{JudgedLimit, RunLimits, Sense, UnknownLimit};
pub use status::Status;
pub use verdict::{Judge, Judged, Verdict, Warning};
