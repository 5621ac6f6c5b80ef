//! What the length of the steps does to a flight, estimated while it is flown.

use wingbeat_flight::simulate::{Sample, Schedule, Stepper};
use wingbeat_math::{Quat, Vec3};
use wingbeat_robot::Robot;

/// Instants at which steps are halved, at most. *Choice*: a hundredth of the work of a flight of a second.
const INSTANTS: usize = 100;
/// Of a method of fourth order the error of a step is its distance from two steps of half its length over 1 - 2^-4 (Hairer, Norsett &
/// Wanner 1993, II.4). Near the limit of stability a step of twice the length is far worse than the order says, so none is taken.
const ORDER: f64 = 1.0 - 1.0 / 16.0;
/// Standard gravity, m/s2: what an error of the attitude does to the force that carries the robot.
const GRAVITY: f64 = 9.81;
/// Standard errors of the mean over the instants. *Choice.*
const SURE: f64 = 2.0;

/// Errors of position, velocity and attitude (a rotation in W) that the steps add, per second of flight, and the velocity there.
#[derive(Clone, Copy)]
struct Rate {
    t: f64,
    position: Vec3,
    velocity: Vec3,
    attitude: Vec3,
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
        let apart = |at: usize| (Vec3::from_slice(&long[at..]) - Vec3::from_slice(&short[at..])) * per_second;
        let [from, to] = [&short, &long].map(|x| Quat::from_wxyz(&x[layout.attitude..]));
        let between = to * from.conjugate();
        // Of a unit quaternion the vector is half a small angle; its opposite is the same rotation.
        let twice = if between.w < 0.0 { -2.0 } else { 2.0 };
        Some(Rate {
            t: sample.t,
            position: apart(layout.position),
            velocity: apart(layout.velocity),
            attitude: between.v * (twice * per_second),
            flown: Vec3::from_slice(&sample.x[layout.velocity..]),
        })
    }

    /// The error of the position at the time `end`, m; infinite where a step cannot be taken, none without
    /// samples.
    ///
    /// An error e made at t moves the position at T by e, that of the velocity by e (T - t), that of the attitude by the flown velocity v
    /// and the force m g turned with it, e x v (T - t) + e x g (T - t)^2 / 2: an upper guess, as if the path followed the attitude at
    /// once. Errors of one stroke and the next cancel as vectors do; to their sum come two standard errors of what the instants in between
    /// may add.
    pub fn at_end(&self, end: f64) -> Option<f64> {
        if self.failed {
            return Some(f64::INFINITY);
        }
        let up = Vec3::new(0.0, 0.0, GRAVITY);
        let reach = |rate: &Rate| {
            let left = end - rate.t;
            let turned = rate.attitude.cross(rate.flown + up * (0.5 * left));
            rate.position + (rate.velocity + turned) * left
        };
        let count = self.rates.len() as f64;
        let all: Vec<Vec3> = self.rates.iter().map(reach).collect();
        let mean = all.iter().fold(Vec3::ZERO, |sum, of| sum + *of) * (1.0 / count);
        let spread = all.iter().map(|of| (*of - mean).norm().powi(2)).sum::<f64>() / count;
        (!all.is_empty()).then(|| (mean.norm() + SURE * (spread / count).sqrt()) * end)
    }
}
