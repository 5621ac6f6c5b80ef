//! `wingbeat rig plan` as a user meets it: the way to the begin of a run, refusals.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::{root, scratch, wingbeat};

fn run(name: &str) -> String {
    root().join(format!("rigs/runs/{name}.toml")).to_string_lossy().into_owned()
}

fn rig(folder: &Path, arguments: &[&str]) -> Output {
    wingbeat(folder, &[&["rig"], arguments].concat())
}

/// The joint angles of a row of a Kortex file, deg.
fn joints(line: &str) -> Vec<f64> {
    line.split(',').skip(1).map(|cell| cell.trim().parse().unwrap()).collect()
}

#[test]
fn the_way_from_the_present_pose_ends_where_the_run_begins() {
    let folder = scratch("rig-plan-approach");
    let from = "20,30,-75,10,-80,15";
    let output = rig(&folder, &["plan", &run("roll15_speed07"), "--from-deg", from, "--out", "a"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{output:?}");
    assert!(text.contains("from the present pose") && text.contains("moveit-hard used to"), "{text}");
    let read = |name: &str| fs::read_to_string(folder.join("a").join(name)).unwrap();
    let (approach, turn) = (read("roll15_speed07_approach.csv"), read("roll15_speed07.csv"));
    let rows: Vec<&str> = approach.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())).collect();
    let first = joints(rows[0]);
    let (last, begin) =
        (joints(rows[rows.len() - 1]), joints(turn.lines().find(|l| l.starts_with('0')).unwrap()));
    let near = |a: f64, b: f64| ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs() < 1e-4;
    for (j, deg) in from.split(',').enumerate() {
        assert!(
            near(first[j], deg.parse().unwrap()) && near(last[j], begin[j]),
            "{first:?} {last:?} {begin:?}"
        );
    }
    for name in ["roll15_speed07_approach.yaml", "roll15_speed07_approach.json"] {
        assert!(folder.join("a").join(name).is_file());
    }
}

#[test]
fn what_cannot_be_planned_is_refused_with_what_to_do() {
    let folder = scratch("rig-plan-refused");
    let fast = run("roll15_speed09");
    for (file, more, parts) in [
        (&fast, ["--set", "profile=moveit-hard"], &["exceeds the limit", "keeps every limit at"][..]),
        (&fast, ["--set", "profile=cautious"], &["profile = cautious", "moveit-hard", "urdf"]),
        (&fast, ["--set", "turn.centre_m=[4.0, 4.0]"], &["roll15_speed09", "no place in the workspace"]),
        (&fast, ["--from-deg", "0,0,200,0,0,0"], &["from", "200", "deg"]),
        (&fast, ["--from-deg", "0,0"], &["6 finite joint positions"]),
    ] {
        let output = rig(&folder, &["plan", file, "--out", "a", more[0], more[1]]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{more:?}: {message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{more:?}: {message}"));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "{more:?}");
    }
    let simulated =
        rig(&folder, &["simulate", &fast, "--out", "a", "--set", "profile=moveit-hard", "--quiet"]);
    let message = String::from_utf8(simulated.stderr).unwrap();
    assert!(simulated.status.code() == Some(2) && message.contains("exceeds the limit"), "{message}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}
