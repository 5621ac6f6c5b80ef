//! Vectors in the linkage's plane, as complex numbers: product = turn and scale.

use std::ops::{Add, Mul, Neg, Sub};
use wingbeat_math::{Jet, Meets, Scalar};

/// A vector y + i z with its rate and acceleration. Its components are in the caller's unit: m, or none of a direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Planar<S: Scalar = f64> {
    /// Outboard component.
    pub y: Jet<S>,
    /// Upward component.
    pub z: Jet<S>,
}

impl<S: Scalar> Planar<S> {
    /// From components.
    #[inline]
    pub fn new(y: Jet<S>, z: Jet<S>) -> Self {
        Self { y, z }
    }
    /// A constant vector.
    #[inline]
    pub fn constant<P>(of: [P; 2]) -> Self
    where
        S: Meets<P>,
    {
        let [y, z] = of;
        Self::new(Jet::constant(S::from(y)), Jet::constant(S::from(z)))
    }
    /// Unit vector at the angle `a`, rad.
    #[inline]
    pub fn unit(a: Jet<S>) -> Self {
        let (s, c) = a.sin_cos();
        Self::new(c, s)
    }
    /// Squared length.
    #[inline]
    pub fn norm_squared(self) -> Jet<S> {
        self.y * self.y + self.z * self.z
    }
    /// Mirrored in the y axis: the turn backwards.
    #[inline]
    pub fn conjugate(self) -> Self {
        Self::new(self.y, -self.z)
    }
    /// Scaled by a number.
    #[inline]
    pub fn scaled(self, k: Jet<S>) -> Self {
        Self::new(self.y * k, self.z * k)
    }
    /// Scaled by a constant.
    #[inline]
    pub fn times<P: Copy>(self, k: P) -> Self
    where
        S: Meets<P>,
    {
        Self::new(self.y.scaled(k), self.z.scaled(k))
    }
    /// Turned and scaled by the constant vector `[c, s]`.
    #[inline]
    pub fn turned<P: Copy>(self, [c, s]: [P; 2]) -> Self
    where
        S: Meets<P>,
    {
        Self::new(self.y.scaled(c) - self.z.scaled(s), self.y.scaled(s) + self.z.scaled(c))
    }
    /// Direction in (middle - pi, middle + pi], rad; `middle` is a constant angle.
    #[inline]
    pub fn angle_about(self, middle: f64) -> Jet<S> {
        let (s, c) = middle.sin_cos();
        let seen = self.turned([c, -s]);
        seen.z.atan2(seen.y) + middle
    }
}

impl<S: Scalar> Add for Planar<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self::new(self.y + o.y, self.z + o.z)
    }
}
impl<S: Scalar> Sub for Planar<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self::new(self.y - o.y, self.z - o.z)
    }
}
impl<S: Scalar> Neg for Planar<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.y, -self.z)
    }
}
impl<S: Scalar> Mul for Planar<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::new(self.y * o.y - self.z * o.z, self.y * o.z + self.z * o.y)
    }
}
