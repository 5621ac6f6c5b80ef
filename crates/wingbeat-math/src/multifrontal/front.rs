//! One dense front: its partial factorisation and its part of the solves.

use super::Inertia;
use wide::f64x4;

/// Columns swept together; rows are padded to whole chunks of them.
const CHUNK: usize = 4;

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
}

/// Pivots whose updates are applied together.
const PANEL: usize = 8;

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
    factors: Vec<f64>,
    /// D: the diagonal, and the off-diagonal where a pivot of order two starts.
    diagonal: Vec<f64>,
    coupling: Vec<f64>,
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
    pub fn clear(&mut self) {
        self.rows.clear();
        self.candidates = 0;
    }

    /// Zero values for the present rows.
    pub fn reset(&mut self) {
        self.stride = self.rows.len().next_multiple_of(CHUNK);
        self.values.clear();
        self.values.resize(self.rows.len() * self.stride, 0.0);
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

    /// Notes the size of the candidates' columns, once the front is assembled.
    pub fn measure(&mut self) {
        for i in 0..self.candidates {
            let row =
                self.values[i * self.stride + chunk_of(i)..(i + 1) * self.stride].as_chunks::<CHUNK>().0;
            let scale = &mut self.scale[chunk_of(i)..].as_chunks_mut::<CHUNK>().0[..row.len()];
            let mut largest = f64x4::ZERO;
            for j in 0..row.len() {
                let sizes = f64x4::new(row[j]).abs();
                largest = sizes.fast_max(largest);
                scale[j] = sizes.fast_max(f64x4::new(scale[j])).to_array();
            }
            self.scale[i] = self.scale[i].max(widest(largest));
        }
    }

    /// Adds `value` at row `i` and column `j`, which is not before it.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.values[i * self.stride + j] += value;
    }

    /// Adds `values` from row `i` and column `j` on, down the column or along the row.
    pub fn add_along(&mut self, i: usize, j: usize, down: bool, values: &[f64]) {
        let (stride, first) = (self.stride, i * self.stride + j);
        if down {
            for k in 0..values.len() {
                self.values[first + k * stride] += values[k];
            }
        } else {
            let row = &mut self.values[first..][..values.len()];
            for k in 0..values.len() {
                row[k] += values[k];
            }
        }
    }

    /// Adds a child's remainder; `position` maps unknowns to rows here.
    pub fn extend_add(&mut self, child: &Front, position: &[usize]) {
        let m = child.rows.len();
        for i in 0..m {
            let p = position[child.rows[i]];
            if i < child.candidates {
                self.scale[p] = self.scale[p].max(child.scale[i]);
            }
            for j in i..m {
                let q = position[child.rows[j]];
                self.add(p.min(q), p.max(q), child.values[i * child.stride + j]);
            }
        }
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i.min(j) * self.stride + i.max(j)]
    }

    /// Exchanges unknowns p < q of the remaining part (and their factors).
    fn swap(&mut self, p: usize, q: usize) {
        if p == q {
            return;
        }
        let n = self.stride;
        self.rows.swap(p, q);
        self.scale.swap(p, q);
        for j in 0..p {
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
        for i in k..self.rows.len() {
            if i == c || i == skip {
                continue;
            }
            let v = self.at(i, c).abs();
            all = all.max(v);
            if i < self.candidates && v > best {
                (best, at) = (v, Some(i));
            }
        }
        (all, at)
    }

    /// Largest magnitude of row `k` right of the diagonal.
    fn largest_right(&self, k: usize) -> f64 {
        let (left, row) = (k - chunk_of(k), self.row(k, k));
        let mut beside = row[0];
        for l in 0..=left {
            beside[l] = 0.0;
        }
        let mut largest = f64x4::new(beside).abs();
        for j in 1..row.len() {
            largest = f64x4::new(row[j]).abs().fast_max(largest);
        }
        widest(largest)
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
        out.diagonal.clear();
        out.coupling.clear();
        let (mut k, mut pending) = (0, 0);
        while k < self.candidates {
            self.update(k..k + 1, pending);
            if self.is_pivot(k, threshold) {
                self.pivot_one(k, pending, out, inertia);
                (k, pending) = (k + 1, pending + 1);
                if pending == PANEL {
                    self.update(k..self.rows.len(), pending);
                    pending = 0;
                }
                continue;
            }
            self.update(k + 1..self.rows.len(), pending);
            pending = 0;
            match self.choose(k, threshold) {
                Choice::One(c) => self.swap(k, c),
                Choice::Two(c, r) => {
                    let (c, r) = (c.min(r), c.max(r));
                    self.swap(k, c);
                    self.swap(k + 1, r);
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
        self.update(k..self.rows.len(), pending);
        out.keep(self, k);
    }

    /// Subtracts the last `pending` pivots from `rows`.
    fn update(&mut self, rows: std::ops::Range<usize>, pending: usize) {
        match pending {
            0 => {}
            1 => self.subtract::<1>(rows),
            2 => self.subtract::<2>(rows),
            3 => self.subtract::<3>(rows),
            4 => self.subtract::<4>(rows),
            5 => self.subtract::<5>(rows),
            6 => self.subtract::<6>(rows),
            7 => self.subtract::<7>(rows),
            _ => self.subtract::<PANEL>(rows),
        }
    }

    /// Row i -= sum over the last P pivots p of U_pi times the row of p before its division.
    fn subtract<const P: usize>(&mut self, rows: std::ops::Range<usize>) {
        let stride = self.stride;
        for i in rows {
            let row = self.values[i * stride + chunk_of(i)..(i + 1) * stride].as_chunks_mut().0;
            let panel = &self.panel[i / CHUNK..][..row.len()];
            let mut factors = [f64x4::ZERO; P];
            for p in 0..P {
                factors[p] = f64x4::splat(-panel[0].divided[p][i % CHUNK]);
            }
            for j in 0..row.len() {
                let mut sum = f64x4::new(row[j]);
                for p in 0..P {
                    sum = f64x4::new(panel[j].whole[p]).mul_add(factors[p], sum);
                }
                row[j] = sum.to_array();
            }
        }
    }

    /// True when the diagonal of row `k` is a stable pivot.
    fn is_pivot(&self, k: usize, threshold: f64) -> bool {
        let diagonal = self.at(k, k).abs();
        diagonal > NEGLIGIBLE * self.scale[k] && diagonal >= threshold * self.largest_right(k)
    }

    /// Divides row `k` by its diagonal and keeps what it was.
    fn pivot_one(&mut self, k: usize, pending: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let (stride, first) = (self.stride, chunk_of(k));
        let row = &mut self.values[k * stride..(k + 1) * stride];
        let d = row[k];
        out.diagonal.push(d);
        out.coupling.push(0.0);
        if d > 0.0 {
            inertia.positive += 1;
        } else {
            inertia.negative += 1;
        }
        let inverse = f64x4::splat(1.0 / d);
        let (panel, chunks) = (&mut self.panel[k / CHUNK..], row[first..].as_chunks_mut().0);
        for j in 0..chunks.len().min(panel.len()) {
            panel[j].whole[pending] = chunks[j];
            chunks[j] = (f64x4::new(chunks[j]) * inverse).to_array();
            panel[j].divided[pending] = chunks[j];
        }
        for j in first..=k {
            row[j] = 0.0;
        }
    }

    fn pivot_two(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let s = self.stride;
        let (a, b, d) = (self.at(k, k), self.at(k + 1, k), self.at(k + 1, k + 1));
        out.diagonal.extend([a, d]);
        out.coupling.extend([b, 0.0]);
        let determinant = a * d - b * b;
        match (determinant < 0.0, a + d > 0.0) {
            (true, _) => (inertia.positive, inertia.negative) = (inertia.positive + 1, inertia.negative + 1),
            (false, true) => inertia.positive += 2,
            (false, false) => inertia.negative += 2,
        }
        let (first, second) = self.values[k * s..(k + 2) * s].split_at_mut(s);
        first[..=k + 1].fill(0.0);
        second[..=k + 1].fill(0.0);
        let begin = chunk_of(k + 2);
        let (first, second) = (&mut first[begin..], &mut second[begin..]);
        for l in 0..first.len().min(second.len()) {
            let (c, e) = (first[l], second[l]);
            let PanelChunk { whole, divided } = &mut self.panel[(begin + l) / CHUNK];
            (whole[0][l % CHUNK], whole[1][l % CHUNK]) = (c, e);
            (first[l], second[l]) = ((d * c - b * e) / determinant, (a * e - b * c) / determinant);
            (divided[0][l % CHUNK], divided[1][l % CHUNK]) = (first[l], second[l]);
        }
    }

    /// A zero pivot of a singular matrix: its unknown stays zero.
    fn skip(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let n = self.stride;
        inertia.zero += 1;
        out.diagonal.push(f64::INFINITY);
        out.coupling.push(0.0);
        self.values[k * n + chunk_of(k)..(k + 1) * n].fill(0.0);
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
    /// Takes over the first `count` rows of a front, which are eliminated.
    fn keep(&mut self, front: &Front, count: usize) {
        (self.count, self.stride) = (count, front.stride);
        self.rows.clear();
        self.rows.extend_from_slice(&front.rows);
        self.factors.clear();
        for k in 0..count {
            self.factors.extend_from_slice(front.row(k, k).as_flattened());
        }
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
        let mut rows = self.factors.as_chunks().0;
        for k in 0..self.count {
            let (head, first) = (local[k], chunk_of(k));
            let row;
            (row, rows) = rows.split_at((self.stride - first) / CHUNK);
            let tail = &mut local[first..].as_chunks_mut().0[..row.len()];
            let factor = f64x4::splat(-head);
            for j in 0..row.len() {
                tail[j] = f64x4::new(row[j]).mul_add(factor, f64x4::new(tail[j])).to_array();
            }
        }
        for k in 0..self.rows.len() {
            x[self.rows[k]] = local[k];
        }
    }

    /// x := U^-1 D^-1 x on this front's unknowns.
    pub fn backward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        self.gather(x, local);
        self.divide(local);
        let mut rows = self.factors.as_chunks().0;
        for k in (0..self.count).rev() {
            let first = chunk_of(k);
            let row;
            (rows, row) = rows.split_at(rows.len() - (self.stride - first) / CHUNK);
            let tail = &local[first..].as_chunks().0[..row.len()];
            let mut sum = f64x4::ZERO;
            for j in 0..row.len() {
                sum = f64x4::new(row[j]).mul_add(f64x4::new(tail[j]), sum);
            }
            local[k] -= sum.reduce_add();
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

/// The largest of four numbers.
fn widest(x: f64x4) -> f64 {
    let [a, b, c, d] = x.to_array();
    a.max(b).max(c.max(d))
}
