//! Whether the bodies of a robot are such as wings carry: a unit that was mistaken makes them a thousand times too large or small.

use super::link_spar;
use wingbeat_aero::Aero;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::{flap, membrane, range};
use wingbeat_math::GRAVITY;
use wingbeat_robot::Robot;

/// Angular frequency times the time of an inertance at which a vibration is slowed by (w t)^4/2, half a per cent.
const SLOWED: f64 = 0.316;
/// Frequency of the motion of a robot that does not flap, Hz. *Choice.*
const GLIDE_HZ: f64 = 1.0;

/// What a run that broke down says of `robot` where springs, membranes or flaps may move faster than its steps, which `key` sets; nothing
/// of a rigid one.
pub(super) fn of_short_periods(robot: &Robot, key: &str) -> String {
    let springs = (0..robot.tree().links()).any(|joint| robot.is_elastic(joint));
    let soft = robot.surfaces().any(|(_, aero)| aero.membrane().is_some() || aero.flap().is_some());
    if springs || soft {
        format!(": stiff springs, spars, membranes and flaps may need {key}")
    } else {
        String::new()
    }
}

/// What a run whose mass matrix is none from the start says of `robot`.
pub(super) fn of_no_inertia(robot: &Robot) -> String {
    let mut text = ": a link or a piece of a spar turns without inertia of its own or beyond it".to_owned();
    if robot.surfaces().any(|(_, aero)| aero.membrane().is_some() || aero.flap().is_some()) {
        text += ", out of which the mass of a flap or membrane is taken: raise inertia_kg_m2 of the link or inertia_kg_m of its spar, or lower \
                 areal_density_kg_m2";
    }
    text
}

/// Holds the frequency up to which the vibrations of springs with an inertance are slowed by at most half a per cent against that of the gait.
pub(super) fn hold_followed(judge: &mut Judge, robot: &Robot) {
    if robot.inertance_s() > 0.0 {
        let cycles = std::f64::consts::TAU * robot.frequency_hz().max(GLIDE_HZ) * robot.inertance_s();
        judge.hold(&range::FOLLOWED, SLOWED / cycles);
        judge.hold(&range::NOT_FOLLOWED, SLOWED / cycles);
    }
}

/// Holds the angles of the driven joints of `robot` against half a turn, and their phases against a whole one.
fn hold_angles(judge: &mut Judge, robot: &Robot) {
    let series = robot.numbers().series;
    let largest = |of: &mut dyn Iterator<Item = f64>| of.map(f64::abs).reduce(f64::max);
    let angles = series.iter().flat_map(|(series, _)| {
        std::iter::once(series.mean_rad).chain(series.harmonics.iter().map(|harmonic| harmonic.amplitude_rad))
    });
    judge.hold_if(&range::ANGLE, largest(&mut { angles }));
    let phases = series.iter().flat_map(|(series, lag)| {
        std::iter::once(*lag).chain(series.harmonics.iter().map(|harmonic| harmonic.phase_rad))
    });
    judge.hold_if(&range::PHASE, largest(&mut { phases }));
}

/// The longest of the surfaces of `robot` along its arc, m.
pub(super) fn span(robot: &Robot) -> f64 {
    robot.surfaces().map(|(_, aero)| width(aero)).fold(0.0, f64::max)
}

/// How far the surfaces of `robot` reach from the middle of all, laid end to end, m: those of one side are half a wing each.
pub(super) fn reach(robot: &Robot) -> f64 {
    0.5 * robot.surfaces().map(|(_, aero)| width(aero)).sum::<f64>()
}

fn width(aero: &Aero) -> f64 {
    aero.arcs().last().zip(aero.arcs().first()).map_or(0.0, |(to, from)| (to - from).abs())
}

/// Holds masses and inertias of `robot` against what wings of its span carry, and those of membranes and flaps against their links.
pub(super) fn hold(judge: &mut Judge, robot: &Robot) {
    judge.hold_if(&membrane::MASS, robot.membrane_over_link());
    judge.hold_if(&range::THIN, Some(robot.density()).filter(|density| *density > 0.0));
    judge.hold_if(&flap::MASS, robot.flap_over_link());
    let apart = robot.panels_apart();
    [&range::APART, &range::TORN].into_iter().for_each(|limit| judge.hold_if(limit, apart));
    hold_angles(judge, robot);
    hold_followed(judge, robot);
    link_spar::hold_shape(judge, robot);
    let span = span(robot);
    let bodies = robot.numbers().bodies;
    let (Some(central), true) = (bodies.first(), span > 0.0) else { return };
    let heavy = || bodies.iter().filter(|body| body.mass > 0.0);
    let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    let gyration =
        largest(&mut heavy().map(|b| (b.moments.0.into_iter().fold(0.0, f64::max) / b.mass).sqrt()));
    let least = central.moments.0.into_iter().fold(f64::INFINITY, f64::min);
    judge.hold(&range::GYRATION, gyration / span);
    judge.hold(&range::COMPACT, (least / central.mass).sqrt() / span);
    judge.hold(&range::CENTRE, largest(&mut heavy().map(|body| body.com.norm())) / span);
    judge.hold(&range::LOADING, robot.mass() * GRAVITY / (span * span));
    judge.hold(&range::LINK, largest(&mut bodies[1..].iter().map(|body| body.mass)) / central.mass);
}
