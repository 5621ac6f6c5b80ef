//! Numbers with more derivatives beside numbers with fewer. All are in the caller's units.

use super::{Dual, Mat3, Scalar, Vec3};
use std::ops::{Add, Mul, MulAssign, Sub};

/// A scalar that takes the numbers `P` of a model as factors and terms without lifting them first: plain
/// constants, or numbers that carry derivatives themselves, which then are of its own type.
///
/// Every [`Scalar`] meets `f64` and itself.
pub trait Meets<P>:
    From<P> + Add<P, Output = Self> + Sub<P, Output = Self> + Mul<P, Output = Self> + MulAssign<P>
{
}

impl<S, P> Meets<P> for S where
    S: From<P> + Add<P, Output = S> + Sub<P, Output = S> + Mul<P, Output = S> + MulAssign<P>
{
}

/// A scalar that meets the scalar `G`, which carries no more derivatives, without lifting it.
///
/// Where only few of a function's variables carry derivatives, what the others alone decide
/// is computed in `G`, the rest in `Self`.
pub trait Over<G: Scalar>:
    Scalar + From<G> + Add<G, Output = Self> + Sub<G, Output = Self> + Mul<G, Output = Self>
{
    /// self * g + c, rounded once where the processor can.
    fn fused(self, g: G, c: Self) -> Self;
    /// Square of `g` plus self, rounded once where the processor can.
    fn plus_square(self, g: G) -> Self;
    /// self + a * g, rounded as [`Scalar::plus_product`].
    #[inline(always)]
    fn plus_over(self, a: Self, g: G) -> Self {
        if const { Self::NARROW } { a.fused(g, self) } else { self + a * g }
    }
    /// self - a * g, rounded as [`Scalar::less_product`].
    #[inline(always)]
    fn less_over(self, a: Self, g: G) -> Self {
        if const { Self::NARROW } { (-a).fused(g, self) } else { self - a * g }
    }
    /// The part that `G` holds: without the derivatives that only this type carries.
    fn beneath(self) -> G;
}

/// Writes `values` with more derivatives, all zero, into `out`, as far as there is room.
#[inline]
pub fn lift<G: Scalar, S: Over<G>>(values: &[G], out: &mut [S]) {
    for i in 0..values.len().min(out.len()) {
        out[i] = S::from(values[i]);
    }
}

impl<S: Scalar> Over<S> for S {
    #[inline]
    fn fused(self, g: S, c: S) -> S {
        self.mul_add(g, c)
    }
    #[inline]
    fn plus_square(self, g: S) -> S {
        g.squared_add(self)
    }
    #[inline]
    fn beneath(self) -> S {
        self
    }
}

impl<const N: usize> Over<f64> for Dual<N> {
    #[inline]
    fn fused(self, g: f64, c: Self) -> Self {
        let mut sum = c;
        sum.re = self.re.mul_add(g, c.re);
        for i in 0..N {
            sum.eps[i] = self.eps[i].mul_add(g, c.eps[i]);
        }
        sum
    }
    #[inline]
    fn plus_square(self, g: f64) -> Self {
        Self { re: g.squared_add(self.re), ..self }
    }
    #[inline]
    fn beneath(self) -> f64 {
        self.re
    }
}

impl<S: Scalar> Vec3<S> {
    /// The same vector as a scalar that meets these numbers holds it.
    #[inline]
    pub fn met<T: Scalar + Meets<S>>(self) -> Vec3<T> {
        self.each(T::from)
    }
    /// The same vector with more derivatives, all zero.
    #[inline]
    pub fn lifted<T: Over<S>>(self) -> Vec3<T> {
        self.each(T::from)
    }
    /// The part of the vector that `T` holds.
    #[inline]
    pub fn beneath<T: Scalar>(self) -> Vec3<T>
    where
        S: Over<T>,
    {
        self.each(S::beneath)
    }
    /// Vector product with a vector that may carry fewer derivatives.
    #[inline]
    pub fn cross_under<T: Scalar>(self, o: Vec3<T>) -> Self
    where
        S: Over<T>,
    {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([(b * z).less_over(c, y), (c * x).less_over(a, z), (a * y).less_over(b, x)])
    }
    /// The vector `x` of the way along `axis`, in its units: self + axis x, rounded as [`Scalar::plus_product`].
    #[inline(always)]
    pub fn shifted<P: Copy>(self, axis: Self, x: P) -> Self
    where
        S: Meets<P>,
    {
        if const { S::NARROW } {
            let x = S::from(x);
            return Self([0, 1, 2].map(|i| axis.0[i].mul_add(x, self.0[i])));
        }
        self + axis.scaled(x)
    }
    /// `sum` and this vector times `k`, which may carry more derivatives; rounded as [`Scalar::plus_product`].
    #[inline(always)]
    pub fn times_plus<T: Over<S>>(self, k: T, sum: Vec3<T>) -> Vec3<T> {
        let ([a, b, c], [x, y, z]) = (self.0, sum.0);
        Vec3([x.plus_over(k, a), y.plus_over(k, b), z.plus_over(k, c)])
    }
    /// Times a number that may carry more derivatives.
    #[inline]
    pub fn times<T: Over<S>>(self, k: T) -> Vec3<T> {
        self.each(|c| k * c)
    }
    /// Scalar product with a vector that may carry more derivatives.
    #[inline]
    pub fn dot_over<T: Over<S>>(self, o: Vec3<T>) -> T {
        (o.0[0] * self.0[0]).plus_over(o.0[1], self.0[1]).plus_over(o.0[2], self.0[2])
    }
    /// Vector product with a vector that may carry more derivatives.
    #[inline]
    pub fn cross_over<T: Over<S>>(self, o: Vec3<T>) -> Vec3<T> {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Vec3([(z * b).less_over(y, c), (x * c).less_over(z, a), (y * a).less_over(x, b)])
    }
}

impl<S: Scalar> Mat3<S> {
    /// Product with a vector that may carry more derivatives.
    #[inline]
    pub fn times<T: Over<S>>(&self, v: Vec3<T>) -> Vec3<T> {
        let row = |r: &[S; 3]| v[2].fused(r[2], v[1].fused(r[1], v[0] * r[0]));
        Vec3([row(&self.0[0]), row(&self.0[1]), row(&self.0[2])])
    }
}
