//! Aerodynamic loads, named by source.

use super::MAX_STRIPS;
use crate::math::{Scalar, Vec3};
use std::ops::{Add, AddAssign};

/// Force (N) and moment about the body origin (N m), resolved in the body frame B.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench<S: Scalar> {
    /// Force, N.
    pub force: Vec3<S>,
    /// Moment about the body origin, N m.
    pub moment: Vec3<S>,
}

impl<S: Scalar> Wrench<S> {
    /// No load.
    pub const ZERO: Self = Self { force: Vec3::ZERO, moment: Vec3::ZERO };

    /// A force acting at `point`.
    #[inline]
    pub fn at(point: Vec3<S>, force: Vec3<S>) -> Self {
        Self { force, moment: point.cross(force) }
    }
    /// A pure couple.
    #[inline]
    pub fn couple(moment: Vec3<S>) -> Self {
        Self { force: Vec3::ZERO, moment }
    }
}

impl<S: Scalar> Add for Wrench<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { force: self.force + o.force, moment: self.moment + o.moment }
    }
}
impl<S: Scalar> AddAssign for Wrench<S> {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

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
