//! The state now from one measured before.

use crate::plant::Plant;
use crate::robot::Robot;
use crate::simulate::{Estimator, Measurement, Stepper, TrueState};
use std::collections::VecDeque;

/// Integration step, s.
const STEP: f64 = 5e-4;

/// Takes a measurement for the true state when it was taken, and flies the model on from there to now under the commands
/// that were in force: the delay of sensors is part of the model.
pub(super) struct Ahead<'a> {
    model: Stepper<&'a Robot>,
    /// Commands in force, each with the time from which on, s, the oldest first.
    past: VecDeque<(f64, Vec<f64>)>,
    /// Time of the last update, s.
    last: Option<f64>,
}

impl<'a> Ahead<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        let model = Stepper::new(robot, 0.0, &vec![0.0; robot.states().len()]);
        Self { model, past: VecDeque::new(), last: None }
    }

    /// The state at `t` s, `held` having been in force since the last update; `None` where too little is measured or
    /// the model breaks down on the way.
    pub fn state(&mut self, t: f64, measurement: &Measurement, held: &[f64]) -> Option<&[f64]> {
        let mut x = vec![0.0; self.model.state().len()];
        TrueState.estimate(t, measurement, held, &mut x).ok()?;
        if let Some(last) = self.last.replace(t) {
            self.past.push_back((last, held.to_vec()));
        }
        // Of the commands before the measurement only the newest still counts.
        while self.past.get(1).is_some_and(|(from, _)| *from <= measurement.taken()) {
            self.past.pop_front();
        }
        self.model.reset(measurement.taken(), &x);
        for (k, (_, commands)) in self.past.iter().enumerate() {
            let until = self.past.get(k + 1).map_or(t, |(next, _)| *next);
            let steps = ((until - self.model.time()) / STEP).ceil();
            if steps > 0.0 {
                let step = (until - self.model.time()) / steps;
                self.model.set_inputs(commands);
                (0..steps as usize).try_for_each(|_| self.model.step(step).map(drop)).ok()?;
            }
        }
        Some(self.model.state())
    }
}
