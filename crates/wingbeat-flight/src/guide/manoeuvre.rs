//! What the robot is asked to do: attitude and angular rate over time.

use std::fmt::Debug;
use wingbeat_math::Error;
use wingbeat_math::{Scalar, Vec3};

/// z_ref = [roll, pitch, angular rate] of the paper's cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reference {
    /// Roll, rad; positive is right wing down.
    pub roll: f64,
    /// Pitch, rad; negative is nose up.
    pub pitch: f64,
    /// Angular rate w_WB_B, rad/s.
    pub w: Vec3,
}

/// What is flown: a reference at any time. [`Turn`](super::Turn) is the one that ships;
/// a scenario names another by its table, `[manoeuvre.NAME]`.
pub trait Manoeuvre: Debug + Send + Sync {
    /// Checks ranges.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key, as the manoeuvre's table has it.
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }

    /// Keys of its table that say when something begins, with that time, s. A flight that ends before says that it never does.
    fn begins(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// The reference at the time `t`, s. A controller asks at every node of its horizon, in no order.
    fn reference(&self, t: f64) -> Reference;
}

/// Difference of two angles, rad, without wrapping for |difference| < pi.
#[inline]
pub fn angle_error<S: Scalar>(angle: S, reference: f64) -> S {
    let difference = angle - reference;
    let turns = (difference.value() / std::f64::consts::TAU).round();
    difference - turns * std::f64::consts::TAU
}
