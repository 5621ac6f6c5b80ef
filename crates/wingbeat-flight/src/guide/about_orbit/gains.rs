//! The feedback that holds an orbit, as a table.

use super::feedback::{DEVIATIONS, Feedback};
use super::spec::OrbitWeights;
use crate::orbit::{Cycle, Deviations, Interval, Orbit, OrbitSection};
use std::fmt::Write;
use wingbeat_ocp::plant::Plant;

/// Units of the integral of the height, the height and the coordinates of the body.
const UNITS: [&str; DEVIATIONS + Deviations::BODY] =
    ["m s", "m", "m/s", "m/s", "m/s", "rad", "rad", "rad/s", "rad/s", "rad/s"];

/// The feedback that holds an orbit.
#[derive(Clone, Debug)]
pub struct HoldingGains {
    /// Gains.
    pub table: String,
    /// Largest multiplier of a deviation over a cycle under this feedback, dimensionless.
    pub multiplier: f64,
}

/// The inputs that the feedback about an orbit of `cycle` has: all that displace an element at rest, but that of the crank.
pub fn holding_inputs(cycle: &Cycle) -> Vec<usize> {
    let (robot, deviations) = (cycle.robot(), Deviations::new(cycle));
    let (commands, rest) = (robot.inputs().len(), robot.rest_gains());
    let moves =
        |input: &usize| deviations.moved().iter().any(|element| rest[element * commands + input] != 0.0);
    (0..commands).filter(moves).collect()
}

/// The periodic controller about `orbit` by its [`holding_inputs`], as comma-separated values: of every phase (share of the cycle) a row for each
/// input, of every deviation that is fed back a column with its unit. The command is that of the orbit less the sum of gains times
/// deviations. `all` are the intervals between these phases, with the derivatives by these inputs. None where nothing is fed back or
/// the controller does not settle.
pub fn gains_of(
    cycle: &Cycle,
    orbit: &Orbit,
    inputs: &[usize],
    all: &[Interval],
    weights: &OrbitWeights,
) -> Option<HoldingGains> {
    if inputs.is_empty() {
        return None;
    }
    let robot = cycle.robot();
    let deviations = Deviations::new(cycle);
    let (elements, from) = (deviations.moved(), DEVIATIONS + deviations.elements_from());
    let limits: Vec<f64> = inputs.iter().map(|i| robot.inputs()[*i].high).collect();
    let (coordinates, parts) = (cycle.section().len(), all.len());
    let feedback = Feedback::new(weights, None, all, coordinates, &limits, orbit.end.duration, None)?;
    let mut told: Vec<(usize, String)> = Vec::new();
    let body = cycle.section().names().iter().take(OrbitSection::BODY).map(String::as_str);
    for (column, name) in ["height_integral", "height"].into_iter().chain(body).enumerate() {
        told.push((column, format!("{name} [{}]", UNITS[column])));
    }
    let (structure, strokes) = (robot.layout().structure, robot.strokes().len());
    for (rates, offset) in [(0, 0), (elements.len(), strokes)] {
        for (k, element) in elements.iter().enumerate() {
            let channel = &robot.states()[structure + offset + element];
            let unit = if channel.unit.is_empty() { "1" } else { channel.unit };
            told.push((from + rates + k, format!("{} [{unit}]", channel.name)));
        }
    }
    let mut table = String::from("phase,input");
    told.iter().for_each(|(_, name)| table += &format!(",{name}"));
    table += "\n";
    for phase in 0..parts {
        let gain = feedback.at(phase as f64 / parts as f64);
        for (row, &input) in inputs.iter().enumerate() {
            let _ = write!(table, "{},{}", phase as f64 / parts as f64, robot.inputs()[input].name);
            for (column, _) in &told {
                let _ = write!(table, ",{:e}", gain[(row, *column)]);
            }
            table += "\n";
        }
    }
    Some(HoldingGains { table, multiplier: feedback.multiplier(all) })
}
