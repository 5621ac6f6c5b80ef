//! Derivatives of a collocated problem, interval by interval, dense over the
//! columns of the interval: its own unknowns, then times and parameters.

use super::layout::{StateOf, UnknownLayout};
use super::points::MIDDLE;
use super::*;
use wingbeat_math::rows::{axpy, axpy_four};

/// A local unknown of a point as shares of two columns of its interval.
pub(super) type Shares = [(usize, f64); 2];

/// The local unknowns of a point in the columns of its interval.
#[derive(Clone, Debug)]
pub(super) struct PointMap {
    /// Shares of each local unknown.
    pub shares: Vec<Shares>,
    /// The locals 1 to `run` are the columns from `start` on, one by one.
    start: usize,
    run: usize,
}

impl PointMap {
    fn new(shares: Vec<Shares>) -> Self {
        let start = shares[1][0].0;
        let next = |(i, s): (usize, &Shares)| *s == [(start + i, 1.0), (s[1].0, 0.0)];
        let run = shares[1..].iter().enumerate().take_while(|s| next(*s)).count();
        Self { shares, start, run }
    }

    /// row += factor (slopes over the locals, as columns).
    fn add(&self, row: &mut [f64], factor: f64, slopes: &[f64]) {
        let run = 1..1 + self.run;
        axpy(&mut row[self.start..], factor, &slopes[run.clone()]);
        self.add_apart(row, factor, slopes, 0..run.start);
        self.add_apart(row, factor, slopes, run.end..slopes.len());
    }

    /// The same of locals that are no columns of their own.
    fn add_apart(&self, row: &mut [f64], factor: f64, slopes: &[f64], locals: std::ops::Range<usize>) {
        for v in locals {
            if slopes[v] != 0.0 {
                let [(a, one), (b, two)] = self.shares[v];
                row[a] += factor * slopes[v] * one;
                row[b] += factor * slopes[v] * two;
            }
        }
    }
}

/// Maps from the columns of an interval to the local unknowns of its points,
/// and the scratch of one interval.
#[derive(Clone, Debug)]
pub(super) struct Assembly {
    /// Columns of an interval; those before `own` are its own unknowns.
    pub width: usize,
    pub own: usize,
    /// Points of an interval.
    points: usize,
    /// Shares of each local unknown, for each point of each interval.
    maps: Vec<PointMap>,
    /// d locals / d columns of a middle point, row-major.
    middle: Vec<f64>,
    /// A row of the Hessian of a middle point times `middle`.
    product: Vec<f64>,
    /// Slopes of the weighted rates and cost of a point along its local unknowns.
    pub slopes: Vec<f64>,
    /// The sum of those of the points of an interval along its columns.
    span_slopes: Vec<f64>,
    /// Hessian, row-major; the upper triangle counts.
    pub block: Vec<f64>,
}

impl Assembly {
    pub fn new(setup: &Setup, scheme: &Scheme, layout: &UnknownLayout) -> Self {
        let own = layout.intervals[0].columns[1] - layout.intervals[0].columns[0];
        let (width, points) = (own + 2 + setup.parameters.len(), scheme.points());
        let intervals = layout.intervals.iter().enumerate();
        let place = |(k, interval): (usize, &layout::IntervalPlace)| -> Vec<PointMap> {
            let [first, last] = interval.ends;
            (first..=last).map(|i| PointMap::new(shares(setup, layout, i, k))).collect()
        };
        let maps: Vec<PointMap> = intervals.flat_map(place).collect();
        let locals = maps[0].shares.len();
        Self {
            width,
            own,
            points,
            maps,
            middle: vec![0.0; locals * width],
            product: vec![0.0; width],
            slopes: vec![0.0; locals],
            span_slopes: vec![0.0; width],
            block: vec![0.0; width * width],
        }
    }

    /// The local unknowns of point `j` of interval `k`.
    pub fn map(&self, k: usize, j: usize) -> &PointMap {
        &self.maps[k * self.points + j]
    }

    /// Adds `value` and its mirror image to the Hessian.
    fn add_pair(&mut self, a: usize, b: usize, value: f64) {
        let value = if a == b { 2.0 * value } else { value };
        self.block[a.min(b) * self.width + a.max(b)] += value;
    }

    /// Adds the products of the time span with the slopes of the points.
    fn add_span_products(&mut self) {
        for c in 0..self.width {
            let slope = self.span_slopes[c];
            self.add_pair(c, self.own, -slope);
            self.add_pair(c, self.own + 1, slope);
        }
    }
}

/// Shares of the local unknowns of point `i`; those of a middle state follow
/// from the rates at the ends and are left zero.
fn shares(setup: &Setup, layout: &UnknownLayout, i: usize, k: usize) -> Vec<Shares> {
    let (place, [first, end]) = (&layout.points[i], layout.intervals[k].columns);
    let (n, m, own) = (setup.states.len(), setup.inputs.len(), end - first);
    let mut map = vec![[(own, 1.0 - place.sigma), (own + 1, place.sigma)]];
    map.extend((0..n).map(|r| match place.x {
        StateOf::Unknown(x) => [(x + r - first, 1.0), (0, 0.0)],
        StateOf::Middle(_) => [(0, 0.0); 2],
    }));
    let [(a, wa), (b, wb)] = place.u;
    map.extend((0..m).map(|j| [(a + j - first, wa), (b + j - first, wb)]));
    map.extend((0..setup.parameters.len()).map(|q| [(own + 2 + q, 1.0), (0, 0.0)]));
    map
}

/// row += factor (slopes . rows), of rows as long as `row`.
fn add_rows(row: &mut [f64], factor: f64, slopes: &[f64], rows: &[f64]) {
    let width = row.len();
    let (mut factors, mut some, mut count) = ([0.0; 4], [[].as_slice(); 4], 0);
    for v in 0..slopes.len() {
        if slopes[v] != 0.0 {
            (factors[count], some[count]) = (factor * slopes[v], &rows[v * width..][..width]);
            count += 1;
            if count == 4 {
                axpy_four(row, factors, some);
                count = 0;
            }
        }
    }
    if count > 0 {
        for k in count..4 {
            (factors[k], some[k]) = (0.0, some[0]);
        }
        axpy_four(row, factors, some);
    }
}

impl Discretisation {
    /// d locals / d columns of the middle point of interval `k`: shares, and
    /// the slopes of the middle of the cubic.
    pub(super) fn map_middle(&mut self, k: usize, span: f64) {
        let (n, interval) = (self.setup.states.len(), &self.layout.intervals[k]);
        let (width, own, locals) = (self.assembly.width, self.assembly.own, self.points.locals);
        let mut middle = std::mem::take(&mut self.assembly.middle);
        middle.fill(0.0);
        for (row, shares) in middle.chunks_exact_mut(width).zip(&self.assembly.map(k, 1).shares) {
            shares.iter().for_each(|&(c, share)| row[c] += share);
        }
        let first = interval.columns[0];
        for (j, i, bulge) in [(0, interval.ends[0], MIDDLE), (2, interval.ends[1], -MIDDLE)] {
            let (f, jacobian) = (self.points.value(i), self.points.jacobian(i));
            let (map, x) = (self.assembly.map(k, j), self.layout.nodes[k + j / 2] - first);
            let factor = bulge * interval.share;
            for r in 0..n {
                let row = &mut middle[(1 + r) * width..][..width];
                row[x + r] += 0.5;
                row[own] -= factor * f[r];
                row[own + 1] += factor * f[r];
                map.add(row, factor * span, &jacobian[r * locals..(r + 1) * locals]);
            }
        }
        self.assembly.middle = middle;
    }

    /// Appends the Jacobian rows of the defects of interval `k`.
    pub(super) fn defect_rows(&self, k: usize, span: f64, out: &mut Vec<f64>) {
        let (n, scheme) = (self.setup.states.len(), &self.transcribed.scheme);
        let interval = &self.layout.intervals[k];
        let (width, own, first) = (self.assembly.width, self.assembly.own, interval.columns[0]);
        let begin = out.len();
        out.resize(begin + scheme.defects().len() * n * width, 0.0);
        let rows = &mut out[begin..];
        let start = self.layout.nodes[k] - first;
        for (block, j) in rows.chunks_exact_mut(n * width).zip(scheme.defects()) {
            if let StateOf::Unknown(x) = self.layout.points[interval.ends[0] + j].x {
                for (r, row) in block.chunks_exact_mut(width).enumerate() {
                    row[x - first + r] += 1.0;
                    row[start + r] -= 1.0;
                }
            }
            for i in 0..scheme.points() {
                let (point, factor) = (interval.ends[0] + i, interval.share * scheme.a[j][i]);
                let (f, map) = (self.points.value(point), self.assembly.map(k, i));
                let jacobian = self.points.jacobian(point).chunks_exact(self.points.locals);
                let middle = matches!(self.layout.points[point].x, StateOf::Middle(_));
                for (r, (row, slopes)) in block.chunks_exact_mut(width).zip(jacobian).enumerate() {
                    row[own] += factor * f[r];
                    row[own + 1] -= factor * f[r];
                    if middle {
                        add_rows(row, -factor * span, slopes, &self.assembly.middle);
                    } else {
                        map.add(row, -factor * span, slopes);
                    }
                }
            }
        }
    }

    /// Hessian of the Lagrangian's part of interval `k`.
    pub(super) fn hessian_block(&mut self, k: usize, weight: f64) {
        self.assembly.block.fill(0.0);
        self.assembly.span_slopes.fill(0.0);
        for i in self.owned(k) {
            match self.layout.points[i].x {
                StateOf::Unknown(_) => self.add_point(k, i),
                StateOf::Middle(_) => self.add_middle(i),
            }
        }
        self.assembly.add_span_products();
        let change = weight * self.setup.input_change;
        if change != 0.0 {
            let interval = &self.layout.intervals[k];
            let [a, b] = interval.ends.map(|i| self.layout.points[i].u[0].0 - interval.columns[0]);
            for j in 0..self.setup.inputs.len() {
                self.assembly.add_pair(a + j, a + j, change);
                self.assembly.add_pair(b + j, b + j, change);
                self.assembly.add_pair(a + j, b + j, -2.0 * change);
            }
        }
    }

    /// Slopes of the weighted rates and cost of point `i` along its local unknowns.
    pub(super) fn weigh_slopes(&mut self, i: usize) {
        let weights = &self.weights[i * self.points.outputs..][..=self.setup.states.len()];
        self.assembly.slopes.fill(0.0);
        add_rows(&mut self.assembly.slopes, 1.0, weights, self.points.jacobian(i));
    }

    /// Adds a point whose state is unknown to the Hessian.
    fn add_point(&mut self, k: usize, i: usize) {
        self.weigh_slopes(i);
        let (locals, j) = (self.points.locals, i - self.layout.intervals[k].ends[0]);
        let Assembly { block, span_slopes, slopes, maps, points, width, .. } = &mut self.assembly;
        let map = &maps[k * *points + j];
        map.add(span_slopes, 1.0, slopes);
        for v in 1..=map.run {
            let (c, row) = (map.start + v - 1, &self.points.hessian(i)[v * locals..][..locals]);
            axpy(&mut block[c * *width + c..], 1.0, &row[v..=map.run]);
        }
        self.add_apart(k, i);
    }

    /// Adds the products of the locals that are no columns of their own with all locals.
    fn add_apart(&mut self, k: usize, i: usize) {
        let (locals, j) = (self.points.locals, i - self.layout.intervals[k].ends[0]);
        let Assembly { block, maps, points, width, .. } = &mut self.assembly;
        let PointMap { shares, run, .. } = &maps[k * *points + j];
        for v in (0..locals).filter(|v| !(1..=*run).contains(v)) {
            let row = &self.points.hessian(i)[v * locals..][..locals];
            for u in (0..locals).filter(|u| row[*u] != 0.0) {
                // A local of the run does not meet this one again with the two exchanged.
                let twice = (1..=*run).contains(&u);
                for (a, one) in shares[v] {
                    for (b, two) in shares[u] {
                        let value = one * two * row[u];
                        let mirrored = if a == b { 2.0 * value } else { value };
                        match (twice, a <= b) {
                            (true, _) => block[a.min(b) * *width + a.max(b)] += mirrored,
                            (false, true) => block[a * *width + b] += value,
                            (false, false) => {}
                        }
                    }
                }
            }
        }
    }

    /// Adds a middle point, mapped by the last [`Self::map_middle`]: M' H M
    /// and the products with the time span.
    fn add_middle(&mut self, i: usize) {
        self.weigh_slopes(i);
        let (locals, width) = (self.points.locals, self.assembly.width);
        let Assembly { middle, product, block, span_slopes, slopes, .. } = &mut self.assembly;
        add_rows(span_slopes, 1.0, slopes, middle);
        for v in 0..locals {
            let (row, map) = (&self.points.hessian(i)[v * locals..][..locals], &middle[v * width..][..width]);
            if row.iter().all(|h| *h == 0.0) {
                continue;
            }
            product.fill(0.0);
            add_rows(product, 1.0, row, middle);
            for c in 0..width {
                if map[c] != 0.0 {
                    axpy(&mut block[c * width + c..(c + 1) * width], map[c], &product[c..]);
                }
            }
        }
    }

    /// Adds the running cost of interval `k` to the gradient.
    pub(super) fn add_cost_slopes(&mut self, k: usize, span: f64) {
        let (n, locals, times) = (self.setup.states.len(), self.points.locals, self.layout.times);
        let (first, own, width) =
            (self.layout.intervals[k].columns[0], self.assembly.own, self.assembly.width);
        let column = |c: usize| if c < own { first + c } else { times + c - own };
        for i in self.owned(k) {
            let place = &self.layout.points[i];
            if place.weight == 0.0 {
                continue;
            }
            let weight = place.weight * span;
            let slopes = &self.points.jacobian(i)[n * locals..][..locals];
            let map = self.assembly.map(k, i - self.layout.intervals[k].ends[0]);
            for (v, slope) in slopes.iter().enumerate().filter(|(_, s)| **s != 0.0) {
                if let StateOf::Middle(_) = place.x {
                    for (c, share) in self.assembly.middle[v * width..][..width].iter().enumerate() {
                        self.gradient[column(c)] += weight * slope * share;
                    }
                } else {
                    map.shares[v]
                        .iter()
                        .for_each(|&(c, share)| self.gradient[column(c)] += weight * slope * share);
                }
            }
            let cost = place.weight * self.points.value(i)[n];
            self.gradient[times + 1] += cost;
            self.gradient[times] -= cost;
        }
    }
}
