//! The order in which operations are eliminated, and the sums of products that this takes.

use super::super::Double4;
use super::{CONSTANT, LANES, TapeKind, TapeNode, TapeRecording};
use wide::f64x4;

/// Places of the numbers 0, 1 and -1; behind them are the weights of the outputs, then their factors.
const ZERO: u32 = 0;
const ONE: u32 = 1;
const MINUS: u32 = 2;
const FIRST: usize = 3;
/// The operand that is missing.
const NONE: u32 = u32::MAX;
/// Numbers of a node that are gathered together.
const TOGETHER: usize = 4;

/// Places of numbers: as many as can be told apart by two bytes, so that none is looked for beyond them.
const PLACES: usize = 1 << u16::BITS;

/// Numbers for each node and sweep with which the sums of products at four points take about as long as the sweeps.
const MOST_PRODUCTS: usize = 20;

/// Numbers of four points. Zeros until they are written: pages of them are none of the memory.
#[derive(Clone, Debug)]
pub(super) struct TapeCells(Box<[[f64; 4]; PLACES]>);

impl Default for TapeCells {
    fn default() -> Self {
        let cells = vec![[0.0; 4]; PLACES].into_boxed_slice();
        Self(cells.try_into().unwrap_or_else(|_| unreachable!("as many cells as places")))
    }
}

impl TapeCells {
    /// The numbers at a place, in the units of the caller.
    #[inline]
    pub fn at(&self, place: u16) -> [f64; 4] {
        self.0[usize::from(place)]
    }
}

/// A derivative (output, input) or (input, input) and its place among the numbers.
pub(super) type TapeEntry = ((usize, usize), u16);

/// The same while the places are being found.
type TapePlace = ((usize, usize), u32);

/// A number that is taken to be 1 or -1: of the node or output of this place.
#[derive(Clone, Copy, Debug)]
struct TapeUnit {
    of: u32,
    value: f64,
}

/// A sum both of whose slopes are.
#[derive(Clone, Copy, Debug)]
struct TapeUnits {
    of: u32,
    slopes: [u64; 2],
}

/// The derivatives of recorded operations as a list of sums of products of numbers.
#[derive(Clone, Debug)]
pub(super) struct TapeElimination {
    pub hash: u64,
    inputs: usize,
    /// Operands and kinds of the nodes.
    nodes: Vec<(u64, u32)>,
    outputs: Vec<u32>,
    /// What was 1 or -1 and is so in each recording that fits: slopes of sums, factors of outputs.
    sums: Vec<TapeUnits>,
    units: Vec<TapeUnit>,
    /// Nodes of which the first numbers are gathered, and those of which the last one is.
    gathered: Vec<u32>,
    bent: Vec<u32>,
    /// Number `first + k` is x y + z of the places [x, y, z] of step k.
    first: usize,
    steps: Vec<[u16; 3]>,
    pub jacobian: Vec<TapeEntry>,
    pub hessian: Vec<TapeEntry>,
}

/// The place of a number that is 1 or -1.
fn unit(value: f64) -> Option<u32> {
    if value == 1.0 { Some(ONE) } else { (value == -1.0).then_some(MINUS) }
}

impl TapeElimination {
    /// Of what was recorded; none where it takes more numbers than there are places.
    pub fn new(recorded: &TapeRecording, hash: u64) -> Option<Self> {
        let TapeRecording { nodes, inputs, outputs } = recorded;
        let mut found = Self {
            hash,
            inputs: *inputs,
            nodes: nodes.iter().map(|node| (node.operands_as_one(), node.kind as u32)).collect(),
            outputs: outputs.iter().map(|output| output.node).collect(),
            sums: Vec::new(),
            units: Vec::new(),
            gathered: Vec::new(),
            bent: Vec::new(),
            first: 0,
            steps: Vec::new(),
            jacobian: Vec::new(),
            hessian: Vec::new(),
        };
        let (places, ends) = (found.places(nodes), found.ends(recorded));
        let mut steps = TapeSteps { first: found.first, list: Vec::new() };
        let places: Vec<_> = places.into_iter().map(|place| steps.of_one(place)).collect();
        let graph = TapeGraph { nodes: &places, ends: &ends, inputs: *inputs };
        let adjoints = graph.adjoints(&mut steps);
        let hessian = graph.push_bends(&adjoints, &mut steps);
        let jacobian = graph.eliminate(&adjoints, &mut steps);
        found.keep_used(steps.list, jacobian, hessian).then_some(found)
    }

    /// The nodes with the places of their numbers.
    fn places(&mut self, nodes: &[TapeNode]) -> Vec<[u32; FIELDS]> {
        let count = nodes.len() as u32;
        let sums = nodes.iter().filter(|node| node.kind == TapeKind::Sum);
        let whole = sums.filter(|node| node.numbers[..2].iter().all(|slope| unit(*slope).is_some())).count();
        let begin = FIRST + 2 * self.outputs.len();
        let last = begin + TOGETHER * (count as usize - whole - self.inputs);
        let places = (0..count).map(|i| {
            let TapeNode { parents: [a, b], kind, numbers } = nodes[i as usize];
            if kind == TapeKind::Input {
                return [NONE, NONE, ZERO, ZERO, ZERO, ZERO, ZERO];
            }
            let place = (begin + TOGETHER * self.gathered.len()) as u32;
            match kind {
                TapeKind::Sum => {
                    if let [Some(to_a), Some(to_b)] = [0, 1].map(|side: usize| unit(numbers[side])) {
                        let slopes = [numbers[0].to_bits(), numbers[1].to_bits()];
                        self.sums.push(TapeUnits { of: i, slopes });
                        return [a, b, to_a, to_b, ZERO, ZERO, ZERO];
                    }
                    self.gathered.push(i);
                    [a, b, place, place + 1, ZERO, ZERO, ZERO]
                }
                TapeKind::Unary => {
                    self.gathered.push(i);
                    [a, NONE, place, ZERO, place + 2, ZERO, ZERO]
                }
                TapeKind::Product => {
                    self.gathered.push(i);
                    [a, b, place, place + 1, ZERO, place + 3, ZERO]
                }
                _ => {
                    self.gathered.push(i);
                    self.bent.push(i);
                    let bb = (last + self.bent.len() - 1) as u32;
                    [a, b, place, place + 1, place + 2, place + 3, bb]
                }
            }
        });
        let places = places.collect();
        self.first = last + self.bent.len();
        places
    }

    /// The nodes of the outputs and the places of their factors.
    fn ends(&mut self, recorded: &TapeRecording) -> Vec<[u32; 2]> {
        let outputs = recorded.outputs.iter().enumerate();
        outputs
            .map(|(i, output)| {
                if output.node == CONSTANT {
                    return [NONE, ZERO];
                }
                let place = unit(output.factor);
                if place.is_some() {
                    self.units.push(TapeUnit { of: i as u32, value: output.factor });
                }
                [output.node, place.unwrap_or((FIRST + self.outputs.len() + i) as u32)]
            })
            .collect()
    }

    /// True when this is the elimination of what was recorded.
    pub fn fits(&self, recorded: &TapeRecording) -> bool {
        let TapeRecording { nodes, inputs, outputs } = recorded;
        if self.nodes.len() != nodes.len() || self.inputs != *inputs || self.outputs.len() != outputs.len() {
            return false;
        }
        // What calls remain in loops over iterators cost more than the comparisons.
        let (nodes, own) = (&nodes[..], &self.nodes[..nodes.len()]);
        let (mut parents, mut kinds) = (0, 0);
        for i in 0..nodes.len() {
            parents |= nodes[i].operands_as_one() ^ own[i].0;
            kinds |= nodes[i].kind as u32 ^ own[i].1;
        }
        if parents != 0 || kinds != 0 {
            return false;
        }
        for sum in &self.sums {
            let [to_a, to_b, ..] = nodes[sum.of as usize].numbers;
            if [to_a.to_bits(), to_b.to_bits()] != sum.slopes {
                return false;
            }
        }
        for i in 0..outputs.len() {
            if outputs[i].node != self.outputs[i] {
                return false;
            }
        }
        for unit in &self.units {
            if outputs[unit.of as usize].factor != unit.value {
                return false;
            }
        }
        true
    }

    /// Writes the numbers of four recordings that fit, and those of the steps, for the `weights` of the outputs.
    pub fn run(&self, recorded: [&TapeRecording; 4], weights: &[Double4], cells: &mut TapeCells) {
        let cells = &mut cells.0;
        let outputs = self.outputs.len();
        (cells[ZERO as usize], cells[ONE as usize], cells[MINUS as usize]) = ([0.0; 4], [1.0; 4], [-1.0; 4]);
        let [a, b, c, d] = recorded.map(|recorded| &recorded.outputs[..outputs]);
        for i in 0..outputs {
            cells[FIRST + i] = weights[i].numbers();
            cells[FIRST + outputs + i] = [a[i].factor, b[i].factor, c[i].factor, d[i].factor];
        }
        let [a, b, c, d] = recorded.map(|recorded| &recorded.nodes[..self.nodes.len()]);
        let (together, others) = cells[FIRST + 2 * outputs..].split_at_mut(TOGETHER * self.gathered.len());
        for (&i, out) in self.gathered.iter().zip(together.as_chunks_mut().0) {
            let i = i as usize;
            *out = turned([a[i].first_four(), b[i].first_four(), c[i].first_four(), d[i].first_four()]);
        }
        for (&i, out) in self.bent.iter().zip(others) {
            let i = i as usize;
            *out = [a[i].numbers[4], b[i].numbers[4], c[i].numbers[4], d[i].numbers[4]];
        }
        let mut at = self.first as u16;
        for &[x, y, z] in &self.steps {
            let (x, y) = (f64x4::new(cells[usize::from(x)]), f64x4::new(cells[usize::from(y)]));
            cells[usize::from(at)] = x.mul_add(y, f64x4::new(cells[usize::from(z)])).to_array();
            at = at.wrapping_add(1);
        }
    }

    /// Keeps the steps that derivatives follow from; false where there are too many.
    fn keep_used(
        &mut self,
        mut steps: Vec<[u32; 3]>,
        mut jacobian: Vec<TapePlace>,
        mut hessian: Vec<TapePlace>,
    ) -> bool {
        let first = self.first;
        let mut used = vec![false; steps.len()];
        let mark = |used: &mut [bool], place: u32| {
            if let Some(step) = (place as usize).checked_sub(first) {
                used[step] = true;
            }
        };
        jacobian.iter().chain(&hessian).for_each(|entry| mark(&mut used, entry.1));
        for k in (0..used.len()).rev() {
            if used[k] {
                steps[k].iter().for_each(|place| mark(&mut used, *place));
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
        if first + count as usize > PLACES.min(MOST_PRODUCTS * self.nodes.len() * self.inputs.div_ceil(LANES))
        {
            return false;
        }
        let moved = |at: &mut u32| {
            if let Some(step) = (*at as usize).checked_sub(first) {
                *at = place[step];
            }
        };
        let mut kept = used.iter();
        steps.retain(|_| *kept.next().unwrap_or(&false));
        steps.iter_mut().flatten().for_each(moved);
        jacobian.iter_mut().chain(&mut hessian).for_each(|entry| moved(&mut entry.1));
        // There are no more places than that.
        self.steps = steps.into_iter().map(|step| step.map(|place| place as u16)).collect();
        [self.jacobian, self.hessian] = [jacobian, hessian]
            .map(|entries| entries.into_iter().map(|(of, place)| (of, place as u16)).collect());
        true
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

    /// A node whose two operands are one and the same as one of one operand.
    fn of_one(&mut self, node: [u32; FIELDS]) -> [u32; FIELDS] {
        let [a, b, to_a, to_b, aa, ab, bb] = node;
        if a != b || a == NONE {
            return node;
        }
        let slope = self.sum(to_a, to_b, ONE);
        let twice = [aa, ab, ab, bb].into_iter().fold(ZERO, |sum, bend| self.sum(sum, bend, ONE));
        [a, NONE, slope, ZERO, twice, ZERO, ZERO]
    }
}

/// What is known of a node, as places of numbers: its operands (the second may be [`NONE`]), its slopes, and its curvatures.
const FIELDS: usize = 7;

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
    fn push_bends(&self, adjoints: &[u32], steps: &mut TapeSteps) -> Vec<TapePlace> {
        // Pairs (larger node, smaller node).
        let mut bends: Vec<Vec<(usize, u32)>> = vec![Vec::new(); self.nodes.len()];
        let add = |bends: &mut [Vec<(usize, u32)>], steps: &mut TapeSteps, [i, j]: [usize; 2], x, y| {
            let (row, j) = (&mut bends[i.max(j)], i.min(j));
            match row.iter_mut().find(|bend| bend.0 == j) {
                Some((_, bend)) => *bend = steps.sum(*bend, x, y),
                None => row.push((j, steps.sum(ZERO, x, y))),
            }
        };
        for i in (self.inputs..self.nodes.len()).rev() {
            let mut own = std::mem::take(&mut bends[i]);
            own.sort_unstable();
            let node = &self.nodes[i];
            for &(j, bend) in &own {
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
        let mut entries = Vec::new();
        for (i, row) in bends[..self.inputs].iter_mut().enumerate() {
            row.sort_unstable();
            entries.extend(row.iter().map(|&(j, bend)| ((i, j), bend)));
        }
        entries
    }

    /// The Jacobian: nodes are left out of the graph of slopes, those first that take the fewest products (Markowitz 1957; Griewank &
    /// Walther 2008, ch. 10).
    fn eliminate(&self, adjoints: &[u32], steps: &mut TapeSteps) -> Vec<TapePlace> {
        let count = self.nodes.len();
        let mut slopes =
            TapeSlopes { into: vec![Vec::new(); count + self.ends.len()], out: vec![Vec::new(); count] };
        for i in (self.inputs..count).filter(|i| adjoints[*i] != ZERO) {
            operands(&self.nodes[i]).for_each(|(a, slope)| slopes.add(a, i, slope, ONE, steps));
        }
        for (i, &[node, factor]) in self.ends.iter().enumerate().filter(|(_, end)| end[0] != NONE) {
            slopes.add(node as usize, count + i, factor, ONE, steps);
        }
        let mut left: Vec<usize> = (self.inputs..count).filter(|i| adjoints[*i] != ZERO).collect();
        while let Some(at) = (0..left.len()).min_by_key(|at| (slopes.products(left[*at]), left[*at])) {
            slopes.leave_out(left.swap_remove(at), steps);
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

    /// Leaves node `i` out.
    fn leave_out(&mut self, i: usize, steps: &mut TapeSteps) {
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
    }
}

/// Numbers of four lanes as four numbers of all lanes.
#[inline]
fn turned([a, b, c, d]: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    let [a, b, c, d] = f64x4::transpose([f64x4::new(a), f64x4::new(b), f64x4::new(c), f64x4::new(d)]);
    [a.to_array(), b.to_array(), c.to_array(), d.to_array()]
}
