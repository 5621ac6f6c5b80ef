//! Along a flight: the forces of preset `full`, which flew it, and those of the lattice. Without drag of body and sections, which neither
//! of them computes, the robot keeps its speed, and with it the reduced frequency.

use crate::aero_turn::turn;
use crate::{Error, Row};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;
use wingbeat_lattice::{Flight, Lattice, Panels, Scene, Settings, Spacing};

/// Speed at the start, m/s, and wing beats per second.
const SPEED: f64 = 5.2;
const FREQUENCY: f64 = 3.5;
/// Time at which the lattice starts, s, and cycles that it is stepped.
const FROM: f64 = 0.3;
const CYCLES: usize = 2;
/// Core of the wake, chords.
const CORE: f64 = 0.02;

/// Aerobat under its controller, without folding, its wings apart; the gait's amplitude is a
/// choice that keeps the flow attached.
fn overrides() -> Vec<String> {
    [
        format!("start.velocity_m_s=[{SPEED}, 0.0, 0.0]"),
        "start.pitch_deg=-4.0".into(),
        "robot.body.drag_area_m2=[0.0, 0.0, 0.0]".into(),
        "robot.wing.cd0=0.0".into(),
        "manoeuvre.pitch_deg=-4.0".into(),
        "manoeuvre.roll_deg=0.0".into(),
        "manoeuvre.yaw_rate_rad_s=0.0".into(),
        "robot.gait.fourier.shoulder={ mean_rad = 0.1, harmonics = [{ amplitude_rad = 0.3, phase_rad = 0.0 }] }".into(),
        "robot.gait.fourier.elbow={ mean_rad = 0.0, harmonics = [] }".into(),
        "flight.duration_s=0.9".into(),
    ]
    .into()
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

/// Vertical force by the model that flew (without profile drag) and by the lattice, and the reduced frequency.
fn forces(chordwise: usize) -> Result<([Vec<f64>; 2], usize, f64), Error> {
    let scenario = turn(&overrides())?;
    let run = scenario.fly(|_| ControlFlow::Continue(()))?;
    let outlines = scenario.spec.robot.outlines()?;
    let planform = &outlines[0].planform;
    let chord = planform.area() / (2.0 * planform.half_span());
    let to = FROM + CYCLES as f64 / FREQUENCY;
    let flight = Arc::new(Flight::new(scenario.robot(), &run.record, FROM, to)?);
    let panels = Panels { chordwise, spanwise: 24, spacing: Spacing::Lan };
    let density = scenario.spec.air.density_kg_m3;
    let (scene, _) = Scene::flown(&flight, &outlines, FROM, density, panels)?;
    let steps = (SPEED / FREQUENCY * chordwise as f64 / chord).round() as usize;
    let step = 1.0 / (FREQUENCY * steps as f64);
    let mut lattice = Lattice::new(scene, Settings::new(step, CORE * chord))?;
    let mut up: [Vec<f64>; 2] = Default::default();
    let mut speed = 0.0;
    for k in 0..CYCLES * steps {
        let t = FROM + step * k as f64;
        let lost = || Error::NoAnswer(format!("the flight did not last {t} s"));
        let seen = flight.observe(t).ok_or_else(lost)?;
        let air = seen.air.circulatory + seen.air.induced_drag + seen.air.added_mass;
        up[0].push((seen.attitude * air.force)[2]);
        up[1].push(lattice.step()?.joukowski.force[2]);
        speed += flight.body(t).1.norm() / (CYCLES * steps) as f64;
    }
    Ok((up, steps, PI * FREQUENCY * chord / speed))
}

/// Mean and amplitude of the vertical force.
pub fn free_flight() -> Result<Vec<Row>, Error> {
    let (coarse, fine) = (forces(4)?, forces(8)?);
    let of = |(up, steps, _): &([Vec<f64>; 2], usize, f64), by: usize| mean_and_amplitude(&up[by], *steps);
    let (full, k) = (of(&fine, 0), fine.2);
    // In unsteady flow the error falls as the panels' chord.
    let limit = |coarse: f64, fine: f64| 2.0 * fine - coarse;
    let (rough, near) = (of(&coarse, 1), of(&fine, 1));
    let mean = limit(rough.0, near.0);
    let amplitude: [f64; 2] = std::array::from_fn(|i| limit(rough.1[i], near.1[i]));
    let size = |a: [f64; 2]| a[0].hypot(a[1]);
    let far = (amplitude[0] - full.1[0]).hypot(amplitude[1] - full.1[1]);
    let metric = format!(
        "Aerobat under its controller, unfolded, +-17 deg, k {k:.2}: mean vertical force {mean:.3} N, error of full over it; lattice extrapolated from 4 and 8 x 24 panels"
    );
    let row =
        |id: &str, metric: &str, value: f64| Row::judged(id, "own vortex lattice", metric, value, 0.03, "");
    Ok(vec![
        row("lattice.free_flight.mean", &metric, (full.0 / mean - 1.0).abs()),
        row(
            "lattice.free_flight.amplitude",
            &format!("its first harmonic {:.3} N: complex error over it", size(amplitude)),
            far / size(amplitude),
        ),
    ])
}
