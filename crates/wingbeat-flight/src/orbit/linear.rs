//! Small deviations from an orbit between phases of its cycle.

use super::cycle::{Cycle, CycleFlow, Point, settle};
use super::section::{Direction, OrbitSection};
use nalgebra::DMatrix;
use std::ops::{ControlFlow, Range};
use wingbeat_math::{Dynamics, EqualSteps, Error, RK4, Scalar, Workspace, parallel};
use wingbeat_ocp::plant::{Early, Fault, Linearisation, Plant};
use wingbeat_robot::{CycleScalar, Robot};

/// Numbers of place and heading over the ground.
const GROUND: usize = 3;

/// What deviates from an orbit: height, the coordinates of the [`OrbitSection`], displacements of the elements,
/// their rates. The crank's element does not: it is no part of a cycle.
#[derive(Clone, Debug)]
pub struct Deviations {
    section: OrbitSection,
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
    pub const VELOCITY: Range<usize> = behind_height(OrbitSection::VELOCITY);
    /// Place of the roll.
    pub const ROLL: usize = 1 + OrbitSection::ROLL;
    /// Place of the pitch.
    pub const PITCH: usize = 1 + OrbitSection::PITCH;
    /// Places of the angular rate.
    pub const RATE: Range<usize> = behind_height(OrbitSection::RATE);
    /// Number of those of the body, which are the first.
    pub const BODY: usize = 1 + OrbitSection::BODY;

    /// Those of the robot of `cycle`.
    pub fn new(cycle: &Cycle) -> Self {
        let robot = cycle.robot();
        let commands = robot.inputs().len().max(1);
        let gains = robot.rest_gains();
        let moved = gains.chunks_exact(commands).enumerate();
        let elements = moved.filter(|(_, row)| row.iter().any(|g| *g != 0.0)).map(|(i, _)| i).collect();
        Self { section: cycle.section().clone(), structure: robot.strokes().len(), elements }
    }

    /// Place of a coordinate of the section among them.
    pub const fn coordinate(coordinate: usize) -> usize {
        1 + coordinate
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
    pub(super) fn state<S: Scalar>(&self, s: &[S]) -> Vec<S> {
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
    part: [usize; 2],
    each: &mut dyn FnMut(&[S]),
) -> Result<(), Fault> {
    let EqualSteps { start, length, first, count } = clock(cycle, pace, part);
    let clock = EqualSteps { start: S::from(start), length: S::from(length), first, count };
    let each = |_, _, x: &[S]| {
        each(x);
        Ok(())
    };
    let mut flow = CycleFlow { robot: cycle.robot(), pace: S::from(pace), u, each };
    let mut work = Workspace::new(x.len(), RK4.b.len());
    RK4.integrate(&mut flow, clock, x, &mut work)?;
    Ok(())
}

/// The steps of part `part` of a cycle in so many equal parts as are given second.
pub(super) fn clock(cycle: &Cycle, pace: f64, [part, parts]: [usize; 2]) -> EqualSteps {
    let length = cycle.duration(pace) / cycle.steps() as f64;
    let steps = cycle.steps() / parts;
    EqualSteps { start: 0.0, length, first: part * steps, count: steps }
}

/// Derivatives of a state by rows, as many columns each: along directions, then by commands.
pub(super) struct GrownColumns {
    states: usize,
    /// Number of columns.
    pub count: usize,
    /// Place of the attitude in the state.
    attitude: usize,
    /// U: derivatives of the commands, by rows.
    moved: Vec<f64>,
}

impl GrownColumns {
    pub fn new(robot: &Robot, commands: usize, [directions, inputs]: [&[Direction]; 2]) -> Self {
        let count = directions.len() + inputs.len();
        let mut moved = vec![0.0; commands * count];
        for (column, input) in (directions.len()..).zip(inputs) {
            input.iter().for_each(|(i, share)| moved[i * count + column] = *share);
        }
        Self { states: robot.states().len(), count, attitude: robot.layout().attitude, moved }
    }

    /// Writes A X + B U, of `here` and the columns X, in the units of these per s.
    pub fn growth(&self, here: &Linearisation, grown: &[f64], growth: &mut [f64]) {
        let (n, m) = (self.states, here.b.len() / self.states);
        growth.fill(0.0);
        for (i, row) in growth.chunks_exact_mut(self.count.max(1)).enumerate() {
            add_rows(row, &here.a[i * n..][..n], grown);
            add_rows(row, &here.b[i * m..][..m], &self.moved);
        }
    }

    /// Makes the derivatives of q those of q/|q| = p, the attitude in the state `x`, all dimensionless over the units of what is moved:
    /// dp = (dq - p (p . dq)) / |q|.
    pub fn settle(&self, x: &[f64], inverse: f64, grown: &mut [f64]) {
        let p = &x[self.attitude..][..4];
        for column in 0..self.count {
            let at = |i: usize| (self.attitude + i) * self.count + column;
            let along: f64 = (0..4).map(|i| p[i] * grown[at(i)]).sum();
            (0..4).for_each(|i| grown[at(i)] = (grown[at(i)] - p[i] * along) * inverse);
        }
    }
}

/// A robot under held commands whose state comes with its derivatives: the numbers of the state, then the columns.
///
/// Equation: orbit.variation
/// `X' = A X + B U beside x' = f, with A and B at each stage of a step`
/// Source: variational equation; with A and B exact it gives the derivatives of the step itself.
/// Test: `intervals_add_up_to_the_cycle_and_the_feedback_holds_the_orbit`.
struct Growing<'a> {
    robot: &'a Robot,
    u: &'a [f64],
    columns: GrownColumns,
    here: Linearisation,
}

impl Dynamics<f64, Fault> for Growing<'_> {
    fn slope(&mut self, t: f64, x: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        let n = self.robot.states().len();
        let (x, grown) = x.split_at(n);
        let (rates, growth) = dx.split_at_mut(n);
        self.here.evaluate(self.robot, t, x, self.u)?;
        rates.copy_from_slice(&self.here.f);
        self.columns.growth(&self.here, grown, growth);
        Ok(())
    }
    fn after_step(&mut self, _: usize, t: f64, x: &mut [f64]) -> Result<ControlFlow<()>, Fault> {
        let (x, grown) = x.split_at_mut(self.robot.states().len());
        let first = self.robot.layout().attitude;
        let inverse = x[first..first + 4].iter().map(|q| q * q).sum::<f64>().sqrt().recip();
        settle(self.robot, t, x)?;
        self.columns.settle(x, inverse, grown);
        Ok(ControlFlow::Continue(()))
    }
}

/// Adds the `rows`, each as long as `sum`, times their `factors`.
fn add_rows(sum: &mut [f64], factors: &[f64], rows: &[f64]) {
    let n = sum.len();
    for (j, factor) in factors.iter().enumerate() {
        if *factor != 0.0 {
            let row = &rows[j * n..][..n];
            for i in 0..n {
                sum[i] = factor.mul_add(row[i], sum[i]);
            }
        }
    }
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
    (pace, held): (f64, &[f64]),
    part: [usize; 2],
    along: [&[Direction]; 2],
) -> Result<(Vec<f64>, Interval), Fault> {
    let paced = (pace != 1.0).then(|| cycle.robot().paced(pace));
    let robot = paced.as_ref().unwrap_or(cycle.robot());
    let columns = GrownColumns::new(robot, held.len(), along);
    let here = Linearisation::new(robot.states().len(), held.len());
    let mut growing = Growing { robot, u: held, columns, here };
    let mut x = begin(deviations, nominal, along);
    let mut work = Workspace::new(x.len(), RK4.b.len());
    RK4.integrate(&mut growing, clock(cycle, pace, part), &mut x, &mut work)?;
    Ok(told(deviations, &x, along))
}

/// The state at the numbers `nominal`, in the units of the states, and the columns behind it, by rows.
pub(super) fn begin(deviations: &Deviations, nominal: &[f64], along: [&[Direction]; 2]) -> Vec<f64> {
    let columns = along[0].len() + along[1].len();
    let mut x = Vec::new();
    for first in blocks(columns) {
        let mut s: Vec<Early> = nominal.iter().map(|v| Early::constant(*v)).collect();
        for (lane, direction) in along[0].iter().skip(first).take(Early::LANES).enumerate() {
            direction.iter().for_each(|(i, share)| s[*i].eps[lane] = *share);
        }
        let (count, states) = (Early::LANES.min(columns - first), deviations.state(&s));
        let n = states.len();
        x.resize(n * (1 + columns), 0.0);
        for (i, state) in states.iter().enumerate() {
            x[i] = state.re;
            x[n + i * columns + first..][..count].copy_from_slice(&state.eps[..count]);
        }
    }
    x
}

/// What deviates in the state `x` with its columns behind it, in the units of the states, and how it grew.
pub(super) fn told(deviations: &Deviations, x: &[f64], along: [&[Direction]; 2]) -> (Vec<f64>, Interval) {
    let columns = along[0].len() + along[1].len();
    let n = x.len() / (1 + columns);
    let (mut over, mut next) = (Interval::zeros(along.map(<[Direction]>::len)), Vec::new());
    for first in blocks(columns) {
        let count = Early::LANES.min(columns - first);
        let state = |i: usize| {
            let mut state = Early::constant(x[i]);
            state.eps[..count].copy_from_slice(&x[n + i * columns + first..][..count]);
            state
        };
        let x: Vec<Early> = (0..n).map(state).collect();
        let mut end = vec![Early::ZERO; deviations.len()];
        let heading = deviations.of(&x, &mut end);
        let place = deviations.position();
        let ground = [x[place], x[place + 1], heading];
        let rows = along[0].iter().map(|direction| OrbitSection::along(direction, &end).eps);
        let rows = rows.chain(ground.map(|over| over.eps)).collect();
        over.set(&IntervalColumns { first, count, rows, ground: ground.map(|over| over.re) });
        next = end.iter().map(|end| end.re).collect();
    }
    (next, over)
}

/// The first of the columns that are told together, at least one.
fn blocks(columns: usize) -> impl Iterator<Item = usize> {
    (0..columns.max(1)).step_by(Early::LANES)
}

impl Interval {
    /// Room for `n` deviations and `m` commands.
    fn zeros([n, m]: [usize; 2]) -> Self {
        let [(a, b), (ground_a, ground_b)] =
            [n, GROUND].map(|rows| (DMatrix::zeros(rows, n), DMatrix::zeros(rows, m)));
        Self { a, b, ground: [0.0; GROUND], ground_a, ground_b }
    }

    /// Takes the columns that are told together.
    fn set(&mut self, flown: &IntervalColumns) {
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

/// Columns of an [`Interval`] that are told together.
struct IntervalColumns {
    /// The first of them, those of A before those of B.
    first: usize,
    /// Their number.
    count: usize,
    /// Derivatives, by rows: what deviates, then what lies over the ground.
    rows: Vec<[f64; Early::LANES]>,
    /// Where the orbit is then over the ground.
    ground: [f64; GROUND],
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
    let (mut begins, held) = (vec![nominal], &point.inputs[..]);
    for k in 1..count {
        let part = [k - 1, count];
        begins.push(fly_part(cycle, &deviations, &begins[k - 1], point.pace, held, part, &mut |_| ())?.0);
    }
    let along = [&directions[..], &inputs[..]];
    let grown =
        |k, begin: &Vec<f64>| interval(cycle, &deviations, begin, (point.pace, held), [k, count], along);
    parallel::map(&begins, grown).into_iter().map(|grown| Ok(grown?.1)).collect()
}
