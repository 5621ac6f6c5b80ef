//! Velocities induced by straight vortex segments: one at a time, and of whole grids at many points.

use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// 1/(4 pi).
const INVERSE_4PI: f64 = 0.25 * std::f64::consts::FRAC_1_PI;
/// Points of one block of lanes.
pub const LANES: usize = 4;
/// Squared sine of the angle between the ways from a point to the ends of a segment below which it lies on the segment's line.
const ON_LINE: f64 = 1e-24;
/// Pairs of segments and points from which work is shared among the cores. *Choice.*
const SHARED: usize = 2_000_000;
/// Blocks that one core takes at a time. *Choice.*
const BLOCKS: usize = 16;

/// Velocity at `p` per unit circulation of the segment from `a` to `b`: (d x r) (r1 + r2) / (4 pi r1 r2 (r1 r2 + r1.r2)),
/// d = b - a; nothing on the line of the segment.
///
/// Equation: lattice.segment
#[inline]
pub fn segment(p: Vec3, a: Vec3, b: Vec3) -> Vec3 {
    let (r1, r2) = (p - a, p - b);
    let (x, y) = (r1.norm(), r2.norm());
    let (across, product) = (r1.cross(r2), x * y);
    if across.norm_squared() <= ON_LINE * (product * product) {
        return Vec3::ZERO;
    }
    across * (INVERSE_4PI * (x + y) / (product * (product + r1.dot(r2))))
}

/// The same of a vortex with a core: |r1 x r2|^2, which falls as the square of the distance, grows by `core` = (l rc)^2, l the
/// length of the segment and rc the radius of its core, m4.
///
/// Equation: lattice.cored_segment
#[inline]
pub fn cored_segment(p: Vec3, a: Vec3, b: Vec3, core: f64) -> Vec3 {
    let (r1, r2) = (p - a, p - b);
    let (x, y) = (r1.norm(), r2.norm());
    let (across, product) = (r1.cross(r2), x * y);
    let square = across.norm_squared();
    if square <= ON_LINE * (product * product) {
        return Vec3::ZERO;
    }
    across * (INVERSE_4PI * (x + y) * (product - r1.dot(r2)) / (product * (square + core)))
}

/// Points at which velocities are wanted, in lanes; those that fill up the last block repeat the last point.
#[derive(Clone, Debug, Default)]
pub struct Points {
    count: usize,
    blocks: Vec<[f64x4; 3]>,
}

impl Points {
    /// Takes the place of the points held.
    pub fn set(&mut self, points: impl ExactSizeIterator<Item = Vec3>) {
        self.count = points.len();
        self.blocks.clear();
        let (mut lanes, mut filled) = ([[0.0; LANES]; 3], 0);
        let mut last = Vec3::ZERO;
        let block = |lanes: &[[f64; LANES]; 3]| lanes.map(f64x4::from);
        for point in points {
            (0..3).for_each(|k| lanes[k][filled] = point[k]);
            (filled, last) = (filled + 1, point);
            if filled == LANES {
                self.blocks.push(block(&lanes));
                filled = 0;
            }
        }
        if filled > 0 {
            (filled..LANES).for_each(|lane| (0..3).for_each(|k| lanes[k][lane] = last[k]));
            self.blocks.push(block(&lanes));
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The blocks: x, y and z of four points each.
    pub fn blocks(&self) -> &[[f64x4; 3]] {
        &self.blocks
    }
}

/// A grid of vertices joined by vortex segments: across, from column to column, and along, from row to row.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    /// Vertices of a row.
    pub columns: usize,
    /// Vertices by row, m.
    pub points: Vec<Vec3>,
    /// Circulation of the segments from column j to j + 1, by row, `columns - 1` each, m2/s.
    pub across: Vec<f64>,
    /// Circulation of the segments from a row to the next, by row, `columns` each, m2/s.
    pub along: Vec<f64>,
    /// Squared core times squared length of the segments across, m4.
    pub core_across: Vec<f64>,
    /// The same of the segments along, m4.
    pub core_along: Vec<f64>,
}

impl Grid {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.points.len().checked_div(self.columns).unwrap_or(0)
    }

    /// Number of segments.
    pub fn segments(&self) -> usize {
        self.across.len() + self.along.len()
    }
}

/// A vertex as seen from four points: where they lie from it, and how far.
pub type Seen = ([f64x4; 3], f64x4);

/// `point` as seen from the points `p`.
#[inline(always)]
pub fn see(p: &[f64x4; 3], point: Vec3) -> Seen {
    let r: [f64x4; 3] = std::array::from_fn(|k| p[k] - f64x4::splat(point[k]));
    (r, r[0].mul_add(r[0], r[1].mul_add(r[1], r[2] * r[2])).sqrt())
}

/// Velocity at four points per 4 pi of circulation of the segment between two vertices.
#[inline(always)]
pub fn between<const CORE: bool>((r1, x): &Seen, (r2, y): &Seen, core: f64) -> [f64x4; 3] {
    let across = [
        r1[1].mul_sub(r2[2], r1[2] * r2[1]),
        r1[2].mul_sub(r2[0], r1[0] * r2[2]),
        r1[0].mul_sub(r2[1], r1[1] * r2[0]),
    ];
    let dot = r1[0].mul_add(r2[0], r1[1].mul_add(r2[1], r1[2] * r2[2]));
    let square = across[0].mul_add(across[0], across[1].mul_add(across[1], across[2] * across[2]));
    let (product, sum) = (*x * *y, *x + *y);
    let factor = if CORE {
        sum * (product - dot) / (product * (square + f64x4::splat(core)))
    } else {
        sum / (product * (product + dot))
    };
    // All ones off the line: zero on it, whatever the quotient is there.
    let off = square.simd_gt(product * product * f64x4::splat(ON_LINE));
    let factor = off & factor;
    across.map(|c| c * factor)
}

/// Adds to `velocities` what `grid` induces at `points`, m/s, on all cores where there is much to do.
pub fn add_velocities<const CORE: bool>(grid: &Grid, points: &Points, velocities: &mut [Vec3]) {
    let blocks = points.blocks();
    if points.len() * grid.segments() < SHARED {
        let mut seen = Vec::with_capacity(grid.columns);
        for (block, out) in blocks.iter().zip(velocities.chunks_mut(LANES)) {
            add_block(out, induced::<CORE>(grid, block, &mut seen));
        }
        return;
    }
    let chunks: Vec<_> = blocks.chunks(BLOCKS).collect();
    let answers = parallel::map(&chunks, |_, chunk| {
        let mut seen = Vec::with_capacity(grid.columns);
        chunk.iter().map(|block| induced::<CORE>(grid, block, &mut seen)).collect::<Vec<_>>()
    });
    for (out, answer) in velocities.chunks_mut(LANES).zip(answers.into_iter().flatten()) {
        add_block(out, answer);
    }
}

fn add_block(out: &mut [Vec3], velocity: [f64x4; 3]) {
    let lanes = velocity.map(|v| v.to_array());
    for (lane, v) in out.iter_mut().enumerate() {
        *v += Vec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
    }
}

/// Velocity at four points; `seen` is room for a row of vertices.
fn induced<const CORE: bool>(grid: &Grid, p: &[f64x4; 3], seen: &mut Vec<Seen>) -> [f64x4; 3] {
    let mut sum = [f64x4::ZERO; 3];
    let mut add = |unit: [f64x4; 3], circulation: f64| {
        let circulation = f64x4::splat(circulation);
        (0..3).for_each(|k| sum[k] = unit[k].mul_add(circulation, sum[k]));
    };
    let n = grid.columns;
    seen.clear();
    for (r, row) in grid.points.chunks_exact(n).enumerate() {
        let across = r * (n - 1);
        for (j, point) in row.iter().enumerate() {
            let now = see(p, *point);
            if r > 0 {
                let at = (r - 1) * n + j;
                add(between::<CORE>(&seen[j], &now, grid.core_along[at]), grid.along[at]);
                seen[j] = now;
            } else {
                seen.push(now);
            }
            if j > 0 {
                let at = across + j - 1;
                add(between::<CORE>(&seen[j - 1], &now, grid.core_across[at]), grid.across[at]);
            }
        }
    }
    sum.map(|v| v * f64x4::splat(INVERSE_4PI))
}

/// Adds the part along `normal` of what every segment of `grid` induces at four points per unit circulation:
/// `across` and `along` as in [`Grid`].
pub fn unit_washes<const CORE: bool>(
    grid: &Grid,
    p: &[f64x4; 3],
    normal: &[f64x4; 3],
    across: &mut [f64x4],
    along: &mut [f64x4],
    seen: &mut Vec<Seen>,
) {
    let part = |v: [f64x4; 3]| {
        let dot = v[0].mul_add(normal[0], v[1].mul_add(normal[1], v[2] * normal[2]));
        dot * f64x4::splat(INVERSE_4PI)
    };
    let n = grid.columns;
    seen.clear();
    for (r, row) in grid.points.chunks_exact(n).enumerate() {
        for (j, point) in row.iter().enumerate() {
            let now = see(p, *point);
            if r > 0 {
                let at = (r - 1) * n + j;
                along[at] += part(between::<CORE>(&seen[j], &now, grid.core_along[at]));
                seen[j] = now;
            } else {
                seen.push(now);
            }
            if j > 0 {
                let at = r * (n - 1) + j - 1;
                across[at] += part(between::<CORE>(&seen[j - 1], &now, grid.core_across[at]));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::math::Random;

    fn drawn(random: &mut Random) -> Vec3 {
        Vec3(std::array::from_fn(|_| random.normal()))
    }

    fn grid(random: &mut Random, rows: usize, columns: usize, soft: f64) -> Grid {
        let (across, along) = (rows * (columns - 1), (rows - 1) * columns);
        Grid {
            columns,
            points: (0..rows * columns).map(|_| drawn(random)).collect(),
            across: (0..across).map(|_| random.normal()).collect(),
            along: (0..along).map(|_| random.normal()).collect(),
            core_across: vec![soft; across],
            core_along: vec![soft; along],
        }
    }

    /// The grid segment by segment.
    fn slowly(grid: &Grid, p: Vec3, unit: impl Fn(Vec3, Vec3, Vec3, f64) -> Vec3) -> Vec3 {
        let n = grid.columns;
        let mut sum = Vec3::ZERO;
        for r in 0..grid.rows() {
            for j in 0..n {
                let a = grid.points[r * n + j];
                if j + 1 < n {
                    let at = r * (n - 1) + j;
                    sum += unit(p, a, grid.points[r * n + j + 1], grid.core_across[at]) * grid.across[at];
                }
                if r + 1 < grid.rows() {
                    let at = r * n + j;
                    sum += unit(p, a, grid.points[(r + 1) * n + j], grid.core_along[at]) * grid.along[at];
                }
            }
        }
        sum
    }

    #[test]
    fn lanes_agree_with_single_segments() {
        let mut random = Random::new(3);
        for (rows, columns, soft) in [(1, 2, 1e-3), (2, 2, 1e-12), (5, 4, 1e-2), (40, 9, 1e-4)] {
            let grid = grid(&mut random, rows, columns, soft);
            for count in [1, 4, 7] {
                let at: Vec<Vec3> = (0..count).map(|_| drawn(&mut random)).collect();
                let mut points = Points::default();
                points.set(at.iter().copied());
                let (mut bare, mut cored) = (vec![Vec3::ZERO; count], vec![Vec3::ZERO; count]);
                add_velocities::<false>(&grid, &points, &mut bare);
                add_velocities::<true>(&grid, &points, &mut cored);
                let strength: f64 = grid.across.iter().chain(&grid.along).map(|g| g.abs()).sum();
                for i in 0..count {
                    assert!(
                        (bare[i] - slowly(&grid, at[i], |p, a, b, _| segment(p, a, b))).norm()
                            < 1e-13 * strength.max(bare[i].norm())
                    );
                    let one = slowly(&grid, at[i], cored_segment);
                    assert!((cored[i] - one).norm() < 1e-13 * strength.max(one.norm()));
                }
            }
        }
    }

    #[test]
    fn a_long_segment_is_a_line_vortex_and_a_core_fades_it() {
        let ends = [-1e3, 1e3].map(|y| Vec3::new(0.0, y, 0.0));
        let p = Vec3::new(0.5, 0.0, 0.0);
        let line = 1.0 / (2.0 * std::f64::consts::PI * 0.5);
        let bare = segment(p, ends[0], ends[1]);
        assert!((bare[2] + line).abs() < 1e-6 && bare[0].abs() + bare[1].abs() < 1e-15);
        let core = cored_segment(p, ends[0], ends[1], (2e3_f64 * 0.5).powi(2));
        assert!((core[2] / bare[2] - 0.5).abs() < 1e-6);
        for at in [ends[0], ends[1], Vec3::ZERO, Vec3::new(0.0, 2e3, 0.0)] {
            assert_eq!(segment(at, ends[0], ends[1]).norm(), 0.0);
            assert_eq!(cored_segment(at, ends[0], ends[1], 1e-12).norm(), 0.0);
        }
    }

    #[test]
    fn work_on_all_cores_is_the_same_work() {
        let mut random = Random::new(9);
        let grid = grid(&mut random, 60, 30, 1e-4);
        let at: Vec<Vec3> = (0..700).map(|_| drawn(&mut random)).collect();
        let (mut points, mut all) = (Points::default(), vec![Vec3::ZERO; 700]);
        points.set(at.iter().copied());
        assert!(at.len() * grid.segments() > SHARED);
        add_velocities::<true>(&grid, &points, &mut all);
        for k in [0, 63, 64, 699] {
            let mut one = [Vec3::ZERO];
            points.set(at[k..=k].iter().copied());
            add_velocities::<true>(&grid, &points, &mut one);
            assert_eq!(one[0], all[k]);
        }
    }
}
