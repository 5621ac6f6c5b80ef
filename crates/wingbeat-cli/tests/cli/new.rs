//! `wingbeat new` and `wingbeat schema` as a user meets them.

use std::fs;
use std::path::Path;

use crate::{entries, scratch, wingbeat};

/// Writes a document of a kind and gives what is printed.
fn written(folder: &Path, arguments: &[&str]) -> String {
    let output = wingbeat(folder, &[&["new"], arguments].concat());
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// The command that is proposed next runs, with `more` behind it.
fn runs(folder: &Path, told: &str, more: &[&str]) {
    let next = told.lines().find_map(|line| line.strip_prefix("next: wingbeat ")).unwrap();
    let arguments: Vec<&str> = next.split(' ').chain(more.iter().copied()).collect();
    let output = wingbeat(folder, &arguments);
    assert!(output.status.success(), "{next}: {output:?}");
}

#[test]
fn a_new_scenario_flies_and_holds_its_goal() {
    let folder = scratch("new-scenario");
    let told = written(&folder, &["scenario", "mine.toml"]);
    assert_eq!(entries(&folder), ["mine.toml", "robot.toml"]);
    let text = fs::read_to_string(folder.join("mine.toml")).unwrap();
    assert!(text.contains("name = \"mine\"\nrobot = \"robot.toml\"\n"), "{text}");
    assert!(text.contains("# 200 Hz") && !text.contains("#:schema .."), "{text}");
    runs(&folder, &told, &["--quiet"]);
    assert!(folder.join("runs/mine/record.parquet").is_file());
}

#[test]
fn a_new_robot_is_flown_by_a_new_scenario() {
    let folder = scratch("new-robot");
    written(&folder, &["robot"]);
    let told = written(&folder, &["scenario"]);
    assert!(told.contains("robot.toml: was there already, kept"), "{told}");
    let short = ["--quiet", "--set", "flight.duration_s=0.1", "--set", "goal.settle_s=0.05", "--out", "a"];
    runs(&folder, &told, &[&short[..], &["--set", "goal.roll_within_deg=90.0"]].concat());
}

#[test]
fn new_cases_and_sweeps_run() {
    let folder = scratch("new-case");
    let told = written(&folder, &["case"]);
    runs(&folder, &told, &["--quiet"]);
    let told = written(&folder, &["sweep"]);
    assert_eq!(entries(&folder), ["case.toml", "robot.toml", "runs", "scenario.toml", "sweep.toml"]);
    runs(&folder, &told, &["--quiet", "--set", "runs=2"]);
}

#[test]
fn a_new_search_flies_its_candidates() {
    let folder = scratch("new-search");
    let told = written(&folder, &["search"]);
    assert!(told.contains("next: wingbeat sweep search.toml"), "{told}");
    assert_eq!(entries(&folder), ["robot.toml", "scenario.toml", "search.toml"]);
    let short = ["runs=4", "search.population=4", "scenario.flight.duration_s=0.02"];
    let sets: Vec<&str> = short.iter().flat_map(|set| ["--set", set]).collect();
    let output = wingbeat(&folder, &[&["sweep", "search.toml", "--quiet", "--out", "a"], &sets[..]].concat());
    // No candidate turns within a few steps.
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(fs::read_to_string(folder.join("a/best.toml")).unwrap().contains("[controller"));
}

#[test]
fn new_rigs_runs_and_lists_are_planned() {
    for kind in ["rig", "run", "runs"] {
        let folder = scratch(&format!("new-{kind}"));
        let told = written(&folder, &[kind, "own.toml"]);
        assert!(folder.join("arm.toml").is_file() && folder.join("robot.toml").is_file(), "{told}");
        runs(&folder, &told, &["--quiet", "--out", "a"]);
    }
    let folder = scratch("new-arm");
    written(&folder, &["arm"]);
    let told = written(&folder, &["rig"]);
    runs(&folder, &told, &["--quiet", "--out", "a"]);
}

#[test]
fn the_minimal_robot_flies_and_documents_stand_around_it() {
    let folder = scratch("new-minimal");
    let told = written(&folder, &["robot", "bird.toml", "--minimal"]);
    assert!(told.contains("next: wingbeat show bird.toml"), "{told}");
    assert!(fs::read_to_string(folder.join("bird.toml")).unwrap().lines().count() < 80);
    let told = written(&folder, &["scenario", "flight.toml", "--robot", "bird.toml"]);
    runs(&folder, &told, &["--quiet", "--set", "flight.duration_s=0.2", "--out", "a"]);
    fs::create_dir(folder.join("below")).unwrap();
    let told = written(&folder, &["trim", "below/level.toml", "--robot", "bird.toml"]);
    assert!(told.contains("next: wingbeat trim below/level.toml"), "{told}");
    let text = fs::read_to_string(folder.join("below/level.toml")).unwrap();
    assert!(text.contains("free = [\"frequency\", \"elevator\"]"), "{text}");
    let output =
        wingbeat(&folder, &["fly", "below/level.toml", "--quiet", "--set", "flight.duration_s=0.01"]);
    assert!(output.status.success(), "{output:?}");
}

#[test]
#[ignore = "long: cargo xtask long tests"]
fn the_minimal_robot_trims_as_it_is_written() {
    let folder = scratch("new-trims");
    written(&folder, &["robot", "bird.toml", "--minimal"]);
    written(&folder, &["trim", "level.toml", "--robot", "bird.toml"]);
    let output = wingbeat(&folder, &["trim", "level.toml", "--quiet", "--out", "level"]);
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn a_trim_of_a_robot_with_a_fin_is_written() {
    let folder = scratch("new-fin");
    let glider = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/glider.toml");
    let told = written(&folder, &["trim", "glide.toml", "--robot", glider.to_str().unwrap()]);
    assert!(told.contains("next: wingbeat trim glide.toml"), "{told}");
    let text = fs::read_to_string(folder.join("glide.toml")).unwrap();
    assert!(text.contains("free = [\"frequency\", \"elevator\"]") && !text.contains("assumed"), "{text}");
}

#[test]
fn a_calibration_of_a_case_names_it() {
    let folder = scratch("new-of-case");
    written(&folder, &["case", "wing.toml"]);
    written(&folder, &["calibration", "fit.toml", "--case", "wing.toml"]);
    assert_eq!(entries(&folder), ["fit.toml", "wing.toml"]);
    let listed = wingbeat(&folder, &["calibrate", "fit.toml", "--names"]);
    let names = String::from_utf8(listed.stdout).unwrap();
    assert!(names.contains("surfaces.wing.added_mass_scale = 1\n"), "{names}");
    let output = wingbeat(&folder, &["calibrate", "fit.toml", "--information"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && message.contains("measured.csv"), "{message}");
}

#[test]
fn options_of_new_that_do_not_fit_are_refused() {
    let folder = scratch("new-options");
    written(&folder, &["robot", "still.toml", "--minimal"]);
    let text = fs::read_to_string(folder.join("still.toml")).unwrap();
    let still = text.split("# What a controller").next().unwrap();
    fs::write(folder.join("still.toml"), still).unwrap();
    for (arguments, said) in [
        (&["case", "--minimal"][..], "--minimal: allowed with `new robot`"),
        (&["trim"], "--robot ROBOT.toml"),
        (&["sweep", "--robot", "still.toml"], "--robot: allowed with"),
        (&["scenario", "--case", "still.toml"], "--case: allowed with `new calibration`"),
        (&["scenario", "--robot", "none.toml"], "none.toml"),
        (&["calibration", "--case", "still.toml"], "still.toml"),
    ] {
        let output = wingbeat(&folder, &[&["new"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(said), "{message}");
    }
    assert_eq!(entries(&folder), ["still.toml"]);
    // A robot without actuators gets them in the document.
    written(&folder, &["trim", "level.toml", "--robot", "still.toml"]);
    let text = fs::read_to_string(folder.join("level.toml")).unwrap();
    assert!(
        text.contains("base = \"still.toml\"") && text.contains("[[robot.structure.elements]]"),
        "{text}"
    );
    let flown = ["fly", "level.toml", "--quiet", "--set", "flight.duration_s=0.01", "--out", "a"];
    assert!(wingbeat(&folder, &flown).status.success());
}

#[test]
fn nothing_is_replaced_unasked() {
    let folder = scratch("new-kept");
    fs::write(folder.join("scenario.toml"), "mine").unwrap();
    let refused = |arguments: &[&str], why: &str| {
        let output = wingbeat(&folder, &[&["new"], arguments].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(why), "{message}");
    };
    refused(&["scenario"], "scenario.toml: is there already; --force replaces it");
    refused(&["scenario", "robot.toml"], "robot.toml: another name");
    refused(&["scenario", "nowhere/a.toml"], "nowhere");
    refused(&["scenario", ".."], "a file name that ends with .toml");
    assert_eq!(entries(&folder), ["scenario.toml"]);
    assert_eq!(fs::read_to_string(folder.join("scenario.toml")).unwrap(), "mine");
    fs::write(folder.join("robot.toml"), "mine too").unwrap();
    written(&folder, &["scenario", "--force"]);
    assert!(fs::read_to_string(folder.join("scenario.toml")).unwrap().contains("[air]"));
    assert_eq!(fs::read_to_string(folder.join("robot.toml")).unwrap(), "mine too");
}

#[test]
fn a_schema_is_json_that_names_every_table() {
    let output = wingbeat(&scratch("schema"), &["schema", "scenario"]);
    assert!(output.status.success(), "{output:?}");
    let schema: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let tables = schema["properties"].as_object().unwrap();
    assert!(["air", "aero", "flight", "controller", "goal"].iter().all(|table| tables.contains_key(*table)));
}
