//! Velocities of large wakes: patches of a grid, halved by turns, the far ones as multipoles.

use crate::kernel::{FieldPoints, INVERSE_4PI, LANES, VertexRoom, VortexGrid, Window, add_all, add_block};
use crate::multipole::{Coefficients, MOMENTS, Moments, SHIFT, add_segment, coefficients, velocity};
use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// Most cells of a patch that is not halved. *Choice.*
const LEAF: usize = 64;
/// Points that are served together. *Choice.*
const GROUP: usize = 32;
/// Points from which work is shared among the cores. *Choice.*
const SHARED: usize = 4000;
/// Radius of a patch over its distance from the nearest point below which it is far. *Choice*, for the error.
const FAR: f64 = 0.55;
/// Radii of its largest core within which a patch is not far: moments know no cores. *Choice.*
const CORES: f64 = 8.0;

/// A part of the grid.
struct Patch {
    window: Window,
    centre: Vec3,
    /// Of a ball about the centre that holds its vertices, m.
    radius: f64,
    /// Largest radius of its cores, m.
    core: f64,
    /// Its halves.
    halves: Option<[usize; 2]>,
}

/// A grid in patches.
pub struct PatchTree<'a> {
    grid: &'a VortexGrid,
    patches: Vec<Patch>,
    coefficients: Vec<Coefficients>,
}

impl<'a> PatchTree<'a> {
    /// The patches of `grid`, which has two rows and columns or more, with their moments.
    pub fn new(grid: &'a VortexGrid) -> Self {
        let mut tree = Self { grid, patches: Vec::new(), coefficients: Vec::new() };
        tree.halve(grid.whole());
        let mut moments: Vec<Moments> = vec![[Vec3::ZERO; MOMENTS]; tree.patches.len()];
        // Halves stand behind what they are halves of.
        for at in (0..tree.patches.len()).rev() {
            match tree.patches[at].halves {
                None => tree.gather(at, &mut moments[at]),
                Some(halves) => {
                    for half in halves {
                        let off = tree.patches[half].centre - tree.patches[at].centre;
                        let own = moments[half];
                        SHIFT.add(&mut moments[at], &own, off);
                        tree.patches[at].core = tree.patches[at].core.max(tree.patches[half].core);
                    }
                }
            }
        }
        tree.coefficients = moments.iter().map(coefficients).collect();
        tree
    }

    /// Adds a patch and what it is halved into; returns its place.
    fn halve(&mut self, window: Window) -> usize {
        let place = self.patches.len();
        let (centre, radius) = ball(self.vertices(window));
        self.patches.push(Patch { window, centre, radius, core: 0.0, halves: None });
        let Window { rows: [r, s], columns: [c, d] } = window;
        if (s - r) * (d - c) <= LEAF {
            return place;
        }
        let parts = match s - r > 1 && (d - c == 1 || self.is_longer_along(window)) {
            true => [[r, (r + s) / 2], [(r + s) / 2, s]].map(|rows| Window { rows, ..window }),
            false => [[c, (c + d) / 2], [(c + d) / 2, d]].map(|columns| Window { columns, ..window }),
        };
        let halves = parts.map(|part| self.halve(part));
        self.patches[place].halves = Some(halves);
        place
    }

    fn point(&self, r: usize, j: usize) -> Vec3 {
        self.grid.points[r * self.grid.columns + j]
    }

    fn vertices(&self, window: Window) -> impl Iterator<Item = Vec3> + Clone + '_ {
        let Window { rows: [r, s], columns: [c, d] } = window;
        (r..=s).flat_map(move |r| (c..=d).map(move |j| self.point(r, j)))
    }

    /// Whether the way through the middle along the rows is longer than that along the columns.
    fn is_longer_along(&self, window: Window) -> bool {
        let Window { rows: [r, s], columns: [c, d] } = window;
        let (row, column) = ((r + s) / 2, (c + d) / 2);
        let along: f64 = (r..s).map(|r| (self.point(r + 1, column) - self.point(r, column)).norm()).sum();
        let across: f64 = (c..d).map(|j| (self.point(row, j + 1) - self.point(row, j)).norm()).sum();
        along >= across
    }

    /// Sums the moments of the segments of a patch, and finds its largest core.
    fn gather(&mut self, at: usize, moments: &mut Moments) {
        let (grid, n) = (self.grid, self.grid.columns);
        let Patch { window, centre, .. } = self.patches[at];
        let Window { rows: [r, s], columns: [c, d] } = window;
        let mut largest: f64 = 0.0;
        let mut add = |a: Vec3, b: Vec3, strength: f64, core: f64| {
            add_segment(moments, a - centre, b - centre, strength);
            let square = (b - a).norm_squared();
            if square > 0.0 {
                largest = largest.max(core / square);
            }
        };
        for row in r..=s {
            for j in c..=d {
                let here = self.point(row, j);
                if j < d && (row < s || s + 1 == grid.rows()) {
                    let k = row * (n - 1) + j;
                    add(here, self.point(row, j + 1), grid.across[k], grid.core_across[k]);
                }
                if row < s && (j < d || d + 1 == n) {
                    let k = row * n + j;
                    add(here, self.point(row + 1, j), grid.along[k], grid.core_along[k]);
                }
            }
        }
        self.patches[at].core = largest.sqrt();
    }

    /// Adds to `velocities` what the grid induces at `points`, m/s, on all cores. Which patches are far is decided by the points
    /// `by`, which lie near these in the same order: it may turn with the last digit of a place, and velocities with it by the
    /// error of a multipole.
    pub fn add_velocities(&self, points: &[Vec3], by: &[Vec3], velocities: &mut [Vec3]) {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut groups = Vec::new();
        group(by, &mut order, &mut groups);
        if points.len() < SHARED {
            for group in &groups {
                let found = self.serve(points, by, group);
                group.iter().zip(found).for_each(|(at, v)| velocities[*at as usize] += v);
            }
            return;
        }
        let answers = parallel::map(&groups, |_, group| self.serve(points, by, group));
        for (group, answer) in groups.iter().zip(answers) {
            group.iter().zip(answer).for_each(|(at, v)| velocities[*at as usize] += v);
        }
    }

    /// Velocities at the points of a group, m/s.
    fn serve(&self, points: &[Vec3], by: &[Vec3], group: &[u32]) -> Vec<Vec3> {
        let at = || group.iter().map(|at| points[*at as usize]);
        let (middle, reach) = ball(group.iter().map(|at| by[*at as usize]));
        let (mut far, mut near, mut open) = (Vec::new(), Vec::new(), vec![0]);
        while let Some(place) = open.pop() {
            let patch = &self.patches[place];
            let distance = (patch.centre - middle).norm() - reach;
            if patch.radius < FAR * distance && distance > patch.radius + CORES * patch.core {
                far.push(place);
            } else {
                match patch.halves {
                    Some(halves) => open.extend(halves),
                    None => near.push(place),
                }
            }
        }
        let mut lanes = FieldPoints::default();
        lanes.set(at());
        let mut found = vec![Vec3::ZERO; group.len()];
        let mut sums = vec![[f64x4::ZERO; 3]; lanes.blocks().len()];
        for (block, sum) in lanes.blocks().iter().zip(&mut sums) {
            for place in &far {
                let centre = self.patches[*place].centre;
                let d = std::array::from_fn(|k| block[k] - f64x4::splat(centre[k]));
                let v = velocity(&self.coefficients[*place], &d);
                (0..3).for_each(|k| sum[k] += v[k]);
            }
        }
        let windows: Vec<Window> = near.iter().map(|place| self.patches[*place].window).collect();
        add_all(self.grid, &windows, lanes.blocks(), &mut VertexRoom::default(), &mut sums);
        for (sum, out) in sums.into_iter().zip(found.chunks_mut(LANES)) {
            add_block(out, sum.map(|v| v * f64x4::splat(INVERSE_4PI)));
        }
        found
    }
}

/// Centre and radius of a ball that holds `points`.
fn ball(points: impl Iterator<Item = Vec3> + Clone) -> (Vec3, f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points.clone() {
        (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(point[k]), high[k].max(point[k])));
    }
    let centre = Vec3(std::array::from_fn(|k| 0.5 * (low[k] + high[k])));
    (centre, points.fold(0.0_f64, |radius, point| radius.max((point - centre).norm())))
}

/// Puts points that lie together into groups: halves by the longest side of what holds them.
fn group<'a>(points: &[Vec3], order: &'a mut [u32], groups: &mut Vec<&'a [u32]>) {
    if order.len() <= GROUP {
        if !order.is_empty() {
            groups.push(order);
        }
        return;
    }
    let side = |axis: usize| {
        let values = order.iter().map(|at| points[*at as usize][axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let sides = [side(0), side(1), side(2)];
    let axis = (0..3).max_by(|a, b| sides[*a].total_cmp(&sides[*b])).unwrap_or(0);
    // Whole lanes in the first half.
    let middle = (order.len() / 2).next_multiple_of(LANES);
    order.select_nth_unstable_by(middle, |a, b| {
        points[*a as usize][axis].total_cmp(&points[*b as usize][axis])
    });
    let (first, second) = order.split_at_mut(middle);
    group(points, first, groups);
    group(points, second, groups);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{add_induced, add_velocities};
    use wingbeat::math::Random;

    /// A sheet that waves and rolls up, of `rows` x `columns` rings.
    fn sheet(rows: usize, columns: usize) -> VortexGrid {
        let mut random = Random::new(11);
        let place = |r: usize, j: usize| {
            let (x, y) = (-0.02 * r as f64, 0.4 * (j as f64 / columns as f64 - 0.5));
            let lift = 0.1 * (12.0 * x).sin() + 0.05 * (9.0 * y + 3.0 * x).cos();
            Vec3::new(x, y, lift)
        };
        let points = (0..=rows).flat_map(|r| (0..=columns).map(move |j| place(r, j)));
        let (across, along) = ((rows + 1) * columns, rows * (columns + 1));
        let ring: Vec<f64> = (0..rows * columns)
            .map(|k| (0.3 + 0.05 * (k / columns) as f64).sin() * (1.0 + 0.1 * random.normal()))
            .collect();
        let ring = |r: Option<usize>, j: Option<usize>| match (r, j) {
            (Some(r), Some(j)) if r < rows && j < columns => ring[r * columns + j],
            _ => 0.0,
        };
        let mut grid = VortexGrid { columns: columns + 1, points: points.collect(), ..VortexGrid::default() };
        let (n, m) = (columns, columns + 1);
        grid.across = (0..across)
            .map(|k| ring((k / n).checked_sub(1), Some(k % n)) - ring(Some(k / n), Some(k % n)))
            .collect();
        grid.along = (0..along)
            .map(|k| ring(Some(k / m), Some(k % m)) - ring(Some(k / m), (k % m).checked_sub(1)))
            .collect();
        grid.soften(|_, _| 2.5e-5, |_, _| 2.5e-5);
        grid
    }

    #[test]
    fn trials_of_an_instant_have_one_choice_of_sums() {
        let grid = sheet(60, 40);
        let tree = PatchTree::new(&grid);
        // Rows of control points beside each other, as panels of a wing have: their order turns with rounding.
        let points: Vec<Vec3> = (0..400)
            .map(|k| Vec3::new(0.1 + 0.02 * (k / 40) as f64, 0.4 * ((k % 40) as f64 / 39.0 - 0.5), 0.05))
            .collect();
        let mut random = Random::new(5);
        let moved: Vec<Vec3> =
            points.iter().map(|p| *p + Vec3(std::array::from_fn(|_| 1e-13 * random.normal()))).collect();
        let velocities = |points: &[Vec3], by: &[Vec3]| {
            let mut velocities = vec![Vec3::ZERO; points.len()];
            tree.add_velocities(points, by, &mut velocities);
            velocities
        };
        let here = velocities(&points, &points);
        let apart =
            |there: Vec<Vec3>| here.iter().zip(there).map(|(a, b)| (*a - b).norm()).fold(0.0, f64::max);
        let [one, own] = [&points, &moved].map(|by| apart(velocities(&moved, by)));
        assert!(one < 1e-10 && own > 1e-8, "{one:e} {own:e}");
    }

    /// Rms difference between fast and direct sum at the sheet's vertices, over the rms velocity.
    pub fn error(grid: &VortexGrid) -> f64 {
        let points: Vec<Vec3> = grid.points.iter().step_by(7).copied().collect();
        let mut lanes = FieldPoints::default();
        lanes.set(points.iter().copied());
        let (mut exact, mut fast) = (vec![Vec3::ZERO; points.len()], vec![Vec3::ZERO; points.len()]);
        add_velocities::<true>(grid, &lanes, &mut exact);
        PatchTree::new(grid).add_velocities(&points, &points, &mut fast);
        let squares = |values: &mut dyn Iterator<Item = Vec3>| values.map(|v| v.norm_squared()).sum::<f64>();
        let apart = squares(&mut exact.iter().zip(&fast).map(|(a, b)| *a - *b));
        (apart / squares(&mut exact.iter().copied())).sqrt()
    }

    #[test]
    fn far_patches_are_close_to_their_vortices() {
        for (rows, columns) in [(1, 3), (20, 8), (100, 20), (300, 30)] {
            let found = error(&sheet(rows, columns));
            assert!(found < 1e-3, "{rows} x {columns}: {found}");
        }
    }

    #[test]
    fn every_segment_has_one_patch() {
        let grid = sheet(33, 17);
        let tree = PatchTree::new(&grid);
        let p = Vec3::new(0.3, 0.1, 0.2);
        let block: [f64x4; 3] = std::array::from_fn(|k| f64x4::splat(p[k]));
        let (mut parts, mut all) = ([f64x4::ZERO; 3], [f64x4::ZERO; 3]);
        let mut seen = Vec::new();
        for patch in tree.patches.iter().filter(|patch| patch.halves.is_none()) {
            add_induced::<true>(&grid, &patch.window, &block, &mut seen, &mut parts);
        }
        add_induced::<true>(&grid, &grid.whole(), &block, &mut seen, &mut all);
        for k in 0..3 {
            assert!((parts[k] - all[k]).to_array()[0].abs() < 1e-12 * all[k].to_array()[0].abs().max(1.0));
        }
    }
}
