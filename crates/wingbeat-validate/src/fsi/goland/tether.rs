//! Goland's wing as `wingbeat tether` has it: the library's beam in the air of the strips.

use super::{ALOFT, AXIS, BENDING, CENTRE, INERTIA, MASS, SEMI_CHORD, SPAN, TORSION};
use crate::{ComparisonRow, Error};
use wingbeat::scenario::{Document, TetherCase};

/// Size of the wing whose case is read, which flutters at the same speed: stiffness and inertia go by its fourth power, mass by its square, frequencies
/// by its inverse. In full size a spar is stiffer than cases allow.
const SCALE: f64 = 0.1;
/// Strips of the whole wing.
const STRIPS: [usize; 2] = [12, 24];
/// Speeds between which it begins to flutter, m/s, and halvings of the way between them.
const BETWEEN: [f64; 2] = [100.0, 220.0];
const HALVINGS: usize = 14;
/// Growth rate over the angular frequency below which a motion is not damped but for rounding, as those in the plane of the wing.
const NONE: f64 = 1e-6;

/// The case on so many strips at `speed` m/s.
fn case(strips: usize, speed: f64) -> Result<TetherCase, Error> {
    let (chord, span) = (2.0 * SCALE * SEMI_CHORD, SCALE * SPAN);
    let (ahead, behind) = (AXIS * chord, (AXIS - 1.0) * chord);
    let aft = (CENTRE - AXIS) * chord;
    let [torsion, bending, inertia] = [TORSION, BENDING, INERTIA].map(|of| of * SCALE.powi(4));
    let mass = MASS * SCALE * SCALE;
    let station = |arc: f64| {
        format!(
            "{{ arc_m = {arc:?}, torsion_n_m2 = {torsion:?}, bending_n_m2 = {bending:?}, edge_bending_n_m2 = {:?}, mass_kg_m = {mass:?}, \
             aft_m = {aft:?}, inertia_kg_m = {:?} }}",
            100.0 * bending,
            inertia - mass * aft * aft
        )
    };
    let edges =
        |arc: f64| format!("{{ arc_m = {arc:?}, leading_edge_m = {ahead:?}, trailing_edge_m = {behind:?} }}");
    let text = format!(
        "name = \"goland\"\nwing.planform = [{}, {}]\nspar = {{ elements = 1, order = 6, stations = [{}, {}] }}\n\
         wind = {{ speed_m_s = {speed:?}, density_kg_m3 = {ALOFT:?} }}\n\
         aero = {{ preset = \"full\", law = \"linear\", full.strips = {strips} }}\n\
         time = {{ frequency_hz = 50.0, cycles = 1, steps_per_cycle = 64 }}\n",
        edges(0.0),
        edges(span),
        station(0.0),
        station(span)
    );
    let read =
        Document::text("goland", &text).and_then(|text| TetherCase::new(text, &|_| Err(String::new())));
    read.map_err(|error| Error::NoAnswer(error.to_string()))
}

/// Growth rate (1/s) and frequency (rad/s) of the least damped motion.
fn least_damped(strips: usize, speed: f64) -> Result<[f64; 2], Error> {
    let tether = case(strips, speed)?.tether;
    let steady = tether.spar.as_ref().map(|spar| spar.steady(&tether)).filter(|steady| steady.found);
    steady.map(|steady| steady.least_damped).ok_or_else(|| Error::NoAnswer("shape of Goland's wing".into()))
}

/// Speed (m/s) and frequency (rad/s in full size) of flutter.
fn flutter(strips: usize) -> Result<[f64; 2], Error> {
    let [mut low, mut high] = BETWEEN;
    let mut frequency = f64::NAN;
    for _ in 0..HALVINGS {
        let speed = 0.5 * (low + high);
        let [growth, omega] = least_damped(strips, speed)?;
        if growth > NONE * omega {
            (high, frequency) = (speed, omega);
        } else {
            low = speed;
        }
    }
    Ok([0.5 * (low + high), SCALE * frequency])
}

pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let ([speed, frequency], _) = super::lattice::apart()?;
    let source = format!(
        "a lattice in the frequency domain, extrapolated: {speed:.1} m/s, {frequency:.1} rad/s (validation/goland)"
    );
    let mut rows = Vec::new();
    for strips in STRIPS {
        let [found, omega] = flutter(strips)?;
        let id = format!("fsi.goland.tether.{strips}");
        let metric = format!(
            "relative error of the speed of flutter as `tether` finds it, full, {strips} strips, computed {found:.1} m/s"
        );
        rows.push(ComparisonRow::judged(&id, &source, &metric, (found / speed - 1.0).abs(), 0.03, ""));
        let metric = format!("relative error of its frequency (computed {omega:.1} rad/s)");
        let error = (omega / frequency - 1.0).abs();
        rows.push(ComparisonRow::shown(&format!("{id}.frequency"), &source, &metric, error, ""));
    }
    Ok(rows)
}
