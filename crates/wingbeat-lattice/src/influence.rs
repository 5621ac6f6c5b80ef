//! What rings and wakes induce, mirror images included.

use crate::kernel::{Grid, LANES, Points, Seen, add_velocities, unit_washes};
use crate::mesh::Mesh;
use wide::f64x4;
use wingbeat::math::Vec3;
use wingbeat::parallel;

/// Grids that induce velocities.
pub struct Sources<'a> {
    /// Bound rings.
    pub bound: Vec<&'a Grid>,
    /// Vortices with cores: wakes and the ends of the last rings.
    pub cored: Vec<&'a Grid>,
}

/// How velocities are summed.
#[derive(Clone, Debug)]
pub struct Influence {
    symmetric: bool,
    /// Whether bound vortices have cores.
    cored: bool,
}

/// Panels from which the coefficients are shared among the cores. *Choice.*
const SHARED: usize = 200;

/// The mirror image at the plane y = 0.
pub fn mirrored(v: Vec3) -> Vec3 {
    let [x, y, z] = v.0;
    Vec3([x, -y, z])
}

impl Influence {
    /// With the mirror image of all sources where `symmetric`; with cores on bound vortices where `cored`.
    pub fn new(symmetric: bool, cored: bool) -> Self {
        Self { symmetric, cored }
    }

    /// Induced velocities at `points`, m/s. What the mirror image of the sources induces at p is the mirror image of what they
    /// induce at the mirror image of p.
    pub fn velocities(&self, points: &[Vec3], sources: &Sources<'_>) -> Vec<Vec3> {
        let count = points.len();
        let images = if self.symmetric { points } else { &[] };
        let all: Vec<Vec3> = points.iter().copied().chain(images.iter().map(|p| mirrored(*p))).collect();
        let mut lanes = Points::default();
        lanes.set(all.iter().copied());
        let mut velocities = vec![Vec3::ZERO; all.len()];
        for grid in &sources.bound {
            match self.cored {
                true => add_velocities::<true>(grid, &lanes, &mut velocities),
                false => add_velocities::<false>(grid, &lanes, &mut velocities),
            }
        }
        for grid in &sources.cored {
            add_velocities::<true>(grid, &lanes, &mut velocities);
        }
        let image = velocities.split_off(count);
        velocities.iter_mut().zip(image).for_each(|(v, image)| *v += mirrored(image));
        velocities
    }

    /// What rings of unit circulation induce along the normals at the control points, row by row, 1/m.
    pub fn coefficients(&self, meshes: &[Mesh]) -> Vec<f64> {
        let controls: Vec<(Vec3, Vec3)> =
            meshes.iter().flat_map(|mesh| mesh.controls.iter().map(|c| (c.at, c.normal))).collect();
        let blocks: Vec<&[(Vec3, Vec3)]> = controls.chunks(LANES).collect();
        let rows = |block: &[(Vec3, Vec3)]| self.block(block, meshes);
        if controls.len() < SHARED {
            return blocks.iter().flat_map(|block| rows(block)).collect();
        }
        parallel::map(&blocks, |_, block| rows(block)).concat()
    }

    /// The rows of up to four control points.
    fn block(&self, controls: &[(Vec3, Vec3)], meshes: &[Mesh]) -> Vec<f64> {
        let lanes = |of: fn(&(Vec3, Vec3)) -> Vec3, image: bool| -> [f64x4; 3] {
            let vectors: [Vec3; LANES] = std::array::from_fn(|lane| {
                let v = of(&controls[lane.min(controls.len() - 1)]);
                if image { mirrored(v) } else { v }
            });
            std::array::from_fn(|k| f64x4::from(vectors.map(|v| v[k])))
        };
        let images = if self.symmetric { &[false, true][..] } else { &[false] };
        let seen_from: Vec<_> = images.iter().map(|i| (lanes(|c| c.0, *i), lanes(|c| c.1, *i))).collect();
        let columns: Vec<f64x4> = meshes.iter().flat_map(|mesh| self.rings(mesh, &seen_from)).collect();
        let columns: Vec<[f64; LANES]> = columns.iter().map(|column| column.to_array()).collect();
        (0..controls.len()).flat_map(|lane| columns.iter().map(move |column| column[lane])).collect()
    }

    /// What the unit rings of a surface induce along the normals at four points: front and right less rear and left.
    fn rings(&self, mesh: &Mesh, seen_from: &[([f64x4; 3], [f64x4; 3])]) -> Vec<f64x4> {
        let (m, n) = (mesh.chordwise, mesh.strips);
        let rows = mesh.bound.rows();
        let mut across = vec![f64x4::ZERO; rows * n];
        let mut along = vec![f64x4::ZERO; (rows - 1) * (n + 1)];
        let mut seen: Vec<Seen> = Vec::with_capacity(n + 1);
        for (p, normal) in seen_from {
            match self.cored {
                true => unit_washes::<true>(&mesh.bound, p, normal, &mut across, &mut along, &mut seen),
                false => unit_washes::<false>(&mesh.bound, p, normal, &mut across, &mut along, &mut seen),
            }
        }
        // The ends of the last rings are vortices of the wake.
        let mut ends = vec![f64x4::ZERO; n];
        for (p, normal) in seen_from {
            unit_washes::<true>(&mesh.trailing, p, normal, &mut ends, &mut [], &mut seen);
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
