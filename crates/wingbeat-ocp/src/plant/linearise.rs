//! Exact linearisation of a plant by forward-mode duals.

use super::{Fault, Known, Plant};
use arrayvec::ArrayVec;
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
    /// Rates f(t, x, u), n, in the units of the states per s.
    pub f: Vec<f64>,
    /// df/dx, n x n, row-major, in the unit of the row's state over that of the column's, per s.
    pub a: Vec<f64>,
    /// df/du, n x m, row-major, in the unit of the row's state over that of the column's input, per s.
    pub b: Vec<f64>,
    x: Vec<Early>,
    u: Vec<Early>,
    dx: Vec<Early>,
    late: Vec<Late>,
    late_dx: Vec<Late>,
    known: Known,
}

/// States that follow one another.
type Runs = ArrayVec<Range<usize>, 8>;

/// The states whose directions the early passes carry; after them come inputs.
#[derive(Default)]
struct EarlyDirections {
    /// In the order of the directions.
    runs: Runs,
    /// How many of them are by states that move places.
    placing: usize,
    /// How many are by inputs: all or none.
    inputs: usize,
    /// Whether the plant knows the accelerations and the mass matrix on them.
    about: bool,
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
            known: Known::new(states, inputs),
        }
    }

    /// Evaluates the plant and its derivatives at (t, x, u).
    pub fn evaluate<P: Plant>(&mut self, plant: &P, t: f64, x: &[f64], u: &[f64]) -> Result<(), Fault> {
        let unfelt = plant.unfelt_states();
        for row in self.a.chunks_exact_mut(x.len()) {
            row[unfelt.clone()].fill(0.0);
        }
        let known = self.by_known(plant, t, x, u, true)?;
        let of = EarlyDirections::of(plant, known);
        self.by_early(
            plant,
            t,
            x,
            u,
            &EarlyDirections { about: known && !self.known.mass.is_empty(), ..of },
        )?;
        if known && !plant.derived_states().is_empty() {
            plant.derive(x, &self.f, &self.known, &mut self.a);
        }
        let (early, late) = x.split_at(plant.late_states());
        if self.known.late.is_empty() {
            return self.by_late(plant, t, (early, late), u);
        }
        let known = self.known.late.chunks_exact(late.len());
        for (row, known) in self.a.chunks_exact_mut(x.len()).zip(known) {
            row[early.len()..].copy_from_slice(known);
        }
        Ok(())
    }

    /// As [`evaluate`](Self::evaluate) for f and B alone; A stays as it was.
    pub fn evaluate_inputs<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        if self.by_known(plant, t, x, u, false)? {
            return Ok(());
        }
        self.by_early(plant, t, x, u, &EarlyDirections { inputs: u.len(), ..EarlyDirections::default() })
    }

    /// f and B, where the plant knows them; says whether it does.
    fn by_known<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
        late: bool,
    ) -> Result<bool, Fault> {
        self.known.wants_late = late;
        self.known.late.clear();
        self.known.left_out.clear();
        let known = plant.known(t, x, u, &mut self.f, &mut self.known)?;
        if known {
            self.b.copy_from_slice(&self.known.inputs);
        }
        Ok(known)
    }

    /// f and derivatives by the given states and inputs. The first passes take the states that move places, and as many others
    /// as there is room for.
    fn by_early<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
        of: &EarlyDirections,
    ) -> Result<(), Fault> {
        let (n, m, states) = (x.len(), u.len(), of.states());
        let directions = states + of.inputs;
        let late = plant.late_states();
        for (value, late) in self.x[late..].iter_mut().zip(&x[late..]) {
            *value = Early::constant(*late);
        }
        for first in (0..directions.max(usize::from(!of.about))).step_by(Early::LANES) {
            let count = Early::LANES.min(directions - first);
            seed(&mut self.x[..late], x, (first, 0), &of.runs);
            seed(&mut self.u, u, (first, states), std::slice::from_ref(&(0..of.inputs)));
            let places = first < of.placing;
            if of.about {
                let (early, after) = self.x.split_at(late);
                let (dx, late_dx) = self.dx.split_at_mut(late);
                plant.rates_about(&self.known, places, (t, [early, after], &self.u), [dx, late_dx])?;
            } else if places {
                plant.rates_in_early(t, &self.x, &self.u, &mut self.dx)?;
            } else {
                plant.rates_in_moving(t, &self.x, &self.u, &mut self.dx)?;
            }
            let (block, mut before) = (first..first + count, 0);
            for run in &of.runs {
                scatter(&self.dx, &block, before..before + run.len(), &mut self.a, n, run.start);
                before += run.len();
            }
            if of.inputs > 0 {
                scatter(&self.dx, &block, states..directions, &mut self.b, m, 0);
            }
        }
        if !of.about {
            for (f, rate) in self.f.iter_mut().zip(&self.dx) {
                *f = rate.re;
            }
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
            seed(&mut self.late[..count], late, (first, 0), std::slice::from_ref(&(0..count)));
            plant.rates_in_late(t, early, &self.late[..count], u, &mut self.late_dx)?;
            let width = Late::LANES.min(count - first);
            for (row, rate) in self.a.chunks_exact_mut(n).zip(&self.late_dx) {
                row[early.len() + first..][..width].copy_from_slice(&rate.eps[..width]);
            }
        }
        Ok(())
    }
}

impl EarlyDirections {
    /// Those by all early states of `plant` that are felt, and by inputs; where some derivatives are `known`, only by those states that
    /// they do not give.
    fn of<P: Plant>(plant: &P, known: bool) -> Self {
        let (late, unfelt, placing) = (plant.late_states(), plant.unfelt_states(), plant.placing_states());
        let derived = if known { plant.derived_states() } else { 0..0 };
        let (mut others, mut start) = (Runs::new(), 0);
        for taken in [unfelt, derived, placing[0].clone(), placing[1].clone(), late..late] {
            others.push(start..taken.start.max(start));
            start = start.max(taken.end);
        }
        let count = placing.iter().map(Range::len).sum();
        let inputs = if known { 0 } else { plant.inputs().len() };
        Self { runs: placing.into_iter().chain(others).collect(), placing: count, inputs, about: false }
    }
    /// Number of states among the directions.
    fn states(&self) -> usize {
        self.runs.iter().map(Range::len).sum()
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
    let (lane, to) = (start - block.start, to + start - run.start);
    for i in 0..rates.len() {
        let row = &mut matrix[i * width + to..][..end - start];
        copy_few(row, &rates[i].eps[lane..][..end - start]);
    }
}

/// Copies so few numbers that a call would take longer.
#[inline(always)]
#[expect(clippy::manual_memcpy, reason = "what it asks for is that call")]
fn copy_few(to: &mut [f64], from: &[f64]) {
    let (blocks, rest) = to.as_chunks_mut::<4>();
    let (from, from_rest) = from.as_chunks::<4>();
    for i in 0..blocks.len().min(from.len()) {
        blocks[i] = from[i];
    }
    match (rest, from_rest) {
        ([to], [from]) => *to = *from,
        ([a, b], [x, y]) => (*a, *b) = (*x, *y),
        ([a, b, c], [x, y, z]) => (*a, *b, *c) = (*x, *y, *z),
        _ => {}
    }
}

/// Seeds the `values`, of which those in `runs` are the directions from `direction` on in their order, for the block of directions that
/// starts at `first`.
fn seed<const N: usize>(
    out: &mut [Dual<N>],
    values: &[f64],
    (first, mut direction): (usize, usize),
    runs: &[Range<usize>],
) {
    for i in 0..out.len() {
        out[i] = Dual::constant(values[i]);
    }
    for run in runs {
        let block = first.max(direction)..(first + N).min(direction + run.len());
        for lane in block {
            out[run.start + lane - direction].eps[lane - first] = 1.0;
        }
        direction += run.len();
    }
}
