//! Direct collocation: an optimal-control problem as a sparse nonlinear program. Unknowns, functions and multipliers are in the
//! caller's units, those of the problem.

mod assembly;
mod ends;
mod layout;
mod points;

use super::multipliers::Multipliers;
use super::nlp::{Derivatives, EvaluationError, Program, Structure};
use super::problem::{OptimalControl, Setup};
use super::scaled::TypicalSizes;
use super::scheme::Scheme;
use super::trajectory::Trajectory;
use crate::plant::Channel;
use assembly::Assembly;
use ends::EndFunctions;
use layout::{PointPlace, StateOf, UnknownLayout};
use points::{MIDDLE, Points};
use wingbeat_math::{Double4, Lanes, Scalar};

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
    parts: Discretisation,
}

/// What a mesh makes of any problem: where its unknowns and rows are, what the functions of the problem were at the last point, and how
/// the derivatives of the program follow from theirs.
struct Discretisation {
    setup: Setup,
    transcribed: Transcribed,
    layout: UnknownLayout,
    points: Points,
    ends: EndFunctions,
    /// Weights of the outputs in the Lagrangian, per time span.
    weights: Vec<f64>,
    scaled: Vec<Double4>,
    end_weights: Vec<f64>,
    assembly: Assembly,
    gradient: Vec<f64>,
    /// The unknowns at which the outputs of all points are known.
    evaluated: Vec<f64>,
    /// The derivatives taken last are.
    finite: bool,
}

impl<'a, P: OptimalControl> Collocation<'a, P> {
    /// `problem` on the mesh of `transcribed`, which has at least one interval.
    pub fn new(problem: &'a P, transcribed: Transcribed, guess: &Trajectory) -> Self {
        let setup = problem.setup();
        let layout =
            UnknownLayout::new(&setup, &transcribed.scheme, &transcribed.mesh, transcribed.cost_at_nodes);
        let points = Points::new(&setup, &layout);
        let mut parts = Discretisation {
            ends: EndFunctions::new(problem, &setup, &layout, &vec![0.5; layout.variables.len()]),
            weights: vec![0.0; layout.points.len() * points.outputs],
            scaled: vec![Double4::ZERO; points.outputs],
            end_weights: vec![0.0; setup.ends.len() + 1],
            assembly: Assembly::new(&setup, &transcribed.scheme, &layout, points.room()),
            evaluated: Vec::new(),
            finite: false,
            gradient: Vec::new(),
            setup,
            transcribed,
            layout,
            points,
        };
        let w = parts.unknowns(guess);
        parts.ends = EndFunctions::new(problem, &parts.setup, &parts.layout, &w);
        Self { problem, parts }
    }

    /// The unknowns of a trajectory sampled at the collocation points.
    pub fn unknowns(&self, guess: &Trajectory) -> Vec<f64> {
        self.parts.unknowns(guess)
    }

    /// The trajectory of the unknowns `w` at all collocation points; what is
    /// not unknown inside an interval follows the scheme.
    pub fn trajectory(&mut self, w: &[f64]) -> Result<Trajectory, EvaluationError> {
        self.parts.trajectory(self.problem, w)
    }

    /// Typical sizes of the unknowns and of the constraints.
    pub(super) fn sizes(&self) -> TypicalSizes {
        self.parts.layout.sizes.clone()
    }

    /// What the multipliers `y` of the constraints say at the unknowns `w`. The costate in the middle of an interval is the
    /// mean of those at its ends, the sum of its defects' multipliers and that of the last one.
    pub(super) fn multipliers(&self, w: &[f64], y: &[f64], z: &[f64]) -> Multipliers {
        self.parts.multipliers(w, y, z)
    }
}

impl Discretisation {
    fn unknowns(&self, guess: &Trajectory) -> Vec<f64> {
        let layout = &self.layout;
        let mut w = vec![0.0; layout.variables.len()];
        for place in &layout.points {
            let (x, u) = guess.sample(place.sigma);
            if let StateOf::Unknown(first) = place.x {
                w[first..first + x.len()].copy_from_slice(&x);
            }
            if place.u[1].1 == 0.0 {
                w[place.u[0].0..place.u[0].0 + u.len()].copy_from_slice(&u);
            }
        }
        (w[layout.times], w[layout.times + 1]) = (guess.t[0], guess.t[guess.t.len() - 1]);
        w[layout.times + 2..].copy_from_slice(&guess.p);
        w
    }

    fn trajectory<P: OptimalControl>(
        &mut self,
        problem: &P,
        w: &[f64],
    ) -> Result<Trajectory, EvaluationError> {
        let times = self.layout.times;
        let mut out = Trajectory { p: w[times + 2..].to_vec(), ..Trajectory::default() };
        self.evaluated.clear();
        self.points.evaluate(problem, &self.setup, &self.layout, w, self.layout.unknown_states())?;
        for i in 0..self.layout.points.len() {
            let (t, x, u) = self.points.at(w, &self.layout, i);
            out.t.push(t);
            out.x.push(x.to_vec());
            out.u.push(u.to_vec());
        }
        Ok(out)
    }

    fn multipliers(&self, w: &[f64], y: &[f64], z: &[f64]) -> Multipliers {
        let (n, layout) = (self.setup.states.len(), &self.layout);
        let (begin, span) = (w[layout.times], w[layout.times + 1] - w[layout.times]);
        let at = |sigma: f64| begin + span * sigma;
        let mut out = Multipliers {
            ends: y[layout.ends..].to_vec(),
            constants: z[layout.times..].to_vec(),
            defects: vec![Vec::new(); layout.points.len()],
            bounds: layout.points.iter().map(|place| self.limits_at(place, z)).collect(),
            ..Multipliers::default()
        };
        let blocks = self.transcribed.scheme.defects().len();
        for interval in &layout.intervals {
            let [first, last] = interval.ends.map(|i| layout.points[i].sigma);
            out.t.push(at(0.5 * (first + last)));
            let weight = |block: usize| if block + 1 == blocks { 1.0 } else { 0.5 };
            let costate = |i: usize| (0..blocks).map(|b| -weight(b) * y[interval.row + b * n + i]).sum();
            out.costates.push((0..n).map(costate).collect());
            for (block, j) in self.transcribed.scheme.defects().enumerate() {
                out.defects[interval.ends[0] + j] = y[interval.row + block * n..][..n].to_vec();
            }
        }
        for place in &layout.points {
            if let Some(row) = place.path {
                out.path.push((at(place.sigma), y[row..row + self.points.path()].to_vec()));
            }
        }
        out
    }

    /// Multipliers `z` of the limits of the states and inputs of a point, where they are unknowns.
    fn limits_at(&self, place: &PointPlace, z: &[f64]) -> [Vec<f64>; 2] {
        let x = match place.x {
            StateOf::Unknown(first) => z[first..first + self.setup.states.len()].to_vec(),
            StateOf::Middle(_) => Vec::new(),
        };
        let [(first, _), (_, other)] = place.u;
        let own = other == 0.0;
        [x, if own { z[first..first + self.setup.inputs.len()].to_vec() } else { Vec::new() }]
    }

    /// Columns of interval `k`: its own unknowns, then final time, initial time and parameters. The initial time, which is mostly given,
    /// does not come between unknowns.
    fn columns(&self, k: usize) -> Vec<usize> {
        let ([first, end], times) = (self.layout.intervals[k].columns, self.layout.times);
        (first..end).chain([times + 1, times]).chain(times + 2..self.layout.variables.len()).collect()
    }

    /// Final less initial time.
    fn span(&self, w: &[f64]) -> f64 {
        w[self.layout.times + 1] - w[self.layout.times]
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
            for (block, j) in scheme.defects().enumerate() {
                let lambda = &multipliers[interval.row + block * n..][..n];
                for (i, a) in scheme.a[j].iter().enumerate() {
                    let out = &mut self.weights[(interval.ends[0] + i) * outputs..][..n];
                    out.iter_mut().zip(lambda).for_each(|(w, l)| *w -= interval.share * a * l);
                }
            }
        }
    }

    /// Evaluates the functions at all points.
    fn evaluate<P: OptimalControl>(&mut self, problem: &P, w: &[f64]) -> Result<(), EvaluationError> {
        if self.evaluated == w {
            return Ok(());
        }
        self.evaluated.clear();
        let order = self.layout.unknown_states().chain(self.layout.middle_states());
        self.points.evaluate(problem, &self.setup, &self.layout, w, order)?;
        self.evaluated.extend(w);
        Ok(())
    }

    /// Intervals that are assembled side by side.
    fn groups(&self) -> usize {
        self.layout.intervals.len().div_ceil(Double4::WIDTH)
    }

    /// The place among those of `group` of the last interval, if it is there.
    fn last_of(&self, group: usize) -> Option<usize> {
        (group + 1 == self.groups()).then_some((self.layout.intervals.len() - 1) % Double4::WIDTH)
    }

    /// Differentiates the points of the intervals of `group` but for their last ones: the middle states first, whose slopes add to the
    /// weights of the rates at the ends that they follow from. The group after the last one has the last point.
    fn differentiate_group<P: OptimalControl>(
        &mut self,
        problem: &P,
        group: usize,
        w: &[f64],
        multipliers: &[f64],
    ) -> Result<(), EvaluationError> {
        if group == self.groups() {
            // Where the last group has lanes to spare, the last point is there.
            if !self.layout.intervals.len().is_multiple_of(Double4::WIDTH) {
                return Ok(());
            }
            return self.differentiate_points(problem, (group, 0), w, multipliers);
        }
        for middle in [true, false] {
            for j in 0..self.transcribed.scheme.points() - 1 {
                if matches!(self.layout.points[j].x, StateOf::Middle(_)) == middle {
                    self.differentiate_points(problem, (group, j), w, multipliers)?;
                    if middle {
                        self.carry(group, j, self.span(w));
                    }
                }
            }
        }
        Ok(())
    }

    /// The weights of the outputs as they enter the Hessian: the time span
    /// multiplies rates and cost, path values have their own multipliers.
    fn differentiate_points<P: OptimalControl>(
        &mut self,
        problem: &P,
        (group, j): (usize, usize),
        w: &[f64],
        multipliers: &[f64],
    ) -> Result<(), EvaluationError> {
        let (span, at) = (self.span(w), self.four(group, j));
        let (n, outputs) = (self.setup.states.len(), self.points.outputs);
        for row in 0..outputs {
            self.scaled[row] = Double4::of(|lane| match self.layout.points[at[lane]].path {
                _ if row <= n => span * self.weights[at[lane] * outputs + row],
                Some(first) => multipliers[first + row - n - 1],
                None => 0.0,
            });
        }
        self.points.differentiate(problem, &self.layout, (group, j), at, w, &self.scaled)
    }

    /// Weights of the rates at the ends of the intervals of `group` through their middle states.
    fn carry(&mut self, group: usize, j: usize, span: f64) {
        self.weigh_slopes(group, j, None);
        let (n, outputs) = (self.setup.states.len(), self.points.outputs);
        let first = Double4::WIDTH * group;
        for (lane, interval) in self.layout.intervals[first..].iter().take(Double4::WIDTH).enumerate() {
            let [a, b] = interval.ends.map(|end| end * outputs);
            for r in 0..n {
                let change = MIDDLE * span * interval.share * self.assembly.slopes[1 + r].lane(lane);
                self.weights[a + r] += change;
                self.weights[b + r] -= change;
            }
        }
    }

    /// Cost of the changes of the inputs; adds its gradient when wanted.
    fn input_change(&self, w: &[f64], mut gradient: Option<&mut [f64]>) -> f64 {
        let (weight, mut sum) = (self.setup.input_change, 0.0);
        if weight == 0.0 {
            return 0.0;
        }
        for interval in &self.layout.intervals {
            let [a, b] = interval.ends.map(|i| self.layout.points[i].u[0].0);
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

    /// Gradient of the end cost and the changes of the inputs.
    fn begin_gradient(&mut self, w: &[f64]) {
        let mut gradient = std::mem::take(&mut self.gradient);
        gradient.clear();
        gradient.resize(w.len(), 0.0);
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
