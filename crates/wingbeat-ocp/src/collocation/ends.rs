//! The end cost and the constraints on the ends.

use super::super::nlp::EvaluationError;
use super::super::problem::{Ends, OptimalControl, Setup};
use super::layout::UnknownLayout;
use wingbeat_math::{Scalar, Tape};

/// Values and derivatives of the functions of the ends, over their unknowns
/// (t0, tf, x0, xN, p); only the non-zeros are kept.
#[derive(Clone, Debug)]
pub(super) struct EndFunctions {
    states: usize,
    /// Places of the unknowns among those of the program.
    pub columns: Vec<usize>,
    /// Non-zeros (row, local column) of the constraints' Jacobian.
    pub jacobian: Vec<(usize, usize)>,
    /// Non-zeros of the Hessian, lower triangle of local columns.
    pub hessian: Vec<(usize, usize)>,
    /// Cost, then the constraints.
    pub values: Vec<f64>,
    /// d values / d unknowns, row-major.
    pub slopes: Vec<f64>,
    /// Hessian of the weighted values, row-major.
    pub curvature: Vec<f64>,
    tape: Tape,
    local: Vec<f64>,
}

impl EndFunctions {
    /// The functions of `problem`; their non-zeros are found near the unknowns `w`.
    pub fn new<P: OptimalControl>(problem: &P, setup: &Setup, layout: &UnknownLayout, w: &[f64]) -> Self {
        let n = setup.states.len();
        let (first, last) = (layout.nodes[0], layout.nodes[layout.nodes.len() - 1]);
        let mut columns = vec![layout.times, layout.times + 1];
        columns.extend((first..first + n).chain(last..last + n));
        columns.extend(layout.times + 2..layout.times + 2 + setup.parameters.len());
        let (rows, size) = (setup.ends.len() + 1, columns.len());
        let mut ends = Self {
            states: n,
            columns,
            jacobian: Vec::new(),
            hessian: Vec::new(),
            values: vec![0.0; rows],
            slopes: vec![0.0; rows * size],
            curvature: vec![0.0; size * size],
            tape: Tape::default(),
            local: vec![0.0; size],
        };
        ends.find_non_zeros(problem, w);
        ends
    }

    /// Tries a few points around `w` and notes which derivatives appear.
    fn find_non_zeros<P: OptimalControl>(&mut self, problem: &P, w: &[f64]) {
        let (rows, size) = (self.values.len(), self.columns.len());
        let (mut slopes, mut curvature) = (vec![false; rows * size], vec![false; size * size]);
        let weights: Vec<f64> = (0..rows).map(|i| 1.0 + 0.37 * i as f64).collect();
        for trial in 0..3 {
            let mut near = w.to_vec();
            for (k, v) in near.iter_mut().enumerate() {
                *v += 1e-2 * (1.0 + v.abs()) * ((k + 7 * trial) as f64 * 1.7 + 0.3).sin();
            }
            self.differentiate(problem, &near, &weights);
            let mark = |seen: &mut [bool], values: &[f64]| {
                seen.iter_mut().zip(values).for_each(|(s, v)| *s |= *v != 0.0);
            };
            mark(&mut slopes, &self.slopes);
            mark(&mut curvature, &self.curvature);
        }
        let places = |rows: std::ops::Range<usize>| rows.flat_map(|i| (0..size).map(move |j| (i, j)));
        self.jacobian = places(1..rows).filter(|&(i, j)| slopes[i * size + j]).collect();
        self.hessian = places(0..size).filter(|&(i, j)| j <= i && curvature[i * size + j]).collect();
    }

    fn gather(&mut self, w: &[f64]) {
        for (v, &c) in self.local.iter_mut().zip(&self.columns) {
            *v = w[c];
        }
    }

    fn functions<P: OptimalControl, S: Scalar>(problem: &P, n: usize, local: &[S], out: &mut [S]) {
        let (x0, rest) = local[2..].split_at(n);
        let (x1, p) = rest.split_at(n);
        let ends = Ends { t: [local[0], local[1]], x: [x0, x1], p };
        out[0] = problem.end_cost(ends);
        problem.constrain_ends(ends, &mut out[1..]);
    }

    /// Values at the unknowns `w`: cost, then constraints.
    pub fn evaluate<P: OptimalControl>(
        &mut self,
        problem: &P,
        setup: &Setup,
        w: &[f64],
    ) -> Result<(), EvaluationError> {
        self.gather(w);
        Self::functions(problem, self.states, &self.local, &mut self.values);
        let Some(bad) = self.values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
        let what = if bad == 0 { "the end cost" } else { &setup.ends[bad - 1].name };
        Err(EvaluationError(format!("{what} is {}", self.values[bad])))
    }

    /// Slopes and the Hessian of `weights` . (cost, constraints).
    pub fn differentiate<P: OptimalControl>(&mut self, problem: &P, w: &[f64], weights: &[f64]) {
        self.gather(w);
        let n = self.states;
        let recorded = self.tape.record(&self.local, &mut self.values, |local, out| {
            Self::functions(problem, n, local, out);
            Ok::<(), std::convert::Infallible>(())
        });
        let Ok(()) = recorded;
        self.tape.second_order(weights, &mut self.slopes, &mut self.curvature);
    }
}
