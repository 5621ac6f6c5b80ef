//! The program as a user meets it: run folders, tables, messages, exit codes.

mod average;
mod calibrate;
mod fly;
mod migrate;
mod new;
mod paper;
mod plan;
#[cfg(unix)]
mod record;
mod report;
mod rig_beside;
mod rig_faults;
mod rig_plan;
mod rig_process;
mod rig_simulate;
mod seeing;
mod sweep;
mod tether;
#[cfg(unix)]
mod validate;
mod wake;
mod wake_flight;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The root of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// An empty folder for one test.
fn scratch(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The program with `arguments`, run in `folder`.
fn wingbeat(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_wingbeat")).args(arguments).current_dir(folder).output().unwrap()
}

/// Names in `folder`, sorted.
fn entries(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = names.collect();
    names.sort();
    names
}
