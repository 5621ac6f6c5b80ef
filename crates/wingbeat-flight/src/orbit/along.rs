//! Deviations over intervals of a cycle by the derivatives of the rates along a flight that is known.

use super::cycle::{Cycle, Point};
use super::linear::{Deviations, GrownColumns, Interval, alone, begin, clock, fly_part, interval, told};
use wingbeat_math::{EqualSteps, RK4, Workspace, parallel};
use wingbeat_ocp::plant::{Fault, Linearisation};
use wingbeat_robot::Robot;

/// Steps of the flight in the longer step of the two by which the error is told.
const STRETCH: usize = 4;
/// Steps in the other.
const STEP: usize = STRETCH / 2;
/// Largest error over an interval, over the largest derivative by the same deviation or command, up to which this is done. *Choice.*
pub(super) const MOST_ERROR: f64 = 2e-5;
/// Difference of a rule of fourth order to that in steps twice as long over its error: 2^4 - 1.
const GAIN: f64 = 15.0;

/// States of a flight at equal times under held commands, with the derivatives at the last few that were asked for.
struct KnownFlight<'a> {
    robot: &'a Robot,
    u: &'a [f64],
    columns: GrownColumns,
    states: &'a [Vec<f64>],
    /// Number of the first, from the start of the cycle.
    first: usize,
    /// Time between one and the next, s.
    spacing: f64,
    /// Derivatives, each with the place of its state.
    kept: [(Option<usize>, Linearisation); STRETCH + 1],
}

impl<'a> KnownFlight<'a> {
    fn new(
        robot: &'a Robot,
        u: &'a [f64],
        columns: GrownColumns,
        states: &'a [Vec<f64>],
        clock: EqualSteps,
    ) -> Self {
        let kept = std::array::from_fn(|_| (None, Linearisation::new(states[0].len(), u.len())));
        Self { robot, u, columns, states, first: clock.first, spacing: clock.length, kept }
    }

    /// Derivatives at a state.
    fn at(&mut self, place: usize) -> Result<&Linearisation, Fault> {
        let (of, here) = &mut self.kept[place % (STRETCH + 1)];
        if *of != Some(place) {
            let t = (self.first + place) as f64 * self.spacing;
            here.evaluate(self.robot, t, &self.states[place], self.u)?;
            *of = Some(place);
        }
        Ok(here)
    }

    /// Takes the columns `grown` from the state at `place` to that so many `steps` of the flight behind it, an even number, in one step.
    fn grow(
        &mut self,
        place: usize,
        steps: usize,
        grown: &mut [f64],
        work: &mut Workspace<f64>,
    ) -> Result<(), Fault> {
        let length = steps as f64 * self.spacing;
        let slope = |t: f64, grown: &[f64], growth: &mut [f64]| {
            // RK4 asks at either end and between.
            let node = place + (t / self.spacing).round() as usize;
            self.at(node)?;
            let (_, here) = &self.kept[node % (STRETCH + 1)];
            self.columns.growth(here, grown, growth);
            Ok(())
        };
        RK4.step(slope, 0.0, length, grown, work)?;
        self.columns.settle(&self.states[place + steps], 1.0, grown);
        Ok(())
    }

    /// The state and its columns at the end of the flight from those at its start, `x`.
    fn grown(mut self, mut x: Vec<f64>) -> Result<Grown, Fault> {
        let last = self.states.len() - 1;
        let (state, fine) = x.split_at_mut(self.states[0].len());
        let (mut coarse, mut work) = (fine.to_vec(), Workspace::new(fine.len(), RK4.b.len()));
        let mut error = 0.0;
        for place in (0..last).step_by(STRETCH) {
            let end = last.min(place + STRETCH);
            for place in (place..end).step_by(STEP) {
                self.grow(place, STEP, fine, &mut work)?;
            }
            self.grow(place, end - place, &mut coarse, &mut work)?;
            error = difference(fine, &coarse, self.columns.count) / GAIN;
            // Steps half as long gain no more than that.
            if error > MOST_ERROR * GAIN {
                return Ok(Grown::Hopeless);
            }
        }
        if error > MOST_ERROR {
            return Ok(Grown::Off);
        }
        fine.iter_mut().zip(&coarse).for_each(|(fine, coarse)| *fine += (*fine - coarse) / GAIN);
        state.copy_from_slice(&self.states[last]);
        Ok(Grown::To(x))
    }
}

/// How derivatives grow over a known flight.
enum Grown {
    /// The state and its columns at the end.
    To(Vec<f64>),
    /// The error is too large in these steps.
    Off,
    /// It would be in steps half as long too.
    Hopeless,
}

/// Largest difference of two sets of columns by rows, over the largest number of its column in the first.
fn difference(of: &[f64], other: &[f64], columns: usize) -> f64 {
    let (mut largest, mut apart) = (vec![0.0_f64; columns], vec![0.0_f64; columns]);
    for (i, (value, other)) in of.iter().zip(other).enumerate() {
        let column = i % columns;
        largest[column] = largest[column].max(value.abs());
        // One that is no number is further off than any.
        let off = (value - other).abs();
        apart[column] = if off.is_nan() { f64::INFINITY } else { apart[column].max(off) };
    }
    apart
        .iter()
        .zip(&largest)
        .filter(|(off, _)| **off > 0.0)
        .fold(0.0, |most, (off, all)| most.max(off / all))
}

/// As [`intervals`](super::intervals), at a quarter of the cost: a step of Runge and Kutta takes the derivatives alone over two steps of
/// the flight, with those of the rates at its start, its middle and its end. By steps twice as long, which need no more of them, the error
/// is told, and taken off. An interval over which that error is more than 2e-5 of the largest derivative of its column is flown in
/// steps half as long; where that does not do, as of a decay that is too fast for the longer steps, it is differentiated as
/// `intervals` does it.
///
/// Equation: orbit.intervals_along
/// `X' = A X + B U along the states that are flown, by RK4 in two steps at once, X_2, and in four, X_4: X = X_2 + (X_2 - X_4)/15`
/// Source: variational equation; Richardson 1911.
/// Test: `intervals_by_a_known_flight_are_those_of_the_flow`.
///
/// # Errors
/// The [`Fault`] that makes the model unusable on the way.
pub fn intervals_along(
    cycle: &Cycle,
    point: &Point,
    count: usize,
    inputs: &[usize],
) -> Result<Vec<Interval>, Fault> {
    let steps = (cycle.steps() / count).next_multiple_of(STRETCH);
    let cycle = &cycle.in_steps(count, steps);
    let deviations = Deviations::new(cycle);
    let (directions, inputs) = (alone(0..deviations.len()), alone(inputs.iter().copied()));
    let along = [&directions[..], &inputs[..]];
    let mut nominal = vec![0.0; deviations.len()];
    deviations.of(&cycle.start(point), &mut nominal);
    let (held, mut parts) = (&point.inputs[..], Vec::with_capacity(count));
    for k in 0..count {
        let flown = fly(cycle, &deviations, &nominal, point, [k, count])?;
        parts.push((std::mem::replace(&mut nominal, flown.end), flown.states));
    }
    let robot = &cycle.robot().paced(point.pace);
    let grown = |k, (nominal, states): &(Vec<f64>, Vec<Vec<f64>>)| {
        let part = [k, count];
        let known = |cycle: &Cycle, states: &[Vec<f64>]| {
            let columns = GrownColumns::new(robot, held.len(), along);
            let flight = KnownFlight::new(robot, held, columns, states, clock(cycle, point.pace, part));
            flight.grown(begin(&deviations, nominal, along))
        };
        let mut grown = known(cycle, states)?;
        if let Grown::Off = grown {
            let finer = cycle.in_steps(count, 2 * steps);
            grown = known(&finer, &fly(&finer, &deviations, nominal, point, part)?.states)?;
        }
        match grown {
            Grown::To(x) => Ok(told(&deviations, &x, along).1),
            _ => Ok(interval(cycle, &deviations, nominal, (point.pace, held), part, along)?.1),
        }
    };
    parallel::map(&parts, grown).into_iter().collect()
}

/// A flight over a part of a cycle.
struct FlownPart {
    states: Vec<Vec<f64>>,
    /// What deviates at its end.
    end: Vec<f64>,
}

fn fly(
    cycle: &Cycle,
    deviations: &Deviations,
    nominal: &[f64],
    point: &Point,
    part: [usize; 2],
) -> Result<FlownPart, Fault> {
    let mut states = vec![deviations.state(nominal)];
    let keep = &mut |x: &[f64]| states.push(x.to_vec());
    let (end, _) = fly_part(cycle, deviations, nominal, point.pace, &point.inputs, part, keep)?;
    Ok(FlownPart { states, end })
}
