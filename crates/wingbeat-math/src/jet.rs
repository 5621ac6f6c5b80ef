//! Second-order jets along time: a value with its rate and acceleration.

use super::{Meets, Scalar};
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// x, dx/dt and d2x/dt2 of one quantity. They are in the caller's unit, that per s and that per s2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Jet<S: Scalar = f64> {
    /// Value.
    pub x: S,
    /// First time derivative.
    pub d: S,
    /// Second time derivative.
    pub dd: S,
}

impl<S: Scalar> Jet<S> {
    /// Value, rate and acceleration.
    #[inline]
    pub fn new(x: S, d: S, dd: S) -> Self {
        Self { x, d, dd }
    }

    /// A number that does not change in time.
    #[inline]
    pub fn constant(x: S) -> Self {
        Self::new(x, S::ZERO, S::ZERO)
    }
    /// With the constant number `by` added.
    #[inline]
    pub fn shifted<P>(self, by: P) -> Self
    where
        S: Meets<P>,
    {
        Self::new(self.x + by, self.d, self.dd)
    }
    /// Times the constant number `k`.
    #[inline]
    pub fn scaled<P: Copy>(self, k: P) -> Self
    where
        S: Meets<P>,
    {
        Self::new(self.x * k, self.d * k, self.dd * k)
    }

    /// Chain rule (Faa di Bruno, order 2): f, f' and f'' at the value.
    #[inline]
    fn chain(self, f: S, df: S, ddf: S) -> Self {
        Self { x: f, d: df * self.d, dd: ddf * self.d * self.d + df * self.dd }
    }
}

impl<S: Scalar> From<f64> for Jet<S> {
    #[inline]
    fn from(x: f64) -> Self {
        Self::new(S::from(x), S::ZERO, S::ZERO)
    }
}
impl<S: Scalar> PartialEq for Jet<S> {
    #[inline]
    fn eq(&self, o: &Self) -> bool {
        self.x == o.x
    }
}
impl<S: Scalar> PartialOrd for Jet<S> {
    #[inline]
    fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
        self.x.partial_cmp(&o.x)
    }
}
impl<S: Scalar> Neg for Jet<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.d, -self.dd)
    }
}
impl<S: Scalar> Add for Jet<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self::new(self.x + o.x, self.d + o.d, self.dd + o.dd)
    }
}
impl<S: Scalar> Sub for Jet<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self::new(self.x - o.x, self.d - o.d, self.dd - o.dd)
    }
}
impl<S: Scalar> Mul for Jet<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::new(
            self.x * o.x,
            self.d * o.x + self.x * o.d,
            self.dd * o.x + self.d * o.d * 2.0 + self.x * o.dd,
        )
    }
}
impl<S: Scalar> Div for Jet<S> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        self * o.recip()
    }
}
impl<S: Scalar> Add<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: f64) -> Self {
        Self::new(self.x + o, self.d, self.dd)
    }
}
impl<S: Scalar> Sub<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: f64) -> Self {
        Self::new(self.x - o, self.d, self.dd)
    }
}
impl<S: Scalar> Mul<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: f64) -> Self {
        Self::new(self.x * o, self.d * o, self.dd * o)
    }
}
impl<S: Scalar> Div<f64> for Jet<S> {
    type Output = Self;
    #[inline]
    fn div(self, o: f64) -> Self {
        self * (1.0 / o)
    }
}
impl<S: Scalar> Add<Jet<S>> for f64 {
    type Output = Jet<S>;
    fn add(self, o: Jet<S>) -> Jet<S> {
        o + self
    }
}
impl<S: Scalar> Sub<Jet<S>> for f64 {
    type Output = Jet<S>;
    fn sub(self, o: Jet<S>) -> Jet<S> {
        -o + self
    }
}
impl<S: Scalar> Mul<Jet<S>> for f64 {
    type Output = Jet<S>;
    fn mul(self, o: Jet<S>) -> Jet<S> {
        o * self
    }
}
impl<S: Scalar> Div<Jet<S>> for f64 {
    type Output = Jet<S>;
    fn div(self, o: Jet<S>) -> Jet<S> {
        o.recip() * self
    }
}
impl<S: Scalar> AddAssign for Jet<S> {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<S: Scalar> SubAssign for Jet<S> {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl<S: Scalar> MulAssign for Jet<S> {
    #[inline]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}
impl<S: Scalar> MulAssign<f64> for Jet<S> {
    #[inline]
    fn mul_assign(&mut self, o: f64) {
        *self = *self * o;
    }
}

impl<S: Scalar> Scalar for Jet<S> {
    const ZERO: Self = Self { x: S::ZERO, d: S::ZERO, dd: S::ZERO };
    const ONE: Self = Self { x: S::ONE, d: S::ZERO, dd: S::ZERO };
    const NARROW: bool = S::NARROW;

    #[inline]
    fn value(self) -> f64 {
        self.x.value()
    }
    #[inline]
    fn sqrt(self) -> Self {
        let r = self.x.sqrt();
        let df = r.recip() * 0.5;
        self.chain(r, df, -(df * self.x.recip() * 0.5))
    }
    #[inline]
    fn exp(self) -> Self {
        let e = self.x.exp();
        self.chain(e, e, e)
    }
    #[inline]
    fn ln(self) -> Self {
        let r = self.x.recip();
        self.chain(self.x.ln(), r, -(r * r))
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.x.sin_cos();
        (self.chain(s, c, -s), self.chain(c, -s, -c))
    }
    #[inline]
    fn tanh(self) -> Self {
        let t = self.x.tanh();
        let df = S::ONE - t * t;
        self.chain(t, df, t * df * -2.0)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let y = self;
        let r2 = x.x * x.x + y.x * y.x;
        let area = y.d * x.x - x.d * y.x;
        let d = area / r2;
        let dr2 = (x.x * x.d + y.x * y.d) * 2.0;
        let dd = (y.dd * x.x - x.dd * y.x - d * dr2) / r2;
        Self::new(y.x.atan2(x.x), d, dd)
    }
    #[inline]
    fn recip(self) -> Self {
        let r = self.x.recip();
        let r2 = r * r;
        self.chain(r, -r2, r2 * r * 2.0)
    }
    #[inline]
    fn if_below(self, limit: Self, then: Self, otherwise: Self) -> Self {
        let chosen = |then, otherwise| self.x.if_below(limit.x, then, otherwise);
        Self::new(chosen(then.x, otherwise.x), chosen(then.d, otherwise.d), chosen(then.dd, otherwise.dd))
    }
    #[inline]
    fn positive(self) -> Option<Self> {
        Some(Self { x: self.x.positive()?, ..self })
    }
    #[inline]
    fn at_least(
        self,
        least: f64,
        seen: [Self; 2],
        measure: impl Fn([f64; 2]) -> f64,
    ) -> Result<(Self, f64), f64> {
        let [a, b] = seen;
        let (x, found) = self.x.at_least(least, [a.x, b.x], measure)?;
        Ok((Self { x, ..self }, found))
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.x.is_finite() && self.d.is_finite() && self.dd.is_finite()
    }
    #[inline]
    fn is_zero(self) -> bool {
        self.x.is_zero() && self.d.is_zero() && self.dd.is_zero()
    }
}
