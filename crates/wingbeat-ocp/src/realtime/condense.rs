//! Elimination of the states: every node's state as a linear function of the
//! inputs, interval by interval.

use super::dense::{LeftFactor, WIDEST, add_product, factor, padded, panels, solve, solve_one};
use super::plan::Horizon;
use crate::plant::Linearisation;
use std::ops::Range;
use wingbeat_math::rows::{axpy, combine, dot};

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
///
/// States whose rates know only themselves and the inputs are driven: they are found first, and what is left to solve for together is
/// the others. Within an interval the others come first, then those driven, both padded with rows of zeros, and their columns in panels
/// of at most [`WIDEST`].
#[derive(Clone, Debug)]
pub struct Elimination {
    horizon: Horizon,
    groups: Groups,
    /// S_k for each node, states x columns.width(k), row-major.
    states: Vec<Vec<f64>>,
    /// The same of the node reached, in groups and panels, with its rates; then room for the next.
    reached: [Vec<f64>; 2],
    next: [Vec<f64>; 2],
    middle: Vec<f64>,
    /// What each interval was solved with: of all of them where states are moved afterwards, else of the last.
    factors: Vec<[GroupFactor; 2]>,
    /// A_{k+1} of one group, and its columns in panels.
    end: Vec<f64>,
    panels: Vec<f64>,
}

/// The states in groups: the others, which surround those driven, and these.
#[derive(Clone, Debug)]
struct Groups {
    states: usize,
    driven: Range<usize>,
}

impl Groups {
    /// Runs of the states of each group.
    fn runs(&self) -> [[Range<usize>; 2]; 2] {
        let Self { states, driven } = self;
        [[0..driven.start, driven.end..*states], [driven.clone(), 0..0]]
    }

    /// Rows of each group.
    fn sizes(&self) -> [usize; 2] {
        self.runs().map(|runs| padded(length(&runs)))
    }
}

/// Number of states in `runs`.
fn length(runs: &[Range<usize>; 2]) -> usize {
    runs[0].len() + runs[1].len()
}

/// The states in `runs`.
fn each(runs: &[Range<usize>; 2]) -> impl Iterator<Item = usize> {
    runs[0].clone().chain(runs[1].clone())
}

/// The derivative of the defects of a group by its states at the end of the interval, factored.
#[derive(Clone, Debug)]
struct GroupFactor {
    matrix: Vec<f64>,
    pivots: Vec<usize>,
}

/// An interval of which the states at the end are asked for.
struct SolvedInterval<'a> {
    h: f64,
    middle: &'a Linearisation,
    end: &'a Linearisation,
    defect: &'a [f64],
    /// Columns of the inputs at its begin and end.
    inputs: [Option<usize>; 2],
    factors: &'a [GroupFactor; 2],
    /// Whether another interval starts from its end.
    goes_on: bool,
}

impl Elimination {
    /// Storage for a horizon that keeps what `kept` intervals were solved with; rates of states that are `driven` know only them and the
    /// inputs.
    pub fn new(horizon: Horizon, kept: usize, driven: Range<usize>) -> Self {
        let n = horizon.states;
        let groups = Groups { states: n, driven };
        let sizes = groups.sizes();
        let rows = sizes[0] + sizes[1];
        let width = |node| Columns { inputs: horizon.inputs, first: 0 }.width(node);
        let block = || vec![0.0; rows * width(horizon.intervals)];
        let factors = sizes.map(|n| GroupFactor { matrix: vec![0.0; n * n], pivots: vec![0; n] });
        let largest = sizes[0].max(sizes[1]);
        Self {
            horizon,
            states: (0..=horizon.intervals).map(|k| vec![0.0; n * width(k)]).collect(),
            reached: [block(), block()],
            next: [block(), block()],
            middle: vec![0.0; (rows * width(horizon.intervals)).max(4 * rows)],
            factors: vec![factors; kept],
            end: vec![0.0; largest * largest],
            panels: vec![0.0; largest * largest],
            groups,
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
        let [x, f] = &mut self.reached;
        let (width, [others, driven]) = (columns.width(0), self.groups.sizes());
        x[..(others + driven) * width].fill(0.0);
        f[..(others + driven) * width].fill(0.0);
        for (runs, first) in self.groups.runs().iter().zip([0, others]) {
            for (panel, width) in panel_widths(width) {
                let rows = &mut f[self.groups.place(panel)..][first * width..];
                add_inputs(rows, (panel, width), columns.of(0), 1.0, (&node.b, columns.inputs), runs);
            }
        }
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
        let slot = k % self.factors.len();
        for group in 0..2 {
            self.end_matrix(slot, group, &middle.a, &end.a);
            let GroupFactor { matrix, pivots } = &mut self.factors[slot][group];
            if !factor(matrix, pivots) {
                return false;
            }
        }
        let interval = SolvedInterval {
            h: self.horizon.step,
            middle,
            end,
            defect,
            inputs: [columns.of(k), columns.of(k + 1)],
            factors: &self.factors[slot],
            goes_on: k + 1 < self.horizon.intervals,
        };
        let [w0, w1] = [k, k + 1].map(|node| columns.width(node));
        let rows = self.groups.sizes()[0] + self.groups.sizes()[1];
        for (panel, width) in panel_widths(w1) {
            let (at, before) = (self.groups.place(panel), w0.saturating_sub(panel).min(WIDEST));
            let [x0, f0] = self.reached.each_ref().map(|of| &of[at..][..rows * before]);
            let [x1, f1] = self.next.each_mut().map(|of| &mut of[at..][..rows * width]);
            let known = &mut self.middle[..rows * width];
            carry(interval.h, (x0, f0, before), (x1, known, width));
            let states = (&mut self.states[k + 1][..], w1);
            self.groups.solve(&interval, (panel, width), (x1, f1, known), states);
        }
        std::mem::swap(&mut self.reached, &mut self.next);
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
        let (row, runs) = (padded(n), self.groups.runs());
        let by = |a: &[f64], i: usize, x: &[f64]| dot(&a[i * n..][..n], &x[..n]);
        for k in 0..=intervals {
            let (done, rest) = moved.split_at_mut(k * row);
            let here = &mut rest[..row];
            if k > 0 {
                let (before, interval) = (&done[(k - 1) * row..][..row], k - 1);
                let (middle, end) = (&middles[interval].a, &nodes[k].a);
                let (rates, known) = self.middle[..2 * row].split_at_mut(row);
                for i in 0..n {
                    rates[i] = by(&nodes[interval].a, i, before);
                }
                carry(h, (before, rates, row), (here, known, row));
                for group in [1, 0] {
                    let GroupFactor { matrix, pivots } = &self.factors[interval][group];
                    let solved = &mut self.end[..pivots.len()];
                    solved.fill(0.0);
                    for (x, i) in solved.iter_mut().zip(each(&runs[group])) {
                        *x = here[i] + 2.0 * h / 3.0 * by(middle, i, known);
                    }
                    solve_one(matrix, pivots, solved);
                    // What the others know of those driven.
                    rates.fill(0.0);
                    for (x, i) in solved.iter().zip(each(&runs[group])) {
                        (here[i], rates[i]) = (*x, *x);
                    }
                    if group == 1 {
                        for i in each(&runs[1]) {
                            known[i] += 0.5 * here[i] - h / 8.0 * by(end, i, rates);
                        }
                        for i in each(&runs[0]) {
                            let rate = by(end, i, rates);
                            here[i] += h / 6.0 * rate;
                            known[i] -= h / 8.0 * rate;
                        }
                    }
                }
            }
            let width = columns.width(k);
            for i in 0..n {
                self.states[k][i * width] += here[i];
            }
        }
    }

    /// Derivative of the defect of a group of states by them at the end:
    /// I - h/6 A_{k+1} - 2h/3 A_c (I/2 - h/8 A_{k+1}).
    #[inline(never)]
    fn end_matrix(&mut self, slot: usize, group: usize, middle: &[f64], end: &[f64]) {
        let Horizon { states: n, step: h, .. } = self.horizon;
        let (groups, matrix) = (self.groups.runs(), &mut self.factors[slot][group].matrix);
        let runs = &groups[group];
        let size = self.groups.sizes()[group];
        matrix[length(runs) * size..].fill(0.0);
        for (place, i) in each(runs).enumerate() {
            let (row, of_end) = (&mut matrix[place * size..][..size], &mut self.end[place * size..][..size]);
            let mut first = 0;
            for run in runs {
                let columns = first..first + run.len();
                let (ac, a1) = (&middle[i * n..][run.clone()], &end[i * n..][run.clone()]);
                let (row, of_end) = (&mut row[columns.clone()], &mut of_end[columns]);
                for j in 0..row.len().min(ac.len()).min(a1.len()).min(of_end.len()) {
                    row[j] = -h / 6.0 * a1[j] - h / 3.0 * ac[j];
                    of_end[j] = a1[j];
                }
                first += run.len();
            }
            row[first..].fill(0.0);
            of_end[first..].fill(0.0);
        }
        for i in 0..size {
            matrix[i * size + i] += 1.0;
        }
        let factors = LeftFactor { scale: h * h / 12.0, a: middle, stride: n, rows: runs.clone() };
        for (first, width) in panels(size) {
            let panel = if width == size {
                &self.end[..]
            } else {
                for (to, from) in self.panels.chunks_exact_mut(width).zip(self.end.chunks_exact(size)) {
                    to.copy_from_slice(&from[first..][..width]);
                }
                &self.panels[..]
            };
            let (one, other) = panel[..length(runs) * width].split_at(runs[0].len() * width);
            let parts = [(runs[0].start, one), (runs[1].start, other)];
            add_product(&mut matrix[first..], size, &factors, &parts, width);
        }
    }
}

impl Groups {
    /// Where the panel that begins at this column has its rows.
    fn place(&self, panel: usize) -> usize {
        panel * (self.sizes()[0] + self.sizes()[1])
    }

    /// Solves for the states at the end of an interval in the columns of a panel. `x1` and `known` hold what [`carry`] knows; `f1` gets the
    /// rates there, `states` (and their width) the states in their own order.
    fn solve(
        &self,
        interval: &SolvedInterval,
        (panel, width): (usize, usize),
        (x1, f1, known): (&mut [f64], &mut [f64], &mut [f64]),
        (states, w1): (&mut [f64], usize),
    ) {
        let SolvedInterval { h, middle, end, defect, inputs: [old, new], factors, goes_on } = *interval;
        let (runs, [others, driven], n) = (self.runs(), self.sizes(), self.states);
        let m = middle.b.len() / n;
        let begins = [0, others * width];
        f1.chunks_exact_mut(width).for_each(|row| row.fill(0.0));
        for (runs, first) in runs.iter().zip(begins) {
            if panel == 0 {
                for (row, i) in x1[first..].chunks_exact_mut(width).zip(each(runs)) {
                    row[0] -= defect[i];
                }
            }
            let panel = (panel, width);
            add_inputs(&mut f1[first..], panel, new, 1.0, (&end.b, m), runs);
            add_inputs(&mut x1[first..], panel, new, h / 3.0, (&middle.b, m), runs);
            add_inputs(&mut x1[first..], panel, old, h / 3.0, (&middle.b, m), runs);
        }
        let [(x1, x_driven), (f1, f_driven), (known, known_driven)] =
            [x1, f1, known].map(|rows| rows.split_at_mut(others * width));
        let by = |scale: f64, a, group: usize| LeftFactor { scale, a, stride: n, rows: runs[group].clone() };
        if driven > 0 {
            let (at, count) = (runs[1][0].start, runs[1][0].len() * width);
            add(x_driven, h / 6.0, f_driven);
            add(known_driven, -h / 8.0, f_driven);
            let of_middle = by(2.0 * h / 3.0, &middle.a, 1);
            add_product(x_driven, width, &of_middle, &[(at, &known_driven[..count])], width);
            let GroupFactor { matrix, pivots } = &factors[1];
            solve(matrix, pivots, x_driven, width);
            // Of the rates at the end those by the inputs are taken back, and all of them given.
            add(known_driven, h / 8.0, f_driven);
            add_product(f_driven, width, &by(1.0, &end.a, 1), &[(at, &x_driven[..count])], width);
            add(known_driven, 0.5, x_driven);
            add(known_driven, -h / 8.0, f_driven);
            add_product(f1, width, &by(1.0, &end.a, 0), &[(at, &x_driven[..count])], width);
        }
        add(x1, h / 6.0, f1);
        add(known, -h / 8.0, f1);
        let split = runs[0][0].len() * width;
        let count = length(&runs[0]) * width;
        let (one, other) = known[..count].split_at(split);
        let of_driven = (runs[1][0].start, &known_driven[..runs[1][0].len() * width]);
        let parts = [(0, one), (runs[0][1].start, other), of_driven];
        add_product(x1, width, &by(2.0 * h / 3.0, &middle.a, 0), &parts, width);
        let GroupFactor { matrix, pivots } = &factors[0];
        solve(matrix, pivots, x1, width);
        if goes_on {
            let (one, other) = x1[..count].split_at(split);
            add_product(f1, width, &by(1.0, &end.a, 0), &[(0, one), (runs[0][1].start, other)], width);
        }
        for (runs, rows) in runs.iter().zip([x1, x_driven]) {
            for (row, i) in rows.chunks_exact(width).zip(each(runs)) {
                states[i * w1 + panel..][..width].copy_from_slice(row);
            }
        }
    }
}

/// First column and width of each panel of `width` columns: as wide as possible, so that a panel stays where it is as columns are added.
fn panel_widths(width: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..width).step_by(WIDEST).map(move |first| (first, WIDEST.min(width - first)))
}

/// What an interval of `h` s knows of its end from the states and rates at its begin, and the state in its middle: dx_k + h/6 df_k and
/// dx_k/2 + h/8 df_k, in the columns that the begin has.
fn carry(h: f64, (x0, f0, w0): (&[f64], &[f64], usize), (end, middle, w1): (&mut [f64], &mut [f64], usize)) {
    for i in 0..end.len() / w1 {
        let (right, known) = (&mut end[i * w1..][..w1], &mut middle[i * w1..][..w1]);
        let of_begin = [&x0[i * w0..][..w0], &f0[i * w0..][..w0]];
        combine(right, [1.0, h / 6.0], of_begin);
        combine(known, [0.5, h / 8.0], of_begin);
        right[w0..].fill(0.0);
        known[w0..].fill(0.0);
    }
}

/// y += a x
#[inline(never)]
fn add(y: &mut [f64], a: f64, x: &[f64]) {
    axpy(y, a, x);
}

/// Adds scale B, of the states in `runs`, to the columns of one node's inputs, from `first` on, as far as they lie in the panel (its first
/// column and width) whose rows are given.
fn add_inputs(
    rows: &mut [f64],
    (panel, width): (usize, usize),
    first: Option<usize>,
    scale: f64,
    (b, inputs): (&[f64], usize),
    runs: &[Range<usize>; 2],
) {
    let Some(first) = first else { return };
    let columns = first.max(panel)..(first + inputs).min(panel + width);
    if columns.is_empty() {
        return;
    }
    for (row, i) in rows.chunks_exact_mut(width).zip(each(runs)) {
        let b = &b[i * inputs..][columns.start - first..columns.end - first];
        axpy(&mut row[columns.start - panel..][..b.len()], scale, b);
    }
}
