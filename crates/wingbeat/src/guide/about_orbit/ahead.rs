//! The state now from one measured before.

use crate::guide::history::History;
use crate::plant::Plant;
use crate::robot::Robot;
use crate::simulate::{Estimator, Measurement, NoEstimate, Stepper, TrueState};

/// Integration step, s.
const STEP: f64 = 5e-4;

/// Takes a measurement for the true state when it was taken, and flies the model on from there to now under the commands
/// that were in force: the delay of sensors is part of the model.
pub(super) struct Ahead<'a> {
    model: Stepper<&'a Robot>,
    history: History,
}

impl<'a> Ahead<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        let model = Stepper::new(robot, 0.0, &vec![0.0; robot.states().len()]);
        Self { model, history: History::default() }
    }
}

impl Estimator for Ahead<'_> {
    fn estimate(
        &mut self,
        t: f64,
        measurement: &Measurement,
        u: &[f64],
        x: &mut [f64],
    ) -> Result<(), NoEstimate> {
        TrueState.estimate(t, measurement, u, x)?;
        self.history.note(t, u);
        self.history.forget(measurement.taken());
        self.model.reset(measurement.taken(), x);
        while let Some((commands, until)) = self.history.at(self.model.time()) {
            let until = until.min(t);
            let steps = ((until - self.model.time()) / STEP).ceil();
            if !(steps > 0.0) {
                break;
            }
            let step = (until - self.model.time()) / steps;
            self.model.set_inputs(commands);
            (0..steps as usize).try_for_each(|_| self.model.step(step).map(drop))?;
            // The sum of the steps misses it by rounding.
            self.model.set_time(until);
        }
        x.copy_from_slice(self.model.state());
        Ok(())
    }
}
