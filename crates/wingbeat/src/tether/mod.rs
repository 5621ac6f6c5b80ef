//! A wing in prescribed motion in a wind, without a robot: hinges and body
//! follow given functions of time; loads come out.

mod coordinate;
mod recorder;
mod run;
mod wing;

pub use coordinate::Coordinate;
pub use recorder::{CycleMean, TetherRun};
pub use run::{Clock, Motion, Reference, Tether};
pub use wing::{Hinge, HingeKind, Side, TetheredBody, Wing};
