//! Exact linearisation of a plant by forward-mode duals.

use super::{Fault, Plant};
use crate::math::Dual;
use std::ops::Range;

/// Directions carried by one dual evaluation.
const LANES: usize = 12;
/// The same for late states.
const LATE_LANES: usize = 16;

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
    x: Vec<Dual<LANES>>,
    u: Vec<Dual<LANES>>,
    dx: Vec<Dual<LANES>>,
    late: Vec<Dual<LATE_LANES>>,
    late_dx: Vec<Dual<LATE_LANES>>,
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
        self.by_early(plant, t, x, u, 0..late)?;
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
        self.by_early(plant, t, x, u, 0..0)
    }

    /// f and derivatives by the given states and by all inputs.
    fn by_early<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
        states: Range<usize>,
    ) -> Result<(), Fault> {
        let (n, m) = (x.len(), u.len());
        let directions: usize = states.len() + m;
        for first in (0..directions.max(1)).step_by(LANES) {
            let count = LANES.min(directions - first);
            seed(&mut self.x, x, states.clone(), first);
            seed(&mut self.u, u, 0..m, first.wrapping_sub(states.len()));
            plant.rates(Dual::from(t), &self.x, &self.u, &mut self.dx)?;
            for (i, rate) in self.dx.iter().enumerate() {
                for (direction, slope) in (first..).zip(&rate.eps[..count]) {
                    match direction.checked_sub(states.len()) {
                        None => self.a[i * n + states.start + direction] = *slope,
                        Some(input) => self.b[i * m + input] = *slope,
                    }
                }
            }
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
        for first in (0..count).step_by(LATE_LANES) {
            seed(&mut self.late[..count], late, 0..count, first);
            plant.rates_by_late(t, early, &self.late[..count], u, &mut self.late_dx)?;
            let width = LATE_LANES.min(count - first);
            for (row, rate) in self.a.chunks_exact_mut(n).zip(&self.late_dx) {
                row[early.len() + first..][..width].copy_from_slice(&rate.eps[..width]);
            }
        }
        Ok(())
    }
}

/// Seeds the `variables` among `values` that lie in the block of directions starting at
/// `first`, counted from the first variable.
fn seed<const N: usize>(out: &mut [Dual<N>], values: &[f64], variables: Range<usize>, first: usize) {
    for (i, (o, v)) in out.iter_mut().zip(values).enumerate() {
        *o = match i.wrapping_sub(variables.start).wrapping_sub(first) {
            direction if direction < N && variables.contains(&i) => Dual::variable(*v, direction),
            _ => Dual::constant(*v),
        };
    }
}
