//! Several numbers side by side in a vector register: one evaluation of a model serves as many systems.

use super::Scalar;
use std::cmp::Ordering;
use std::fmt::{self, Debug, Formatter};
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use wide::{f32x8, f64x4};

/// A scalar that is several numbers in the caller's unit, its lanes. No lane knows the others: what comes out of one depends,
/// to the bit, on what went into it alone.
///
/// Where branches ask for [`value`](Scalar::value), lanes that differ have none: it is NaN, as their order is unknown. Code
/// that is to run on lanes branches by [`if_below`](Scalar::if_below), [`positive`](Scalar::positive) and
/// [`at_least`](Scalar::at_least).
pub trait Lanes: Scalar {
    /// Number of lanes.
    const WIDTH: usize;
    /// From the number of each lane.
    fn of(number: impl FnMut(usize) -> f64) -> Self;
    /// The number of a lane.
    ///
    /// # Panics
    /// When there is no such lane.
    fn lane(self, lane: usize) -> f64;
}

macro_rules! lanes {
    ($(#[$about:meta])* $name:ident, $vector:ident, $number:ty, $width:literal) => {
        $(#[$about])*
        #[derive(Clone, Copy, Default)]
        pub struct $name($vector);

        impl $name {
            #[inline(always)]
            fn splat(x: f64) -> $vector {
                $vector::splat(x as $number)
            }
            /// The condition of each lane, all bits of it.
            #[inline(always)]
            fn below(self, o: Self) -> $vector {
                self.0.simd_lt(o.0)
            }
        }

        impl Lanes for $name {
            const WIDTH: usize = $width;

            #[inline]
            fn of(mut number: impl FnMut(usize) -> f64) -> Self {
                let mut numbers = [0.0; $width];
                for lane in 0..$width {
                    numbers[lane] = number(lane) as $number;
                }
                Self($vector::new(numbers))
            }
            #[inline]
            fn lane(self, lane: usize) -> f64 {
                f64::from(self.0.to_array()[lane])
            }
        }

        impl Debug for $name {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                self.0.to_array().fmt(f)
            }
        }
        impl From<f64> for $name {
            #[inline(always)]
            fn from(x: f64) -> Self {
                Self(Self::splat(x))
            }
        }
        impl PartialEq for $name {
            #[inline]
            fn eq(&self, o: &Self) -> bool {
                self.0.to_array() == o.0.to_array()
            }
        }
        impl PartialOrd for $name {
            #[inline]
            fn partial_cmp(&self, o: &Self) -> Option<Ordering> {
                self.value().partial_cmp(&o.value())
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
        lanes!(@operators $name, Add add AddAssign add_assign, Sub sub SubAssign sub_assign, Mul mul MulAssign mul_assign);
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, o: Self) -> Self {
                Self(self.0 / o.0)
            }
        }
        impl Div<f64> for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, o: f64) -> Self {
                Self(self.0 / Self::splat(o))
            }
        }
        impl MulAssign<f64> for $name {
            #[inline(always)]
            fn mul_assign(&mut self, o: f64) {
                *self = *self * o;
            }
        }

        impl Scalar for $name {
            const ZERO: Self = Self($vector::splat(0.0));
            const ONE: Self = Self($vector::splat(1.0));
            const NARROW: bool = size_of::<$number>() < size_of::<f64>();

            /// What all lanes are, NaN where they differ.
            fn value(self) -> f64 {
                let [first, others @ ..] = self.0.to_array();
                if others.iter().all(|other| *other == first) { f64::from(first) } else { f64::NAN }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.sqrt())
            }
            #[inline(always)]
            fn exp(self) -> Self {
                Self(self.0.exp())
            }
            #[inline(always)]
            fn ln(self) -> Self {
                Self(self.0.ln())
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                let (s, c) = self.0.sin_cos();
                (Self(s), Self(c))
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                Self(self.0.tanh())
            }
            #[inline(always)]
            fn atan2(self, x: Self) -> Self {
                Self(self.0.atan2(x.0))
            }
            #[inline(always)]
            fn recip(self) -> Self {
                // The vector's own reciprocal has 12 bits.
                Self($vector::splat(1.0) / self.0)
            }
            #[inline]
            fn is_finite(self) -> bool {
                self.0.to_array().iter().all(|x| x.is_finite())
            }
            #[inline]
            fn is_zero(self) -> bool {
                self.0.to_array().iter().all(|x| *x == 0.0)
            }
            #[inline(always)]
            fn mul_add(self, a: Self, b: Self) -> Self {
                Self(self.0.mul_add(a.0, b.0))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(self.0.abs())
            }
            #[inline(always)]
            fn clamped(self, low: f64, high: f64) -> Self {
                let (low, high) = (Self::from(low), Self::from(high));
                self.if_below(low, low, high.if_below(self, high, self))
            }
            #[inline(always)]
            fn if_below(self, limit: Self, then: Self, otherwise: Self) -> Self {
                Self(self.below(limit).select(then.0, otherwise.0))
            }
            #[inline(always)]
            fn positive(self) -> Option<Self> {
                let good = Self::ZERO.below(self) & self.below(Self::from(f64::INFINITY));
                Some(Self(good.select(self.0, Self::splat(f64::NAN))))
            }
            fn at_least(
                self,
                least: f64,
                seen: [Self; 2],
                measure: impl Fn([f64; 2]) -> f64,
            ) -> Result<(Self, f64), f64> {
                let ([a, b], mut worst) = (seen, f64::INFINITY);
                let kept = Self::of(|lane| {
                    let found = measure([a.lane(lane), b.lane(lane)]);
                    worst = worst.min(found);
                    if found >= least { self.lane(lane) } else { f64::NAN }
                });
                Ok((kept, worst))
            }
        }
    };
    (@operators $name:ident, $($trait:ident $function:ident $assign:ident $in_place:ident),*) => {$(
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, o: Self) -> Self {
                Self($trait::$function(self.0, o.0))
            }
        }
        impl $trait<f64> for $name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, o: f64) -> Self {
                Self($trait::$function(self.0, Self::splat(o)))
            }
        }
        impl $assign for $name {
            #[inline(always)]
            fn $in_place(&mut self, o: Self) {
                *self = $trait::$function(*self, o);
            }
        }
    )*};
}

lanes!(
    /// Four numbers of double precision. Sine, cosine, exponential, logarithm and arc tangent are polynomials, within 2 units in
    /// the last place of those of `f64`, sine and cosine of arguments up to 1e4 within 1e-15.
    Double4,
    f64x4,
    f64,
    4
);
impl Double4 {
    /// Number `j` of each of four as one, for every `j`, in the units of the caller.
    #[inline(always)]
    pub fn transposed(four: [Self; 4]) -> [[f64; 4]; 4] {
        let [a, b, c, d] = f64x4::transpose([four[0].0, four[1].0, four[2].0, four[3].0]);
        [a.to_array(), b.to_array(), c.to_array(), d.to_array()]
    }
    /// The four numbers, in the units of the caller.
    #[inline(always)]
    pub fn numbers(self) -> [f64; 4] {
        self.0.to_array()
    }
    /// From the four numbers, in the units of the caller.
    #[inline(always)]
    pub fn new(numbers: [f64; 4]) -> Self {
        Self(f64x4::new(numbers))
    }
}

lanes!(
    /// Eight numbers of single precision: everything is rounded to 6e-8 of its size.
    Single8,
    f32x8,
    f32,
    8
);

#[cfg(test)]
mod tests {
    use super::*;

    /// Values in every lane, spread over `from` to `to`.
    fn spread<L: Lanes>(from: f64, to: f64) -> impl Iterator<Item = L> {
        const COUNT: usize = 20_000;
        let step = (to - from) / COUNT as f64;
        (0..COUNT / L::WIDTH)
            .map(move |k| L::of(|lane| from + (k * L::WIDTH + lane) as f64 * step + 1e-3 * step))
    }

    /// Largest error of a function of one variable against that of `f64`, relative to `floor` or more.
    fn error<L: Lanes>(
        [from, to]: [f64; 2],
        floor: f64,
        f: impl Fn(L) -> L,
        exact: impl Fn(f64) -> f64,
    ) -> f64 {
        let mut largest = 0.0_f64;
        for x in spread::<L>(from, to) {
            let y = f(x);
            for lane in 0..L::WIDTH {
                let exact = exact(x.lane(lane));
                largest = largest.max((y.lane(lane) - exact).abs() / exact.abs().max(floor));
            }
        }
        largest
    }

    fn worst<L: Lanes>() -> [(&'static str, f64); 8] {
        [
            ("sin", error::<L>([-1e3, 1e3], 1.0, |x| x.sin(), f64::sin)),
            ("cos", error::<L>([-1e3, 1e3], 1.0, |x| x.cos(), f64::cos)),
            ("sqrt", error::<L>([0.0, 1e3], 0.0, |x| x.sqrt(), f64::sqrt)),
            ("exp", error::<L>([-30.0, 30.0], 0.0, |x| x.exp(), f64::exp)),
            ("ln", error::<L>([1e-3, 1e3], 1.0, |x| x.ln(), f64::ln)),
            ("tanh", error::<L>([-9.0, 9.0], 1e-3, |x| x.tanh(), f64::tanh)),
            ("atan2", error::<L>([-40.0, 40.0], 1e-3, |x| x.atan2(L::from(-3.0)), |x| x.atan2(-3.0))),
            ("recip", error::<L>([0.1, 90.0], 0.0, |x| x.recip(), |x| 1.0 / x)),
        ]
    }

    #[test]
    fn functions_are_those_of_single_numbers() {
        for (name, error) in worst::<Double4>() {
            println!("double {name}: {error:.1e}");
            assert!(error < 1e-15, "{name}: {error:e}");
        }
        for (name, error) in worst::<Single8>() {
            println!("single {name}: {error:.1e}");
            assert!(error < 3e-7, "{name}: {error:e}");
        }
    }

    fn branches<L: Lanes>() {
        let x = L::of(|lane| [-2.0, 0.0, f64::NAN, 5.0][lane % 4]);
        let numbers = |x: L| -> Vec<f64> { (0..L::WIDTH).map(|lane| x.lane(lane)).collect() };
        let same = |x: L, wanted: [f64; 4]| {
            numbers(x).iter().zip(wanted.iter().cycle()).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        };
        let nan = f64::NAN;
        assert!(same(x.abs(), [2.0, 0.0, nan, 5.0]));
        assert!(same(x.clamped(-1.0, 3.0), [-1.0, 0.0, nan, 3.0]));
        assert!(same(x.if_below(L::ONE, L::from(7.0), x), [7.0, 7.0, nan, 5.0]));
        assert!(same(x.positive().unwrap(), [nan, nan, nan, 5.0]));
        let (kept, least) = x.at_least(1.0, [x, x * 2.0], |[_, twice]| twice).unwrap();
        assert!(same(kept, [nan, nan, nan, 5.0]) && least == -4.0);
        assert!(x.value().is_nan() && L::from(3.0).value() == 3.0 && x.partial_cmp(&L::ONE).is_none());
        assert!(!x.is_finite() && L::ZERO.is_zero());
    }

    #[test]
    fn every_lane_takes_its_own_branch() {
        branches::<Double4>();
        branches::<Single8>();
    }
}
