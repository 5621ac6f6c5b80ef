//! Planning of banking turns on an arm: the path, its place in the workspace,
//! the joint motion, and what of the limits it uses.

mod approach;
mod clearance;
mod place;
mod report;
mod track;
mod turn;
mod usage;

pub use approach::{Approach, LARGEST_POSITION};
pub use clearance::{Clearance, Envelope, clearance};
pub use place::{Margins, Placed, Workspace};
pub use report::{Plan, Refusal};
pub use track::{Instant, Placement, Untracked, track};
pub use turn::{Turn, TurnPath, TurnSpec};
pub use usage::{LimitKind, Peak, binding, peaks};
