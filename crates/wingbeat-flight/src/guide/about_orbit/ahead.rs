//! The state now from one measured before.

use crate::guide::Told;
use crate::guide::history::History;
use crate::simulate::{Estimator, Measurement, NoEstimate, Stepper};
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::Robot;

/// Takes what is told for the true state when it was measured, and flies the model on from there to now under the commands
/// that were in force: the delay of sensors is part of the model.
pub(super) struct Ahead<'a> {
    told: Told<'a>,
    model: Stepper<&'a Robot>,
    history: History,
}

impl<'a> Ahead<'a> {
    pub fn new(robot: &'a Robot) -> Self {
        let model = Stepper::new(robot, 0.0, &vec![0.0; robot.states().len()]);
        Self { told: Told::new(robot), model, history: History::default() }
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
        self.told.estimate(t, measurement, u, x)?;
        self.history.note(t, u);
        self.history.forget(measurement.taken());
        self.model.reset(measurement.taken(), x);
        self.history.fly(&mut self.model, t)?;
        x.copy_from_slice(self.model.state());
        Ok(())
    }
}
