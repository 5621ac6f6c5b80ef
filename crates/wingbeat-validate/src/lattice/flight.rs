//! Along flights: the forces of preset `full`, which flew them, and those of the lattice. Two flights, both at reduced frequencies of at most .3:
//!
//! - The model glider, its wings flapped at their roots, regulators at rest. It is 28 times as heavy as the air of a chord's height over
//!   its wing, so that the body hardly gives way and the force is that of the strokes. Judged.
//! - Aerobat under its controller. Without drag of body and sections, which neither computes, it keeps its speed. It is light: the body gives
//!   way to the strokes and the controller twists the wings against them, so that the force is a small difference of parts on each of which
//!   `full` is within 2 to 3 %. Shown.

use super::small::extrapolated;
use crate::aero_turn::turn;
use crate::shipped;
use crate::{ComparisonRow, Error};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat::scenario::{Document, Scenario};
use wingbeat::simulate::Record;
use wingbeat_lattice::{FlightStretch, Lattice, LatticeSettings, Panels, Scene, Spacing};

/// Largest error of mean and amplitude.
const LIMIT: f64 = 0.03;
/// Core of the wake, chords: next to none. With 0.02 the four rows are 0.0054, 0.0300, 0.0568 and 0.185, so a light robot's force knows
/// the core.
const CORE: f64 = 0.001;

/// A flight, and the stretch of it along which the lattice is stepped.
struct LatticeFlight {
    scenario: Scenario,
    /// Speed about which it flies, m/s.
    speed: f64,
    /// Wing beats per second.
    frequency: f64,
    /// Begin of the stretch, s.
    from: f64,
    cycles: usize,
}

/// Aerobat under its controller, without folding, its wings apart; the gait's amplitude is a choice that keeps the flow attached.
fn aerobat() -> Result<LatticeFlight, Error> {
    let (speed, frequency) = (5.2, 3.5);
    let overrides = [
        format!("start.velocity_m_s=[{speed}, 0.0, 0.0]"),
        "start.nose_up_deg=4.0".into(),
        "robot.body.drag_area_m2=[0.0, 0.0, 0.0]".into(),
        "robot.wing.cd0=0.0".into(),
        "manoeuvre.nose_up_deg=4.0".into(),
        "manoeuvre.roll_deg=0.0".into(),
        "manoeuvre.yaw_rate_rad_s=0.0".into(),
        "robot.gait.fourier.shoulder={ mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.3, phase_rad = 0.0 }] }".into(),
        "robot.gait.fourier.elbow={ mean_rad = 0.0, harmonics = [] }".into(),
        "flight.duration_s=0.9".into(),
    ];
    Ok(LatticeFlight { scenario: turn(&overrides)?, speed, frequency, from: 0.3, cycles: 2 })
}

/// What of the glider's robot file makes its wing ride on shoulders.
const RIGID: &str =
    "panels = [{ link = \"body\", origin_m = [0.025, 0.0, 0.0], direction = [0.0, 1.0, 0.105] }]";
const FLAPPING: &str = "panels = [{ link = \"shoulder\" }]\n[[links]]\nname = \"shoulder\"\nside = \"mirrored\"\norigin_m = [0.025, 0.0, 0.0]\n\
    driven = { mean_rad = 0.105, harmonics = [{ amplitude_rad = 0.1, phase_rad = 0.0 }] }\n[gait.fourier]\nfrequency_hz = 6.25\n";

/// The model glider from its glide, flapping by 6 degrees, six beats and a quarter a second: choices that keep the flow attached.
fn glider() -> Result<LatticeFlight, Error> {
    let refused = |e: wingbeat::scenario::ConfigError| Error::reference("glider", e.to_string());
    let robot = shipped::robot("glider", &|text| text.replace(RIGID, FLAPPING))?;
    if robot.written("gait").is_none() {
        return Err(Error::reference("glider", "its wing rides elsewhere"));
    }
    let document = shipped::document("glider")?.put("robot", robot).map_err(refused)?;
    let document = document.set("flight.duration_s=0.96").set("flight.record_every_s=1e-3");
    let scenario = Scenario::new(document).map_err(refused)?;
    Ok(LatticeFlight { scenario, speed: 9.0, frequency: 6.25, from: 0.2, cycles: 4 })
}

/// Mean and complex amplitude at the frequency of the wing beat over the last cycle of `values`, `steps` to the cycle.
fn mean_and_amplitude(values: &[f64], steps: usize) -> (f64, [f64; 2]) {
    let last = &values[values.len() - steps..];
    let count = steps as f64;
    let part = |wave: fn(f64) -> f64| -> f64 {
        let term = |(k, v): (usize, &f64)| v * wave(2.0 * PI * k as f64 / count);
        last.iter().enumerate().map(term).sum::<f64>() * 2.0 / count
    };
    (last.iter().sum::<f64>() / count, [part(f64::cos), part(f64::sin)])
}

/// Vertical force by the model that flew (without profile drag) and by the lattice, steps of a cycle, and the reduced frequency.
fn forces(flown: &LatticeFlight, chordwise: usize) -> Result<([Vec<f64>; 2], usize, f64), Error> {
    let LatticeFlight { scenario, speed, frequency, from, cycles } = flown;
    let run = scenario.fly(|_| ControlFlow::Continue(()))?;
    let outlines = scenario.spec.robot.outlines()?;
    let planform = &outlines[0].planform;
    let chord = planform.mean_chord();
    let to = from + *cycles as f64 / frequency;
    let flight = Arc::new(FlightStretch::new(scenario.robot(), &run.record, *from, to)?);
    let panels = Panels { chordwise, spanwise: 24, spacing: Spacing::Lan };
    let density = scenario.spec.air.density_kg_m3;
    let (scene, _) = Scene::flown(&flight, &outlines, *from, density, panels)?;
    let steps = (speed / frequency * chordwise as f64 / chord).round() as usize;
    let step = 1.0 / (frequency * steps as f64);
    let mut lattice = Lattice::new(scene, LatticeSettings::new(step, CORE * chord))?;
    let mut up: [Vec<f64>; 2] = Default::default();
    let mut mean_speed = 0.0;
    for k in 0..cycles * steps {
        let t = from + step * k as f64;
        let lost = || Error::NoAnswer(format!("the flight did not last {t} s"));
        let seen = flight.observe(t).ok_or_else(lost)?;
        let air = seen.air.circulatory + seen.air.induced_drag + seen.air.added_mass;
        up[0].push((seen.attitude * air.force)[2]);
        up[1].push(lattice.step()?.joukowski.force[2]);
        mean_speed += flight.body(t).1.norm() / (cycles * steps) as f64;
    }
    Ok((up, steps, PI * frequency * chord / mean_speed))
}

/// Errors of mean and first harmonic of the vertical force.
struct ForceErrors {
    k: f64,
    mean: f64,
    amplitude: f64,
    error_of_mean: f64,
    error_of_amplitude: f64,
}

fn errors(flown: &LatticeFlight) -> Result<ForceErrors, Error> {
    let (coarse, fine) = (forces(flown, 4)?, forces(flown, 8)?);
    let of = |(up, steps, _): &([Vec<f64>; 2], usize, f64), by: usize| mean_and_amplitude(&up[by], *steps);
    let (full, k) = (of(&fine, 0), fine.2);
    let (rough, near) = (of(&coarse, 1), of(&fine, 1));
    let mean = extrapolated(rough.0, near.0);
    let amplitude: [f64; 2] = std::array::from_fn(|i| extrapolated(rough.1[i], near.1[i]));
    let size = amplitude[0].hypot(amplitude[1]);
    let far = (amplitude[0] - full.1[0]).hypot(amplitude[1] - full.1[1]);
    let error_of_mean = (full.0 / mean - 1.0).abs();
    Ok(ForceErrors { k, mean, amplitude: size, error_of_mean, error_of_amplitude: far / size })
}

/// Steps of the lattice beside the flight, s: the way of one is a panel's chord and a fifth.
const STEP: f64 = 0.004;

/// The flapping glider flown in the lattice, both found together, beside the flight by strips.
pub fn coupled() -> Result<Vec<ComparisonRow>, Error> {
    let refused = |e: wingbeat::scenario::ConfigError| Error::reference("glider", e.to_string());
    let strips = glider()?.scenario;
    let document = Document::text("glider.toml", &strips.resolved).map_err(refused)?;
    let document = document.set(format!("lattice.step_s={STEP}"));
    let lattice = Scenario::open(document, &wingbeat_lattice::doors()).map_err(refused)?;
    let runs = [strips, lattice].map(|scenario| scenario.fly(|_| ControlFlow::Continue(())));
    let [strips, lattice] = runs;
    let (strips, lattice) = (strips?, lattice?);
    let lost = || Error::NoAnswer("a flight in the lattice did not last".into());
    let last = |record: &Record, name: &str| record.values(name).and_then(|v| v.last().copied());
    let end = |record: &Record| Some([last(record, "p_WB_x")?, last(record, "p_WB_z")?, last(record, "t")?]);
    let (a, b) = (end(&strips.record).ok_or_else(lost)?, end(&lattice.record).ok_or_else(lost)?);
    let tried = lattice.summary.lattice.ok_or_else(lost)?;
    let metric = format!(
        "the model glider flapping, {:.2} s in the lattice, its loads and the motion found together: end beside that by full, over the way; {:.1} states tried a step, at most {}",
        b[2], tried.iterations_mean, tried.iterations_most
    );
    let apart = (a[0] - b[0]).hypot(a[1] - b[1]) / a[0].hypot(a[1]);
    Ok(vec![ComparisonRow::shown("lattice.coupled", "preset full", &metric, apart, "")])
}

/// Mean and amplitude of the vertical force.
pub fn free_flight() -> Result<Vec<ComparisonRow>, Error> {
    const LATTICE: &str = "own vortex lattice";
    let (heavy, light) = (errors(&glider()?)?, errors(&aerobat()?)?);
    let mean = |what: &str, found: &ForceErrors| {
        format!(
            "{what}, k {:.2}: mean vertical force {:.3} N, error of full over it; lattice extrapolated from 4 and 8 x 24 panels",
            found.k, found.mean
        )
    };
    let amplitude =
        |found: &ForceErrors| format!("its first harmonic {:.3} N: complex error over it", found.amplitude);
    let glider = mean("model glider, wings flapping by +-6 deg", &heavy);
    let aerobat = mean("Aerobat under its controller, unfolded, +-17 deg", &light);
    let judged = |id, metric: &str, value| ComparisonRow::judged(id, LATTICE, metric, value, LIMIT, "");
    let shown = |id, metric: &str, value| ComparisonRow::shown(id, LATTICE, metric, value, "");
    Ok(vec![
        judged("lattice.free_flight.mean", &glider, heavy.error_of_mean),
        judged("lattice.free_flight.amplitude", &amplitude(&heavy), heavy.error_of_amplitude),
        shown("lattice.free_flight.light_mean", &aerobat, light.error_of_mean),
        shown("lattice.free_flight.light_amplitude", &amplitude(&light), light.error_of_amplitude),
    ])
}
