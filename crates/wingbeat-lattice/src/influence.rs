//! What rings and wakes induce, mirror images included.

use crate::kernel::{
    Crossing, FieldPoints, LANES, PointLocation, SeenVertex, Segment, VortexGrid, add_rounded,
    add_velocities, own, rounded, unit_washes,
};
use crate::mesh::{Control, Mesh};
use crate::motion::Scene;
use crate::tree::PatchTree;
use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// Grids that induce velocities.
pub struct InducingGrids<'a> {
    /// Bound rings, with the number of their surface.
    pub bound: Vec<(usize, &'a VortexGrid)>,
    /// Vortices with cores: wakes and the ends of the last rings.
    pub cored: Vec<&'a VortexGrid>,
}

/// Planes of symmetry of the flow: y = 0, and a ground or ceiling.
#[derive(Clone, Copy, Debug)]
pub struct Mirrors {
    symmetric: bool,
    /// Its height, m.
    ground: Option<f64>,
}

/// A mirror image: at y = 0, at the ground of this height, or at both.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    aside: bool,
    ground: Option<f64>,
}

impl Mirrors {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        Self { symmetric: scene.symmetric, ground: scene.ground }
    }

    /// The images beside what is there.
    ///
    /// Equation: lattice.ground
    /// `images of all vortices at the plane: v(p) + M v(M p)`
    /// Source: method of images; Katz & Plotkin 2001, section 12.3.
    /// Test: `a_lattice_over_a_ground_is_the_upper_one_of_a_mirrored_pair`.
    pub fn images(self) -> impl Iterator<Item = Image> + Clone {
        let aside = Image { aside: true, ground: None };
        let below = |aside| self.ground.map(|height| Image { aside, ground: Some(height) });
        let symmetric = self.symmetric;
        symmetric
            .then_some(aside)
            .into_iter()
            .chain(below(false))
            .chain(below(true).filter(move |_| symmetric))
    }
}

impl Image {
    /// Whether it turns the sense of a circulation: after both mirrors it is as before.
    pub fn turns(self) -> bool {
        self.aside != self.ground.is_some()
    }
    /// Of a point, m.
    pub fn point(self, p: Vec3) -> Vec3 {
        let Vec3([x, y, z]) = self.direction(p);
        Vec3([x, y, z + 2.0 * self.ground.unwrap_or(0.0)])
    }
    /// Of a direction, in the unit of the vector.
    pub fn direction(self, v: Vec3) -> Vec3 {
        let v = if self.aside { mirrored(v) } else { v };
        let [x, y, z] = v.0;
        Vec3([x, y, if self.ground.is_some() { -z } else { z }])
    }
    /// Of a place: the image at a ground is another wing, with which none crosses.
    fn place(self, place: PointLocation) -> PointLocation {
        match place {
            PointLocation::On(_, arc) if self.ground.is_some() => PointLocation::On(usize::MAX, arc),
            PointLocation::On(surface, arc) => PointLocation::On(surface, -arc),
            PointLocation::Wake => PointLocation::Wake,
        }
    }
}

/// How velocities are summed.
#[derive(Clone, Debug)]
pub struct Influence {
    mirrors: Mirrors,
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
type Aimed = (Vec3, Vec3, PointLocation);

/// Rows of rings on a surface.
struct Rings<'a> {
    /// How many; the last reach to the ends.
    rows: usize,
    bound: &'a VortexGrid,
    /// The ends of the last rings.
    ends: &'a VortexGrid,
}

/// Four control points, or their mirror images.
struct SeenFrom {
    at: [f64x4; 3],
    normal: [f64x4; 3],
    places: [PointLocation; LANES],
}

/// The mirror image at the plane y = 0, in the unit of the vector.
pub fn mirrored(v: Vec3) -> Vec3 {
    let [x, y, z] = v.0;
    Vec3([x, -y, z])
}

impl Influence {
    /// With the mirror images of all sources at `mirrors`; with cores on bound vortices where `cored`, or where parts of a wing
    /// cross as `crossing` says; wakes of `fast_from` segments and more by multipoles.
    pub fn new(mirrors: Mirrors, cored: bool, crossing: Option<Crossing>, fast_from: usize) -> Self {
        Self { mirrors, cored, crossing, fast_from }
    }

    /// Induced velocities at `points`, which lie at `places`, m/s. What the mirror image of the sources induces at p is the mirror
    /// image of what they induce at the mirror image of p.
    pub fn velocities(
        &self,
        points: &[Vec3],
        places: &[PointLocation],
        sources: &InducingGrids<'_>,
    ) -> Vec<Vec3> {
        self.velocities_by(points, points, places, sources)
    }

    /// The same, by sums that are chosen for the points `by`, near these in the same order: trials of one instant have one choice.
    pub fn velocities_by(
        &self,
        points: &[Vec3],
        by: &[Vec3],
        places: &[PointLocation],
        sources: &InducingGrids<'_>,
    ) -> Vec<Vec3> {
        let count = points.len();
        let images = self.mirrors.images();
        let with_images = |points: &[Vec3]| -> Vec<Vec3> {
            let image = images.clone().flat_map(|image| points.iter().map(move |p| image.point(*p)));
            points.iter().copied().chain(image).collect()
        };
        let (all, by) = (with_images(points), with_images(by));
        let mut lanes = FieldPoints::default();
        lanes.set(all.iter().copied());
        let mut velocities = vec![Vec3::ZERO; all.len()];
        match &self.crossing {
            Some(crossing) => {
                let image = images.clone().flat_map(|image| places.iter().map(move |p| image.place(*p)));
                let places: Vec<PointLocation> = places.iter().copied().chain(image).collect();
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
                true => PatchTree::new(grid).add_velocities(&all, &by, &mut velocities),
                false => add_velocities::<true>(grid, &lanes, &mut velocities),
            }
        }
        let seen = velocities.split_off(count);
        for (image, seen) in images.zip(seen.chunks_exact(count.max(1))) {
            velocities.iter_mut().zip(seen).for_each(|(v, seen)| *v += image.direction(*seen));
        }
        velocities
    }

    /// The same with bound vortices that have the core of the wake, `core` m, where the wake feels them: sheets that leave the leading edge
    /// pass close over the wing.
    pub fn softened(&self, core: f64) -> Self {
        let wake_only = Crossing { share: 0.0, near: 0.0, wake: core };
        Self { crossing: self.crossing.or(Some(wake_only)), ..self.clone() }
    }

    /// Whether the mirror image of all sources at y = 0 is there.
    pub fn symmetric(&self) -> bool {
        self.mirrors.symmetric
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
            let place = move |c: &Control| PointLocation::On(surface, c.arc);
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
        let lanes = |of: &dyn Fn(&Aimed) -> Vec3| -> [f64x4; 3] {
            let vectors: [Vec3; LANES] = std::array::from_fn(|lane| of(&controls[lane.min(last)]));
            std::array::from_fn(|k| f64x4::from(vectors.map(|v| v[k])))
        };
        let places: [PointLocation; LANES] = std::array::from_fn(|lane| controls[lane.min(last)].2);
        let own = SeenFrom { at: lanes(&|c| c.0), normal: lanes(&|c| c.1), places };
        let image = |image: Image| SeenFrom {
            at: lanes(&|c| image.point(c.0)),
            normal: lanes(&|c| image.direction(c.1)),
            places: places.map(|place| image.place(place)),
        };
        let seen_from: Vec<SeenFrom> = std::iter::once(own).chain(self.mirrors.images().map(image)).collect();
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
        let mut seen: Vec<SeenVertex> = Vec::with_capacity(n + 1);
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
