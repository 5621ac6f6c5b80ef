//! Frames of a run as polygons for VTK, ParaView and pyvista.

use std::fmt::Write;

use crate::motion::{RunMotion, at};

/// Frame `i` as legacy VTK: wings as quadrilaterals with their side, bent and cambered as they are, strips as points with force (N, in W) and circulation (m2/s).
pub fn vtk(motion: &RunMotion, i: usize) -> String {
    let (mut points, mut quads, mut forces) = (Vec::new(), Vec::new(), Vec::new());
    for surface in &motion.surfaces {
        let first = points.len();
        let along = (0..surface.ribs.len()).flat_map(|k| surface.along(k, i));
        points.extend(along.map(|point| motion.in_world(i, point)));
        let each = if surface.raised.is_empty() { 2 } else { 5 };
        for (k, side) in surface.side.iter().enumerate().filter(|(k, _)| surface.covered[*k]) {
            let at = first + each * k;
            let strip = at..at + each - 1;
            quads.extend(strip.map(|at| ([at, at + 1, at + each + 1, at + each], *side)));
        }
    }
    let ribs = points.len();
    for strip in motion.surfaces.iter().flat_map(|surface| &surface.strips) {
        points.push(motion.in_world(i, at(&strip.quarter_chord, i)));
        forces.push((motion.turned(i, at(&strip.force, i)), strip.circulation[i]));
    }
    let mut text = String::from("# vtk DataFile Version 3.0\n");
    // Writing to a String does not fail.
    let _ = writeln!(text, "t = {} s\nASCII\nDATASET POLYDATA\nPOINTS {} double", motion.t[i], points.len());
    points.iter().for_each(|p| row(&mut text, p.0));
    if !forces.is_empty() {
        let _ = writeln!(text, "VERTICES {} {}", forces.len(), 2 * forces.len());
        (ribs..points.len()).for_each(|at| {
            let _ = writeln!(text, "1 {at}");
        });
    }
    let _ = writeln!(text, "POLYGONS {} {}", quads.len(), 5 * quads.len());
    for ([a, b, c, d], _) in &quads {
        let _ = writeln!(text, "4 {a} {b} {c} {d}");
    }
    let _ =
        writeln!(text, "CELL_DATA {}\nSCALARS side int 1\nLOOKUP_TABLE default", forces.len() + quads.len());
    text += &"-1\n".repeat(forces.len());
    quads.iter().for_each(|(_, side)| {
        let _ = writeln!(text, "{side}");
    });
    let _ = writeln!(text, "POINT_DATA {}\nVECTORS force_N double", points.len());
    text += &"0 0 0\n".repeat(ribs);
    forces.iter().for_each(|(force, _)| row(&mut text, force.0));
    text += "SCALARS circulation_m2_s double 1\nLOOKUP_TABLE default\n";
    text += &"0\n".repeat(ribs);
    forces.iter().for_each(|(_, circulation)| {
        let _ = writeln!(text, "{circulation}");
    });
    text
}

fn row(text: &mut String, [x, y, z]: [f64; 3]) {
    let _ = writeln!(text, "{x} {y} {z}");
}

/// The list of the files with their times (s) that ParaView reads.
pub fn series(files: &[(String, f64)]) -> String {
    let file = |(name, time): &(String, f64)| format!("    {{ \"name\": \"{name}\", \"time\": {time} }}");
    let files: Vec<String> = files.iter().map(file).collect();
    format!("{{\n  \"file-series-version\": \"1.0\",\n  \"files\": [\n{}\n  ]\n}}\n", files.join(",\n"))
}
