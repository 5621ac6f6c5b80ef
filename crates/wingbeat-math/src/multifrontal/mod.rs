//! Direct solution of sparse symmetric indefinite systems by the multifrontal method (Duff & Reid 1983): the caller names the
//! blocks in which the unknowns are eliminated (the stages of an optimal-control problem, say); inside a block pivots of order one
//! and two are chosen with a threshold (Bunch & Kaufman 1977), and what finds no stable pivot is delayed to the next block. Entries
//! and unknowns are in the caller's units.

mod front;

use front::{Front, Pivots};

/// Where consecutive entries of a part of the matrix go: places in the upper
/// triangle of their block's front, along a row or down a column.
#[derive(Clone, Copy, Debug)]
struct Slot {
    part: usize,
    entry: usize,
    length: usize,
    row: usize,
    column: usize,
    down: bool,
}

impl Slot {
    /// Takes the next entry in when it lies where the slot goes on and on the
    /// same side of `own`, the number of the block's own unknowns.
    fn extend(&mut self, (part, entry): (usize, usize), row: usize, column: usize, own: usize) -> bool {
        let Self { row: first, column: left, length, .. } = *self;
        let right = row == first && column == left + length && column != own;
        let down = column == left && row == first + length && row != own;
        let fits = part == self.part
            && entry == self.entry + length
            && match length {
                1 => right || down,
                _ => {
                    if self.down {
                        down
                    } else {
                        right
                    }
                }
            };
        if fits {
            (self.length, self.down) = (length + 1, down);
        }
        fits
    }
}

/// One block of the elimination.
#[derive(Clone, Debug, Default)]
struct Block {
    /// Unknowns eliminated here.
    own: Vec<usize>,
    /// Unknowns of later blocks coupled to them.
    boundary: Vec<usize>,
    children: Vec<usize>,
    slots: Vec<Slot>,
}

/// The pattern of a matrix and the order of its elimination.
#[derive(Clone, Debug)]
pub struct Pattern {
    size: usize,
    blocks: Vec<Block>,
}

/// How many positive, negative and zero eigenvalues a matrix has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inertia {
    /// Positive eigenvalues.
    pub positive: usize,
    /// Negative eigenvalues.
    pub negative: usize,
    /// Eigenvalues that are zero to working precision.
    pub zero: usize,
}

impl Pattern {
    /// The block of an unknown that is left out of the matrix, with its entries; the solution there is the right-hand side.
    pub const LEFT_OUT: usize = usize::MAX;

    /// The pattern of a symmetric matrix of order `block_of.len()`, a sum of `parts` with
    /// entries (row, column) in either triangle, repeated ones summed.
    /// Blocks are eliminated in ascending number.
    pub fn new(block_of: &[usize], parts: &[&[(usize, usize)]]) -> Self {
        let count = block_of.iter().filter(|b| **b != Self::LEFT_OUT).max().map_or(0, |b| b + 1);
        let mut blocks = vec![Block::default(); count];
        for (i, &b) in block_of.iter().enumerate().filter(|(_, b)| **b != Self::LEFT_OUT) {
            blocks[b].own.push(i);
        }
        // The block that last noted an unknown on its boundary: most repetitions are seen at once.
        let mut noted = vec![usize::MAX; block_of.len()];
        for &(i, j) in parts.iter().copied().flatten() {
            let (low, high) = if block_of[i] < block_of[j] { (i, j) } else { (j, i) };
            let apart = block_of[high] != Self::LEFT_OUT && block_of[low] != block_of[high];
            if apart && noted[high] != block_of[low] {
                noted[high] = block_of[low];
                blocks[block_of[low]].boundary.push(high);
            }
        }
        for b in 0..count {
            let mut boundary = std::mem::take(&mut blocks[b].boundary);
            boundary.sort_unstable_by_key(|&i| (block_of[i], i));
            boundary.dedup();
            if let Some(&first) = boundary.first() {
                let parent = block_of[first];
                blocks[parent].children.push(b);
                let up: Vec<usize> = boundary.iter().copied().filter(|&i| block_of[i] != parent).collect();
                blocks[parent].boundary.extend(up);
            } else if b + 1 < count {
                // A block of its own still hands its delayed pivots on.
                blocks[b + 1].children.push(b);
            }
            blocks[b].boundary = boundary;
        }
        for (part, entries) in parts.iter().enumerate() {
            place_entries(&mut blocks, block_of, part, entries);
        }
        Self { size: block_of.len(), blocks }
    }
}

/// Places of the entries of a part: own unknowns count from 0, boundary ones follow.
fn place_entries(blocks: &mut [Block], block_of: &[usize], part: usize, entries: &[(usize, usize)]) {
    // The places in the front of the present block of entries.
    let (mut place, mut present) = (vec![0; block_of.len()], usize::MAX);
    for (entry, &(i, j)) in entries.iter().enumerate() {
        if block_of[i].max(block_of[j]) == Pattern::LEFT_OUT {
            continue;
        }
        let b = block_of[i].min(block_of[j]);
        let Block { own, boundary, slots, .. } = &mut blocks[b];
        if b != present {
            present = b;
            own.iter().chain(&*boundary).enumerate().for_each(|(k, &i)| place[i] = k);
        }
        let (row, column) = (place[i].min(place[j]), place[i].max(place[j]));
        if !slots.last_mut().is_some_and(|last| last.extend((part, entry), row, column, own.len())) {
            slots.push(Slot { part, entry, length: 1, row, column, down: false });
        }
    }
}

/// The factors of a matrix, with their storage, reused from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Factors {
    pivots: Vec<Pivots>,
    contributions: Vec<Front>,
    front: Front,
    position: Vec<usize>,
    local: Vec<f64>,
}

impl Factors {
    /// Factorises the matrix with the values `parts` at the entries of the parts of `pattern`; an empty part is zero.
    /// `threshold` in (0, 0.5] bounds the growth: larger is stabler and slower.
    pub fn factorise(&mut self, pattern: &Pattern, parts: &[&[f64]], threshold: f64) -> Inertia {
        self.prepare(pattern);
        let mut inertia = Inertia::default();
        let last = pattern.blocks.len().saturating_sub(1);
        for (b, block) in pattern.blocks.iter().enumerate() {
            self.assemble(pattern, b, parts);
            let mut pivots = std::mem::take(&mut self.pivots[b]);
            self.front.eliminate(threshold, b == last, &mut pivots, &mut inertia);
            self.pivots[b] = pivots;
            self.front.remainder_into(&self.pivots[b], &mut self.contributions[b]);
            for &child in &block.children {
                self.contributions[child].clear();
            }
        }
        inertia
    }

    fn prepare(&mut self, pattern: &Pattern) {
        let count = pattern.blocks.len();
        if self.pivots.len() == count && self.position.len() == pattern.size {
            return;
        }
        self.pivots = vec![Pivots::default(); count];
        self.contributions = vec![Front::default(); count];
        self.position = vec![0; pattern.size];
    }

    /// The front of block `b`: its own unknowns, those delayed by its
    /// children, then the boundary; filled with entries and contributions.
    fn assemble(&mut self, pattern: &Pattern, b: usize, parts: &[&[f64]]) {
        let block = &pattern.blocks[b];
        let front = &mut self.front;
        front.rows.clear();
        front.rows.extend(&block.own);
        for &child in &block.children {
            let contribution = &self.contributions[child];
            front.rows.extend(&contribution.rows[..contribution.candidates]);
        }
        front.candidates = front.rows.len();
        front.rows.extend(&block.boundary);
        front.reset();
        for (k, &i) in front.rows.iter().enumerate() {
            self.position[i] = k;
        }
        let (own, shift) = (block.own.len(), front.candidates - block.own.len());
        let place = |p: usize| if p < own { p } else { p + shift };
        for slot in block.slots.iter().filter(|slot| !parts[slot.part].is_empty()) {
            let entries = &parts[slot.part][slot.entry..slot.entry + slot.length];
            front.add_along(place(slot.row), place(slot.column), slot.down, entries);
        }
        for &child in &block.children {
            front.extend_add(&self.contributions[child], &self.position);
        }
        front.measure();
    }

    /// Overwrites `x` (the right-hand side) with the solution.
    pub fn solve(&mut self, x: &mut [f64]) {
        let mut local = std::mem::take(&mut self.local);
        for pivots in &self.pivots {
            pivots.forward(x, &mut local);
        }
        for pivots in self.pivots.iter().rev() {
            pivots.backward(x, &mut local);
        }
        self.local = local;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of saddle-point blocks with a zero (1, 1) part, and a border.
    fn chain(stages: usize) -> (Vec<usize>, Vec<(usize, usize)>, Vec<f64>) {
        let (mut blocks, mut entries, mut values) = (Vec::new(), Vec::new(), Vec::new());
        let border = 3 * stages;
        for k in 0..stages {
            blocks.extend([k; 3]);
            let i = 3 * k;
            let wave = (k as f64 * 0.7).sin();
            let mut put = |r: usize, c: usize, v: f64| {
                entries.push((r, c));
                values.push(v);
            };
            put(i + 1, i + 1, 1.0 + wave);
            put(i + 2, i, -1.0);
            put(i + 2, i + 1, 0.3 + wave);
            put(border, i + 2, 0.1);
            if k + 1 < stages {
                put(i + 2, i + 3, 1.0);
            } else {
                put(i, i, 2.0);
            }
        }
        blocks.push(stages);
        entries.push((border, border));
        values.push(5.0);
        (blocks, entries, values)
    }

    #[test]
    fn chain_with_delayed_pivots_is_solved_with_its_inertia() {
        let (blocks, entries, values) = chain(40);
        let pattern = Pattern::new(&blocks, &[&entries]);
        let mut factors = Factors::default();
        for _ in 0..2 {
            let inertia = factors.factorise(&pattern, &[&values], 1e-6);
            let n = blocks.len();
            let exact: Vec<f64> = (0..n).map(|i| (i as f64 * 1.3).cos()).collect();
            let mut x = vec![0.0; n];
            for (&(i, j), v) in entries.iter().zip(&values) {
                x[i] += v * exact[j];
                if i != j {
                    x[j] += v * exact[i];
                }
            }
            factors.solve(&mut x);
            let worst = x.iter().zip(&exact).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(worst < 1e-9, "error {worst:e}");
            assert_eq!((inertia.negative, inertia.zero), (40, 0));
        }
    }

    #[test]
    fn singular_matrix_is_seen() {
        let pattern = Pattern::new(&[0, 0, 1], &[&[(0, 0), (1, 0), (1, 1), (2, 2)]]);
        let inertia = Factors::default().factorise(&pattern, &[&[1.0, 2.0, 4.0, 1.0]], 1e-6);
        assert_eq!(inertia, Inertia { positive: 2, negative: 0, zero: 1 });
    }
}
