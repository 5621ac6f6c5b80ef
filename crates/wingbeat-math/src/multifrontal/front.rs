//! One dense front: its partial factorisation and its part of the solves.

use super::{Inertia, SlotCourse};
use wide::f64x4;

/// Columns swept together; rows are padded to whole chunks of them.
const CHUNK: usize = 4;

/// Bits of the columns of a chunk right of each of them.
const RIGHT_OF: [[f64; CHUNK]; CHUNK] = {
    let (some, none) = (f64::from_bits(u64::MAX), 0.0);
    [[none, some, some, some], [none, none, some, some], [none, none, none, some], [none; CHUNK]]
};

/// The numbers of a chunk right of the column that has the remainder of `i`, zeros in the place of the others.
#[inline]
fn right_of(i: usize, chunk: [f64; CHUNK]) -> [f64; CHUNK] {
    (f64x4::new(chunk) & f64x4::new(RIGHT_OF[i % CHUNK])).to_array()
}

/// Column `i` rounded down to where its chunk begins.
#[inline(always)]
fn chunk_of(i: usize) -> usize {
    i / CHUNK * CHUNK
}

/// A dense symmetric matrix over the unknowns `rows`, of which the first
/// `candidates` may be eliminated. Upper triangle, row-major; what lies left
/// of the diagonal in its chunk is swept with it and means nothing.
#[derive(Clone, Debug, Default)]
pub struct Front {
    pub rows: Vec<usize>,
    pub candidates: usize,
    /// Length of a padded row.
    stride: usize,
    values: Vec<f64>,
    /// Largest magnitude each unknown's column had when it was assembled.
    scale: Vec<f64>,
    /// Rows of the last pivots, chunk by chunk, for the rows below.
    panel: Vec<PanelChunk>,
    /// Rows of a child that follow one another here too: the first, its place here and their number.
    runs: Vec<(usize, usize, usize)>,
}

/// Pivots whose updates are applied together.
const PANEL: usize = 12;

/// A chunk of columns of the rows of a few pivots, before their division by the pivots and after it.
#[derive(Clone, Copy, Debug, Default)]
struct PanelChunk {
    whole: [[f64; CHUNK]; PANEL],
    divided: [[f64; CHUNK]; PANEL],
}

/// The eliminated part of a front: P' A P = U' D U for its leading rows.
#[derive(Clone, Debug, Default)]
pub struct Pivots {
    rows: Vec<usize>,
    count: usize,
    stride: usize,
    /// U, the first `count` rows over the unknowns of the front, each from the
    /// chunk of its diagonal on, with zeros on the diagonal and left of it.
    factors: Vec<[f64; CHUNK]>,
    /// How many of them count.
    filled: usize,
    /// D: the diagonal, and the off-diagonal where a pivot of order two starts.
    diagonal: Vec<f64>,
    coupling: Vec<f64>,
}

/// The rows of the pivots of a chunk, each from the chunk on.
type RowsOfChunk<'r> = [&'r [[f64; CHUNK]]; CHUNK];

/// What follows the chunk in each row, that of the first one for those of no pivots.
#[inline(always)]
fn tails<'r>(rows: &RowsOfChunk<'r>) -> RowsOfChunk<'r> {
    let tail = |p: usize| if rows[p].is_empty() { &rows[0][1..] } else { &rows[p][1..] };
    [tail(0), tail(1), tail(2), tail(3)]
}

/// What the search for a pivot found.
enum Choice {
    One(usize),
    Two(usize, usize),
    None,
}

/// Pivots below this share of what their column once held count as zero.
const NEGLIGIBLE: f64 = 1e-14;

impl Front {
    /// Zero values for the present rows.
    pub fn reset(&mut self) {
        self.stride = self.rows.len().next_multiple_of(CHUNK);
        if self.values.len() < self.rows.len() * self.stride {
            self.values.resize(self.rows.len() * self.stride, 0.0);
        }
        for i in 0..self.rows.len() {
            self.values[i * self.stride + chunk_of(i)..(i + 1) * self.stride].fill(0.0);
        }
        self.scale.clear();
        self.scale.resize(self.stride, f64::MIN_POSITIVE);
        if self.panel.len() < self.stride / CHUNK {
            self.panel.resize(self.stride / CHUNK, PanelChunk::default());
        }
    }

    /// Row `i` from the chunk of column `first` on.
    #[inline]
    fn row(&self, i: usize, first: usize) -> &[[f64; CHUNK]] {
        self.values[i * self.stride + chunk_of(first)..(i + 1) * self.stride].as_chunks().0
    }

    /// Notes the size of the candidates' columns, once the front is assembled; what it notes of others means nothing.
    pub fn measure(&mut self) {
        let columns = self.candidates.div_ceil(CHUNK);
        for i in 0..self.candidates {
            let first = chunk_of(i) / CHUNK;
            let row =
                self.values[i * self.stride + chunk_of(i)..(i + 1) * self.stride].as_chunks::<CHUNK>().0;
            let scale = &mut self.scale.as_chunks_mut::<CHUNK>().0[first..columns];
            let (own, rest) = row.split_at(scale.len());
            let mut largest = f64x4::ZERO;
            for j in 0..own.len() {
                let sizes = f64x4::new(own[j]).abs();
                largest = sizes.fast_max(largest);
                scale[j] = sizes.fast_max(f64x4::new(scale[j])).to_array();
            }
            for j in 0..rest.len() {
                largest = f64x4::new(rest[j]).abs().fast_max(largest);
            }
            self.scale[i] = self.scale[i].max(widest(largest));
        }
    }

    /// Adds `values` from row `i` and column `j` on.
    #[inline]
    pub fn add_course(&mut self, i: usize, j: usize, course: SlotCourse, values: &[f64]) {
        let first = i * self.stride + j;
        let step = match course {
            SlotCourse::Along => {
                let row = &mut self.values[first..][..values.len()];
                for k in 0..values.len() {
                    row[k] += values[k];
                }
                return;
            }
            SlotCourse::Down => self.stride,
            SlotCourse::Diagonal => self.stride + 1,
        };
        for (sum, value) in self.values[first..].iter_mut().step_by(step).zip(values) {
            *sum += value;
        }
    }

    /// Adds a child's remainder; `position` maps unknowns to rows here.
    pub fn extend_add(&mut self, child: &Front, position: &[usize]) {
        let mut runs = std::mem::take(&mut self.runs);
        runs.clear();
        for (j, row) in child.rows.iter().enumerate() {
            let place = position[*row];
            match runs.last_mut() {
                Some((begin, first, length)) if *begin + *length == j && *first + *length == place => {
                    *length += 1
                }
                _ => runs.push((j, place, 1)),
            }
        }
        for (i, row) in child.rows.iter().enumerate() {
            let p = position[*row];
            if i < child.candidates {
                self.scale[p] = self.scale[p].max(child.scale[i]);
            }
            let values = &child.values[i * child.stride..][..child.rows.len()];
            for &(begin, first, length) in &runs {
                if begin + length <= i {
                    continue;
                }
                let skipped = i.saturating_sub(begin);
                let (from, to) = (&values[begin + skipped..begin + length], first + skipped);
                let course = if to < p { SlotCourse::Down } else { SlotCourse::Along };
                self.add_course(p.min(to), p.max(to), course, from);
            }
        }
        self.runs = runs;
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i.min(j) * self.stride + i.max(j)]
    }

    /// Exchanges unknowns p < q of the part that remains from `first` on, and their factors.
    fn swap(&mut self, first: usize, [p, q]: [usize; 2], out: &mut Pivots) {
        if p == q {
            return;
        }
        let n = self.stride;
        self.rows.swap(p, q);
        self.scale.swap(p, q);
        out.swap([p, q]);
        for j in first..p {
            self.values.swap(j * n + p, j * n + q);
        }
        self.values.swap(p * n + p, q * n + q);
        for j in p + 1..q {
            self.values.swap(p * n + j, j * n + q);
        }
        let (above, below) = self.values.split_at_mut(q * n);
        above[p * n + q + 1..(p + 1) * n].swap_with_slice(&mut below[q + 1..n]);
    }

    /// Largest magnitude of column `c` among rows from `k` on other than `c`
    /// and `skip`; and the candidate where it is largest.
    fn largest(&self, k: usize, c: usize, skip: usize) -> (f64, Option<usize>) {
        let (mut all, mut best, mut at) = (0.0_f64, 0.0, None);
        let mut see = |i: usize, value: f64| {
            let size = value.abs();
            if size > all && i != skip {
                all = size;
            }
            if size > best && i < self.candidates && i != skip {
                (best, at) = (size, Some(i));
            }
        };
        for i in k..c {
            see(i, self.values[i * self.stride + c]);
        }
        let row = &self.values[c * self.stride..][..self.rows.len()];
        for i in c + 1..self.candidates {
            see(i, row[i]);
        }
        // Those of others, none of which is skipped, only count for their size.
        (all.max(largest_of(&row[self.candidates..])), at)
    }

    fn choose(&self, k: usize, threshold: f64) -> Choice {
        for c in k..self.candidates {
            let (diagonal, tiny) = (self.at(c, c).abs(), NEGLIGIBLE * self.scale[c]);
            let (gamma, partner) = self.largest(k, c, c);
            if diagonal > tiny && diagonal >= threshold * gamma {
                return Choice::One(c);
            }
            let Some(r) = partner else { continue };
            let (a, b, d) = (self.at(c, c), self.at(c, r), self.at(r, r));
            let determinant = (a * d - b * b).abs();
            let (gc, gr) = (self.largest(k, c, r).0, self.largest(k, r, c).0);
            let growth = (d.abs() * gc + b.abs() * gr).max(b.abs() * gc + a.abs() * gr);
            if b.abs() > tiny && determinant > tiny * b.abs() && growth * threshold <= determinant {
                return Choice::Two(c, r);
            }
        }
        Choice::None
    }

    /// Eliminates every candidate that has a stable pivot; in the last front
    /// (`all`) the rest count as zero eigenvalues.
    pub fn eliminate(&mut self, threshold: f64, all: bool, out: &mut Pivots, inertia: &mut Inertia) {
        out.clear(self.stride);
        let (mut k, mut pending) = (0, 0);
        while k < self.candidates {
            let beside = self.bring(k, pending);
            let diagonal = self.at(k, k).abs();
            if diagonal > NEGLIGIBLE * self.scale[k] && diagonal >= threshold * beside {
                self.pivot_one(k, pending, out, inertia);
                (k, pending) = (k + 1, pending + 1);
                if pending == PANEL {
                    self.update(k, pending);
                    pending = 0;
                }
                continue;
            }
            self.update(k + 1, pending);
            pending = 0;
            match self.choose(k, threshold) {
                Choice::One(c) => self.swap(k, [k, c], out),
                Choice::Two(c, r) => {
                    let (c, r) = (c.min(r), c.max(r));
                    self.swap(k, [k, c], out);
                    self.swap(k, [k + 1, r], out);
                    self.pivot_two(k, out, inertia);
                    (k, pending) = (k + 2, 2);
                }
                Choice::None if all => {
                    self.skip(k, out, inertia);
                    k += 1;
                }
                Choice::None => break,
            }
        }
        self.update(k, pending);
        out.keep(self, k);
    }

    /// Subtracts the last `pending` pivots from the rows from `first` on.
    fn update(&mut self, first: usize, pending: usize) {
        match pending {
            0 => {}
            1 => self.subtract::<1>(first),
            2 => self.subtract::<2>(first),
            3 => self.subtract::<3>(first),
            4 => self.subtract::<4>(first),
            5 => self.subtract::<5>(first),
            6 => self.subtract::<6>(first),
            7 => self.subtract::<7>(first),
            8 => self.subtract::<8>(first),
            9 => self.subtract::<9>(first),
            10 => self.subtract::<10>(first),
            11 => self.subtract::<11>(first),
            _ => self.subtract::<PANEL>(first),
        }
    }

    /// Row i -= sum over the last P pivots p of U_pi times the row of p before its division.
    fn subtract<const P: usize>(&mut self, first: usize) {
        for i in first..self.rows.len() {
            self.subtract_from::<P>(i);
        }
    }

    /// The same of row `i`.
    #[inline(always)]
    fn subtract_from<const P: usize>(&mut self, i: usize) -> &[[f64; CHUNK]] {
        let stride = self.stride;
        let row = self.values[i * stride + chunk_of(i)..(i + 1) * stride].as_chunks_mut().0;
        let panel = &self.panel[i / CHUNK..][..row.len()];
        let mut factors = [f64x4::ZERO; P];
        for p in 0..P {
            factors[p] = f64x4::splat(panel[0].divided[p][i % CHUNK]);
        }
        for j in 0..row.len() {
            let mut sum = f64x4::new(row[j]);
            for p in 0..P {
                sum = f64x4::new(panel[j].whole[p]).mul_neg_add(factors[p], sum);
            }
            row[j] = sum.to_array();
        }
        row
    }

    /// Subtracts the last `pending` pivots from row `k`, the next one; returns its largest magnitude right of the diagonal.
    fn bring(&mut self, k: usize, pending: usize) -> f64 {
        let row = match pending {
            1 => self.subtract_from::<1>(k),
            2 => self.subtract_from::<2>(k),
            3 => self.subtract_from::<3>(k),
            4 => self.subtract_from::<4>(k),
            5 => self.subtract_from::<5>(k),
            6 => self.subtract_from::<6>(k),
            7 => self.subtract_from::<7>(k),
            8 => self.subtract_from::<8>(k),
            9 => self.subtract_from::<9>(k),
            10 => self.subtract_from::<10>(k),
            11 => self.subtract_from::<11>(k),
            _ => self.row(k, k),
        };
        let mut largest = f64x4::new(right_of(k, row[0])).abs();
        for j in 1..row.len() {
            largest = f64x4::new(row[j]).abs().fast_max(largest);
        }
        widest(largest)
    }

    /// Divides row `k` by its diagonal and keeps what it was.
    fn pivot_one(&mut self, k: usize, pending: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let d = self.at(k, k);
        if d > 0.0 {
            inertia.positive += 1;
        } else {
            inertia.negative += 1;
        }
        let inverse = f64x4::splat(1.0 / d);
        let stride = self.stride;
        let chunks = self.values[k * stride + chunk_of(k)..(k + 1) * stride].as_chunks().0;
        let (panel, factors) = (&mut self.panel[k / CHUNK..], out.add(k, d, 0.0, chunks.len()));
        for j in 0..chunks.len().min(panel.len()).min(factors.len()) {
            panel[j].whole[pending] = chunks[j];
            factors[j] = (f64x4::new(chunks[j]) * inverse).to_array();
            panel[j].divided[pending] = factors[j];
        }
        factors[0] = right_of(k, factors[0]);
    }

    fn pivot_two(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let (a, b, d) = (self.at(k, k), self.at(k + 1, k), self.at(k + 1, k + 1));
        let determinant = a * d - b * b;
        match (determinant < 0.0, a + d > 0.0) {
            (true, _) => (inertia.positive, inertia.negative) = (inertia.positive + 1, inertia.negative + 1),
            (false, true) => inertia.positive += 2,
            (false, false) => inertia.negative += 2,
        }
        let stride = self.stride;
        let first = self.values[k * stride + chunk_of(k)..(k + 1) * stride].as_chunks().0;
        let second = self.values[(k + 1) * stride + chunk_of(k + 1)..(k + 2) * stride].as_chunks().0;
        let (skipped, panel) = (first.len() - second.len(), &mut self.panel[(k + 1) / CHUNK..]);
        let (a_, b_, d_) = (f64x4::splat(a), f64x4::splat(b), f64x4::splat(d));
        let determinant = f64x4::splat(determinant);
        for j in 0..second.len() {
            let (c, e) = (f64x4::new(first[skipped + j]), f64x4::new(second[j]));
            let PanelChunk { whole, divided } = &mut panel[j];
            (whole[0], whole[1]) = (c.to_array(), e.to_array());
            divided[0] = ((d_ * c - b_ * e) / determinant).to_array();
            divided[1] = ((a_ * e - b_ * c) / determinant).to_array();
        }
        for (p, skipped) in [(0, skipped), (1, 0)] {
            let length = skipped + second.len();
            let factors = out.add(k + p, [a, d][p], [b, 0.0][p], length);
            factors[..skipped].fill([0.0; CHUNK]);
            for (factor, chunk) in factors[skipped..].iter_mut().zip(&*panel) {
                *factor = chunk.divided[p];
            }
            factors[skipped] = right_of(k + 1, factors[skipped]);
        }
    }

    /// A zero pivot of a singular matrix: its unknown stays zero.
    fn skip(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        inertia.zero += 1;
        out.add(k, f64::INFINITY, 0.0, (self.stride - chunk_of(k)) / CHUNK).fill([0.0; CHUNK]);
    }

    /// The part that was not eliminated, delayed candidates first.
    pub fn remainder_into(&self, pivots: &Pivots, out: &mut Front) {
        let (n, k) = (self.rows.len(), pivots.count);
        out.rows.clear();
        out.rows.extend(&self.rows[k..]);
        out.scale.clear();
        out.scale.extend(&self.scale[k..n]);
        out.candidates = self.candidates - k;
        out.stride = n - k;
        out.values.clear();
        for i in k..n {
            out.values.extend_from_slice(&self.values[i * self.stride + k..][..n - k]);
        }
    }
}

impl Pivots {
    /// None yet, of a front with padded rows of the length `stride`.
    fn clear(&mut self, stride: usize) {
        self.stride = stride;
        self.filled = 0;
        self.diagonal.clear();
        self.coupling.clear();
    }

    /// Adds the pivot of row `k`; returns the room for its row, `length` chunks.
    #[inline]
    fn add(&mut self, k: usize, diagonal: f64, coupling: f64, length: usize) -> &mut [[f64; CHUNK]] {
        debug_assert_eq!(k, self.diagonal.len());
        self.diagonal.push(diagonal);
        self.coupling.push(coupling);
        let begin = self.filled;
        self.filled += length;
        if self.factors.len() < self.filled {
            self.factors.resize(self.filled, [0.0; CHUNK]);
        }
        &mut self.factors[begin..self.filled]
    }

    /// Exchanges columns p < q, which come after the pivots.
    fn swap(&mut self, [p, q]: [usize; 2]) {
        let mut begin = 0;
        for k in 0..self.diagonal.len() {
            let place = |column: usize| (column - chunk_of(k)) / CHUNK;
            let row = &mut self.factors[begin..begin + place(self.stride)];
            let (a, b) = (row[place(p)][p % CHUNK], row[place(q)][q % CHUNK]);
            (row[place(p)][p % CHUNK], row[place(q)][q % CHUNK]) = (b, a);
            begin += row.len();
        }
    }

    /// Takes over the unknowns of a front whose first `count` ones are eliminated.
    fn keep(&mut self, front: &Front, count: usize) {
        self.count = count;
        self.rows.clear();
        self.rows.extend_from_slice(&front.rows);
    }

    /// The values of `x` at this front's unknowns, padded with zeros.
    fn gather(&self, x: &[f64], local: &mut Vec<f64>) {
        local.clear();
        local.extend(self.rows.iter().map(|&i| x[i]));
        local.resize(self.stride, 0.0);
    }

    /// x := U^-T x on this front's unknowns.
    pub fn forward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        self.gather(x, local);
        let mut rows = self.factors.as_slice();
        for first in (0..self.count).step_by(CHUNK) {
            let of: RowsOfChunk;
            (of, rows) = self.split_rows(rows, first);
            let (own, tail) = local[first..].as_chunks_mut().0.split_at_mut(1);
            let mut heads = [f64x4::ZERO; CHUNK];
            for p in 0..CHUNK {
                let head = own[0][p];
                for l in p + 1..CHUNK {
                    if let Some(row) = of[p].first() {
                        own[0][l] -= row[l] * head;
                    }
                }
                heads[p] = f64x4::splat(if of[p].is_empty() { 0.0 } else { head });
            }
            let (tail, [a, b, c, d]) = (&mut tail[..of[0].len() - 1], tails(&of));
            for j in 0..tail.len() {
                let sum = f64x4::new(a[j]).mul_neg_add(heads[0], f64x4::new(tail[j]));
                let sum = f64x4::new(b[j]).mul_neg_add(heads[1], sum);
                let sum = f64x4::new(c[j]).mul_neg_add(heads[2], sum);
                tail[j] = f64x4::new(d[j]).mul_neg_add(heads[3], sum).to_array();
            }
        }
        for k in 0..self.rows.len() {
            x[self.rows[k]] = local[k];
        }
    }

    /// The rows of pivots whose diagonals are in the chunk of column `first`, none of those that are no pivots, and what follows.
    fn split_rows<'r>(
        &self,
        rows: &'r [[f64; CHUNK]],
        first: usize,
    ) -> (RowsOfChunk<'r>, &'r [[f64; CHUNK]]) {
        let (length, count) = ((self.stride - first) / CHUNK, (self.count - first).min(CHUNK));
        let (own, rest) = rows.split_at(count * length);
        let mut of = [[].as_slice(); CHUNK];
        for p in 0..count {
            of[p] = &own[p * length..][..length];
        }
        (of, rest)
    }

    /// x := U^-1 D^-1 x on this front's unknowns.
    pub fn backward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        self.gather(x, local);
        self.divide(local);
        let mut end = self.filled;
        for first in (0..self.count).step_by(CHUNK).rev() {
            end -= (self.stride - first) / CHUNK * (self.count - first).min(CHUNK);
            let (of, _) = self.split_rows(&self.factors[end..], first);
            let (own, tail) = local[first..].as_chunks_mut().0.split_at_mut(1);
            let (tail, [a, b, c, d]) = (&tail[..of[0].len() - 1], tails(&of));
            let mut sums = [f64x4::ZERO; CHUNK];
            for j in 0..tail.len() {
                let tail = f64x4::new(tail[j]);
                sums[0] = f64x4::new(a[j]).mul_add(tail, sums[0]);
                sums[1] = f64x4::new(b[j]).mul_add(tail, sums[1]);
                sums[2] = f64x4::new(c[j]).mul_add(tail, sums[2]);
                sums[3] = f64x4::new(d[j]).mul_add(tail, sums[3]);
            }
            for p in (0..CHUNK).rev() {
                if let Some(row) = of[p].first() {
                    let mut sum = sums[p].reduce_add();
                    for l in p + 1..CHUNK {
                        sum += row[l] * own[0][l];
                    }
                    own[0][p] -= sum;
                }
            }
        }
        for k in 0..self.count {
            x[self.rows[k]] = local[k];
        }
    }

    fn divide(&self, y: &mut [f64]) {
        let mut k = 0;
        while k < self.count {
            let b = self.coupling[k];
            if b == 0.0 {
                y[k] /= self.diagonal[k];
                k += 1;
                continue;
            }
            let (a, d) = (self.diagonal[k], self.diagonal[k + 1]);
            let determinant = a * d - b * b;
            (y[k], y[k + 1]) =
                ((d * y[k] - b * y[k + 1]) / determinant, (a * y[k + 1] - b * y[k]) / determinant);
            k += 2;
        }
    }
}

/// The largest magnitude.
fn largest_of(values: &[f64]) -> f64 {
    let (chunks, rest) = values.as_chunks();
    let mut largest = f64x4::ZERO;
    for i in 0..chunks.len() {
        largest = f64x4::new(chunks[i]).abs().fast_max(largest);
    }
    let mut all = widest(largest);
    for i in 0..rest.len() {
        all = all.max(rest[i].abs());
    }
    all
}

/// The largest of four numbers.
fn widest(x: f64x4) -> f64 {
    let larger = |a: f64, b: f64| if a > b { a } else { b };
    let [a, b, c, d] = x.to_array();
    larger(larger(a, b), larger(c, d))
}
