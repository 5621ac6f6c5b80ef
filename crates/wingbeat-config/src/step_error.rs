//! What the length of the steps does to a flight, estimated while it is flown.

use wingbeat_flight::simulate::{Sample, Schedule, Stepper, mean_error};
use wingbeat_math::{GRAVITY, Quat, Vec3};
use wingbeat_robot::{Layout, Robot};

/// Instants at which steps are halved, at most. *Choice*: a hundredth of the work of a flight of a second.
const INSTANTS: usize = 100;
/// Of a method of fourth order the error of a step is its distance from two steps of half its length over 1 - 2^-4 (Hairer, Norsett &
/// Wanner 1993, II.4). Near the limit of stability a step of twice the length is far worse than the order says, so none is taken.
const ORDER: f64 = 1.0 - 1.0 / 16.0;

/// Errors of position, velocity and attitude (a rotation in W).
#[derive(Clone, Copy)]
struct Off {
    position: Vec3,
    velocity: Vec3,
    attitude: Vec3,
}

/// Those of the state `wrong` in place of `right`, times a factor.
fn apart(layout: &Layout, [wrong, right]: [&[f64]; 2], factor: f64) -> Off {
    let apart = |at: usize| (Vec3::from_slice(&wrong[at..]) - Vec3::from_slice(&right[at..])) * factor;
    let [from, to] = [right, wrong].map(|x| Quat::from_wxyz(&x[layout.attitude..]));
    let between = to * from.conjugate();
    // Of a unit quaternion the vector is half a small angle; its opposite is the same rotation.
    let twice = if between.w < 0.0 { -2.0 } else { 2.0 };
    Off {
        position: apart(layout.position),
        velocity: apart(layout.velocity),
        attitude: between.v * (twice * factor),
    }
}

/// What the state `wrong` in place of `right` does to the position `left` s later, m.
pub fn reach(layout: &Layout, left: f64, [wrong, right]: [&[f64]; 2]) -> Vec3 {
    reached(&apart(layout, [wrong, right], 1.0), Vec3::from_slice(&right[layout.velocity..]), left)
}

/// An error e of the position moves the position `left` s later by e, that of the velocity by e times the time, that of the attitude by the
/// velocity `flown` and the force m g turned with it, e x v (T - t) + e x g (T - t)^2 / 2: an upper guess, as if the path followed the
/// attitude at once.
fn reached(off: &Off, flown: Vec3, left: f64) -> Vec3 {
    let turned = off.attitude.cross(flown + Vec3::new(0.0, 0.0, GRAVITY) * (0.5 * left));
    off.position + (off.velocity + turned) * left
}

/// The error of a flight that ends at the first of two positions, the other that of the same flight in half steps, m: that of its steps and
/// of all that became of them.
pub fn halved([whole, half]: [Vec3; 2]) -> f64 {
    (whole - half).norm() / ORDER
}

/// Errors that the steps add, per second of flight, and the velocity there.
#[derive(Clone, Copy)]
struct Rate {
    t: f64,
    of: Off,
    flown: Vec3,
}

/// The estimate of a flight.
pub struct StepError<'a> {
    robot: &'a Robot,
    step: f64,
    /// Samples between two looks, and until the next.
    every: usize,
    due: usize,
    rates: Vec<Rate>,
    failed: bool,
}

impl<'a> StepError<'a> {
    /// Of a flight of `robot` by the clock `schedule`.
    pub fn new(robot: &'a Robot, schedule: &Schedule) -> Self {
        let samples = schedule.steps / schedule.steps_per_sample;
        let every = samples.div_ceil(INSTANTS).max(1);
        Self {
            robot,
            step: schedule.step,
            every,
            due: 0,
            rates: Vec::with_capacity(INSTANTS + 1),
            failed: false,
        }
    }

    /// Halves the step from a sample on, if it is due, under its inputs.
    pub fn see(&mut self, sample: &Sample) {
        if self.due == 0 {
            match self.rate(sample) {
                Some(rate) => self.rates.push(rate),
                None => self.failed = true,
            }
            self.due = self.every;
        }
        self.due -= 1;
    }

    fn rate(&self, sample: &Sample) -> Option<Rate> {
        let after = |step: f64, count: usize| {
            let mut stepper = Stepper::new(self.robot, sample.t, sample.x);
            stepper.set_inputs(sample.u);
            (0..count).try_for_each(|_| stepper.step(step)).ok()?;
            Some(stepper.state().to_vec())
        };
        let (short, long) = (after(0.5 * self.step, 2)?, after(self.step, 1)?);
        let layout = self.robot.layout();
        let per_second = 1.0 / (ORDER * self.step);
        let of = apart(layout, [&long, &short], per_second);
        Some(Rate { t: sample.t, of, flown: Vec3::from_slice(&sample.x[layout.velocity..]) })
    }

    /// Most that the errors of steps may do to the position at the time `end`, m, if nothing damps or amplifies them; infinite where a
    /// step cannot be taken, none without samples.
    pub fn at_end(&self, end: f64) -> Option<f64> {
        if self.failed {
            return Some(f64::INFINITY);
        }
        let reach = |rate: &Rate| reached(&rate.of, rate.flown, end - rate.t);
        let all: Vec<Vec3> = self.rates.iter().map(reach).collect();
        mean_error(&all, end)
    }
}
