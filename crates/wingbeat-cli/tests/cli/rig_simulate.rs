//! `wingbeat rig simulate` as a user meets it: verdicts and exit codes.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::{entries, root, scratch, wingbeat};

/// Simulates a second and a half of the bench.
fn bench(folder: &Path, out: &str, keys: &[&str]) -> Output {
    let run = root().join("rigs/runs/bench.toml");
    let mut arguments =
        vec!["rig", "simulate", run.to_str().unwrap(), "--out", out, "--set", "hold.each_s=1.5"];
    arguments.extend(keys.iter().flat_map(|key| ["--set", key]));
    wingbeat(folder, &arguments)
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_run_of_the_bench_has_a_verdict_and_its_ending() {
    let folder = scratch("rig-simulate");
    let fit = "rig.robot.numbers={verdict = {status = \"suspect_data\"}}";
    let output = bench(&folder, "a", &[fit, "process.phase=encoder"]);
    assert!(output.status.success(), "{output:?}");
    let found = summary(&folder.join("a/bench"));
    assert_eq!(
        (&found["status"], &found["ending"], &found["reason"]),
        (&"ok".into(), &"ok".into(), &Value::Null)
    );
    assert_eq!(found["judged"][0]["id"], "rig.saturated_fraction");
    let ids: Vec<&str> =
        found["warnings"].as_array().unwrap().iter().map(|warning| warning["id"].as_str().unwrap()).collect();
    assert!(ids.contains(&"fit.rejected") && ids.contains(&"range.stall_fraction"), "{ids:?}");
    assert!(String::from_utf8(output.stdout).unwrap().contains("bench: warning (fit.rejected)"));
    // The same in what is made of the samples.
    let output = wingbeat(&folder, &["rig", "process", "a", "--quiet"]);
    let processed = summary(&folder.join("a/processed"));
    let warned = processed["warnings"].to_string();
    assert!(warned.contains("fit.rejected"), "{warned} {output:?}");
}

#[test]
fn what_cannot_be_planned_or_simulated_ends_with_its_status() {
    let folder = scratch("rig-simulate-broken");
    // A wing in a wind that no cell bears, or no step follows.
    let output = bench(
        &folder,
        "a",
        &["rig.robot.wing.cd90=1e4", "wind_m_s=[1e4, 0.0, 0.0]", "limits.range.stall_fraction=1.0"],
    );
    let found = summary(&folder.join("a/bench"));
    assert_ne!(found["status"], "ok", "{output:?} {found}");
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    assert!(
        found["reason"].is_string() && ["ok", "fault"].contains(&found["ending"].as_str().unwrap()),
        "{found}"
    );

    // A turn that is too fast for the arm, in a list with one that is not: the folder is kept.
    let runs = |name: &str| root().join(format!("rigs/runs/{name}.toml"));
    let fast = format!("base = {:?}\nname = \"fast\"\nturn.speed_m_s = 50.0\n", runs("roll15_speed08"));
    fs::write(folder.join("fast.toml"), fast).unwrap();
    let slow = format!("base = {:?}\nname = \"slow\"\nhold.each_s = 0.5\n", runs("bench"));
    fs::write(folder.join("slow.toml"), slow).unwrap();
    fs::write(folder.join("both.toml"), "runs = [\"fast.toml\", \"slow.toml\"]\n").unwrap();
    let output = wingbeat(&folder, &["rig", "simulate", "both.toml", "--out", "b"]);
    assert_eq!(output.status.code(), Some(3), "{output:?}");
    let (fast, slow) = (summary(&folder.join("b/fast")), summary(&folder.join("b/slow")));
    assert_eq!((&fast["status"], &fast["ending"]), (&"not_found".into(), &"refused".into()));
    assert!(fast["stall_fraction"].is_null() && fast["samples"] == 0, "{fast}");
    assert_eq!((&slow["status"], &slow["ending"]), (&"ok".into(), &"ok".into()));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("not_found: fast: limit profile"), "{said}");

    // Where none can be planned nothing is kept, as of any bad input.
    let output = wingbeat(&folder, &["rig", "simulate", "fast.toml", "--out", "c"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(!entries(&folder).contains(&"c".into()));
}
