//! Derivatives of a collocated problem, four intervals side by side, dense over the columns of an interval: its own unknowns, then final
//! time, initial time and parameters.

use super::layout::{StateOf, UnknownLayout};
use super::points::{Four, MIDDLE};
use super::*;
use wingbeat_math::{Double4, FourDerivatives, Lanes, Scalar};

/// A local unknown of a point as shares of columns of its interval: of none for a middle state, whose map is dense.
#[derive(Clone, Debug)]
enum LocalUnknown {
    Own(usize),
    Shared([(usize, Double4); 2]),
    Middle,
}

impl LocalUnknown {
    /// Adds `factor` times the local to `row`.
    #[inline]
    fn add(&self, row: &mut [Double4], factor: Double4) {
        match self {
            Self::Own(column) => row[*column] += factor,
            Self::Shared([(a, one), (b, two)]) => {
                row[*a] = factor.mul_add(*one, row[*a]);
                row[*b] = factor.mul_add(*two, row[*b]);
            }
            Self::Middle => {}
        }
    }

    fn shares(&self) -> ([(usize, Double4); 2], usize) {
        match *self {
            Self::Own(column) => ([(column, Double4::ONE); 2], 1),
            Self::Shared(shares) => (shares, 2),
            Self::Middle => ([(0, Double4::ZERO); 2], 0),
        }
    }
}

/// Maps from the columns of an interval to the local unknowns of its points, and the scratch of four intervals.
#[derive(Clone, Debug)]
pub(super) struct Assembly {
    /// Columns of an interval; those before `own` are its own unknowns.
    pub width: usize,
    pub own: usize,
    /// The local unknowns of each point of an interval.
    maps: Vec<Vec<LocalUnknown>>,
    /// d locals / d columns of a middle point, row-major.
    middle: Vec<Double4>,
    /// The columns along which each local of a middle point changes.
    reach: Vec<Vec<usize>>,
    /// For each column the locals of a middle point that change with it and have second derivatives.
    meets: Vec<Vec<usize>>,
    /// The Hessian of a middle point times `middle`.
    product: Vec<Double4>,
    /// Slopes of the weighted rates and cost of a point along its local unknowns.
    pub slopes: Vec<Double4>,
    /// The sum of those of the points of an interval along its columns.
    span_slopes: Vec<Double4>,
    /// Derivatives at the last points of the intervals.
    last: FourDerivatives,
    /// Jacobian rows of the defects, then of the path values at the points that an interval owns.
    pub rows: Vec<Double4>,
    /// Hessian, upper triangle row by row.
    pub block: Vec<Double4>,
    /// Slopes of the running cost along the columns.
    pub cost: Vec<Double4>,
}

/// y = sum over `picks` of a factor times a row, of rows as long as `y` that begin with the column `from`; added to `y` where it is
/// `onto` something.
#[inline]
fn combine(
    y: &mut [Double4],
    (from, onto): (usize, bool),
    rows: &[Double4],
    picks: &[usize],
    factor: impl Fn(usize) -> Double4,
) {
    let (n, width) = (y.len(), from + y.len());
    let row = |v: usize| &rows[v * width + from..][..n];
    let (fours, rest) = picks.as_chunks();
    let mut onto = onto;
    for &[a, b, c, d] in fours {
        let (p, q, r, s) = (factor(a), factor(b), factor(c), factor(d));
        let (a, b, c, d) = (row(a), row(b), row(c), row(d));
        if std::mem::replace(&mut onto, true) {
            for k in 0..n {
                y[k] = s.mul_add(d[k], r.mul_add(c[k], q.mul_add(b[k], p.mul_add(a[k], y[k]))));
            }
        } else {
            for k in 0..n {
                y[k] = s.mul_add(d[k], r.mul_add(c[k], q.mul_add(b[k], p * a[k])));
            }
        }
    }
    for &a in rest {
        let (p, a) = (factor(a), row(a));
        if std::mem::replace(&mut onto, true) {
            for k in 0..n {
                y[k] = p.mul_add(a[k], y[k]);
            }
        } else {
            for k in 0..n {
                y[k] = p * a[k];
            }
        }
    }
    if !onto {
        y.fill(Double4::ZERO);
    }
}

/// Writes the lanes of up to four intervals to `out` as one row for each interval.
pub(super) fn unpack(rows: &[Double4], out: &mut [f64]) {
    let (fours, rest) = rows.as_chunks();
    let begun = fours.len() * Double4::WIDTH;
    for (lane, row) in out.chunks_exact_mut(rows.len()).enumerate() {
        for (out, entry) in row[begun..].iter_mut().zip(rest) {
            *out = entry.lane(lane);
        }
    }
    let mut lanes = out.chunks_exact_mut(rows.len()).map(|row| row[..begun].as_chunks_mut().0);
    if let [Some(a), Some(b), Some(c), Some(d)] = [lanes.next(), lanes.next(), lanes.next(), lanes.next()] {
        for e in 0..fours.len().min(a.len()).min(b.len()).min(c.len()).min(d.len()) {
            [a[e], b[e], c[e], d[e]] = Double4::transposed(fours[e]);
        }
        return;
    }
    for (lane, row) in out.chunks_exact_mut(rows.len()).enumerate() {
        for (out, entry) in row.iter_mut().zip(rows) {
            *out = entry.lane(lane);
        }
    }
}

impl Assembly {
    pub fn new(setup: &Setup, scheme: &Scheme, layout: &UnknownLayout, last: FourDerivatives) -> Self {
        let own = layout.intervals[0].columns[1] - layout.intervals[0].columns[0];
        let (width, points) = (own + 2 + setup.parameters.len(), scheme.points());
        let maps: Vec<_> = (0..points).map(|j| locals(setup, layout, j)).collect();
        let (locals, n) = (maps[0].len(), setup.states.len());
        let zeros = |count: usize| vec![Double4::ZERO; count];
        let mut middle = zeros(locals * width);
        for (row, local) in middle.chunks_exact_mut(width).zip(&maps[points / 2]) {
            local.add(row, Double4::ONE);
        }
        let mut assembly = Self {
            width,
            own,
            maps,
            middle,
            reach: Vec::new(),
            meets: Vec::new(),
            product: zeros(locals * width),
            slopes: zeros(locals),
            span_slopes: zeros(width),
            last,
            rows: Vec::new(),
            block: zeros(width * (width + 1) / 2),
            cost: zeros(width),
        };
        let path = (0..points - 1).filter(|j| layout.points[*j].path.is_some());
        let path = path.map(|j| assembly.path_columns(j).count()).sum::<usize>() * setup.path.len();
        assembly.rows = zeros(scheme.defects().len() * n * width + path);
        assembly
    }

    /// Where row `a` of the Hessian would begin if it had the columns before its diagonal.
    #[inline]
    fn row_of(&self, a: usize) -> usize {
        a * self.width - a * (a + 1) / 2
    }

    /// Columns of the locals of point `j`, local by local.
    pub fn path_columns(&self, j: usize) -> impl Iterator<Item = usize> {
        self.maps[j].iter().flat_map(|local| {
            let (shares, count) = local.shares();
            shares.into_iter().take(count).map(|share| share.0)
        })
    }

    /// Adds `value` and its mirror image to the Hessian.
    #[inline]
    fn add_pair(&mut self, a: usize, b: usize, value: Double4) {
        let value = if a == b { value + value } else { value };
        let place = self.row_of(a.min(b)) + a.max(b);
        self.block[place] += value;
    }

    /// Adds the products of the time span with the slopes of the points.
    fn add_span_products(&mut self) {
        for c in 0..self.width {
            let slope = self.span_slopes[c];
            self.add_pair(c, self.own, slope);
            self.add_pair(c, self.own + 1, -slope);
        }
    }
}

/// The local unknowns of point `j` of any interval; the shares of the times follow with the place of the point.
fn locals(setup: &Setup, layout: &UnknownLayout, j: usize) -> Vec<LocalUnknown> {
    let (place, [first, end]) = (&layout.points[j], layout.intervals[0].columns);
    let (n, m, own) = (setup.states.len(), setup.inputs.len(), end - first);
    let mut map = vec![LocalUnknown::Shared([(own, Double4::ZERO), (own + 1, Double4::ONE)])];
    map.extend((0..n).map(|r| match place.x {
        StateOf::Unknown(x) => LocalUnknown::Own(x + r - first),
        StateOf::Middle(_) => LocalUnknown::Middle,
    }));
    let [(a, wa), (b, wb)] = place.u;
    map.extend((0..m).map(|j| match wb {
        0.0 => LocalUnknown::Own(a + j - first),
        _ => LocalUnknown::Shared([(a + j - first, wa.into()), (b + j - first, wb.into())]),
    }));
    map.extend((0..setup.parameters.len()).map(|q| LocalUnknown::Own(own + 2 + q)));
    map
}

impl Discretisation {
    /// The points `j` of the intervals of `group`; those of intervals that are not there are those of the last one.
    pub(super) fn four(&self, group: usize, j: usize) -> Four {
        let last = self.layout.intervals.len() - 1;
        std::array::from_fn(|lane| {
            let k = Double4::WIDTH * group + lane;
            // The first point after the last interval is its end.
            let after = if k > last && j == 0 { 1 } else { 0 };
            let [begin, end] = self.layout.intervals[k.min(last)].ends;
            if after == 1 { end } else { begin + j }
        })
    }

    fn shares(&self, group: usize) -> Double4 {
        let intervals = &self.layout.intervals;
        Double4::of(|lane| intervals[(Double4::WIDTH * group + lane).min(intervals.len() - 1)].share)
    }

    /// The weight of output `row` of four points.
    fn weights_of(&self, at: Four, row: usize) -> Double4 {
        Double4::of(|lane| self.weights[at[lane] * self.points.outputs + row])
    }

    /// The columns of an interval where the state of its node `end` (0 or 1) begins.
    fn node_column(&self, end: usize) -> usize {
        self.layout.nodes[end] - self.layout.intervals[0].columns[0]
    }

    /// What depends on where second derivatives are.
    fn find_meetings(&mut self) {
        let tape = &self.points.tape;
        let (n, width) = (self.setup.states.len(), self.assembly.width);
        let last = self.transcribed.scheme.points() - 1;
        let mut changes = vec![vec![false; width]; self.points.locals];
        let mark = |row: &mut [bool], j: usize, v: usize, maps: &[Vec<LocalUnknown>]| {
            let (shares, count) = maps[j][v].shares();
            shares.iter().take(count).for_each(|share| row[share.0] = true);
        };
        let (maps, own) = (&self.assembly.maps, self.assembly.own);
        for (v, row) in changes.iter_mut().enumerate() {
            mark(row, last / 2, v, maps);
            if (1..=n).contains(&v) {
                let states = [0, 1].map(|end| self.node_column(end) + v - 1);
                states.into_iter().chain([own, own + 1]).for_each(|c| row[c] = true);
                for u in &tape.slopes[v - 1] {
                    mark(row, 0, *u, maps);
                    mark(row, last, *u, maps);
                }
            }
        }
        let bent: Vec<usize> = (0..self.points.locals).filter(|v| !tape.bends[*v].is_empty()).collect();
        self.assembly.meets =
            (0..width).map(|c| bent.iter().copied().filter(|v| changes[*v][c]).collect()).collect();
        self.assembly.reach = changes.iter().map(|row| (0..width).filter(|c| row[*c]).collect()).collect();
    }

    /// Prepares the assembly of the intervals of `group`, whose derivatives are known, and those at their ends.
    pub(super) fn begin_group(&mut self, group: usize, last: Option<usize>) {
        if std::mem::take(&mut self.points.tape.grown) {
            self.find_meetings();
        }
        self.points.shift(group, last, &mut self.assembly.last);
        let own = self.assembly.own;
        for j in 0..self.transcribed.scheme.points() {
            let sigma = self.sigmas(group, j);
            self.assembly.maps[j][0] = LocalUnknown::Shared([(own, sigma), (own + 1, Double4::ONE - sigma)]);
        }
    }

    fn sigmas(&self, group: usize, j: usize) -> Double4 {
        let at = self.at_point(group, j);
        Double4::of(|lane| self.layout.points[at[lane]].sigma)
    }

    /// As [`Self::four`], of the last points too.
    fn at_point(&self, group: usize, j: usize) -> Four {
        let last = self.transcribed.scheme.points() - 1;
        if j < last {
            return self.four(group, j);
        }
        let intervals = &self.layout.intervals;
        std::array::from_fn(|lane| {
            intervals[(Double4::WIDTH * group + lane).min(intervals.len() - 1)].ends[1]
        })
    }

    /// Derivatives at point `j` of the intervals of `group`.
    fn derivatives(&self, group: usize, j: usize) -> &FourDerivatives {
        let last = self.transcribed.scheme.points() - 1;
        if j < last { self.points.set(group, j) } else { &self.assembly.last }
    }

    /// d locals / d columns of the middle points of `group`: shares, and the slopes of the middle of the cubic.
    pub(super) fn map_middle(&mut self, group: usize, span: f64) {
        let (n, share) = (self.setup.states.len(), self.shares(group));
        let (width, own, locals) = (self.assembly.width, self.assembly.own, self.points.locals);
        let mut middle = std::mem::take(&mut self.assembly.middle);
        let time = &mut middle[..width];
        time.fill(Double4::ZERO);
        self.assembly.maps[1][0].add(time, Double4::ONE);
        for (row, columns) in middle.chunks_exact_mut(width).zip(&self.assembly.reach).skip(1).take(n) {
            columns.iter().for_each(|c| row[*c] = Double4::ZERO);
        }
        for (j, end, bulge) in [(0, 0, MIDDLE), (2, 1, -MIDDLE)] {
            let (at, jacobian) = (self.at_point(group, j), &self.derivatives(group, j).jacobian);
            let (map, x) = (&self.assembly.maps[j], self.node_column(end));
            let factor = share * bulge;
            let steep = factor * span;
            for r in 0..n {
                let row = &mut middle[(1 + r) * width..][..width];
                let change = factor * self.points.four(at, r);
                row[x + r] += Double4::from(0.5);
                row[own] += change;
                row[own + 1] -= change;
                for &v in &self.points.tape.slopes[r] {
                    map[v].add(row, steep * jacobian[r * locals + v]);
                }
            }
        }
        self.assembly.middle = middle;
    }

    /// Writes the Jacobian rows of the defects of the intervals of `group`.
    pub(super) fn defect_rows(&mut self, group: usize, span: f64) {
        let mut rows = std::mem::take(&mut self.assembly.rows);
        let (n, scheme) = (self.setup.states.len(), &self.transcribed.scheme);
        let (width, own, share) = (self.assembly.width, self.assembly.own, self.shares(group));
        let defects = &mut rows[..scheme.defects().len() * n * width];
        if !scheme.compressed {
            defects.fill(Double4::ZERO);
        }
        let [first, ..] = self.layout.intervals[0].columns;
        let start = self.node_column(0);
        for (block, j) in defects.chunks_exact_mut(n * width).zip(scheme.defects()) {
            // Rows begin with the middle state where there is one.
            for i in self.middle_first() {
                let (at, jacobian) = (self.at_point(group, i), &self.derivatives(group, i).jacobian);
                let (factor, map) = (share * scheme.a[j][i], &self.assembly.maps[i]);
                let steep = factor * -span;
                let middle = matches!(self.layout.points[i].x, StateOf::Middle(_));
                for (r, row) in block.chunks_exact_mut(width).enumerate() {
                    let slopes = &jacobian[r * self.points.locals..][..self.points.locals];
                    let picks = &self.points.tape.slopes[r];
                    if middle {
                        combine(row, (0, false), &self.assembly.middle, picks, |v| steep * slopes[v]);
                    } else {
                        picks.iter().for_each(|&v| map[v].add(row, steep * slopes[v]));
                    }
                    let change = factor * self.points.four(at, r);
                    row[own] -= change;
                    row[own + 1] += change;
                }
            }
            if let StateOf::Unknown(x) = self.layout.points[j].x {
                for (r, row) in block.chunks_exact_mut(width).enumerate() {
                    row[x - first + r] += Double4::ONE;
                    row[start + r] -= Double4::ONE;
                }
            }
        }
        self.assembly.rows = rows;
    }

    /// The points of an interval, one whose state is the middle first.
    fn middle_first(&self) -> impl Iterator<Item = usize> {
        let points = self.transcribed.scheme.points();
        let first = if self.transcribed.scheme.compressed { points / 2 } else { 0 };
        std::iter::once(first).chain((0..points).filter(move |i| *i != first))
    }

    /// Writes the Jacobian rows of the path values of the points that intervals own.
    pub(super) fn path_rows(&mut self, group: usize) {
        let (n, locals, width) = (self.setup.states.len(), self.points.locals, self.assembly.width);
        let scheme = &self.transcribed.scheme;
        let mut entry = scheme.defects().len() * n * width;
        for j in (0..scheme.points() - 1).filter(|j| self.layout.points[*j].path.is_some()) {
            let jacobian = &self.points.set(group, j).jacobian[(n + 1) * locals..];
            let Assembly { maps, rows, .. } = &mut self.assembly;
            for row in jacobian.chunks_exact(locals) {
                for (local, slope) in maps[j].iter().zip(row) {
                    let (shares, count) = local.shares();
                    for (_, share) in &shares[..count] {
                        rows[entry] = *share * *slope;
                        entry += 1;
                    }
                }
            }
        }
    }

    /// Jacobian rows of the path values at the last point of all, at `lane` of the last group.
    pub(super) fn last_path_rows(&self, lane: usize, out: &mut [f64]) {
        let (n, locals) = (self.setup.states.len(), self.points.locals);
        let map = &self.assembly.maps[self.transcribed.scheme.points() - 1];
        let slopes = self.assembly.last.jacobian[(n + 1) * locals..].iter().zip(map.iter().cycle());
        let entries = slopes.flat_map(|(slope, local)| {
            let (shares, count) = local.shares();
            shares.into_iter().take(count).map(move |share| (share.1 * *slope).lane(lane))
        });
        out.iter_mut().zip(entries).for_each(|(out, entry)| *out = entry);
    }

    /// Hessian of the Lagrangian's part of the intervals of `group`, the last of which ends the last interval where it is `last`.
    pub(super) fn hessian_block(&mut self, group: usize, weight: f64, last: Option<usize>) {
        self.assembly.span_slopes.fill(Double4::ZERO);
        if !self.transcribed.scheme.compressed {
            self.assembly.block.fill(Double4::ZERO);
        }
        let end = self.transcribed.scheme.points() - 1;
        for j in self.middle_first().filter(|j| *j < end).collect::<Vec<_>>() {
            match self.layout.points[j].x {
                StateOf::Unknown(_) => self.add_point(group, j, None),
                StateOf::Middle(_) => self.add_middle(group, j),
            }
        }
        if last.is_some() {
            self.add_point(group, self.transcribed.scheme.points() - 1, last);
        }
        self.assembly.add_span_products();
        let change = weight * self.setup.input_change;
        if change != 0.0 {
            let interval = &self.layout.intervals[0];
            let [a, b] = interval.ends.map(|i| self.layout.points[i].u[0].0 - interval.columns[0]);
            for j in 0..self.setup.inputs.len() {
                self.assembly.add_pair(a + j, a + j, change.into());
                self.assembly.add_pair(b + j, b + j, change.into());
                self.assembly.add_pair(a + j, b + j, (-2.0 * change).into());
            }
        }
    }

    /// Slopes of the weighted rates and cost of points `j` along their local unknowns, at one lane where it is `only`.
    pub(super) fn weigh_slopes(&mut self, group: usize, j: usize, only: Option<usize>) {
        let (at, locals) = (self.at_point(group, j), self.points.locals);
        let mut slopes = std::mem::take(&mut self.assembly.slopes);
        slopes.fill(Double4::ZERO);
        let jacobian = &self.derivatives(group, j).jacobian;
        for row in 0..=self.setup.states.len() {
            let weight = self.weights_of(at, row);
            let weight = only.map_or(weight, |only| single(weight, only));
            for &v in &self.points.tape.slopes[row] {
                slopes[v] = weight.mul_add(jacobian[row * locals + v], slopes[v]);
            }
        }
        self.assembly.slopes = slopes;
    }

    /// Adds points whose states are unknown to the Hessian.
    fn add_point(&mut self, group: usize, j: usize, only: Option<usize>) {
        self.weigh_slopes(group, j, only);
        let (locals, end) = (self.points.locals, self.transcribed.scheme.points() - 1);
        let Assembly { block, span_slopes, slopes, maps, width, last, .. } = &mut self.assembly;
        let hessian = if j < end { &self.points.set(group, j).hessian } else { &last.hessian };
        let place = |a: usize, b: usize| a.min(b) * *width - a.min(b) * (a.min(b) + 1) / 2 + a.max(b);
        for (v, picks) in self.points.tape.bends.iter().enumerate() {
            maps[j][v].add(span_slopes, slopes[v]);
            for &u in picks.iter().take_while(|u| **u <= v) {
                let value = hessian[v * locals + u];
                if let (LocalUnknown::Own(a), LocalUnknown::Own(b)) = (&maps[j][v], &maps[j][u]) {
                    block[place(*a, *b)] += value;
                    continue;
                }
                let ((one, ones), (two, twos)) = (maps[j][v].shares(), maps[j][u].shares());
                for (a, one) in &one[..ones] {
                    for (b, two) in &two[..twos] {
                        let value = *one * *two * value;
                        match (u == v, a.cmp(b)) {
                            // Of a pair with itself each order of two columns comes once.
                            (true, std::cmp::Ordering::Greater) => {}
                            (false, std::cmp::Ordering::Equal) => block[place(*a, *b)] += value + value,
                            _ => block[place(*a, *b)] += value,
                        }
                    }
                }
            }
        }
    }

    /// Adds middle points, mapped by the last [`Self::map_middle`]: M' H M, with which the Hessian begins, and the products
    /// with the time span.
    fn add_middle(&mut self, group: usize, j: usize) {
        self.weigh_slopes(group, j, None);
        let (locals, width) = (self.points.locals, self.assembly.width);
        let Assembly { middle, product, block, span_slopes, slopes, meets, .. } = &mut self.assembly;
        let all: Vec<usize> = (0..locals).collect();
        combine(span_slopes, (0, true), middle, &all, |v| slopes[v]);
        let hessian = &self.points.set(group, j).hessian;
        for (v, picks) in self.points.tape.bends.iter().enumerate().filter(|row| !row.1.is_empty()) {
            let row = &mut product[v * width..][..width];
            combine(row, (0, false), middle, picks, |u| hessian[v * locals + u]);
        }
        let mut rest = block.as_mut_slice();
        for c in 0..width {
            let row;
            (row, rest) = rest.split_at_mut(width - c);
            combine(row, (c, false), product, &meets[c], |v| middle[v * width + c]);
        }
    }

    /// Slopes of the running cost of the intervals of `group` along their columns, and the costs per time span.
    pub(super) fn cost_slopes(&mut self, group: usize, span: f64, last: Option<usize>) -> Double4 {
        let (n, locals) = (self.setup.states.len(), self.points.locals);
        let mut cost = std::mem::take(&mut self.assembly.cost);
        cost.fill(Double4::ZERO);
        let (mut sum, end) = (Double4::ZERO, self.transcribed.scheme.points() - 1);
        for j in 0..=end {
            let at = self.at_point(group, j);
            let weight = Double4::of(|lane| self.layout.points[at[lane]].weight);
            let weight = match (j == end, last) {
                (false, _) => weight,
                (true, Some(last)) => single(weight, last),
                (true, None) => Double4::ZERO,
            };
            if weight.is_zero() {
                continue;
            }
            sum += weight * self.points.four(at, n);
            let slopes = &self.derivatives(group, j).jacobian[n * locals..][..locals];
            let (picks, map) = (&self.points.tape.slopes[n], &self.assembly.maps[j]);
            let weight = weight * span;
            if let StateOf::Middle(_) = self.layout.points[j].x {
                combine(&mut cost, (0, true), &self.assembly.middle, picks, |v| weight * slopes[v]);
            } else {
                picks.iter().for_each(|&v| map[v].add(&mut cost, weight * slopes[v]));
            }
        }
        self.assembly.cost = cost;
        sum
    }
}

/// The number of one lane, zero in the others.
fn single(numbers: Double4, only: usize) -> Double4 {
    Double4::of(|lane| if lane == only { numbers.lane(lane) } else { 0.0 })
}
