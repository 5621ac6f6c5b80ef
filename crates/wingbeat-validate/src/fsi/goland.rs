//! Goland's wing: a uniform cantilever whose bending and torsion flutter.

mod lattice;
mod tether;

use super::C;
use super::theodorsen::loads;
use crate::{Case, ComparisonRow, Error};
use nalgebra::DMatrix;
use std::f64::consts::PI;
use wingbeat::math::{Mat3, Vec3};
use wingbeat::structure::{
    Beam, CrossSection, Grid, SectionStation, Setting, Strain, frequencies, linear, turning,
};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "fsi.goland.strip", quick: true, run: strip },
    Case { id: "fsi.goland.tether", quick: true, run: tether::rows },
    Case { id: "fsi.goland.lattice", quick: false, run: lattice::rows },
];

/// Goland 1945: semi-span and semi-chord, m; elastic axis and centre of mass behind the leading edge, chords.
const SPAN: f64 = 6.096;
const SEMI_CHORD: f64 = 0.9144;
const AXIS: f64 = 0.33;
const CENTRE: f64 = 0.43;
/// Bending and torsional stiffness, N m2; mass, kg/m, and inertia about the elastic axis, kg m.
const BENDING: f64 = 9.77e6;
const TORSION: f64 = 0.987e6;
const MASS: f64 = 35.71;
const INERTIA: f64 = 8.64;
/// Density at sea level, to which the speed of exact strip theory belongs, kg/m3.
const SEA_LEVEL: f64 = 1.225;
/// Density with which lattices publish their speeds (`validation/goland`), kg/m3.
const ALOFT: f64 = 1.02;
/// Strips over the semi-span, and modes of the beam.
const STRIPS: usize = 40;
const MODES: usize = 4;
/// Reduced frequencies omega b / U searched, from the largest down, by this factor.
const SEARCHED: (f64, f64, f64) = (1.5, 0.2, 0.99);

/// The beam, with nodes at `arcs`; y points aft.
fn beam(arcs: Vec<f64>) -> Result<Beam, Error> {
    let offset = (CENTRE - AXIS) * 2.0 * SEMI_CHORD;
    let own = INERTIA - MASS * offset * offset;
    // In its plane it is taken a hundred times stiffer.
    let section = CrossSection::isotropic(1e10, [TORSION, BENDING, 100.0 * BENDING]).with_mass(
        MASS,
        Vec3::new(0.0, offset, 0.0),
        Mat3::diagonal(Vec3::new(own, 1e-6 * own, own)),
    );
    let stations = [0.0, SPAN].map(|arc_m| SectionStation { arc_m, section });
    Ok(Beam::new(&stations, &[], &Grid { elements: 1, order: 6, strains: Strain::INEXTENSIBLE, arcs })?)
}

fn middle(strip: usize) -> f64 {
    (strip as f64 + 0.5) * SPAN / STRIPS as f64
}

/// A mode of unit mass: frequency squared, and displacement down (semi-chords) and twist nose up of each strip.
struct WingMode {
    square: f64,
    moves: Vec<[f64; 2]>,
}

/// The lowest modes of the library's beam without air.
fn modes() -> Result<Vec<WingMode>, Error> {
    let (beam, setting) = (beam((0..STRIPS).map(middle).collect())?, Setting::default());
    let zero = vec![0.0; beam.coordinates()];
    let found = frequencies(&linear(&beam, &setting, &zero));
    let mode = |(omega, shape): &(f64, Vec<f64>)| {
        // Rates of a beam that is straight are small displacements.
        let places = beam.motion(&setting, &zero, shape, &zero);
        let of = |strip: usize| {
            let place = &places[beam.nearest(middle(strip))];
            // A chord along y, which points aft, turns nose up about -x.
            [-place.p[2].d / SEMI_CHORD, -turning(&place.r)[0][0]]
        };
        WingMode { square: omega * omega, moves: (0..STRIPS).map(of).collect() }
    };
    Ok(found.iter().take(MODES).map(mode).collect())
}

/// Work of the loads of mode j on mode i over omega2 at the reduced frequency `k` in air of `density`, by strips.
fn by_strips(modes: &[WingMode], density: f64, k: f64) -> DMatrix<C> {
    let [lift, moment] = loads(2.0 * AXIS - 1.0, k);
    let scale = PI * density * SEMI_CHORD.powi(4) * SPAN / STRIPS as f64;
    DMatrix::from_fn(modes.len(), modes.len(), |i, j| {
        let work = modes[i].moves.iter().zip(&modes[j].moves).map(|([h, alpha], [by_h, by_alpha])| {
            // Lift points up, h down.
            (moment[0] * *by_h + moment[1] * *by_alpha) * *alpha
                - (lift[0] * *by_h + lift[1] * *by_alpha) * *h
        });
        work.sum::<C>() * scale
    })
}

/// All X = (1 + i g)/omega2 at which a wing of the modal frequencies squared `squares` oscillates harmonically:
/// X omega_i2 q_i = q_i + sum_j G_ij q_j, omega2 G the work of the loads of mode j on mode i.
fn characteristic(squares: &[f64], work: &DMatrix<C>) -> Result<Vec<C>, Error> {
    let own = |i: usize, j: usize| C::from(if i == j { 1.0 } else { 0.0 });
    let matrix =
        DMatrix::from_fn(squares.len(), squares.len(), |i, j| (own(i, j) + work[(i, j)]) / squares[i]);
    let found = matrix.eigenvalues().ok_or_else(|| Error::NoAnswer("eigenvalues of Goland's wing".into()))?;
    Ok(found.iter().copied().collect())
}

/// Speed (m/s) and frequency (rad/s) of flutter: the lowest speed at which the damping that a harmonic motion needs turns positive.
fn flutter(squares: &[f64], work: impl Fn(f64) -> DMatrix<C>) -> Result<[f64; 2], Error> {
    let at = |k: f64| characteristic(squares, &work(k));
    let (first, last, factor) = SEARCHED;
    let (mut k, mut roots, mut found) = (first, at(first)?, Vec::new());
    while k > last {
        let next = at(k * factor)?;
        for root in &next {
            let near = |x: &&C| (**x - root).norm();
            let before = roots.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
            if let Some(before) = before.filter(|x| x.im < 0.0 && root.im >= 0.0 && root.re > 0.0) {
                let share = before.im / (before.im - root.im);
                let (k, x) = (k * (1.0 + (factor - 1.0) * share), before + (root - before) * share);
                let omega = x.re.sqrt().recip();
                found.push([omega * SEMI_CHORD / k, omega]);
            }
        }
        (k, roots) = (k * factor, next);
    }
    let lowest = found.into_iter().min_by(|a, b| a[0].total_cmp(&b[0]));
    lowest.ok_or_else(|| Error::NoAnswer("flutter of Goland's wing".into()))
}

fn strip() -> Result<Vec<ComparisonRow>, Error> {
    let modes = modes()?;
    let squares: Vec<f64> = modes.iter().map(|mode| mode.square).collect();
    let [speed, frequency] = flutter(&squares, |k| by_strips(&modes, SEA_LEVEL, k))?;
    let aloft = flutter(&squares, |k| by_strips(&modes, ALOFT, k))?;
    let source = "Goland 1945, Goland & Luke 1948: exact strip theory at sea level, 137.2 m/s, 70.7 rad/s";
    let judged = |id: &str, what: &str, value: f64| ComparisonRow::judged(id, source, what, value, 0.03, "");
    Ok(vec![
        judged(
            "fsi.goland.strip",
            &format!(
                "relative error of the speed of flutter, the beam's modes with Theodorsen's loads by strips (computed {speed:.2} m/s)"
            ),
            (speed / 137.2 - 1.0).abs(),
        ),
        judged(
            "fsi.goland.strip.frequency",
            &format!("relative error of its frequency (computed {frequency:.2} rad/s)"),
            (frequency / 70.7 - 1.0).abs(),
        ),
        ComparisonRow::shown(
            "fsi.goland.strip.aloft",
            "validation/goland: 164 to 177 m/s in three-dimensional flow, where the finite wing bears less",
            "speed of flutter by strips in air of 1.02 kg/m3",
            aloft[0],
            "m/s",
        ),
    ])
}
