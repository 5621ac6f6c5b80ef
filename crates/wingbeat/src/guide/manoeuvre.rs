//! What the robot is asked to do: attitude and angular rate over time.

use crate::math::{Scalar, Vec3};
use serde::{Deserialize, Serialize};

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

/// A level approach, then a turn at constant bank.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Manoeuvre {
    /// Start of the turn, s.
    pub turn_start_s: f64,
    /// Bank in the turn, deg; positive is right wing down.
    pub roll_deg: f64,
    /// Pitch throughout, deg; negative is nose up.
    pub pitch_deg: f64,
    /// Heading rate in the turn, rad/s; negative turns right.
    pub yaw_rate_rad_s: f64,
}

impl Manoeuvre {
    /// The reference at time `t`: within the turn the body rates are those of a
    /// steady turn, w = psi' (-sin theta, cos theta sin phi, cos theta cos phi).
    pub fn reference(&self, t: f64) -> Reference {
        let turning = t >= self.turn_start_s;
        let (roll, yaw_rate) =
            if turning { (self.roll_deg.to_radians(), self.yaw_rate_rad_s) } else { (0.0, 0.0) };
        let pitch = self.pitch_deg.to_radians();
        let ((sp, cp), (sr, cr)) = (pitch.sin_cos(), roll.sin_cos());
        Reference { roll, pitch, w: Vec3::new(-sp, cp * sr, cp * cr) * yaw_rate }
    }
}

/// Difference of two angles, rad, without wrapping for |difference| < pi.
#[inline]
pub fn angle_error<S: Scalar>(angle: S, reference: f64) -> S {
    let difference = angle - reference;
    let turns = (difference.value() / std::f64::consts::TAU).round();
    difference - turns * std::f64::consts::TAU
}
