//! Optimal-control problems: min end cost + integral of the running cost,
//! subject to dynamics, limits, path and end constraints, with free times and
//! parameters.

use crate::plant::{Channel, Fault};
use wingbeat_math::Scalar;

/// Lowest and highest value allowed; equal ones fix the value.
pub type Limits = [f64; 2];

/// No limits: infinite in the unit of any channel.
pub const FREE: Limits = [f64::NEG_INFINITY, f64::INFINITY];

/// Time, state, input and parameters at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Instant<'a, S> {
    /// Time, s.
    pub t: S,
    /// State.
    pub x: &'a [S],
    /// Input.
    pub u: &'a [S],
    /// Parameters.
    pub p: &'a [S],
}

/// Times and states at both ends, and the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Ends<'a, S> {
    /// Initial and final time, s.
    pub t: [S; 2],
    /// Initial and final state.
    pub x: [&'a [S]; 2],
    /// Parameters.
    pub p: &'a [S],
}

/// The numbers of a problem: what there is, by name, and its limits, which are in the units of their channels, times in s.
///
/// In the paper's stacked decision vector [Y, Omega, t_f] the states at the
/// nodes are Y, the inputs Omega; its boundary conditions r_i are `start`,
/// `end` and `ends` with equal limits, its stroke inequalities g_i the limits
/// of the inputs and states.
#[derive(Clone, Debug, Default)]
pub struct Setup {
    /// States with the limits they keep at all times.
    pub states: Vec<Channel>,
    /// Inputs with their limits.
    pub inputs: Vec<Channel>,
    /// Constant unknowns with their limits.
    pub parameters: Vec<Channel>,
    /// Limits of the initial and of the final time, s.
    pub times: [Limits; 2],
    /// Limits of the initial state; empty when only `states` limits it.
    pub start: Vec<Limits>,
    /// Limits of the final state; empty when only `states` limits it.
    pub end: Vec<Limits>,
    /// Path constraints with the limits of their values.
    pub path: Vec<Channel>,
    /// Constraints on the ends with the limits of their values.
    pub ends: Vec<Channel>,
    /// Weight of the squared change of the inputs from node to node.
    pub input_change: f64,
    /// Typical sizes of what the problem holds.
    pub scales: Scales,
}

/// Typical sizes of states, inputs and parameters, in their units. The solver counts in them, and errors are relative to
/// them; an empty list is one each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scales {
    /// Of the states, in the units of their channels.
    pub states: Vec<f64>,
    /// Of the inputs, in the units of their channels.
    pub inputs: Vec<f64>,
    /// Of the parameters, in their own units.
    pub parameters: Vec<f64>,
}

impl Scales {
    /// Size of the state `i`, in its unit.
    pub fn state(&self, i: usize) -> f64 {
        self.states.get(i).copied().unwrap_or(1.0)
    }
    /// Size of the input `i`, in its unit.
    pub fn input(&self, i: usize) -> f64 {
        self.inputs.get(i).copied().unwrap_or(1.0)
    }
    /// Size of the parameter `i`, in its unit.
    pub fn parameter(&self, i: usize) -> f64 {
        self.parameters.get(i).copied().unwrap_or(1.0)
    }
    /// True when every size is one.
    pub fn is_unit(&self) -> bool {
        [&self.states, &self.inputs, &self.parameters]
            .iter()
            .all(|sizes| sizes.iter().all(|size| *size == 1.0))
    }

    /// What is wrong with the sizes for these numbers of states, inputs and parameters.
    pub(super) fn fault(&self, counts: [usize; 3]) -> Option<String> {
        let lists = [("states", &self.states), ("inputs", &self.inputs), ("parameters", &self.parameters)];
        for ((name, sizes), count) in lists.into_iter().zip(counts) {
            if !sizes.is_empty() && sizes.len() != count {
                return Some(format!("scales of {name}: {} given for {count}", sizes.len()));
            }
            if let Some(size) = sizes.iter().find(|size| !(**size > 0.0 && size.is_finite())) {
                return Some(format!("scales of {name}: {size}; allowed are finite numbers above 0"));
            }
        }
        None
    }
}

/// An optimal-control problem; its functions are written once over any scalar. Costs and constraints are in the caller's units.
pub trait OptimalControl {
    /// Channels and limits.
    fn setup(&self) -> Setup;
    /// Writes dx/dt.
    fn rates<S: Scalar>(&self, at: Instant<S>, dx: &mut [S]) -> Result<(), Fault>;
    /// Cost per second (Lagrange term).
    fn running_cost<S: Scalar>(&self, _at: Instant<S>) -> S {
        S::ZERO
    }
    /// Writes the values of the path constraints.
    fn constrain_path<S: Scalar>(&self, _at: Instant<S>, _values: &mut [S]) {}
    /// Cost of the ends (Mayer term).
    fn end_cost<S: Scalar>(&self, _ends: Ends<S>) -> S {
        S::ZERO
    }
    /// Writes the values of the constraints on the ends.
    fn constrain_ends<S: Scalar>(&self, _ends: Ends<S>, _values: &mut [S]) {}
}

impl Setup {
    /// States, inputs and times alone; fixed initial time 0; the final one in s.
    pub fn new(states: Vec<Channel>, inputs: Vec<Channel>, final_time: Limits) -> Self {
        Self { states, inputs, times: [[0.0, 0.0], final_time], ..Self::default() }
    }

    /// The same with limits of the initial and of the final state, in the units of the states.
    pub fn between(mut self, start: &[Limits], end: &[Limits]) -> Self {
        (self.start, self.end) = (start.to_vec(), end.to_vec());
        self
    }

    /// Limits of state `i` at a node: the first (0), the last (1) or between.
    pub(super) fn state_limits(&self, i: usize, end: Option<usize>) -> Limits {
        let own = [self.states[i].low, self.states[i].high];
        let special = match end {
            Some(0) => self.start.get(i),
            Some(_) => self.end.get(i),
            None => None,
        };
        let Some(&[low, high]) = special else { return own };
        if low == high { [low, high] } else { [low.max(own[0]), high.min(own[1])] }
    }

    /// The straight line: states linear between the middles of their end
    /// limits, inputs in the middle of theirs or zero, times in the middle.
    pub fn straight_line(&self) -> super::Trajectory {
        let [t0, t1] = self.times.map(middle);
        let end = |k: usize| -> Vec<f64> {
            (0..self.states.len()).map(|i| middle(self.state_limits(i, Some(k)))).collect()
        };
        let inputs: Vec<f64> = self.inputs.iter().map(|c| middle([c.low, c.high])).collect();
        let (mut first, mut last) = (end(0), end(1));
        for i in 0..first.len() {
            // An end that is free follows the other.
            let free = |k: usize| self.state_limits(i, Some(k)) == FREE;
            match (free(0), free(1)) {
                (true, false) => first[i] = last[i],
                (false, true) => last[i] = first[i],
                _ => {}
            }
        }
        super::Trajectory {
            t: vec![t0, if t1 > t0 { t1 } else { t0 + 1.0 }],
            x: vec![first, last],
            u: vec![inputs.clone(), inputs],
            p: self.parameters.iter().map(|c| middle([c.low, c.high])).collect(),
        }
    }
}

/// A value inside the limits: their middle, the finite one, or zero.
fn middle([low, high]: Limits) -> f64 {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => 0.5 * (low + high),
        (true, false) => low.max(0.0),
        (false, true) => high.min(0.0),
        (false, false) => 0.0,
    }
}
