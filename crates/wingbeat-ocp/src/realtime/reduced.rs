//! The Gauss-Newton quadratic program in the inputs alone.

use super::active_set::QuadraticProgram;
use super::condense::{Columns, Elimination};
use super::dense::{multiply_add, padded};
use super::plan::{Horizon, Plan};
use super::status::Limit;
use super::tracking::{Component, Tracking};
use crate::plant::Channel;
use wingbeat_math::Dual;
use wingbeat_math::rows::{axpy, dot};

/// Directions of one residual evaluation.
const LANES: usize = 8;

/// Assembles the program of one iteration.
#[derive(Clone, Debug)]
pub struct Reduction {
    horizon: Horizon,
    x: Vec<Dual<LANES>>,
    u: Vec<Dual<LANES>>,
    r: Vec<Dual<LANES>>,
    by_input: Vec<f64>,
    /// Slopes of the residuals: of all nodes where states are moved afterwards, else of the last.
    slopes: Vec<ResidualSlopes>,
    /// Meaning of each row of the program.
    pub meaning: Vec<Limit>,
}

/// Derivatives of the residuals of a node.
#[derive(Clone, Debug)]
struct ResidualSlopes {
    by_state: Vec<f64>,
    /// By [1, du], residuals x columns.
    reduced: Vec<f64>,
}

impl Reduction {
    /// Storage for residual vectors of at most `residuals` and `rows` limits that keeps the slopes of `kept` nodes.
    pub fn new(horizon: Horizon, residuals: usize, rows: usize, kept: usize) -> Self {
        let Horizon { states: n, inputs: m, intervals, .. } = horizon;
        let zero = Dual::constant(0.0);
        Self {
            horizon,
            x: vec![zero; n],
            u: vec![zero; m],
            r: vec![zero; residuals],
            by_input: vec![0.0; residuals * m],
            slopes: vec![
                ResidualSlopes {
                    by_state: vec![0.0; residuals * n],
                    reduced: vec![0.0; residuals * padded(1 + (intervals + 1) * m)],
                };
                kept
            ],
            meaning: Vec::with_capacity(rows),
        }
    }

    /// Has intervals of `step` s.
    pub fn cut(&mut self, step: f64) {
        self.horizon.step = step;
    }

    /// Adds the cost of every node and of the input changes to `qp`.
    pub fn cost<T: Tracking>(
        &mut self,
        tracking: &T,
        plan: &Plan,
        states: &Elimination,
        columns: Columns,
        qp: &mut QuadraticProgram,
    ) {
        qp.hessian.fill(0.0);
        qp.gradient.fill(0.0);
        for node in 0..=self.horizon.intervals {
            self.node_cost(tracking, plan, node, states, columns, qp);
        }
        for node in 0..self.horizon.intervals {
            change_cost(tracking, plan, node, columns, qp);
        }
        let n = qp.gradient.len();
        for i in 0..n {
            for j in 0..i {
                qp.hessian[j * n + i] = qp.hessian[i * n + j];
            }
        }
    }

    /// Adds 2 J'J and 2 J'r of one node, with J = r_x S + r_u, to the lower triangle.
    fn node_cost<T: Tracking>(
        &mut self,
        tracking: &T,
        plan: &Plan,
        node: usize,
        states: &Elimination,
        columns: Columns,
        qp: &mut QuadraticProgram,
    ) {
        let (n, m) = (self.horizon.states, self.horizon.inputs);
        let (count, size) = (tracking.residuals(node), qp.gradient.len());
        let (width, used) = (columns.width(node), columns.through(node));
        self.differentiate(tracking, plan, node, count);
        let slot = node % self.slopes.len();
        let ResidualSlopes { by_state, reduced } = &mut self.slopes[slot];
        let reduced = &mut reduced[..count * width];
        for ((row, r), by_input) in
            reduced.chunks_exact_mut(width).zip(&self.r).zip(self.by_input.chunks_exact(m))
        {
            row.fill(0.0);
            row[0] = r.re;
            if let Some(first) = columns.of(node) {
                row[first..first + m].copy_from_slice(by_input);
            }
        }
        let by_state = &by_state[..count * n];
        multiply_add(reduced, by_state, states.state(node, columns), width);
        for row in reduced.chunks_exact(width) {
            let (r, slope) = (row[0], &row[1..used]);
            axpy(&mut qp.gradient, 2.0 * r, slope);
            // Most residuals of inputs know one.
            for (i, s) in slope.iter().enumerate().filter(|(_, s)| **s != 0.0) {
                axpy(&mut qp.hessian[i * size..][..=i], 2.0 * s, slope);
            }
        }
    }

    /// Moves gradient and limits of `qp` by the move of each node's states, in padded rows and the units of the states:
    /// dg = 2 J' r_x dx.
    pub fn move_start<T: Tracking>(
        &self,
        tracking: &T,
        moved: &[f64],
        columns: Columns,
        qp: &mut QuadraticProgram,
    ) {
        let n = self.horizon.states;
        let by = |node: usize| &moved[node * padded(n)..][..n];
        for (node, ResidualSlopes { by_state, reduced }) in self.slopes.iter().enumerate() {
            let (width, used) = (columns.width(node), columns.through(node));
            for i in 0..tracking.residuals(node) {
                let more = dot(&by_state[i * n..][..n], by(node));
                axpy(&mut qp.gradient, 2.0 * more, &reduced[i * width + 1..i * width + used]);
            }
        }
        for (row, limit) in self.meaning.iter().enumerate() {
            let more = match *limit {
                Limit::State { channel, node } => by(node)[channel],
                Limit::Linear { row, node } => {
                    let terms = tracking.limits()[row].terms.iter();
                    let state = |&(component, c): &(Component, f64)| match component {
                        Component::State(i) => c * by(node)[i],
                        Component::Input(_) => 0.0,
                    };
                    terms.map(state).sum()
                }
                Limit::Input { .. } | Limit::Rate { .. } => 0.0,
            };
            qp.row_low[row] -= more;
            qp.row_high[row] -= more;
        }
    }

    /// Residuals of `node` and their derivatives by state and input.
    fn differentiate<T: Tracking>(&mut self, tracking: &T, plan: &Plan, node: usize, count: usize) {
        let (n, m) = (self.horizon.states, self.horizon.inputs);
        let slot = node % self.slopes.len();
        for (d, x) in self.x.iter_mut().zip(plan.state(node)) {
            *d = Dual::constant(*x);
        }
        for (d, u) in self.u.iter_mut().zip(plan.input(node)) {
            *d = Dual::constant(*u);
        }
        // Those of inputs follow the states that are known.
        let known = tracking.known_states(n);
        let count_known = known.len();
        for first in (0..count_known + m).step_by(LANES) {
            let block = first..(first + LANES).min(count_known + m);
            for j in block.clone() {
                let variable = match j.checked_sub(count_known) {
                    None => &mut self.x[known.start + j],
                    Some(j) => &mut self.u[j],
                };
                variable.eps[j - first] = 1.0;
            }
            let r = &mut self.r[..count];
            tracking.residual(node, plan.time(node), &self.x, &self.u, r);
            for j in block {
                let (matrix, stride, column) = match j.checked_sub(count_known) {
                    None => (&mut self.slopes[slot].by_state, n, known.start + j),
                    Some(j) => (&mut self.by_input, m, j),
                };
                for (i, r) in r.iter().enumerate() {
                    matrix[i * stride + column] = r.eps[j - first];
                }
                let variable = match j.checked_sub(count_known) {
                    None => &mut self.x[known.start + j],
                    Some(j) => &mut self.u[j],
                };
                variable.eps[j - first] = 0.0;
            }
        }
    }

    /// Writes the limits on the steps of inputs, and the rows that limit states
    /// and linear combinations at the nodes after the first and the rates of
    /// inputs in between.
    pub fn limits<T: Tracking>(
        &mut self,
        channels: [&[Channel]; 2],
        tracking: &T,
        plan: &Plan,
        states: &Elimination,
        columns: Columns,
        qp: &mut QuadraticProgram,
    ) {
        let (m, size) = (self.horizon.inputs, qp.gradient.len());
        for node in columns.first..=self.horizon.intervals {
            for (j, (channel, u)) in channels[1].iter().zip(plan.input(node)).enumerate() {
                let i = (node - columns.first) * m + j;
                (qp.low[i], qp.high[i]) = (channel.low - u, channel.high - u);
            }
        }
        self.meaning.clear();
        qp.rows.fill(0.0);
        for node in 1..=self.horizon.intervals {
            let (width, used) = (columns.width(node), columns.through(node));
            let (sensitivity, x) = (states.state(node, columns), plan.state(node));
            for (i, channel) in limited(channels[0]) {
                let row = self.meaning.len();
                let s = &sensitivity[i * width..][..width];
                qp.rows[row * size..][..used - 1].copy_from_slice(&s[1..used]);
                let value = x[i] + s[0];
                (qp.row_low[row], qp.row_high[row]) = (channel.low - value, channel.high - value);
                self.meaning.push(Limit::State { channel: i, node });
            }
            for (index, limit) in tracking.limits().iter().enumerate() {
                let row = self.meaning.len();
                let entries = &mut qp.rows[row * size..][..size];
                let mut value = 0.0;
                for &(component, c) in &limit.terms {
                    match component {
                        Component::State(i) => {
                            let s = &sensitivity[i * width..][..width];
                            axpy(entries, c, &s[1..used]);
                            value += c * (x[i] + s[0]);
                        }
                        Component::Input(j) => {
                            value += c * plan.input(node)[j];
                            if let Some(first) = columns.of(node) {
                                entries[first - 1 + j] += c;
                            }
                        }
                    }
                }
                (qp.row_low[row], qp.row_high[row]) = (limit.low - value, limit.high - value);
                self.meaning.push(Limit::Linear { row: index, node });
            }
            self.rate_rows(tracking, plan, node, columns, qp);
        }
    }

    /// |u_k - u_{k-1}| <= r h for the inputs whose rate is limited, k = `node`.
    ///
    /// Equation: ocp.input_rate
    /// `abs(u_{k+1} - u_k) <= r h on every interval`
    /// Source: piecewise linear input.
    /// Test: `the_rate_of_an_input_is_limited_from_the_held_one_on`.
    fn rate_rows<T: Tracking>(
        &mut self,
        tracking: &T,
        plan: &Plan,
        node: usize,
        columns: Columns,
        qp: &mut QuadraticProgram,
    ) {
        let size = qp.gradient.len();
        for j in rate_limited(tracking, self.horizon.inputs) {
            let row = self.meaning.len();
            let entries = &mut qp.rows[row * size..][..size];
            for (node, sign) in [(node - 1, -1.0), (node, 1.0)] {
                if let Some(first) = columns.of(node) {
                    entries[first - 1 + j] = sign;
                }
            }
            let most = tracking.rate_limit(j) * self.horizon.step;
            let change = plan.input(node)[j] - plan.input(node - 1)[j];
            (qp.row_low[row], qp.row_high[row]) = (-most - change, most - change);
            self.meaning.push(Limit::Rate { channel: j, node });
        }
    }
}

/// The inputs whose rate is limited.
pub fn rate_limited<T: Tracking>(tracking: &T, inputs: usize) -> impl Iterator<Item = usize> {
    (0..inputs).filter(|&j| tracking.rate_limit(j).is_finite())
}

/// The channels that have a limit, with their index.
pub fn limited(channels: &[Channel]) -> impl Iterator<Item = (usize, &Channel)> {
    channels.iter().enumerate().filter(|(_, c)| c.low.is_finite() || c.high.is_finite())
}

/// Adds c (u_{k+1} - u_k)^2 of every input to the lower triangle and gradient.
fn change_cost<T: Tracking>(
    tracking: &T,
    plan: &Plan,
    node: usize,
    columns: Columns,
    qp: &mut QuadraticProgram,
) {
    let size = qp.gradient.len();
    for j in 0..columns.inputs {
        let weight = 2.0 * tracking.change_weight(j);
        let change = plan.input(node + 1)[j] - plan.input(node)[j];
        let variable = |node| columns.of(node).map(|c| c - 1 + j);
        if let Some(b) = variable(node + 1) {
            qp.hessian[b * size + b] += weight;
            qp.gradient[b] += weight * change;
            if let Some(a) = variable(node) {
                qp.hessian[a * size + a] += weight;
                qp.gradient[a] -= weight * change;
                qp.hessian[b * size + a] -= weight;
            }
        }
    }
}
