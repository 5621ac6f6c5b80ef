//! Every number that a shipped document gives acts: moved by a little it changes what the built robot does.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use wingbeat::math::{Quat, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::{Document, Scenario};

/// Tables whose numbers the built robot and its start show; those of the others only flights, plans and orbits show.
const SHOWN: [&str; 4] = ["robot.", "air.", "aero.", "start."];

/// In a vacuum no number of the wings acts: it is looked at in air.
const VACUUM: &str = "reorientation.toml";

/// Scenarios whose middle of the wing is a gap, or where no strip lies on it.
const OPEN: &[&str] = &[
    "aerobat_elastic",
    "aerobat_membrane",
    "any_air_bank15_beta",
    "any_air_bank30_20g",
    "bank15_20g",
    "bank15_20g_lev",
    "bank15_beta",
    "bank15_beta_lev",
    "banking_turn_beta",
    "bounding_20g",
    "cruise_20g",
    "cruise_44g",
    "cruise_44g_lev",
    "cruise_linkage",
    "decelerate",
    "hover_guarded",
    "land_20g",
    "loaded_bank15",
    "passive_20g",
    "passive_20g_margin",
    "passive_bank15",
    "soft_20g",
    "soft_bank15",
];
/// Scenarios whose first station beyond the middle only ends a gap.
const ENDED: &[&str] = &[
    "aerobat_membrane",
    "any_air_bank15_beta",
    "any_air_bank30_20g",
    "bank15_20g",
    "bank15_20g_lev",
    "bank15_beta",
    "bank15_beta_lev",
    "bounding_20g",
    "cruise_20g",
    "cruise_44g",
    "cruise_44g_lev",
    "cruise_linkage",
    "decelerate",
    "hover_guarded",
    "land_20g",
    "loaded_bank15",
    "passive_20g",
    "passive_20g_margin",
    "passive_bank15",
    "soft_20g",
    "soft_bank15",
];
/// Scenarios whose strips do not ride on the panel of the body.
const BARE: &[&str] = &["aerobat_elastic", "banking_turn_beta", "motor_flapper"];
/// Scenarios whose law asks for no suction.
const WITHOUT_LEV: &[&str] = &[
    "aerobat_elastic",
    "aerobat_membrane",
    "any_air_bank15_beta",
    "any_air_bank30_20g",
    "as_printed_fourier",
    "as_printed_linkage",
    "bank15_20g",
    "bank15_beta",
    "banking_turn",
    "banking_turn_beta",
    "banking_turn_stall",
    "bounding_20g",
    "cruise_20g",
    "cruise_44g",
    "cruise_linkage",
    "decelerate",
    "flap_glide",
    "four_wings",
    "glider",
    "hover_guarded",
    "land_20g",
    "loaded_bank15",
    "motor_flapper",
    "paper_turn",
    "paper_turn_clear",
    "paper_turn_one_speed",
    "passive_20g",
    "passive_20g_margin",
    "passive_bank15",
    "reorientation",
    "sail_glide",
    "soft_20g",
    "soft_bank15",
];
/// Scenarios whose law is linear.
const LINEAR: &[&str] = &[
    "aerobat_elastic",
    "as_printed_fourier",
    "as_printed_linkage",
    "banking_turn",
    "flap_glide",
    "glider",
    "paper_turn",
    "paper_turn_clear",
    "paper_turn_one_speed",
    "sail_glide",
];
/// Scenarios with a linkage within the limits of its regulators.
const LINKED: &[&str] = &["as_printed_linkage", "banking_turn_beta", "cruise_linkage", "passive_bank15"];
/// Scenarios of the printed equations without profile drag.
const PRINTED: &[&str] = &["as_printed_fourier", "as_printed_linkage"];
/// Scenarios of the printed equations, which carry no air.
const WITHOUT_CARRIED: &[&str] =
    &["as_printed_fourier", "as_printed_linkage", "paper_turn", "paper_turn_clear", "paper_turn_one_speed"];

/// Numbers that cannot act in a document, by parts that their keys and their document have, with the reason.
const STILL_KEYS: &[(&str, &[&str], &str)] = &[
    (".axis[1]", &[], "a direction has no length"),
    (".axis[2]", &["reorientation"], "a direction has no length"),
    (".direction[", &["flap_glide", "glider", "sail_glide"], "a direction has no length"),
    (".planform[0].", OPEN, "no strip lies there"),
    (".planform[1].arc_m", ENDED, "the edges run straight on where the gap ends"),
    (".cd0", PRINTED, "no profile drag"),
    (".cd90", PRINTED, "no profile drag"),
];

/// Numbers of a robot that cannot act, by the end of their name, with the reason.
const STILL_PARAMETERS: &[(&str, &[&str], &str)] = &[
    (".direction[1]", &[], "a direction has no length"),
    (
        ".direction[2]",
        &[
            "aerobat_elastic",
            "as_printed_fourier",
            "as_printed_linkage",
            "banking_turn_beta",
            "flap_glide",
            "glider",
            "motor_flapper",
            "sail_glide",
        ],
        "no strip rides on the panel, or a direction has no length",
    ),
    (".planform[0].", OPEN, "no strip lies there"),
    (".planform[1].arc_m", ENDED, "the edges run straight on where the gap ends"),
    (".panels.body.origin_m", BARE, "no strip rides on the body"),
    (".critical_suction", WITHOUT_LEV, "the law does not ask for it"),
    (".stall_angle_rad", LINEAR, "the law does not ask for it"),
    (".added_mass_scale", WITHOUT_CARRIED, "no such term"),
    ("_range[", LINKED, "the regulators keep the lengths within the limits that the file gives them"),
    (
        ".driven.lag_rad",
        &["flap_glide", "glider", "reorientation", "sail_glide"],
        "a series without harmonics has no phase",
    ),
    (".driven.harmonics[11].phase_rad", &["bounding_20g"], "three strokes of four have no fourth harmonic"),
];

/// Factors and shifts that cannot act on a robot, with the reason.
const STILL_FACTORS: &[(&str, &[&str], &str)] = &[
    ("profile_drag", PRINTED, "no profile drag"),
    ("broadside_drag", PRINTED, "no profile drag"),
    ("regulator_bandwidth", &["four_wings", "hover_guarded"], "no elements but thrusters, or none"),
    ("gait_amplitude", &["flap_glide", "glider", "reorientation", "sail_glide"], "nothing flaps"),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios")
}

/// Shipped scenarios, of each robot, preset and law one.
static SCENARIOS: LazyLock<Vec<(String, Document)>> = LazyLock::new(|| {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder()).unwrap().map(|file| file.unwrap().path()).collect();
    files.sort();
    let mut seen = BTreeSet::new();
    let mut all = Vec::new();
    for file in files {
        let mut document = Document::file(&file).unwrap();
        if file.ends_with(VACUUM) {
            document = document.set("air.density_kg_m3=1.225");
        }
        let scenario = Scenario::new(document.clone()).unwrap();
        let spec = &scenario.spec;
        let make = format!("{} {:?} {:?}", spec.robot.name, spec.aero.preset, spec.aero.law);
        if seen.insert(make) {
            // With what the file includes.
            let name = file.file_stem().unwrap().to_string_lossy().into_owned();
            all.push((name, Document::text(&file.to_string_lossy(), &scenario.resolved).unwrap()));
        }
    }
    all
});

/// A state somewhere in flight, elements displaced and all else moving.
fn flying(robot: &Robot, t: f64) -> Vec<f64> {
    let l = *robot.layout();
    let mut x = vec![0.0; l.len];
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
    let start = robot.start_coordinates();
    x[l.joints..][..start.len()].copy_from_slice(&start);
    for (i, (state, channel)) in x.iter_mut().zip(robot.states()).enumerate().skip(l.structure) {
        let size = if i < l.joints && channel.unit.starts_with('m') { 2e-4 } else { 0.12 };
        *state += size * (1.7 * (i - l.structure) as f64 + 40.0 * t).sin();
    }
    x
}

/// Looks at a robot: as it is built, and at three instants of a flight.
const LOOKS: usize = 4;

/// What the look `of` sees of a robot, to the last bit.
fn look(robot: &Robot, of: usize) -> String {
    let Some(t) = of.checked_sub(1).map(|instant| [0.013, 0.05, 0.087][instant]) else {
        let built = format!("{:?} {:?} {:?}", robot.inputs(), robot.strokes(), robot.start_coordinates());
        return built + &format!("{:?}", robot.wind_over_time());
    };
    let u: Vec<f64> =
        robot.inputs().iter().enumerate().map(|(i, u)| u.clamp(0.02 * (1.0 + i as f64))).collect();
    let x = flying(robot, t);
    let mut dx = vec![0.0; x.len()];
    match (robot.rates_in_numbers(t, &x, &u, &mut dx), robot.observe(t, &x, &u)) {
        (Ok(()), Ok(observed)) => format!("{dx:?} {observed:?}"),
        (rates, observed) => format!("{rates:?} {:?}", observed.map(drop)),
    }
}

/// All that is seen of a robot.
fn looks(robot: &Robot) -> Vec<String> {
    (0..LOOKS).map(|of| look(robot, of)).collect()
}

/// Whether a robot is seen as `own` was, to the last bit; it is looked at until it differs, in flight first.
fn is_seen_as(own: &[String], robot: &Robot) -> bool {
    (0..LOOKS).rev().all(|of| look(robot, of) == own[of])
}

/// All that is seen of what a scenario builds.
struct Built {
    robot: Vec<String>,
    model: Vec<String>,
    start: String,
}

impl Built {
    fn of(scenario: &Scenario) -> Self {
        let start = format!("{:?}", scenario.start());
        Self { robot: looks(scenario.robot()), model: looks(scenario.model()), start }
    }

    fn is_that_of(&self, other: &Scenario) -> bool {
        self.start == format!("{:?}", other.start())
            && is_seen_as(&self.robot, other.robot())
            && is_seen_as(&self.model, other.model())
    }
}

/// The value moved by 1 %, a zero by a hundredth of what is usual, a whole number by 1.
fn moved(text: &str) -> String {
    let value: f64 = text.replace('_', "").parse().unwrap();
    match text.contains(['.', 'e', 'E']) {
        false => format!("{}", value + 1.0),
        true if value == 0.0 => "0.001".into(),
        true => format!("{:?}", 1.01 * value),
    }
}

/// Whether the reviewed list holds `what` of the document.
fn listed(list: &[(&str, &[&str], &str)], what: &str, document: &str) -> bool {
    list.iter().any(|(part, documents, _)| {
        what.contains(part) && (documents.is_empty() || documents.contains(&document))
    })
}

#[test]
fn every_number_of_every_robot_acts_as_key() {
    let mut silent = Vec::new();
    for (name, document) in SCENARIOS.iter() {
        let own = Built::of(&Scenario::new(document.clone()).unwrap());
        for key in document.numbers() {
            if !SHOWN.iter().any(|table| key.starts_with(table)) {
                continue;
            }
            let text = document.written(&key).unwrap().0;
            let other = Scenario::new(document.clone().set(format!("{key}={}", moved(&text))));
            // A refusal tells of the number, too.
            if other.is_ok_and(|other| own.is_that_of(&other)) && !listed(STILL_KEYS, &key, name) {
                silent.push(format!("{name}: {key} = {text}"));
            }
        }
    }
    assert!(silent.is_empty(), "{} numbers are silent:\n{}", silent.len(), silent.join("\n"));
}

#[test]
fn every_number_of_every_robot_acts_as_parameter() {
    let mut silent = Vec::new();
    for (name, document) in SCENARIOS.iter() {
        let scenario = Scenario::new(document.clone()).unwrap();
        let robot = scenario.robot();
        let own = looks(robot);
        let mut names = BTreeSet::new();
        for number in robot.parameters() {
            if !names.insert(number.name.clone()) {
                continue;
            }
            let value = if number.value == 0.0 { 1e-3 } else { 1.01 * number.value };
            let other = robot.adjusted(&[(&number.name, value)]);
            if other.is_ok_and(|other| is_seen_as(&own, &other))
                && !listed(STILL_PARAMETERS, &number.name, name)
            {
                silent.push(format!("{name}: {} = {}", number.name, number.value));
            }
        }
    }
    assert!(silent.is_empty(), "{} numbers are silent:\n{}", silent.len(), silent.join("\n"));
}

#[test]
fn every_factor_of_a_mismatch_acts() {
    let mut silent = Vec::new();
    for (name, document) in SCENARIOS.iter() {
        let own = looks(Scenario::new(document.clone()).unwrap().robot());
        for factor in [
            "density=1.01",
            "mass=1.01",
            "inertia=1.01",
            "com_x_m=0.001",
            "com_y_m=0.001",
            "com_z_m=0.001",
            "gait_amplitude=1.01",
            "regulator_bandwidth=1.01",
            "stiffness=1.01",
            "profile_drag=1.01",
            "broadside_drag=1.01",
        ] {
            let other = Scenario::new(document.clone().set(format!("mismatch.{factor}")));
            if other.is_ok_and(|other| is_seen_as(&own, other.robot()))
                && !listed(STILL_FACTORS, factor, name)
            {
                silent.push(format!("{name}: {factor}"));
            }
        }
    }
    assert!(silent.is_empty(), "{} factors are silent:\n{}", silent.len(), silent.join("\n"));
}
