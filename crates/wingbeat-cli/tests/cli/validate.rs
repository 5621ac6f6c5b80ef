//! `wingbeat validate` hands over to the program of the comparisons.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::scratch;

/// A copy of the program in `folder`, where no other program stands.
fn copied(folder: &Path) -> PathBuf {
    placed(Path::new(env!("CARGO_BIN_EXE_wingbeat")), folder.join("wingbeat"))
}

/// A copy of a program that may be run at once. It is another process that writes it: a file that this one has open for writing
/// would be open, and so busy, in whatever the tests beside it start.
fn placed(from: &Path, to: PathBuf) -> PathBuf {
    assert!(Command::new("cp").arg(from).arg(&to).status().unwrap().success());
    to
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
    let script = folder.join("script");
    fs::write(&script, "#!/bin/sh\necho \"$$ $*\"\nexit 7\n").unwrap();
    fs::set_permissions(&script, fs::Permissions::from_mode(0o755)).unwrap();
    placed(&script, folder.join("wingbeat-validate"));
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
