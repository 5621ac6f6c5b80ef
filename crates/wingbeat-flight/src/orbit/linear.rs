//! Small deviations from an orbit between phases of its cycle.

use super::cycle::{Cycle, Flow, Point};
use super::section::{Direction, Section};
use nalgebra::DMatrix;
use std::ops::Range;
use wingbeat_math::{Error, RK4, Scalar, Steps, Workspace, parallel};
use wingbeat_ocp::plant::{Early, Fault, Plant};
use wingbeat_robot::CycleScalar;

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
    /// A, in the units of the deviations.
    pub a: DMatrix<f64>,
    /// B, in the units of the deviations over those of the commands.
    pub b: DMatrix<f64>,
    /// Where the orbit is at its end over the ground, in heading axes at its begin: along x, y, m, and heading, rad.
    pub ground: [f64; 3],
    /// The same as A for that.
    pub ground_a: DMatrix<f64>,
    /// The same as B for that.
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

    /// Directions in which left and right stay alike.
    ///
    /// # Errors
    /// Those of [`Robot::pairs`](wingbeat_robot::Robot::pairs).
    pub fn symmetric(&self, cycle: &Cycle) -> Result<Vec<Direction>, Error> {
        let mirror = cycle.robot().pairs()?;
        let l = self.section.layout();
        let mut stands = vec![0; l.len - l.structure];
        mirror.expand_states(&mirror.states, &mut stands);
        let shifted = |direction: &Direction| direction.iter().map(|(i, share)| (i + 1, *share)).collect();
        let body = self.section.symmetric().iter().map(shifted);
        let (first, count) = (self.elements_from(), self.elements.len());
        let pairs = self
            .elements
            .iter()
            .filter(|&&i| stands[i] == i)
            .map(|&i| (0..count).filter(|&k| stands[self.elements[k]] == i).collect::<Vec<_>>());
        let pairs: Vec<Vec<usize>> = pairs.collect();
        let of = |offset: usize| {
            pairs.iter().map(move |pair| pair.iter().map(|k| (first + offset + k, 1.0)).collect())
        };
        Ok(std::iter::once(vec![(Self::HEIGHT, 1.0)]).chain(body).chain(of(0)).chain(of(count)).collect())
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

/// Flies part `part` of a cycle in equal parts, as many as are given second, from the numbers `s` that deviate at its begin with the
/// commands `u` held; `each` sees every step. The numbers at its end, and place and heading over the ground there.
pub(crate) fn fly_part<S: CycleScalar>(
    cycle: &Cycle,
    deviations: &Deviations,
    s: &[S],
    pace: f64,
    u: &[S],
    [part, parts]: [usize; 2],
    each: &mut dyn FnMut(&[S]),
) -> Result<(Vec<S>, [S; GROUND]), Fault> {
    let mut x = deviations.state(s);
    fly_state(cycle, &mut x, pace, u, [part, parts], each)?;
    let mut end = vec![S::ZERO; deviations.len()];
    let heading = deviations.of(&x, &mut end);
    let place = deviations.position();
    Ok((end, [x[place], x[place + 1], heading]))
}

/// Flies likewise from the state `x` at the pace of the gait, whose crank moves by its command; parts may go on beyond the first cycle.
pub(crate) fn fly_held<S: CycleScalar>(
    cycle: &Cycle,
    x: &mut [S],
    u: &[S],
    part: [usize; 2],
    each: &mut dyn FnMut(&[S]),
) -> Result<(), Fault> {
    fly_state(cycle, x, 1.0, u, part, each)
}

fn fly_state<S: CycleScalar>(
    cycle: &Cycle,
    x: &mut [S],
    pace: f64,
    u: &[S],
    [part, parts]: [usize; 2],
    each: &mut dyn FnMut(&[S]),
) -> Result<(), Fault> {
    let length = cycle.duration(pace) / cycle.steps() as f64;
    let steps = cycle.steps() / parts;
    let clock = Steps { start: S::ZERO, length: S::from(length), first: part * steps, count: steps };
    let each = |_, _, x: &[S]| {
        each(x);
        Ok(())
    };
    let mut flow = Flow { robot: cycle.robot(), pace: S::from(pace), u, each };
    let mut work = Workspace::new(x.len(), RK4.b.len());
    RK4.integrate(&mut flow, clock, x, &mut work)?;
    Ok(())
}

/// The numbers, in the units of the states, after part `part` of a cycle from the `nominal` ones under held commands, and how
/// deviations along `directions` and commands along `inputs` grow over it, as deviations along `directions`.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
pub fn interval(
    cycle: &Cycle,
    deviations: &Deviations,
    nominal: &[f64],
    point: (f64, &[f64]),
    part: [usize; 2],
    along: [&[Direction]; 2],
) -> Result<(Vec<f64>, Interval), Fault> {
    let mut over = Interval::zeros(along.map(<[Direction]>::len));
    let mut next = Vec::new();
    for first in (0..along[0].len() + along[1].len()).step_by(Early::LANES) {
        let columns = fly_columns(cycle, deviations, nominal, point, part, along, first)?;
        over.set(&columns);
        next = columns.next;
    }
    Ok((next, over))
}

impl Interval {
    /// Room for `n` deviations and `m` commands.
    fn zeros([n, m]: [usize; 2]) -> Self {
        let [(a, b), (ground_a, ground_b)] =
            [n, GROUND].map(|rows| (DMatrix::zeros(rows, n), DMatrix::zeros(rows, m)));
        Self { a, b, ground: [0.0; GROUND], ground_a, ground_b }
    }

    /// Takes the columns that were flown together.
    fn set(&mut self, flown: &Columns) {
        let n = self.a.nrows();
        self.ground = flown.ground;
        for (i, row) in flown.rows.iter().enumerate() {
            let (a, b, i) = match i.checked_sub(n) {
                None => (&mut self.a, &mut self.b, i),
                Some(i) => (&mut self.ground_a, &mut self.ground_b, i),
            };
            for (lane, value) in row[..flown.count].iter().enumerate() {
                match (flown.first + lane).checked_sub(n) {
                    None => a[(i, flown.first + lane)] = *value,
                    Some(input) => b[(i, input)] = *value,
                }
            }
        }
    }
}

/// Columns of an [`Interval`] that are flown together.
struct Columns {
    /// The first of them, those of A before those of B.
    first: usize,
    /// Their number.
    count: usize,
    /// Derivatives, by rows: what deviates, then what lies over the ground.
    rows: Vec<[f64; Early::LANES]>,
    /// The numbers at the end of the interval.
    next: Vec<f64>,
    /// Where the orbit is then over the ground.
    ground: [f64; GROUND],
}

/// Flies the columns from `first` on.
fn fly_columns(
    cycle: &Cycle,
    deviations: &Deviations,
    nominal: &[f64],
    point: (f64, &[f64]),
    part: [usize; 2],
    [directions, inputs]: [&[Direction]; 2],
    first: usize,
) -> Result<Columns, Fault> {
    let n = directions.len();
    let count = (n + inputs.len() - first).min(Early::LANES);
    let mut s: Vec<Early> = nominal.iter().map(|v| Early::constant(*v)).collect();
    let mut u: Vec<Early> = point.1.iter().map(|v| Early::constant(*v)).collect();
    for lane in 0..count {
        let (to, direction) = match (first + lane).checked_sub(n) {
            None => (&mut s, &directions[first + lane]),
            Some(i) => (&mut u, &inputs[i]),
        };
        direction.iter().for_each(|(i, share)| to[*i].eps[lane] = *share);
    }
    let (end, over) = fly_part(cycle, deviations, &s, point.0, &u, part, &mut |_| ())?;
    let along = directions.iter().map(|direction| Section::along(direction, &end).eps);
    let rows = along.chain(over.iter().map(|over| over.eps)).collect();
    let next = end.iter().map(|end| end.re).collect();
    Ok(Columns { first, count, rows, next, ground: over.map(|over| over.re) })
}

/// Each of these numbers by itself.
pub fn alone(numbers: impl IntoIterator<Item = usize>) -> Vec<Direction> {
    numbers.into_iter().map(|i| vec![(i, 1.0)]).collect()
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
    let (directions, inputs) = (alone(0..deviations.len()), alone(inputs.iter().copied()));
    let mut nominal = vec![0.0; deviations.len()];
    deviations.of(&cycle.start(point), &mut nominal);
    // Columns that are flown together do not see the others, so each core takes some of them over the whole cycle.
    let columns: Vec<usize> = (0..directions.len() + inputs.len()).step_by(Early::LANES).collect();
    let over_cycle = |_, first: &usize| -> Result<Vec<Columns>, Fault> {
        let mut at = nominal.clone();
        let held = (point.pace, &point.inputs[..]);
        let over = |k| {
            let along = [&directions[..], &inputs[..]];
            let flown = fly_columns(cycle, &deviations, &at, held, [k, count], along, *first)?;
            at.clone_from(&flown.next);
            Ok(flown)
        };
        (0..count).map(over).collect()
    };
    let mut all = vec![Interval::zeros([directions.len(), inputs.len()]); count];
    for flown in parallel::map(&columns, over_cycle) {
        all.iter_mut().zip(&flown?).for_each(|(interval, columns)| interval.set(columns));
    }
    Ok(all)
}
