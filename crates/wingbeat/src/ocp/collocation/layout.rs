//! Where the unknowns and the constraints of a collocated problem are.

use super::super::problem::Setup;
use super::super::scheme::{InputShape, Scheme};
use crate::plant::Channel;

/// A collocation point: its place in time and its unknowns.
#[derive(Clone, Debug)]
pub(super) struct PointPlace {
    /// Fraction of the time span.
    pub sigma: f64,
    /// First state among the unknowns.
    pub x: usize,
    /// First input of two nodes and their shares (the second share may be 0).
    pub u: [(usize, f64); 2],
    /// Quadrature weight of the running cost, per time span.
    pub weight: f64,
    /// First path constraint, if the limits hold here.
    pub path: Option<usize>,
}

/// An interval: its share of the time span and where its rows begin.
#[derive(Clone, Debug)]
pub(super) struct IntervalPlace {
    pub share: f64,
    /// Number of its first point.
    pub point: usize,
    /// First and one past the last of its own unknowns.
    pub columns: [usize; 2],
    /// First defect row.
    pub row: usize,
}

/// The unknowns stage by stage (x, u of a node, then the points inside), then
/// initial time, final time and parameters; the constraints likewise.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub points: Vec<PointPlace>,
    pub intervals: Vec<IntervalPlace>,
    /// Initial time; the final time and the parameters follow.
    pub times: usize,
    /// First constraint on the ends.
    pub ends: usize,
    pub variables: Vec<Channel>,
    pub constraints: Vec<Channel>,
    pub variable_block: Vec<usize>,
    pub constraint_block: Vec<usize>,
}

impl Layout {
    pub fn new(setup: &Setup, scheme: &Scheme, mesh: &[f64], cost_at_nodes: bool) -> Self {
        let mut layout = Self {
            points: Vec::new(),
            intervals: Vec::new(),
            times: 0,
            ends: 0,
            variables: Vec::new(),
            constraints: Vec::new(),
            variable_block: Vec::new(),
            constraint_block: Vec::new(),
        };
        let last = mesh.len() - 1;
        for k in 0..last {
            layout.interval(setup, scheme, mesh, k);
        }
        layout.node(setup, mesh[last], last, Some(1));
        for k in 0..last {
            let next = layout.points[(k + 1) * (scheme.points() - 1)].x;
            layout.intervals[k].columns[1] = next + setup.states.len() + setup.inputs.len();
        }
        if scheme.input == InputShape::Linear {
            layout.blend_inputs(scheme);
        }
        layout.weigh(scheme, cost_at_nodes);
        layout.globals(setup, last);
        layout
    }

    fn variable(&mut self, channel: &Channel, limits: [f64; 2], place: &str, block: usize) {
        let name = format!("{}{place}", channel.name);
        self.variables.push(Channel::limited(name, channel.unit, channel.frame, limits[0], limits[1]));
        self.variable_block.push(block);
    }

    fn constraint(&mut self, name: String, channel: &Channel, limits: [f64; 2], block: usize) {
        self.constraints.push(Channel::limited(name, channel.unit, channel.frame, limits[0], limits[1]));
        self.constraint_block.push(block);
    }

    fn node(&mut self, setup: &Setup, sigma: f64, k: usize, end: Option<usize>) {
        let x = self.variables.len();
        let place = format!("[{k}]");
        for (i, channel) in setup.states.iter().enumerate() {
            self.variable(channel, setup.state_limits(i, end), &place, k);
        }
        self.point(setup, sigma, k, x, &place, true);
    }

    /// The inputs and path constraints of a point whose states begin at `x`.
    fn point(&mut self, setup: &Setup, sigma: f64, k: usize, x: usize, place: &str, limited: bool) {
        let u = self.variables.len();
        let mut path = None;
        if limited {
            for channel in &setup.inputs {
                self.variable(channel, [channel.low, channel.high], place, k);
            }
            path = (!setup.path.is_empty()).then_some(self.constraints.len());
            for channel in &setup.path {
                self.constraint(format!("{}{place}", channel.name), channel, [channel.low, channel.high], k);
            }
        }
        self.points.push(PointPlace { sigma, x, u: [(u, 1.0), (u, 0.0)], weight: 0.0, path });
    }

    fn interval(&mut self, setup: &Setup, scheme: &Scheme, mesh: &[f64], k: usize) {
        let (share, first) = (mesh[k + 1] - mesh[k], self.points.len());
        let start = self.variables.len();
        self.node(setup, mesh[k], k, (k == 0).then_some(0));
        let limited = scheme.input == InputShape::Polynomial;
        for (j, c) in scheme.c.iter().enumerate().take(scheme.points() - 1).skip(1) {
            let (x, place) = (self.variables.len(), format!("[{k}.{j}]"));
            for channel in &setup.states {
                let limits = [channel.low, channel.high];
                let limits = if limited { limits } else { super::super::problem::FREE };
                self.variable(channel, limits, &place, k);
            }
            self.point(setup, mesh[k] + c * share, k, x, &place, limited);
        }
        let row = self.constraints.len();
        for _ in 1..scheme.points() {
            for channel in &setup.states {
                self.constraint(format!("dynamics of {}[{k}]", channel.name), channel, [0.0, 0.0], k);
            }
        }
        self.intervals.push(IntervalPlace { share, point: first, columns: [start, start], row });
    }

    /// Inputs inside an interval as shares of those at its nodes.
    fn blend_inputs(&mut self, scheme: &Scheme) {
        let inner = scheme.points() - 1;
        for k in 0..self.intervals.len() {
            let first = self.intervals[k].point;
            let (u0, u1) = (self.points[first].u[0].0, self.points[first + inner].u[0].0);
            for j in 1..inner {
                self.points[first + j].u = [(u0, 1.0 - scheme.c[j]), (u1, scheme.c[j])];
            }
        }
    }

    fn weigh(&mut self, scheme: &Scheme, cost_at_nodes: bool) {
        let inner = scheme.points() - 1;
        for interval in &self.intervals {
            for (j, w) in scheme.weights().iter().enumerate() {
                let w = match (cost_at_nodes, j == 0 || j == inner) {
                    (true, true) => 0.5,
                    (true, false) => 0.0,
                    (false, _) => *w,
                };
                self.points[interval.point + j].weight += interval.share * w;
            }
        }
    }

    /// Times, parameters and the constraints on the ends.
    fn globals(&mut self, setup: &Setup, last: usize) {
        self.times = self.variables.len();
        for (name, limits) in ["initial time", "final time"].iter().zip(setup.times) {
            self.variable(&Channel::free(*name, "s", ""), limits, "", last);
        }
        for channel in &setup.parameters {
            self.variable(channel, [channel.low, channel.high], "", last);
        }
        self.ends = self.constraints.len();
        for channel in &setup.ends {
            self.constraint(channel.name.clone(), channel, [channel.low, channel.high], last);
        }
    }
}
