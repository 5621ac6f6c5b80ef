//! A controller, then a planned input, then rest.

use crate::simulate::{Column, Controller, Measurement, Update};
use wingbeat_math::interpolation::lerp;

/// The controller that holds its commands.
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
    /// Inputs at ascending times, two or more, after `approach`.
    pub fn new(approach: C, times: Vec<f64>, inputs: Vec<Vec<f64>>) -> Self {
        Self { approach, times, inputs }
    }
}

impl<C: Controller> Controller for Playback<C> {
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
