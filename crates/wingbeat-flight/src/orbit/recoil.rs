//! The recoil start: a state at phase 0 from which the free body's swing has the mean motion asked.

use super::course::Course;
use super::cycle::{Cycle, Free, Point};
use super::failure::Failure;
use super::newton::solve;
use super::section::{Direction, OrbitSection};

/// Cycles that settle swing and lags.
const SETTLING: usize = 12;
/// Newton steps on the mean accelerations.
const STEPS: usize = 12;
/// Cycles that settle swing and lags after each of them.
const AFTER_STEP: usize = 3;
/// Coordinates whose drift is taken off: forward, upward, pitch, pitch rate.
const DRIFTING: [usize; 4] = [0, 2, 4, 6];
/// Of them those whose mean acceleration is to vanish.
const ACCELERATED: [usize; 3] = [0, 2, 6];
/// Largest step of the pitch, rad, of the pace, and of a command as a share of its range.
const LONGEST: f64 = 0.15;
/// Mean accelerations at which Newton's method takes over: m/s and rad/s per cycle.
const SETTLED: f64 = 0.02;

/// Step of the differences, in rad, of the pace and of commands.
const DIFFERENCE: f64 = 1e-5;

/// A state whose swing has the mean motion of `course` and whose mean accelerations vanish, begun from `point`, whose
/// mean pitch is a guess: the free body flies a cycle, its drift over the cycle is taken off the state at phase 0, the
/// states of air and joints are kept; then Newton steps on the mean accelerations by pitch and two free numbers.
pub(super) fn recoil(
    cycle: &Cycle,
    course: &Course,
    free: &[Free],
    mut point: Point,
) -> Result<Point, Failure> {
    let mut pitch = point.z[OrbitSection::PITCH];
    for _ in 0..SETTLING {
        settle(cycle, course, pitch, &mut point)?;
    }
    for _ in 0..STEPS {
        let drift = drift(cycle, &point)?;
        if drift.iter().all(|d| d.abs() < SETTLED) {
            break;
        }
        let matrix = slopes(cycle, free, &point, drift)?;
        let Some(step) = solve(&matrix, 3, 3, &drift.iter().map(|d| -d).collect::<Vec<_>>()) else { break };
        let range = |f: &Free| match f {
            Free::Frequency => point.pace,
            Free::Inputs(_) => {
                let [low, high] = cycle.described(f).2;
                high - low
            }
        };
        let sizes = [1.0, range(&free[0]), range(&free[1])];
        let longest = step.iter().zip(sizes).map(|(s, size)| s.abs() / size).fold(0.0, f64::max);
        let share = (LONGEST / longest).min(1.0);
        pitch += share * step[0];
        point.z[OrbitSection::PITCH] += share * step[0];
        free.iter().zip(&step[1..]).for_each(|(free, step)| point.moved(free, share * step));
        for _ in 0..AFTER_STEP {
            settle(cycle, course, pitch, &mut point)?;
        }
    }
    Ok(point)
}

/// Growth of forward and upward velocity (m/s) and of the pitch rate (rad/s) over a cycle.
///
/// # Errors
/// The [`Failure`] of a model that cannot be evaluated.
pub fn drift(cycle: &Cycle, point: &Point) -> Result<[f64; 3], Failure> {
    let end = cycle.end(point)?;
    Ok(ACCELERATED.map(|i| end.z[i] - point.z[i]))
}

/// Differences of the drift by pitch and the two free numbers, by rows: a start needs no exact derivatives, and three
/// plain cycles cost a fraction of one that carries them.
fn slopes(cycle: &Cycle, free: &[Free], point: &Point, here: [f64; 3]) -> Result<Vec<f64>, Failure> {
    let mut matrix = vec![0.0; 9];
    for column in 0..3 {
        let mut beside = point.clone();
        match column {
            0 => beside.z[OrbitSection::PITCH] += DIFFERENCE,
            _ => beside.moved(&free[column - 1], DIFFERENCE),
        }
        for (row, (there, here)) in drift(cycle, &beside)?.into_iter().zip(here).enumerate() {
            matrix[3 * row + column] = (there - here) / DIFFERENCE;
        }
    }
    Ok(matrix)
}

/// One cycle: the state at phase 0 gets the swing about the motion asked, at the mean pitch `pitch` (rad), and the states of
/// air and joints at its end.
///
/// # Errors
/// The [`Failure`] of a model that cannot be evaluated.
pub fn settle(cycle: &Cycle, course: &Course, pitch: f64, point: &mut Point) -> Result<(), Failure> {
    let (section, steps) = (cycle.section(), cycle.steps() as f64);
    let mut z = point.z.clone();
    let mut means = [0.0; 4];
    let end = cycle.fly(&point.z, point.pace, &point.inputs, |k, _, x| {
        section.coordinates(x, &mut z);
        // The trapezoidal rule: begin and end count half, and the begin is what the end is without its drift.
        let weight = if k == cycle.steps() { 0.5 } else { 1.0 };
        DRIFTING.iter().zip(&mut means).for_each(|(&i, mean)| *mean += weight * z[i] / steps);
        Ok(())
    })?;
    let asked = [course.speed, course.climb, pitch, 0.0];
    let begin = point.z.clone();
    point.z[OrbitSection::BODY..].copy_from_slice(&end.z[OrbitSection::BODY..]);
    for ((&i, mean), asked) in DRIFTING.iter().zip(means).zip(asked) {
        let mean = mean + 0.5 * begin[i] / steps - 0.5 * (end.z[i] - begin[i]);
        point.z[i] = asked + begin[i] - mean;
    }
    symmetrise(section.symmetric(), &mut point.z);
    Ok(())
}

/// Leaves only what is alike on both sides.
fn symmetrise(symmetric: &[Direction], z: &mut [f64]) {
    let kept: Vec<f64> = symmetric.iter().map(|d| OrbitSection::along(d, z)).collect();
    z.fill(0.0);
    for (direction, value) in symmetric.iter().zip(kept) {
        direction.iter().for_each(|(i, share)| z[*i] += share * value);
    }
}

impl Point {
    /// The point with left and right alike, and the commands of one side for both.
    pub fn alike(mut self, cycle: &Cycle) -> Self {
        symmetrise(cycle.section().symmetric(), &mut self.z);
        if let Ok(mirror) = cycle.robot().pairs() {
            let kept: Vec<f64> = mirror.inputs.iter().map(|&i| self.inputs[i]).collect();
            mirror.expand_inputs(&kept, &mut self.inputs);
        }
        self
    }

    /// The point on the line from `before` through this one, the factor `ahead` on their distance beyond it.
    pub fn beyond(&self, before: &Self, ahead: f64) -> Self {
        let on = |a: f64, b: f64| (1.0 + ahead) * b - ahead * a;
        let line = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| on(*a, *b)).collect();
        Self {
            z: line(&before.z, &self.z),
            pace: on(before.pace, self.pace),
            inputs: line(&before.inputs, &self.inputs),
        }
    }

    /// Moves what is free by `step`.
    pub(super) fn moved(&mut self, free: &Free, step: f64) {
        match free {
            Free::Frequency => self.pace += step,
            Free::Inputs(direction) => {
                direction.iter().for_each(|(i, share)| self.inputs[*i] += share * step)
            }
        }
    }
}
