//! The model at the collocation points: values, Jacobians and Hessians.

use super::super::nlp::EvaluationError;
use super::super::problem::{Instant, OptimalControl, Setup};
use super::layout::{StateOf, UnknownLayout};
use crate::plant::Fault;
use wingbeat_math::{Scalar, Tape};

/// Share of h by which the difference of the ends' rates lifts the middle of
/// the cubic through them.
pub(super) const MIDDLE: f64 = 0.125;

/// Outputs (rates, running cost, path values) of all points, and the
/// derivatives of those of two intervals along the local unknowns
/// (t, x, u, p).
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    states: usize,
    inputs: usize,
    path: usize,
    /// Number of outputs and of local unknowns.
    pub outputs: usize,
    pub locals: usize,
    pub values: Vec<f64>,
    /// Points with derivatives: point `i` has the place i % room.
    room: usize,
    jacobians: Vec<f64>,
    hessians: Vec<f64>,
    tape: Tape,
    local: Vec<f64>,
}

impl Points {
    pub fn new(setup: &Setup, layout: &UnknownLayout) -> Self {
        let (states, inputs, path) = (setup.states.len(), setup.inputs.len(), setup.path.len());
        let (outputs, locals) = (states + 1 + path, 1 + states + inputs + setup.parameters.len());
        let count = layout.points.len();
        let [first, last] = layout.intervals[0].ends;
        let room = count.min(2 * (last - first) + 1);
        Self {
            room,
            states,
            inputs,
            path,
            outputs,
            locals,
            values: vec![0.0; count * outputs],
            jacobians: vec![0.0; room * outputs * locals],
            hessians: vec![0.0; room * locals * locals],
            tape: Tape::default(),
            local: vec![0.0; locals],
        }
    }

    /// Outputs of point `i`.
    pub fn value(&self, i: usize) -> &[f64] {
        &self.values[i * self.outputs..(i + 1) * self.outputs]
    }

    /// d outputs / d locals of point `i`, row-major.
    pub fn jacobian(&self, i: usize) -> &[f64] {
        let size = self.outputs * self.locals;
        &self.jacobians[i % self.room * size..][..size]
    }

    /// Hessian of the weighted outputs of point `i`, row-major.
    pub fn hessian(&self, i: usize) -> &[f64] {
        let size = self.locals * self.locals;
        &self.hessians[i % self.room * size..][..size]
    }

    /// Gathers the local unknowns of point `i` from the unknowns `w`; a middle
    /// state also from the rates at the nodes.
    fn gather(&mut self, w: &[f64], layout: &UnknownLayout, i: usize) {
        let (n, m, place) = (self.states, self.inputs, &layout.points[i]);
        let times = layout.times;
        self.local[0] = w[times] * (1.0 - place.sigma) + w[times + 1] * place.sigma;
        match place.x {
            StateOf::Unknown(x) => self.local[1..=n].copy_from_slice(&w[x..x + n]),
            StateOf::Middle(k) => self.gather_middle(w, layout, k),
        }
        let [(a, wa), (b, wb)] = place.u;
        for j in 0..m {
            self.local[1 + n + j] = if wb == 0.0 { w[a + j] } else { wa * w[a + j] + wb * w[b + j] };
        }
        self.local[1 + n + m..].copy_from_slice(&w[times + 2..]);
    }

    /// x_c = (x_0 + x_1)/2 + h/8 (f_0 - f_1), as [`Interval::middle`](crate::IntervalEnds::middle).
    fn gather_middle(&mut self, w: &[f64], layout: &UnknownLayout, k: usize) {
        let interval = &layout.intervals[k];
        let [f0, f1] = interval.ends.map(|i| i * self.outputs);
        let [x0, x1] = [layout.nodes[k], layout.nodes[k + 1]];
        let h = interval.share * (w[layout.times + 1] - w[layout.times]);
        for r in 0..self.states {
            let bulge = self.values[f0 + r] - self.values[f1 + r];
            self.local[1 + r] = 0.5 * (w[x0 + r] + w[x1 + r]) + MIDDLE * h * bulge;
        }
    }

    fn outputs_at<P: OptimalControl, S: Scalar>(
        problem: &P,
        (n, m): (usize, usize),
        local: &[S],
        out: &mut [S],
    ) -> Result<(), Fault> {
        let (x, rest) = local[1..].split_at(n);
        let (u, p) = rest.split_at(m);
        let at = Instant { t: local[0], x, u, p };
        let (dx, rest) = out.split_at_mut(n);
        problem.rates(at, dx)?;
        rest[0] = problem.running_cost(at);
        problem.constrain_path(at, &mut rest[1..]);
        Ok(())
    }

    /// Time, state and input of point `i`.
    pub fn at(&mut self, w: &[f64], layout: &UnknownLayout, i: usize) -> (f64, &[f64], &[f64]) {
        self.gather(w, layout, i);
        let (x, rest) = self.local[1..].split_at(self.states);
        (self.local[0], x, &rest[..self.inputs])
    }

    /// Values of all outputs at `points`; those whose state is unknown come
    /// before middle states.
    pub fn evaluate<P: OptimalControl>(
        &mut self,
        problem: &P,
        setup: &Setup,
        layout: &UnknownLayout,
        w: &[f64],
        points: impl Iterator<Item = usize>,
    ) -> Result<(), EvaluationError> {
        let sizes = (self.states, self.inputs);
        for i in points {
            self.gather(w, layout, i);
            let out = &mut self.values[i * self.outputs..(i + 1) * self.outputs];
            Self::outputs_at(problem, sizes, &self.local, out).map_err(|f| EvaluationError(f.to_string()))?;
            if let Some(bad) = out.iter().position(|v| !v.is_finite()) {
                return Err(not_finite(setup, bad, out[bad], self.local[0]));
            }
        }
        Ok(())
    }

    /// Values and Jacobian at point `i`, and the Hessian for the `weights` of its outputs.
    pub fn differentiate<P: OptimalControl>(
        &mut self,
        problem: &P,
        layout: &UnknownLayout,
        i: usize,
        w: &[f64],
        weights: &[f64],
    ) -> Result<(), EvaluationError> {
        let (sizes, outputs, locals) = ((self.states, self.inputs), self.outputs, self.locals);
        self.gather(w, layout, i);
        let out = &mut self.values[i * outputs..(i + 1) * outputs];
        self.tape
            .record(&self.local, out, |local, out| Self::outputs_at(problem, sizes, local, out))
            .map_err(|fault| EvaluationError(fault.to_string()))?;
        let (place, first, second) = (i % self.room, outputs * locals, locals * locals);
        let jacobian = &mut self.jacobians[place * first..][..first];
        let hessian = &mut self.hessians[place * second..][..second];
        self.tape.second_order(weights, jacobian, hessian);
        Ok(())
    }

    pub fn path(&self) -> usize {
        self.path
    }
}

fn not_finite(setup: &Setup, output: usize, value: f64, t: f64) -> EvaluationError {
    let n = setup.states.len();
    let what = match output {
        i if i < n => format!("the rate of {}", setup.states[i].name),
        i if i == n => "the running cost".into(),
        i => setup.path[i - n - 1].name.clone(),
    };
    EvaluationError(format!("{what} is {value} at t = {t:.4} s"))
}
