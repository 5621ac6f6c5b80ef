//! Drag of steady wings by the forces on their vortices, against that of their wake far behind.

use super::wings::{CHORD, lan, rectangle};
use crate::{ComparisonRow, Error};
use std::f64::consts::PI;
use wingbeat::aero::{Planform, PlanformStation};
use wingbeat::math::Vec3;
use wingbeat::tether::Wing;
use wingbeat_lattice::{FlappingWing, Lattice, LatticeSettings, Scene};

/// Span, m; the area is that of the aspect ratio 8.
pub(super) const SPAN: f64 = 8.0;
/// Incidence, rad.
const INCIDENCE: f64 = 0.1;
/// Stations of an outline that is curved.
const STATIONS: usize = 60;

/// A wing: its leading edge behind that of the root, and its chord, m, at a share of the half span.
pub(super) type HalfWingOutline = fn(f64) -> (f64, f64);

/// Elliptic chords about a straight quarter line.
pub(super) fn elliptic(at: f64) -> (f64, f64) {
    let (root, chord) = (4.0 / PI, (4.0 / PI) * (1.0 - at * at).max(1e-4).sqrt());
    (0.25 * (root - chord), chord)
}

/// Taper .3 about a straight quarter line.
fn tapered(at: f64) -> (f64, f64) {
    let (root, chord) = (2.0 / 1.3, (2.0 / 1.3) * (1.0 - 0.7 * at));
    (0.25 * (root - chord), chord)
}

/// Swept by 30 deg.
fn swept(at: f64) -> (f64, f64) {
    (at * 0.5 * SPAN * 30_f64.to_radians().tan(), CHORD)
}

/// The wing of an outline, at rest in a wind of 1 m/s from ahead.
pub(super) fn laid(outline: HalfWingOutline) -> Result<FlappingWing, Error> {
    let station = |k: usize| {
        // Close together at the tip, where a curved outline turns.
        let at = (0.5 * PI * k as f64 / STATIONS as f64).sin();
        let (ahead, chord) = outline(at);
        PlanformStation { arc_m: 0.5 * SPAN * at, leading_edge_m: -ahead, trailing_edge_m: -ahead - chord }
    };
    let stations: Vec<PlanformStation> = (0..=STATIONS).map(station).collect();
    let mut wing = rectangle(SPAN)?;
    wing.wing = Wing::new(Planform::new(&stations)?, Vec::new())?;
    Ok(wing)
}

/// Lift, N, and drag, N, by the forces on the vortices and by the wake, on 6 x 24 panels.
fn forces(outline: HalfWingOutline) -> Result<[f64; 3], Error> {
    let mut wing = laid(outline)?;
    wing.wind = Vec3::new(-INCIDENCE.cos(), 0.0, INCIDENCE.sin());
    // A step so long that the last rings are horseshoes.
    let settings =
        LatticeSettings { longest_distance_m: f64::INFINITY, ..LatticeSettings::new(1e4 * CHORD, 1e-3) };
    let mut lattice = Lattice::new(Scene::new(&wing, lan(6, 24), true)?, settings)?;
    lattice.step()?;
    let force = lattice.step()?.joukowski.force;
    let far = lattice.wake_drag().ok_or_else(|| Error::NoAnswer("no wind".into()))?;
    let up = Vec3::new(INCIDENCE.sin(), 0.0, INCIDENCE.cos());
    Ok([force.dot(up), force.dot(wing.wind), far])
}

/// Force along the span, outward, on a half of `wing` in a wind of 1 m/s at the incidence `incidence` (rad), and its lift across the
/// wing, N, on panels along the chord and along a half of the span.
pub fn steady_half(
    wing: &Wing,
    incidence: f64,
    (chordwise, spanwise): (usize, usize),
) -> Result<[f64; 2], Error> {
    let wing = FlappingWing {
        wing: wing.clone(),
        wind: Vec3::new(-incidence.cos(), 0.0, incidence.sin()),
        ..rectangle(SPAN)?
    };
    let settings =
        LatticeSettings { longest_distance_m: f64::INFINITY, ..LatticeSettings::new(1e4 * CHORD, 1e-3) };
    let mut lattice = Lattice::new(Scene::new(&wing, lan(chordwise, spanwise), true)?, settings)?;
    lattice.step()?;
    let loads = lattice.step()?;
    let half = loads.panels.iter().flat_map(|panels| &panels.strips).fold(Vec3::ZERO, |sum, w| sum + w.force);
    Ok([half[1], half[2]])
}

/// Both drags of each wing, and the largest span efficiency L^2/(pi q b^2 D), which none can have above 1 (Munk 1921).
pub fn efficiency() -> Result<Vec<ComparisonRow>, Error> {
    let wings: [(&str, &str, HalfWingOutline); 3] = [
        ("elliptic", "elliptic", elliptic),
        ("tapered", "taper 0.3", tapered),
        ("swept", "swept by 30 deg", swept),
    ];
    let (mut rows, mut most) = (Vec::new(), 0.0_f64);
    for (id, name, outline) in wings {
        let [lift, near, far] = forces(outline)?;
        let metric = format!(
            "AR 8, {name}, 6 x 24 panels: drag by the forces on the vortices over that of the wake, less 1"
        );
        let id = format!("lattice.span_efficiency.{id}");
        rows.push(ComparisonRow::judged(&id, "Munk 1921", &metric, (near / far - 1.0).abs(), 0.02, ""));
        most = [near, far]
            .iter()
            .fold(most, |most, drag| most.max(lift * lift / (0.5 * PI * SPAN * SPAN * drag)));
    }
    let metric = "largest span efficiency of these by either drag";
    rows.push(ComparisonRow::judged("lattice.span_efficiency.most", "Munk 1921", metric, most, 1.0, ""));
    Ok(rows)
}
