//! What the length of the steps does to a flight, estimated while it is flown.

use wingbeat_flight::simulate::{Sample, Schedule, Stepper};
use wingbeat_math::Vec3;
use wingbeat_robot::Robot;

/// Instants at which steps are doubled, at most. *Choice*: a hundredth of the work of a flight of a second.
const INSTANTS: usize = 100;
/// Step doubling of a method of fourth order: the error of the two short steps is their distance from the long one
/// over 2^4 - 1 (Hairer, Norsett & Wanner 1993, II.4).
const ORDER: f64 = 15.0;
/// Standard gravity, m/s2: what an error of the attitude does to the force that carries the robot.
const GRAVITY: f64 = 9.81;

/// Errors of position, velocity and attitude that the steps add, per second of flight.
#[derive(Clone, Copy, Default)]
struct Rate {
    t: f64,
    position: f64,
    velocity: f64,
    attitude: f64,
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

    /// Doubles the steps from a sample on, if it is due, under its inputs.
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
        let (short, long) = (after(self.step, 2)?, after(2.0 * self.step, 1)?);
        let layout = self.robot.layout();
        let distance = |at: usize| (Vec3::from_slice(&short[at..]) - Vec3::from_slice(&long[at..])).norm();
        // Half the angle of the small rotation between two unit quaternions is their distance.
        let turn =
            short[layout.attitude..][..4].iter().zip(&long[layout.attitude..]).map(|(a, b)| (a - b).powi(2));
        let per_second = 1.0 / (ORDER * 2.0 * self.step);
        Some(Rate {
            t: sample.t,
            position: per_second * distance(layout.position),
            velocity: per_second * distance(layout.velocity),
            attitude: per_second * 2.0 * turn.sum::<f64>().sqrt(),
        })
    }

    /// The error of the position at the time `end`, m; infinite where twice the step cannot be taken, none without
    /// samples.
    ///
    /// An error e made at t moves the position at T by e, that of the velocity by e (T - t), that of the attitude by
    /// g e (T - t)^2 / 2.
    pub fn at_end(&self, end: f64) -> Option<f64> {
        if self.failed {
            return Some(f64::INFINITY);
        }
        let reach = |rate: &Rate| {
            let left = end - rate.t;
            rate.position + rate.velocity * left + 0.5 * GRAVITY * rate.attitude * left * left
        };
        let sum: f64 = self.rates.iter().map(reach).sum();
        (!self.rates.is_empty()).then(|| sum / self.rates.len() as f64 * end)
    }
}
