//! What rings and wakes induce, mirror images included.

use crate::kernel::{
    Crossing, Grid, LANES, Place, Points, Seen, Segment, add_rounded, add_velocities, own, rounded,
    unit_washes,
};
use crate::mesh::{Control, Mesh};
use crate::tree::Tree;
use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// Grids that induce velocities.
pub struct Sources<'a> {
    /// Bound rings, with the number of their surface.
    pub bound: Vec<(usize, &'a Grid)>,
    /// Vortices with cores: wakes and the ends of the last rings.
    pub cored: Vec<&'a Grid>,
}

/// How velocities are summed.
#[derive(Clone, Debug)]
pub struct Influence {
    symmetric: bool,
    /// Whether bound vortices have cores.
    cored: bool,
    /// How bound vortices are rounded off where parts of a wing cross.
    crossing: Option<Crossing>,
    /// Segments of a wake from which it is summed by multipoles.
    fast_from: usize,
}

/// Panels from which the coefficients are shared among the cores. *Choice.*
const SHARED: usize = 200;

/// A control point, the normal there, and where it lies.
type Aimed = (Vec3, Vec3, Place);

/// Rows of rings on a surface.
struct Rings<'a> {
    /// How many; the last reach to the ends.
    rows: usize,
    bound: &'a Grid,
    /// The ends of the last rings.
    ends: &'a Grid,
}

/// Four control points, or their mirror images.
struct SeenFrom {
    at: [f64x4; 3],
    normal: [f64x4; 3],
    places: [Place; LANES],
}

/// The mirror image at the plane y = 0.
pub fn mirrored(v: Vec3) -> Vec3 {
    let [x, y, z] = v.0;
    Vec3([x, -y, z])
}

impl Influence {
    /// With the mirror image of all sources where `symmetric`; with cores on bound vortices where `cored`, or where parts of a wing
    /// cross as `crossing` says; wakes of `fast_from` segments and more by multipoles.
    pub fn new(symmetric: bool, cored: bool, crossing: Option<Crossing>, fast_from: usize) -> Self {
        Self { symmetric, cored, crossing, fast_from }
    }

    /// Induced velocities at `points`, which lie at `places`, m/s. What the mirror image of the sources induces at p is the mirror
    /// image of what they induce at the mirror image of p.
    pub fn velocities(&self, points: &[Vec3], places: &[Place], sources: &Sources<'_>) -> Vec<Vec3> {
        let count = points.len();
        let images = if self.symmetric { count } else { 0 };
        let image = points[..images].iter().map(|p| mirrored(*p));
        let all: Vec<Vec3> = points.iter().copied().chain(image).collect();
        let mut lanes = Points::default();
        lanes.set(all.iter().copied());
        let mut velocities = vec![Vec3::ZERO; all.len()];
        match &self.crossing {
            Some(crossing) => {
                let image = |place: &Place| match *place {
                    Place::On(surface, arc) => Place::On(surface, -arc),
                    Place::Wake => Place::Wake,
                };
                let places: Vec<Place> =
                    places.iter().copied().chain(places[..images].iter().map(image)).collect();
                for (surface, grid) in &sources.bound {
                    add_rounded(grid, *surface, crossing, &lanes, &places, &mut velocities);
                }
            }
            None => {
                for (_, grid) in &sources.bound {
                    match self.cored {
                        true => add_velocities::<true>(grid, &lanes, &mut velocities),
                        false => add_velocities::<false>(grid, &lanes, &mut velocities),
                    }
                }
            }
        }
        for grid in &sources.cored {
            // A single row has no cells to be halved.
            match grid.rows() > 1 && grid.segments() >= self.fast_from {
                true => Tree::new(grid).add_velocities(&all, &mut velocities),
                false => add_velocities::<true>(grid, &lanes, &mut velocities),
            }
        }
        let image = velocities.split_off(count);
        velocities.iter_mut().zip(image).for_each(|(v, image)| *v += mirrored(image));
        velocities
    }

    /// The same with bound vortices that have the core of the wake, `core` m, where the wake feels them: sheets that leave the leading edge
    /// pass close over the wing.
    pub fn softened(&self, core: f64) -> Self {
        let wake_only = Crossing { share: 0.0, near: 0.0, wake: core };
        Self { crossing: self.crossing.or(Some(wake_only)), ..self.clone() }
    }

    /// Whether the mirror image of all sources is there.
    pub fn symmetric(&self) -> bool {
        self.symmetric
    }

    /// What rings of unit circulation induce along the normals at the control points, row by row, 1/m.
    pub fn coefficients(&self, meshes: &[Mesh]) -> Vec<f64> {
        self.columns(meshes, |mesh| Rings { rows: mesh.chordwise, bound: &mesh.bound, ends: &mesh.trailing })
    }

    /// The same of the rings between the first bound vortices and the sheets that leave the leading edges.
    pub fn noses(&self, meshes: &[Mesh]) -> Vec<f64> {
        self.columns(meshes, |mesh| Rings { rows: 1, bound: &mesh.nose, ends: &mesh.heads })
    }

    fn columns(&self, meshes: &[Mesh], of: fn(&Mesh) -> Rings<'_>) -> Vec<f64> {
        let rings: Vec<Rings<'_>> = meshes.iter().map(of).collect();
        let of = |(surface, mesh): (usize, &Mesh)| {
            let place = move |c: &Control| Place::On(surface, c.arc);
            mesh.controls.iter().map(move |c| (c.at, c.normal, place(c))).collect::<Vec<Aimed>>()
        };
        let controls: Vec<Aimed> = meshes.iter().enumerate().flat_map(of).collect();
        let blocks: Vec<&[Aimed]> = controls.chunks(LANES).collect();
        let rows = |block: &[Aimed]| self.block(block, &rings);
        if controls.len() < SHARED {
            return blocks.iter().flat_map(|block| rows(block)).collect();
        }
        parallel::map(&blocks, |_, block| rows(block)).concat()
    }

    /// The rows of up to four control points.
    fn block(&self, controls: &[Aimed], rings: &[Rings<'_>]) -> Vec<f64> {
        let last = controls.len() - 1;
        let lanes = |of: fn(&Aimed) -> Vec3, image: bool| -> [f64x4; 3] {
            let vectors: [Vec3; LANES] = std::array::from_fn(|lane| {
                let v = of(&controls[lane.min(last)]);
                if image { mirrored(v) } else { v }
            });
            std::array::from_fn(|k| f64x4::from(vectors.map(|v| v[k])))
        };
        let images = if self.symmetric { &[false, true][..] } else { &[false] };
        let seen_from: Vec<SeenFrom> = images
            .iter()
            .map(|image| SeenFrom {
                at: lanes(|c| c.0, *image),
                normal: lanes(|c| c.1, *image),
                places: std::array::from_fn(|lane| match controls[lane.min(last)].2 {
                    Place::On(surface, arc) if *image => Place::On(surface, -arc),
                    place => place,
                }),
            })
            .collect();
        let columns: Vec<f64x4> = rings.iter().enumerate().flat_map(|m| self.rings(m, &seen_from)).collect();
        let columns: Vec<[f64; LANES]> = columns.iter().map(|column| column.to_array()).collect();
        (0..controls.len()).flat_map(|lane| columns.iter().map(move |column| column[lane])).collect()
    }

    /// What the unit rings of a surface induce along the normals at four points: front and right less rear and left.
    fn rings(&self, (surface, of): (usize, &Rings<'_>), seen_from: &[SeenFrom]) -> Vec<f64x4> {
        let (m, n) = (of.rows, of.bound.columns - 1);
        let rows = of.bound.rows();
        let mut across = vec![f64x4::ZERO; rows * n];
        let mut along = vec![f64x4::ZERO; (rows - 1) * (n + 1)];
        let mut seen: Vec<Seen> = Vec::with_capacity(n + 1);
        let bound = of.bound;
        for SeenFrom { at, normal, places } in seen_from {
            let sums = [&mut across[..], &mut along[..]];
            match (&self.crossing, self.cored) {
                (Some(crossing), _) => {
                    let [along, across] = crossing.squares(*places, surface, &bound.arcs);
                    unit_washes(bound, at, normal, sums, &mut seen, |segment, a, b| match segment {
                        Segment::Along(at, j) => rounded(a, b, along[j] * f64x4::splat(bound.core_along[at])),
                        Segment::Across(at, j) => {
                            rounded(a, b, across[j] * f64x4::splat(bound.core_across[at]))
                        }
                    });
                }
                (None, true) => {
                    unit_washes(bound, at, normal, sums, &mut seen, |s, a, b| own::<true>(bound, s, a, b));
                }
                (None, false) => {
                    unit_washes(bound, at, normal, sums, &mut seen, |s, a, b| own::<false>(bound, s, a, b));
                }
            }
        }
        // The ends of the last rings are vortices of the wake.
        let mut ends = vec![f64x4::ZERO; n];
        let trailing = of.ends;
        for SeenFrom { at, normal, .. } in seen_from {
            let sums = [&mut ends[..], &mut []];
            unit_washes(trailing, at, normal, sums, &mut seen, |s, a, b| own::<true>(trailing, s, a, b));
        }
        let sides = |row: usize, j: usize| along[row * (n + 1) + j + 1] - along[row * (n + 1) + j];
        let ring = |i: usize, j: usize| {
            if i + 1 < m {
                return across[i * n + j] - across[(i + 1) * n + j] + sides(i, j);
            }
            let behind = (i + 1..rows - 1).fold(f64x4::ZERO, |sum, row| sum + sides(row, j));
            across[i * n + j] - ends[j] + sides(i, j) + behind
        };
        (0..m).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| ring(i, j)).collect()
    }
}
