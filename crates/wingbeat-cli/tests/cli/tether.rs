//! `wingbeat tether` as a user meets it: run folders, tables from CSV, messages, exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::{entries, root, scratch};

fn cases() -> PathBuf {
    root().join("cases")
}

fn tether(folder: &Path, case: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wingbeat"));
    command.arg("tether").arg(case).args(more).current_dir(folder).output().unwrap()
}

#[test]
fn a_case_leaves_a_whole_folder_and_a_table() {
    let folder = scratch("tether-whole");
    let output = tether(&folder, &cases().join("flap_f2.toml"), &["--out", "a"]);
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("CL") && text.contains("knows no stall") && text.contains("run folder: a"),
        "{text}"
    );
    let names =
        ["case.toml", "figures", "loads.csv", "manifest.json", "means.csv", "strips.parquet", "summary.json"];
    assert_eq!(entries(&folder.join("a")), names);
    assert_eq!(entries(&folder.join("a/figures")), ["loads.png", "loads.svg", "span.png", "span.svg"]);
    let again = tether(&folder, Path::new("a/case.toml"), &["--out", "b", "--quiet"]);
    assert!(again.status.success() && again.stdout.is_empty(), "{again:?}");
    let loads = |run: &str| fs::read_to_string(folder.join(run).join("loads.csv")).unwrap();
    assert!(loads("a") == loads("b"));
}

#[test]
fn a_coordinate_may_be_a_table() {
    let folder = scratch("tether-table");
    let rows = (0..=40).map(|i| {
        let phase = f64::from(i) / 40.0;
        format!("{},{}\n", phase / 3.5, 35.0 * (std::f64::consts::TAU * phase).sin())
    });
    fs::write(folder.join("stroke.csv"), "t,angle\n".to_owned() + &rows.collect::<String>()).unwrap();
    let text = fs::read_to_string(cases().join("flap_f2.toml")).unwrap();
    let table = "table = { file = \"stroke.csv\", column = \"angle\", periodic = true }";
    fs::write(folder.join("case.toml"), text.replace("fourier = { sin = [35.0] }", table)).unwrap();
    let output = tether(&folder, Path::new("case.toml"), &["--out", "a"]);
    assert!(output.status.success(), "{output:?}");
    let again = tether(&folder, Path::new("a/case.toml"), &["--out", "again"]);
    assert!(again.status.success() && folder.join("again/stroke.csv").is_file(), "{again:?}");
    fs::write(folder.join("stroke.csv"), "t,angle\n0,1\n0.1,x\n").unwrap();
    let output = tether(&folder, Path::new("case.toml"), &["--out", "b"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(
        message.contains("case.toml:") && message.contains("line 3") && message.contains("`x`"),
        "{message}"
    );
    assert!(!folder.join("b").exists());
}

#[test]
fn bad_input_is_one_message_and_no_folder() {
    let folder = scratch("tether-bad");
    for (set, part) in [
        ("time.cycles=0", "1 or more"),
        ("wing.cd0=nan", "finite"),
        ("wing.hinges[0].arc_m=9.0", "the tip"),
        ("aero.full.strips=0", "strips"),
    ] {
        let output = tether(&folder, &cases().join("flap_f2.toml"), &["--set", set]);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{message}");
        assert!(message.contains(part), "{message}");
    }
    assert!(entries(&folder).is_empty());
}
