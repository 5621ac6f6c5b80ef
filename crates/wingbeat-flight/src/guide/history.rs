//! Commands that were in force.

use crate::simulate::Stepper;
use std::collections::VecDeque;
use wingbeat_ocp::plant::Fault;
use wingbeat_robot::Robot;

/// Integration step of a model between two measurements, s.
pub(super) const STEP: f64 = 5e-4;

/// Commands in force, each with the time from which on, s, the oldest first.
#[derive(Debug, Default)]
pub(super) struct History {
    past: VecDeque<(f64, Vec<f64>)>,
    /// Time of the last update, s.
    last: Option<f64>,
}

impl History {
    /// Notes that `held` was in force from the last update to this one at `t` s.
    pub fn note(&mut self, t: f64, held: &[f64]) {
        if let Some(last) = self.last.replace(t) {
            self.past.push_back((last, held.to_vec()));
        }
    }

    /// Forgets what nobody asks for who starts at `t` s: of the commands before, only the newest still counts.
    pub fn forget(&mut self, t: f64) {
        while self.past.get(1).is_some_and(|(from, _)| *from <= t) {
            self.past.pop_front();
        }
    }

    /// The commands in force from `t` s on, in the units of their channels, and until when (in s), the last of them without
    /// end; `None` where none are known.
    pub fn at(&self, t: f64) -> Option<(&[f64], f64)> {
        let next = self.past.partition_point(|(from, _)| *from <= t).max(1);
        let until = self.past.get(next).map_or(f64::INFINITY, |(from, _)| *from);
        self.past.get(next - 1).map(|(_, commands)| (commands.as_slice(), until))
    }

    /// Flies `model` on to `t` s under the commands that were in force, as far as they are known.
    ///
    /// # Errors
    /// The [`Fault`] that ends it.
    pub fn fly(&self, model: &mut Stepper<&Robot>, t: f64) -> Result<(), Fault> {
        while let Some((commands, until)) = self.at(model.time()) {
            let until = until.min(t);
            let steps = ((until - model.time()) / STEP).ceil();
            if !(steps > 0.0) {
                break;
            }
            let step = (until - model.time()) / steps;
            model.set_inputs(commands);
            (0..steps as usize).try_for_each(|_| model.step(step).map(drop))?;
            // The sum of the steps misses it by rounding.
            model.set_time(until);
        }
        Ok(())
    }
}
