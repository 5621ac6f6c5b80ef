//! Direct solution of sparse symmetric indefinite systems by the multifrontal method (Duff & Reid 1983): the caller names the
//! blocks in which the unknowns are eliminated (the stages of an optimal-control problem, say); inside a block pivots of order one
//! and two are chosen with a threshold (Bunch & Kaufman 1977), and what finds no stable pivot is delayed to the next block. Entries
//! and unknowns are in the caller's units.

mod front;

use front::{Front, Pivots};

/// The most parts that a matrix is the sum of.
pub const MOST_PARTS: usize = 8;

/// Where consecutive entries of a part of the matrix go: places in the upper
/// triangle of their block's front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Slot {
    part: u8,
    course: SlotCourse,
    /// Counted from the first entry of the part in the block.
    entry: u32,
    length: u32,
    row: u32,
    column: u32,
}

/// Which way consecutive entries go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SlotCourse {
    Along,
    Down,
    Diagonal,
}

impl Slot {
    /// Takes the next entry in when it lies where the slot goes on and on the
    /// same side of `own`, the number of the block's own unknowns.
    fn extend(&mut self, (part, entry): (usize, usize), row: usize, column: usize, own: usize) -> bool {
        let [first, left, length] = [self.row, self.column, self.length].map(|of| of as usize);
        if part != usize::from(self.part) || entry != self.entry as usize + length {
            return false;
        }
        let course = if row == first && column == left + length && column != own {
            SlotCourse::Along
        } else if column == left && row == first + length && row != own {
            SlotCourse::Down
        } else if row == column && first == left && row == first + length {
            SlotCourse::Diagonal
        } else {
            return false;
        };
        let fits = length == 1 || course == self.course;
        if fits {
            (self.length, self.course) = (self.length + 1, course);
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
    /// First entry of each part, and the number of the slots.
    first: Vec<usize>,
    slots: usize,
}

/// The pattern of a matrix and the order of its elimination.
#[derive(Clone, Debug)]
pub struct Pattern {
    size: usize,
    blocks: Vec<Block>,
    /// Slots of the blocks; those of stages that are alike are the same, and stay in the cache.
    slots: Vec<Vec<Slot>>,
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
    /// entries (row, column) in either triangle, repeated ones summed; there are at most [`MOST_PARTS`].
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
        let mut slots = vec![Vec::new(); count];
        blocks.iter_mut().for_each(|block| block.first = vec![usize::MAX; parts.len()]);
        for (part, entries) in parts.iter().enumerate() {
            place_entries(&mut blocks, &mut slots, block_of, part, entries);
        }
        let mut pattern = Self { size: block_of.len(), blocks, slots: Vec::new() };
        for (block, slots) in pattern.blocks.iter_mut().zip(slots) {
            if pattern.slots.last() != Some(&slots) {
                pattern.slots.push(slots);
            }
            block.slots = pattern.slots.len() - 1;
        }
        pattern
    }
}

/// Places of the entries of a part: own unknowns count from 0, boundary ones follow.
fn place_entries(
    blocks: &mut [Block],
    slots: &mut [Vec<Slot>],
    block_of: &[usize],
    part: usize,
    entries: &[(usize, usize)],
) {
    // The places in the front of the present block of entries.
    let (mut place, mut present) = (vec![0; block_of.len()], usize::MAX);
    let mut entry = 0;
    while entry < entries.len() {
        let (i, j) = entries[entry];
        if block_of[i].max(block_of[j]) == Pattern::LEFT_OUT {
            entry += 1;
            continue;
        }
        let b = block_of[i].min(block_of[j]);
        let (Block { own, boundary, first, .. }, slots) = (&mut blocks[b], &mut slots[b]);
        if b != present {
            present = b;
            own.iter().chain(&*boundary).enumerate().for_each(|(k, &i)| place[i] = k);
            first[part] = first[part].min(entry);
        }
        let (one, other, own) = (place[i], place[j], own.len());
        let (row, column) = (one.min(other), one.max(other));
        // Entries of one row in consecutive columns, as long as their places are on the same side of the row's and of `own`.
        let goes_on = |k: usize| {
            let place_after = other + k;
            entries.get(entry + k) == Some(&(i, j + k))
                && block_of[j + k] == block_of[j]
                && place[j + k] == place_after
                && (place_after > one) == (other >= one)
                && place_after != own
        };
        let length = (1..).find(|k| !goes_on(*k)).unwrap_or(1);
        let slot_entry = entry - first[part];
        entry += length;
        if length == 1
            && slots.last_mut().is_some_and(|last| last.extend((part, slot_entry), row, column, own))
        {
            continue;
        }
        let course = if other >= one { SlotCourse::Along } else { SlotCourse::Down };
        let [entry, length, row, column] = [slot_entry, length, row, column].map(|of| of as u32);
        slots.push(Slot { part: part as u8, course, entry, length, row, column });
    }
}

/// The factors of a matrix, with their storage, reused from one to the next.
#[derive(Clone, Debug, Default)]
pub struct Factors {
    pivots: Vec<Pivots>,
    contributions: Vec<Front>,
    spare: Vec<Front>,
    front: Front,
    position: Vec<usize>,
    local: Vec<f64>,
}

impl Factors {
    /// Factorises the matrix with the values `parts` at the entries of the parts of `pattern`; an empty part is zero.
    /// `threshold` in (0, 0.5] bounds the growth: larger is stabler and slower. Ends early, with the inertia so far, when
    /// more eigenvalues are negative after a block than `most` has for it; an empty one has no limits.
    pub fn factorise(
        &mut self,
        pattern: &Pattern,
        parts: &[&[f64]],
        threshold: f64,
        most: &[usize],
    ) -> Inertia {
        self.prepare(pattern);
        let mut inertia = Inertia::default();
        let last = pattern.blocks.len().saturating_sub(1);
        for (b, block) in pattern.blocks.iter().enumerate() {
            self.assemble(pattern, b, parts);
            let mut pivots = std::mem::take(&mut self.pivots[b]);
            self.front.eliminate(threshold, b == last, &mut pivots, &mut inertia);
            self.pivots[b] = pivots;
            if most.get(b).is_some_and(|most| inertia.negative > *most) {
                break;
            }
            // A remainder takes the room of one that was used up, which is in the cache.
            for &child in &block.children {
                self.spare.push(std::mem::take(&mut self.contributions[child]));
            }
            let mut remainder = self.spare.pop().unwrap_or_default();
            self.front.remainder_into(&self.pivots[b], &mut remainder);
            self.contributions[b] = remainder;
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
        let place = |p: u32| if (p as usize) < own { p as usize } else { p as usize + shift };
        // An empty part is zero.
        let mut begun = [[].as_slice(); MOST_PARTS];
        for part in 0..parts.len() {
            begun[part] = parts[part].get(block.first[part]..).unwrap_or_default();
        }
        for slot in &pattern.slots[block.slots] {
            let first = slot.entry as usize;
            if let Some(entries) = begun[slot.part as usize].get(first..first + slot.length as usize) {
                front.add_course(place(slot.row), place(slot.column), slot.course, entries);
            }
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
            let inertia = factors.factorise(&pattern, &[&values], 1e-6, &[]);
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
        let inertia = Factors::default().factorise(&pattern, &[&[1.0, 2.0, 4.0, 1.0]], 1e-6, &[]);
        assert_eq!(inertia, Inertia { positive: 2, negative: 0, zero: 1 });
    }
}
