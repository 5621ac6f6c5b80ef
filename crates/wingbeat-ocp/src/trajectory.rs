//! Sampled trajectories: guesses and solutions.

use wingbeat_math::interpolation::lerp;

/// Times, states, inputs and parameters; a guess, or a solution at its nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// Times, s, ascending.
    pub t: Vec<f64>,
    /// States, one vector per time, in the units of their channels.
    pub x: Vec<Vec<f64>>,
    /// Inputs, one vector per time, in the units of their channels.
    pub u: Vec<Vec<f64>>,
    /// Parameters, in their own units.
    pub p: Vec<f64>,
}

impl Trajectory {
    /// State and input, in the units of their channels, at the fraction `s` in [0, 1] of the time span, linear between samples.
    pub fn sample(&self, s: f64) -> (Vec<f64>, Vec<f64>) {
        let last = self.t.len() - 1;
        if last == 0 {
            return (self.x[0].clone(), self.u[0].clone());
        }
        let t = lerp(self.t[0], self.t[last], s);
        let k = self.t.partition_point(|&v| v <= t).clamp(1, last) - 1;
        let share = ((t - self.t[k]) / (self.t[k + 1] - self.t[k])).clamp(0.0, 1.0);
        let mix = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(&a, &b)| lerp(a, b, share)).collect();
        (mix(&self.x[k], &self.x[k + 1]), mix(&self.u[k], &self.u[k + 1]))
    }

    /// What makes the trajectory useless as a guess for `states` states and
    /// `inputs` inputs, if anything.
    pub(super) fn fault(&self, states: usize, inputs: usize) -> Option<String> {
        let sizes = self.x.len() == self.t.len() && self.u.len() == self.t.len() && !self.t.is_empty();
        let widths = self.x.iter().all(|x| x.len() == states) && self.u.iter().all(|u| u.len() == inputs);
        if !sizes || !widths {
            return Some(format!("the guess must hold {states} states and {inputs} inputs at every time"));
        }
        let numbers = self.x.iter().chain(&self.u).flatten().chain(&self.t);
        if numbers.into_iter().any(|v| !v.is_finite()) {
            return Some("the guess holds a value that is not finite".into());
        }
        None
    }
}
