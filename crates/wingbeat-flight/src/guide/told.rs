//! The state of a model from the channels that are told by name.

use super::history::History;
use crate::simulate::{Estimator, Measurement, NoEstimate, Stepper};
use wingbeat_ocp::plant::{Channel, Plant};
use wingbeat_robot::Robot;

/// Takes every channel that is told for the model's state of that name. The states of the air are told all or none: where those that
/// are told are not the model's own, name by name and none besides, as with another law or another number of strips, whose states
/// of one name belong to other places, all of the model's follow the model under the commands that were in force.
pub struct Told<'a> {
    robot: &'a Robot,
    model: Stepper<&'a Robot>,
    history: History,
    /// For every state the place of the channel that tells it.
    places: Option<Vec<Option<usize>>>,
    begun: bool,
}

impl<'a> Told<'a> {
    /// For the model `robot`, its air at rest until the first measurement.
    pub fn new(robot: &'a Robot) -> Self {
        let model = Stepper::new(robot, 0.0, &vec![0.0; robot.states().len()]);
        Self { robot, model, history: History::default(), places: None, begun: false }
    }

    fn places(&self, channels: &[Channel]) -> Vec<Option<usize>> {
        let place = |state: &Channel| channels.iter().position(|channel| channel.name == state.name);
        let mut places: Vec<Option<usize>> = self.robot.states().iter().map(place).collect();
        let aero = self.robot.layout().aero;
        let known = places[..aero].iter().flatten().count();
        let own_air =
            places[aero..].iter().all(Option::is_some) && channels.len() == known + places.len() - aero;
        if !own_air {
            places[aero..].fill(None);
        }
        places
    }
}

impl Estimator for Told<'_> {
    fn estimate(
        &mut self,
        t: f64,
        measurement: &Measurement,
        u: &[f64],
        x: &mut [f64],
    ) -> Result<(), NoEstimate> {
        let places = match self.places.take() {
            Some(places) => places,
            None => self.places(measurement.channels()),
        };
        let aero = self.robot.layout().aero;
        let (measured, states) = (places.iter().flatten().count(), x.len());
        let untold = places[..aero].iter().any(Option::is_none);
        let places = &*self.places.insert(places);
        if untold {
            return Err(NoEstimate::Unmeasured { measured, states });
        }
        let tell = |x: &mut [f64]| {
            for (x, place) in x.iter_mut().zip(places) {
                *x = place.map_or(*x, |place| measurement.values()[place]);
            }
        };
        if measured == states {
            tell(x);
            return Ok(());
        }
        let taken = measurement.taken();
        self.history.note(t, u);
        self.history.forget(self.model.time());
        if self.begun {
            self.history.fly(&mut self.model, taken)?;
            x.copy_from_slice(self.model.state());
        } else {
            x.fill(0.0);
            tell(x);
            self.robot.settle(taken, x, u)?;
            self.begun = true;
        }
        tell(x);
        self.model.reset(taken, x);
        Ok(())
    }
}
