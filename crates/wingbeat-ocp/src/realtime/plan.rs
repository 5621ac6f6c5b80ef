//! The planned trajectory at its nodes.

use crate::plant::{Channel, Fault, Plant};
use crate::{IntervalEnds, Transcription};
use wingbeat_math::{EqualSteps, RK4, Workspace};

/// Sizes of a horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    /// States of the plant.
    pub states: usize,
    /// Inputs of the plant.
    pub inputs: usize,
    /// Intervals N; the nodes are 0 to N.
    pub intervals: usize,
    /// Length of an interval, s.
    pub step: f64,
}

/// States, inputs and rates at the nodes.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Sizes and step.
    pub horizon: Horizon,
    /// Time of node 0, s.
    pub start: f64,
    /// States, node by node, in the units of their channels.
    pub x: Vec<f64>,
    /// Inputs, node by node, in the units of their channels.
    pub u: Vec<f64>,
    /// Rates f(t_k, x_k, u_k), node by node, in the units of the states per s.
    pub f: Vec<f64>,
}

impl Plan {
    /// A plan of zeros.
    pub fn new(horizon: Horizon) -> Self {
        let nodes = horizon.intervals + 1;
        Self {
            horizon,
            start: 0.0,
            x: vec![0.0; nodes * horizon.states],
            u: vec![0.0; nodes * horizon.inputs],
            f: vec![0.0; nodes * horizon.states],
        }
    }

    /// Number of nodes, one more than intervals.
    pub fn nodes(&self) -> usize {
        self.horizon.intervals + 1
    }

    /// Time of node `k`, s.
    pub fn time(&self, k: usize) -> f64 {
        self.start + k as f64 * self.horizon.step
    }

    /// State at node `k`, in the units of its channels.
    pub fn state(&self, k: usize) -> &[f64] {
        &self.x[k * self.horizon.states..][..self.horizon.states]
    }

    /// The same, to be changed.
    pub fn state_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.x[k * self.horizon.states..][..self.horizon.states]
    }

    /// Input at node `k`, in the units of its channels.
    pub fn input(&self, k: usize) -> &[f64] {
        &self.u[k * self.horizon.inputs..][..self.horizon.inputs]
    }

    /// The same, to be changed.
    pub fn input_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.u[k * self.horizon.inputs..][..self.horizon.inputs]
    }

    /// Rates at node `k`, in the units of the states per s.
    pub fn rates(&self, k: usize) -> &[f64] {
        &self.f[k * self.horizon.states..][..self.horizon.states]
    }

    /// The interval from node `k` to the next.
    pub fn interval(&self, k: usize) -> IntervalEnds<'_, f64> {
        IntervalEnds {
            t: self.time(k),
            h: self.horizon.step,
            x: [self.state(k), self.state(k + 1)],
            u: [self.input(k), self.input(k + 1)],
            f: [self.rates(k), self.rates(k + 1)],
        }
    }

    /// Copies another plan of the same horizon.
    pub fn copy_from(&mut self, other: &Self) {
        self.start = other.start;
        self.x.copy_from_slice(&other.x);
        self.u.copy_from_slice(&other.u);
        self.f.copy_from_slice(&other.f);
    }

    /// Fills the states with `x` and, from node `first` on, the inputs with
    /// zero or the nearest that `channels` allow.
    pub fn rest(&mut self, x: &[f64], channels: &[Channel], first: usize) {
        for k in 0..=self.horizon.intervals {
            self.state_mut(k).copy_from_slice(x);
            if k >= first {
                for (u, channel) in self.input_mut(k).iter_mut().zip(channels) {
                    *u = channel.clamp(0.0);
                }
            }
        }
    }

    /// Evaluates the rates at every node.
    pub fn evaluate_rates<P: Plant>(&mut self, plant: &P) -> Result<(), Fault> {
        let Horizon { states: n, inputs: m, step, .. } = self.horizon;
        let nodes = self.x.chunks_exact(n).zip(self.u.chunks_exact(m)).zip(self.f.chunks_exact_mut(n));
        for (k, ((x, u), f)) in nodes.enumerate() {
            let t = self.start + k as f64 * step;
            plant.rates_in_numbers(t, x, u, f)?;
            check_finite(f, t)?;
        }
        Ok(())
    }

    /// The interval that holds the time `t` and the fraction reached in it.
    fn locate(&self, t: f64) -> (usize, f64) {
        let place = (t - self.start) / self.horizon.step;
        let k = (place.max(0.0) as usize).min(self.horizon.intervals - 1);
        (k, (place - k as f64).clamp(0.0, 1.0))
    }

    /// Writes the interpolated state at the time `t`, held at the ends.
    pub fn state_at(&self, t: f64, x: &mut [f64]) {
        let (k, s) = self.locate(t);
        let interval = self.interval(k);
        for (i, x) in x.iter_mut().enumerate() {
            *x = Transcription::HermiteSimpson.state(&interval, s, i).0;
        }
    }

    /// Writes the interpolated input at the time `t`, held at the ends.
    pub fn input_at(&self, t: f64, u: &mut [f64]) {
        let (k, s) = self.locate(t);
        let interval = self.interval(k);
        for (j, u) in u.iter_mut().enumerate() {
            *u = interval.input(s, j);
        }
    }

    /// Fills this plan with `old` moved on by `dt` in time: interpolated inside,
    /// and beyond its end integrated with the last input held, in Runge-Kutta
    /// steps of at most `substep`, s. Where the model fails the state is held.
    pub fn shift_from<P: Plant>(
        &mut self,
        old: &Self,
        dt: f64,
        plant: &P,
        substep: f64,
        work: &mut Workspace<f64>,
    ) {
        let Horizon { states: n, inputs: m, intervals, .. } = self.horizon;
        self.start = old.start + dt;
        let end = old.time(intervals);
        let mut reached = end;
        for k in 0..=intervals {
            let t = self.time(k);
            old.input_at(t, &mut self.u[k * m..][..m]);
            old.state_at(t, &mut self.x[k * n..][..n]);
            if t > end + 1e-9 * self.horizon.step {
                if reached > end {
                    self.x.copy_within((k - 1) * n..k * n, k * n);
                }
                let (x, u) = (&mut self.x[k * n..][..n], &self.u[k * m..][..m]);
                let steps = ((t - reached) / substep).ceil().max(1.0);
                let steps = EqualSteps::new(reached, (t - reached) / steps, steps as usize);
                let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| plant.rates_in_numbers(t, x, u, dx);
                let stopped = RK4.integrate(&mut rates, steps, x, work).is_err();
                // A component that is not finite stays so whatever is added to it.
                if stopped || x.iter().any(|x| !x.is_finite()) {
                    old.state_at(end, x);
                }
                reached = t;
            }
        }
    }
}

/// Refuses rates that are not finite, at the time `time`, s.
pub fn check_finite(f: &[f64], time: f64) -> Result<(), Fault> {
    match f.iter().position(|f| !f.is_finite()) {
        Some(state) => Err(Fault::NotFinite { state, time }),
        None => Ok(()),
    }
}
