//! Aerodynamic loads, named by source.

use super::MAX_STRIPS;
use crate::math::{Scalar, Wrench};

/// Loads of one strip by source.
#[derive(Clone, Copy, Debug, Default)]
pub struct StripLoads<S: Scalar> {
    /// Lift of the bound and shed vorticity, perpendicular to the wind the
    /// section meets by its own motion.
    pub circulatory: Wrench<S>,
    /// What the wash of wake and lags adds by turning that force: induced drag.
    pub induced_drag: Wrench<S>,
    /// Reaction of the accelerated air, with the section moment of pitching.
    pub added_mass: Wrench<S>,
    /// Skin friction and separation, along the wind.
    pub profile_drag: Wrench<S>,
}

impl<S: Scalar> StripLoads<S> {
    /// Sum over the sources.
    pub fn total(&self) -> Wrench<S> {
        self.circulatory + self.induced_drag + self.added_mass + self.profile_drag
    }
}

/// Loads of the whole wing.
///
/// The body acceleration may still be unknown when the loads are computed:
/// with s = [acceleration of the body origin; angular acceleration] (inertial,
/// in B) beyond what the sections' accelerations hold, the true wrench is
/// `wrench - added_mass s`.
#[derive(Clone, Copy, Debug)]
pub struct Loads<S: Scalar> {
    /// Sum over strips and sources.
    pub wrench: Wrench<S>,
    /// Added-mass matrix on [acceleration; angular acceleration], symmetric, about the body origin.
    pub added_mass: [[S; 6]; 6],
    /// Strips from left tip to right tip; the first `strips` are valid.
    pub strip: [StripLoads<S>; MAX_STRIPS],
    /// Incidence that each strip meets, wash included, rad.
    pub incidence: [S; MAX_STRIPS],
    /// Wash along the normal that each strip meets at 3/4 chord, m/s.
    pub wash: [S; MAX_STRIPS],
    /// Circulation of each strip, m2/s.
    pub circulation: [S; MAX_STRIPS],
    /// Number of strips.
    pub strips: usize,
}

impl<S: Scalar> Default for Loads<S> {
    fn default() -> Self {
        Self {
            wrench: Wrench::ZERO,
            added_mass: [[S::ZERO; 6]; 6],
            strip: [StripLoads::default(); MAX_STRIPS],
            incidence: [S::ZERO; MAX_STRIPS],
            wash: [S::ZERO; MAX_STRIPS],
            circulation: [S::ZERO; MAX_STRIPS],
            strips: 0,
        }
    }
}

impl<S: Scalar> Loads<S> {
    /// Sum over strips by source.
    pub fn by_source(&self) -> StripLoads<S> {
        self.strip[..self.strips].iter().fold(StripLoads::default(), |sum, s| StripLoads {
            circulatory: sum.circulatory + s.circulatory,
            induced_drag: sum.induced_drag + s.induced_drag,
            added_mass: sum.added_mass + s.added_mass,
            profile_drag: sum.profile_drag + s.profile_drag,
        })
    }
}
