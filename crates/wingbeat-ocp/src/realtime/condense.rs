//! Elimination of the states: every node's state as a linear function of the
//! inputs, interval by interval.

use super::dense::{
    PACK, Terms, factor, multiply_add, multiply_add_one, packs, packs_mut, padded, solve, solve_one,
};
use super::plan::Horizon;
use crate::plant::Linearisation;

/// Which column of a sensitivity belongs to which input. Column 0 is the
/// constant; the inputs of the nodes follow in order, without node 0 where its
/// input is held.
#[derive(Clone, Copy, Debug)]
pub struct Columns {
    /// Inputs per node.
    pub inputs: usize,
    /// First node whose input is free: 0 or 1.
    pub first: usize,
}

impl Columns {
    /// First column of the inputs of `node`, if they are free.
    pub fn of(&self, node: usize) -> Option<usize> {
        node.checked_sub(self.first).map(|k| 1 + k * self.inputs)
    }

    /// Columns up to and with the inputs of `node`.
    pub fn through(&self, node: usize) -> usize {
        1 + (node + 1 - self.first) * self.inputs
    }

    /// Length of a row that holds these columns, padded with zeros.
    pub fn width(&self, node: usize) -> usize {
        padded(self.through(node))
    }
}

/// Sensitivities of the states to the inputs: dx_k = S_k [1; du], with the
/// rates df_k = A_k dx_k + B_k du_k beside them, but at the last node.
#[derive(Clone, Debug)]
pub struct Elimination {
    horizon: Horizon,
    /// S_k for each node, states x columns.width(k), row-major.
    states: Vec<Vec<f64>>,
    /// df_k for each node, the same shape.
    rates: Vec<Vec<f64>>,
    middle: Vec<f64>,
    /// What each interval was solved with: of all of them where states are moved afterwards, else of the last.
    factors: Vec<IntervalFactor>,
    /// A_{k+1} with padded rows.
    end: Vec<f64>,
    terms: Terms,
}

/// The derivative of a defect by the state at the end of its interval, factored.
#[derive(Clone, Debug)]
struct IntervalFactor {
    matrix: Vec<f64>,
    pivots: Vec<usize>,
}

impl Elimination {
    /// Storage for a horizon that keeps what `kept` intervals were solved with.
    pub fn new(horizon: Horizon, kept: usize) -> Self {
        let n = horizon.states;
        let width = |node| Columns { inputs: horizon.inputs, first: 0 }.width(node);
        let blocks = || (0..=horizon.intervals).map(|k| vec![0.0; n * width(k)]).collect();
        Self {
            horizon,
            states: blocks(),
            rates: blocks(),
            middle: vec![0.0; (n * width(horizon.intervals)).max(2 * padded(n))],
            factors: vec![IntervalFactor { matrix: vec![0.0; n * padded(n)], pivots: vec![0; n] }; kept],
            end: vec![0.0; n * padded(n)],
            terms: Terms::new(n),
        }
    }

    /// Has intervals of `step` s.
    pub fn cut(&mut self, step: f64) {
        self.horizon.step = step;
    }

    /// S_k, by the inputs, in the unit of that state over those of the inputs: row i holds the sensitivity of state i of
    /// `node`.
    pub fn state(&self, node: usize, columns: Columns) -> &[f64] {
        &self.states[node][..self.horizon.states * columns.width(node)]
    }

    /// Starts at a given initial state: dx_0 = 0, df_0 = B_0 du_0.
    pub fn start(&mut self, columns: Columns, node: &Linearisation) {
        self.states[0].fill(0.0);
        self.rates[0].fill(0.0);
        add_inputs(&mut self.rates[0], columns.width(0), columns.of(0), 1.0, &node.b, columns.inputs);
    }

    /// Eliminates node k+1 from the linearised Hermite-Simpson defect (in the units of the states) of the interval `k`, with
    /// the linearisations at its middle and end:
    ///
    /// dx_{k+1} - dx_k - h/6 (df_k + 4 df_c + df_{k+1}) + d = 0,
    /// df_c = A_c ((dx_k + dx_{k+1})/2 + h/8 (df_k - df_{k+1})) + B_c (du_k + du_{k+1})/2.
    ///
    /// False if the interval is singular.
    ///
    /// Equation: ocp.linearised_defect
    /// `dx1 - dx0 - h/6 (df0 + 4 dfc + df1) + d = 0`
    /// Source: derivative of ocp.defect.
    /// Test: `an_unlimited_linear_problem_has_the_riccati_solution`.
    pub fn advance(
        &mut self,
        k: usize,
        columns: Columns,
        middle: &Linearisation,
        end: &Linearisation,
        defect: &[f64],
    ) -> bool {
        let Horizon { states: n, inputs: m, step: h, .. } = self.horizon;
        let (w0, w1) = (columns.width(k), columns.width(k + 1));
        let stride = padded(n);
        let slot = k % self.factors.len();
        self.end_matrix(slot, &middle.a, &end.a);
        let IntervalFactor { matrix, pivots } = &mut self.factors[slot];
        if !factor(matrix, n, stride, pivots) {
            return false;
        }
        let known = &mut self.middle[..n * w1];
        let (done, rest) = self.states.split_at_mut(k + 1);
        let (x0, f0) = (&done[k][..n * w0], &self.rates[k][..n * w0]);
        let x1 = &mut rest[0][..n * w1];
        carry(h, (x0, f0, w0), (x1, known, w1));
        for i in 0..n {
            x1[i * w1] -= defect[i];
        }
        let (old, new) = (columns.of(k), columns.of(k + 1));
        add_inputs(known, w1, new, -h / 8.0, &end.b, m);
        add_inputs(x1, w1, new, h / 6.0, &end.b, m);
        add_inputs(x1, w1, new, h / 3.0, &middle.b, m);
        add_inputs(x1, w1, old, h / 3.0, &middle.b, m);
        multiply_add(x1, 2.0 * h / 3.0, &middle.a, known, w1, &mut self.terms);
        solve(matrix, stride, pivots, x1, w1, &mut self.terms);
        if k + 1 == self.horizon.intervals {
            // No interval starts from there.
            return true;
        }
        let f1 = &mut self.rates[k + 1][..n * w1];
        f1.fill(0.0);
        add_inputs(f1, w1, new, 1.0, &end.b, m);
        multiply_add(f1, 1.0, &end.a, x1, w1, &mut self.terms);
        true
    }

    /// Moves the states of all nodes by what follows, at inputs unchanged, from the move of the first, with the linearisations at the
    /// `nodes` and in the `middles` of all intervals. `moved` has a padded row for each node, in the units
    /// of the states: the first node's is given, the others' are written.
    ///
    /// Equation: ocp.moved_start
    /// `dx1 - dx0 - h/6 (A0 dx0 + 4 dfc + A1 dx1) = 0, dfc = Ac ((dx0 + dx1)/2 + h/8 (A0 dx0 - A1 dx1)), from dx = x measured - x predicted`
    /// Source: initial value embedding, Diehl, Bock & Schloeder 2005, A real-time iteration scheme for nonlinear optimization in optimal
    /// feedback control, SIAM J. Control Optim. 43.
    /// Test: `an_answer_from_where_it_was_prepared_is_the_whole_update`.
    pub fn move_start(
        &mut self,
        columns: Columns,
        nodes: &[Linearisation],
        middles: &[Linearisation],
        moved: &mut [f64],
    ) {
        let Horizon { states: n, intervals, step: h, .. } = self.horizon;
        let row = padded(n);
        for k in 0..=intervals {
            let (done, rest) = moved.split_at_mut(k * row);
            let here = &mut rest[..row];
            if k > 0 {
                let (before, interval) = (&done[(k - 1) * row..], k - 1);
                let (rates, known) = self.middle[..2 * row].split_at_mut(row);
                rates.fill(0.0);
                multiply_add_one(&mut rates[..n], 1.0, &nodes[interval].a, &before[..n]);
                carry(h, (before, rates, row), (here, known, row));
                multiply_add_one(&mut here[..n], 2.0 * h / 3.0, &middles[interval].a, &known[..n]);
                let IntervalFactor { matrix, pivots } = &self.factors[interval];
                solve_one(matrix, row, pivots, &mut here[..n]);
            }
            let width = columns.width(k);
            for i in 0..n {
                self.states[k][i * width] += here[i];
            }
        }
    }

    /// Derivative of the defect by the end state:
    /// I - h/6 A_{k+1} - 2h/3 A_c (I/2 - h/8 A_{k+1}).
    fn end_matrix(&mut self, slot: usize, middle: &[f64], end: &[f64]) {
        let Horizon { states: n, step: h, .. } = self.horizon;
        let stride = padded(n);
        let matrix = &mut self.factors[slot].matrix;
        for i in 0..n {
            let row = &mut matrix[i * stride..][..n];
            let (ac, a1) = (&middle[i * n..][..n], &end[i * n..][..n]);
            for j in 0..n {
                row[j] = -h / 6.0 * a1[j] - h / 3.0 * ac[j];
            }
            row[i] += 1.0;
            self.end[i * stride..][..n].copy_from_slice(&end[i * n..][..n]);
        }
        multiply_add(matrix, h * h / 12.0, middle, &self.end, stride, &mut self.terms);
    }
}

/// What an interval of `h` s knows of its end from the states and rates at its begin, and the state in its middle: dx_k + h/6 df_k and
/// dx_k/2 + h/8 df_k, in the columns that the begin has.
fn carry(h: f64, (x0, f0, w0): (&[f64], &[f64], usize), (end, middle, w1): (&mut [f64], &mut [f64], usize)) {
    for i in 0..end.len() / w1 {
        let (right, known) = (&mut end[i * w1..][..w1], &mut middle[i * w1..][..w1]);
        let (x, f) = (packs(&x0[i * w0..][..w0]), packs(&f0[i * w0..][..w0]));
        let (to, also) = (packs_mut(right), packs_mut(known));
        for c in 0..x.len() {
            for l in 0..PACK {
                to[c][l] = x[c][l] + h / 6.0 * f[c][l];
                also[c][l] = 0.5 * x[c][l] + h / 8.0 * f[c][l];
            }
        }
        right[w0..].fill(0.0);
        known[w0..].fill(0.0);
    }
}

/// Adds scale B to the columns of one node's inputs, from `first` on.
fn add_inputs(block: &mut [f64], width: usize, first: Option<usize>, scale: f64, b: &[f64], inputs: usize) {
    let Some(first) = first else { return };
    for (row, b) in block.chunks_exact_mut(width).zip(b.chunks_exact(inputs)) {
        let (rows, row_rest) = row[first..][..inputs].as_chunks_mut::<PACK>();
        let (bs, b_rest) = b.as_chunks::<PACK>();
        for c in 0..bs.len() {
            for l in 0..PACK {
                rows[c][l] += scale * bs[c][l];
            }
        }
        for c in 0..b_rest.len() {
            row_rest[c] += scale * b_rest[c];
        }
    }
}
