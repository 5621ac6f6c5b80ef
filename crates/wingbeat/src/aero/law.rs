//! Section laws: how lift saturates, and the profile drag.

use crate::Error;
use crate::math::{Over, Scalar};
use crate::require;

/// What becomes of the attached lift as the incidence grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LiftLaw {
    /// Lift proportional to the wash at any incidence: the paper's law, which
    /// knows no stall. Valid below the stall angle.
    Linear,
    /// Flat, thin wing at low Reynolds number (1e3 to 1e5): the attached lift
    /// fades with the flow's separation and the normal force of a plate in
    /// separated flow takes its place (Hoerner 1965, ch. 3; Dickinson, Lehmann
    /// & Sane 1999). Quasi-steady: no dynamic-stall vortex is shed, so it errs
    /// where the incidence crosses the stall angle faster than about a chord
    /// of travel, and at thick or strongly cambered sections.
    Stall,
}

impl LiftLaw {
    /// Name as written in configurations and results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Stall => "stall",
        }
    }

    /// Share of the lift that stays attached, from the squared sine of the
    /// effective incidence; `scale` is the fourth power of 1/sine at which
    /// half is left, see [`separation_scale`].
    ///
    /// Equation: aero.attached_share
    #[inline]
    pub(super) fn attached_share<S: Scalar>(self, sine_squared: S, scale: f64) -> S {
        match self {
            Self::Linear => S::ONE,
            Self::Stall => (sine_squared * sine_squared * scale + 1.0).recip(),
        }
    }
}

/// Scale of [`LiftLaw::attached_share`] for which the attached lift is largest
/// at the stall angle: x / (1 + x^4) peaks at x^4 = 1/3.
pub(super) fn separation_scale(stall_angle_rad: f64) -> f64 {
    stall_angle_rad.sin().powi(-4) / 3.0
}

/// Drag of skin and separation, cd0 + cd90 sin^2(incidence).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileDrag {
    /// Drag coefficient along the chord.
    pub cd0: f64,
    /// Drag coefficient of the plate broadside on.
    pub cd90: f64,
}

/// Section drag by components and where it acts.
pub(super) struct SectionDrag<S> {
    /// Force along the chord per dynamic scale rho c dy / 2, m2/s2.
    pub chordwise: S,
    /// Force along the normal, likewise.
    pub normal: S,
    /// Centre of pressure as chord fraction from the leading edge.
    pub centre: S,
}

/// Width of the smooth |sin| in the centre of pressure.
const SINE_WIDTH: f64 = 0.02;

/// Refuses stall angles outside (0, pi/2), rad.
pub(super) fn check_stall_angle(angle: f64) -> Result<(), Error> {
    if angle > 0.0 && angle < std::f64::consts::FRAC_PI_2 {
        return Ok(());
    }
    Err(Error::invalid("stall_angle_rad", angle, "between 0 and pi/2"))
}

impl ProfileDrag {
    /// Refuses negative coefficients.
    pub(super) fn check(&self) -> Result<(), Error> {
        require::not_negative("drag.cd0", self.cd0)?;
        require::not_negative("drag.cd90", self.cd90)
    }

    /// Profile drag of a section that meets the wind (`uc`, `w`) at mid chord.
    ///
    /// Law `linear`: (cd0 + cd90 sin^2) along the wind, centre from 1/4 to 1/2
    /// chord with sin^2. Law `stall`: cd0 along the wind, and of the normal
    /// force cd90 sin the separated share, at Rayleigh's (1876) centre
    /// 1/2 - (3/4) cos / (4 + pi |sin|).
    ///
    /// Equation: aero.profile_drag
    #[inline]
    pub(super) fn section<G: Scalar, S: Over<G>>(
        self,
        law: LiftLaw,
        uc: G,
        w: G,
        attached: S,
        delta2: f64,
    ) -> SectionDrag<S> {
        let speed = (uc * uc + w * w + delta2).sqrt();
        let inverse = speed.recip();
        let sine = w * inverse;
        match law {
            LiftLaw::Linear => {
                let sine2 = sine * sine;
                let along = speed * (sine2 * self.cd90 + self.cd0);
                let (chordwise, normal) = (S::from(along * uc), S::from(along * w));
                SectionDrag { chordwise, normal, centre: S::from(sine2 * 0.25 + 0.25) }
            }
            LiftLaw::Stall => {
                let plate = (S::ONE - attached) * self.cd90 + self.cd0;
                let centre = G::from(0.5)
                    - uc * inverse * 0.75 / (sine.smooth_abs(SINE_WIDTH) * std::f64::consts::PI + 4.0);
                let chordwise = S::from(speed * uc * self.cd0);
                SectionDrag { chordwise, normal: plate * (speed * w), centre: S::from(centre) }
            }
        }
    }
}
