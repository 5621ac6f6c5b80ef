//! The model at the collocation points: values, Jacobians and Hessians.

use super::super::nlp::EvaluationError;
use super::super::problem::{Instant, OptimalControl, Setup};
use super::layout::{StateOf, UnknownLayout};
use crate::plant::Fault;
use wingbeat_math::{Double4, FourDerivatives, Lanes, Scalar, TapeFour};

/// Share of h by which the difference of the ends' rates lifts the middle of
/// the cubic through them.
pub(super) const MIDDLE: f64 = 0.125;

/// Points whose derivatives are taken side by side.
pub(super) type Four = [usize; Double4::WIDTH];

/// Outputs (rates, running cost, path values) of all points, and the derivatives of those of two groups of intervals.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    states: usize,
    inputs: usize,
    path: usize,
    /// Number of outputs and of local unknowns.
    pub outputs: usize,
    pub locals: usize,
    pub values: Vec<f64>,
    /// Points of an interval without its last one, twice: of two groups in turns.
    sets: Vec<FourDerivatives>,
    pub tape: TapeFour,
    local: Vec<f64>,
    recorded: Vec<f64>,
    weights: Vec<f64>,
}

impl Points {
    pub fn new(setup: &Setup, layout: &UnknownLayout) -> Self {
        let (states, inputs, path) = (setup.states.len(), setup.inputs.len(), setup.path.len());
        let (outputs, locals) = (states + 1 + path, 1 + states + inputs + setup.parameters.len());
        let [first, last] = layout.intervals[0].ends;
        Self {
            states,
            inputs,
            path,
            outputs,
            locals,
            values: vec![0.0; layout.points.len() * outputs],
            sets: vec![FourDerivatives::new(outputs, locals); 2 * (last - first)],
            tape: TapeFour::new(outputs, locals),
            local: vec![0.0; locals],
            recorded: vec![0.0; outputs],
            weights: vec![0.0; outputs],
        }
    }

    /// Derivatives at point `j` of the intervals of `group`.
    pub fn set(&self, group: usize, j: usize) -> &FourDerivatives {
        &self.sets[self.place(group, j)]
    }

    fn place(&self, group: usize, j: usize) -> usize {
        group % 2 * (self.sets.len() / 2) + j
    }

    /// Room for derivatives at the last points of the intervals of a group.
    pub fn room(&self) -> FourDerivatives {
        FourDerivatives::new(self.outputs, self.locals)
    }

    /// The derivatives at the first points of the intervals after those of `group`, each in the place of the one before it. The
    /// Hessian counts at the point in the place `last` alone, where there is one.
    pub fn shift(&self, group: usize, last: Option<usize>, out: &mut FourDerivatives) {
        let (own, next) = (self.set(group, 0), self.set(group + 1, 0));
        let shifted = |own: Double4, next: Double4| {
            Double4::of(|lane| if lane + 1 < Double4::WIDTH { own.lane(lane + 1) } else { next.lane(0) })
        };
        for (row, columns) in self.tape.slopes.iter().enumerate() {
            for v in columns.iter().map(|v| row * self.locals + v) {
                out.jacobian[v] = shifted(own.jacobian[v], next.jacobian[v]);
            }
        }
        let Some(last) = last else { return };
        let only = Double4::of(|lane| if lane == last { 1.0 } else { 0.0 });
        for (row, columns) in self.tape.bends.iter().enumerate() {
            for v in columns.iter().map(|v| row * self.locals + v) {
                out.hessian[v] = shifted(own.hessian[v], next.hessian[v]) * only;
            }
        }
    }

    /// Outputs of point `i`.
    pub fn value(&self, i: usize) -> &[f64] {
        &self.values[i * self.outputs..(i + 1) * self.outputs]
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

    /// Output `row` of four points.
    #[inline]
    pub fn four(&self, points: Four, row: usize) -> Double4 {
        Double4::of(|lane| self.values[points[lane] * self.outputs + row])
    }

    /// Jacobians of the points `at`, each point `j` of an interval of `group`, and the Hessians for the `weights` of their
    /// outputs; the values that enter middle states are known.
    pub fn differentiate<P: OptimalControl>(
        &mut self,
        problem: &P,
        layout: &UnknownLayout,
        (group, j): (usize, usize),
        at: Four,
        w: &[f64],
        weights: &[Double4],
    ) -> Result<(), EvaluationError> {
        let (sizes, set) = ((self.states, self.inputs), self.place(group, j));
        self.tape.begin();
        for lane in 0..at.len() {
            if lane > 0 && at[lane] == at[lane - 1] {
                break;
            }
            self.gather(w, layout, at[lane]);
            for (own, weight) in self.weights.iter_mut().zip(weights) {
                *own = weight.lane(lane);
            }
            let outputs = |local: &[_], out: &mut [_]| Self::outputs_at(problem, sizes, local, out);
            self.tape
                .record(&self.local, &mut self.recorded, &self.weights, outputs)
                .map_err(|fault| EvaluationError(fault.to_string()))?;
        }
        self.tape.second_order(weights, &mut self.sets[set]);
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
