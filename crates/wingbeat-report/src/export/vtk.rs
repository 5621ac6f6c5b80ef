//! Frames of a run as polygons for VTK, ParaView and pyvista.

use std::fmt::Write;

use crate::motion::{RunMotion, at};

/// Frame `i` as legacy VTK: wings as quadrilaterals with their side, bent and cambered as they are, strips as points at 1/4 chord with force (N, in W), moment
/// about that point (N m, in W) and circulation (m2/s).
pub fn vtk(motion: &RunMotion, i: usize) -> String {
    let (mut points, mut quads) = (Vec::new(), Vec::new());
    let (mut forces, mut moments) = (Vec::new(), Vec::new());
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
        if !strip.moment[0].is_empty() {
            moments.push(motion.turned(i, at(&strip.moment, i)));
        }
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
    if !moments.is_empty() {
        text += "VECTORS moment_N_m double\n";
        text += &"0 0 0\n".repeat(ribs);
        moments.iter().for_each(|moment| row(&mut text, moment.0));
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;
    use std::path::Path;
    use wingbeat::math::Vec3;
    use wingbeat::scenario::{Scenario, TetherCase};

    /// Force of frame `i` as its file has it, its moment about the origin of the body, and the largest moment of a strip about its own point.
    fn summed(motion: &RunMotion, i: usize) -> ([Vec3; 2], f64) {
        let text = vtk(motion, i);
        let block = |head: &str| -> Vec<Vec3> {
            let lines = text.lines().skip_while(|line| !line.starts_with(head)).skip(1);
            let numbers = |line: &str| line.split(' ').map(str::parse).collect::<Result<Vec<f64>, _>>().ok();
            lines.map_while(|line| Some(Vec3(numbers(line)?.try_into().ok()?))).collect()
        };
        let [points, forces, moments] = ["POINTS", "VECTORS force_N", "VECTORS moment_N_m"].map(block);
        assert!(points.len() == forces.len() && points.len() == moments.len());
        let origin = at(&motion.position, i);
        let mut sum = [Vec3::ZERO; 2];
        for ((point, force), moment) in points.iter().zip(&forces).zip(&moments) {
            sum = [sum[0] + *force, sum[1] + (*point - origin).cross(*force) + *moment];
        }
        (sum, moments.iter().map(|moment| moment.norm()).fold(0.0, f64::max))
    }

    /// Of a half wing its own half alone counts, of the paper's strips the middle one with half of its load.
    #[test]
    fn strips_of_a_tethered_wing_sum_to_its_loads() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/step.toml");
        let none = |_: &Path| Err(String::new());
        let steps = ["time.cycles=1", "time.steps_per_cycle=20", "body.heave_m={fourier={cos=[0.1]}}"]
            .map(String::from);
        let sides = ["both", "left", "right"].map(|side| format!("wing.side=\"{side}\""));
        for (side, preset) in sides.iter().flat_map(|side| ["full", "paper"].map(|preset| (side, preset))) {
            let set = [&steps[..], &[side.clone(), format!("aero.preset=\"{preset}\"")]].concat();
            let case = TetherCase::load(&path, &set, &none).unwrap();
            let run = case.tether.run(|_| ControlFlow::Continue(()));
            let rows: Vec<usize> = (0..run.loads.rows()).collect();
            let motion = crate::held::wing(&case, &run.loads, Some(&run.strips), &rows).unwrap();
            let row = |name: &str, i: usize| {
                motion.turned(
                    i,
                    Vec3(["x", "y", "z"].map(|a| run.loads.values(&format!("{name}_{a}")).unwrap()[i])),
                )
            };
            for i in [3, 11] {
                let ([force, moment], couples) = summed(&motion, i);
                let whole = [row("force", i), row("moment", i)];
                assert!(
                    (force - whole[0]).norm() < 1e-9 * whole[0].norm(),
                    "{side} {preset}: {force:?} {whole:?}"
                );
                assert!(
                    (moment - whole[1]).norm() < 1e-9 * whole[0].norm(),
                    "{side} {preset}: {moment:?} {whole:?}"
                );
                assert!(couples > 1e-6 && whole[0].norm() > 1e-3, "{couples} {whole:?}");
            }
        }
    }

    /// Forces and moments of the strips about their points are, about the origin of the body, those of the record by source.
    #[test]
    fn moments_of_the_strips_sum_to_those_of_the_record() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/four_wings.toml");
        let scenario = Scenario::load(&path, &["flight.duration_s=0.1".into()]).unwrap();
        let record = scenario.fly(|_| ControlFlow::Continue(())).unwrap().record;
        let rows = crate::flight::shown(&record);
        let motion = crate::flight::motion(&scenario, &record, &rows).unwrap();
        let i = rows.len() / 2;
        let (sum, couples) = summed(&motion, i);
        let of = |source: &str| {
            motion.turned(
                i,
                Vec3(
                    ["x", "y", "z"]
                        .map(|axis| record.values(&format!("moment_{source}_{axis}")).unwrap()[rows[i]]),
                ),
            )
        };
        let sources = ["circulatory", "induced_drag", "added_mass", "profile_drag"].map(of);
        let whole = sources.into_iter().fold(Vec3::ZERO, |sum, moment| sum + moment);
        assert!((sum[1] - whole).norm() < 1e-9 * whole.norm() && whole.norm() > 1e-4, "{sum:?} {whole:?}");
        assert!(couples > 1e-6, "the largest couple is {couples} N m");
    }
}
