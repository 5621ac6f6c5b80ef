//! Numbers of a robot that a trim may choose, and actuators where the robot has none.

use super::super::search::VarySpec;
use crate::{Scenario, ScenarioSpec};
use std::collections::BTreeSet;
use wingbeat_flight::orbit::Free;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::{
    DrivenSpec, ElementSpec, GaitSpec, LinkSide, LinkSpec, Robot, RobotSpec, StructureSpec,
};

/// How far means of joints, phases and settings may be moved, rad and deg. *Choices.*
const MEAN: f64 = 0.5;
const PHASE: f64 = 1.0;
const SET_DEG: f64 = 15.0;
/// Smallest and largest stroke of a joint that flaps, and largest of one that twists, rad. *Choices.*
const STROKE: [f64; 2] = [0.25, 1.15];
const TWIST: f64 = 0.785;
/// By which factor a spring may be softer or stiffer. *Choice.*
const SPRING: f64 = 3.0;
/// How far the centre of mass may be moved along the body, as a share of the longest chord. *Choice.*
const SHIFT: f64 = 0.3;

/// Actuators that are assumed: second order, their ranges as those of the shipped robots. *Choices.*
const FREQUENCY_HZ: f64 = 12.0;
const DAMPING: f64 = 0.8;
const SCALE: f64 = 0.4;
const MOVE: f64 = 0.4;
const CRANK: f64 = 0.5;
/// Elements that a robot is given at most.
const MOST: usize = 12;

/// Whether the joint of `link` turns about the span.
fn twists(link: &LinkSpec) -> bool {
    let size = link.axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    link.axis[1].abs() > 0.7 * size
}

/// Whether a panel of a surface rides on `link`.
fn carries(robot: &RobotSpec, link: &LinkSpec) -> bool {
    robot.surfaces.iter().flat_map(|surface| &surface.panels).any(|panel| panel.link == link.name)
}

/// A range about `own`, which it holds whatever `low` and `high` are.
fn about(key: String, own: f64, low: f64, high: f64) -> VarySpec {
    VarySpec { key, low: low.min(own), high: high.max(own) }
}

/// Ranges of the numbers of one series at `key`; the phase of `first`, to which the others are seen, stays.
fn of_series(key: &str, series: &DrivenSpec, twist: bool, first: bool, all: &mut Vec<VarySpec>) {
    let mean = series.mean_rad;
    all.push(about(format!("{key}.mean_rad"), mean, mean - MEAN, mean + MEAN));
    let Some(harmonic) = series.harmonics.first() else { return };
    let own = harmonic.amplitude_rad;
    let [low, high] = if twist { [0.0, TWIST] } else { STROKE };
    let (low, high) = if own < 0.0 { (-high, -low) } else { (low, high) };
    all.push(about(format!("{key}.harmonics[0].amplitude_rad"), own, low, high));
    if !first {
        let own = harmonic.phase_rad;
        all.push(about(format!("{key}.harmonics[0].phase_rad"), own, own - PHASE, own + PHASE));
    }
}

/// What of `robot` may be chosen, each within its range; `chord` is the longest, m.
pub(super) fn numbers(robot: &RobotSpec, chord: f64) -> Vec<VarySpec> {
    let mut all = Vec::new();
    let mut first = true;
    if let GaitSpec::Fourier { shoulder, elbow, .. } = &robot.gait {
        for (name, series) in [("shoulder", shoulder), ("elbow", elbow)] {
            let Some(series) = series else { continue };
            let driven = DrivenSpec {
                mean_rad: series.mean_rad,
                harmonics: series.harmonics.clone(),
                ..DrivenSpec::default()
            };
            of_series(&format!("robot.gait.fourier.{name}"), &driven, false, first, &mut all);
            first = false;
        }
    }
    if let GaitSpec::Linkage { dimensions, .. } = &robot.gait {
        let own = dimensions.turned_deg;
        all.push(about("robot.gait.linkage.dimensions.turned_deg".into(), own, own - 60.0, own + 60.0));
    }
    for (i, link) in robot.links.iter().enumerate() {
        let key = format!("robot.links[{i}]");
        if let Some(driven) = link.driven.as_ref().filter(|driven| driven.linkage.is_none()) {
            of_series(&format!("{key}.driven"), driven, twists(link), first, &mut all);
            first &= driven.harmonics.is_empty();
        } else if let Some(elastic) = &link.elastic {
            let (rest, spring) = (elastic.rest, elastic.stiffness);
            all.push(about(format!("{key}.elastic.rest"), rest, rest - MEAN, rest + MEAN));
            all.push(about(format!("{key}.elastic.stiffness"), spring, spring / SPRING, spring * SPRING));
        }
        // The angle at which a tail, or a wing whose joint does not twist, is set.
        let set = link.elastic.is_none() && !link.free && !twists(link);
        if set && link.parent == "body" && carries(robot, link) {
            let own = link.orientation_deg[1];
            all.push(about(format!("{key}.orientation_deg[1]"), own, own - SET_DEG, own + SET_DEG));
        }
    }
    let own = robot.body.com_m[0];
    all.push(about("robot.body.com_m[0]".into(), own, own - SHIFT * chord, own + SHIFT * chord));
    all
}

/// An element that is assumed.
fn element(name: String, moves: &[String], scales: &[String], range: f64) -> ElementSpec {
    let mut element = ElementSpec::default();
    (element.name, element.moves, element.scales) = (name, moves.to_vec(), scales.to_vec());
    (element.low, element.high) = (Some(-range), Some(range));
    element
}

/// Gives `robot` actuators on all its joints, and a tail that turns, in place of what it has; their names.
pub(super) fn actuated(robot: &mut RobotSpec, frequency: f64) -> Vec<String> {
    let tails: BTreeSet<String> = (robot.links.iter())
        .filter(|link| {
            let still = link.driven.is_none() && link.elastic.is_none() && !link.free;
            still && link.side == LinkSide::Single && carries(robot, link)
        })
        .map(|link| link.name.clone())
        .collect();
    let mut elements = Vec::new();
    let mut names = Vec::new();
    let sides = |name: &str| [format!("{name}_left"), format!("{name}_right")];
    let mut pair = |name: &str, joint: &str, scale: bool| {
        let range = if scale { SCALE } else { MOVE };
        for (name, joint) in sides(name).into_iter().zip(sides(joint)) {
            let (moves, scales) = if scale { (vec![], vec![joint]) } else { (vec![joint], vec![]) };
            elements.push(element(name, &moves, &scales, range));
        }
        names.push(name.to_string());
    };
    if robot.wing.is_some() {
        pair("shoulder_stroke", "shoulder", true);
        pair("twist", "twist", false);
        pair("elbow", "elbow", false);
    }
    for link in robot.links.iter().filter(|link| link.side == LinkSide::Mirrored) {
        let flaps = link.driven.as_ref().is_some_and(|driven| !driven.harmonics.is_empty());
        if flaps && link.parent == "body" {
            pair(&format!("{}_stroke", link.name), &link.name, true);
        }
        if flaps && link.parent == "body" || twists(link) && (flaps || link.elastic.is_some()) {
            pair(&link.name, &link.name, false);
        }
    }
    for link in robot.links.iter_mut().filter(|link| link.side == LinkSide::Single) {
        if tails.contains(&link.name) {
            link.axis = [0.0, 1.0, 0.0];
            link.driven = Some(DrivenSpec::default());
        }
        if link.driven.as_ref().is_some_and(|driven| driven.harmonics.is_empty()) {
            elements.push(element(link.name.clone(), std::slice::from_ref(&link.name), &[], MOVE));
            names.push(link.name.clone());
        }
    }
    elements.truncate(MOST);
    let crank = CRANK * std::f64::consts::TAU * frequency;
    // Without a driven joint there is no crank.
    if robot.wing.is_some() || robot.links.iter().any(|link| link.driven.is_some()) {
        elements.push(element("crank".into(), &["crank".into()], &[], crank));
    }
    robot.structure = StructureSpec {
        frequency_hz: Some(FREQUENCY_HZ),
        damping: Some(DAMPING),
        elements,
        ..StructureSpec::default()
    };
    names
}

/// Takes the held commands of `spec` over into the numbers of the joints that their elements displace, where each has a link of its
/// own: means, amplitudes, rests of springs. What is held on either side of a mirrored link is its mean; the rest stays a command.
pub(super) fn fold(spec: &mut ScenarioSpec) {
    let structure = spec.robot.structure.clone();
    if !structure.regulators.is_empty() {
        return;
    }
    let commands = spec.start.commands.clone();
    let held = |name: &str| commands.get(&format!("command_{name}")).copied();
    for element in &structure.elements {
        let (joint, scales) = match (&element.moves[..], &element.scales[..]) {
            ([joint], []) => (joint, false),
            ([], [joint]) => (joint, true),
            _ => continue,
        };
        // Of a pair the left one stands for both.
        let (link, value) = match (joint.strip_suffix("_left"), element.name.strip_suffix("_left")) {
            (Some(link), Some(name)) => {
                let sides =
                    [held(&element.name), held(&format!("{name}_right"))].map(|side| side.unwrap_or(0.0));
                (link, 0.5 * (sides[0] + sides[1]))
            }
            (None, _) if !joint.ends_with("_right") => (joint.as_str(), held(&element.name).unwrap_or(0.0)),
            _ => continue,
        };
        let Some(link) = spec.robot.links.iter_mut().find(|other| other.name == link) else { continue };
        match (&mut link.driven, &mut link.elastic) {
            (Some(driven), _) if driven.linkage.is_none() => match scales {
                true => driven.harmonics.iter_mut().for_each(|h| h.amplitude_rad *= 1.0 + value),
                false => driven.mean_rad += value,
            },
            (_, Some(elastic)) if !scales => elastic.rest += value,
            _ => continue,
        }
        let left = element.name.strip_suffix("_left");
        let names = left.map_or(vec![element.name.clone()], |name| {
            ["left", "right"].map(|s| format!("{name}_{s}")).to_vec()
        });
        for name in names {
            let held = spec.start.commands.entry(format!("command_{name}")).or_insert(0.0);
            *held -= value;
            if held.abs() < 1e-12 {
                spec.start.commands.remove(&format!("command_{name}"));
            }
        }
    }
}

/// Why the actuators of a scenario's robot are not the `needed` ones; none where they are.
pub(super) fn short_of(scenario: &Scenario, needed: usize) -> Option<String> {
    let model = scenario.model();
    if let Err(error) = model.pairs() {
        return (!scenario.spec.robot.structure.elements.is_empty()).then(|| error.to_string());
    }
    let sides = model.inputs().iter().filter(|input| !input.name.ends_with("_crank")).count();
    (sides < needed).then(|| format!("{needed} actuators are needed and the robot has {sides}"))
}

/// What an orbit may choose of `robot`: the frequency first, then pairs of actuators, or all.
pub(super) fn free(robot: &Robot) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in Free::names(robot).into_iter().filter(|name| name != "crank") {
        let pair = ["_left", "_right"].iter().find_map(|side| name.strip_suffix(side)).unwrap_or(&name);
        if !names.iter().any(|other| other == pair) {
            names.push(pair.to_string());
        }
    }
    names
}

/// Whether the element `name` of `robot` turns a single link about an axis in the plane of symmetry, as a rudder.
pub(super) fn acts_across(robot: &RobotSpec, name: &str) -> bool {
    let element = robot.structure.elements.iter().find(|element| element.name == name);
    let moved = element.map_or(&[][..], |element| &element.moves[..]);
    let single = |link: &&LinkSpec| link.side == LinkSide::Single && moved.contains(&link.name);
    robot.links.iter().find(single).is_some_and(|link| !twists(link))
}

/// The same as numbers of inputs.
pub(super) fn all_free(robot: &Robot, each: bool) -> Vec<Free> {
    free(robot).iter().filter_map(|name| Free::named(robot, name, each)).flatten().collect()
}
