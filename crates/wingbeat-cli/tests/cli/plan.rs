//! `wingbeat plan` as a user meets it: a gait of least power, its replays, messages, exit codes.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::{entries, root, scratch, wingbeat};

/// Plans a smooth variant of the gait on one coarse mesh.
fn plan(folder: &Path, keys: &[&str]) -> Output {
    let scenario = root().join("scenarios/least_power_gait.toml");
    let mut arguments = vec!["plan", scenario.to_str().unwrap(), "--out", "a"];
    let short = [
        "storage=1.0",
        "up_n=0.08",
        "frequency_hz=[3.5, 3.5]",
        "pitch_deg=[-15.0, -15.0]",
        "effort_w=0.3",
        "intervals=24",
        "meshes=1",
        "tolerance=1e-2",
    ];
    let keys: Vec<String> = short.iter().chain(keys).map(|key| format!("plan.least_power.{key}")).collect();
    arguments.extend(keys.iter().flat_map(|key| ["--set", key]));
    wingbeat(folder, &arguments)
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_gait_leaves_a_whole_folder_and_the_tethered_wing_bears_its_force() {
    let folder = scratch("plan-gait");
    let output = plan(&folder, &[]);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("replayed from rest") && text.contains("own gait"), "{text}");
    let names = [
        "figures",
        "joints.csv",
        "manifest.json",
        "record.parquet",
        "scenario.toml",
        "summary.json",
        "tether.toml",
    ];
    assert_eq!(entries(&folder.join("a")), names);
    let figures = ["commands.png", "commands.svg", "forces.png", "forces.svg", "gait.png", "gait.svg"];
    assert_eq!(entries(&folder.join("a/figures")), figures);
    let planned = summary(&folder.join("a"));
    assert_eq!(planned["status"], "ok");
    assert!(planned["plan"]["up_n"].as_f64().unwrap() > 0.0799);

    // The same motion of the wing alone, by the path of `tether`; the drag of the body is added by hand.
    let output = wingbeat(&folder, &["tether", "a/tether.toml", "--out", "b", "--quiet"]);
    assert!(output.status.success(), "{output:?}");
    let tethered = summary(&folder.join("b"));
    let mean = |name: &str| {
        let cycle = tethered["cycle"].as_array().unwrap();
        cycle.iter().find(|column| column["name"] == name).unwrap()["mean"].as_f64().unwrap()
    };
    let pitch = -15_f64.to_radians();
    let body = -0.5 * 1.225 * 0.002 * (2.0 * pitch.cos()).powi(2);
    let (up, forward) =
        (mean("force_wind_lift") - body * pitch.sin(), body * pitch.cos() - mean("force_wind_drag"));
    let replay = |name: &str| planned["replay"][name].as_f64().unwrap();
    assert!((up - replay("up_n")).abs() < 5e-5, "{up} {}", replay("up_n"));
    assert!((forward - replay("forward_n")).abs() < 5e-5, "{forward} {}", replay("forward_n"));
}

#[test]
fn a_force_out_of_reach_is_named_in_a_folder_that_is_kept() {
    let folder = scratch("plan-reach");
    let output = plan(&folder, &["up_n=3.0", "intervals=8"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(text.contains("infeasible: mean upward force misses its limits"), "{text}");
    assert_eq!(entries(&folder.join("a")), ["manifest.json", "scenario.toml", "summary.json"]);
    assert_eq!(summary(&folder.join("a"))["status"], "failed");
}

#[test]
fn bad_settings_are_refused_in_one_message_and_leave_nothing() {
    let folder = scratch("plan-refused");
    for (key, said) in [
        ("frequency_hz=[5.0, 4.0]", "plan.least_power.frequency_hz"),
        ("frequency_hz=[0.0, 4.0]", "plan.least_power.frequency_hz"),
        ("pitch_deg=[0.0, 95.0]", "plan.least_power.pitch_deg"),
        ("storage=1.5", "plan.least_power.storage"),
        ("order=5", "plan.least_power.order"),
        ("effort_w=0.0", "plan.least_power.effort_w"),
        ("intervals=0", "plan.least_power.intervals"),
        ("trim_within_n_m=-1.0", "plan.least_power.trim_within_n_m"),
        ("upward_n=1.0", "upward_n"),
    ] {
        let output = plan(&folder, &[key]);
        assert_eq!(output.status.code(), Some(2), "{key}: {output:?}");
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(text.contains(said), "{key}: {text}");
        assert!(entries(&folder).is_empty(), "{key}");
    }
}
