//! Small deviations from an orbit between phases of its cycle.

use super::cycle::{Cycle, Flow, Point};
use crate::math::{RK4, Scalar, Steps, Workspace};
use crate::plant::{Early, Fault, Plant};
use nalgebra::DMatrix;

/// What deviates from an orbit: height, the coordinates of the [`Section`](super::Section), displacements of the elements,
/// their rates. The crank's element does not: it is no part of a cycle.
#[derive(Clone, Debug)]
pub struct Deviations {
    coordinates: usize,
    /// Elements that come to rest under held commands.
    elements: Vec<usize>,
}

/// Deviations at the end of an interval from those at its begin and from held commands: A s + B u.
#[derive(Clone, Debug)]
pub struct Interval {
    /// A.
    pub a: DMatrix<f64>,
    /// B.
    pub b: DMatrix<f64>,
}

impl Deviations {
    /// Those of the robot of `cycle`.
    pub fn new(cycle: &Cycle) -> Self {
        let commands = cycle.robot().inputs().len().max(1);
        let gains = cycle.robot().rest_gains();
        let moved = gains.chunks_exact(commands).enumerate();
        let elements = moved.filter(|(_, row)| row.iter().any(|g| *g != 0.0)).map(|(i, _)| i).collect();
        Self { coordinates: cycle.section().len(), elements }
    }

    /// Elements whose displacements and rates are among them.
    pub fn moved(&self) -> &[usize] {
        &self.elements
    }

    /// Their number.
    pub fn len(&self) -> usize {
        1 + self.coordinates + 2 * self.elements.len()
    }
    /// Never true.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The numbers of the state `x` that deviate; returns its heading, rad.
    pub fn of<S: Scalar>(&self, cycle: &Cycle, x: &[S], s: &mut [S]) -> S {
        let l = cycle.robot().layout();
        s[0] = x[l.position + 2];
        let heading = cycle.section().coordinates(x, &mut s[1..=self.coordinates]);
        let (n, first) = (cycle.robot().strokes().len(), 1 + self.coordinates);
        for (k, i) in self.elements.iter().enumerate() {
            s[first + k] = x[l.structure + i];
            s[first + self.elements.len() + k] = x[l.structure + n + i];
        }
        heading
    }

    /// The state with heading zero above the origin that has the numbers `s`.
    fn state<S: Scalar>(&self, cycle: &Cycle, s: &[S]) -> Vec<S> {
        let l = cycle.robot().layout();
        let (n, first) = (cycle.robot().strokes().len(), 1 + self.coordinates);
        let mut structure = vec![S::ZERO; 2 * n];
        for (k, i) in self.elements.iter().enumerate() {
            structure[*i] = s[first + k];
            structure[n + i] = s[first + self.elements.len() + k];
        }
        let mut x = vec![S::ZERO; l.len];
        cycle.section().state(&s[1..=self.coordinates], &structure, &mut x);
        x[l.position + 2] = s[0];
        x
    }
}

/// The deviations over each of `count` equal intervals of a cycle of the orbit at `point`; `inputs` are moved, the others
/// held. A cycle must have a multiple of `count` steps.
///
/// Equation: orbit.intervals
///
/// Derivatives of the flow over an interval, in heading axes at either end.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
pub fn intervals(
    cycle: &Cycle,
    point: &Point,
    count: usize,
    inputs: &[usize],
) -> Result<Vec<Interval>, Fault> {
    let deviations = Deviations::new(cycle);
    let (n, m) = (deviations.len(), inputs.len());
    let length = cycle.duration(point.pace) / cycle.steps() as f64;
    let steps = cycle.steps() / count;
    let mut nominal = vec![0.0; n];
    deviations.of(cycle, &cycle.start(point), &mut nominal);
    let mut all = Vec::with_capacity(count);
    for k in 0..count {
        let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, m));
        let mut next = nominal.clone();
        for first in (0..n + m).step_by(Early::LANES) {
            let mut s: Vec<Early> = nominal.iter().map(|v| Early::constant(*v)).collect();
            let mut u: Vec<Early> = point.inputs.iter().map(|v| Early::constant(*v)).collect();
            let last = (n + m).min(first + Early::LANES);
            for column in first..last {
                match column.checked_sub(n) {
                    None => s[column].eps[column - first] = 1.0,
                    Some(i) => u[inputs[i]].eps[column - first] = 1.0,
                }
            }
            let mut x = deviations.state(cycle, &s);
            let clock = Steps {
                start: Early::constant(0.0),
                length: Early::constant(length),
                first: k * steps,
                count: steps,
            };
            let pace = Early::constant(point.pace);
            let mut flow = Flow { robot: cycle.robot(), pace, u: &u, each: |_, _, _: &[Early]| Ok(()) };
            let mut work = Workspace::new(x.len(), RK4.b.len());
            RK4.integrate(&mut flow, clock, &mut x, &mut work)?;
            deviations.of(cycle, &x, &mut s);
            for (i, end) in s.iter().enumerate() {
                next[i] = end.re;
                for column in first..last {
                    match column.checked_sub(n) {
                        None => a[(i, column)] = end.eps[column - first],
                        Some(input) => b[(i, input)] = end.eps[column - first],
                    }
                }
            }
        }
        nominal = next;
        all.push(Interval { a, b });
    }
    Ok(all)
}
