//! A controller, then a planned input, then rest.

use super::controllers::{ControllerSpec, ControllerTask};
use super::turn::ascending;
use crate::simulate::{AtRest, Column, Controller, Measurement, Update};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_math::interpolation::lerp;
use wingbeat_math::names::one_of;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Error, require};
use wingbeat_ocp::plant::Plant;

/// Commands over time, whatever the robot does: linear between the times, at rest before the first and held after the last.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct CommandsSpec {
    /// Time between updates, s, at which nothing is decided.
    pub period_s: f64,
    /// Times, s, ascending: two or more.
    pub time_s: Vec<f64>,
    /// Commands by the names and in the units of their inputs, one for each time; those of the other inputs are 0.
    pub commands: BTreeMap<String, Vec<f64>>,
}

ranges!(CommandsSpec { period_s: Range::POSITIVE });

impl ControllerSpec for CommandsSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, Error> {
        self.in_range()?;
        require::finite("time_s", &self.time_s)?;
        ascending(&self.time_s)?;
        let (count, channels) = (self.time_s.len(), task.model.inputs());
        let mut inputs = vec![vec![0.0; channels.len()]; count];
        for (name, values) in &self.commands {
            let key = format!("commands.{name}");
            let Some(input) = channels.iter().position(|channel| channel.name == *name) else {
                let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
                return Err(Error::invalid(key, "given", one_of(name, &names)));
            };
            if values.len() != count {
                return Err(Error::invalid(
                    key,
                    format!("{} values", values.len()),
                    format!("{count}, one per time"),
                ));
            }
            require::finite(&key, values)?;
            inputs.iter_mut().zip(values).for_each(|(u, value)| u[input] = *value);
        }
        Ok(Box::new(Playback::new(AtRest, self.time_s.clone(), inputs)))
    }
}

/// The controller that holds its commands, in the units of their channels.
#[derive(Clone, Debug)]
pub struct HeldCommands(pub Vec<f64>);

impl Controller for HeldCommands {
    fn update(&mut self, _: f64, _: &Measurement) -> Update {
        Update::Fresh
    }
    fn input(&self, _: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.0);
    }
}

/// Flies `approach` up to the plan's first time, then the planned inputs,
/// linear between their times; after the last one the regulators hold.
pub struct Playback<C> {
    approach: C,
    times: Vec<f64>,
    inputs: Vec<Vec<f64>>,
}

impl<C: Controller> Playback<C> {
    /// Inputs, in the units of their channels, at two or more ascending times (s), after `approach`.
    pub fn new(approach: C, times: Vec<f64>, inputs: Vec<Vec<f64>>) -> Self {
        Self { approach, times, inputs }
    }
}

impl<C: Controller> Controller for Playback<C> {
    fn prepare(&mut self, t: f64) {
        if t < self.times[0] {
            self.approach.prepare(t);
        }
    }

    fn update(&mut self, t: f64, measurement: &Measurement) -> Update {
        if t < self.times[0] { self.approach.update(t, measurement) } else { Update::Fresh }
    }

    fn input(&self, t: f64, u: &mut [f64]) {
        if t < self.times[0] {
            return self.approach.input(t, u);
        }
        let last = self.times.len() - 1;
        let k = self.times.partition_point(|&v| v <= t).clamp(1, last);
        let share = ((t - self.times[k - 1]) / (self.times[k] - self.times[k - 1])).clamp(0.0, 1.0);
        for (u, (a, b)) in u.iter_mut().zip(self.inputs[k - 1].iter().zip(&self.inputs[k])) {
            *u = lerp(*a, *b, share);
        }
    }

    fn columns(&self) -> Vec<Column> {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::AtRest;

    #[test]
    fn inputs_are_linear_between_their_times_and_held_after() {
        let player = Playback::new(AtRest, vec![1.0, 2.0, 4.0], vec![vec![0.5], vec![1.5], vec![-0.5]]);
        let at = |t| {
            let mut u = [9.0];
            player.input(t, &mut u);
            u[0]
        };
        assert_eq!([at(0.5), at(1.0), at(1.5), at(3.0), at(7.0)], [0.0, 0.5, 1.0, 0.5, -0.5]);
    }
}
