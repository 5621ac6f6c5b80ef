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
        (&run("roll15_speed08"), ["--set", "rig.mount.link.mass_kg=6"], &["torque", "exceeds the limit"]),
        (&fast, ["--set", "turn.speed_m_s=10000"], &["turn.speed_m_s = 10000", "a way of at most 1000 m"]),
        (&fast, ["--set", "profile=cautious"], &["profile = cautious", "moveit-hard", "urdf"]),
        (&fast, ["--set", "turn.centre_m=[4.0, 4.0]"], &["roll15_speed09", "no place in the workspace"]),
        (&fast, ["--from-deg", "0,0,200,0,0,0"], &["--from-deg.joint_3 = 200", "deg"]),
        (&fast, ["--from-deg", "0,0"], &["--from-deg = [0.0, 0.0]", "6 finite joint positions"]),
    ] {
        let output = rig(&folder, &["plan", file, "--out", "a", more[0], more[1]]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{more:?}: {message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{more:?}: {message}"));
        // Torque that bears weight does not go with the speed.
        assert!(!message.contains("torque") || !message.contains("keeps every limit"), "{message}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "{more:?}");
    }
    let simulated =
        rig(&folder, &["simulate", &fast, "--out", "a", "--set", "profile=moveit-hard", "--quiet"]);
    let message = String::from_utf8(simulated.stderr).unwrap();
    assert!(simulated.status.code() == Some(2) && message.contains("exceeds the limit"), "{message}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}

/// The Kinova Gen3 of `rigs/arms` as a URDF file.
fn gen3_urdf() -> String {
    let frames = [
        ("0 0 0.15643", "-3.141592653589793 0 0", None),
        ("0 0.005375 -0.12838", "1.5707963267948966 0 0", Some(2.24)),
        ("0 -0.41 0", "3.141592653589793 0 0", Some(2.57)),
        ("0 0.20843 -0.006375", "1.5707963267948966 0 0", None),
        ("0 -0.00017505 -0.10593", "-1.5707963267948966 0 0", Some(2.09)),
        ("0 0.10593 -0.00017505", "1.5707963267948966 0 0", None),
    ];
    let mut text = String::from("<robot name=\"gen3\">\n<link name=\"base\"/>\n");
    let mut parent = "base".to_owned();
    for (i, (xyz, rpy, limit)) in frames.iter().enumerate() {
        let range = limit.map_or(String::new(), |l| format!("lower=\"-{l}\" upper=\"{l}\" "));
        let kind = if limit.is_some() { "revolute" } else { "continuous" };
        let speed = if i < 3 { 1.3963 } else { 1.2218 };
        text += &format!(
            "<link name=\"l{i}\"><inertial><mass value=\"0.8\"/>\
             <inertia ixx=\"2e-3\" ixy=\"0\" ixz=\"0\" iyy=\"2e-3\" iyz=\"0\" izz=\"1e-3\"/></inertial></link>\n\
             <joint name=\"j{i}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"l{i}\"/>\
             <origin xyz=\"{xyz}\" rpy=\"{rpy}\"/><axis xyz=\"0 0 1\"/>\
             <limit {range}effort=\"39\" velocity=\"{speed}\"/></joint>\n"
        );
        parent = format!("l{i}");
    }
    for (name, z) in [("tool", "-0.061525"), ("camera", "-0.05")] {
        text += &format!(
            "<link name=\"{name}\"/><joint name=\"to_{name}\" type=\"fixed\"><parent link=\"{parent}\"/>\
             <child link=\"{name}\"/><origin xyz=\"0 0 {z}\" rpy=\"3.141592653589793 0 -3.141592653589793\"/>\
             </joint>\n"
        );
    }
    text + "</robot>\n"
}

#[test]
fn an_arm_may_be_a_urdf_file() {
    let folder = scratch("rig-plan-urdf");
    fs::write(folder.join("gen3.urdf"), gen3_urdf()).unwrap();
    let file = run("roll15_speed07");
    let arm = |name: &str| format!("rig.arm={}", folder.join(name).display());
    let output = rig(
        &folder,
        &["plan", &file, "--out", "a", "--set", &arm("gen3.urdf#tool"), "--set", "profile=urdf"],
    );
    assert!(output.status.success(), "{output:?}");
    assert!(folder.join("a/roll15_speed07.csv").is_file());
    let whole = gen3_urdf();
    fs::write(folder.join("cut.urdf"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.join("other.urdf"), "joints: 6\n").unwrap();
    for (name, part) in [
        ("gen3.urdf", "camera"),
        ("gen3.urdf#wrist", "wrist"),
        ("cut.urdf", "not a URDF file"),
        ("other.urdf", "no <robot> element"),
        ("none.urdf", "No such file"),
    ] {
        let output = rig(&folder, &["plan", &file, "--out", "b", "--set", &arm(name)]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{name}: {message}");
        assert!(message.contains("rig.arm") && message.contains(part), "{name}: {message}");
        assert!(!folder.join("b").exists(), "{name}");
    }
}

#[test]
fn a_present_pose_beyond_all_turns_is_refused() {
    let folder = crate::scratch("rig_plan_far");
    let run = crate::root().join("rigs/runs/bench.toml");
    for far in ["1e300,0,0,0,0,0", "0,0,0,0,0,nan"] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_wingbeat"));
        command.args(["rig", "plan"]).arg(&run).args(["--from-deg", far, "--out", "plan"]);
        let output = command.current_dir(&folder).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("--from-deg") && !text.contains("panicked"), "{text}");
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
}
