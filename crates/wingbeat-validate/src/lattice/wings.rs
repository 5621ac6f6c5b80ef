//! Wings for the lattice, and what is read off a run.

use crate::Error;
use std::f64::consts::PI;
use wingbeat::aero::{Planform, PlanformStation};
use wingbeat::math::Vec3;
use wingbeat::tether::{Coordinate, Hinge, HingeKind, Motion, Side, Wing};
use wingbeat_lattice::{FlappingWing, Lattice, LatticeLoads, LatticeSettings, Panels, Scene, Spacing};

/// Chord of the wings in small motions, m; their speed is 1 m/s, their density 1 kg/m3.
pub const CHORD: f64 = 1.0;
/// Radius of the wake's cores, chords: small motions need none.
pub const CORE: f64 = 1e-4;
/// Length of the wake behind wings with ends, chords.
const LONGEST: f64 = 40.0;
/// Size of small motions, rad.
pub const SMALL: f64 = 1e-3;

/// A rectangle of the aspect ratio `aspect` with its leading edge at x = 0, at rest in a wind of 1 m/s from ahead.
pub fn rectangle(aspect: f64) -> Result<FlappingWing, Error> {
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -CHORD };
    let planform = Planform::new(&[station(0.0), station(0.5 * aspect * CHORD)])?;
    let wing = Wing::new(planform, Vec::new())?;
    Ok(FlappingWing {
        wing,
        motion: Motion::at_rest(),
        wind: Vec3::new(-1.0, 0.0, 0.0),
        density_kg_m3: 1.0,
        ground: None,
    })
}

/// A wave of the reduced frequency `k`.
pub fn wave(k: f64, cos: f64, sin: f64) -> Coordinate {
    Coordinate::Fourier { frequency_hz: k / (PI * CHORD), mean: 0.0, cos: vec![cos], sin: vec![sin] }
}

/// Lan's strips; one strip from end to end.
pub fn lan(chordwise: usize, spanwise: usize) -> Panels {
    let spacing = if spanwise == 1 { Spacing::Uniform } else { Spacing::Lan };
    Panels { chordwise, spanwise, spacing }
}

/// The loads of `steps` instants, the way of each a panel's chord unless `step` (s) says another.
pub fn loads(
    wing: &FlappingWing,
    panels: Panels,
    step: Option<f64>,
    steps: usize,
) -> Result<Vec<LatticeLoads>, Error> {
    loads_with(CORE, wing, panels, step, steps)
}

/// The same with cores of the radius `core` chords.
pub fn loads_with(
    core: f64,
    wing: &FlappingWing,
    panels: Panels,
    step: Option<f64>,
    steps: usize,
) -> Result<Vec<LatticeLoads>, Error> {
    let scene = Scene::new(wing, panels, true)?;
    let step = step.unwrap_or(CHORD / panels.chordwise as f64);
    // In two dimensions the wake is felt however long it is.
    let longest_distance_m = if panels.spanwise == 1 { f64::INFINITY } else { LONGEST * CHORD.max(step) };
    let settings = LatticeSettings { longest_distance_m, ..LatticeSettings::new(step, core * CHORD) };
    let mut lattice = Lattice::new(scene, settings)?;
    (0..steps).map(|_| Ok(lattice.step()?)).collect()
}

/// The first harmonic, in the unit of the values, at the angular frequency `omega` of values at even `step`, over the whole
/// cycles at their end.
pub fn harmonic(values: &[f64], step: f64, omega: f64) -> (f64, f64) {
    let cycle = (2.0 * PI / (omega * step)).round();
    let from = values.len() - cycle as usize;
    let sum = |wave: fn(f64) -> f64| -> f64 {
        let part = |i: usize| values[i] * wave(omega * step * i as f64);
        (from..values.len()).map(part).sum::<f64>() * 2.0 / cycle
    };
    // Re(H e^(i w t)) = a cos + b sin: H = a - i b.
    (sum(f64::cos), -sum(f64::sin))
}

/// A rectangular wing hinged in the middle that flaps, with an elbow where `fold` says its place over the half span and angle.
pub fn flapper(half_span: f64, amplitude_deg: f64, fold: Option<(f64, f64)>) -> Result<FlappingWing, Error> {
    let (chord, frequency_hz, speed, incidence) = (0.08, 3.5, 1.5, 5_f64.to_radians());
    let station = |arc_m| PlanformStation { arc_m, leading_edge_m: 0.0, trailing_edge_m: -chord };
    let planform = Planform::new(&[station(0.0), station(half_span)])?;
    let angle = |mean: f64, cos: f64, sin: f64| Coordinate::Fourier {
        frequency_hz,
        mean: mean.to_radians(),
        cos: vec![cos.to_radians()],
        sin: vec![sin.to_radians()],
    };
    let hinge = |kind, arc_m| Hinge { kind, side: Side::Both, arc_m, to_arc_m: None, ahead_m: 0.0 };
    let mut hinges = vec![hinge(HingeKind::Flap, 0.0)];
    let mut angles = vec![("shoulder".to_string(), angle(0.0, 0.0, amplitude_deg))];
    if let Some((place, down)) = fold {
        hinges.push(hinge(HingeKind::Fold, place * half_span));
        angles.push(("elbow".into(), angle(-0.5 * down, -0.5 * down, 0.0)));
    }
    let motion = Motion { hinges: angles, ..Motion::at_rest() };
    let wind = Vec3::new(-incidence.cos(), 0.0, incidence.sin()) * speed;
    Ok(FlappingWing { wing: Wing::new(planform, hinges)?, motion, wind, density_kg_m3: 1.225, ground: None })
}

/// Lift and drag, N, of a force in a wind at 5 degrees.
pub fn lift_drag(force: Vec3) -> (f64, f64) {
    let (sin, cos) = 5_f64.to_radians().sin_cos();
    (force[0] * sin + force[2] * cos, -force[0] * cos + force[2] * sin)
}
