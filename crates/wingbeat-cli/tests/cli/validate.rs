//! `wingbeat validate` hands over to the program of the comparisons.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::scratch;

/// A copy of the program in `folder`, where no other program stands.
fn copied(folder: &Path) -> PathBuf {
    let program = folder.join("wingbeat");
    fs::copy(env!("CARGO_BIN_EXE_wingbeat"), &program).unwrap();
    program
}

#[test]
fn a_program_alone_says_how_the_comparisons_are_had() {
    let folder = scratch("validate-alone");
    let output = Command::new(copied(&folder)).args(["validate", "--only", "linkage"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("`cargo build --release -p wingbeat-validate`"), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
}

#[test]
fn arguments_and_exit_code_pass_unchanged() {
    let folder = scratch("validate-beside");
    let beside = folder.join("wingbeat-validate");
    fs::write(&beside, "#!/bin/sh\necho \"$$ $*\"\nexit 7\n").unwrap();
    fs::set_permissions(&beside, fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(copied(&folder));
    let arguments = ["validate", "--only", "linkage", "--quick", "--quiet", "--json", "a file.json"];
    let child = command.args(arguments).stdout(std::process::Stdio::piped()).spawn().unwrap();
    // The same process, so that signals reach the comparisons.
    let said = format!("{} --only linkage --quick --quiet --json a file.json\n", child.id());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(7), "{output:?}");
    assert_eq!(String::from_utf8_lossy(&output.stdout), said);
}

#[test]
fn what_the_comparisons_do_not_take_is_refused_before() {
    let folder = scratch("validate-refused");
    let output = Command::new(copied(&folder)).args(["validate", "--onyl", "linkage"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--only"), "{output:?}");
}
