//! Exact linearisation of a plant by forward-mode duals.

use super::{Fault, Plant};
use crate::math::{Dual, Scalar};

/// Directions carried by one dual evaluation.
const LANES: usize = 8;

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
        }
    }

    /// Evaluates the plant and its derivatives at (t, x, u).
    pub fn evaluate<P: Plant>(&mut self, plant: &P, t: f64, x: &[f64], u: &[f64]) -> Result<(), Fault> {
        self.differentiate(plant, t, x, u, 0)
    }

    /// As [`evaluate`](Self::evaluate) for f and B alone; A stays as it was.
    pub fn evaluate_inputs<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
    ) -> Result<(), Fault> {
        self.differentiate(plant, t, x, u, x.len())
    }

    /// Derivatives by the variables [x, u] from index `start` on.
    fn differentiate<P: Plant>(
        &mut self,
        plant: &P,
        t: f64,
        x: &[f64],
        u: &[f64],
        start: usize,
    ) -> Result<(), Fault> {
        let (n, m) = (x.len(), u.len());
        for first in (start..n + m).step_by(LANES) {
            let last = (first + LANES).min(n + m);
            seed(&mut self.x, x, 0, first);
            seed(&mut self.u, u, n, first);
            plant.rates(Dual::from(t), &self.x, &self.u, &mut self.dx)?;
            for (i, rate) in self.dx.iter().enumerate() {
                for j in first..last {
                    let slope = rate.eps[j - first];
                    if j < n {
                        self.a[i * n + j] = slope;
                    } else {
                        self.b[i * m + j - n] = slope;
                    }
                }
            }
        }
        for (f, rate) in self.f.iter_mut().zip(&self.dx) {
            *f = rate.re.value();
        }
        Ok(())
    }
}

/// Seeds the variables whose global index (offset + i) lies in the block of
/// directions starting at `first`.
fn seed(out: &mut [Dual<LANES>], values: &[f64], offset: usize, first: usize) {
    for (i, (o, v)) in out.iter_mut().zip(values).enumerate() {
        *o = match (offset + i).checked_sub(first) {
            Some(direction) if direction < LANES => Dual::variable(*v, direction),
            _ => Dual::constant(*v),
        };
    }
}
