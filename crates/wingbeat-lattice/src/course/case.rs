//! The course of a case.

use super::{Axes, CourseClock, CourseRequest, LatticeCourse, Stroke, fitting};
use crate::{Error, FlappingWing, Scene};
use std::ops::ControlFlow;
use wingbeat::scenario::{Moved, TetherCase};
use wingbeat::simulate::Ending;

/// Steps of a cycle without wind.
const STILL: f64 = 48.0;

/// The course through all cycles of `case`; `flow` may end the strip model that tells what is past stall.
///
/// # Errors
/// What cannot be asked, and wings without a lattice.
pub fn case(
    asked: &CourseRequest,
    case: &TetherCase,
    flow: &dyn Fn() -> ControlFlow<()>,
) -> Result<LatticeCourse, Error> {
    let asked = asked.checked()?;
    let tether = &case.tether;
    let (frequency_hz, cycles) = (tether.clock.frequency_hz, tether.clock.cycles);
    let chord = tether.reference.chord_m;
    let speed = tether.wind.norm();
    let way = if speed > 0.0 { speed / frequency_hz } else { STILL * chord / asked.chordwise as f64 };
    let steps = asked.steps.unwrap_or_else(|| fitting(way, chord, asked.chordwise));
    let clock = CourseClock { frequency_hz, cycles, steps };
    asked.check_size(clock)?;
    let flapping = FlappingWing::try_from(tether)?;
    let symmetric = Scene::new(&flapping, asked.panels(), true)?.symmetric;
    let scene = Scene::new(&flapping, asked.panels(), false)?;
    let moved = Moved::new(tether);
    Ok(LatticeCourse {
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
        moved: Some(moved),
        critical_suction: asked.critical_suction,
        unheard: case.unheard_by_lattice(),
        past_stall: past_stall(case, flow),
    })
}

/// Share of strips and instants of the last cycle past the stall angle, by the strip model of the case; none where that breaks down.
fn past_stall(case: &TetherCase, flow: &dyn Fn() -> ControlFlow<()>) -> Option<f64> {
    let run = case.tether.run(|_| flow());
    if run.ending != Ending::Complete {
        return None;
    }
    Some(run.stalled.stalled())
}
