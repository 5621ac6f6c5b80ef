//! Tasks to be learned: robots side by side, each steered by normalised actions, observed and rewarded.
//!
//! ```
//! use std::sync::Arc;
//! use wingbeat_config::learn::{BankingTurn, Flock, Precision};
//! use wingbeat_config::Scenario;
//!
//! let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
//! let scenario = Scenario::load(path.as_ref(), &[])?;
//! let task = Arc::new(BankingTurn::of(&scenario)?);
//! let mut flock = Flock::new(&scenario, task, 3, 1, Precision::Double)?;
//! let start = flock.reset(&[7, 8, 9], 1.0);
//! let batch = flock.step(&vec![0.0; 3 * flock.actions()])?;
//! assert_eq!((start.len(), batch.rewards.len()), (3 * flock.observations(), 3));
//! assert!(batch.rewards.iter().all(|reward| *reward > 0.0 && *reward < 1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod flock;
mod lanes;
mod turn;

pub use flock::{Batch, Flock, PERIOD_S, STEP_S, SavedRobot};
pub use lanes::Precision;
pub use turn::BankingTurn;

use std::fmt::Debug;
use wingbeat_math::Random;
use wingbeat_ocp::plant::Channel;

/// A robot at the end of a step, as its task sees it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Time since the start of the episode, s.
    pub t: f64,
    /// Phase of the gait, rad.
    pub phase: f64,
    /// State, in the units of the robot's channels.
    pub x: &'a [f64],
    /// Action in force, each a share of the command's range in [-1, 1].
    pub action: &'a [f64],
}

/// What is to be learned: what is seen, what is rewarded, when it has failed.
pub trait Task: Debug + Send + Sync {
    /// What an observation holds, in order; its numbers are kept within the channels' limits.
    fn observation(&self) -> &[Channel];

    /// Writes an observation, in the units of its channels.
    fn observe(&self, view: &View, values: &mut [f64]);

    /// Names of the terms whose sum is the reward.
    fn terms(&self) -> &[&'static str];

    /// Writes the terms of the reward, dimensionless.
    fn reward(&self, view: &View, terms: &mut [f64]);

    /// True when the episode has failed.
    fn failed(&self, view: &View) -> bool;

    /// Duration after which an episode is cut off, s.
    fn duration_s(&self) -> f64;

    /// Varies the state at the start by the factor `spread` on what is usual for the task.
    fn vary(&self, x: &mut [f64], spread: f64, random: &mut Random);
}
