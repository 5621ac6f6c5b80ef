//! One dense front: its partial factorisation and its part of the solves.

use super::Inertia;

/// A dense symmetric matrix over the unknowns `rows`, of which the first
/// `candidates` may be eliminated. Lower triangle, row-major, full stride.
#[derive(Clone, Debug, Default)]
pub struct Front {
    pub rows: Vec<usize>,
    pub candidates: usize,
    values: Vec<f64>,
    /// Largest magnitude each unknown's column had when it was assembled.
    scale: Vec<f64>,
    column: Vec<f64>,
    second: Vec<f64>,
}

/// The eliminated part of a front: P' A P = L D L' for its leading columns.
#[derive(Clone, Debug, Default)]
pub struct Pivots {
    rows: Vec<usize>,
    count: usize,
    /// Multipliers, one row of `count` per unknown of the front.
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

    /// Notes the size of the columns, once the front is assembled.
    pub fn measure(&mut self) {
        let n = self.rows.len();
        for i in 0..n {
            for j in 0..=i {
                let v = self.values[i * n + j].abs();
                self.scale[i] = self.scale[i].max(v);
                self.scale[j] = self.scale[j].max(v);
            }
        }
    }

    #[inline]
    pub fn add(&mut self, i: usize, j: usize, value: f64) {
        let n = self.rows.len();
        self.values[i.max(j) * n + i.min(j)] += value;
    }

    /// Adds a child's remainder; `position` maps unknowns to rows here.
    pub fn extend_add(&mut self, child: &Front, position: &[usize]) {
        let m = child.rows.len();
        for i in 0..m {
            let p = position[child.rows[i]];
            if i < child.candidates {
                self.scale[p] = self.scale[p].max(child.scale[i]);
            }
            for j in 0..=i {
                self.add(p, position[child.rows[j]], child.values[i * m + j]);
            }
        }
    }

    #[inline]
    fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i.max(j) * self.rows.len() + i.min(j)]
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
            self.values.swap(p * n + j, q * n + j);
        }
        self.values.swap(p * n + p, q * n + q);
        for j in p + 1..q {
            self.values.swap(j * n + p, q * n + j);
        }
        for i in q + 1..n {
            self.values.swap(i * n + p, i * n + q);
        }
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
        let n = self.rows.len();
        out.diagonal.clear();
        out.coupling.clear();
        let mut k = 0;
        while k < self.candidates {
            match self.choose(k, threshold) {
                Choice::One(c) => {
                    self.swap(k, c);
                    self.pivot_one(k, out, inertia);
                    k += 1;
                }
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
        out.keep(&self.rows, &self.values, n, k);
    }

    fn pivot_one(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let n = self.rows.len();
        let d = self.values[k * n + k];
        out.diagonal.push(d);
        out.coupling.push(0.0);
        if d > 0.0 {
            inertia.positive += 1;
        } else {
            inertia.negative += 1;
        }
        self.column.clear();
        self.column.extend((k + 1..n).map(|i| self.values[i * n + k]));
        for i in k + 1..n {
            let c = self.column[i - k - 1];
            if c == 0.0 {
                continue;
            }
            let factor = c / d;
            let row = &mut self.values[i * n + k..=i * n + i];
            row[0] = factor;
            for (v, c) in row[1..].iter_mut().zip(&self.column) {
                *v -= factor * c;
            }
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
        self.column.clear();
        self.column.extend((k + 2..n).map(|i| self.values[i * n + k]));
        self.second.clear();
        self.second.extend((k + 2..n).map(|i| self.values[i * n + k + 1]));
        self.values[(k + 1) * n + k] = 0.0;
        for i in k + 2..n {
            let (c, e) = (self.column[i - k - 2], self.second[i - k - 2]);
            if c == 0.0 && e == 0.0 {
                continue;
            }
            let (fc, fe) = ((d * c - b * e) / determinant, (a * e - b * c) / determinant);
            let row = &mut self.values[i * n + k..=i * n + i];
            (row[0], row[1]) = (fc, fe);
            for ((v, c), e) in row[2..].iter_mut().zip(&self.column).zip(&self.second) {
                *v -= fc * c + fe * e;
            }
        }
    }

    /// A zero pivot of a singular matrix: its unknown stays zero.
    fn skip(&mut self, k: usize, out: &mut Pivots, inertia: &mut Inertia) {
        let n = self.rows.len();
        inertia.zero += 1;
        out.diagonal.push(f64::INFINITY);
        out.coupling.push(0.0);
        for i in k + 1..n {
            self.values[i * n + k] = 0.0;
        }
    }

    /// The part that was not eliminated, delayed candidates first.
    pub fn remainder_into(&self, pivots: &Pivots, out: &mut Front) {
        let (n, k) = (self.rows.len(), pivots.count);
        out.rows.clear();
        out.rows.extend(&self.rows[k..]);
        out.scale.clear();
        out.scale.extend(&self.scale[k..]);
        out.candidates = self.candidates - k;
        out.values.clear();
        for i in k..n {
            out.values.extend(&self.values[i * n + k..(i + 1) * n]);
        }
    }
}

impl Pivots {
    fn keep(&mut self, rows: &[usize], values: &[f64], n: usize, count: usize) {
        self.count = count;
        self.rows.clear();
        self.rows.extend(rows);
        self.factors.clear();
        for i in 0..n {
            self.factors.extend(&values[i * n..i * n + count]);
        }
    }

    /// x := L^-1 x on this front's unknowns.
    pub fn forward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        let m = self.count;
        local.clear();
        local.extend(self.rows[..m].iter().map(|&i| x[i]));
        for i in 0..m {
            let row = &self.factors[i * m..i * m + i];
            local[i] -= dot(row, &local[..i]);
        }
        for (&i, v) in self.rows[..m].iter().zip(local.iter()) {
            x[i] = *v;
        }
        for (k, &i) in self.rows.iter().enumerate().skip(m) {
            x[i] -= dot(&self.factors[k * m..(k + 1) * m], local);
        }
    }

    /// x := L^-T D^-1 x on this front's unknowns.
    pub fn backward(&self, x: &mut [f64], local: &mut Vec<f64>) {
        let m = self.count;
        local.clear();
        local.extend(self.rows[..m].iter().map(|&i| x[i]));
        self.divide(local);
        for (k, &i) in self.rows.iter().enumerate().skip(m) {
            subtract(local, x[i], &self.factors[k * m..(k + 1) * m]);
        }
        for i in (0..m).rev() {
            let (head, tail) = local.split_at_mut(i);
            subtract(head, tail[0], &self.factors[i * m..i * m + i]);
        }
        for (&i, v) in self.rows[..m].iter().zip(local.iter()) {
            x[i] = *v;
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

#[inline]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// y -= a x
#[inline]
fn subtract(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= a * x;
    }
}
