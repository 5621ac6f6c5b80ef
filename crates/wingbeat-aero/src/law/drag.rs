//! Profile drag: skin friction, and the plate in separated flow.

use super::Polar;
use wingbeat_math::Error;
use wingbeat_math::require;
use wingbeat_math::{Meets, Over, Scalar};

/// Drag of skin and separation, cd0 + cd90 sin^2(incidence).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProfileDrag<P = f64> {
    /// Drag coefficient along the chord.
    pub cd0: P,
    /// Drag coefficient of the plate broadside on.
    pub cd90: P,
}

/// Section drag by components and where it acts.
pub(crate) struct SectionDrag<S> {
    /// Force along the chord per dynamic scale rho c dy / 2, m2/s2.
    pub chordwise: S,
    /// Force along the normal, likewise.
    pub normal: S,
    /// Centre of pressure as chord fraction from the leading edge.
    pub centre: S,
}

/// Width of the smooth |sin| in the centre of pressure.
const SINE_WIDTH: f64 = 0.02;

impl ProfileDrag {
    /// Refuses negative coefficients.
    pub(crate) fn check(&self) -> Result<(), Error> {
        require::not_negative("drag.cd0", self.cd0)?;
        require::not_negative("drag.cd90", self.cd90)
    }
}

impl<P: Scalar> ProfileDrag<P> {
    /// The same without what `cd0` gives: what is left is the plate's, as the drag is linear in both.
    pub(crate) fn of_plate(&self) -> Self {
        Self { cd0: P::ZERO, cd90: self.cd90 }
    }

    /// Profile drag of a section that meets the wind (`uc`, `w`) at mid chord.
    ///
    /// Law `linear`: (cd0 + cd90 sin^2) along the wind, centre from 1/4 to 1/2
    /// chord with sin^2. Laws that separate: cd0 along the wind, and of the normal
    /// force cd90 sin the separated share, at Rayleigh's (1876) centre
    /// 1/2 - (3/4) cos / (4 + pi |sin|); under `lev3d` that force is a plate's of the surface's aspect ratio.
    ///
    /// Equation: aero.profile_drag
    /// `cd0 + cd90 sin^2 a along the wind; law stall: normal force cd90 sin a on the separated share, centre 1/2 -
    /// (3/4) cos a / (4 + pi sin a)`
    /// Source: Rayleigh 1876; Hoerner 1965.
    /// Test: `any_wind_gives_finite_loads_that_vary_smoothly`.
    #[inline]
    pub(crate) fn section<G: Scalar + Meets<P>, S: Over<G> + Meets<P>>(
        &self,
        polar: &Polar<P>,
        uc: G,
        w: G,
        attached: S,
        delta2: f64,
    ) -> SectionDrag<S> {
        let speed = (uc * uc + w * w + delta2).sqrt();
        let inverse = speed.recip();
        let sine = w * inverse;
        match polar.law.separates() {
            false => {
                let sine2 = sine * sine;
                let along = speed * (sine2 * self.cd90 + self.cd0);
                let (chordwise, normal) = (S::from(along * uc), S::from(along * w));
                SectionDrag { chordwise, normal, centre: S::from(sine2 * 0.25 + 0.25) }
            }
            true => {
                let absolute = sine.smooth_abs(SINE_WIDTH);
                let mut broadside = G::from(self.cd90);
                if let Some(share) = polar.law.broadside(absolute, polar.end_relief) {
                    broadside *= share;
                }
                let plate = (S::ONE - attached) * broadside + self.cd0;
                let centre = G::from(0.5) - uc * inverse * 0.75 / (absolute * std::f64::consts::PI + 4.0);
                let chordwise = S::from(speed * uc * self.cd0);
                SectionDrag { chordwise, normal: plate * (speed * w), centre: S::from(centre) }
            }
        }
    }
}
