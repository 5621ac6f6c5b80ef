//! What the tests of this crate look at beyond its public items. It is no part of what the crate promises.
//!
//! The tests stand in a program of their own: with them in the modules the whole crate would be compiled twice.

pub use crate::document::airfoil::AirfoilFile;
pub use crate::document::limits::{LARGEST, largest, text_of, unit};
pub use crate::document::outline::drawing::{DrawingPoint, read as read_drawing};
pub use crate::document::outline::{MOST as MOST_STATIONS, OutlineFile};
pub use crate::document::source::{brief, joined};
pub use crate::document::tree::{path, steps};
#[cfg(feature = "schema")]
pub use crate::schema::plain;
pub use crate::sound::rows;
pub use crate::tether::{change, ladder, observed_order};
pub use crate::trim::alone::balance::least;
pub use crate::trim::alone::guess::Size;
pub use crate::trim::alone::{RobotTrim, STALLED, next};
pub use crate::trim::search::descent::{DescentPoint, Ended, Landscape, Slopes, descend};
pub use crate::trim::search::quadratic::{QuadraticStep, step};
