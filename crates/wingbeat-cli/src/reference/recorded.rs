//! Every column of every record against what is said of it, by flying, tethering and rigging what ships, briefly.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;

use wingbeat::aero::LoadSource;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::robot::WeightPart;
use wingbeat::scenario::{Evaluated, ProcessedRun, RigRun, Scenario, Sweep, TetherCase, together};
use wingbeat::simulate::{Column, Record};

use super::columns::{
    AVERAGE, BOX, CALIBRATED, CANDIDATES, COLUMNS, ENVELOPE, FLIGHT, GAIT, LOADS, MODES, NODES, ORBITS,
    OWN_FRAME, OWN_UNIT, PER_UNIT, RECORDS, RIG, RUNS, STARTS, STRIPS, SWEEP,
};
use super::{root, shipped};

/// What placeholders stand for; of others, any name.
fn words(placeholder: &str) -> Option<Vec<&'static str>> {
    Some(match placeholder {
        "axis" => vec!["x", "y", "z", "w", "drag", "side", "lift"],
        "side" => vec!["left", "right"],
        "angle" => vec!["roll", "pitch", "yaw"],
        "channel" => CHANNELS.map(|(name, _)| name).into(),
        "measure" => vec!["iterations", "qp_changes", "active_limits", "stationarity", "defect"],
        "part" => WeightPart::ALL.map(WeightPart::name).into(),
        "source" => LoadSource::ALL.map(LoadSource::name).into(),
        _ => return None,
    })
}

/// Whether a name is one of a pattern's.
fn fits(pattern: &str, name: &str) -> bool {
    let Some((literal, rest)) = pattern.split_once('<') else { return pattern == name };
    let Some(name) = name.strip_prefix(literal) else { return false };
    let Some((placeholder, rest)) = rest.split_once('>') else { return false };
    if let Some(words) = words(placeholder) {
        return words.iter().any(|word| name.strip_prefix(word).is_some_and(|name| fits(rest, name)));
    }
    let number = matches!(placeholder, "n" | "k");
    let stands = |text: &str| !number || text.bytes().all(|byte| byte.is_ascii_digit());
    (1..=name.len()).any(|end| name.is_char_boundary(end) && stands(&name[..end]) && fits(rest, &name[end..]))
}

/// The entries that were met, by their place in the list.
#[derive(Default)]
struct Met(BTreeSet<usize>);

impl Met {
    /// Every column is described, with its unit and frame; `alone` are the names that a joint or key may have.
    fn see(&mut self, record: &str, columns: &[Column], alone: &[String]) {
        for column in columns {
            let fitting = |entry: &&(usize, &super::columns::ColumnMeaning)| {
                let described = entry.1;
                let general = matches!(described.name, "<joint>" | "<key>" | "<state>");
                let named =
                    if general { alone.contains(&column.name) } else { fits(described.name, &column.name) };
                described.records.contains(&record) && named
            };
            let entries: Vec<_> = COLUMNS.iter().enumerate().collect();
            let Some((index, described)) = entries.iter().find(fitting) else {
                panic!("{}: nothing is said of the column {}", record, column.name);
            };
            let Column { name, unit, frame, .. } = column;
            let follows = |units: &[&str]| units == [OWN_UNIT] || units == [PER_UNIT];
            assert!(
                described.units.contains(&unit.as_str()) || follows(described.units),
                "{record}: {name} is in {unit:?}, not {}",
                described.name
            );
            assert!(
                frame == described.frame
                    || described.frame == OWN_FRAME
                    || described.name.starts_with("own_"),
                "{record}: {name} is in {frame:?}"
            );
            self.0.insert(*index);
        }
    }

    /// Every column that is said to be in `record`, if first there, was seen.
    fn all_of(&self, record: &str) {
        assert!(RECORDS.iter().any(|(known, _)| *known == record), "{record} is no record");
        for (index, described) in COLUMNS.iter().enumerate() {
            let unseen = described.records.first() == Some(&record) && !self.0.contains(&index);
            assert!(!unseen, "{record} has no column {}", described.name);
        }
    }
}

/// Flies a scenario for ten samples, each with its strips.
fn fly(met: &mut Met, file: &str, keys: &[&str]) {
    let path = root().join(file);
    let every = Scenario::load(&path, &[]).unwrap().spec.flight.record_every_s;
    let brief =
        [format!("flight.duration_s={:?}", 10.0 * every), format!("flight.record_strips_every_s={every:?}")];
    let keys: Vec<String> = brief.into_iter().chain(keys.iter().map(|key| (*key).to_owned())).collect();
    let scenario = Scenario::load(&path, &keys).unwrap();
    let joints: Vec<String> = scenario.robot().joint_names().map(str::to_owned).collect();
    let run = scenario.fly(|_| ControlFlow::Continue(())).unwrap();
    met.see(FLIGHT, run.record.columns(), &joints);
    met.see(STRIPS, run.strips.unwrap().columns(), &[]);
}

/// The keys of a table and of the tables in it, so far down, and the words that are chosen in these, such as a law.
fn tables(table: &toml::Table, depth: usize) -> Vec<String> {
    let below = |(key, value): (&String, &toml::Value)| match value {
        toml::Value::Table(table) if depth > 0 => {
            tables(table, depth - 1).iter().map(|name| format!("{key}.{name}")).collect()
        }
        toml::Value::String(word) if depth < DEPTH => vec![format!("{key}={word}")],
        _ => vec![key.clone()],
    };
    table.iter().flat_map(below).collect()
}

/// Takes seconds to trim, with the columns of soft_20g and of bank15_20g.
const SOFT: &str = "scenarios/soft_bank15.toml";

/// What takes seconds to find and adds no column, by the table that asks for it.
const BRIEF: [(&[&str], &[&str]); 5] = [
    // It begins within the flight.
    (&["plan", "roll_in"], &["plan.roll_in.start_s=0.0"]),
    // Few strips have the columns of many, and an orbit in a third of the time.
    (&["controller", "orbit"], &["controller.orbit.legs=[]", "aero.full.strips=8"]),
    (
        &["controller", "orbit", "dive"],
        &["controller.orbit.dive.nose_down_deg=10.0", "controller.orbit.dive.cycles=2"],
    ),
    (
        &["controller", "orbit", "landing"],
        &[
            "controller.orbit.landing={cycles=2, iterations=1, speed_within_m_s=100.0, pitch_within_deg=180.0}",
            // It starts with states of so many.
            "aero.full.strips=9",
        ],
    ),
    (
        &["controller", "orbit", "tracking"],
        &["path.curve={line={length_m=100.0}}", "controller.orbit.tracking.bank_limit_deg=1.0"],
    ),
];

/// Tables in tables that tell one kind of scenario from another.
const DEPTH: usize = 2;

#[test]
fn columns_of_flights_and_strips_are_in_the_reference() {
    let mut met = Met::default();
    let mut seen = BTreeSet::new();
    for document in shipped::all().iter().filter(|d| d.file.starts_with("scenarios/")) {
        // What has the tables and the robot of another has its columns.
        let robot = document.table.get("robot").map(ToString::to_string);
        if document.file == SOFT || !seen.insert((robot, tables(&document.table, DEPTH))) {
            continue;
        }
        let has = |path: &[&str]| {
            let mut keys = path.iter();
            let table = keys.next().and_then(|key| document.table.get(*key));
            keys.try_fold(table, |table, key| Some(table?.get(*key))).flatten().is_some()
        };
        let brief = BRIEF.iter().filter(|(path, _)| has(path)).flat_map(|(_, keys)| keys.iter().copied());
        fly(&mut met, &document.file, &brief.collect::<Vec<_>>());
    }
    for key in ["aero.law=lev", "aero.preset=paper"] {
        fly(&mut met, "scenarios/four_wings.toml", &[key]);
    }
    fly(&mut met, "scenarios/glider.toml", &["aero.preset=as_printed"]);
    fly(&mut met, "scenarios/glider.toml", &["air.ground_m=-5.0"]);
    let flexure = "robot.gait.linkage.springs=[{pin='coupler_rod', stiffness=1e-3}]";
    fly(&mut met, "scenarios/cruise_linkage.toml", &[flexure]);
    let reduced = "controller.orbit.predictive={intervals=3, interval_s=0.0075, structure='orbit'}";
    fly(
        &mut met,
        "scenarios/membrane_bank15.toml",
        &["controller.orbit.legs=[]", "aero.full.strips=8", reduced],
    );
    fly(&mut met, "scenarios/banking_turn.toml", &["controller.prepared=true"]);
    fly(&mut met, "scenarios/paper_turn.toml", &["controller.horizon_between_cycles=[0.5, 1.5]"]);
    met.all_of(FLIGHT);
}

#[test]
fn columns_of_gaits_are_in_the_reference() {
    let mut met = Met::default();
    let brief = [
        "storage=1.0",
        "up_n=0.08",
        "frequency_hz=[3.5, 3.5]",
        "nose_up_deg=[15.0, 15.0]",
        "effort_w=0.3",
        "intervals=8",
        "meshes=1",
        "tolerance=1e-1",
        "clearance_m=-1.0",
    ];
    let brief = brief.map(|key| format!("plan.least_power.{key}"));
    let scenario = Scenario::load(&root().join("scenarios/least_power_gait.toml"), &brief).unwrap();
    let joints: Vec<String> = scenario.robot().joint_names().map(str::to_owned).collect();
    let planned = scenario.plan(&mut |_| ControlFlow::Continue(())).unwrap();
    met.see(GAIT, planned.record.expect("a gait is found").columns(), &joints);
    let nodes = planned.nodes.expect("a gait is found").points;
    let names: Vec<String> = nodes.columns().iter().map(|column| column.name.clone()).collect();
    let multiplier = |name: &&String| {
        ["t", "interval"].contains(&name.as_str())
            || ["defect_", "limit_", "path_"].iter().any(|kind| name.starts_with(kind))
    };
    let states: Vec<String> = names.iter().filter(|name| !multiplier(name)).cloned().collect();
    met.see(NODES, nodes.columns(), &states);
    met.all_of(NODES);
    met.all_of(GAIT);
}

#[test]
fn columns_of_tethered_wings_are_in_the_reference() {
    let mut met = Met::default();
    for document in shipped::all().iter().filter(|d| d.file.starts_with("cases/")) {
        let path = root().join(&document.file);
        let membrane =
            "wing.membrane={ thickness_m = 1e-3, modulus_pa = 1e6, density_kg_m3 = 1e3, prestrain = 0.1 }";
        let flap = "wing.flap={ chord_fraction = 0.3, stiffness_n_rad = 1.0, areal_density_kg_m2 = 0.1 }";
        for key in ["aero.preset=full", "aero.preset=paper", membrane, flap] {
            let brief = ["time.cycles=1", "time.steps_per_cycle=24", key];
            let read = |path: &Path| wingbeat_io::read_csv(path).map_err(|error| error.to_string());
            let case = TetherCase::load(&path, &brief.map(str::to_owned), &read).unwrap();
            let run = case.tether.run(|_| ControlFlow::Continue(()));
            met.see(LOADS, run.loads.columns(), &[]);
            met.see(STRIPS, run.strips.columns(), &[]);
        }
    }
    met.all_of(LOADS);
    met.all_of(STRIPS);
}

#[test]
fn columns_of_the_rig_are_in_the_reference() {
    let mut met = Met::default();
    let brief = ["rig.cell.rate_hz=1000.0", "rig.cell.filter_hz=400.0", "hold.each_s=2.0"].map(String::from);
    for file in ["bench.toml", "roll15_speed08.toml"] {
        let path = root().join("rigs/runs").join(file);
        let load =
            || RigRun::load(&path, if file == "bench.toml" { &brief[..] } else { &brief[..2] }).unwrap();
        let run = load();
        let plan = run.spec.turn.map(|_| run.plan().unwrap().unwrap_or_else(|refusal| panic!("{refusal}")));
        let carrier = run.carrier(plan.as_ref());
        let record = run.simulate(&carrier, 0, |_| {}).unwrap().unwrap().record;
        met.see(RIG, record.columns(), &[]);
        let measured: Vec<Column> =
            record.columns().iter().filter(|column| !column.name.starts_with("true_")).cloned().collect();
        for record in [record, Record::new(measured, 0).unwrap()] {
            let run = load();
            let result =
                run.evaluate(record, &carrier, run.window(plan.as_ref(), &carrier)).unwrap().unwrap();
            let Evaluated::Averaged(processed) = &result else { panic!("{file} flaps") };
            met.see(AVERAGE, processed.record(run.processed_frame()).unwrap().columns(), &[]);
            let mut less = processed.clone();
            less.subtract("still air", processed);
            met.see(AVERAGE, less.record(run.processed_frame()).unwrap().columns(), &[]);
            let all = together(&[ProcessedRun { run, result }]).unwrap().unwrap();
            met.see(ENVELOPE, all.envelope.columns(), &[]);
        }
    }
    for robot in ["motor_flapper", "aerobat_membrane", "flap_glider"] {
        let robot = format!("rig.robot={}", root().join(format!("robots/{robot}.toml")).display());
        let full = "rig.aero.preset=full".to_owned();
        let run = RigRun::load(&root().join("rigs/runs/bench.toml"), &[&brief[..], &[robot, full]].concat());
        let run = run.unwrap();
        met.see(RIG, run.simulate(&run.carrier(None), 0, |_| {}).unwrap().unwrap().record.columns(), &[]);
    }
    met.all_of(RIG);
    met.all_of(AVERAGE);
    met.all_of(ENVELOPE);
}

#[test]
fn columns_of_sweeps_are_in_the_reference() {
    let mut met = Met::default();
    for (file, record) in [("banking_turn_robustness", SWEEP), ("flap_map", RUNS)] {
        let path = root().join("sweeps").join(file).with_extension("toml");
        let sweep = Sweep::load(&path, &[], &|path| Err(format!("{}: no table", path.display()))).unwrap();
        let columns = sweep.columns();
        let drawn: Vec<String> = sweep.draws().iter().map(|draw| draw.key.clone()).collect();
        met.see(record, &columns, &drawn);
        met.all_of(record);
    }
}

#[test]
fn columns_of_candidates_are_in_the_reference() {
    let path = root().join("sweeps/paper_turn_search.toml");
    let sweep = Sweep::load(&path, &[], &|path| Err(format!("{}: no table", path.display()))).unwrap();
    let drawn: Vec<String> = sweep.draws().iter().map(|draw| draw.key.clone()).collect();
    let keys: Vec<String> = sweep.spec.search.iter().flat_map(|s| &s.goals).map(|g| g.key.clone()).collect();
    let mut met = Met::default();
    met.see(CANDIDATES, &sweep.search().unwrap().columns(), &[drawn, keys].concat());
    met.all_of(CANDIDATES);
}

#[test]
fn columns_of_searches_are_in_the_reference() {
    let search = "trim.search={goal='power', limits={}, vary=[{key='trim.speed_m_s', low=3.0, high=4.0}]}";
    let scenario = Scenario::load(&root().join("scenarios/cruise_20g.toml"), &[search.to_owned()]).unwrap();
    let search = scenario.gait_search().unwrap().unwrap();
    let mut met = Met::default();
    met.see(STARTS, &search.columns(), &["trim.speed_m_s".to_owned()]);
    met.all_of(STARTS);
}

#[test]
fn columns_of_trimmed_flights_are_in_the_reference() {
    let mut met = Met::default();
    let family = "trim.family={along='speed_m_s', to=3.8, steps=1}".to_owned();
    let scenario = Scenario::load(&root().join("scenarios/cruise_20g.toml"), &[family]).unwrap();
    let joints: Vec<String> = scenario.robot().joint_names().map(str::to_owned).collect();
    let trimmed = scenario.trim(&mut |_| ControlFlow::Continue(())).unwrap();
    for (name, record) in [(FLIGHT, trimmed.record), (MODES, trimmed.multipliers), (ORBITS, trimmed.family)] {
        met.see(name, record.expect("an orbit is found").columns(), &joints);
    }
    met.all_of(MODES);
    met.all_of(ORBITS);
}

#[test]
fn columns_of_calibrations_are_in_the_reference() {
    let mut met = Met::default();
    met.see(CALIBRATED, &crate::calibrate::columns(), &[]);
    met.all_of(CALIBRATED);
}

#[test]
fn columns_of_recordings_are_in_the_reference() {
    let mut met = Met::default();
    met.see(BOX, &crate::rig::recorded::columns(), &[]);
    met.all_of(BOX);
}

#[test]
fn patterns_of_the_reference_fit_their_columns_alone() {
    assert!(fits("force_<source>_<axis>", "force_body_drag_x") && !fits("force_<axis>", "force_body_drag_x"));
    assert!(fits("lag<k>_<n>", "lag2_11") && !fits("lag<k>_<n>", "lag2_x") && !fits("lag<k>_<n>", "lag2_"));
    assert!(
        fits("<surface>_incidence_<n>", "tail_incidence_3") && !fits("incidence_<n>", "tail_incidence_3")
    );
}
