//! Velocities induced by straight vortex segments: one at a time, and of whole grids at many points.

use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// 1/(4 pi), dimensionless.
pub const INVERSE_4PI: f64 = 0.25 * std::f64::consts::FRAC_1_PI;
/// Points of one block of lanes.
pub const LANES: usize = 4;
/// Squared sine of the angle between the ways from a point to the ends of a segment below which it lies on the segment's line: legs of
/// millimetres whose places are rounded metres from the origin are that far off.
const ON_LINE: f64 = 1e-18;
/// Added to denominators (m4): far below any of them, so that the product of two is no zero either, nor infinite its inverse.
pub const NEVER_ZERO: f64 = 1e-120;
/// Pairs of segments and points from which work is shared among the cores. *Choice.*
const SHARED: usize = 2_000_000;
/// Blocks that one core takes at a time. *Choice.*
const BLOCKS: usize = 16;

/// Velocity at `p` per unit circulation, 1/m, of the segment from `a` to `b`: (d x r) (r1 + r2) / (4 pi r1 r2 (r1 r2 + r1.r2)),
/// d = b - a; nothing on the line of the segment.
///
/// Equation: lattice.segment
/// `v = (d x r) (r1 + r2) / (4 pi r1 r2 (r1 r2 + r1.r2))`
/// Source: Biot & Savart; Katz & Plotkin 2001, section 10.4.5, rearranged.
/// Test: `lanes_agree_with_single_segments`.
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
/// `the same with 1/(r1 r2 + r1.r2) = (r1 r2 - r1.r2)/abs(r1 x r2)^2 and abs(r1 x r2)^2 + (l rc)^2 in its place`
/// Source: form of PteraSoftware 5.1.0.
/// Test: `a_long_segment_is_a_line_vortex_and_a_core_fades_it`.
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

/// The same of a vortex softened over the distance `core`, m: r^2 + core^2 in the place of r^2 in the law of Biot and Savart, integrated
/// along the segment.
///
/// Equation: lattice.softened_segment
/// `v = (d x r) (R1 + R2) / (4 pi R1 R2 (R1 R2 + r1.r2 + c^2)), R^2 = r^2 + c^2`
/// Source: Rosenhead 1930, Proc. R. Soc. A 127, integrated along the segment.
/// Test: `a_softened_segment_is_the_integral_of_its_law`.
pub fn softened_segment(p: Vec3, a: Vec3, b: Vec3, core: f64) -> Vec3 {
    let (r1, r2) = (p - a, p - b);
    let square = core * core;
    let [x, y] = [r1, r2].map(|r| (r.norm_squared() + square).sqrt());
    let product = x * y;
    r1.cross(r2) * (INVERSE_4PI * (x + y) / (product * (product + r1.dot(r2) + square)))
}

/// Points at which velocities are wanted, in lanes; those that fill up the last block repeat the last point.
#[derive(Clone, Debug, Default)]
pub struct FieldPoints {
    count: usize,
    blocks: Vec<[f64x4; 3]>,
}

impl FieldPoints {
    /// Takes the place of the points held, m.
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

    /// The blocks: x, y and z of four points each, m.
    pub fn blocks(&self) -> &[[f64x4; 3]] {
        &self.blocks
    }
}

/// A grid of vertices joined by vortex segments: across, from column to column, and along, from row to row.
#[derive(Clone, Debug, Default)]
pub struct VortexGrid {
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
    /// Arc coordinates of the columns, m, of bound grids.
    pub arcs: Vec<f64>,
}

impl VortexGrid {
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
pub type SeenVertex = ([f64x4; 3], f64x4);

/// `point` as seen from the points `p`, m.
#[inline(always)]
pub fn see(p: &[f64x4; 3], point: Vec3) -> SeenVertex {
    let r: [f64x4; 3] = std::array::from_fn(|k| p[k] - f64x4::splat(point[k]));
    (r, r[0].mul_add(r[0], r[1].mul_add(r[1], r[2] * r[2])).sqrt())
}

/// r1 x r2.
#[inline(always)]
fn crossed(r1: &[f64x4; 3], r2: &[f64x4; 3]) -> [f64x4; 3] {
    [
        r1[1].mul_sub(r2[2], r1[2] * r2[1]),
        r1[2].mul_sub(r2[0], r1[0] * r2[2]),
        r1[0].mul_sub(r2[1], r1[1] * r2[0]),
    ]
}

/// r1 . r2.
#[inline(always)]
fn dot(r1: &[f64x4; 3], r2: &[f64x4; 3]) -> f64x4 {
    r1[0].mul_add(r2[0], r1[1].mul_add(r2[1], r1[2] * r2[2]))
}

/// Velocity at four points per 4 pi of circulation of the segment between two vertices, without a core.
#[inline(always)]
fn bare((r1, x): &SeenVertex, (r2, y): &SeenVertex) -> [f64x4; 3] {
    let (across, dot) = (crossed(r1, r2), dot(r1, r2));
    let square = across[0].mul_add(across[0], across[1].mul_add(across[1], across[2] * across[2]));
    let (product, sum) = (*x * *y, *x + *y);
    let factor = sum / (product * (product + dot));
    // All ones off the line: zero on it, whatever the quotient is there.
    let off = square.simd_gt(product * product * f64x4::splat(ON_LINE));
    let factor = off & factor;
    across.map(|c| c * factor)
}

/// With a core: r1 x r2, and numerator and denominator of what it is to be multiplied with. As
/// |r1 x r2|^2 = (r1 r2 - r1.r2)(r1 r2 + r1.r2), the factor is (r1 + r2) e / (r1 r2 (e (r1 r2 + r1.r2) + core)), e = r1 r2 - r1.r2,
/// in which the rounding of e falls out as the core does. The denominator is never zero.
#[inline(always)]
fn cored((r1, x): &SeenVertex, (r2, y): &SeenVertex, core: f64x4) -> ([f64x4; 3], f64x4, f64x4) {
    let (across, dot) = (crossed(r1, r2), dot(r1, r2));
    let product = *x * *y;
    let excess = (product - dot).max(f64x4::ZERO);
    let square = excess.mul_add(product + dot, core);
    (across, (*x + *y) * excess, product.mul_add(square, f64x4::splat(NEVER_ZERO)))
}

/// Velocity at four points per 4 pi of circulation, 1/m, of the segment between two vertices, with the squared core times
/// squared length (m4).
#[inline(always)]
pub fn between<const CORE: bool>(a: &SeenVertex, b: &SeenVertex, core: f64x4) -> [f64x4; 3] {
    if !CORE {
        return bare(a, b);
    }
    let (across, numerator, denominator) = cored(a, b, core);
    let factor = numerator / denominator;
    across.map(|c| c * factor)
}

/// Part of a grid: its vertices from the first to the last row and column. Segments on its last row and column are another part's,
/// unless the grid ends there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// First and last row.
    pub rows: [usize; 2],
    /// First and last column.
    pub columns: [usize; 2],
}

impl VortexGrid {
    /// All of the grid.
    pub fn whole(&self) -> Window {
        Window { rows: [0, self.rows().saturating_sub(1)], columns: [0, self.columns.saturating_sub(1)] }
    }
}

/// Adds to `velocities` what `grid` induces at `points`, m/s, on all cores where there is much to do.
pub fn add_velocities<const CORE: bool>(grid: &VortexGrid, points: &FieldPoints, velocities: &mut [Vec3]) {
    let (blocks, window) = (points.blocks(), grid.whole());
    let some = |blocks: &[[f64x4; 3]]| {
        let (mut room, mut sums) = (VertexRoom::default(), vec![[f64x4::ZERO; 3]; blocks.len()]);
        if CORE {
            add_all(grid, &[window], blocks, &mut room, &mut sums);
        } else {
            for (block, sum) in blocks.iter().zip(&mut sums) {
                add_induced::<CORE>(grid, &window, block, &mut room.four, sum);
            }
        }
        sums.into_iter().map(|sum| sum.map(|v| v * f64x4::splat(INVERSE_4PI))).collect::<Vec<_>>()
    };
    if points.len() * grid.segments() < SHARED {
        for (out, answer) in velocities.chunks_mut(LANES).zip(some(blocks)) {
            add_block(out, answer);
        }
        return;
    }
    let chunks: Vec<_> = blocks.chunks(BLOCKS).collect();
    let answers = parallel::map(&chunks, |_, chunk| some(chunk));
    for (out, answer) in velocities.chunks_mut(LANES).zip(answers.into_iter().flatten()) {
        add_block(out, answer);
    }
}

/// Room for rows of vertices as seen from points.
#[derive(Default)]
pub struct VertexRoom {
    four: Vec<SeenVertex>,
    #[cfg(target_arch = "x86_64")]
    eight: Vec<crate::wider::WideVertex>,
}

/// Adds to `sums` the velocities times 4 pi (m/s) at the points of `blocks` that parts of a grid of vortices with cores induce.
/// Eight points at once where the processor can, else four, to the same bits.
pub fn add_all(
    grid: &VortexGrid,
    windows: &[Window],
    blocks: &[[f64x4; 3]],
    room: &mut VertexRoom,
    sums: &mut [[f64x4; 3]],
) {
    let mut begin = 0;
    #[cfg(target_arch = "x86_64")]
    if crate::wider::is_there() {
        for (pair, sums) in blocks.chunks_exact(2).zip(sums.chunks_exact_mut(2)) {
            let mut both = [sums[0], sums[1]];
            for window in windows {
                #[expect(unsafe_code, reason = "it has been asked whether the processor has AVX-512")]
                unsafe {
                    crate::wider::add_induced(grid, window, [&pair[0], &pair[1]], &mut room.eight, &mut both);
                }
            }
            sums.copy_from_slice(&both);
            begin += 2;
        }
    }
    for (block, sum) in blocks[begin..].iter().zip(&mut sums[begin..]) {
        for window in windows {
            add_induced::<true>(grid, window, block, &mut room.four, sum);
        }
    }
}

/// Adds velocities (m/s) at four points to those of up to four.
pub fn add_block(out: &mut [Vec3], velocity: [f64x4; 3]) {
    let lanes = velocity.map(|v| v.to_array());
    for (lane, v) in out.iter_mut().enumerate() {
        *v += Vec3::new(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
    }
}

/// Adds the velocity times 4 pi (m/s) at four points that a part of a grid induces; `seen` is room for a row of vertices.
pub fn add_induced<const CORE: bool>(
    grid: &VortexGrid,
    window: &Window,
    p: &[f64x4; 3],
    seen: &mut Vec<SeenVertex>,
    sum: &mut [f64x4; 3],
) {
    let n = grid.columns;
    let [first_row, last_row] = window.rows;
    let [first, last] = window.columns;
    // What lies on the far edges of a part is another's.
    let last_along = if last + 1 < n { 0.0 } else { 1.0 };
    let splat = f64x4::splat;
    let add = |a: &SeenVertex, b: &SeenVertex, core: f64, strength: f64, sum: &mut [f64x4; 3]| {
        let unit = between::<CORE>(a, b, splat(core));
        (0..3).for_each(|k| sum[k] = unit[k].mul_add(splat(strength), sum[k]));
    };
    seen.clear();
    for r in first_row..=last_row {
        let points = &grid.points[r * n + first..=r * n + last];
        let here = r * (n - 1) + first..r * (n - 1) + last;
        let (across, core_across) = (&grid.across[here.clone()], &grid.core_across[here]);
        let own = if r == last_row && r + 1 < grid.rows() { 0.0 } else { 1.0 };
        let mut left = see(p, points[0]);
        if r == first_row {
            seen.push(left);
            for ((point, strength), core) in points[1..].iter().zip(across).zip(core_across) {
                let now = see(p, *point);
                add(&left, &now, *core, own * strength, sum);
                seen.push(now);
                left = now;
            }
            continue;
        }
        let above = (r - 1) * n + first..=(r - 1) * n + last;
        let (along, core_along) = (&grid.along[above.clone()], &grid.core_along[above]);
        let edge = if points.len() == 1 { last_along } else { 1.0 };
        add(&seen[0], &left, core_along[0], edge * along[0], sum);
        seen[0] = left;
        let cells = points.len() - 1;
        let rest = points[1..].iter().zip(&mut seen[1..]).zip(across.iter().zip(core_across));
        let rest = rest.zip(along[1..].iter().zip(&core_along[1..])).enumerate();
        for (cell, (((point, before), (across, core_across)), (along, core_along))) in rest {
            let now = see(p, *point);
            let along = if cell + 1 == cells { last_along * along } else { *along };
            if CORE {
                let (c, a, b) = cored(before, &now, splat(*core_along));
                let (d, e, f) = cored(&left, &now, splat(*core_across));
                // Two quotients for one division.
                let inverse = f64x4::ONE / (b * f);
                let one = a * splat(along) * (f * inverse);
                let two = e * splat(own * across) * (b * inverse);
                (0..3).for_each(|k| sum[k] = c[k].mul_add(one, d[k].mul_add(two, sum[k])));
            } else {
                add(before, &now, *core_along, along, sum);
                add(&left, &now, *core_across, own * across, sum);
            }
            *before = now;
            left = now;
        }
    }
}

/// Where a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointLocation {
    /// On the surface of this number at an arc coordinate, m.
    On(usize, f64),
    /// In the wake.
    Wake,
}

/// How bound vortices are rounded off where parts of a wing pass through each other: by a share of the distance along the arc beyond
/// the first `near` m, so that a wing's neighbouring strips feel nothing of it; on the wake as the wake's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Core over the distance along the arc.
    pub share: f64,
    /// Distance along the arc up to which there is none, m.
    pub near: f64,
    /// Core in the wake, m.
    pub wake: f64,
}

impl Crossing {
    /// Squared core at `place` of the vortex at the arc coordinate `arc` of the surface number `surface`, m2.
    ///
    /// Equation: lattice.crossing
    /// `core = share max(0, abs(s_i - s_j) - near) of a bound vortex at the arc s_j felt at s_i`
    /// Source: choice: strips far apart along a wing that meet are no neighbours.
    /// Test: `wings_that_pass_through_each_other_are_finite`.
    pub fn square(&self, place: PointLocation, surface: usize, arc: f64) -> f64 {
        let radius = match place {
            PointLocation::On(own, at) if own == surface => {
                self.share * ((at - arc).abs() - self.near).max(0.0)
            }
            PointLocation::On(..) => 0.0,
            PointLocation::Wake => self.wake,
        };
        radius * radius
    }

    /// The squared cores (m2) at four points of the vortices along at the columns `arcs`, and of those across between them.
    pub fn squares(&self, places: [PointLocation; LANES], surface: usize, arcs: &[f64]) -> [Vec<f64x4>; 2] {
        let at = |arc: f64| f64x4::from(places.map(|place| self.square(place, surface, arc)));
        let middles = arcs.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        [arcs.iter().map(|arc| at(*arc)).collect(), middles.map(at).collect()]
    }
}

/// Velocity at four points per 4 pi of circulation, 1/m, of the segment between two vertices, with the squared core times
/// squared length, which may be zero; nothing on the segment's line.
#[inline(always)]
pub fn rounded(a: &SeenVertex, b: &SeenVertex, core: f64x4) -> [f64x4; 3] {
    let (across, numerator, denominator) = cored(a, b, core);
    let square = across[0].mul_add(across[0], across[1].mul_add(across[1], across[2] * across[2]));
    let product = a.1 * b.1;
    let off = square.simd_gt(product * product * f64x4::splat(ON_LINE));
    let factor = off & (numerator / denominator);
    across.map(|c| c * factor)
}

/// A segment of a grid: its number among those across or along, and its column.
#[derive(Clone, Copy, Debug)]
pub enum Segment {
    Across(usize, usize),
    Along(usize, usize),
}

/// Every segment of a grid, with its two vertices as seen from the four points `p` (m); `seen` is room for a row of vertices.
#[inline(always)]
pub fn each_segment(
    grid: &VortexGrid,
    p: &[f64x4; 3],
    seen: &mut Vec<SeenVertex>,
    mut with: impl FnMut(Segment, &SeenVertex, &SeenVertex),
) {
    let n = grid.columns;
    seen.clear();
    for (r, row) in grid.points.chunks_exact(n).enumerate() {
        for (j, point) in row.iter().enumerate() {
            let now = see(p, *point);
            if r > 0 {
                with(Segment::Along((r - 1) * n + j, j), &seen[j], &now);
                seen[j] = now;
            } else {
                seen.push(now);
            }
            if j > 0 {
                with(Segment::Across(r * (n - 1) + j - 1, j - 1), &seen[j - 1], &now);
            }
        }
    }
}

/// Adds to `velocities` what the bound `grid` of the surface number `surface` induces at `points`, which lie at `places`, m/s. Its
/// cores are the squared lengths of its segments.
pub fn add_rounded(
    grid: &VortexGrid,
    surface: usize,
    crossing: &Crossing,
    points: &FieldPoints,
    places: &[PointLocation],
    velocities: &mut [Vec3],
) {
    let mut seen = Vec::with_capacity(grid.columns);
    let blocks = points.blocks().iter().zip(places.chunks(LANES));
    for ((block, places), out) in blocks.zip(velocities.chunks_mut(LANES)) {
        let lanes = std::array::from_fn(|lane| places[lane.min(places.len() - 1)]);
        let [along, across] = crossing.squares(lanes, surface, &grid.arcs);
        let mut sum = [f64x4::ZERO; 3];
        each_segment(grid, block, &mut seen, |segment, a, b| {
            let (core, strength) = match segment {
                Segment::Along(at, j) => (along[j] * f64x4::splat(grid.core_along[at]), grid.along[at]),
                Segment::Across(at, j) => (across[j] * f64x4::splat(grid.core_across[at]), grid.across[at]),
            };
            let unit = rounded(a, b, core);
            (0..3).for_each(|k| sum[k] = unit[k].mul_add(f64x4::splat(strength), sum[k]));
        });
        add_block(out, sum.map(|v| v * f64x4::splat(INVERSE_4PI)));
    }
}

/// Adds the part along `normal` of what every segment of `grid` induces at four points per unit circulation (1/m). `across` and
/// `along` are as in [`VortexGrid`]; `unit` is what a segment between two vertices induces per 4 pi.
#[inline(always)]
pub fn unit_washes(
    grid: &VortexGrid,
    p: &[f64x4; 3],
    normal: &[f64x4; 3],
    [across, along]: [&mut [f64x4]; 2],
    seen: &mut Vec<SeenVertex>,
    unit: impl Fn(Segment, &SeenVertex, &SeenVertex) -> [f64x4; 3],
) {
    each_segment(grid, p, seen, |segment, a, b| {
        let v = unit(segment, a, b);
        let dot = v[0].mul_add(normal[0], v[1].mul_add(normal[1], v[2] * normal[2]));
        let part = dot * f64x4::splat(INVERSE_4PI);
        match segment {
            Segment::Across(at, _) => across[at] += part,
            Segment::Along(at, _) => along[at] += part,
        }
    });
}

/// What a segment induces per 4 pi of circulation, 1/m, with the grid's own cores.
#[inline(always)]
pub fn own<const CORE: bool>(
    grid: &VortexGrid,
    segment: Segment,
    a: &SeenVertex,
    b: &SeenVertex,
) -> [f64x4; 3] {
    let core = match segment {
        Segment::Across(at, _) => grid.core_across[at],
        Segment::Along(at, _) => grid.core_along[at],
    };
    between::<CORE>(a, b, f64x4::splat(core))
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::math::Random;

    fn drawn(random: &mut Random) -> Vec3 {
        Vec3(std::array::from_fn(|_| random.normal()))
    }

    fn grid(random: &mut Random, rows: usize, columns: usize, soft: f64) -> VortexGrid {
        let (across, along) = (rows * (columns - 1), (rows - 1) * columns);
        VortexGrid {
            columns,
            points: (0..rows * columns).map(|_| drawn(random)).collect(),
            across: (0..across).map(|_| random.normal()).collect(),
            along: (0..along).map(|_| random.normal()).collect(),
            core_across: vec![soft; across],
            core_along: vec![soft; along],
            arcs: Vec::new(),
        }
    }

    /// The grid segment by segment.
    fn slowly(grid: &VortexGrid, p: Vec3, unit: impl Fn(Vec3, Vec3, Vec3, f64) -> Vec3) -> Vec3 {
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
    fn eight_points_at_once_have_the_bits_of_four() {
        let mut random = Random::new(7);
        let grid = grid(&mut random, 12, 9, 1e-4);
        let blocks: Vec<[f64x4; 3]> = (0..5)
            .map(|_| std::array::from_fn(|_| f64x4::from(std::array::from_fn(|_| random.normal()))))
            .collect();
        let windows = [
            grid.whole(),
            Window { rows: [2, 7], columns: [1, 4] },
            Window { rows: [3, 3], columns: [5, 5] },
        ];
        let (mut all, mut four) = (vec![[f64x4::ZERO; 3]; 5], vec![[f64x4::ZERO; 3]; 5]);
        add_all(&grid, &windows, &blocks, &mut VertexRoom::default(), &mut all);
        for (block, sum) in blocks.iter().zip(&mut four) {
            windows.iter().for_each(|w| add_induced::<true>(&grid, w, block, &mut Vec::new(), sum));
        }
        for (all, four) in all.iter().flatten().zip(four.iter().flatten()) {
            assert_eq!(all.to_array().map(f64::to_bits), four.to_array().map(f64::to_bits));
        }
    }

    #[test]
    fn lanes_agree_with_single_segments() {
        let mut random = Random::new(3);
        for (rows, columns, soft) in [(1, 2, 1e-3), (2, 2, 1e-12), (5, 4, 1e-2), (40, 9, 1e-4)] {
            let grid = grid(&mut random, rows, columns, soft);
            for count in [1, 4, 7] {
                let at: Vec<Vec3> = (0..count).map(|_| drawn(&mut random)).collect();
                let mut points = FieldPoints::default();
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
    fn a_softened_segment_is_the_integral_of_its_law() {
        let (p, a, b, core) =
            (Vec3::new(0.3, 0.2, -0.1), Vec3::new(0.0, 1.0, 0.2), Vec3::new(0.5, -0.7, 0.0), 0.4);
        let count = 2000_u16;
        let part = |k: usize| {
            let r = p - (a + (b - a) * ((k as f64 + 0.5) / f64::from(count)));
            (b - a).cross(r) * ((r.norm_squared() + core * core).powf(-1.5) * INVERSE_4PI / f64::from(count))
        };
        let sum = (0..usize::from(count)).map(part).fold(Vec3::ZERO, |sum, v| sum + v);
        assert!((sum - softened_segment(p, a, b, core)).norm() < 1e-6 * sum.norm());
        assert!((softened_segment(p, a, b, 0.0) - segment(p, a, b)).norm() < 1e-14);
        assert!(softened_segment(a + (b - a) * 0.3, a, b, core).norm() < 1e-16);
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
        let (mut points, mut all) = (FieldPoints::default(), vec![Vec3::ZERO; 700]);
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
