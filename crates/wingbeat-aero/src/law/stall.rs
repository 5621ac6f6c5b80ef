//! Quasi-steady stall of a thin, flat wing.

use super::{Attachment, CD0, CD90, LIFT_SLOPE, Law, STALL_ANGLE, Section, ZERO_LIFT_ANGLE};
use wingbeat_math::{Meets, Scalar};

pub(super) struct Stall;

impl Section for Stall {
    const LAW: Law = Law {
        name: "stall",
        meaning: "attached lift fades at once with the angle of attack, the normal force of a plate takes its place",
        parameters: &[STALL_ANGLE, ZERO_LIFT_ANGLE, LIFT_SLOPE, CD0, CD90],
        states: &[],
        attachment: Attachment::AtOnce,
        edge_vortex: false,
        holds_to_deg: None,
        beyond: "is quasi-steady, so that lift is only within +-50 % there, and a mean thrust may have the other sign",
    };
}

/// Share of the lift that stays attached, from the squared sine of the effective angle of attack; `scale` is the
/// fourth power of 1/sine at which half is left.
///
/// Equation: aero.attached_share
/// `attached share of the lift 1 / (1 + (sin a / sin a_s)^4 / 3)`
/// Source: Hoerner 1965 ch. 3 (plate in separated flow); the blend is a choice.
/// Test: `duals_agree_with_central_differences`.
#[inline]
pub(super) fn attached_share<P, S: Scalar + Meets<P>>(sine_squared: S, scale: P) -> S {
    (sine_squared * sine_squared * scale + 1.0).recip()
}

/// Scale of [`attached_share`] for which the attached lift is largest at the stall angle: x / (1 + x^4)
/// peaks at x^4 = 1/3.
pub(super) fn scale<P: Scalar>(stall_angle_rad: P) -> P {
    let square = stall_angle_rad.sin().squared();
    (square * square * 3.0).recip()
}
