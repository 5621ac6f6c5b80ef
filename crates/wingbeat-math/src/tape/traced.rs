//! The number that writes down what is done with it.

use super::super::{Double4, Lanes, Scalar};
use super::{CONSTANT, MINUS, NONE, ONE, ZERO};
use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// What was done at a node, as places of numbers: its two operands (the second may be [`NONE`]), its slopes, and its curvatures
/// d2/da2, d2/dadb, d2/db2.
pub(super) const FIELDS: usize = 7;

/// Operations written down so far.
#[derive(Clone, Debug, Default)]
pub(super) struct TapeRecording {
    /// [`FIELDS`] places for each node.
    pub shape: Vec<u32>,
    /// The numbers at those places, of which the first `used` count.
    pub cells: Vec<Double4>,
    pub used: usize,
    /// A branch asked for one value where the points had several.
    pub asked: bool,
}

impl TapeRecording {
    /// Begins anew, behind the first `first` cells.
    pub fn begin(&mut self, first: usize) {
        self.shape.clear();
        (self.used, self.asked) = (first, false);
        if self.cells.len() < first {
            self.cells.resize(first, Double4::ZERO);
        }
    }

    #[inline]
    fn number(&mut self, value: Double4) -> u32 {
        match self.cells.get_mut(self.used) {
            Some(cell) => *cell = value,
            None => self.cells.push(value),
        }
        self.used += 1;
        (self.used - 1) as u32
    }

    /// The place of what a number changes by when its node does.
    #[inline]
    fn factor(&mut self, of: Traced) -> u32 {
        if of.unit == NONE { self.number(of.factor) } else { of.unit }
    }

    #[inline]
    fn node(&mut self, shape: [u32; FIELDS]) -> u32 {
        self.shape.extend_from_slice(&shape);
        (self.shape.len() / FIELDS - 1) as u32
    }
}

thread_local! {
    static RECORDING: RefCell<TapeRecording> = const {
        RefCell::new(TapeRecording { shape: Vec::new(), cells: Vec::new(), used: 0, asked: false })
    };
}

/// Exchanges what is written down on this thread with `other`.
pub(super) fn exchange(other: &mut TapeRecording) {
    RECORDING.with_borrow_mut(|recording| std::mem::swap(recording, other));
}

/// A branch asks for one value of several.
#[cold]
fn ask() {
    RECORDING.with_borrow_mut(|recording| recording.asked = true);
}

/// What all lanes of `of` say; where they differ, the first one, and the recording holds for none.
#[inline]
fn agreed<T: PartialEq>(of: impl Fn(usize) -> T) -> T {
    let first = of(0);
    if (1..Double4::WIDTH).any(|lane| of(lane) != first) {
        ask();
    }
    first
}

/// Numbers of several points whose operations are being recorded on this thread: they change by `factor` times what their node changes
/// by, so that constant factors and summands leave no node.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    pub(super) value: Double4,
    pub(super) factor: Double4,
    pub(super) node: u32,
    /// The place of the factor where it is 1 or -1 whatever the point, else [`NONE`].
    pub(super) unit: u32,
}

impl Traced {
    #[inline]
    fn constant(value: Double4) -> Self {
        Self { value, factor: Double4::ZERO, node: CONSTANT, unit: NONE }
    }

    /// The numbers `value` of an input.
    pub(super) fn input(value: Double4) -> Self {
        let shape = [NONE, NONE, ZERO, ZERO, ZERO, ZERO, ZERO];
        Self::of(value, RECORDING.with_borrow_mut(|recording| recording.node(shape)))
    }

    #[inline]
    fn of(value: Double4, node: u32) -> Self {
        Self { value, factor: Double4::ONE, node, unit: ONE }
    }

    /// The number `value` that changes by `slope` times what this one changes by.
    #[inline]
    fn scaled(self, value: Double4, slope: Double4) -> Self {
        Self { value, factor: self.factor * slope, unit: NONE, ..self }
    }

    #[inline]
    fn unary(self, value: Double4, slope: Double4, curvature: Double4) -> Self {
        if self.node == CONSTANT {
            return Self::constant(value);
        }
        let f = self.factor;
        let node = RECORDING.with_borrow_mut(|recording| {
            let (slope, bend) = (recording.number(slope * f), recording.number(curvature * (f * f)));
            recording.node([self.node, NONE, slope, ZERO, bend, ZERO, ZERO])
        });
        Self::of(value, node)
    }

    /// The sum `value`, or the difference where `sign` is [`MINUS`].
    #[inline]
    fn sum(self, o: Self, value: Double4, sign: u32) -> Self {
        let o = if sign == ONE { o } else { -o };
        match (self.node, o.node) {
            (_, CONSTANT) => Self { value, ..self },
            (CONSTANT, _) => Self { value, ..o },
            (a, b) if a == b => Self { value, factor: self.factor + o.factor, node: a, unit: NONE },
            (a, b) => {
                let node = RECORDING.with_borrow_mut(|recording| {
                    let (to_a, to_b) = (recording.factor(self), recording.factor(o));
                    recording.node([a, b, to_a, to_b, ZERO, ZERO, ZERO])
                });
                Self::of(value, node)
            }
        }
    }

    #[inline]
    fn product(self, o: Self, value: Double4) -> Self {
        let (f, g) = (self.factor, o.factor);
        let node = RECORDING.with_borrow_mut(|recording| {
            let (to_a, to_b) = (recording.number(o.value * f), recording.number(self.value * g));
            let bend = recording.number(f * g);
            recording.node([self.node, o.node, to_a, to_b, ZERO, bend, ZERO])
        });
        Self::of(value, node)
    }

    #[inline]
    fn binary(self, o: Self, value: Double4, slope: [Double4; 2], curvature: [Double4; 3]) -> Self {
        let (f, g) = (self.factor, o.factor);
        match (self.node, o.node) {
            (_, CONSTANT) => self.unary(value, slope[0], curvature[0]),
            (CONSTANT, _) => o.unary(value, slope[1], curvature[2]),
            (a, b) if a == b => {
                let one = Self::of(value, a);
                let cross = curvature[1] * (f * g);
                let bend = curvature[0] * (f * f) + (cross + cross) + curvature[2] * (g * g);
                one.unary(value, slope[0] * f + slope[1] * g, bend)
            }
            (a, b) => {
                let node = RECORDING.with_borrow_mut(|recording| {
                    let (to_a, to_b) = (recording.number(slope[0] * f), recording.number(slope[1] * g));
                    let aa = recording.number(curvature[0] * (f * f));
                    let ab = recording.number(curvature[1] * (f * g));
                    let bb = recording.number(curvature[2] * (g * g));
                    recording.node([a, b, to_a, to_b, aa, ab, bb])
                });
                Self::of(value, node)
            }
        }
    }
}

impl Default for Traced {
    fn default() -> Self {
        Self::ZERO
    }
}
impl From<f64> for Traced {
    fn from(x: f64) -> Self {
        Self::constant(Double4::from(x))
    }
}
impl PartialEq for Traced {
    fn eq(&self, other: &Self) -> bool {
        agreed(|lane| self.value.lane(lane) == other.value.lane(lane))
    }
}
impl PartialOrd for Traced {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        agreed(|lane| self.value.lane(lane).partial_cmp(&other.value.lane(lane)))
    }
}
impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        let unit = match self.unit {
            ONE => MINUS,
            MINUS => ONE,
            _ => NONE,
        };
        Self { value: -self.value, factor: -self.factor, node: self.node, unit }
    }
}
impl Add for Traced {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.sum(o, self.value + o.value, ONE)
    }
}
impl Sub for Traced {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.sum(o, self.value - o.value, MINUS)
    }
}
impl Mul for Traced {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let value = self.value * o.value;
        match (self.node, o.node) {
            (_, CONSTANT) => self.scaled(value, o.value),
            (CONSTANT, _) => o.scaled(value, self.value),
            (a, b) if a == b => {
                let (f, g) = (self.factor, o.factor);
                let cross = f * g;
                Self::of(value, a).unary(value, o.value * f + self.value * g, cross + cross)
            }
            _ => self.product(o, value),
        }
    }
}
impl Div for Traced {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let r = o.value.recip();
        let q = self.value * r;
        if o.node == CONSTANT {
            return self.scaled(q, r);
        }
        self.binary(o, q, [r, -q * r], [Double4::ZERO, -r * r, q * r * r * 2.0])
    }
}
impl Add<f64> for Traced {
    type Output = Self;
    fn add(self, o: f64) -> Self {
        Self { value: self.value + o, ..self }
    }
}
impl Sub<f64> for Traced {
    type Output = Self;
    fn sub(self, o: f64) -> Self {
        Self { value: self.value - o, ..self }
    }
}
impl Mul<f64> for Traced {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.scaled(self.value * o, Double4::from(o))
    }
}
impl Div<f64> for Traced {
    type Output = Self;
    fn div(self, o: f64) -> Self {
        self * (1.0 / o)
    }
}
impl Add<Traced> for f64 {
    type Output = Traced;
    fn add(self, o: Traced) -> Traced {
        o + self
    }
}
impl Sub<Traced> for f64 {
    type Output = Traced;
    fn sub(self, o: Traced) -> Traced {
        -o + self
    }
}
impl Mul<Traced> for f64 {
    type Output = Traced;
    fn mul(self, o: Traced) -> Traced {
        o * self
    }
}
impl Div<Traced> for f64 {
    type Output = Traced;
    fn div(self, o: Traced) -> Traced {
        o.recip() * self
    }
}
impl AddAssign for Traced {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl SubAssign for Traced {
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}
impl MulAssign for Traced {
    fn mul_assign(&mut self, o: Self) {
        *self = *self * o;
    }
}
impl MulAssign<f64> for Traced {
    fn mul_assign(&mut self, o: f64) {
        *self = *self * o;
    }
}

impl Scalar for Traced {
    const ZERO: Self = Self { value: Double4::ZERO, factor: Double4::ZERO, node: CONSTANT, unit: NONE };
    const ONE: Self = Self { value: Double4::ONE, factor: Double4::ZERO, node: CONSTANT, unit: NONE };
    const RECORDED: bool = true;

    fn value(self) -> f64 {
        agreed(|lane| self.value.lane(lane))
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let slope = root.recip() * 0.5;
        self.unary(root, slope, slope * -0.5 / self.value)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.unary(e, e, e)
    }
    fn ln(self) -> Self {
        let r = self.value.recip();
        self.unary(self.value.ln(), r, -r * r)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.unary(s, c, -s), self.unary(c, -s, -c))
    }
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        let slope = -t * t + 1.0;
        self.unary(t, slope, t * slope * -2.0)
    }
    fn atan2(self, x: Self) -> Self {
        let (y, x_) = (self.value, x.value);
        let inverse = (y * y + x_ * x_).recip();
        let i2 = inverse * inverse;
        let cross = (y * y - x_ * x_) * i2;
        let slope = [x_ * inverse, -y * inverse];
        let bend = x_ * y * i2 * 2.0;
        self.binary(x, y.atan2(x_), slope, [-bend, cross, bend])
    }
    fn recip(self) -> Self {
        let r = self.value.recip();
        self.unary(r, -r * r, r * r * r * 2.0)
    }
    fn is_finite(self) -> bool {
        agreed(|lane| self.value.lane(lane).is_finite())
    }
    fn is_zero(self) -> bool {
        self.node == CONSTANT && self.value.is_zero()
    }
    fn abs(self) -> Self {
        if agreed(|lane| self.value.lane(lane) < 0.0) { -self } else { self }
    }
    fn if_below(self, limit: Self, then: Self, otherwise: Self) -> Self {
        if agreed(|lane| self.value.lane(lane) < limit.value.lane(lane)) { then } else { otherwise }
    }
    fn positive(self) -> Option<Self> {
        let good = |value: f64| value > 0.0 && value.is_finite();
        agreed(|lane| good(self.value.lane(lane))).then_some(self)
    }
    fn at_least(
        self,
        least: f64,
        [a, b]: [Self; 2],
        measure: impl Fn([f64; 2]) -> f64,
    ) -> Result<(Self, f64), f64> {
        let found: [f64; Double4::WIDTH] =
            std::array::from_fn(|lane| measure([a.value.lane(lane), b.value.lane(lane)]));
        let enough = agreed(|lane| found[lane] >= least);
        let found = found.into_iter().fold(found[0], f64::min);
        if enough { Ok((self, found)) } else { Err(found) }
    }
    fn clamped(self, low: f64, high: f64) -> Self {
        match agreed(|lane| [self.value.lane(lane) < low, self.value.lane(lane) > high]) {
            [true, _] => Self::from(low),
            [_, true] => Self::from(high),
            _ => self,
        }
    }
}
