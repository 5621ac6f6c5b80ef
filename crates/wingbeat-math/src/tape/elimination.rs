//! The order in which operations are eliminated, and the sums of products that this takes.

use super::traced::FIELDS;
use super::{Double4, FIRST, NONE, ONE, Scalar, ZERO};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// A derivative (output, input) or (input, input) and its place among the numbers.
pub(super) type TapeEntry = ((usize, usize), u32);

/// The derivatives of recorded operations as a list of sums of products of numbers.
#[derive(Clone, Debug)]
pub(super) struct TapeElimination {
    shape: Vec<u32>,
    ends: Vec<[u32; 2]>,
    inputs: usize,
    /// Number `first + k` is x y + z of the places [x, y, z] of step k.
    first: usize,
    steps: Vec<[u32; 3]>,
    pub jacobian: Vec<TapeEntry>,
    pub hessian: Vec<TapeEntry>,
}

impl TapeElimination {
    /// Of the nodes `shape` and the outputs `ends`, where `first` numbers were recorded.
    pub fn new(shape: &[u32], ends: &[[u32; 2]], inputs: usize, first: usize) -> Self {
        let graph = TapeGraph { nodes: shape.as_chunks().0, ends, inputs };
        let mut steps = TapeSteps { first, list: Vec::new() };
        let adjoints = graph.adjoints(&mut steps);
        let hessian = graph.push_bends(&adjoints, &mut steps);
        let jacobian = graph.eliminate(&adjoints, &mut steps);
        let (shape, ends) = (shape.to_vec(), ends.to_vec());
        let mut found = Self { shape, ends, inputs, first, steps: steps.list, jacobian, hessian };
        found.drop_unused();
        found
    }

    /// True when this is the elimination of those nodes and outputs.
    pub fn fits(&self, shape: &[u32], ends: &[[u32; 2]], inputs: usize) -> bool {
        self.inputs == inputs && self.ends == ends && self.shape == shape
    }

    /// Leaves out the steps that no derivative follows from.
    fn drop_unused(&mut self) {
        let first = self.first;
        let mut used = vec![false; self.steps.len()];
        let mark = |used: &mut [bool], place: u32| {
            if let Some(step) = (place as usize).checked_sub(first) {
                used[step] = true;
            }
        };
        self.jacobian.iter().chain(&self.hessian).for_each(|entry| mark(&mut used, entry.1));
        for k in (0..used.len()).rev() {
            if used[k] {
                self.steps[k].iter().for_each(|place| mark(&mut used, *place));
            }
        }
        let mut count = 0;
        let place: Vec<u32> = used
            .iter()
            .map(|used| {
                count += u32::from(*used);
                (first as u32 + count).wrapping_sub(1)
            })
            .collect();
        let moved = |at: &mut u32| {
            if let Some(step) = (*at as usize).checked_sub(first) {
                *at = place[step];
            }
        };
        let mut kept = used.iter();
        self.steps.retain(|_| *kept.next().unwrap());
        self.steps.iter_mut().flatten().for_each(moved);
        self.jacobian.iter_mut().chain(&mut self.hessian).for_each(|entry| moved(&mut entry.1));
    }

    /// Writes the numbers of the steps behind those recorded.
    pub fn run(&self, cells: &mut Vec<Double4>) {
        let end = self.first + self.steps.len();
        if cells.len() < end {
            cells.resize(end, Double4::ZERO);
        }
        let cells = &mut cells[..end];
        for (k, &[x, y, z]) in self.steps.iter().enumerate() {
            cells[self.first + k] = cells[x as usize].mul_add(cells[y as usize], cells[z as usize]);
        }
    }
}

/// The steps found so far.
struct TapeSteps {
    first: usize,
    list: Vec<[u32; 3]>,
}

impl TapeSteps {
    /// The place of x y + z, of a number that is already there where it can be.
    fn sum(&mut self, z: u32, x: u32, y: u32) -> u32 {
        match (x, y, z) {
            (ZERO, _, _) | (_, ZERO, _) => z,
            (ONE, only, ZERO) | (only, ONE, ZERO) => only,
            _ => {
                self.list.push([x, y, z]);
                (self.first + self.list.len() - 1) as u32
            }
        }
    }
}

/// Recorded operations.
struct TapeGraph<'a> {
    nodes: &'a [[u32; FIELDS]],
    ends: &'a [[u32; 2]],
    inputs: usize,
}

/// The operands of a node with the places of its slopes.
fn operands(node: &[u32; FIELDS]) -> impl Iterator<Item = (usize, u32)> {
    let [a, b, to_a, to_b, ..] = *node;
    [(a, to_a), (b, to_b)].into_iter().filter(|of| of.0 != NONE).map(|(node, slope)| (node as usize, slope))
}

impl TapeGraph<'_> {
    /// Derivatives of the weighted sum along the nodes; zero of those that no output depends on.
    fn adjoints(&self, steps: &mut TapeSteps) -> Vec<u32> {
        let mut adjoints = vec![ZERO; self.nodes.len()];
        for (i, &[node, factor]) in self.ends.iter().enumerate().filter(|(_, end)| end[0] != NONE) {
            let sum = &mut adjoints[node as usize];
            *sum = steps.sum(*sum, (FIRST + i) as u32, factor);
        }
        for i in (self.inputs..self.nodes.len()).rev() {
            for (operand, slope) in operands(&self.nodes[i]) {
                adjoints[operand] = steps.sum(adjoints[operand], adjoints[i], slope);
            }
        }
        adjoints
    }

    /// The Hessian: second derivatives along pairs of nodes go over to those of their operands, from the last node to the inputs
    /// (Gower & Mello 2012, Optimization Methods and Software 27:251-273).
    fn push_bends(&self, adjoints: &[u32], steps: &mut TapeSteps) -> Vec<TapeEntry> {
        // Pairs (larger node, smaller node).
        let mut bends: Vec<BTreeMap<usize, u32>> = vec![BTreeMap::new(); self.nodes.len()];
        let add = |bends: &mut [BTreeMap<usize, u32>], steps: &mut TapeSteps, [i, j]: [usize; 2], x, y| {
            let bend = bends[i.max(j)].entry(i.min(j)).or_insert(ZERO);
            *bend = steps.sum(*bend, x, y);
        };
        for i in (self.inputs..self.nodes.len()).rev() {
            let own = std::mem::take(&mut bends[i]);
            let node = &self.nodes[i];
            for (&j, &bend) in &own {
                if j == i {
                    let halves: Vec<_> =
                        operands(node).map(|(a, slope)| (a, slope, steps.sum(ZERO, bend, slope))).collect();
                    for (k, &(a, slope, _)) in halves.iter().enumerate() {
                        for &(b, _, half) in &halves[k..] {
                            add(&mut bends, steps, [a, b], half, slope);
                        }
                    }
                    continue;
                }
                for (a, slope) in operands(node) {
                    for _ in 0..1 + usize::from(a == j) {
                        add(&mut bends, steps, [a, j], bend, slope);
                    }
                }
            }
            let [a, b, _, _, aa, ab, bb] = *node;
            for (i_, j_, bend) in [(a, a, aa), (a, b, ab), (b, b, bb)] {
                if bend != ZERO && adjoints[i] != ZERO {
                    add(&mut bends, steps, [i_ as usize, j_ as usize], adjoints[i], bend);
                }
            }
        }
        let rows = bends.iter().enumerate().take(self.inputs);
        rows.flat_map(|(i, row)| row.iter().map(move |(&j, &bend)| ((i, j), bend))).collect()
    }

    /// The Jacobian: nodes are left out of the graph of slopes, those first that take the fewest products (Markowitz 1957; Griewank &
    /// Walther 2008, ch. 10).
    fn eliminate(&self, adjoints: &[u32], steps: &mut TapeSteps) -> Vec<TapeEntry> {
        let count = self.nodes.len();
        let mut slopes =
            TapeSlopes { into: vec![Vec::new(); count + self.ends.len()], out: vec![Vec::new(); count] };
        for i in (self.inputs..count).filter(|i| adjoints[*i] != ZERO) {
            operands(&self.nodes[i]).for_each(|(a, slope)| slopes.add(a, i, slope, ONE, steps));
        }
        for (i, &[node, factor]) in self.ends.iter().enumerate().filter(|(_, end)| end[0] != NONE) {
            slopes.add(node as usize, count + i, factor, ONE, steps);
        }
        let live = (self.inputs..count).filter(|i| adjoints[*i] != ZERO);
        let mut order: BinaryHeap<_> = live.map(|i| Reverse((slopes.products(i), i))).collect();
        let mut left = vec![true; count];
        while let Some(Reverse((products, i))) = order.pop() {
            if !left[i] || products != slopes.products(i) {
                continue;
            }
            left[i] = false;
            for neighbour in slopes.leave_out(i, steps) {
                if (self.inputs..count).contains(&neighbour) {
                    order.push(Reverse((slopes.products(neighbour), neighbour)));
                }
            }
        }
        let mut entries = Vec::new();
        for (output, row) in slopes.into[count..].iter_mut().enumerate() {
            row.sort_unstable();
            entries.extend(row.iter().map(|&(input, slope)| ((output, input), slope)));
        }
        entries
    }
}

/// The graph of slopes: those into each node or output, and where those out of each node go.
struct TapeSlopes {
    into: Vec<Vec<(usize, u32)>>,
    out: Vec<Vec<usize>>,
}

impl TapeSlopes {
    /// Products that leaving node `i` out takes.
    fn products(&self, i: usize) -> usize {
        self.into[i].len() * self.out[i].len()
    }

    /// Adds x y to the slope of `to` along `from`.
    fn add(&mut self, from: usize, to: usize, x: u32, y: u32, steps: &mut TapeSteps) {
        match self.into[to].iter_mut().find(|slope| slope.0 == from) {
            Some((_, slope)) => *slope = steps.sum(*slope, x, y),
            None => {
                self.into[to].push((from, steps.sum(ZERO, x, y)));
                self.out[from].push(to);
            }
        }
    }

    /// Leaves node `i` out; returns its neighbours.
    fn leave_out(&mut self, i: usize, steps: &mut TapeSteps) -> Vec<usize> {
        let (into, out) = (std::mem::take(&mut self.into[i]), std::mem::take(&mut self.out[i]));
        for &(from, _) in &into {
            self.out[from].retain(|to| *to != i);
        }
        for &to in &out {
            let place = self.into[to].iter().position(|slope| slope.0 == i).unwrap_or_default();
            let (_, after) = self.into[to].swap_remove(place);
            for &(from, before) in &into {
                self.add(from, to, before, after, steps);
            }
        }
        into.iter().map(|slope| slope.0).chain(out).collect()
    }
}
