//! One dense front: its partial factorisation and its part of the solves.

use super::Inertia;
use crate::rows::{axpy, dot, fused};

/// A dense symmetric matrix over the unknowns `rows`, of which the first
/// `candidates` may be eliminated. Upper triangle, row-major, full stride.
#[derive(Clone, Debug, Default)]
pub struct Front {
    pub rows: Vec<usize>,
    pub candidates: usize,
    values: Vec<f64>,
    /// Largest magnitude each unknown's column had when it was assembled.
    scale: Vec<f64>,
    /// Rows of the last pivots before their division, for the rows below.
    pivots: [Vec<f64>; PANEL],
}

/// Pivots of order one whose updates are applied together.
const PANEL: usize = 4;

/// The eliminated part of a front: P' A P = U' D U for its leading rows.
#[derive(Clone, Debug, Default)]
pub struct Pivots {
    rows: Vec<usize>,
    count: usize,
    /// U, the first `count` rows over the unknowns of the front.
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
        self.values.clear();
        self.values.resize(self.rows.len() * self.rows.len(), 0.0);
        self.scale.clear();
        self.scale.resize(self.rows.len(), f64::MIN_POSITIVE);
    }

    /// Notes the size of the candidates' columns, once the front is assembled.
    pub fn measure(&mut self) {
        let n = self.rows.len();
        for i in 0..self.candidates {
            let row = &self.values[i * n + i..(i + 1) * n];
            let scale = &mut self.scale[i..][..row.len()];
            let mut largest = scale[0];
            for j in 0..row.len() {
                let v = row[j].abs();
                largest = if v > largest { v } else { largest };
                scale[j] = if v > scale[j] { v } else { scale[j] };
            }
            scale[0] = largest;
        }
    }

    /// Adds `value` at row `i` and column `j`, which is not before it.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        self.values[i * self.rows.len() + j] += value;
    }

    /// Adds `values` from row `i` and column `j` on, down the column or along the row.
    pub fn add_along(&mut self, i: usize, j: usize, down: bool, values: &[f64]) {
        let (n, first) = (self.rows.len(), i * self.rows.len() + j);
        if down {
            for k in 0..values.len() {
                self.values[first + k * n] += values[k];
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
                self.add(p.min(q), p.max(q), child.values[i * m + j]);
            }
        }
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i.min(j) * self.rows.len() + i.max(j)]
    }

    /// Exchanges unknowns p < q of the remaining part (and their factors).
    fn swap(&mut self, p: usize, q: usize) {
        if p == q {
            return;
        }
        let n = self.rows.len();
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
        let n = self.rows.len();
        let row = &self.values[k * n + k + 1..(k + 1) * n];
        let mut largest = 0.0;
        for j in 0..row.len() {
            let v = row[j].abs();
            largest = if v > largest { v } else { largest };
        }
        largest
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
            self.update(k, k..k + 1, pending);
            if self.is_pivot(k, threshold) {
                self.pivot_one(k, pending, out, inertia);
                (k, pending) = (k + 1, pending + 1);
                if pending == PANEL {
                    self.update(k, k..self.rows.len(), pending);
                    pending = 0;
                }
                continue;
            }
            self.update(k, k + 1..self.rows.len(), pending);
            pending = 0;
            match self.choose(k, threshold) {
                Choice::One(c) => self.swap(k, c),
                Choice::Two(c, r) => {
                    let (c, r) = (c.min(r), c.max(r));
                    self.swap(k, c);
                    self.swap(k + 1, r);
                    self.pivot_two(k, out, inertia);
                    k += 2;
                }
                Choice::None if all => {
                    self.skip(k, out, inertia);
                    k += 1;
                }
                Choice::None => break,
            }
        }
        self.update(k, k..self.rows.len(), pending);
        out.keep(&self.rows, &mut self.values, k);
    }

    /// Subtracts the last `pending` pivots before row `k` from `rows`.
    fn update(&mut self, k: usize, rows: std::ops::Range<usize>, pending: usize) {
        let n = self.rows.len();
        let (above, below) = self.values.split_at_mut(k * n);
        let factor = |p: usize, i: usize| above[(k - pending + p) * n + i];
        for i in rows {
            let row = &mut below[(i - k) * n + i..(i - k + 1) * n];
            if pending == PANEL {
                let [one, two, three, four] = &self.pivots;
                let rows = [&one[i..n], &two[i..n], &three[i..n], &four[i..n]];
                subtract_panel(row, [factor(0, i), factor(1, i), factor(2, i), factor(3, i)], rows);
                continue;
            }
            for p in 0..pending {
                axpy(row, -factor(p, i), &self.pivots[p][i..n]);
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
        let n = self.rows.len();
        let row = &mut self.values[k * n..(k + 1) * n];
        let d = row[k];
        out.diagonal.push(d);
        out.coupling.push(0.0);
        if d > 0.0 {
            inertia.positive += 1;
        } else {
            inertia.negative += 1;
        }
        self.pivots[pending].clear();
        self.pivots[pending].extend(&*row);
        for j in k + 1..n {
            row[j] /= d;
        }
    }

    fn pivot_two(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let n = self.rows.len();
        let (a, b, d) = (self.at(k, k), self.at(k + 1, k), self.at(k + 1, k + 1));
        out.diagonal.extend([a, d]);
        out.coupling.extend([b, 0.0]);
        let determinant = a * d - b * b;
        match (determinant < 0.0, a + d > 0.0) {
            (true, _) => (inertia.positive, inertia.negative) = (inertia.positive + 1, inertia.negative + 1),
            (false, true) => inertia.positive += 2,
            (false, false) => inertia.negative += 2,
        }
        let (above, below) = self.values.split_at_mut((k + 2) * n);
        let (first, second) = above[k * n..].split_at_mut(n);
        first[k + 1] = 0.0;
        let (first, second) = (&mut first[k + 2..], &mut second[k + 2..]);
        let [one, two, ..] = &mut self.pivots;
        one.clear();
        one.extend(&*first);
        two.clear();
        two.extend(&*second);
        for (c, e) in first.iter_mut().zip(second.iter_mut()) {
            (*c, *e) = ((d * *c - b * *e) / determinant, (a * *e - b * *c) / determinant);
        }
        for (i, (fc, fe)) in first.iter().zip(second.iter()).enumerate() {
            let row = &mut below[i * n + k + 2 + i..(i + 1) * n];
            axpy(row, -fc, &one[i..]);
            axpy(row, -fe, &two[i..]);
        }
    }

    /// A zero pivot of a singular matrix: its unknown stays zero.
    fn skip(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let n = self.rows.len();
        inertia.zero += 1;
        out.diagonal.push(f64::INFINITY);
        out.coupling.push(0.0);
        self.values[k * n + k + 1..(k + 1) * n].fill(0.0);
    }

    /// The part that was not eliminated, delayed candidates first; its values
    /// are still with `pivots`.
    pub fn remainder_into(&self, pivots: &Pivots, out: &mut Front) {
        let (n, k) = (self.rows.len(), pivots.count);
        out.rows.clear();
        out.rows.extend(&self.rows[k..]);
        out.scale.clear();
        out.scale.extend(&self.scale[k..]);
        out.candidates = self.candidates - k;
        out.values.clear();
        for i in k..n {
            out.values.extend(&pivots.factors[i * n + k..(i + 1) * n]);
        }
    }
}

impl Pivots {
    /// Takes the values of a front of which `count` rows are eliminated.
    fn keep(&mut self, rows: &[usize], values: &mut Vec<f64>, count: usize) {
        self.count = count;
        self.rows.clear();
        self.rows.extend(rows);
        std::mem::swap(&mut self.factors, values);
    }

    /// Rows of U.
    fn pivot_rows(&self) -> impl DoubleEndedIterator<Item = (usize, &[f64])> {
        let n = self.rows.len();
        (0..self.count).map(move |k| (k, &self.factors[k * n..(k + 1) * n]))
    }

    /// x := U^-T x on this front's unknowns.
    pub fn forward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        local.clear();
        local.extend(self.rows.iter().map(|&i| x[i]));
        for (k, row) in self.pivot_rows() {
            let (head, tail) = local.split_at_mut(k + 1);
            axpy(tail, -head[k], &row[k + 1..]);
        }
        for k in 0..self.rows.len() {
            x[self.rows[k]] = local[k];
        }
    }

    /// x := U^-1 D^-1 x on this front's unknowns.
    pub fn backward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        local.clear();
        local.extend(self.rows.iter().map(|&i| x[i]));
        self.divide(local);
        for (k, row) in self.pivot_rows().rev() {
            local[k] -= dot(&row[k + 1..], &local[k + 1..]);
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

/// y -= sum_p a_p x_p
#[inline]
fn subtract_panel(y: &mut [f64], a: [f64; PANEL], x: [&[f64]; PANEL]) {
    let n = y.len();
    let [x0, x1, x2, x3] = [&x[0][..n], &x[1][..n], &x[2][..n], &x[3][..n]];
    for j in 0..n {
        y[j] -= fused(a[0], x0[j], fused(a[1], x1[j], fused(a[2], x2[j], a[3] * x3[j])));
    }
}
