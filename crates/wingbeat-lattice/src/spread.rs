//! What bound vortices induce on each other, as the sheet does for which they stand.
//!
//! A force on a bound vortex needs the air along its whole length. What the legs and the wake induce is taken at the one point where
//! Lan's sums over strips are exact. What the other bound vortices induce varies within a strip wherever the wing has a kink, and is
//! taken as the mean over the strip. In that mean two vortices of one row that meet at a kink would pull without bound at their common
//! end; the sheet whose row they are spreads their circulation over the width of the panel.

use crate::influence::{InducingGrids, Influence, mirrored};
use crate::kernel::{PointLocation, VortexGrid, segment, softened_segment};
use crate::mesh::Mesh;
use crate::wake::Wake;
use wingbeat::math::Vec3;

/// Gauss-Legendre rule of six points on 0 to 1: places, weights. *Choice*: swept, tapered and delta wings of 6 x 24 panels have the
/// drag of their wake within 2 % with six points, and within 3 % with three.
const GAUSS: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_99, 0.085_662_246_189_585_17],
    [0.169_395_306_766_867_74, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_56, 0.233_956_967_286_345_52],
    [0.619_309_593_041_598_5, 0.233_956_967_286_345_52],
    [0.830_604_693_233_132_3, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_17],
];

/// The rule of three points, for what is mild. *Choice*: of the plate of the rows `lattice.shedding.measured` six points give the same
/// lift.
const FEW: [[f64; 2]; 3] = [
    [0.112_701_665_379_258_3, 0.277_777_777_777_777_8],
    [0.5, 0.444_444_444_444_444_4],
    [0.887_298_334_620_741_7, 0.277_777_777_777_777_8],
];

/// Strips on either side whose vortices are spread: further away the distance is many widths. *Choice.*
const NEAR: usize = 2;

/// Core of a bound vortex over the width of its panel.
///
/// The pull of a kink goes with the mean of ln r over pairs of points of the sheet. Vortices at 1/4 of `m` even panels, with the flow
/// tangent at 3/4, have strengths g_i; with the core k/m in the place of r for a vortex and itself they have the mean of a flat plate,
/// whose loading is (2/pi) sqrt((1-x)/x): sum_ik g_i g_k ln|x_i - x_k| + sum_i g_i^2 ln(k/m) = -2 ln 2 - 1/2, by
/// ln|cos s - cos t| = -ln 2 - 2 sum cos(ns) cos(nt)/n. That gives k = 0.152, 0.148, 0.148, 0.149, 0.152 for m = 1, 2, 4, 12, 100.
const CORE: f64 = 0.148;

/// What has to be added, by surface, to the velocities that the bound rings induce at the points of [`Mesh::fronts`], m/s.
///
/// Equation: lattice.bound_mean
/// `mean along a bound vortex of what the other bound vortices induce, those of its row softened over .148 panel
/// widths`
/// Source: own derivation: mean of ln r over a flat plate's loading.
/// Test: `steady_wings_have_the_drag_of_their_wake`.
pub fn changes(meshes: &[Mesh], influence: &Influence) -> Vec<Vec<Vec3>> {
    let across: Vec<VortexGrid> = meshes.iter().map(across).collect();
    let sources = InducingGrids { bound: across.iter().enumerate().collect(), cored: Vec::new() };
    let (mut points, mut places) = (Vec::new(), Vec::new());
    for (surface, mesh) in meshes.iter().enumerate() {
        for (k, front) in mesh.fronts.iter().enumerate() {
            let j = k % mesh.strips;
            for f in fractions(mesh, j) {
                points.push(front.at + front.along * (f - mesh.fractions[j]));
                places.push(PointLocation::On(surface, mesh.arcs[j] + (mesh.arcs[j + 1] - mesh.arcs[j]) * f));
            }
        }
    }
    let velocities = influence.velocities(&points, &places, &sources);
    let mut seen = points.chunks_exact(GAUSS.len() + 1).zip(velocities.chunks_exact(GAUSS.len() + 1));
    let of = |mesh: &Mesh| {
        let fronts = seen.by_ref().take(mesh.fronts.len()).enumerate();
        fronts
            .map(|(k, (points, v))| {
                let mean = GAUSS.iter().zip(&v[1..]).zip(&points[1..]).map(|(([_, weight], v), p)| {
                    (*v + rounding(mesh, k / mesh.strips, k % mesh.strips, *p, influence.symmetric()))
                        * *weight
                });
                mean.fold(Vec3::ZERO, |sum, v| sum + v) - v[0]
            })
            .collect()
    };
    meshes.iter().map(of).collect()
}

/// Where along a bound vortex of strip `j` the air is wanted: at the point of the strip, and at those of the mean.
fn fractions(mesh: &Mesh, j: usize) -> impl Iterator<Item = f64> {
    std::iter::once(mesh.fractions[j]).chain(GAUSS.map(|[place, _]| place))
}

/// What has to be added, by surface, to the velocities that noses and `sheets` induce at the points of [`Mesh::legs`] (m/s), where
/// leading edges shed: on the legs of the first panels and of the nose their mean from the middle of one strip beside to that of the
/// other. A sheet lies over a wing by less than the width of a strip, and its filaments right over the legs: at a distance a, filaments
/// that are d apart induce at the legs coth(pi a/d) times what the sheet does for which they stand, and their mean over d is that
/// of the sheet. So it is with the corner that each filament has at the edge, which would pull itself. The points `first` choose the sums
/// ([`Influence::velocities_by`]), or become those of this trial where there are none.
pub fn changes_by_sheets(
    meshes: &[Mesh],
    sheets: &[Wake],
    influence: &Influence,
    first: &mut Vec<Vec3>,
) -> Vec<Vec<Vec3>> {
    let rising: Vec<VortexGrid> = meshes.iter().map(rising).collect();
    let heads = meshes.iter().map(|mesh| &mesh.heads);
    let cored = heads.chain(sheets.iter().map(|sheet| &sheet.grid)).collect();
    let sources = InducingGrids { bound: rising.iter().enumerate().collect(), cored };
    let (mut points, mut places) = (Vec::new(), Vec::new());
    for (surface, mesh) in meshes.iter().enumerate() {
        for leg in first_legs(mesh) {
            for (f, _) in halves(mesh, leg % mesh.arcs.len()) {
                let (from, to) = (mesh.legs[leg].at, mesh.legs[f.toward(leg)].at);
                points.push(from + (to - from) * f.way);
                let [from, to] = [leg, f.toward(leg)].map(|leg| mesh.arcs[leg % mesh.arcs.len()]);
                places.push(PointLocation::On(surface, from + (to - from) * f.way));
            }
        }
    }
    if first.is_empty() {
        first.clone_from(&points);
    }
    let velocities = influence.velocities_by(&points, first, &places, &sources);
    let mut seen = velocities.iter();
    let of = |mesh: &Mesh| {
        let mut changes = vec![Vec3::ZERO; mesh.legs.len()];
        for leg in first_legs(mesh) {
            let parts = halves(mesh, leg % mesh.arcs.len()).zip(seen.by_ref());
            changes[leg] = parts.fold(Vec3::ZERO, |sum, ((_, weight), v)| sum + *v * weight);
        }
        changes
    };
    meshes.iter().map(of).collect()
}

/// The legs of the first panels, then those of the nose.
fn first_legs(mesh: &Mesh) -> impl Iterator<Item = usize> {
    let sides = mesh.arcs.len();
    (0..sides).chain(mesh.chordwise * sides..(mesh.chordwise + 1) * sides)
}

/// A place between a leg and one beside it.
struct NeighbourLeg {
    right: bool,
    /// Share of the way to that leg.
    way: f64,
}

impl NeighbourLeg {
    fn toward(&self, leg: usize) -> usize {
        if self.right { leg + 1 } else { leg - usize::from(self.way > 0.0) }
    }
}

/// Places about the leg `side` of a row with their weights in the mean less what is at the leg.
fn halves(mesh: &Mesh, side: usize) -> impl Iterator<Item = (NeighbourLeg, f64)> {
    let arcs = &mesh.arcs;
    let width = |right: bool| {
        let to = if right { side.checked_add(1) } else { side.checked_sub(1) };
        to.and_then(|to| arcs.get(to)).map_or(0.0, |to| (to - arcs[side]).abs())
    };
    let widths = [width(false), width(true)];
    let all = widths[0] + widths[1];
    let at_leg = std::iter::once((NeighbourLeg { right: false, way: 0.0 }, -1.0));
    let of = move |right: bool| {
        let share = widths[usize::from(right)] / all;
        let within = FEW.into_iter().filter(move |_| share > 0.0);
        within.map(move |[place, weight]| (NeighbourLeg { right, way: 0.5 * place }, share * weight))
    };
    at_leg.chain(of(false)).chain(of(true))
}

/// The rings of the nose without what lies on the wing.
fn rising(mesh: &Mesh) -> VortexGrid {
    let (nose, columns) = (&mesh.nose, mesh.arcs.len());
    VortexGrid {
        columns,
        points: nose.points[columns..].to_vec(),
        across: nose.across[columns - 1..].to_vec(),
        along: nose.along[columns..].to_vec(),
        core_across: nose.core_across[columns - 1..].to_vec(),
        core_along: nose.core_along[columns..].to_vec(),
        arcs: nose.arcs.clone(),
    }
}

/// The bound vortices alone: a single row of vertices, in which a segment without circulation leads from each row of the wing to the next.
fn across(mesh: &Mesh) -> VortexGrid {
    let (bound, n) = (&mesh.bound, mesh.strips);
    let joined = |of: &[f64]| -> Vec<f64> {
        let rows = of.chunks_exact(n).take(mesh.chordwise).flat_map(|row| row.iter().copied().chain([0.0]));
        rows.take(mesh.chordwise * (n + 1) - 1).collect()
    };
    VortexGrid {
        columns: mesh.chordwise * (n + 1),
        points: bound.points[..mesh.chordwise * (n + 1)].to_vec(),
        across: joined(&bound.across),
        core_across: joined(&bound.core_across),
        arcs: bound.arcs.repeat(mesh.chordwise),
        ..VortexGrid::default()
    }
}

/// What the cores of the vortices of row `i` near strip `j` change at its point `p`, m/s.
fn rounding(mesh: &Mesh, i: usize, j: usize, p: Vec3, symmetric: bool) -> Vec3 {
    let n = mesh.strips;
    let own = width(mesh, i, j);
    let of = |p: Vec3, k: usize| {
        let [a, b] = [k, k + 1].map(|k| mesh.bound.points[i * (n + 1) + k]);
        let core = CORE * 0.5 * (own + width(mesh, i, k));
        (softened_segment(p, a, b, core) - segment(p, a, b)) * mesh.bound.across[i * n + k]
    };
    let beside = (j.saturating_sub(NEAR)..(j + NEAR + 1).min(n)).filter(|k| *k != j);
    let mut sum = beside.map(|k| of(p, k)).fold(Vec3::ZERO, |sum, v| sum + v);
    // The mirror image of the strip n - 1 - k is the k-th beyond the middle.
    if symmetric && mesh.reaches_middle() {
        let reach = (j + NEAR + 1).saturating_sub(n).min(n);
        for k in 0..reach {
            sum += mirrored(of(mirrored(p), n - 1 - k));
        }
    }
    sum
}

/// Width of a panel square to its bound vortex, m.
fn width(mesh: &Mesh, i: usize, j: usize) -> f64 {
    let at = i * mesh.strips + j;
    mesh.controls[at].area / mesh.fronts[at].along.norm()
}
