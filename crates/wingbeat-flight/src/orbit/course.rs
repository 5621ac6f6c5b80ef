//! What an orbit is asked to do.

use wingbeat_math::{GRAVITY, Scalar};

/// A steady course: mean speed along its horizontal projection, mean climb, and for a turn its bank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course {
    /// Mean horizontal speed, m/s.
    pub speed: f64,
    /// Mean climb, m/s; negative descends.
    pub climb: f64,
    /// Bank that the rate of turn asks for, rad; positive is right wing down, a turn to the right.
    pub bank: f64,
}

impl Course {
    /// Rate of the heading, rad/s, positive to the left: -g tan(bank) / V. By Newton's law the mean force of the air, in
    /// axes that turn with it, is m (g up + V |rate| towards the centre): inclined by this bank. It lies in the plane of
    /// symmetry where the body rolls by as much, up to products of the swings of force and attitude: so the mean roll is
    /// the fourth condition of a turn. No sideslip would be another: side force comes from rates and strokes too.
    ///
    /// Equation: orbit.yaw_rate
    /// `-g tan(bank) / V`
    /// Source: coordinated turn.
    /// Test: `a_turn_takes_the_rate_that_its_bank_asks_for`.
    pub fn yaw_rate(&self) -> f64 {
        -GRAVITY * self.bank.tan() / self.speed
    }

    /// Length of the chord of the path over `duration` s, over that time, m/s: V sin(a)/a with
    /// a = yaw rate times duration / 2.
    pub fn chord_speed<S: Scalar>(&self, duration: S) -> S {
        let half = duration * (0.5 * self.yaw_rate());
        if half.value().abs() < 1e-8 { S::from(self.speed) } else { half.sin() / half * self.speed }
    }

    /// True for a turn.
    pub fn turns(&self) -> bool {
        self.bank != 0.0
    }
}
