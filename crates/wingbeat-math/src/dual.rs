//! Forward-mode automatic differentiation with a fixed number of directions.

use super::Scalar;
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A value and its derivatives along `N` directions. Both are in the caller's units: a derivative in that of the value over
/// that of its direction.
///
/// `Dual<N>` gives gradients; `Dual<N, Dual<M>>` gives exact second derivatives.
///
/// Derivatives come first and aligned, so that vector registers load them whole.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Dual<const N: usize, S: Scalar = f64> {
    /// Derivatives along each direction.
    pub eps: [S; N],
    /// Value.
    pub re: S,
}

impl<const N: usize, S: Scalar> Dual<N, S> {
    /// Number of directions carried.
    pub const LANES: usize = N;
    /// A constant: all derivatives zero.
    #[inline]
    pub fn constant(re: S) -> Self {
        Self { re, eps: [S::ZERO; N] }
    }

    /// The independent variable of direction `direction`.
    #[inline]
    pub fn variable(re: S, direction: usize) -> Self {
        let mut x = Self::constant(re);
        x.eps[direction] = S::ONE;
        x
    }

    /// Chain rule: value `f` and slope `df` of a function of one variable.
    #[inline]
    fn chain(self, f: S, df: S) -> Self {
        self.each(f, |e| e * df)
    }

    #[inline]
    fn each(self, re: S, f: impl Fn(S) -> S) -> Self {
        let mut eps = [S::ZERO; N];
        for i in 0..N {
            eps[i] = f(self.eps[i]);
        }
        Self { re, eps }
    }

    #[inline]
    fn zip(self, other: Self, re: S, f: impl Fn(S, S) -> S) -> Self {
        let mut eps = [S::ZERO; N];
        for i in 0..N {
            eps[i] = f(self.eps[i], other.eps[i]);
        }
        Self { re, eps }
    }
}

impl<const N: usize, S: Scalar> Default for Dual<N, S> {
    fn default() -> Self {
        Self::constant(S::ZERO)
    }
}

impl<const N: usize, S: Scalar> From<f64> for Dual<N, S> {
    #[inline]
    fn from(x: f64) -> Self {
        Self::constant(S::from(x))
    }
}

impl<const N: usize, S: Scalar> PartialEq for Dual<N, S> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.re == other.re
    }
}

impl<const N: usize, S: Scalar> PartialOrd for Dual<N, S> {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<const N: usize, S: Scalar> Neg for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.each(-self.re, |e| -e)
    }
}

impl<const N: usize, S: Scalar> Add for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        self.zip(o, self.re + o.re, |a, b| a + b)
    }
}

impl<const N: usize, S: Scalar> Sub for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self.zip(o, self.re - o.re, |a, b| a - b)
    }
}

impl<const N: usize, S: Scalar> Mul for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        self.zip(o, self.re * o.re, |a, b| a.mul_add(o.re, b * self.re))
    }
}

impl<const N: usize, S: Scalar> Div for Dual<N, S> {
    type Output = Self;
    #[inline]
    fn div(self, o: Self) -> Self {
        let inverse = o.re.recip();
        let re = self.re * inverse;
        self.zip(o, re, |a, b| b.mul_add(-re, a) * inverse)
    }
}

macro_rules! with_f64 {
    ($type:ident) => {
        impl<const N: usize, S: Scalar> Add<f64> for $type<N, S> {
            type Output = Self;
            #[inline]
            fn add(mut self, o: f64) -> Self {
                self.re = self.re + o;
                self
            }
        }
        impl<const N: usize, S: Scalar> Sub<f64> for $type<N, S> {
            type Output = Self;
            #[inline]
            fn sub(mut self, o: f64) -> Self {
                self.re = self.re - o;
                self
            }
        }
        impl<const N: usize, S: Scalar> Mul<f64> for $type<N, S> {
            type Output = Self;
            #[inline]
            fn mul(self, o: f64) -> Self {
                self.each(self.re * o, |e| e * o)
            }
        }
        impl<const N: usize, S: Scalar> Div<f64> for $type<N, S> {
            type Output = Self;
            #[inline]
            fn div(self, o: f64) -> Self {
                self * (1.0 / o)
            }
        }
        impl<const N: usize, S: Scalar> Add<$type<N, S>> for f64 {
            type Output = $type<N, S>;
            #[inline]
            fn add(self, o: $type<N, S>) -> $type<N, S> {
                o + self
            }
        }
        impl<const N: usize, S: Scalar> Sub<$type<N, S>> for f64 {
            type Output = $type<N, S>;
            #[inline]
            fn sub(self, o: $type<N, S>) -> $type<N, S> {
                -o + self
            }
        }
        impl<const N: usize, S: Scalar> Mul<$type<N, S>> for f64 {
            type Output = $type<N, S>;
            #[inline]
            fn mul(self, o: $type<N, S>) -> $type<N, S> {
                o * self
            }
        }
        impl<const N: usize, S: Scalar> Div<$type<N, S>> for f64 {
            type Output = $type<N, S>;
            #[inline]
            fn div(self, o: $type<N, S>) -> $type<N, S> {
                o.recip() * self
            }
        }
        impl<const N: usize, S: Scalar> MulAssign<f64> for $type<N, S> {
            #[inline]
            fn mul_assign(&mut self, o: f64) {
                *self = *self * o;
            }
        }
    };
}
with_f64!(Dual);

impl<const N: usize, S: Scalar> AddAssign for Dual<N, S> {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<const N: usize, S: Scalar> SubAssign for Dual<N, S> {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl<const N: usize, S: Scalar> MulAssign for Dual<N, S> {
    #[inline]
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}

impl<const N: usize, S: Scalar> Scalar for Dual<N, S> {
    const ZERO: Self = Self { re: S::ZERO, eps: [S::ZERO; N] };
    const ONE: Self = Self { re: S::ONE, eps: [S::ZERO; N] };
    const NARROW: bool = S::NARROW;
    const CARRIES: bool = true;
    const FIRST_ORDER: bool = !S::CARRIES && !S::RECORDED && size_of::<S>() == size_of::<f64>();

    #[inline]
    fn value(self) -> f64 {
        self.re.value()
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, (root + root).recip())
    }
    #[inline]
    fn exp(self) -> Self {
        let e = self.re.exp();
        self.chain(e, e)
    }
    #[inline]
    fn ln(self) -> Self {
        self.chain(self.re.ln(), self.re.recip())
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.re.sin_cos();
        (self.chain(s, c), self.chain(c, -s))
    }
    #[inline]
    fn tanh(self) -> Self {
        let t = self.re.tanh();
        self.chain(t, S::ONE - t * t)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let inverse = (self.re * self.re + x.re * x.re).recip();
        let (ky, kx) = (x.re * inverse, self.re * inverse);
        self.zip(x, self.re.atan2(x.re), |dy, dx| dy.mul_add(ky, -(dx * kx)))
    }
    #[inline]
    fn recip(self) -> Self {
        let r = self.re.recip();
        self.chain(r, -(r * r))
    }
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let mut sum = b;
        sum.re = self.re.mul_add(a.re, b.re);
        for i in 0..N {
            sum.eps[i] = self.eps[i].mul_add(a.re, a.eps[i].mul_add(self.re, b.eps[i]));
        }
        sum
    }
    #[inline]
    fn squared(self) -> Self {
        self.chain(self.re * self.re, self.re + self.re)
    }
    #[inline]
    fn squared_add(self, b: Self) -> Self {
        let slope = self.re + self.re;
        self.zip(b, self.re.squared_add(b.re), |e, b| e.mul_add(slope, b))
    }
    #[inline(always)]
    fn plus_slope(mut self, slope: f64, of: &Self) -> Self {
        let slope = S::from(slope);
        for i in 0..N {
            self.eps[i] = of.eps[i].mul_add(slope, self.eps[i]);
        }
        self
    }
    /// With s = 1/(x^4 + c): slope x^2 s (4 c s - 1) by x and -x^3 s^2 by c.
    #[inline]
    fn faded_inverse(self, core4: Self) -> Self {
        let square = self.re.squared();
        let share = square.squared_add(core4.re).recip();
        let faded = square * self.re * share;
        let slope = square * share * ((core4.re * share) * 4.0 - 1.0);
        let by_core = -(faded * share);
        self.zip(core4, faded, |e, c| e.mul_add(slope, c * by_core))
    }
    #[inline]
    fn if_below(self, limit: Self, then: Self, otherwise: Self) -> Self {
        then.zip(otherwise, self.re.if_below(limit.re, then.re, otherwise.re), |then, otherwise| {
            self.re.if_below(limit.re, then, otherwise)
        })
    }
    #[inline]
    fn positive(self) -> Option<Self> {
        Some(Self { re: self.re.positive()?, ..self })
    }
    #[inline]
    fn at_least(
        self,
        least: f64,
        seen: [Self; 2],
        measure: impl Fn([f64; 2]) -> f64,
    ) -> Result<(Self, f64), f64> {
        let [a, b] = seen;
        let (re, found) = self.re.at_least(least, [a.re, b.re], measure)?;
        Ok((Self { re, ..self }, found))
    }
    #[inline]
    fn is_finite(self) -> bool {
        self.re.is_finite() && self.eps.iter().all(|e| e.is_finite())
    }
    #[inline]
    fn is_zero(self) -> bool {
        self.re.is_zero() && self.eps.iter().all(|e| e.is_zero())
    }
}
