//! Spars of links: chains of rigid pieces on springs beside the beam for which they stand.

use crate::{ComparisonRow, Error};
use nalgebra::DMatrix;
use wingbeat::math::Quat;
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;

/// Lowest frequencies of a uniform cantilever in bending (over sqrt(EI/(m L^4))) and torsion (over sqrt(GJ/(I L^2))).
const EXACT: [f64; 2] = [3.516_015_268_5, std::f64::consts::FRAC_PI_2];

/// Relative errors of both frequencies with `segments` segments on a body that nothing moves.
fn errors(segments: usize) -> Result<[f64; 2], Error> {
    // EI/(m L^4) = 100 and GJ/(I L^2) = 1e6 per s2, so that both lie apart; the inertia is small beside m L^2.
    let text = format!(
        r#"
name = "cantilever"
body = {{ mass_kg = 1e2, inertia_kg_m2 = [1e5, 1e5, 1e5] }}
[[links]]
name = "wing"
spar = {{ length_m = 0.1, segments = {segments}, bending_n_m2 = 1e-5, torsion_n_m2 = 1e-5, mass_kg_m = 1e-3, inertia_kg_m = 1e-9 }}
"#
    );
    let spec = Document::text("cantilever", &text).and_then(|document| document.robot());
    let spec = spec.map_err(|error| Error::NoAnswer(error.to_string()))?;
    let robot =
        Robot::new(&spec, Vec::new(), Air { density: 1.2, wind: Wind::steady(Default::default()) }, 0.0)?;
    let (n, held) = (robot.states().len(), robot.layout().joints);
    let mut x = vec![0.0; n];
    Quat::IDENTITY.store_wxyz(&mut x[robot.layout().attitude..]);
    let mut exact = Linearisation::new(n, 0);
    exact.evaluate(&robot, 0.0, &x, &[])?;
    let free = n - held;
    let a = DMatrix::from_fn(free, free, |i, j| exact.a[(held + i) * n + held + j]);
    let found: Vec<f64> = a.complex_eigenvalues().iter().map(|s| s.im).filter(|im| *im > 0.0).collect();
    let nearest = |omega: f64| {
        let off = |x: &f64| (x / omega - 1.0).abs();
        found.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    Ok([nearest(EXACT[0] * 10.0), nearest(EXACT[1] * 1e3)])
}

pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let source = "closed form of the uniform cantilever";
    let mut rows = Vec::new();
    let mut bending = Vec::new();
    for segments in [1, 2, 3, 4] {
        let [bend, twist] = errors(segments)?;
        bending.push(bend);
        for (what, id, value) in [("bending", "", bend), ("torsion", ".torsion", twist)] {
            rows.push(ComparisonRow::shown(
                &format!("fsi.beam.segments.{segments}{id}"),
                source,
                &format!("relative error of the lowest frequency of {what}, {segments} segments of a link"),
                value,
                "",
            ));
        }
    }
    let observed = (bending[1] / bending[3]).log2();
    rows.push(ComparisonRow::order("fsi.beam.segments", "bending, 2 and 4 segments", observed, 2.0, 0.3));
    Ok(rows)
}
