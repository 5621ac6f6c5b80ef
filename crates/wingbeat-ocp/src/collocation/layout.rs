//! Where the unknowns and the constraints of a collocated problem are.

use super::super::problem::Setup;
use super::super::scaled::TypicalSizes;
use super::super::scheme::{InputShape, Scheme};
use crate::plant::Channel;

/// Where the state of a collocation point comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum StateOf {
    /// It is unknown; its first component among the unknowns.
    Unknown(usize),
    /// The middle of the cubic through the ends of the interval of this number.
    Middle(usize),
}

/// A collocation point: its place in time and its unknowns.
#[derive(Clone, Debug)]
pub(super) struct PointPlace {
    /// Fraction of the time span.
    pub sigma: f64,
    pub x: StateOf,
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
    /// Its first and last point.
    pub ends: [usize; 2],
    /// First and one past the last of its own unknowns.
    pub columns: [usize; 2],
    /// First defect row.
    pub row: usize,
}

/// The unknowns stage by stage (x, u of a node, then the points inside), then
/// initial time, final time and parameters; the constraints likewise.
#[derive(Clone, Debug)]
pub(super) struct UnknownLayout {
    pub points: Vec<PointPlace>,
    /// First state of each node among the unknowns.
    pub nodes: Vec<usize>,
    pub intervals: Vec<IntervalPlace>,
    /// Initial time; the final time and the parameters follow.
    pub times: usize,
    /// First constraint on the ends.
    pub ends: usize,
    pub variables: Vec<Channel>,
    pub constraints: Vec<Channel>,
    pub variable_block: Vec<usize>,
    pub constraint_block: Vec<usize>,
    /// Typical sizes of variables and constraints.
    pub sizes: TypicalSizes,
}

impl UnknownLayout {
    pub fn new(setup: &Setup, scheme: &Scheme, mesh: &[f64], cost_at_nodes: bool) -> Self {
        let mut layout = Self {
            points: Vec::new(),
            nodes: Vec::new(),
            intervals: Vec::new(),
            times: 0,
            ends: 0,
            variables: Vec::new(),
            constraints: Vec::new(),
            variable_block: Vec::new(),
            constraint_block: Vec::new(),
            sizes: TypicalSizes::default(),
        };
        let last = mesh.len() - 1;
        for k in 0..last {
            layout.interval(setup, scheme, mesh, k);
        }
        layout.node(setup, mesh[last], last, Some(1));
        for k in 0..last {
            layout.intervals[k].columns[1] = layout.nodes[k + 1] + setup.states.len() + setup.inputs.len();
        }
        if scheme.input == InputShape::Linear {
            layout.blend_inputs(scheme);
        }
        layout.weigh(scheme, cost_at_nodes);
        layout.globals(setup, last);
        layout
    }

    /// The points whose state is unknown.
    pub fn unknown_states(&self) -> impl Iterator<Item = usize> {
        (0..self.points.len()).filter(|&i| matches!(self.points[i].x, StateOf::Unknown(_)))
    }

    /// The points whose state follows from the ends of their interval.
    pub fn middle_states(&self) -> impl Iterator<Item = usize> {
        (0..self.points.len()).filter(|&i| matches!(self.points[i].x, StateOf::Middle(_)))
    }

    fn variable(&mut self, (channel, size): (&Channel, f64), limits: [f64; 2], place: &str, block: usize) {
        let name = format!("{}{place}", channel.name);
        self.sizes.variables.push(size);
        self.variables.push(Channel::limited(name, channel.unit, channel.frame, limits[0], limits[1]));
        self.variable_block.push(block);
    }

    fn constraint(&mut self, name: String, (channel, size): (&Channel, f64), limits: [f64; 2], block: usize) {
        self.sizes.constraints.push(size);
        self.constraints.push(Channel::limited(name, channel.unit, channel.frame, limits[0], limits[1]));
        self.constraint_block.push(block);
    }

    fn node(&mut self, setup: &Setup, sigma: f64, k: usize, end: Option<usize>) {
        let x = self.variables.len();
        self.nodes.push(x);
        let place = format!("[{k}]");
        for (i, channel) in setup.states.iter().enumerate() {
            self.variable((channel, setup.scales.state(i)), setup.state_limits(i, end), &place, k);
        }
        self.point(setup, sigma, k, StateOf::Unknown(x), &place, true);
    }

    /// The inputs and path constraints of a point.
    fn point(&mut self, setup: &Setup, sigma: f64, k: usize, x: StateOf, place: &str, limited: bool) {
        let u = self.variables.len();
        let mut path = None;
        if limited {
            for (j, channel) in setup.inputs.iter().enumerate() {
                self.variable((channel, setup.scales.input(j)), [channel.low, channel.high], place, k);
            }
            path = (!setup.path.is_empty()).then_some(self.constraints.len());
            for channel in &setup.path {
                let limits = [channel.low, channel.high];
                self.constraint(format!("{}{place}", channel.name), (channel, 1.0), limits, k);
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
            let (first, place) = (self.variables.len(), format!("[{k}.{j}]"));
            for (i, channel) in setup.states.iter().enumerate().filter(|_| !scheme.compressed) {
                let limits = [channel.low, channel.high];
                let limits = if limited { limits } else { super::super::problem::FREE };
                self.variable((channel, setup.scales.state(i)), limits, &place, k);
            }
            let x = if scheme.compressed { StateOf::Middle(k) } else { StateOf::Unknown(first) };
            self.point(setup, mesh[k] + c * share, k, x, &place, limited);
        }
        let row = self.constraints.len();
        for _ in scheme.defects() {
            for (i, channel) in setup.states.iter().enumerate() {
                let name = format!("dynamics of {}[{k}]", channel.name);
                self.constraint(name, (channel, setup.scales.state(i)), [0.0, 0.0], k);
            }
        }
        let ends = [first, first + scheme.points() - 1];
        self.intervals.push(IntervalPlace { share, ends, columns: [start, start], row });
    }

    /// Inputs inside an interval as shares of those at its nodes.
    fn blend_inputs(&mut self, scheme: &Scheme) {
        let inner = scheme.points() - 1;
        for k in 0..self.intervals.len() {
            let [first, last] = self.intervals[k].ends;
            let (u0, u1) = (self.points[first].u[0].0, self.points[last].u[0].0);
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
                self.points[interval.ends[0] + j].weight += interval.share * w;
            }
        }
    }

    /// Times, parameters and the constraints on the ends.
    fn globals(&mut self, setup: &Setup, last: usize) {
        self.times = self.variables.len();
        for (name, limits) in ["initial time", "final time"].iter().zip(setup.times) {
            self.variable((&Channel::free(*name, "s", ""), 1.0), limits, "", last);
        }
        for (i, channel) in setup.parameters.iter().enumerate() {
            let size = setup.scales.parameter(i);
            self.variable((channel, size), [channel.low, channel.high], "", last);
        }
        self.ends = self.constraints.len();
        for channel in &setup.ends {
            self.constraint(channel.name.clone(), (channel, 1.0), [channel.low, channel.high], last);
        }
    }
}
