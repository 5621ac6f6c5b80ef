//! Periodic flight: orbits of a robot whose crank turns at a constant rate, how they are found, whether they hold.
//!
//! An orbit returns after a cycle to the state it began with, but for its place and heading: level and climbing flight
//! are periodic up to a displacement, turns up to a rotation about the vertical too (relative periodic orbits).
//! Unknown are the state at phase 0 ([`OrbitSection`]) and the numbers that may be chosen ([`Free`]); asked is a
//! [`Course`]. [`search`] finds the orbit by a recoil start and Newton's method on derivatives of the flow over
//! a cycle, exact at first and then learned from its steps; [`floquet`] tells how small disturbances grow.

mod along;
mod course;
mod cycle;
mod failure;
mod linear;
mod measure;
mod modes;
mod newton;
mod recoil;
mod section;

pub use along::intervals_along;
pub use course::Course;
pub use cycle::PARTS;
pub use cycle::{Cycle, End, Free, Point};
pub use failure::Failure;
pub use linear::{Deviations, Interval, alone, interval, intervals};
pub(crate) use linear::{fly_held, fly_part};
pub use measure::{Measures, SKIN, StripAreas, measure};
pub use modes::{Mode, Modes, Sector, floquet, floquet_over};
pub use newton::{FoundOrbit, Orbit, search};
pub use newton::{Tangent, search_from, search_near, steadiness};
pub use recoil::{drift, settle};
pub use section::{Direction, OrbitSection};
