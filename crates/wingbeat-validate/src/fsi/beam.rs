//! Geometrically exact beams against closed forms, published numbers and equations written apart.

mod apart;
mod moving;
mod segments;

use crate::fsi::worst;
use crate::{Case, ComparisonRow, Error};
use apart::TaperedBeam;
use std::f64::consts::PI;
use wingbeat::math::{Mat3, Vec3};
use wingbeat::structure::{
    Beam, CrossSection, Grid, Load, Place, SectionStation, Setting, StaticsStatus, Strain, Swung,
    eigenvalues, frequencies, hold, linear,
};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.beam.uniform", quick: true, run: uniform },
    Case { id: "fsi.beam.tapered", quick: true, run: tapered },
    Case { id: "fsi.beam.offset", quick: true, run: offset },
    Case { id: "fsi.beam.elastica", quick: true, run: elastica },
    Case { id: "fsi.beam.follower", quick: true, run: follower },
    Case { id: "fsi.beam.rotating", quick: true, run: rotating },
    Case { id: "fsi.beam.order", quick: true, run: order },
    Case { id: "fsi.beam.flapping", quick: true, run: moving::flapping },
    Case { id: "fsi.beam.energy", quick: true, run: moving::energy },
    Case { id: "fsi.beam.momentum", quick: true, run: moving::momentum },
    Case { id: "fsi.beam.derivatives", quick: true, run: moving::derivatives },
    Case { id: "fsi.beam.segments", quick: true, run: segments::rows },
    Case { id: "fsi.beam.step_order", quick: true, run: moving::step_order },
];

/// Inertia of sections without any, kg m: small beside the mass times the length squared.
const SLENDER: f64 = 1e-9;

/// A section with bending about y (out of the plane of rotation) and torsion as in [`TaperedBeam`], bending about z `wide` times
/// stiffer.
fn section([bend, twist, mass, inertia]: [f64; 4], offset: f64, wide: f64) -> CrossSection {
    // About the centre of mass: the library moves it to the axis. A plate's, as what turns about x must lie somewhere.
    let own = inertia - mass * offset * offset;
    CrossSection::isotropic(1e9, [twist, bend, wide * bend]).with_mass(
        mass,
        Vec3::new(0.0, offset, 0.0),
        Mat3::diagonal(Vec3::new(own, SLENDER, own)),
    )
}

fn beam(of: &TaperedBeam, elements: usize, order: usize) -> Result<Beam, Error> {
    let stations = [(0.0, of.root), (1.0, of.tip)]
        .map(|(arc_m, n)| SectionStation { arc_m, section: section(n, of.offset, 1e6) });
    let grid = Grid { elements, order, strains: Strain::INEXTENSIBLE, arcs: Vec::new() };
    Ok(Beam::new(&stations, &[], &grid)?)
}

/// The lowest `count` frequencies at rest, rad/s.
fn lowest(beam: &Beam, setting: &Setting, count: usize) -> Vec<f64> {
    let q = vec![0.0; beam.unknowns(setting.free)];
    frequencies(&linear(beam, setting, &q)).iter().take(count).map(|mode| mode.0).collect()
}

const UNIFORM: TaperedBeam =
    TaperedBeam { root: [1.0, 1e4, 1.0, 1e-2], tip: [1.0, 1e4, 1.0, 1e-2], offset: 0.0, turning: 0.0 };

fn uniform() -> Result<Vec<ComparisonRow>, Error> {
    let beam = beam(&UNIFORM, 1, 8)?;
    let found = lowest(&beam, &Setting::default(), 3);
    let exact = [1.875_104_068_711_961, 4.694_091_132_974_175, 7.854_757_438_237_613].map(|x: f64| x * x);
    let twist = TaperedBeam { root: [1e6, 1.0, 1.0, 1e-2], tip: [1e6, 1.0, 1.0, 1e-2], ..UNIFORM };
    let torsion = lowest(&self::beam(&twist, 1, 8)?, &Setting::default(), 3);
    let exact_torsion = (0..3).map(|k| (2 * k + 1) as f64 * PI / 2.0 * 10.0);
    let source = "closed form: cos x cosh x = -1; sqrt(GJ/I) (2k - 1) pi/(2 L)";
    let row = |id: &str, what: &str, value| {
        ComparisonRow::judged(
            id,
            source,
            &format!("max relative error of 3 frequencies of {what}, 1 element"),
            value,
            1e-4,
            "",
        )
    };
    Ok(vec![
        row("fsi.beam.uniform", "bending", worst(found.into_iter().zip(exact))),
        row("fsi.beam.uniform.torsion", "torsion", worst(torsion.into_iter().zip(exact_torsion))),
    ])
}

fn tapered() -> Result<Vec<ComparisonRow>, Error> {
    let of = TaperedBeam { tip: [0.2, 1e4, 0.4, 1e-2], ..UNIFORM };
    let found = lowest(&beam(&of, 1, 9)?, &Setting::default(), 4);
    let value = worst(found.into_iter().zip(of.frequencies(4, 2.0)));
    let source = "shooting of (EI y'')'' = w^2 m y, written apart";
    let metric = "max relative error of 4 frequencies, EI to 0.2 and mass to 0.4 at the tip";
    Ok(vec![ComparisonRow::judged("fsi.beam.tapered", source, metric, value, 1e-4, "")])
}

fn offset() -> Result<Vec<ComparisonRow>, Error> {
    let numbers = [1.0, 0.2, 1.0, 0.012];
    let of = TaperedBeam { root: numbers, tip: numbers, offset: 0.06, turning: 0.0 };
    let found = lowest(&beam(&of, 1, 9)?, &Setting::default(), 5);
    let value = worst(found.into_iter().zip(of.frequencies(5, 1.0)));
    let source = "shooting of coupled bending and torsion, written apart";
    let metric = "max relative error of 5 frequencies, centre of mass 6 % of the length off the axis";
    Ok(vec![ComparisonRow::judged("fsi.beam.offset", source, metric, value, 1e-4, "")])
}

/// Tip of the uniform beam under a tip load along z.
fn bent(load: Load, steps: usize, elements: usize, order: usize) -> Result<Vec3, Error> {
    let beam = beam(&UNIFORM, elements, order)?;
    let load = Load { node: beam.tip(), ..load };
    let held = hold(&beam, &Setting { loads: vec![load], ..Setting::default() }, steps);
    if held.status != StaticsStatus::Converged {
        return Err(Error::NoAnswer(format!("a static shape: {:?} {:e}", held.status, held.residual)));
    }
    Ok(beam.places(&Place::IDENTITY, &held.q)[beam.tip()].p)
}

fn elastica() -> Result<Vec<ComparisonRow>, Error> {
    // Bisshopp & Drucker 1945: P L^2/(E I), deflection and shortening over length, as tabulated to five digits.
    const PRINTED: [[f64; 3]; 3] =
        [[1.0, 0.30172, 0.05643], [2.0, 0.49346, 0.16064], [10.0, 0.81061, 0.55500]];
    let (mut printed, mut exact) = (0.0_f64, 0.0_f64);
    for [load, down, short] in PRINTED {
        let tip = bent(Load::dead(0, Vec3::new(0.0, 0.0, load)), 4, 2, 8)?;
        let found = [tip[2], 1.0 - tip[0]];
        let far = |known: [f64; 2]| (found[0] - known[0]).abs().max((found[1] - known[1]).abs());
        (printed, exact) = (printed.max(far([down, short])), exact.max(far(apart::elastica(load)?)));
    }
    let metric = "max error of deflection and shortening over length, P L^2/EI = 1, 2, 10";
    Ok(vec![
        ComparisonRow::judged(
            "fsi.beam.elastica",
            "Bisshopp & Drucker 1945, elliptic integrals",
            metric,
            printed,
            1e-4,
            "",
        ),
        ComparisonRow::judged(
            "fsi.beam.elastica.shooting",
            "t'' = -a cos t, written apart",
            metric,
            exact,
            1e-4,
            "",
        ),
    ])
}

fn follower() -> Result<Vec<ComparisonRow>, Error> {
    let mut value = 0.0_f64;
    for load in [1.0, 4.0, 12.0, 25.0] {
        let tip = bent(Load::following(0, Vec3::new(0.0, 0.0, load)), 20, 2, 8)?;
        let [x, z] = apart::followed(load)?;
        value = value.max((tip[0] - x).abs()).max((tip[2].abs() - z).abs());
    }
    let metric = "max error of the tip over length, P L^2/EI = 1, 4, 12, 25";
    let source = "initial-value problem from the tip, written apart";
    let beck = ComparisonRow::judged(
        "fsi.beam.follower.beck",
        "Beck 1952: P L^2/EI = 20.05 (uniform column)",
        "relative error of the tangential load at which oscillations of a column grow",
        (beck()? / 20.0509 - 1.0).abs(),
        1e-3,
        "",
    );
    Ok(vec![ComparisonRow::judged("fsi.beam.follower", source, metric, value, 1e-3, ""), beck])
}

/// Load along the tip's tangent at which two frequencies of the column in its plane merge, E I and L being 1.
fn beck() -> Result<f64, Error> {
    let beam = beam(&UNIFORM, 2, 6)?;
    let q = vec![0.0; beam.coordinates()];
    let growth = |load: f64| -> Result<f64, Error> {
        let loads = vec![Load::following(beam.tip(), Vec3::new(-load, 0.0, 0.0))];
        let found = eigenvalues(&linear(&beam, &Setting { loads, ..Setting::default() }, &q));
        Ok(found.iter().map(|s| s.re).fold(f64::NEG_INFINITY, f64::max) - 1e-3)
    };
    crate::fsi::section::crossing(growth, 15.0, 25.0)
}

/// Frequencies out of the plane of rotation of the uniform beam that turns about its root, rad/s.
fn turned(of: &TaperedBeam, order: usize, count: usize) -> Result<Vec<f64>, Error> {
    let beam = beam(of, 2, order)?;
    let rate = Vec3::new(0.0, 0.0, of.turning);
    let setting = Setting { root: Swung::turning(&Place::IDENTITY, rate, 0.0), ..Setting::default() };
    let mut found: Vec<f64> = eigenvalues(&linear(&beam, &setting, &vec![0.0; beam.coordinates()]))
        .iter()
        .map(|s| s.im)
        .filter(|im| *im > 1e-6)
        .collect();
    wingbeat::math::order::ascend(&mut found);
    found.truncate(count);
    Ok(found)
}

fn rotating() -> Result<Vec<ComparisonRow>, Error> {
    // Hodges & Rutkowski 1981 (and Wright et al. 1982): first three flapping frequencies over sqrt(EI/(m L^4)) at 0, 4, 8, 12.
    const PRINTED: [(f64, [f64; 3]); 4] = [
        (0.0, [3.5160, 22.0345, 61.6972]),
        (4.0, [5.5850, 24.2733, 63.9668]),
        (8.0, [9.2568, 29.9954, 70.2930]),
        (12.0, [13.1702, 37.6031, 79.6145]),
    ];
    let (mut printed, mut exact) = (0.0_f64, 0.0_f64);
    for (turning, known) in PRINTED {
        let of = TaperedBeam { turning, ..UNIFORM };
        let found = turned(&of, 6, 3)?;
        printed = printed.max(worst(found.iter().copied().zip(known)));
        exact = exact.max(worst(found.into_iter().zip(of.frequencies(3, 1.0))));
    }
    let metric = "max relative error of 3 flapping frequencies, rotation 0, 4, 8 and 12 sqrt(EI/m L^4)";
    Ok(vec![
        ComparisonRow::judged(
            "fsi.beam.rotating",
            "Hodges & Rutkowski 1981, table for no hub",
            metric,
            printed,
            1e-3,
            "",
        ),
        ComparisonRow::judged(
            "fsi.beam.rotating.shooting",
            "(EI y'')'' - (T y')' = w^2 m y, written apart",
            metric,
            exact,
            1e-3,
            "",
        ),
    ])
}

/// Order of convergence with the number of elements of constant and of linear strain.
fn order() -> Result<Vec<ComparisonRow>, Error> {
    let exact = apart::elastica(5.0)?[0];
    let mut rows = Vec::new();
    for (order, expected, id) in [(1, 2.0, "fsi.beam.order"), (2, 4.0, "fsi.beam.order.linear")] {
        let error = |elements| -> Result<f64, Error> {
            Ok((bent(Load::dead(0, Vec3::new(0.0, 0.0, 5.0)), 4, elements, order)?[2] - exact).abs())
        };
        let [coarse, fine] = if order == 1 { [16, 32] } else { [8, 16] };
        let observed = (error(coarse)? / error(fine)?).log2();
        rows.push(ComparisonRow::order(
            id,
            "elastica, P L^2/EI = 5, elements doubled",
            observed,
            expected,
            0.3,
        ));
    }
    Ok(rows)
}
