//! The lattice as it lies: quadrilaterals for figures and for programs that read VTK.

use crate::influence::mirrored;
use crate::lattice::Lattice;
use std::fmt::Write;
use wingbeat::math::Vec3;

/// A panel or a ring of the wake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Its corners in turn, m.
    pub corners: [Vec3; 4],
    /// Circulation of its ring, m2/s, positive where the ring of a wing that lifts is.
    pub circulation: f64,
}

/// Wings and wakes at an instant, mirror images included.
#[derive(Clone, Debug, Default)]
pub struct VortexPicture {
    /// Time, s.
    pub time: f64,
    /// Panels of the wings.
    pub wing: Vec<Quad>,
    /// Rings of the wakes.
    pub wake: Vec<Quad>,
    /// Steps since each ring of the wakes was shed.
    pub age: Vec<usize>,
    /// Vortices of the wakes, along the flow from older to younger end and across it from left to right, with their circulation, m2/s.
    pub filaments: Vec<([Vec3; 2], f64)>,
}

impl VortexPicture {
    /// The lattice at its last instant, `time` s.
    pub fn new(lattice: &Lattice, time: f64) -> Self {
        let mut picture = Self { time, ..Self::default() };
        let mut rings = lattice.rings();
        for mesh in lattice.meshes() {
            let (own, rest) = rings.split_at(mesh.panels());
            rings = rest;
            for (at, circulation) in own.iter().enumerate() {
                let (i, j) = (at / mesh.strips, at % mesh.strips);
                let corners =
                    [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| mesh.corner(i, j));
                picture.wing.push(Quad { corners, circulation: *circulation });
            }
        }
        let ends = lattice.meshes().iter().map(|mesh| &mesh.trailing.across);
        let heads = lattice.meshes().iter().map(|mesh| &mesh.heads.across);
        let sheets = lattice.sheets().iter().zip(heads);
        for (wake, ends) in lattice.wakes().iter().zip(ends).chain(sheets) {
            let (n, points) = (wake.grid.columns, &wake.grid.points);
            for (at, circulation) in wake.rings.iter().enumerate() {
                let k = at / (n - 1) * n + at % (n - 1);
                // As on the wing: the younger edge first, from left to right.
                let corners = [k + n, k + n + 1, k + 1, k].map(|k| points[k]);
                picture.wake.push(Quad { corners, circulation: *circulation });
                // Rows join at the trailing edge: the last is the youngest.
                picture.age.push(wake.rows() - at / (n - 1));
            }
            let along = |(k, circulation): (usize, &f64)| ([points[k], points[k + n]], *circulation);
            picture.filaments.extend(wake.grid.along.iter().enumerate().map(along));
            // The last row holds the ends of the bound rings too.
            let across = |(at, circulation): (usize, &f64)| {
                let (row, j) = (at / (n - 1), at % (n - 1));
                let bound = if row == wake.rows() { ends[j] } else { 0.0 };
                ([points[row * n + j], points[row * n + j + 1]], circulation + bound)
            };
            picture.filaments.extend(wake.grid.across.iter().enumerate().map(across));
        }
        if lattice.scene().symmetric {
            picture.mirror();
        }
        picture
    }

    /// Adds the mirror image, whose rings turn the other way about and whose corners therefore run the other way.
    fn mirror(&mut self) {
        let image = |quad: &Quad| {
            let [a, b, c, d] = quad.corners.map(mirrored);
            Quad { corners: [b, a, d, c], circulation: quad.circulation }
        };
        for quads in [&mut self.wing, &mut self.wake] {
            let images: Vec<Quad> = quads.iter().map(image).collect();
            quads.extend(images);
        }
        self.age.extend_from_within(..);
        let images: Vec<_> = self.filaments.iter().map(|(ends, g)| (ends.map(mirrored), -g)).collect();
        self.filaments.extend(images);
    }

    /// The ring of the wakes with the largest circulation, and the steps since it was shed.
    pub fn strongest(&self) -> Option<(&Quad, usize)> {
        let rings = self.wake.iter().zip(self.age.iter().copied());
        rings.max_by(|(a, _), (b, _)| a.circulation.abs().total_cmp(&b.circulation.abs()))
    }

    /// Where filaments cross the plane of the normal `across` through `origin`, with the circulation about the normal, m2/s.
    pub fn crossings(&self, origin: Vec3, across: Vec3) -> Vec<(Vec3, f64)> {
        let crossing = |(ends, circulation): &([Vec3; 2], f64)| {
            let [a, b] = ends.map(|end| (end - origin).dot(across));
            let meets = (a < 0.0) != (b < 0.0);
            meets.then(|| {
                let place = ends[0] + (ends[1] - ends[0]) * (a / (a - b));
                (place, if b > a { *circulation } else { -circulation })
            })
        };
        self.filaments.iter().filter_map(crossing).collect()
    }

    /// The quadrilaterals as a VTK file (legacy format 3.0, text) with circulation and part (0 wing, 1 wake) of each.
    pub fn vtk(&self) -> String {
        let quads = || self.wing.iter().chain(&self.wake);
        let count = self.wing.len() + self.wake.len();
        let mut text = String::from("# vtk DataFile Version 3.0\n");
        // Writing to a String does not fail.
        let _ = writeln!(text, "wings and wakes at t = {} s\nASCII\nDATASET POLYDATA", self.time);
        let _ = writeln!(text, "POINTS {} double", 4 * count);
        for corner in quads().flat_map(|quad| quad.corners) {
            let _ = writeln!(text, "{} {} {}", corner[0], corner[1], corner[2]);
        }
        let _ = writeln!(text, "POLYGONS {count} {}", 5 * count);
        for k in (0..count).map(|k| 4 * k) {
            let _ = writeln!(text, "4 {} {} {} {}", k, k + 1, k + 2, k + 3);
        }
        let _ = writeln!(text, "CELL_DATA {count}\nSCALARS circulation_m2_s double 1\nLOOKUP_TABLE default");
        quads().for_each(|quad| {
            let _ = writeln!(text, "{}", quad.circulation);
        });
        text += "SCALARS part int 1\nLOOKUP_TABLE default\n";
        text += &"0\n".repeat(self.wing.len());
        text += &"1\n".repeat(self.wake.len());
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filaments_cross_where_they_do() {
        let filaments = vec![
            ([Vec3::new(-1.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 0.0)], 2.0),
            ([Vec3::new(3.0, 0.0, 1.0), Vec3::new(-1.0, 0.0, 1.0)], 5.0),
            ([Vec3::new(1.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)], 7.0),
        ];
        let picture = VortexPicture { filaments, ..VortexPicture::default() };
        let found = picture.crossings(Vec3::ZERO, Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(found, [(Vec3::new(0.0, 1.5, 0.0), 2.0), (Vec3::new(0.0, 0.0, 1.0), -5.0)]);
    }

    #[test]
    fn vtk_has_as_much_as_it_says() {
        let corner = Vec3::new(0.0, 1.0, 2.5);
        let quad = Quad { corners: [corner; 4], circulation: -0.5 };
        let picture = VortexPicture { wing: vec![quad], wake: vec![quad; 2], ..VortexPicture::default() };
        let text = picture.vtk();
        assert!(text.contains("POINTS 12 double\n0 1 2.5\n") && text.contains("POLYGONS 3 15\n4 0 1 2 3\n"));
        assert_eq!(text.matches("\n-0.5").count(), 3);
        assert!(text.ends_with("0\n1\n1\n"));
    }
}
