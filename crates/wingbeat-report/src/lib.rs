//! Runs as one page that moves, and in the files of other programs.
//!
//! [`run::read`] reads a run folder; [`page::page`] writes a page that needs no network and no library: WebGL 2, or a canvas where there
//! is none. What moves comes from the code that flew it: [`motion::RunMotion`] holds the robot of the run's scenario in the states of its
//! record.

pub mod animate;
mod error;
pub mod export;
pub mod files;
mod flight;
pub mod growing;
mod held;
pub mod motion;
mod pack;
pub mod page;
pub mod panels;
pub mod run;
pub mod sheet;
mod wake;

pub use error::Error;
