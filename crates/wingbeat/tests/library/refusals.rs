//! Every number of every shipped document set to what it should not be: what has a meaning builds, what has none is
//! refused by the key and the place of who wrote it. Nothing panics.

use std::collections::BTreeSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use wingbeat::parallel;
use wingbeat::scenario::{ConfigError, Document, RigRun, Scenario, Sweep, TetherCase, ValuePlace};
use wingbeat::simulate::{Column, Record};

/// What a number may be set to, and have a meaning.
const NUMBERS: [&str; 4] = ["-1", "0", "1e-9", "900000000000"];
/// What none may be.
const NEVER: [&str; 7] = ["nan", "-inf", "1e300", "\"text\"", "[]", "true", "{}"];
/// Ends of keys of what is never below zero, with the keys that are exceptions.
const NOT_NEGATIVE: [&str; 9] = [
    "mass_kg",
    "density_kg_m3",
    "frequency_hz",
    "length_m",
    "step_s",
    "duration_s",
    "cd0",
    "_within_deg",
    "rate_hz",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The documents in a folder.
fn documents(folder: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{folder}");
    paths
}

type Build = fn(Document) -> Result<(), ConfigError>;

fn scenario(document: Document) -> Result<(), ConfigError> {
    Scenario::new(document).map(drop)
}

fn tether(document: Document) -> Result<(), ConfigError> {
    TetherCase::new(document, &|_| Ok(Record::new(vec![Column::new("t", "s", "")], 0).unwrap())).map(drop)
}

fn rig(document: Document) -> Result<(), ConfigError> {
    RigRun::new(document, &|_, _| None).map(drop)
}

fn sweep(document: Document) -> Result<(), ConfigError> {
    Sweep::new(document, &|_| Err("no tables".into())).map(drop)
}

/// Folders of documents, what builds them, the keys that name files.
const KINDS: [(&str, Build, &[&str]); 5] = [
    ("scenarios", scenario, &["robot"]),
    ("cases", tether, &[]),
    ("rigs/runs", rig, &["rig", "rig.robot", "rig.arm"]),
    ("rigs/identification", rig, &["rig", "rig.robot", "rig.arm"]),
    ("sweeps", sweep, &[]),
];

/// Documents with the tables that no shipped one has: a file, and what is set in it.
const TABLES: [(&str, &[&str]); 15] = [
    (
        "scenarios/glider.toml",
        &[
            "lattice={step_s=0.004, chordwise=4, spanwise=24, free_wake=true, core_chords=0.05, longest_age_s=2.0}",
        ],
    ),
    (
        "rigs/runs/bench.toml",
        &[
            "lattice={step_s=0.004, chordwise=4, spanwise=24, free_wake=true, core_chords=0.05, longest_age_s=2.0}",
        ],
    ),
    ("scenarios/path_figure8.toml", &["path.curve={line={length_m=30.0}}"]),
    (
        "scenarios/predictive_figure8.toml",
        &["controller.orbit.predictive={intervals=5, interval_s=0.009, iterations=2, deadline_s=0.005, \
             terminal=\"none\", command_change=0.1, clearance=100.0, clearance_m=0.01, clearance_width_m=0.001, \
             cross_m=0.1, along_m=0.3}"],
    ),
    ("scenarios/path_figure8.toml", &["path.curve={lane_change={length_m=10.0, aside_m=-1.5}}"]),
    (
        "scenarios/path_figure8.toml",
        &["path.curve={helix={radius_m=-5.0, turns=2.0, rise_m=3.0}}", "controller.orbit.climb_m_s=0.1"],
    ),
    (
        "scenarios/path_figure8.toml",
        &["path.curve={points={points_m=[[10.0, 1.0, 0.2], [20.0, -1.0, 0.0], [30.0, 0.5, 0.1]]}}"],
    ),
    (
        "scenarios/bank15_20g.toml",
        &[
            "controller.orbit.climb_m_s=0.1",
            "controller.orbit.legs=[{start_s=1.0, duration_s=1.0, speed_m_s=4.2, climb_m_s=0.0}, \
             {start_s=2.5, duration_s=1.0, bank_deg=10.0}]",
            "controller.orbit.weights={height_m=0.02, height_integral_m_s=0.03, velocity_m_s=0.4, angle_deg=5.0, \
             rate_rad_s=4.0}",
        ],
    ),
    (
        "scenarios/banking_turn.toml",
        &[
            "seed=3",
            "air.gust_m_s=0.1",
            "aero.stall_angle_deg=13.0",
            "aero.paper.chord_floor_m=0.01",
            "aero.full={strips=16, regularisation_m_s=0.1}",
            "mismatch={density=1.1, mass=1.1, inertia=1.1, com_x_m=0.001, com_y_m=0.001, com_z_m=0.001, \
             gait_amplitude=1.1, regulator_bandwidth=1.1, profile_drag=1.1, \
             aero={law=\"stall\", stall_angle_deg=13.0, full={strips=16, regularisation_m_s=0.1}}}",
            "sensors={position_m=0.1, attitude_deg=0.5, velocity_m_s=0.1, rate_rad_s=0.1, displacement=0.01, \
             delay_updates=1}",
            "controller.deadline_s=0.004",
            "controller.input_rate_per_s={command_shoulder_left=10.0}",
            "controller.weights.input_change=0.1",
            "controller.weights.terminal=2.0",
            "manoeuvre.track={time_s=[0.0, 0.5, 1.0], roll_rad=[0.0, 0.1, 0.2], pitch_rad=[0.0, 0.1, 0.2], \
             rate_rad_s=[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]]}",
        ],
    ),
    (
        "scenarios/glide.toml",
        &[
            "robot.gait.linkage.dimensions={l1_m=0.0075, l2a_m=0.035, l2b_m=0.0040957602, l2c_m=0.0028678822, \
           l3a_m=0.05, l3b_m=0.00671, l3c_m=0.006, a3_deg=-15.0, l4_m=0.036, l5a_m=0.01118, l5b_m=0.01, \
           l5c_m=0.07878, l5d_m=-0.00389, l6_m=0.036, l7a_m=0.09, l7b_m=0.035, l7c_m=0.015, \
           p1_m=[-0.01, -0.0098], p5_m=[0.0206732377, 0.0075244432], p8_m=[0.0092976018, 0.0199387714], \
           l3b_range=[0.876, 3.0], l5a_range=[0.876, 1.648], l5b_range=[0.876, 1.166]}",
        ],
    ),
    (
        "scenarios/banking_turn_beta.toml",
        &[
            "robot.drive.motor={torque_constant_n_m_a=1.5e-3, resistance_ohm=1.0, supply_v=3.7, gear_ratio=60.0, \
             efficiency=0.8, rotor_inertia_kg_m2=3e-9, crank_inertia_kg_m2=1e-6}",
            "robot.structure={stiffness_per_s2=[[5000.0, 10.0], [10.0, 5000.0]], \
             damping_per_s=[[100.0, 1.0], [1.0, 100.0]], elements=[{name=\"left\", moves=[\"l5a_left\"]}, \
             {name=\"right\", moves=[\"l5a_right\"]}], \
             regulators=[{name=\"fold\", elements={left=1.0, right=0.9}}]}",
        ],
    ),
    (
        "scenarios/least_power_gait.toml",
        &[
            "robot.structure={a=[[0.0, 1.0], [-5000.0, -100.0]], b=[[0.0], [5000.0]], \
             elements=[{name=\"left\", moves=[\"shoulder_left\"], low=-0.3, high=0.3}]}",
            "plan.least_power.trim_within_n_m=0.001",
            "plan.least_power.order=6",
            "aero.preset=full",
            "robot.wing.gaps=[{from_arc_m=0.05, to_arc_m=0.06}]",
        ],
    ),
    (
        "cases/aerobat_stand.toml",
        &[
            "reference={speed_m_s=0.8, area_m2=0.04, chord_m=0.1}",
            "compare={frequency_hz=3.5, scale={force_z=-1e-3}}",
            "wing.gaps=[{from_arc_m=0.03, to_arc_m=0.04}, {from_arc_m=0.09, to_arc_m=0.1}]",
            "aero.full.strips=24",
            "wing.hinges[1]={name=\"elbow\", kind=\"twist\", arc_m=0.0707, to_arc_m=0.15, ahead_m=0.01, \
             angle_deg={constant=3.0}}",
            "wind.sideslip_deg=3.0",
            "body={surge_m={constant=0.1}, heave_m={fourier={mean=0.1, cos=[0.1], sin=[0.1]}}, \
             roll_deg={constant=3.0}, pitch_axis_ahead_m=0.01}",
        ],
    ),
    (
        "rigs/runs/bench.toml",
        &[
            "profile=urdf",
            "wind_m_s=[-1.0, 0.0, 0.0]",
            "frequency_hz=2.0",
            "process={bins=100, window_s=[0.5, 2.0], steps={cutoff_multiple=8.0}, input={counts_per_newton=1e6, \
             counts_per_newton_metre=1e6, rate_hz=7000.0, start_s=4.0, bridge_samples=3}}",
        ],
    ),
    (
        "sweeps/banking_turn_robustness.toml",
        &["seed=2", "hold.height_within_m=0.1", "hold.clearance_m=0.001"],
    ),
];

/// One number of one document.
struct Leaf {
    document: Document,
    build: Build,
    key: String,
}

/// The text in which a value stands.
fn origin(place: &ValuePlace) -> PathBuf {
    match place {
        ValuePlace::Line(file, _) => file.clone(),
        ValuePlace::Override(text) => text.into(),
        other => panic!("{other}"),
    }
}

/// Every number, once, although several documents name the same robot or arm.
///
/// With `every` each place of each file; else one of each key, whatever its file and its place in a list: what refuses it is
/// the same.
fn leaves(every: bool) -> Vec<Leaf> {
    let mut found: Vec<(&str, Document, Build, &[&str])> = Vec::new();
    for (folder, build, includes) in KINDS {
        found.extend(
            documents(folder).iter().map(|path| (folder, Document::file(path).unwrap(), build, includes)),
        );
    }
    for (path, texts) in TABLES {
        let kind = KINDS.iter().find(|(folder, ..)| path.starts_with(folder)).unwrap();
        let document = Document::file(&root().join(path)).unwrap();
        found.push((
            kind.0,
            texts.iter().fold(document, |document, text| document.set(*text)),
            kind.1,
            kind.2,
        ));
    }
    let (mut seen, mut kinds) = (BTreeSet::new(), BTreeSet::new());
    let mut leaves = Vec::new();
    for (folder, document, build, includes) in found {
        if let Err(error) = build(document.clone()) {
            panic!("{error}");
        }
        let merged = document.clone().merged(includes, &|_, _| None).unwrap();
        for key in merged.numbers() {
            let (_, place) = merged.written(&key).unwrap();
            let below =
                includes.iter().rev().find_map(|include| key.strip_prefix(include)?.strip_prefix('.'));
            let below = below.unwrap_or(&key).to_owned();
            let kind = (folder, unnumbered(&below));
            if seen.insert((origin(&place), below)) && (kinds.insert(kind) || every) {
                leaves.push(Leaf { document: document.clone(), build, key });
            }
        }
    }
    for folder in ["robots", "rigs", "rigs/arms"] {
        for path in documents(folder) {
            let document = Document::file(&path).unwrap();
            let place = |key: &String| origin(&document.written(key).unwrap().1);
            let mut unseen = document.numbers();
            unseen.retain(|key| !seen.contains(&(place(key), key.clone())));
            assert!(unseen.is_empty(), "{}: nothing builds {unseen:?}", path.display());
        }
    }
    leaves
}

/// A key without the places in lists that it names.
fn unnumbered(key: &str) -> String {
    let pieces = key.split('[').map(|piece| piece.split_once(']').map_or(piece, |(_, rest)| rest));
    pieces.collect::<Vec<_>>().join("[]")
}

/// What is wrong with the answer to `key=value`; nothing when all is well.
fn verdict(leaf: &Leaf, value: &str) -> Option<String> {
    let given = format!("{}={value}", leaf.key);
    let document = leaf.document.clone().set(given.as_str());
    let negative = value == "-1" && NOT_NEGATIVE.iter().any(|end| leaf.key.ends_with(end));
    let error = match catch_unwind(AssertUnwindSafe(|| (leaf.build)(document))) {
        Err(_) => return Some(format!("{given}: panics")),
        Ok(Ok(())) if NEVER.contains(&value) || negative => return Some(format!("{given}: accepted")),
        Ok(Ok(())) => return None,
        Ok(Err(error)) => error,
    };
    let here = ValuePlace::Override(given.clone());
    let items = format!("{}[", leaf.key);
    let named = error.all().iter().any(|one| {
        let own = one.place == here && (one.key == leaf.key || one.key.starts_with(&items));
        own || one.against.iter().any(|other| other.place == here && other.key == leaf.key)
    });
    let told = error.to_string().contains(&leaf.key) && error.to_string().contains(&format!("--set {given}"));
    (!(named && told)).then(|| format!("{given}: {error}"))
}

/// Of every key a third of the values, other ones than of its neighbours.
#[test]
fn each_key_is_accepted_or_refused_by_its_name() {
    accepted_or_refused(&leaves(false), 3);
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn each_number_is_accepted_or_refused_by_its_key() {
    accepted_or_refused(&leaves(true), 1);
}

/// Sets each number to one in `share` of the values.
fn accepted_or_refused(leaves: &[Leaf], share: usize) {
    let values: Vec<&str> = NUMBERS.into_iter().chain(NEVER).collect();
    let verdicts = parallel::map(leaves, |place, leaf| {
        let tried = (place % share..values.len()).step_by(share);
        tried.filter_map(|k| verdict(leaf, values[k])).collect::<Vec<_>>()
    });
    let wrong: Vec<String> = verdicts.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{} of {} numbers:\n{}", wrong.len(), leaves.len(), wrong.join("\n"));
}

/// A refused number names the line of its file, robots and arms included.
#[test]
fn a_refused_number_names_its_line() {
    let robot = fs::read_to_string(root().join("robots/aerobat_paper.toml")).unwrap();
    let line = 1 + robot.lines().position(|line| line.starts_with("mass_kg")).unwrap();
    let robot = Document::text("robot", &robot.replacen("mass_kg = 0.010", "mass_kg = -0.010", 1)).unwrap();
    let scenario =
        Document::file(&root().join("scenarios/banking_turn.toml")).unwrap().put("robot", robot).unwrap();
    let message = Scenario::new(scenario).map(drop).unwrap_err().to_string();
    let expected = "robot.body.mass_kg = -0.010: allowed is a finite number above 0";
    assert_eq!(message, format!("robot:{line}: {expected}"));
}

/// What is derived from a number is refused by the key that its user wrote, in the unit of the file.
#[test]
fn a_derived_number_is_refused_by_what_it_comes_from() {
    let case = |text: &str| {
        let document = Document::file(&root().join("cases/plunge.toml")).unwrap();
        tether(document.set(text)).unwrap_err().to_string()
    };
    assert_eq!(case("wing.cd0=-1"), "--set wing.cd0=-1: wing.cd0 = -1: allowed is 0 to 2");
    assert_eq!(
        case("aero.stall_angle_deg=95"),
        "--set aero.stall_angle_deg=95: aero.stall_angle_deg = 95: allowed is between 0 and 90, neither itself"
    );
    assert_eq!(
        case("wind.density_kg_m3=0"),
        "--set wind.density_kg_m3=0: wind.density_kg_m3 = 0: allowed is a finite number above 0"
    );
}
