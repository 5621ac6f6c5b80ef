//! Law `lev` of a wing of finite aspect ratio: the separated part of the flow bears the normal force of a plate of that
//! aspect ratio, and the static stall follows from what the leading edge holds.
//!
//! Valid where the plate's formula is, at aspect ratios of 1 and more. Measured against: plates of AR 2 (steady) and 4 (pitched).

use super::lev::{SEPARATION_CHORDS, STATES, UNTESTED};
use super::{
    Attachment, CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, Law, Section, UNTESTED_DEG, ZERO_LIFT_ANGLE,
};
use crate::SurfaceNumbers;
use wingbeat_math::{Meets, Scalar};

pub(super) struct Lev3d;

impl Section for Lev3d {
    const LAW: Law = Law {
        name: "lev3d",
        meaning: "as `lev`, but separated flow knows the aspect ratio, and its static stall follows from the critical suction",
        parameters: &[CRITICAL_SUCTION, ZERO_LIFT_ANGLE, LIFT_SLOPE, CD0, CD90],
        states: STATES,
        attachment: Attachment::Lagging { state: 1, chords: SEPARATION_CHORDS },
        edge_vortex: true,
        holds_to_deg: Some(UNTESTED_DEG),
        beyond: UNTESTED,
    };

    fn separation<P: Scalar>(numbers: &SurfaceNumbers<P>) -> P {
        scale(numbers.critical_suction)
    }

    #[inline]
    fn broadside<P, G: Scalar + Meets<P>>(absolute_sine: G, relief: P) -> Option<G> {
        Some(plate_force(absolute_sine, relief))
    }
}

/// Scale of [`attached_share`](super::stall::attached_share) for which nine tenths of the lift are attached where the edge
/// lets go in static, plane flow, sin a = A0c (the reading of a static stall that the pages have): 1/(9 A0c^4).
pub(super) fn scale<P: Scalar>(critical_suction: P) -> P {
    let square = critical_suction.squared();
    (square * square * 9.0).recip()
}

/// What the ends of a plate take from its normal force, 0.41 (1 - exp(-17/AR)).
pub(super) fn end_relief<P: Scalar>(aspect: P) -> P {
    (P::ONE - (-aspect.recip() * 17.0).exp()) * 0.41
}

/// Normal force coefficient of a plate over that of an infinite one broadside on and the sine s of its incidence:
/// 1/(0.56 + 0.44 |s|) - 0.41 (1 - exp(-17/AR)). At 90 degrees 0.59 at small aspect ratios (Hoerner 1965, ch. 3: 1.17 of 1.98), 1 at
/// infinite ones.
///
/// Equation: aero.plate_force
/// `normal force of a plate over cd90 sin a: 1/(0.56 + 0.44 abs(sin a)) - 0.41 (1 - exp(-17/AR))`
/// Source: Lindenburg 2001, ECN-RX--01-004; Hoerner 1965 ch. 3.
/// Test: `plates_have_hoerners_drag_broadside_on`.
#[inline]
pub(super) fn plate_force<P, G: Scalar + Meets<P>>(absolute_sine: G, end_relief: P) -> G {
    (absolute_sine * 0.44 + 0.56).recip() - G::from(end_relief)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_have_hoerners_drag_broadside_on() {
        // Hoerner 1965, ch. 3, fig. 28: square plate 1.17, AR 20 1.5 (read +-0.05), infinite plate 1.98.
        for (aspect, drag, near) in [(1.0, 1.17, 0.01), (20.0, 1.5, 0.1), (1e6, 1.98, 1e-3)] {
            let found = 1.98 * plate_force(1.0, end_relief(aspect));
            assert!((found - drag).abs() < near, "AR {aspect}: {found}");
        }
    }

    #[test]
    fn nine_tenths_are_attached_where_the_edge_lets_go() {
        for a0c in [0.11_f64, 0.26] {
            let share = super::super::stall::attached_share(a0c * a0c, scale(a0c));
            assert!((share - 0.9).abs() < 1e-12, "{share}");
        }
    }
}
