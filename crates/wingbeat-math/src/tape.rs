//! Derivatives of long functions: the operations are recorded once, then one
//! forward and one backward sweep give the Jacobian and the Hessian of a
//! weighted sum of the outputs, exactly, at a cost that does not grow with the
//! number of outputs (Griewank & Walther 2008, ch. 5, forward over reverse).

use super::Scalar;
use super::rows::fused;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

/// Directions swept together.
const LANES: usize = 8;
/// Node number of a constant.
const CONSTANT: u32 = u32::MAX;

/// One operation: its operands, its slopes and its curvatures
/// (d2/da2, d2/dadb, d2/db2).
#[derive(Clone, Copy, Debug)]
struct TapeNode {
    parents: [u32; 2],
    slope: [f64; 2],
    curvature: [f64; 3],
    curved: bool,
}

thread_local! {
    static RECORDING: RefCell<Vec<TapeNode>> = const { RefCell::new(Vec::new()) };
}

/// A number whose operations are being recorded on this thread.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    value: f64,
    node: u32,
}

impl Traced {
    fn constant(value: f64) -> Self {
        Self { value, node: CONSTANT }
    }

    fn push(value: f64, node: TapeNode) -> Self {
        RECORDING.with_borrow_mut(|nodes| {
            nodes.push(node);
            Self { value, node: (nodes.len() - 1) as u32 }
        })
    }

    #[inline]
    fn unary(self, value: f64, slope: f64, curvature: f64) -> Self {
        if self.node == CONSTANT {
            return Self::constant(value);
        }
        let node = TapeNode {
            parents: [self.node, CONSTANT],
            slope: [slope, 0.0],
            curvature: [curvature, 0.0, 0.0],
            curved: curvature != 0.0,
        };
        Self::push(value, node)
    }

    #[inline]
    fn binary(self, o: Self, value: f64, slope: [f64; 2], curvature: [f64; 3]) -> Self {
        match (self.node, o.node) {
            (CONSTANT, CONSTANT) => Self::constant(value),
            (_, CONSTANT) => self.unary(value, slope[0], curvature[0]),
            (CONSTANT, _) => o.unary(value, slope[1], curvature[2]),
            (a, b) => {
                let curved = curvature[0] != 0.0 || curvature[1] != 0.0 || curvature[2] != 0.0;
                Self::push(value, TapeNode { parents: [a, b], slope, curvature, curved })
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
        self.unary(-self.value, -1.0, 0.0)
    }
}
impl Add for Traced {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        self.binary(o, self.value + o.value, [1.0, 1.0], [0.0; 3])
    }
}
impl Sub for Traced {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        self.binary(o, self.value - o.value, [1.0, -1.0], [0.0; 3])
    }
}
impl Mul for Traced {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        self.binary(o, self.value * o.value, [o.value, self.value], [0.0, 1.0, 0.0])
    }
}
impl Div for Traced {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let r = 1.0 / o.value;
        let q = self.value * r;
        self.binary(o, q, [r, -q * r], [0.0, -r * r, 2.0 * q * r * r])
    }
}
impl Add<f64> for Traced {
    type Output = Self;
    fn add(self, o: f64) -> Self {
        Self { value: self.value + o, node: self.node }
    }
}
impl Sub<f64> for Traced {
    type Output = Self;
    fn sub(self, o: f64) -> Self {
        Self { value: self.value - o, node: self.node }
    }
}
impl Mul<f64> for Traced {
    type Output = Self;
    fn mul(self, o: f64) -> Self {
        self.unary(self.value * o, o, 0.0)
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
    const ZERO: Self = Self { value: 0.0, node: CONSTANT };
    const ONE: Self = Self { value: 1.0, node: CONSTANT };
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

/// A recorded function and the scratch of its sweeps; reused point after point without allocation once it has grown. Inputs and
/// outputs are in the caller's units.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    nodes: Vec<TapeNode>,
    inputs: usize,
    outputs: Vec<Traced>,
    traced: Vec<Traced>,
    live: Vec<bool>,
    adjoint: Vec<f64>,
    /// Derivatives of the nodes along the lanes, and which nodes have any.
    tangent: Vec<[f64; LANES]>,
    moves: Vec<bool>,
    /// The same of the adjoints.
    bend: Vec<[f64; LANES]>,
    bends: Vec<bool>,
}

impl Tape {
    /// Records `f(inputs, outputs)` at a point and writes the output values.
    pub fn record<E>(
        &mut self,
        inputs: &[f64],
        outputs: &mut [f64],
        f: impl FnOnce(&[Traced], &mut [Traced]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.inputs = inputs.len();
        self.nodes.clear();
        RECORDING.with_borrow_mut(|nodes| std::mem::swap(nodes, &mut self.nodes));
        self.traced.clear();
        self.traced.extend(inputs.iter().map(|&value| {
            let source =
                TapeNode { parents: [CONSTANT; 2], slope: [0.0; 2], curvature: [0.0; 3], curved: false };
            Traced::push(value, source)
        }));
        self.outputs.clear();
        self.outputs.resize(outputs.len(), Traced::ZERO);
        let result = f(&self.traced, &mut self.outputs);
        RECORDING.with_borrow_mut(|nodes| std::mem::swap(nodes, &mut self.nodes));
        for (out, traced) in outputs.iter_mut().zip(&self.outputs) {
            *out = traced.value;
        }
        result
    }

    /// The Jacobian (row-major outputs x inputs) and the Hessian of
    /// sum_i weights_i output_i (row-major inputs x inputs).
    pub fn second_order(&mut self, weights: &[f64], jacobian: &mut [f64], hessian: &mut [f64]) {
        self.sweep_adjoints(weights);
        let n = self.inputs;
        for first in (0..n).step_by(LANES) {
            self.sweep_forward(first);
            self.store_jacobian(first, jacobian);
            self.sweep_backward();
            for i in 0..n {
                for j in first..(first + LANES).min(n) {
                    hessian[i * n + j] = self.bend[i][j - first];
                }
            }
        }
    }

    fn store_jacobian(&self, first: usize, jacobian: &mut [f64]) {
        let n = self.inputs;
        for (row, output) in jacobian.chunks_exact_mut(n).zip(&self.outputs) {
            let constant = output.node == CONSTANT;
            let slopes = if constant { [0.0; LANES] } else { self.tangent[output.node as usize] };
            let end = (first + LANES).min(n);
            row[first..end].copy_from_slice(&slopes[..end - first]);
        }
    }

    /// Derivatives of every node along inputs first .. first + LANES.
    fn sweep_forward(&mut self, first: usize) {
        let (n, count) = (self.inputs, self.nodes.len());
        let Self { nodes, tangent, moves, .. } = self;
        moves.clear();
        moves.resize(count, false);
        tangent.clear();
        tangent.resize(count, [0.0; LANES]);
        for lane in 0..LANES.min(n - first) {
            tangent[first + lane][lane] = 1.0;
            moves[first + lane] = true;
        }
        for i in n..count {
            let TapeNode { parents: [a, b], slope, .. } = nodes[i];
            // A node without a second operand takes the first, with a slope of zero.
            let (a, b) = (a as usize, if b == CONSTANT { a as usize } else { b as usize });
            moves[i] = moves[a] | moves[b];
            if !moves[i] {
                continue;
            }
            let (x, y) = (tangent[a], tangent[b]);
            let t = &mut tangent[i];
            for l in 0..LANES {
                t[l] = fused(slope[1], y[l], slope[0] * x[l]);
            }
        }
    }

    /// d (weighted sum) / d node, and which nodes it depends on.
    fn sweep_adjoints(&mut self, weights: &[f64]) {
        self.adjoint.clear();
        self.adjoint.resize(self.nodes.len(), 0.0);
        self.live.clear();
        self.live.resize(self.nodes.len(), false);
        for (output, w) in self.outputs.iter().zip(weights) {
            if output.node != CONSTANT && *w != 0.0 {
                self.adjoint[output.node as usize] += w;
                self.live[output.node as usize] = true;
            }
        }
        for i in (self.inputs..self.nodes.len()).rev() {
            if !self.live[i] {
                continue;
            }
            let (node, adjoint) = (&self.nodes[i], self.adjoint[i]);
            for side in 0..2 {
                let parent = node.parents[side] as usize;
                if parent != CONSTANT as usize {
                    self.adjoint[parent] += node.slope[side] * adjoint;
                    self.live[parent] = true;
                }
            }
        }
    }

    /// Derivatives of the adjoints along the lanes of the last forward sweep.
    fn sweep_backward(&mut self) {
        let (n, count) = (self.inputs, self.nodes.len());
        let Self { nodes, live, adjoint, tangent, moves, bend, bends, .. } = self;
        bends.clear();
        bends.resize(count, false);
        bend.clear();
        bend.resize(count, [0.0; LANES]);
        for i in (n..count).rev() {
            if !live[i] {
                continue;
            }
            let TapeNode { parents: [a, b], slope, curvature, curved } = nodes[i];
            let (a, two) = (a as usize, b != CONSTANT);
            let b = if two { b as usize } else { a };
            let curved = curved && (moves[a] | moves[b]);
            if !(curved | bends[i]) {
                continue;
            }
            let own = bend[i];
            let (mut to_a, mut to_b) = ([0.0; LANES], [0.0; LANES]);
            for l in 0..LANES {
                to_a[l] = slope[0] * own[l];
                to_b[l] = slope[1] * own[l];
            }
            if curved {
                let [aa, ab, bb] = curvature;
                let (aa, ab, bb) = (aa * adjoint[i], ab * adjoint[i], bb * adjoint[i]);
                let (along_a, along_b) = (&tangent[a], &tangent[b]);
                for l in 0..LANES {
                    to_a[l] = fused(aa, along_a[l], fused(ab, along_b[l], to_a[l]));
                    to_b[l] = fused(ab, along_a[l], fused(bb, along_b[l], to_b[l]));
                }
            }
            bends[a] = true;
            let sum = &mut bend[a];
            for l in 0..LANES {
                sum[l] += to_a[l];
            }
            if two {
                bends[b] = true;
                let sum = &mut bend[b];
                for l in 0..LANES {
                    sum[l] += to_b[l];
                }
            }
        }
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
