//! Force and moment together.

use super::{Over, Scalar, Vec3};
use std::ops::{Add, AddAssign, Neg};

/// Names of the six channels of a wrench, forces then moments, with units.
pub const CHANNELS: [(&str, &str); 6] =
    [("Fx", "N"), ("Fy", "N"), ("Fz", "N"), ("Tx", "N m"), ("Ty", "N m"), ("Tz", "N m")];

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

    /// A force (N) acting at `point` (m), in B from the body origin.
    #[inline]
    pub fn at(point: Vec3<S>, force: Vec3<S>) -> Self {
        Self { force, moment: point.cross(force) }
    }
    /// The same wrench, N and N m, with more derivatives, all zero.
    #[inline]
    pub fn lifted<T: Over<S>>(self) -> Wrench<T> {
        Wrench { force: self.force.lifted(), moment: self.moment.lifted() }
    }
    /// A pure couple, N m in B.
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
impl<S: Scalar> Neg for Wrench<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { force: -self.force, moment: -self.moment }
    }
}
