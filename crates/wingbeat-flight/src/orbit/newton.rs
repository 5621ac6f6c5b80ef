//! Newton's method on the conditions of an orbit.

use super::course::Course;
use super::cycle::{Cycle, End, Free, Point};
use super::failure::Failure;
use super::recoil::recoil;
use super::section::{Direction, OrbitSection};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;
use wingbeat_math::Scalar;

/// Most iterations of Newton's method.
const ITERATIONS: usize = 30;
/// Largest condition missed at which an orbit counts as found: m/s, rad, rad/s, and the units of the air's states.
const TOLERANCE: f64 = 1e-11;
/// The same of an orbit in longer steps, from which that in the steps asked is found.
const COARSE: f64 = 1e-6;
/// Halvings of a step that does not lessen the residual.
const HALVINGS: usize = 8;
/// Largest condition missed of an orbit of which rounding lets no step lessen it, in the same units: rates of a small and fast robot are
/// hundreds of rad/s.
const ROUNDED: f64 = 1e-10;
/// By how much a step with the derivatives of an earlier point must lessen the residual for the next to keep them.
const KEPT: f64 = 0.4;
/// Weight of the state against what is free in a step of least norm.
const STATE_WEIGHT: f64 = 1e4;

/// An orbit.
#[derive(Clone, Debug)]
pub struct Orbit {
    /// State at phase 0 and what is held.
    pub point: Point,
    /// What it flies.
    pub course: Course,
    /// Where a cycle ends.
    pub end: End,
}

/// An orbit and how it was found.
#[derive(Clone, Debug)]
pub struct FoundOrbit {
    /// The orbit.
    pub orbit: Orbit,
    /// Largest condition missed, in its own SI unit.
    pub residual: f64,
    /// Iterations of Newton's method.
    pub iterations: usize,
}

/// Names of the conditions beyond those on the state.
const BEYOND: [&str; 4] = ["mean speed", "mean climb", "growth of the heading", "mean roll"];

/// The conditions of a course.
struct Conditions<'a> {
    course: &'a Course,
    directions: Vec<Direction>,
    /// Whether left and right differ.
    coupled: bool,
}

impl<'a> Conditions<'a> {
    fn new(cycle: &Cycle, course: &'a Course) -> Self {
        let coupled = cycle.coupled(course);
        let others = if coupled { cycle.section().antisymmetric() } else { &[] };
        Self { coupled, ..Self::alike(cycle, course) }.with(others)
    }

    /// Those of a flight that keeps left and right alike, whatever the robot.
    fn alike(cycle: &Cycle, course: &'a Course) -> Self {
        Self { course, directions: cycle.section().symmetric().to_vec(), coupled: false }
    }

    fn with(mut self, others: &[Direction]) -> Self {
        self.directions.extend_from_slice(others);
        self
    }

    /// Number of conditions beyond those on the state.
    fn beyond(&self) -> usize {
        if self.coupled { 4 } else { 2 }
    }

    /// Equation: orbit.conditions
    /// `z(T) = z(0) in heading axes; x(T)/T = V, z(T)/T = climb; of a turn yaw(T) = yaw rate T, chord/T = V
    /// sin(a)/a, a = yaw rate T/2, mean roll = bank`
    /// Source: relative periodic orbits.
    /// Test: `a_flight_from_its_orbit_stays_on_it_open_loop`.
    ///
    /// What is missed: the state that returns, in heading axes; mean speed and climb; of a turn the growth of the
    /// heading over a cycle of T s, the chord of its path V T sin(a)/a, a = yaw rate T / 2, and the mean roll.
    fn missed<S: Scalar>(&self, z: &[S], end: &End<S>) -> Vec<S> {
        let returns =
            self.directions.iter().map(|d| OrbitSection::along(d, &end.z) - OrbitSection::along(d, z));
        let [x, y, up] = end.displacement.0;
        let duration = end.duration;
        let per_time = duration.recip();
        let climb = up * per_time - self.course.climb;
        if !self.coupled {
            return returns.chain([x * per_time - self.course.speed, climb]).collect();
        }
        let speed = (x * x + y * y).sqrt() * per_time - self.course.chord_speed(duration);
        let heading = end.heading - duration * self.course.yaw_rate();
        let roll = end.mean_roll - self.course.bank;
        returns.chain([speed, climb, heading, roll]).collect()
    }

    fn name(&self, cycle: &Cycle, i: usize) -> String {
        match self.directions.get(i) {
            Some(direction) => format!("the return of {}", cycle.section().names()[direction[0].0]),
            None => BEYOND[i - self.directions.len()].into(),
        }
    }
}

/// Solves a square or wide system in the sense of the least norm; `None` when it is singular.
pub(super) fn solve(matrix: &[f64], rows: usize, columns: usize, rhs: &[f64]) -> Option<Vec<f64>> {
    let a = DMatrix::from_row_slice(rows, columns, matrix);
    let b = DVector::from_column_slice(rhs);
    if rows == columns {
        return a.lu().solve(&b).map(|x| x.as_slice().to_vec());
    }
    let gram = &a * a.transpose();
    Some((a.transpose() * gram.lu().solve(&b)?).as_slice().to_vec())
}

/// Finds the orbit of `course` by a recoil start from `guess` and Newton's method, first in steps twice as long. The first two
/// of `free` are what the start turns; a turn is not started this way but followed from level flight. `observe` hears iteration
/// and residual (in SI units).
///
/// # Errors
/// The [`Failure`] that names what stood in the way.
pub fn search(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    guess: Point,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<FoundOrbit, Failure> {
    if let Some(coarse) = cycle.coarser() {
        match started(&coarse, course, free, guess.clone(), COARSE, observe) {
            Ok((found, tangent)) => {
                let near = search_near(cycle, course, free, found.orbit.point, &tangent);
                if let Ok(near) = near {
                    return Ok(FoundOrbit { iterations: found.iterations + near.iterations, ..near });
                }
            }
            Err(Failure::Stopped) => return Err(Failure::Stopped),
            Err(_) => {}
        }
    }
    started(cycle, course, free, guess, TOLERANCE, observe).map(|(found, _)| found)
}

/// [`search`] in the steps of `cycle`, to a largest condition missed of `tolerance`.
fn started(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    guess: Point,
    tolerance: f64,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<(FoundOrbit, Tangent), Failure> {
    // From close by Newton's method needs no other start.
    match newton(cycle, course, free, guess.clone(), tolerance, observe) {
        Ok(found) => return Ok(found),
        Err(Failure::Stopped) => return Err(Failure::Stopped),
        Err(_) => {}
    }
    let started = recoil(cycle, course, free, guess)?;
    match cycle.coupled(course) {
        false => newton(cycle, course, free, started, tolerance, observe),
        true => {
            let near = alike(cycle, course, free, started, observe)?;
            newton(cycle, course, free, near, tolerance, observe)
        }
    }
}

/// Finds the orbit of `course` from `point` by Newton's method on derivatives of the flow over a cycle, exact at first and then learned from its steps; with more free
/// numbers than conditions by steps of least norm in them, each measured by half of its range. `observe` hears iteration and
/// residual (in SI units).
///
/// # Errors
/// The [`Failure`] that names what stood in the way.
pub fn search_from(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: Point,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<FoundOrbit, Failure> {
    newton(cycle, course, free, point, TOLERANCE, observe).map(|(found, _)| found)
}

/// The point that would be on an orbit if the robot's sides were alike, for a start where they are not.
fn alike(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: Point,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<Point, Failure> {
    let conditions = Conditions::alike(cycle, course);
    Ok(iterated(cycle, &conditions, free, point, COARSE, observe)?.0)
}

/// [`search_from`] to a largest condition missed of `tolerance`; with the derivatives that led there.
fn newton(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: Point,
    tolerance: f64,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<(FoundOrbit, Tangent), Failure> {
    let conditions = Conditions::new(cycle, course);
    let (point, residual, iteration, tangent) =
        iterated(cycle, &conditions, free, point, tolerance, observe)?;
    Ok((finished(cycle, course, free, point, residual, iteration)?, tangent))
}

/// Newton's method on `conditions`: where it ends, what is missed there, its iterations and last derivatives.
fn iterated(
    cycle: &Cycle,
    conditions: &Conditions,
    free: &[Free],
    mut point: Point,
    tolerance: f64,
    observe: &mut dyn FnMut(usize, f64) -> ControlFlow<()>,
) -> Result<(Point, f64, usize, Tangent), Failure> {
    let (states, rows) = (conditions.directions.len(), conditions.directions.len() + conditions.beyond());
    let columns = states + free.len();
    if columns < rows {
        return Err(Failure::Singular { iteration: 0, residual: f64::INFINITY });
    }
    let mut residual = f64::INFINITY;
    let mut worst = 0;
    for iteration in 1..=ITERATIONS {
        let (missed, jacobian) =
            cycle.differentiate(&point, &conditions.directions, free, |z, end| conditions.missed(z, end))?;
        (worst, residual) = largest(&missed);
        if observe(iteration, residual).is_break() {
            return Err(Failure::Stopped);
        }
        let mut tangent = Tangent::new(cycle, states, free, &jacobian);
        if residual <= tolerance {
            return Ok((point, residual, iteration, tangent));
        }
        let singular = Failure::Singular { iteration, residual };
        let step = tangent.step(&missed).ok_or(singular.clone())?;
        let Some((next, left, share)) = shortened(cycle, conditions, free, &point, &step, residual) else {
            if residual <= ROUNDED {
                return Ok((point, residual, iteration, tangent));
            }
            let condition = conditions.name(cycle, worst);
            return Err(Failure::NotConverged { iterations: iteration, residual, condition });
        };
        tangent.learn(&step, share, &missed, &left);
        let (next, left) =
            followed(cycle, conditions, free, &mut tangent, (next, left), tolerance, &singular)?;
        point = next;
        if left <= tolerance {
            return Ok((point, left, iteration, tangent));
        }
    }
    Err(Failure::NotConverged { iterations: ITERATIONS, residual, condition: conditions.name(cycle, worst) })
}

/// Derivatives of the conditions of a course at a point, by the coordinates and what is free: with them orbits close by
/// are found at the cost of plain cycles.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// By rows, every column times its weight.
    matrix: Vec<f64>,
    weights: Vec<f64>,
}

impl Tangent {
    /// The derivatives at `point`.
    ///
    /// # Errors
    /// The [`Failure`] of a model that cannot be evaluated.
    pub fn at(cycle: &Cycle, course: &Course, free: &[Free], point: &Point) -> Result<Self, Failure> {
        let conditions = Conditions::new(cycle, course);
        let missed = |z: &[_], end: &End<_>| conditions.missed(z, end);
        let (_, jacobian) = cycle.differentiate(point, &conditions.directions, free, missed)?;
        Ok(Self::new(cycle, conditions.directions.len(), free, &jacobian))
    }

    fn new(cycle: &Cycle, states: usize, free: &[Free], jacobian: &[Vec<f64>]) -> Self {
        let of_free = free.iter().map(|free| cycle.size(free));
        let weights: Vec<f64> = std::iter::repeat_n(STATE_WEIGHT, states).chain(of_free).collect();
        let matrix = jacobian.iter().flat_map(|row| row.iter().zip(&weights).map(|(a, w)| a * w)).collect();
        Self { matrix, weights }
    }

    /// The step that takes off what is `missed`; `None` where the matrix is singular.
    fn step(&self, missed: &[f64]) -> Option<Vec<f64>> {
        let rhs: Vec<f64> = missed.iter().map(|m| -m).collect();
        let step = solve(&self.matrix, missed.len(), self.weights.len(), &rhs)?;
        Some(step.iter().zip(&self.weights).map(|(s, w)| s * w).collect())
    }

    /// Takes what a `share` t of the `step` s has changed of what is `missed` for the derivatives along it. Where more is free than is asked,
    /// an orbit depends on the way to it: there this waits until what is missed is small.
    ///
    /// Equation: orbit.learned_tangent
    /// `J + (m' - (1 - t) m) s'/(t s's), of J s = -m`
    /// Source: Broyden 1965, Math. Comp. 19.
    /// Test: `derivatives_that_learn_find_a_root_in_fewer_steps`.
    fn learn(&mut self, step: &[f64], share: f64, missed: &[f64], then: &[f64]) {
        let columns = self.weights.len();
        if columns > missed.len() && largest(missed).1 > COARSE {
            return;
        }
        let per_length = 1.0 / (share * step.iter().map(|s| s * s).sum::<f64>());
        for (row, (missed, then)) in self.matrix.chunks_exact_mut(columns).zip(missed.iter().zip(then)) {
            let unforeseen = (then - (1.0 - share) * missed) * per_length;
            let of_step = step.iter().zip(&self.weights);
            row.iter_mut().zip(of_step).for_each(|(entry, (s, w))| *entry += unforeseen * s * w);
        }
    }
}

/// Finds the orbit of `course` from `point`, which lies close to it, with derivatives of an orbit close by; where they
/// do not point well any more, with its own ([`search_from`]).
///
/// # Errors
/// The [`Failure`] that names what stood in the way.
pub fn search_near(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: Point,
    tangent: &Tangent,
) -> Result<FoundOrbit, Failure> {
    let conditions = Conditions::new(cycle, course);
    let left = conditions.missed(&point.z, &cycle.end(&point)?);
    let singular = Failure::Singular { iteration: 0, residual: largest(&left).1 };
    let tangent = &mut tangent.clone();
    let (point, left) = followed(cycle, &conditions, free, tangent, (point, left), TOLERANCE, &singular)?;
    if left <= TOLERANCE {
        return finished(cycle, course, free, point, left, 0);
    }
    search_from(cycle, course, free, point, &mut |_, _| ControlFlow::Continue(()))
}

/// How well each pair of `free` leads to the orbits about that at `point`: their places, and the least singular value of the derivatives
/// by the state and these two, commands in halves of their ranges: dimensionless. Where it is 0 the orbits fold: the pair leads to none further on.
///
/// # Errors
/// The [`Failure`] of a model that cannot be evaluated.
pub fn steadiness(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: &Point,
) -> Result<Vec<([usize; 2], f64)>, Failure> {
    let tangent = Tangent::at(cycle, course, free, point)?;
    let columns = tangent.weights.len();
    let all = DMatrix::from_row_slice(tangent.matrix.len() / columns, columns, &tangent.matrix);
    let states = columns - free.len();
    let least = |[i, j]: [usize; 2]| {
        let kept: Vec<usize> = (0..states).chain([states + i, states + j]).collect();
        all.select_columns(&kept).singular_values().min()
    };
    let pairs = (0..free.len()).flat_map(|i| (i + 1..free.len()).map(move |j| [i, j]));
    Ok(pairs.map(|pair| (pair, least(pair))).collect())
}

/// While the derivatives still point well, further steps cost a cycle of plain numbers: the point after them and the
/// largest condition missed there.
fn followed(
    cycle: &Cycle,
    conditions: &Conditions,
    free: &[Free],
    tangent: &mut Tangent,
    (mut point, mut left): (Point, Vec<f64>),
    tolerance: f64,
    singular: &Failure,
) -> Result<(Point, f64), Failure> {
    loop {
        in_range(cycle, free, &point)?;
        let before = largest(&left).1;
        if before <= tolerance {
            return Ok((point, before));
        }
        let step = tangent.step(&left).ok_or_else(|| singular.clone())?;
        let Some((next, then, share)) = shortened(cycle, conditions, free, &point, &step, before) else {
            return Ok((point, before));
        };
        let now = largest(&then).1;
        tangent.learn(&step, share, &left, &then);
        (point, left) = (next, then);
        if now > KEPT * before {
            return Ok((point, now));
        }
    }
}

/// The point after the largest share of `step` that lessens the residual, what is missed there, and that share.
fn shortened(
    cycle: &Cycle,
    conditions: &Conditions,
    free: &[Free],
    point: &Point,
    step: &[f64],
    residual: f64,
) -> Option<(Point, Vec<f64>, f64)> {
    let mut share = 1.0;
    for _ in 0..HALVINGS {
        let mut next = point.clone();
        for (direction, step) in conditions.directions.iter().zip(step) {
            direction.iter().for_each(|(i, part)| next.z[*i] += part * share * step);
        }
        let of_free = &step[conditions.directions.len()..];
        free.iter().zip(of_free).for_each(|(free, step)| next.moved(free, share * step));
        if next.pace > 0.0
            && let Ok(end) = cycle.end(&next)
        {
            let missed = conditions.missed(&next.z, &end);
            if largest(&missed).1 < residual {
                return Some((next, missed, share));
            }
        }
        share *= 0.5;
    }
    None
}

fn finished(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    point: Point,
    residual: f64,
    iterations: usize,
) -> Result<FoundOrbit, Failure> {
    in_range(cycle, free, &point)?;
    let end = cycle.end(&point)?;
    returns_sidewise(cycle, course, &point, &end)?;
    Ok(FoundOrbit { orbit: Orbit { point, course: *course, end }, residual, iterations })
}

/// Largest difference over a cycle of what is zero where left and right are alike, SI.
const SIDEWISE: f64 = 1e-8;

/// That a cycle straight ahead, found in the directions in which left and right do the same, returns in the others too.
fn returns_sidewise(cycle: &Cycle, course: &Course, point: &Point, end: &End<f64>) -> Result<(), Failure> {
    if cycle.coupled(course) {
        return Ok(());
    }
    let directions = cycle.section().antisymmetric();
    let missed: Vec<f64> = directions
        .iter()
        .map(|d| OrbitSection::along(d, &end.z) - OrbitSection::along(d, &point.z))
        .collect();
    let (worst, missed) = largest(&missed);
    if missed <= SIDEWISE {
        return Ok(());
    }
    let condition = format!("the return of {}", cycle.section().names()[directions[worst][0].0]);
    Err(Failure::Asymmetric { missed, condition })
}

/// The largest of the numbers and its place.
fn largest(missed: &[f64]) -> (usize, f64) {
    missed.iter().enumerate().fold((0, 0.0), |(at, most), (i, m)| {
        if m.abs() > most || !m.is_finite() { (i, m.abs()) } else { (at, most) }
    })
}

/// That what is free keeps to its limits.
fn in_range(cycle: &Cycle, free: &[Free], point: &Point) -> Result<(), Failure> {
    for free in free {
        let (name, unit, [low, high]) = cycle.described(free);
        let value = cycle.value(free, point);
        if !(value >= low && value <= high) {
            let measured = *free == Free::Frequency && cycle.robot().residual_frequencies().is_some();
            return Err(if measured {
                Failure::Residual { value, low, high }
            } else {
                Failure::Range { name, value, unit, low, high }
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps to the root of x^2 + y = 3, x - y^2 = -3 with the derivatives of where they start, which learn or do not.
    fn steps(learns: bool) -> usize {
        let missed = |[x, y]: [f64; 2]| vec![x * x + y - 3.0, x - y * y + 3.0];
        let mut at = [2.0, 3.0];
        let weights = vec![10.0, 0.5];
        let jacobian = [2.0 * at[0], 1.0, 1.0, -2.0 * at[1]];
        let matrix = jacobian.iter().zip(weights.repeat(2)).map(|(slope, weight)| slope * weight).collect();
        let mut tangent = Tangent { matrix, weights };
        for taken in 0..40 {
            let before = missed(at);
            if largest(&before).1 < TOLERANCE {
                return taken;
            }
            let (step, share) = (tangent.step(&before).unwrap(), if taken == 0 { 0.5 } else { 1.0 });
            at = std::array::from_fn(|i| at[i] + share * step[i]);
            let then = missed(at);
            if learns {
                tangent.learn(&step, share, &before, &then);
                // What they say of the step is what it did.
                let along: Vec<f64> = step.iter().zip(&tangent.weights).map(|(s, w)| share * s / w).collect();
                for (row, (before, then)) in tangent.matrix.chunks_exact(2).zip(before.iter().zip(&then)) {
                    assert!((row[0] * along[0] + row[1] * along[1] - (then - before)).abs() < 1e-14);
                }
            }
        }
        panic!("{at:?}")
    }

    #[test]
    fn derivatives_that_learn_find_a_root_in_fewer_steps() {
        let [learning, kept] = [true, false].map(steps);
        assert!(learning <= 8 && kept > 10, "{learning} {kept}");
    }
}
