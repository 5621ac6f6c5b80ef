//! The program: its folder, its messages and its exit codes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An empty folder for one test.
fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The program with `arguments`, run in `folder`.
fn compared(folder: &Path, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_wingbeat-validate"));
    program.args(arguments).current_dir(folder).output().unwrap()
}

/// Names in `folder`, sorted.
fn entries(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}

#[test]
fn a_comparison_leaves_its_rows_and_its_figure() {
    let folder = scratch("validate-whole");
    let arguments = ["--only", "linkage", "--quiet", "--out", "a"];
    let output = compared(&folder, &arguments);
    assert!(output.status.success(), "{output:?}");
    let names = ["figures", "manifest.json", "rows.csv", "rows.json", "summary.json"];
    assert_eq!(entries(&folder.join("a")), names);
    assert_eq!(entries(&folder.join("a/figures")), ["linkage.png", "linkage.svg"]);
    let rows = fs::read_to_string(folder.join("a/rows.csv")).unwrap();
    assert!(rows.starts_with("id,source,metric,unit,value,limit,pass\nlinkage.cycle,"), "{rows}");
    assert!(fs::read_to_string(folder.join("a/summary.json")).unwrap().contains("\"passed\": 1"));

    let again = compared(&folder, &arguments);
    assert_eq!(again.status.code(), Some(2), "{again:?}");
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force"), "{again:?}");
    assert_eq!(entries(&folder), ["a"]);
}

#[test]
fn an_unknown_comparison_leaves_nothing() {
    let folder = scratch("validate-unknown");
    let output = compared(&folder, &["--only", "linkag", "--out", "a"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("linkag: no such comparison") && message.contains("linkage.cycle"), "{message}");
    assert!(entries(&folder).is_empty());
}

#[test]
fn a_long_comparison_is_run_when_it_is_asked_for() {
    let folder = scratch("validate-long");
    let output = compared(&folder, &["--only", "flight.draws"]);
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("flight.draws: it takes minutes and is run with --long"), "{message}");
    let output = compared(&folder, &["--quick", "--only", "calibrate.scherer"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("leave --quick out") && output.status.code() == Some(2), "{message}");
    let output = compared(&folder, &["--long", "--only", "flight.drawn"]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("no such comparison") && message.contains("flight.draws.level_20g"),
        "{message}"
    );
}
