//! What a robot of a file is made into before its flight is searched, and what is said of that.

use super::guess::Size;
use super::numbers;
use crate::{Scenario, ScenarioSpec};
use wingbeat_judge::Warning;
use wingbeat_robot::RobotSpec;

/// Least times the frequency of birds of this size at which a search begins, and most that is searched. *Choices.*
const SLOWEST: f64 = 0.3;
pub(super) const FASTEST: f64 = 3.0;

/// Key of the frequency of the gait.
pub(super) fn frequency_key(spec: &ScenarioSpec) -> String {
    format!("robot.gait.{}.frequency_hz", spec.robot.gait.kind())
}

/// Leaves the motor of `spec` out; the numbers it had.
pub(super) fn without_motor(spec: &mut ScenarioSpec, warnings: &mut Vec<Warning>) -> Vec<(String, f64)> {
    let drive = std::mem::take(&mut spec.robot.drive);
    let Some(name) = drive.given().first().copied() else { return Vec::new() };
    let text = "the motor is left out: the crank turns at a constant rate, as a governed motor would turn it; power is that of the crank";
    let table = format!("robot.drive.{name}");
    warnings.push(Warning::new("trim.motor_left_out", text).key(&table));
    let tables = toml::Table::try_from(drive).unwrap_or_default();
    let numbers = tables.get(name).and_then(toml::Value::as_table).into_iter().flatten();
    let numbers = numbers.filter_map(|(key, value)| Some((key, value.as_float()?)));
    numbers.map(|(key, value)| (format!("{table}.{key}"), value)).collect()
}

/// Begins at the frequency of scaling laws where that of the file is far from it.
pub(super) fn let_flap(spec: &mut ScenarioSpec, size: &Size, warnings: &mut Vec<Warning>) {
    let (own, guess) = (spec.robot.gait.frequency_hz(), size.frequency());
    if own > SLOWEST * guess && own < FASTEST * guess {
        return;
    }
    spec.robot.gait.set_frequency_hz(guess);
    let text = format!(
        "the search begins at {guess:.2} Hz in place of the file's {own:.2} Hz, which is not within {SLOWEST} to {FASTEST} times that of birds \
         of this size"
    );
    let key = frequency_key(spec);
    warnings.push(Warning::new("trim.frequency_replaced", text).size(own / guess).key(key.as_str()));
}

/// Gives the robot of `spec` actuators where those of the `given` one are not the `needed`; their names.
pub(super) fn with_actuators(
    spec: &mut ScenarioSpec,
    given: &Scenario,
    needed: usize,
    warnings: &mut Vec<Warning>,
) -> Vec<String> {
    let Some(why) = numbers::short_of(given, needed) else { return Vec::new() };
    let frequency = spec.robot.gait.frequency_hz();
    let names = numbers::actuated(&mut spec.robot, frequency);
    let text = format!("{why}: actuators are assumed on {}", names.join(", "));
    warnings.push(Warning::new("trim.assumed_actuators", text).key("robot.structure"));
    names
}

/// Longest chord of `robot`, m.
pub(super) fn longest_chord(robot: &RobotSpec) -> f64 {
    let outlines = robot.outlines().unwrap_or_default();
    let chords = outlines.iter().flat_map(|outline| {
        let planform = &outline.planform;
        planform.station_arcs().iter().map(|arc| planform.chord(*arc)).collect::<Vec<_>>()
    });
    chords.fold(0.0, f64::max)
}

/// Instants of a cycle at which it is looked whether a surface moves, and the way that is one, m.
const LOOKS: usize = 7;
const MOVES_M: f64 = 1e-6;

/// Whether the gait moves a surface; one that cannot be posed is refused elsewhere.
pub(super) fn flaps(scenario: &Scenario) -> bool {
    let period = 1.0 / scenario.spec.robot.gait.frequency_hz().max(f64::MIN_POSITIVE);
    let points = |k: usize| {
        let robot = scenario.robot().at_rest(period * k as f64 / LOOKS as f64).ok()?;
        Some(robot.outlines.iter().flat_map(|of| of.ribs.iter().flatten().copied()).collect::<Vec<_>>())
    };
    let Some(first) = points(0) else { return true };
    let moved = |k: usize| {
        let there = points(k)?;
        Some(first.iter().zip(&there).any(|(a, b)| (*a - *b).norm() > MOVES_M))
    };
    (1..LOOKS).any(|k| moved(k).unwrap_or(true))
}
