//! Exact linearisation of a plant by forward-mode duals.

use super::{Fault, Plant};
use std::ops::Range;
use wingbeat_math::Dual;

/// A number with the derivatives that one evaluation carries.
pub type Early = Dual<12>;
/// The same for late states.
pub type Late = Dual<16>;

/// f, A = df/dx and B = df/du at one point: the A_i, B_i of the paper's
/// discretised model (section IV). Row-major; reusable without allocation.
#[derive(Clone, Debug)]
pub struct Linearisation {
    /// Rates f(t, x, u), n.
    pub f: Vec<f64>,
    /// df/dx, n x n, row-major.
    pub a: Vec<f64>,
    /// df/du, n x m, row-major.
    pub b: Vec<f64>,
    x: Vec<Early>,
    u: Vec<Early>,
    dx: Vec<Early>,
    late: Vec<Late>,
    late_dx: Vec<Late>,
}

impl Linearisation {
    /// Storage for a plant of `states` states and `inputs` inputs.
    pub fn new(states: usize, inputs: usize) -> Self {
        let zero = Dual::constant(0.0);
        Self {
            f: vec![0.0; states],
            a: vec![0.0; states * states],
            b: vec![0.0; states * inputs],
            x: vec![zero; states],
            u: vec![zero; inputs],
            dx: vec![zero; states],
            late: vec![Dual::constant(0.0); states],
            late_dx: vec![Dual::constant(0.0); states],
        }
    }

    /// Evaluates the plant and its derivatives at (t, x, u).
    pub fn evaluate<P: Plant>(&mut self, plant: &P, t: f64, x: &[f64], u: &[f64]) -> Result<(), Fault> {
        let late = plant.late_states();
        let felt = Felt { early: late, unfelt: plant.unfelt_states() };
        for row in self.a.chunks_exact_mut(x.len()) {
            row[felt.unfelt.clone()].fill(0.0);
        }
        self.by_early(plant, t, x, u, &felt)?;
        self.by_late(plant, t, x.split_at(late), u)
    }

    /// As [`evaluate`](Self::evaluate) for f and B alone; A stays as it was.
    pub fn evaluate_inputs<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        self.by_early(plant, t, x, u, &Felt { early: 0, unfelt: 0..0 })
    }

    /// f and derivatives by the given states and by all inputs.
    fn by_early<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
        states: &Felt,
    ) -> Result<(), Fault> {
        let (n, m, felt) = (x.len(), u.len(), states.count());
        let directions = felt + m;
        for first in (0..directions.max(1)).step_by(Early::LANES) {
            let count = Early::LANES.min(directions - first);
            seed(&mut self.x, x, first, |i| states.direction(i));
            seed(&mut self.u, u, first, |i| Some(felt + i));
            plant.rates_in_early(t, &self.x, &self.u, &mut self.dx)?;
            let block = first..first + count;
            for (run, to) in states.runs() {
                scatter(&self.dx, &block, run, &mut self.a, n, to);
            }
            scatter(&self.dx, &block, felt..directions, &mut self.b, m, 0);
        }
        for (f, rate) in self.f.iter_mut().zip(&self.dx) {
            *f = rate.re;
        }
        Ok(())
    }

    /// Derivatives by the late states.
    fn by_late<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        (early, late): (&[f64], &[f64]),
        u: &[f64],
    ) -> Result<(), Fault> {
        let (n, count) = (self.f.len(), late.len());
        for first in (0..count).step_by(Late::LANES) {
            seed(&mut self.late[..count], late, first, Some);
            plant.rates_in_late(t, early, &self.late[..count], u, &mut self.late_dx)?;
            let width = Late::LANES.min(count - first);
            for (row, rate) in self.a.chunks_exact_mut(n).zip(&self.late_dx) {
                row[early.len() + first..][..width].copy_from_slice(&rate.eps[..width]);
            }
        }
        Ok(())
    }
}

/// The states whose directions the early passes carry.
struct Felt {
    /// How many states are early.
    early: usize,
    /// Those of them that no rate depends on.
    unfelt: Range<usize>,
}

impl Felt {
    /// Number of directions.
    fn count(&self) -> usize {
        self.early - self.unfelt.len()
    }
    /// Directions of states that follow one another, and the first of these states.
    fn runs(&self) -> [(Range<usize>, usize); 2] {
        let before = self.unfelt.start.min(self.count());
        [(0..before, 0), (before..self.count(), self.unfelt.end)]
    }
    /// The direction of a state.
    fn direction(&self, state: usize) -> Option<usize> {
        match state {
            i if i >= self.early || self.unfelt.contains(&i) => None,
            i if i < self.unfelt.start => Some(i),
            i => Some(i - self.unfelt.len()),
        }
    }
}

/// Writes the derivatives of the rates along the directions of a `block` that lie in `run` into the columns from `to` on of a
/// matrix `width` wide.
fn scatter<const N: usize>(
    rates: &[Dual<N>],
    block: &Range<usize>,
    run: Range<usize>,
    matrix: &mut [f64],
    width: usize,
    to: usize,
) {
    let (start, end) = (run.start.max(block.start), run.end.min(block.end));
    if start >= end {
        return;
    }
    for (row, rate) in matrix.chunks_exact_mut(width).zip(rates) {
        let lanes = &rate.eps[start - block.start..end - block.start];
        row[to + start - run.start..][..lanes.len()].copy_from_slice(lanes);
    }
}

/// Seeds those of the `values` whose direction lies in the block that starts at `first`.
fn seed<const N: usize>(
    out: &mut [Dual<N>],
    values: &[f64],
    first: usize,
    direction: impl Fn(usize) -> Option<usize>,
) {
    for (i, (o, v)) in out.iter_mut().zip(values).enumerate() {
        *o = match direction(i).and_then(|direction| direction.checked_sub(first)) {
            Some(lane) if lane < N => Dual::variable(*v, lane),
            _ => Dual::constant(*v),
        };
    }
}
