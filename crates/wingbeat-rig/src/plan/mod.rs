//! Planning of banking turns on an arm: the path, its place in the workspace,
//! the joint motion, and what of the limits it uses.

mod approach;
mod clearance;
mod place;
mod report;
mod track;
mod turn;
mod usage;

pub use approach::{ArmApproach, LARGEST_POSITION};
pub use clearance::{Clearance, Envelope, clearance};
pub use place::{Margins, PlacedTurn, PlacementWorkspace};
pub use report::{Refusal, TurnPlan};
pub use track::{PathPlacement, TrackInstant, Untracked, track};
pub use turn::{BankingPath, TurnPath, TurnSpec};
pub use usage::{LimitKind, Peak, binding, peaks};
