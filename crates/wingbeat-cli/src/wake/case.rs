//! The course of a case.

use wingbeat::scenario::TetherCase;
use wingbeat_lattice::{Flapping, Scene};

use super::course::{Axes, Clock, Course};
use super::stroke::Stroke;
use super::{fitting, panels, refused};
use crate::args::Wake;
use crate::error::Error;
use crate::interrupt::Interrupt;

/// Steps of a cycle without wind.
const STILL: f64 = 48.0;

/// The course through all cycles of `case`.
pub fn course(arguments: &Wake, case: &TetherCase, interrupt: &Interrupt) -> Result<Course, Error> {
    let tether = &case.tether;
    let (frequency_hz, cycles) = (tether.clock.frequency_hz, tether.clock.cycles);
    let chord = tether.reference.chord_m;
    let speed = tether.wind.norm();
    let way = if speed > 0.0 { speed / frequency_hz } else { STILL * chord / arguments.chordwise as f64 };
    let steps = arguments.steps.unwrap_or_else(|| fitting(way, chord, arguments.chordwise));
    let clock = Clock { frequency_hz, cycles, steps };
    let flapping = Flapping::try_from(tether).map_err(refused)?;
    let symmetric = Scene::new(&flapping, panels(arguments), true).map_err(refused)?.symmetric;
    let scene = Scene::new(&flapping, panels(arguments), false).map_err(refused)?;
    Ok(Course {
        name: String::new(),
        title: "wing and wake".into(),
        groups: std::iter::once(0..scene.surfaces.len()).collect(),
        stroke: Stroke::of(tether, &clock),
        axes: Axes::new(-tether.wind),
        scene,
        clock,
        chord,
        symmetric,
        flown: None,
        crosses: false,
        past_stall: past_stall(case, interrupt)?,
    })
}

/// Share of strips and instants of the last cycle past the stall angle, by the strip model of the case.
fn past_stall(case: &TetherCase, interrupt: &Interrupt) -> Result<f64, Error> {
    let run = case.tether.run(|_| interrupt.flow());
    interrupt.check()?;
    let incidence = run.strips.values("incidence").unwrap_or_default();
    let last = &incidence[incidence.len() - incidence.len() / case.tether.clock.cycles..];
    let stall = case.tether.aero.stall_angle();
    Ok(last.iter().filter(|angle| angle.abs() > stall).count() as f64 / last.len().max(1) as f64)
}
