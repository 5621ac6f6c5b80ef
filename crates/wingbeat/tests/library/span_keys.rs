//! What bears along the span, as it was resolved: what is kept of a run says it.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::{Document, RigRun, Scenario, Sweep, TetherCase};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

fn texts(overrides: &[&str]) -> Vec<String> {
    overrides.iter().map(|text| (*text).to_owned()).collect()
}

fn scenario(name: &str, overrides: &[&str]) -> Scenario {
    Scenario::load(&file(&format!("scenarios/{name}.toml")), &texts(overrides))
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// `edge_suction` and `turning_impulse` below the table of aerodynamics at `aero`.
fn said(resolved: &str, aero: &[&str]) -> [Option<bool>; 2] {
    let table: toml::Value = toml::from_str(resolved).unwrap();
    let full = aero.iter().try_fold(&table, |table, key| table.get(*key)).and_then(|aero| aero.get("full"));
    ["edge_suction", "turning_impulse"].map(|key| full?.get(key)?.as_bool())
}

fn rates(robot: &Robot, x: &[f64]) -> Vec<f64> {
    let mut rates = vec![0.0; x.len()];
    robot.rates_in_numbers(0.01, x, &vec![0.0; robot.inputs().len()], &mut rates).unwrap();
    rates
}

/// What a resolved document says: where edges' suction bears, what is not given of the other key stays so.
fn kept([edges, turns]: [bool; 2], overrides: &[&str]) -> [Option<bool>; 2] {
    let given = overrides.iter().any(|text| text.starts_with("aero.full.turning_impulse"));
    [Some(edges), Some(turns).filter(|turns| given || *turns || !edges)]
}

/// What a snapshot writes out does not decide how a membrane that is given later bears, nor what is said of it.
#[test]
fn a_snapshot_with_a_membrane_is_told_as_its_scenario_is() {
    let membrane = "robot.surfaces[0].membrane={ thickness_m = 15e-6, modulus_pa = 2e8, density_kg_m3 = 920.0, prestrain = 0.01, ribs_m = [0.015, 0.215] }";
    let told = |scenario: &Scenario| {
        let brief = scenario.fly(|_| ControlFlow::Continue(())).unwrap().summary;
        let warned = brief.warnings.iter().any(|warning| warning.id == "aero.turning_impulse");
        (warned, brief.distance_x_m, brief.altitude_change_m)
    };
    let swept = "robot.surfaces[0].planform[1].trailing_edge_m=-0.03";
    let overrides = ["flight.duration_s=0.02", swept, membrane];
    let first = scenario("four_wings", &overrides);
    let snapshot = scenario("four_wings", &overrides[..2]).resolved;
    let again = Document::text("again", &snapshot).unwrap().set(membrane);
    assert_eq!(told(&first), told(&Scenario::new(again).unwrap()));
    assert!(told(&first).0);
}

#[test]
fn a_resolved_scenario_holds_what_bears_along_the_span() {
    const EDGES: &str = "aero.full.edge_suction";
    const IMPULSE: &str = "aero.full.turning_impulse";
    let given = |key: &str, value: bool| format!("{key}={value}");
    let (off, neither) = (given(EDGES, false), [given(EDGES, false), given(IMPULSE, false)]);
    for (name, overrides, expected) in [
        ("cruise_20g", vec![], [true, false]),
        ("cruise_20g", vec![off.as_str()], [false, true]),
        ("cruise_20g", vec!["aero.full.turning_impulse=true"], [false, true]),
        ("cruise_20g", vec!["aero.full.turning_impulse=false"], [true, false]),
        ("cruise_20g", neither.iter().map(String::as_str).collect(), [false, false]),
        ("aerobat_membrane", vec![], [false, true]),
        // Their tails are flat.
        ("flap_glide", vec![], [true, true]),
        ("sail_glide", vec![], [true, true]),
        ("flap_glide", vec!["aero.full.turning_impulse=false"], [true, false]),
        ("glider", vec!["aero.full.strips=1"], [true, true]),
    ] {
        let first = scenario(name, &overrides);
        assert_eq!(said(&first.resolved, &["aero"]), kept(expected, &overrides), "{name} {overrides:?}");
        let again = Scenario::new(Document::text("again", &first.resolved).unwrap())
            .unwrap_or_else(|error| panic!("{name} {overrides:?}: {error}"));
        assert_eq!(again.resolved, first.resolved);
        // A wing that moves, in a state where circulation and drift along the span are there.
        let mut x = first.start();
        let layout = first.robot().layout();
        x[layout.rate..][..3].copy_from_slice(&[3.0, -2.0, 1.0]);
        x[layout.velocity + 1] += 0.5;
        let [one, other] = [&first, &again].map(|scenario| rates(scenario.robot(), &x));
        assert_eq!(one, other, "{name} {overrides:?}");
    }
    assert_eq!(said(&scenario("banking_turn", &[]).resolved, &["aero"]), [None; 2]);
}

#[test]
fn each_air_a_case_and_a_rig_hold_theirs() {
    let other = ["mismatch.aero={preset='full', law='stall'}", "mismatch.aero.full.turning_impulse=true"];
    let of_paper = scenario("banking_turn", &other).resolved;
    assert_eq!(said(&of_paper, &["aero"]), [None; 2]);
    assert_eq!(said(&of_paper, &["mismatch", "aero"]), [Some(false), Some(true)]);
    let of_both = scenario("cruise_20g", &other[..1]).resolved;
    assert_eq!(said(&of_both, &["aero"]), [Some(true), None]);
    assert_eq!(said(&of_both, &["mismatch", "aero"]), [Some(true), None]);
    let case = |overrides: &[&str]| {
        let none = &|_: &Path| Err("no table".into());
        TetherCase::load(&file("cases/flap_f2.toml"), &texts(overrides), none).unwrap()
    };
    for (overrides, expected) in [
        (vec!["aero.preset=full"], [true, false]),
        (vec!["aero.preset=full", "aero.full.strips=1"], [false, true]),
    ] {
        let case = case(&overrides);
        let text = case.kept(|_| String::new()).unwrap();
        assert_eq!(
            [&case.resolved, &text].map(|text| said(text, &["aero"])),
            [kept(expected, &overrides); 2]
        );
    }
    assert_eq!(said(&case(&["aero.preset=paper"]).resolved, &["aero"]), [None; 2]);
    let sweep =
        Sweep::load(&file("sweeps/any_air_level_20g.toml"), &[], &|_| Err("no table".into())).unwrap();
    for aero in [&["scenario", "aero"][..], &["scenario", "mismatch", "aero"]] {
        assert_eq!(said(&sweep.resolved, aero), [Some(true), None]);
    }
    let run = file("rigs/runs/roll15_speed08.toml");
    let run =
        |preset: &str| RigRun::load(&run, &texts(&[&format!("rig.aero.preset={preset}")])).unwrap().resolved;
    assert_eq!(said(&run("full"), &["rig", "aero"]), [Some(true), None]);
    assert_eq!(said(&run("paper"), &["rig", "aero"]), [None; 2]);
}

fn no_table(_: &Path) -> Result<wingbeat::simulate::Record, String> {
    Err("no table".into())
}

/// A sweep of `cruise_20g`, or of the case `flap_f2`, with `more` behind its first lines.
fn sweep(of: &str, more: &str) -> Sweep {
    let text = format!("name = \"a_sweep\"\nruns = 2\n{more}");
    let document = Document::text("a sweep", &text).unwrap();
    let (key, path) = match of {
        "case" => (of, "cases/flap_f2.toml"),
        _ => ("scenario", "scenarios/cruise_20g.toml"),
    };
    let document = document.put(key, Document::file(&file(path)).unwrap()).unwrap();
    Sweep::new(document, &no_table).unwrap_or_else(|error| panic!("{more}: {error}"))
}

const HOLD: &str = "hold = { roll_within_deg = 9.0, pitch_within_deg = 9.0 }\n";

/// A name, or the key of another number, is none of what varies them, and neither is an override that holds for all runs.
#[test]
fn only_what_varies_the_keys_keeps_them_out() {
    let draw = |key: &str, values: &str| format!("draws = [{{ key = \"{key}\", values = {values} }}]\n");
    let mass = draw("robot.body.mass_kg", "[0.019, 0.02]");
    for (more, expected) in [
        (format!("{HOLD}{mass}"), [Some(true), None]),
        (format!("{HOLD}set = [\"name=edge_suction_and_aero.preset\"]\n{mass}"), [Some(true), None]),
        (format!("{HOLD}set = [\"aero.full.turning_impulse=true\"]\n{mass}"), [Some(false), Some(true)]),
        (format!("{HOLD}set = [\"aero={{preset='full', law='stall'}}\"]\n{mass}"), [Some(true), None]),
        (format!("{HOLD}{}", draw("aero.preset", "[\"paper\", \"full\"]")), [None; 2]),
        (format!("{HOLD}{}", draw("aero.full.turning_impulse", "[true, false]")), [None; 2]),
        (format!("{HOLD}{}", draw("aero.full.edge_suction", "[true, false]")), [None; 2]),
    ] {
        let first = sweep("scenario", &more);
        assert_eq!(said(&first.resolved, &["scenario", "aero"]), expected, "{more}");
        let again = Sweep::new(Document::text("again", &first.resolved).unwrap(), &no_table)
            .unwrap_or_else(|error| panic!("{more}: {error}"));
        assert_eq!(again.resolved, first.resolved, "{more}");
    }
    for (key, values, expected) in [
        ("time.frequency_hz", "[3.0, 4.0]", [Some(true), None]),
        ("aero.full.turning_impulse", "[true, false]", [None; 2]),
    ] {
        let kept = sweep("case", &format!("set = [\"aero.preset=full\"]\n{}", draw(key, values)))
            .kept(&no_table, |_| String::new());
        let kept = kept.unwrap_or_else(|error| panic!("{key}: {error}"));
        assert_eq!(said(&kept, &["case", "aero"]), expected, "{key}");
        Sweep::new(Document::text("again", &kept).unwrap(), &no_table).unwrap();
    }
    let named = scenario("cruise_20g", &["name=turning_impulse"]);
    assert_eq!(said(&named.resolved, &["aero"]), [Some(true), None]);
    for (air, expected) in [
        ("aero.law=lev", [Some(true), None]),
        ("aero.preset=paper", [None; 2]),
        ("aero.full.turning_impulse=true", [None; 2]),
    ] {
        let search = scenario("gait_search_airs", &[&format!("trim.search.airs=[[\"{air}\"]]")]);
        assert_eq!(said(&search.resolved, &["aero"]), expected, "{air}");
    }
}

/// A sweep whose draws vary the keys holds them in what each of its flights resolves.
#[test]
fn each_flight_of_a_sweep_of_presets_holds_its_own() {
    let draws = "sampling = \"latin_hypercube\"\ndraws = [{ key = \"aero.preset\", values = [\"full\", \"paper\"] }]\n";
    let sweep = sweep("scenario", &format!("{HOLD}{draws}"));
    let mut flown = [0, 1].map(|run| said(&sweep.scenario(run).unwrap().resolved, &["aero"]));
    flown.sort();
    assert_eq!(flown, [[None; 2], [Some(true), None]]);
}

#[test]
fn an_orbit_holds_what_bears_along_the_span() {
    let trim = scenario("cruise_20g", &[]).trim(&mut |_| ControlFlow::Continue(())).unwrap();
    let (_, orbit) = trim.files.iter().find(|(name, _)| *name == "orbit.toml").unwrap();
    assert_eq!(said(orbit, &["aero"]), [Some(true), None]);
}

/// What a plan leaves to be flown, and the wing of a planned gait.
#[test]
fn the_files_of_a_plan_hold_what_bears_along_the_span() {
    let full = ["aero.preset=full", "aero.full.strips=6"];
    let roll_in = ["intervals=6", "meshes=1", "tolerance=1e-2"].map(|key| format!("plan.roll_in.{key}"));
    let gait = [
        "storage=1.0",
        "up_n=0.0",
        "forward_n=-0.2",
        "nose_up_deg=[15.0, 15.0]",
        "frequency_hz=[3.5, 3.5]",
        "effort_w=0.3",
        "intervals=3",
        "meshes=1",
        "tolerance=0.1",
    ];
    let gait = gait.map(|key| format!("plan.least_power.{key}"));
    for (name, file, keys) in
        [("roll_in", "track.toml", &roll_in[..]), ("least_power_gait", "tether.toml", &gait[..])]
    {
        let overrides: Vec<&str> = full.into_iter().chain(keys.iter().map(String::as_str)).collect();
        let planned = scenario(name, &overrides).plan(&mut |_| ControlFlow::Continue(())).unwrap();
        let (_, text) = planned.files.iter().find(|(name, _)| *name == file).unwrap();
        assert_eq!(said(text, &["aero"]), [Some(true), None], "{file}");
    }
}

/// Both given are refused where only one of them would count.
#[test]
fn both_keys_are_for_wings_of_both_kinds() {
    let both = ["aero.full.edge_suction=true", "aero.full.turning_impulse=true"];
    let load = |name: &str| {
        let path = file(&format!("scenarios/{name}.toml"));
        Scenario::load(&path, &texts(&both)).map(drop).map_err(|error| error.to_string())
    };
    for name in ["cruise_20g", "aerobat_membrane"] {
        let refused = load(name).unwrap_err();
        assert!(refused.contains("aero.full.edge_suction"), "{name}: {refused}");
    }
    assert_eq!(load("flap_glide"), Ok(()));
}

#[test]
fn what_is_no_truth_is_told_what_is_allowed() {
    for key in ["edge_suction", "turning_impulse", "side_edges"] {
        for value in ["nan", "1e300", "1", "yes"] {
            let set = format!("aero.full.{key}={value}");
            let path = file("scenarios/cruise_20g.toml");
            let refused = Scenario::load(&path, &texts(&[&set])).unwrap_err().to_string();
            assert!(refused.ends_with("allowed is true or false"), "{refused}");
        }
    }
}
