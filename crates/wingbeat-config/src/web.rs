//! What a run says of webs that no model has, and of twists that nothing spreads over a length of the span.

use super::HingeSpec;
use wingbeat_aero::{Aero, Preset};
use wingbeat_flight::tether::HingeKind;
use wingbeat_judge::Warning;
use wingbeat_math::{Jet, Mat3, Vec3};
use wingbeat_robot::{BodyMotion, Robot, RobotSpec};

/// At how many instants of a cycle panels are looked at. Choice.
const LOOKS: usize = 16;
/// Sine of the angle about the span from which on panels beside one another count as twisted. Choice.
const TWISTED: f64 = 0.02;
/// How far a state of the structure is displaced to see what it turns, rad, m or parts of a stroke. Choice.
const DISPLACED: f64 = 0.1;
/// How far beside a hinge a chord line is taken, in parts of its panel, so that a hinge which `numbers` moves stays between. Choice.
const BESIDE: f64 = 0.1;

/// The warning that a twist is open at `key`: without a web the shipped gaits took 6 to 30 % more power with 32 strips than with 9
/// (`robot.web`).
fn open_twist(key: String) -> Warning {
    let text = "the strip beside a twist closes it within its own width, so loads and power depend on the number of strips: without a web the shipped gaits took 6 to 30 % more power with 32 than with 9";
    Warning::new("aero.open_twist", text.to_owned()).key(key)
}

/// The warning that a twist of `robot`, which was built of `spec`, is open: chords of panels beside one another turn about the span, on
/// strips and without a web.
pub(super) fn open(spec: &RobotSpec, robot: &Robot) -> Option<Warning> {
    robot.surfaces().enumerate().find_map(|(number, (name, aero))| {
        let surface = spec.surfaces.iter().find(|surface| surface.name == name)?;
        let planform = surface.outline().ok().filter(|_| aero.preset() == Preset::Full)?;
        let ends = surface.panels.iter().map(|panel| panel.from_arc_m);
        let ends: Vec<f64> = ends.chain(surface.planform.last().map(|station| station.arc_m)).collect();
        let twists = |k: &usize| {
            let [before, hinge, beyond] = [k - 1, *k, k + 1].map(|k| ends[k]);
            let beside = [before, beyond].map(|end| planform.coordinates(hinge + BESIDE * (end - hinge)));
            beside[0].iter().zip(&beside[1]).any(|(inner, outer)| turns(robot, number, [*inner, *outer]))
        };
        let k = (1..surface.panels.len()).find(|k| surface.panels[*k].web_m == 0.0 && twists(k))?;
        Some(open_twist(format!("robot.surfaces.{name}.panels[{k}].web_m")))
    })
}

/// Whether the chord lines at `arcs` (m) of the surface number `surface` are turned about the span against one another over the gait, or
/// with one of the states of the structure displaced.
fn turns(robot: &Robot, surface: usize, arcs: [f64; 2]) -> bool {
    let (still, layout, frequency) = (robot.carried_still(), robot.layout(), robot.frequency_hz());
    let period = if frequency > 0.0 { frequency.recip() } else { 0.0 };
    let over_the_gait = (0..LOOKS).map(|k| (period * k as f64 / LOOKS as f64, None));
    let displaced = (0..layout.aero - layout.structure).map(|i| (0.0, Some(i)));
    let mut lines = Vec::new();
    over_the_gait.chain(displaced).any(|(t, state)| {
        let mut x = still.clone();
        state.into_iter().for_each(|i: usize| x[i] += DISPLACED);
        let (clock, body) = (Jet::new(t, 1.0, 0.0), BodyMotion::steady(Mat3::IDENTITY, Vec3::ZERO));
        let stance = robot.carried_stance(&clock, Vec3::ZERO, &body, &x);
        robot.chord_lines(&stance, surface, &arcs, &mut lines).is_ok_and(|()| {
            let [inner, outer] = [0, 1].map(|i| (lines[i].te - lines[i].le).unit());
            inner.cross(outer).dot(lines[1].span).abs() > TWISTED
        })
    })
}

/// The warning that a web of `robot`, which was built of `spec`, has no effect: nodes of preset `paper` ride on rigid panels.
pub(super) fn unheard(spec: &RobotSpec, robot: &Robot) -> Option<Warning> {
    spec.surfaces.iter().find_map(|surface| {
        let (_, aero) = robot.surfaces().find(|(name, _)| *name == surface.name)?;
        let preset = Some(aero.preset()).filter(|preset| *preset != Preset::Full)?;
        let k = surface.panels.iter().position(|panel| panel.web_m > 0.0)?;
        let key = format!("robot.surfaces.{}.panels[{k}].web_m", surface.name);
        let text = format!(
            "{key} = {} has no effect: preset `{}` lacks the term",
            surface.panels[k].web_m,
            preset.name()
        );
        Some(Warning::new("aero.unheard", text).key(key))
    })
}

/// That of a tethered wing: a twist out on the half wing that does not grow along the span.
pub(super) fn of_hinges(hinges: &[HingeSpec], model: &Aero) -> Option<Warning> {
    let open =
        |hinge: &HingeSpec| hinge.kind == HingeKind::Twist && hinge.to_arc_m.is_none() && hinge.arc_m > 0.0;
    let k = hinges.iter().position(open).filter(|_| model.preset() == Preset::Full)?;
    Some(open_twist(format!("wing.hinges[{k}].to_arc_m")))
}
