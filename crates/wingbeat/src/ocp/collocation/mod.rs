//! Direct collocation: an optimal-control problem as a sparse nonlinear program.

mod ends;
mod layout;
mod points;

use super::nlp::{Derivatives, EvaluationError, Program, Structure};
use super::problem::{OptimalControl, Setup};
use super::scheme::Scheme;
use super::trajectory::Trajectory;
use crate::plant::Channel;
use ends::EndFunctions;
use layout::Layout;
use points::Points;

/// How a problem is collocated.
#[derive(Clone, Debug)]
pub struct Transcribed {
    /// Points, weights and defects.
    pub scheme: Scheme,
    /// Nodes as fractions of the time span, from 0 to 1.
    pub mesh: Vec<f64>,
    /// Sum the running cost over the nodes by the trapezoid rule, not by the
    /// scheme's own quadrature.
    pub cost_at_nodes: bool,
}

impl Transcribed {
    /// `intervals` equal intervals of a scheme.
    pub fn uniform(scheme: Scheme, intervals: usize) -> Self {
        let mesh = (0..=intervals).map(|k| k as f64 / intervals as f64).collect();
        Self { scheme, mesh, cost_at_nodes: false }
    }
}

/// A problem on a mesh: minimise the end cost plus the quadrature of the
/// running cost, with the defects as equations.
pub struct Collocation<'a, P> {
    problem: &'a P,
    setup: Setup,
    pub(super) transcribed: Transcribed,
    layout: Layout,
    points: Points,
    ends: EndFunctions,
    /// Weights of the outputs in the Lagrangian, per time span.
    weights: Vec<f64>,
    scaled: Vec<f64>,
    end_weights: Vec<f64>,
    rows: Vec<f64>,
    block: Vec<f64>,
    gradient: Vec<f64>,
}

impl<'a, P: OptimalControl> Collocation<'a, P> {
    /// `problem` on the mesh of `transcribed`, which has at least one interval.
    pub fn new(problem: &'a P, transcribed: Transcribed, guess: &Trajectory) -> Self {
        let setup = problem.setup();
        let layout = Layout::new(&setup, &transcribed.scheme, &transcribed.mesh, transcribed.cost_at_nodes);
        let points = Points::new(&setup, &layout);
        let mut collocation = Self {
            problem,
            ends: EndFunctions::new(problem, &setup, &layout, &vec![0.5; layout.variables.len()]),
            weights: vec![0.0; layout.points.len() * points.outputs],
            scaled: vec![0.0; layout.points.len() * points.outputs],
            end_weights: vec![0.0; setup.ends.len() + 1],
            rows: Vec::new(),
            block: Vec::new(),
            gradient: Vec::new(),
            setup,
            transcribed,
            layout,
            points,
        };
        let w = collocation.unknowns(guess);
        collocation.ends = EndFunctions::new(problem, &collocation.setup, &collocation.layout, &w);
        collocation
    }

    /// The unknowns of a trajectory sampled at the collocation points.
    pub fn unknowns(&self, guess: &Trajectory) -> Vec<f64> {
        let layout = &self.layout;
        let mut w = vec![0.0; layout.variables.len()];
        for place in &layout.points {
            let (x, u) = guess.sample(place.sigma);
            w[place.x..place.x + x.len()].copy_from_slice(&x);
            if place.u[1].1 == 0.0 {
                w[place.u[0].0..place.u[0].0 + u.len()].copy_from_slice(&u);
            }
        }
        (w[layout.times], w[layout.times + 1]) = (guess.t[0], guess.t[guess.t.len() - 1]);
        w[layout.times + 2..].copy_from_slice(&guess.p);
        w
    }

    /// The trajectory of the unknowns `w` at all collocation points; inputs
    /// inside an interval follow the scheme.
    pub fn trajectory(&self, w: &[f64]) -> Trajectory {
        let (n, m, times) = (self.setup.states.len(), self.setup.inputs.len(), self.layout.times);
        let mut out = Trajectory { p: w[times + 2..].to_vec(), ..Trajectory::default() };
        for place in &self.layout.points {
            let [(a, wa), (b, wb)] = place.u;
            out.t.push(w[times] + place.sigma * (w[times + 1] - w[times]));
            out.x.push(w[place.x..place.x + n].to_vec());
            let blend = |j| if wb == 0.0 { w[a + j] } else { wa * w[a + j] + wb * w[b + j] };
            out.u.push((0..m).map(blend).collect());
        }
        out
    }

    /// Columns of interval `k`: its own unknowns, then times and parameters.
    fn columns(&self, k: usize) -> Vec<usize> {
        let [first, end] = self.layout.intervals[k].columns;
        (first..end).chain(self.layout.times..self.layout.variables.len()).collect()
    }

    /// Local unknowns of point `i` as (column of interval `k`, share) pairs.
    fn local_map(&self, i: usize, k: usize) -> Vec<[(usize, f64); 2]> {
        let (place, [first, end]) = (&self.layout.points[i], self.layout.intervals[k].columns);
        let (n, m, own) = (self.setup.states.len(), self.setup.inputs.len(), end - first);
        let mut map = vec![[(own, 1.0 - place.sigma), (own + 1, place.sigma)]];
        map.extend((0..n).map(|r| [(place.x + r - first, 1.0), (0, 0.0)]));
        let [(a, wa), (b, wb)] = place.u;
        map.extend((0..m).map(|j| [(a + j - first, wa), (b + j - first, wb)]));
        map.extend((0..self.setup.parameters.len()).map(|q| [(own + 2 + q, 1.0), (0, 0.0)]));
        map
    }

    /// Points whose Hessian and path rows belong to interval `k`.
    fn owned(&self, k: usize) -> std::ops::Range<usize> {
        let inner = self.transcribed.scheme.points() - 1;
        let first = self.layout.intervals[k].point;
        first..first + inner + usize::from(k + 1 == self.layout.intervals.len())
    }

    /// Weights of the outputs in the Lagrangian per time span: -A' lambda for
    /// the rates, the quadrature for the running cost.
    fn weigh(&mut self, weight: f64, multipliers: &[f64]) {
        let (n, outputs) = (self.setup.states.len(), self.points.outputs);
        let scheme = &self.transcribed.scheme;
        self.weights.fill(0.0);
        for (i, place) in self.layout.points.iter().enumerate() {
            self.weights[i * outputs + n] = weight * place.weight;
        }
        for interval in &self.layout.intervals {
            for j in 1..scheme.points() {
                let lambda = &multipliers[interval.row + (j - 1) * n..][..n];
                for (i, a) in scheme.a[j].iter().enumerate() {
                    let out = &mut self.weights[(interval.point + i) * outputs..][..n];
                    out.iter_mut().zip(lambda).for_each(|(w, l)| *w -= interval.share * a * l);
                }
            }
        }
    }

    /// Jacobian rows of the defects of interval `k`, dense over its columns.
    fn defect_rows(&mut self, k: usize, span: f64) {
        let (n, scheme) = (self.setup.states.len(), &self.transcribed.scheme);
        let interval = &self.layout.intervals[k];
        let width = interval.columns[1] - interval.columns[0] + 2 + self.setup.parameters.len();
        let own = interval.columns[1] - interval.columns[0];
        let mut rows = std::mem::take(&mut self.rows);
        rows.clear();
        rows.resize((scheme.points() - 1) * n * width, 0.0);
        let first = self.layout.points[interval.point].x - interval.columns[0];
        for j in 1..scheme.points() {
            let x = self.layout.points[interval.point + j].x - interval.columns[0];
            for r in 0..n {
                let row = ((j - 1) * n + r) * width;
                rows[row + x + r] += 1.0;
                rows[row + first + r] -= 1.0;
            }
        }
        for i in 0..scheme.points() {
            let map = self.local_map(interval.point + i, k);
            let (f, jacobian) =
                (self.points.value(interval.point + i), self.points.jacobian(interval.point + i));
            for j in 1..scheme.points() {
                let factor = interval.share * scheme.a[j][i];
                for r in 0..n {
                    let row = &mut rows[((j - 1) * n + r) * width..][..width];
                    for (v, slope) in map.iter().zip(&jacobian[r * map.len()..]) {
                        v.iter().for_each(|&(c, share)| row[c] -= factor * span * slope * share);
                    }
                    row[own] += factor * f[r];
                    row[own + 1] -= factor * f[r];
                }
            }
        }
        self.rows = rows;
    }

    /// Hessian of the Lagrangian's part of interval `k`, dense over its columns.
    fn hessian_block(&mut self, k: usize, weight: f64) {
        let (n, locals, outputs) = (self.setup.states.len(), self.points.locals, self.points.outputs);
        let interval = &self.layout.intervals[k];
        let own = interval.columns[1] - interval.columns[0];
        let width = own + 2 + self.setup.parameters.len();
        let mut block = std::mem::take(&mut self.block);
        block.clear();
        block.resize(width * width, 0.0);
        for i in self.owned(k) {
            let map = self.local_map(i, k);
            let (hessian, jacobian) = (self.points.hessian(i), self.points.jacobian(i));
            for (a, row) in map.iter().zip(hessian.chunks_exact(locals)) {
                for (b, h) in map.iter().zip(row).filter(|(_, h)| **h != 0.0) {
                    for &(ca, sa) in a {
                        b.iter().for_each(|&(cb, sb)| block[ca * width + cb] += sa * sb * h);
                    }
                }
            }
            // Products of the time span with the slopes of the weighted outputs.
            let weights = &self.weights[i * outputs..][..=n];
            for (v, a) in map.iter().enumerate() {
                let slope: f64 = (0..=n).map(|r| weights[r] * jacobian[r * locals + v]).sum();
                for &(c, share) in a {
                    for (time, sign) in [(own, -1.0), (own + 1, 1.0)] {
                        block[c * width + time] += sign * share * slope;
                        block[time * width + c] += sign * share * slope;
                    }
                }
            }
        }
        let change = 2.0 * weight * self.setup.input_change;
        if change != 0.0 {
            let inner = self.transcribed.scheme.points() - 1;
            let node = |i: usize| self.layout.points[i].u[0].0 - interval.columns[0];
            let (a, b) = (node(interval.point), node(interval.point + inner));
            for j in 0..self.setup.inputs.len() {
                for (p, q, v) in [(a, a, change), (b, b, change), (a, b, -change), (b, a, -change)] {
                    block[(p + j) * width + q + j] += v;
                }
            }
        }
        self.block = block;
    }

    /// Cost of the changes of the inputs; adds its gradient when wanted.
    fn input_change(&self, w: &[f64], mut gradient: Option<&mut [f64]>) -> f64 {
        let (weight, mut sum) = (self.setup.input_change, 0.0);
        if weight == 0.0 {
            return 0.0;
        }
        let inner = self.transcribed.scheme.points() - 1;
        for interval in &self.layout.intervals {
            let node = |i: usize| self.layout.points[i].u[0].0;
            let (a, b) = (node(interval.point), node(interval.point + inner));
            for j in 0..self.setup.inputs.len() {
                let change = w[b + j] - w[a + j];
                sum += weight * change * change;
                if let Some(gradient) = gradient.as_deref_mut() {
                    gradient[b + j] += 2.0 * weight * change;
                    gradient[a + j] -= 2.0 * weight * change;
                }
            }
        }
        sum
    }

    /// Gradient of the objective at the differentiated point.
    fn objective_gradient(&mut self, w: &[f64]) {
        let (n, times) = (self.setup.states.len(), self.layout.times);
        let span = w[times + 1] - w[times];
        let mut gradient = std::mem::take(&mut self.gradient);
        gradient.clear();
        gradient.resize(w.len(), 0.0);
        for k in 0..self.layout.intervals.len() {
            let first = self.layout.intervals[k].columns[0];
            let own = self.layout.intervals[k].columns[1] - first;
            for i in self.owned(k) {
                let weight = self.layout.points[i].weight;
                let slopes = &self.points.jacobian(i)[n * self.points.locals..];
                for (v, slope) in self.local_map(i, k).iter().zip(slopes) {
                    for &(c, share) in v {
                        let column = if c < own { first + c } else { times + c - own };
                        gradient[column] += weight * span * slope * share;
                    }
                }
                let cost = weight * self.points.value(i)[n];
                gradient[times + 1] += cost;
                gradient[times] -= cost;
            }
        }
        for (slope, &c) in self.ends.slopes.iter().zip(&self.ends.columns) {
            gradient[c] += slope;
        }
        self.input_change(w, Some(&mut gradient));
        self.gradient = gradient;
    }
}

mod program;

#[cfg(test)]
mod tests;
