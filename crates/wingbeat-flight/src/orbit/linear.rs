//! Small deviations from an orbit between phases of its cycle.

use super::cycle::{Cycle, Flow, Point};
use super::section::Section;
use nalgebra::DMatrix;
use std::ops::Range;
use wingbeat_math::{RK4, Scalar, Steps, Workspace};
use wingbeat_ocp::plant::{Early, Fault, Plant};

/// Numbers of place and heading over the ground.
const GROUND: usize = 3;

/// What deviates from an orbit: height, the coordinates of the [`Section`], displacements of the elements,
/// their rates. The crank's element does not: it is no part of a cycle.
#[derive(Clone, Debug)]
pub struct Deviations {
    section: Section,
    /// Elements of the structure.
    structure: usize,
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
    /// Where the orbit is at its end over the ground, in heading axes at its begin: along x, y, m, and heading, rad.
    pub ground: [f64; 3],
    /// As A for that.
    pub ground_a: DMatrix<f64>,
    /// As B for that.
    pub ground_b: DMatrix<f64>,
}

impl Deviations {
    /// Place of the height among them.
    pub const HEIGHT: usize = 0;
    /// Places of the velocity in heading axes.
    pub const VELOCITY: Range<usize> = behind_height(Section::VELOCITY);
    /// Place of the roll.
    pub const ROLL: usize = 1 + Section::ROLL;
    /// Place of the pitch.
    pub const PITCH: usize = 1 + Section::PITCH;
    /// Places of the angular rate.
    pub const RATE: Range<usize> = behind_height(Section::RATE);
    /// Number of those of the body, which are the first.
    pub const BODY: usize = 1 + Section::BODY;

    /// Those of the robot of `cycle`.
    pub fn new(cycle: &Cycle) -> Self {
        let robot = cycle.robot();
        let commands = robot.inputs().len().max(1);
        let gains = robot.rest_gains();
        let moved = gains.chunks_exact(commands).enumerate();
        let elements = moved.filter(|(_, row)| row.iter().any(|g| *g != 0.0)).map(|(i, _)| i).collect();
        Self { section: cycle.section().clone(), structure: robot.strokes().len(), elements }
    }

    /// Elements whose displacements and rates are among them.
    pub fn moved(&self) -> &[usize] {
        &self.elements
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.elements_from() + 2 * self.elements.len()
    }
    /// Never true.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Place of the first of the elements' displacements; their rates come after them.
    pub fn elements_from(&self) -> usize {
        1 + self.section.len()
    }

    /// Where the place over the ground is in the state of the robot.
    pub fn position(&self) -> usize {
        self.section.layout().position
    }

    /// The numbers of the state `x` that deviate; returns its heading, rad.
    pub fn of<S: Scalar>(&self, x: &[S], s: &mut [S]) -> S {
        let l = self.section.layout();
        let (n, first) = (self.structure, self.elements_from());
        s[Self::HEIGHT] = x[l.position + 2];
        let heading = self.section.coordinates(x, &mut s[1..first]);
        for (k, i) in self.elements.iter().enumerate() {
            s[first + k] = x[l.structure + i];
            s[first + self.elements.len() + k] = x[l.structure + n + i];
        }
        heading
    }

    /// The state with heading zero above the origin that has the numbers `s`.
    fn state<S: Scalar>(&self, s: &[S]) -> Vec<S> {
        let l = self.section.layout();
        let (n, first) = (self.structure, self.elements_from());
        let mut structure = vec![S::ZERO; 2 * n];
        for (k, i) in self.elements.iter().enumerate() {
            structure[*i] = s[first + k];
            structure[n + i] = s[first + self.elements.len() + k];
        }
        let mut x = vec![S::ZERO; l.len];
        self.section.state(&s[1..first], &structure, &mut x);
        x[l.position + 2] = s[Self::HEIGHT];
        x
    }
}

/// Places behind the height.
const fn behind_height(places: Range<usize>) -> Range<usize> {
    1 + places.start..1 + places.end
}

/// The deviations over each of `count` equal intervals of a cycle of the orbit at `point`; `inputs` are moved, the others
/// held. A cycle must have a multiple of `count` steps.
///
/// Equation: orbit.intervals
/// `s_k+1 = A_k s_k + B_k u, derivatives of the flow between phases`
/// Source: definition.
/// Test: `intervals_add_up_to_the_cycle_and_the_feedback_holds_the_orbit`.
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
    deviations.of(&cycle.start(point), &mut nominal);
    let mut all = Vec::with_capacity(count);
    for k in 0..count {
        let (mut a, mut b) = (DMatrix::zeros(n + GROUND, n), DMatrix::zeros(n + GROUND, m));
        let (place, mut ground) = (deviations.section.layout().position, [0.0; GROUND]);
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
            let mut x = deviations.state(&s);
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
            let heading = deviations.of(&x, &mut s);
            s.extend([x[place], x[place + 1], heading]);
            for (i, end) in s.iter().enumerate() {
                *next.get_mut(i).unwrap_or_else(|| &mut ground[i - n]) = end.re;
                for column in first..last {
                    match column.checked_sub(n) {
                        None => a[(i, column)] = end.eps[column - first],
                        Some(input) => b[(i, input)] = end.eps[column - first],
                    }
                }
            }
        }
        nominal = next;
        all.push(Interval {
            ground_a: a.rows(n, GROUND).into(),
            ground_b: b.rows(n, GROUND).into(),
            a: a.resize_vertically(n, 0.0),
            b: b.resize_vertically(n, 0.0),
            ground,
        });
    }
    Ok(all)
}
