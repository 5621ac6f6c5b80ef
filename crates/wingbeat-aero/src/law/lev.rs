//! Leading-edge vortex: suction that the leading edge cannot hold becomes a lagged normal force, and separation
//! lags behind the effective incidence.
//!
//! Of the lift the attached share stays, of the suction the held share of that: Kirchhoff's flow loses both at the same
//! rate at first, lift as ((1 + sqrt f)/2)^2 and chord force as sqrt f (Leishman & Beddoes 1989).
//!
//! Valid for sections whose flow separates at the leading edge, up to 45 deg in ramps of some chords of travel. The
//! vortex acts at 1/4 chord and sheds no circulation of its own into the wake: both a choice.

use super::{
    Attachment, CD0, CD90, CRITICAL_SUCTION, LIFT_SLOPE, Law, Polar, STALL_ANGLE, Section, StripState,
    UNTESTED_DEG, ZERO_LIFT_ANGLE,
};
use wingbeat_math::{Meets, Over, Scalar};

pub(super) struct Lev;

impl Section for Lev {
    const LAW: Law = Law {
        name: "lev",
        meaning: "suction beyond a critical one becomes the normal force of a leading-edge vortex; separation lags",
        parameters: &[STALL_ANGLE, CRITICAL_SUCTION, ZERO_LIFT_ANGLE, LIFT_SLOPE, CD0, CD90],
        states: STATES,
        attachment: Attachment::Lagging { state: 1, chords: SEPARATION_CHORDS },
        edge_vortex: true,
        holds_to_deg: Some(UNTESTED_DEG),
        beyond: UNTESTED,
    };
}

/// What laws that know separation do past [`UNTESTED_DEG`].
pub(super) const UNTESTED: &str = "was not measured there";

/// What a strip carries.
pub(super) const STATES: &[StripState] = &[
    StripState { name: "vortex", unit: "m2/s2", meaning: "vortex force" },
    StripState { name: "separated", unit: "", meaning: "flow separated" },
];

/// Chords of travel in which the vortex takes over the lost suction: a choice within the 1 to 4 chords that a
/// leading-edge vortex needs to form (Gharib, Rambod & Shariff 1998; Ramesh et al. 2014).
const VORTEX_CHORDS: f64 = 1.0;
/// Chords of travel in which separation follows the incidence: a choice of the order of Goman & Khrabrov's tau_1 and
/// of the vortex's stay over the chord.
pub(super) const SEPARATION_CHORDS: f64 = 8.0;

/// The flow about a leading edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeadingEdge<S> {
    /// Share of the linear suction that the edge holds.
    pub held: S,
    /// Normal force of the suction lost, to the side of the wash, over rho c dy / 2, m2/s2.
    pub lost: S,
}

/// What the edge holds of `suction`, the linear one over rho c dy / 2 (m2/s2), at the square `speed2` of the
/// airspeed: c_s (1 + r^4)^(-1/4), r = c_s/(a0 A0c^2), so that it never exceeds a0 A0c^2 (a0 the section's lift slope); the rest
/// acts along the normal, to the side of `wash`, the wash at the edge (m/s), whose sign is rounded off at `floor` m/s.
///
/// Equation: aero.lev.suction
/// `held c_s (1 + r^4)^(-1/4), r = c_s/(a0 A0c^2); the rest along the normal`
/// Source: Polhamus 1966, NASA TN D-3767; Ramesh et al. 2014, J. Fluid Mech. 751; the rounding a choice.
/// Test: `the_edge_holds_no_more_than_its_limit_and_loses_nothing_else`.
#[inline]
pub(crate) fn edge<P: Scalar, G: Scalar + Meets<P>, S: Over<G>>(
    polar: &Polar<P>,
    suction: S,
    wash: S,
    speed2: G,
    floor: f64,
) -> LeadingEdge<S> {
    let over = suction * (speed2.recip() * polar.inverse_limit);
    let held = (over.squared().squared() + 1.0).sqrt().sqrt().recip();
    let side = wash * wash.smooth_abs(floor).recip();
    LeadingEdge { held, lost: suction * (S::ONE - held) * side }
}

/// Rate of the vortex of a strip: v' = V (lost - v)/(tau_v c).
///
/// Equation: aero.lev.vortex
/// `v' = V (lost - v)/(tau_v c), tau_v = 1`
/// Source: the 1 to 4 chords of Gharib, Rambod & Shariff 1998; a choice.
/// Test: `states_follow_in_their_chords_of_travel`.
#[inline]
pub(crate) fn vortex_rate<G: Scalar, S: Over<G>>(vortex: S, lost: S, chords_per_second: G) -> S {
    (lost - vortex) * (chords_per_second * (1.0 / VORTEX_CHORDS))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LiftLaw, SurfaceNumbers};
    use std::f64::consts::TAU;
    use wingbeat_math::Dual;

    fn polar() -> Polar<f64> {
        let (zero, angle) = (0.0, 0.2);
        let numbers = SurfaceNumbers {
            density: 1.0,
            section_slope: TAU,
            zero_lift_angle: zero,
            cd0: zero,
            cd90: zero,
            stall_angle: angle,
            critical_suction: 0.2,
            added_mass_scale: 1.0,
            lags: arrayvec::ArrayVec::new(),
            membrane: None,
            flap: None,
            outline: None,
            hinges: Vec::new(),
            webs: Vec::new(),
        };
        Polar::new(LiftLaw::Lev, &numbers, 4.0)
    }

    #[test]
    fn the_edge_holds_no_more_than_its_limit_and_loses_nothing_else() {
        let polar = polar();
        let limit = TAU * 0.04 * 9.0;
        let mut last = 0.0;
        for k in 0..400 {
            let suction = 0.03 * f64::from(k);
            let LeadingEdge { held, lost } = edge(&polar, suction, -1.0, 9.0, 1e-9);
            assert!(held * suction >= last && held * suction <= limit);
            assert!((held * suction - lost - suction).abs() < 1e-12);
            last = held * suction;
        }
        assert!(last > 0.98 * limit);
        let exact = edge(&polar, Dual::<1>::variable(2.0, 0), Dual::constant(0.3), Dual::constant(9.0), 0.02);
        let near = |x: f64| edge(&polar, x, 0.3, 9.0, 0.02).lost;
        assert!((exact.lost.eps[0] - (near(2.0 + 1e-6) - near(2.0 - 1e-6)) / 2e-6).abs() < 1e-7);
    }

    #[test]
    fn states_follow_in_their_chords_of_travel() {
        let polar = polar();
        let still = polar.separated_share(1.0);
        let separated = |now: f64| Polar::<f64>::separation_rate(now, still, 5.0, SEPARATION_CHORDS);
        assert!((vortex_rate(0.0, 2.0, 5.0) - 10.0).abs() < 1e-12);
        assert!((separated(0.0) - still * 5.0 / 8.0).abs() < 1e-12);
        assert_eq!((vortex_rate(2.0, 2.0, 5.0), separated(still)), (0.0, 0.0));
    }
}
