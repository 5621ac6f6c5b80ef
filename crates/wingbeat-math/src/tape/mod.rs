//! Derivatives of long functions: the operations are recorded once, then one
//! forward and one backward sweep give the Jacobian and the Hessian of a
//! weighted sum of the outputs, exactly, at a cost that does not grow with the
//! number of outputs (Griewank & Walther 2008, ch. 5, forward over reverse).
//! Operations that were met often are eliminated instead, at four points side by side.

mod elimination;
mod four;

pub use four::{FourDerivatives, TapeFour};

use super::Scalar;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::mem::ManuallyDrop;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use wide::f64x4;

/// Directions swept together, and by how many registers.
const LANES: usize = 20;
const CHUNKS: usize = LANES / 4;
/// Node number of a constant.
const CONSTANT: u32 = u32::MAX;

/// What a node is, which says which of its numbers are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TapeKind {
    Input,
    /// No curvatures.
    Sum,
    /// d2/dadb alone.
    Product,
    /// One operand, named twice; its second slope and the curvatures along it are zero.
    Unary,
    Binary,
}

/// One operation: its operands, its two slopes and its curvatures d2/da2, d2/dadb, d2/db2.
#[derive(Clone, Copy, Debug)]
struct TapeNode {
    parents: [u32; 2],
    kind: TapeKind,
    numbers: [f64; 5],
}

impl TapeNode {
    #[inline]
    fn operands_as_one(&self) -> u64 {
        let [a, b] = self.parents;
        u64::from(a) | u64::from(b) << 32
    }

    /// Slopes, d2/da2 and d2/dadb.
    #[inline]
    fn first_four(&self) -> [f64; 4] {
        let [a, b, aa, ab, _] = self.numbers;
        [a, b, aa, ab]
    }

    #[inline]
    fn curved(&self) -> bool {
        self.kind != TapeKind::Sum
    }

    #[inline]
    fn operands(&self) -> [usize; 2] {
        let [a, b] = self.parents;
        [a as usize, b as usize]
    }
}

thread_local! {
    // Without a destructor it is found without a call; between recordings it holds nothing.
    static RECORDING: RefCell<ManuallyDrop<Vec<TapeNode>>> = const { RefCell::new(ManuallyDrop::new(Vec::new())) };
}

/// Writes a node down; returns its number. Its numbers are taken where there is room for it, straight from registers: what is copied
/// through memory in pieces of another size waits.
#[inline(always)]
fn write(node: impl Fn() -> TapeNode) -> u32 {
    // Of the ways to a number of a thread this one is inlined.
    let number = RECORDING.try_with(|nodes| {
        let mut nodes = nodes.borrow_mut();
        let number = nodes.len();
        if number == nodes.capacity() {
            return CONSTANT;
        }
        nodes.push(node());
        number as u32
    });
    match number {
        Ok(number) if number != CONSTANT => number,
        _ => write_grown(node()),
    }
}

/// As [`write`], where there is no room.
#[cold]
#[inline(never)]
fn write_grown(node: TapeNode) -> u32 {
    RECORDING.with_borrow_mut(|nodes| {
        nodes.push(node);
        (nodes.len() - 1) as u32
    })
}

/// Exchanges what was written down on this thread for `other`.
fn exchange(other: &mut Vec<TapeNode>) {
    RECORDING.with_borrow_mut(|nodes| std::mem::swap(&mut **nodes, other));
}

/// A number whose operations are being recorded on this thread: it changes by `factor` times what its node changes by, so that constant
/// factors and summands leave no node.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    value: f64,
    factor: f64,
    node: u32,
}

impl Traced {
    const fn constant(value: f64) -> Self {
        Self { value, factor: 0.0, node: CONSTANT }
    }

    /// The number `value` of a node.
    #[inline]
    fn of(value: f64, node: u32) -> Self {
        Self { value, factor: 1.0, node }
    }

    /// The number `value` that changes by `slope` times what this one changes by.
    #[inline]
    fn scaled(self, value: f64, slope: f64) -> Self {
        Self { value, factor: self.factor * slope, node: self.node }
    }

    #[inline]
    fn unary(self, value: f64, slope: f64, curvature: f64) -> Self {
        if self.node == CONSTANT {
            return Self::constant(value);
        }
        let f = self.factor;
        let numbers = [slope * f, 0.0, curvature * (f * f), 0.0, 0.0];
        Self::of(value, write(|| TapeNode { parents: [self.node; 2], kind: TapeKind::Unary, numbers }))
    }

    /// A sum: its slopes do not change.
    #[inline]
    fn sum(self, o: Self, value: f64, slope: [f64; 2]) -> Self {
        match (self.node, o.node) {
            (_, CONSTANT) => self.scaled(value, slope[0]),
            (CONSTANT, _) => o.scaled(value, slope[1]),
            (a, b) => {
                let numbers = [slope[0] * self.factor, slope[1] * o.factor, 0.0, 0.0, 0.0];
                Self::of(value, write(|| TapeNode { parents: [a, b], kind: TapeKind::Sum, numbers }))
            }
        }
    }

    #[inline]
    fn binary(self, o: Self, value: f64, slope: [f64; 2], curvature: [f64; 3]) -> Self {
        match (self.node, o.node) {
            (_, CONSTANT) => self.unary(value, slope[0], curvature[0]),
            (CONSTANT, _) => o.unary(value, slope[1], curvature[2]),
            (a, b) => {
                let (f, g) = (self.factor, o.factor);
                let [aa, ab, bb] = curvature;
                let numbers = [slope[0] * f, slope[1] * g, aa * (f * f), ab * (f * g), bb * (g * g)];
                Self::of(value, write(|| TapeNode { parents: [a, b], kind: TapeKind::Binary, numbers }))
            }
        }
    }
}

impl Default for Traced {
    fn default() -> Self {
        Self::constant(0.0)
    }
}
impl From<f64> for Traced {
    fn from(x: f64) -> Self {
        Self::constant(x)
    }
}
impl PartialEq for Traced {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}
impl PartialOrd for Traced {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}
impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        self.scaled(-self.value, -1.0)
    }
}
impl Add for Traced {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.sum(o, self.value + o.value, [1.0, 1.0])
    }
}
impl Sub for Traced {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.sum(o, self.value - o.value, [1.0, -1.0])
    }
}
impl Mul for Traced {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let value = self.value * o.value;
        match (self.node, o.node) {
            (_, CONSTANT) => self.scaled(value, o.value),
            (CONSTANT, _) => o.scaled(value, self.value),
            (a, b) => {
                let (f, g) = (self.factor, o.factor);
                let numbers = [o.value * f, self.value * g, 0.0, f * g, 0.0];
                Self::of(value, write(|| TapeNode { parents: [a, b], kind: TapeKind::Product, numbers }))
            }
        }
    }
}
impl Div for Traced {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let r = 1.0 / o.value;
        let q = self.value * r;
        if o.node == CONSTANT {
            return self.scaled(q, r);
        }
        self.binary(o, q, [r, -q * r], [0.0, -r * r, 2.0 * q * r * r])
    }
}
impl Add<f64> for Traced {
    type Output = Self;
    fn add(self, o: f64) -> Self {
        self.scaled(self.value + o, 1.0)
    }
}
impl Sub<f64> for Traced {
    type Output = Self;
    fn sub(self, o: f64) -> Self {
        self.scaled(self.value - o, 1.0)
    }
}
impl Mul<f64> for Traced {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.scaled(self.value * o, o)
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
    const ZERO: Self = Self::constant(0.0);
    const ONE: Self = Self::constant(1.0);
    const RECORDED: bool = true;

    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let slope = 0.5 / root;
        self.unary(root, slope, -0.5 * slope / self.value)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.unary(e, e, e)
    }
    fn ln(self) -> Self {
        let r = 1.0 / self.value;
        self.unary(self.value.ln(), r, -r * r)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.unary(s, c, -s), self.unary(c, -s, -c))
    }
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        let slope = 1.0 - t * t;
        self.unary(t, slope, -2.0 * t * slope)
    }
    fn atan2(self, x: Self) -> Self {
        let (y, x_) = (self.value, x.value);
        let inverse = 1.0 / (y * y + x_ * x_);
        let i2 = inverse * inverse;
        let cross = (y * y - x_ * x_) * i2;
        let slope = [x_ * inverse, -y * inverse];
        let bend = 2.0 * x_ * y * i2;
        self.binary(x, y.atan2(x_), slope, [-bend, cross, bend])
    }
    fn recip(self) -> Self {
        let r = 1.0 / self.value;
        self.unary(r, -r * r, 2.0 * r * r * r)
    }
    fn is_finite(self) -> bool {
        self.value.is_finite()
    }
    fn is_zero(self) -> bool {
        self.node == CONSTANT && self.value == 0.0
    }
}

/// A recorded function.
#[derive(Clone, Debug, Default)]
struct TapeRecording {
    nodes: Vec<TapeNode>,
    inputs: usize,
    outputs: Vec<Traced>,
}

/// A recorded function and the scratch of its sweeps; reused point after point without allocation once it has grown. Inputs and
/// outputs are in the caller's units.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    recorded: TapeRecording,
    traced: Vec<Traced>,
    reach: Vec<TapeReach>,
    /// Derivatives of the nodes along the lanes, and of their adjoints.
    tangent: Vec<[f64; LANES]>,
    /// They are zero again once they were used.
    bend: Vec<[f64; LANES]>,
}

/// The adjoint of a node, and the groups of lanes that reach it: bit g % 64 is that of group g, so that of more than 64 groups
/// several share a bit and some zeros are swept.
#[derive(Clone, Copy, Debug, Default)]
struct TapeReach {
    adjoint: f64,
    /// The weighted sum depends on the node.
    live: bool,
    /// Groups of inputs along which the node changes.
    moves: u64,
    /// Groups of inputs along which its adjoint changes.
    bends: u64,
}

/// The bit of the group of lanes that begins with input `first`.
fn group(first: usize) -> u64 {
    1 << (first / LANES % 64)
}

impl Tape {
    /// Records `f(inputs, outputs)` at a point and writes the output values.
    pub fn record<E>(
        &mut self,
        inputs: &[f64],
        outputs: &mut [f64],
        f: impl FnOnce(&[Traced], &mut [Traced]) -> Result<(), E>,
    ) -> Result<(), E> {
        let Self { recorded, traced, .. } = self;
        recorded.inputs = inputs.len();
        recorded.nodes.clear();
        exchange(&mut recorded.nodes);
        traced.clear();
        traced.extend(inputs.iter().map(|&value| {
            let source = TapeNode { parents: [CONSTANT; 2], kind: TapeKind::Input, numbers: [0.0; 5] };
            Traced::of(value, write(|| source))
        }));
        recorded.outputs.clear();
        recorded.outputs.resize(outputs.len(), Traced::ZERO);
        let result = f(traced, &mut recorded.outputs);
        exchange(&mut recorded.nodes);
        for (out, traced) in outputs.iter_mut().zip(&recorded.outputs) {
            *out = traced.value;
        }
        result
    }

    /// The Jacobian (row-major outputs x inputs) and the Hessian of
    /// sum_i weights_i output_i (row-major inputs x inputs).
    pub fn second_order(&mut self, weights: &[f64], jacobian: &mut [f64], hessian: &mut [f64]) {
        self.find_reach();
        self.sweep_adjoints(weights);
        self.tangent.resize(self.recorded.nodes.len(), [0.0; LANES]);
        self.bend.resize(self.recorded.nodes.len(), [0.0; LANES]);
        let n = self.recorded.inputs;
        for first in (0..n).step_by(LANES) {
            self.sweep_forward(first);
            for (row, output) in jacobian.chunks_exact_mut(n).zip(&self.recorded.outputs) {
                let node = output.node as usize;
                let mut slopes = if output.node == CONSTANT { [0.0; LANES] } else { self.tangent[node] };
                for l in 0..LANES {
                    slopes[l] *= output.factor;
                }
                store(&slopes, &mut row[first..]);
            }
            self.sweep_backward(first);
            for (row, bend) in hessian.chunks_exact_mut(n).zip(&mut self.bend) {
                store(bend, &mut row[first..]);
                *bend = [0.0; LANES];
            }
        }
    }

    /// Which inputs the nodes change along.
    fn find_reach(&mut self) {
        self.reach.clear();
        self.reach.resize(self.recorded.nodes.len(), TapeReach::default());
        for i in 0..self.recorded.inputs {
            self.reach[i].moves = group(i);
        }
        for i in self.recorded.inputs..self.recorded.nodes.len() {
            let [a, b] = self.recorded.nodes[i].operands();
            self.reach[i].moves = self.reach[a].moves | self.reach[b].moves;
        }
    }

    /// d (weighted sum) / d node, and which inputs it changes along.
    fn sweep_adjoints(&mut self, weights: &[f64]) {
        let Self { recorded: TapeRecording { nodes, outputs, inputs }, reach, .. } = self;
        for (output, w) in outputs.iter().zip(weights) {
            if output.node != CONSTANT && *w != 0.0 {
                let node = &mut reach[output.node as usize];
                node.adjoint += w * output.factor;
                node.live = true;
            }
        }
        for i in (*inputs..nodes.len()).rev() {
            let TapeReach { adjoint, live, moves, bends } = reach[i];
            if !live {
                continue;
            }
            let (operands, slope) = (nodes[i].operands(), &nodes[i].numbers);
            let bends = if nodes[i].curved() { bends | moves } else { bends };
            reach[i].bends = bends;
            for side in 0..2 {
                let operand = &mut reach[operands[side]];
                operand.adjoint += slope[side] * adjoint;
                operand.live = true;
                operand.bends |= bends;
            }
        }
    }

    /// Derivatives of every node along inputs first .. first + LANES.
    fn sweep_forward(&mut self, first: usize) {
        let TapeRecording { nodes, inputs, .. } = &self.recorded;
        let (n, count) = (*inputs, nodes.len());
        let (nodes, reach) = (&nodes[..count], &self.reach[..count]);
        let tangent = &mut self.tangent[..count];
        let bit = group(first);
        for i in 0..n {
            tangent[i] = [0.0; LANES];
        }
        for lane in 0..LANES.min(n - first) {
            tangent[first + lane][lane] = 1.0;
        }
        for i in n..count {
            if reach[i].moves & bit == 0 {
                tangent[i] = [0.0; LANES];
                continue;
            }
            let ([a, b], [to_a, to_b, ..]) = (nodes[i].operands(), nodes[i].numbers);
            let (before, own) = tangent.split_at_mut(i);
            let (x, y) = (chunks(&before[a]), chunks(&before[b]));
            let (t, to_a) = (chunks_mut(&mut own[0]), f64x4::splat(to_a));
            if nodes[i].kind == TapeKind::Unary {
                for l in 0..CHUNKS {
                    t[l] = (to_a * f64x4::new(x[l])).to_array();
                }
                continue;
            }
            let to_b = f64x4::splat(to_b);
            for l in 0..CHUNKS {
                t[l] = to_b.mul_add(f64x4::new(y[l]), to_a * f64x4::new(x[l])).to_array();
            }
        }
    }

    /// Derivatives of the adjoints along the lanes of the last forward sweep, which began with input `first`.
    fn sweep_backward(&mut self, first: usize) {
        let TapeRecording { nodes, inputs, .. } = &self.recorded;
        let (n, count) = (*inputs, nodes.len());
        let (nodes, reach) = (&nodes[..count], &self.reach[..count]);
        let (tangent, bend) = (&self.tangent[..count], &mut self.bend[..count]);
        let bit = group(first);
        for i in (n..count).rev() {
            if reach[i].bends & bit == 0 {
                continue;
            }
            let TapeNode { kind, numbers: [to_a, to_b, aa, ab, bb], .. } = nodes[i];
            let ([a, b], adjoint) = (nodes[i].operands(), reach[i].adjoint);
            let (to_a, to_b) = (f64x4::splat(to_a), f64x4::splat(to_b));
            let (before, own) = bend.split_at_mut(i);
            // It is zero again for the next sweep, while it is in the cache.
            let own = std::mem::replace(&mut own[0], [0.0; LANES]);
            let (own, along_a, along_b) = (chunks(&own), chunks(&tangent[a]), chunks(&tangent[b]));
            let number = |of: &[[f64; 4]], l: usize| f64x4::new(of[l]);
            // What is always zero is left out.
            match kind {
                TapeKind::Input => {}
                TapeKind::Sum => {
                    let sum = chunks_mut(&mut before[a]);
                    for l in 0..CHUNKS {
                        sum[l] = (to_a * number(own, l) + number(sum, l)).to_array();
                    }
                    let sum = chunks_mut(&mut before[b]);
                    for l in 0..CHUNKS {
                        sum[l] = (to_b * number(own, l) + number(sum, l)).to_array();
                    }
                }
                TapeKind::Unary => {
                    let (sum, aa) = (chunks_mut(&mut before[a]), f64x4::splat(aa * adjoint));
                    for l in 0..CHUNKS {
                        let change = aa.mul_add(number(along_a, l), to_a * number(own, l));
                        sum[l] = (change + number(sum, l)).to_array();
                    }
                }
                TapeKind::Product => {
                    let ab = f64x4::splat(ab * adjoint);
                    let sum = chunks_mut(&mut before[a]);
                    for l in 0..CHUNKS {
                        let change = ab.mul_add(number(along_b, l), to_a * number(own, l));
                        sum[l] = (change + number(sum, l)).to_array();
                    }
                    let sum = chunks_mut(&mut before[b]);
                    for l in 0..CHUNKS {
                        let change = ab.mul_add(number(along_a, l), to_b * number(own, l));
                        sum[l] = (change + number(sum, l)).to_array();
                    }
                }
                TapeKind::Binary => {
                    let (aa, ab, bb) =
                        (f64x4::splat(aa * adjoint), f64x4::splat(ab * adjoint), f64x4::splat(bb * adjoint));
                    let sum = chunks_mut(&mut before[a]);
                    for l in 0..CHUNKS {
                        let change = ab.mul_add(number(along_b, l), to_a * number(own, l));
                        sum[l] = (aa.mul_add(number(along_a, l), change) + number(sum, l)).to_array();
                    }
                    let sum = chunks_mut(&mut before[b]);
                    for l in 0..CHUNKS {
                        let change = bb.mul_add(number(along_b, l), to_b * number(own, l));
                        sum[l] = (ab.mul_add(number(along_a, l), change) + number(sum, l)).to_array();
                    }
                }
            }
        }
    }
}

/// The lanes, by fours.
#[inline]
fn chunks(lanes: &[f64; LANES]) -> &[[f64; 4]] {
    lanes.as_chunks().0
}

#[inline]
fn chunks_mut(lanes: &mut [f64; LANES]) -> &mut [[f64; 4]] {
    lanes.as_chunks_mut().0
}

/// Writes the lanes to the start of `row`, as many as it has room for.
#[inline]
fn store(lanes: &[f64; LANES], row: &mut [f64]) {
    match row.first_chunk_mut() {
        Some(whole) => *whole = *lanes,
        None => row.copy_from_slice(&lanes[..row.len()]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dual;

    fn every_operation<S: Scalar>(x: &[S], out: &mut [S]) {
        let [a, b, c] = [x[0], x[1], x[2]];
        let (s, co) = (a * b).sin_cos();
        out[0] = s / (co + 2.0) + (a * a + c * c).sqrt() * b.exp() - c.ln();
        out[1] = a.atan2(b * c) + (b - c * 0.5).tanh() * c.recip() - a / b;
        out[2] = S::from(4.0);
        out[0] *= a + 1.0;
    }

    #[test]
    fn tape_agrees_with_nested_duals() {
        let (x, w) = ([0.7, -1.3, 0.9], [0.4, -2.1, 1.0]);
        let mut tape = Tape::default();
        let (mut out, mut jacobian, mut hessian) = ([0.0; 3], [0.0; 9], [0.0; 9]);
        for _ in 0..2 {
            let record = |x: &[Traced], out: &mut [Traced]| {
                every_operation(x, out);
                Ok::<(), ()>(())
            };
            tape.record(&x, &mut out, record).unwrap();
            tape.second_order(&w, &mut jacobian, &mut hessian);
        }
        type Second = Dual<3, Dual<3>>;
        let xs: [Second; 3] = std::array::from_fn(|i| Dual::variable(Dual::variable(x[i], i), i));
        let mut ys = [Second::ZERO; 3];
        every_operation(&xs, &mut ys);
        for i in 0..3 {
            assert!((out[i] - ys[i].value()).abs() < 1e-14);
            for j in 0..3 {
                assert!((jacobian[3 * i + j] - ys[i].eps[j].re).abs() < 1e-13);
                let second: f64 = (0..3).map(|k| w[k] * ys[k].eps[i].eps[j]).sum();
                assert!((hessian[3 * i + j] - second).abs() < 1e-12, "{i} {j}");
            }
        }
    }
}
