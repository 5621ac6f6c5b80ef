//! The number type of every model: `f64` for values, [`Dual`](super::Dual) for
//! exact derivatives, [`Jet`](super::Jet) for rates along time, [`Lanes`](super::Lanes) for
//! several systems at once. One source of the physics serves all four.

use super::Meets;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// A real number, possibly carrying derivatives, in the caller's unit.
///
/// Comparison and [`value`](Scalar::value) look at the value only, so branches
/// follow the value and derivatives follow the branch taken.
///
/// Numbers stand on either side of `Dual`, `Jet` and `Traced`: `2.0 * x`. Code that is generic over `S: Scalar` writes
/// `x * 2.0`, or `S::from(2.0) * x`: a trait that promised `f64: Mul<S>` would hide `2.0 * 3.0` from the code that uses it.
pub trait Scalar:
    Copy
    + Debug
    + Default
    + Send
    + Sync
    + 'static
    + PartialOrd
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
    + MulAssign<f64>
{
    /// Additive identity.
    const ZERO: Self;
    /// Multiplicative identity.
    const ONE: Self;
    /// True where the product of a few small numbers may leave the range of numbers: single precision ends at 1e-38.
    const NARROW: bool = false;
    /// True of numbers with derivatives of their own, where a product costs more than a quotient of values.
    const CARRIES: bool = false;
    /// Whether these are plain numbers with first derivatives and no others, for which the chain rule needs no more than plain slopes.
    const FIRST_ORDER: bool = false;
    /// True of numbers that write down what is done with them: how fast that is does not matter, how often it is compiled does.
    const RECORDED: bool = false;

    /// The value without derivatives.
    fn value(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
    /// Natural logarithm.
    fn ln(self) -> Self;
    /// Sine and cosine in one call.
    fn sin_cos(self) -> (Self, Self);
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
    /// Angle of the point (x, self), rad, in (-pi, pi].
    fn atan2(self, x: Self) -> Self;
    /// 1 / self.
    fn recip(self) -> Self;
    /// True when value and derivatives are finite.
    fn is_finite(self) -> bool;
    /// True when value and derivatives are zero.
    fn is_zero(self) -> bool;

    /// self * a + b, rounded once where the processor can.
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }
    /// self + a * b. It is rounded once where numbers are [narrow](Self::NARROW), which takes fewer instructions; others keep the bits of a
    /// product and a sum.
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        if const { Self::NARROW } { a.mul_add(b, self) } else { self + a * b }
    }
    /// self + a * p of a number `p` of a model, rounded as [`plus_product`](Self::plus_product).
    #[inline(always)]
    fn plus_met<P: Copy>(self, a: Self, p: P) -> Self
    where
        Self: Meets<P>,
    {
        if const { Self::NARROW } { a.mul_add(Self::from(p), self) } else { self + a * p }
    }
    /// self - a * b, rounded as [`plus_product`](Self::plus_product).
    #[inline(always)]
    fn less_product(self, a: Self, b: Self) -> Self {
        if const { Self::NARROW } { (-a).mul_add(b, self) } else { self - a * b }
    }
    /// Sine.
    #[inline]
    fn sin(self) -> Self {
        self.sin_cos().0
    }
    /// Cosine.
    #[inline]
    fn cos(self) -> Self {
        self.sin_cos().1
    }
    /// Tangent.
    #[inline]
    fn tan(self) -> Self {
        let (s, c) = self.sin_cos();
        s / c
    }
    /// Arc cosine, for |self| < 1.
    #[inline]
    fn acos(self) -> Self {
        (Self::ONE - self * self).sqrt().atan2(self)
    }
    /// Square.
    #[inline]
    fn squared(self) -> Self {
        self * self
    }
    /// Square plus `b`, rounded once where the processor can.
    #[inline]
    fn squared_add(self, b: Self) -> Self {
        self.mul_add(self, b)
    }
    /// 1 / self, falling to zero where `self` is less than the fourth root of `core4`: x^3 / (x^4 + core4).
    #[inline]
    fn faded_inverse(self, core4: Self) -> Self {
        let square = self.squared();
        square * self / square.squared_add(core4)
    }
    /// self with the derivatives of `of` times a plain `slope` added to its own, its value as it is.
    #[inline(always)]
    fn plus_slope(self, slope: f64, of: &Self) -> Self {
        self + (*of - of.value()) * slope
    }
    /// |self|; the derivative follows the branch of the value, and is that of `self` at zero.
    #[inline]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// Whole power, by squaring.
    #[inline]
    fn powi(self, n: i32) -> Self {
        let (mut power, mut base, mut left) = (Self::ONE, self, n.unsigned_abs());
        while left > 0 {
            if left % 2 == 1 {
                power *= base;
            }
            base *= base;
            left /= 2;
        }
        if n < 0 { power.recip() } else { power }
    }
    /// Power with any exponent, of what is above zero.
    #[inline]
    fn powf(self, exponent: f64) -> Self {
        (self.ln() * exponent).exp()
    }
    /// Length of the hypotenuse, sqrt(self^2 + other^2).
    #[inline]
    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).sqrt()
    }
    /// Smooth |x|: sqrt(x^2 + width^2).
    #[inline]
    fn smooth_abs(self, width: f64) -> Self {
        (self * self + width * width).sqrt()
    }
    /// Smooth max(x, 0): (x + sqrt(x^2 + width^2)) / 2.
    #[inline]
    fn smooth_positive(self, width: f64) -> Self {
        (self + self.smooth_abs(width)) * 0.5
    }
    /// `then` where the value of `self` is below that of `limit`, elsewhere `otherwise`: a branch that every one of several
    /// [`Lanes`](super::Lanes) takes by itself.
    #[inline]
    fn if_below(self, limit: Self, then: Self, otherwise: Self) -> Self {
        if self.value() < limit.value() { then } else { otherwise }
    }
    /// `self` when its value is finite and above zero. Of several lanes those that are not go on as NaN.
    #[inline]
    fn positive(self) -> Option<Self> {
        (self.value() > 0.0 && self.value().is_finite()).then_some(self)
    }
    /// `self` and what `measure` finds in the values of `seen`, when that is `least` or more, else what it finds. Of
    /// several lanes each is measured by itself, goes on as NaN where it is refused, and the least is told.
    ///
    /// # Errors
    /// What was found, when it is less or NaN.
    #[inline]
    fn at_least(
        self,
        least: f64,
        seen: [Self; 2],
        measure: impl Fn([f64; 2]) -> f64,
    ) -> Result<(Self, f64), f64> {
        let [a, b] = seen;
        let found = measure([a.value(), b.value()]);
        if found >= least { Ok((self, found)) } else { Err(found) }
    }
    /// `self` limited to [low, high] by value; derivatives vanish outside.
    #[inline]
    fn clamped(self, low: f64, high: f64) -> Self {
        if self.value() < low {
            Self::from(low)
        } else if self.value() > high {
            Self::from(high)
        } else {
            self
        }
    }
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;

    #[inline]
    fn value(self) -> f64 {
        self
    }
    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline]
    fn exp(self) -> Self {
        f64::exp(self)
    }
    #[inline]
    fn ln(self) -> Self {
        f64::ln(self)
    }
    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    #[inline]
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
    #[inline]
    fn recip(self) -> Self {
        1.0 / self
    }
    #[inline]
    fn mul_add(self, a: Self, b: Self) -> Self {
        // Without the instruction the exact function is a slow library call.
        if cfg!(any(target_feature = "fma", target_arch = "aarch64")) {
            f64::mul_add(self, a, b)
        } else {
            self * a + b
        }
    }
    #[inline]
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }
    #[inline]
    fn hypot(self, other: Self) -> Self {
        f64::hypot(self, other)
    }
    #[inline]
    fn acos(self) -> Self {
        f64::acos(self)
    }
    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
    #[inline]
    fn is_zero(self) -> bool {
        self == 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::Scalar;
    use crate::Dual;

    #[test]
    fn numbers_stand_on_either_side() {
        use super::super::{Jet, Tape};
        fn both<S: Scalar>(x: S, left: [S; 4]) {
            let right = [x + 2.0, -x + 2.0, x * 2.0, x.recip() * 2.0];
            assert!(left.iter().zip(right).all(|(a, b)| a.value() == b.value()));
        }
        let d = Dual::<1>::variable(0.7, 0);
        let left = [2.0 + d, 2.0 - d, 2.0 * d, 2.0 / d];
        assert_eq!(left.map(|x| x.eps[0]), [1.0, -1.0, 2.0, -2.0 * d.recip().re.powi(2)]);
        both(d, left);
        let j: Jet = Jet::new(0.7, 1.0, 0.5);
        both(j, [2.0 + j, 2.0 - j, 2.0 * j, 2.0 / j]);
        assert_eq!(((2.0 * j).d, (2.0 - j).dd), (2.0, -0.5));
        let mut out = [0.0; 2];
        let mut tape = Tape::default();
        let recorded = tape.record(&[0.7], &mut out, |x, out| {
            (out[0], out[1]) = (2.0 * x[0] + 1.0, 3.0 - 2.0 / x[0]);
            Ok::<(), ()>(())
        });
        assert_eq!((recorded, out), (Ok(()), [2.4, 3.0 - 2.0 * (1.0 / 0.7)]));
    }

    #[test]
    fn functions_with_slopes_of_their_own_are_the_products_they_stand_for() {
        type Number = Dual<2>;
        let close = |a: Number, b: Number| {
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-13 * b.abs().max(1e-3);
            near(a.re, b.re) && (0..2).all(|i| near(a.eps[i], b.eps[i]))
        };
        for (x, core4) in [(0.3, 0.02), (-0.8, 0.5), (1.7, 1e-6), (1e-3, 0.1)] {
            let (x, core4) = (Number { re: x, eps: [1.3, -0.4] }, Number { re: core4, eps: [0.2, 0.9] });
            assert!(close(x.squared(), x * x));
            assert!(close(x.squared_add(core4), x * x + core4));
            assert!(close(x.faded_inverse(core4), x * x * x / (x * x * x * x + core4)));
            assert!((x.re.faded_inverse(core4.re) - x.faded_inverse(core4).re).abs() < 1e-13);
        }
    }

    #[test]
    fn powers_and_magnitudes_carry_their_derivatives() {
        for n in [-3, 0, 1, 2, 5] {
            let power = Scalar::powi(Dual::<1>::variable(-1.3, 0), n);
            let (value, slope) = ((-1.3_f64).powi(n), f64::from(n) * (-1.3_f64).powi(n - 1));
            assert!((power.re - value).abs() < 1e-14 * value.abs(), "{n}");
            assert!((power.eps[0] - slope).abs() < 1e-13 * slope.abs().max(1.0), "{n}");
        }
        let magnitude = Scalar::abs(Dual::<1>::variable(-2.0, 0));
        assert_eq!((magnitude.re, magnitude.eps[0]), (2.0, -1.0));
    }
}
