//! `cargo xtask long doors`: a law, a motor, a sensor, a figure, a verb and a summary quantity come in by a new file and a few lines. The patches of
//! crates/xtask/doors bring one of each into a copy of this tree, which is built, tested and run.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

use crate::report::Tally;
use crate::tools;

/// Folder of the patches.
const PATCHES: &str = "crates/xtask/doors";
/// The copy, with what is built of it and run in it.
const COPY: &str = "target/doors/tree";

/// What comes in by a patch.
struct Door {
    /// Name of the patch.
    name: &'static str,
    /// Most lines in files that were there, without comments.
    lines: usize,
    /// A command that uses it, what that leaves, and a word that stands in it.
    call: &'static [&'static str],
    leaves: &'static str,
    says: &'static str,
}

const DOORS: [Door; 6] = [
    Door {
        name: "law",
        lines: 2,
        call: &["fly", "scenarios/glide.toml", "--set", "aero.law=late", "--out", "law"],
        leaves: "law/summary.json",
        says: "\"lift_law\": \"late\"",
    },
    Door {
        name: "motor",
        lines: 2,
        call: &[
            "fly",
            "scenarios/motor_flapper.toml",
            "--set",
            "robot.drive={servo={torque_n_m=0.05, inertia_kg_m2=1e-5}}",
            "--set",
            "flight.duration_s=0.5",
            "--out",
            "motor",
        ],
        leaves: "motor/summary.json",
        says: "crank_ripple",
    },
    Door {
        name: "sensor",
        lines: 2,
        call: &[
            "fly",
            "scenarios/estimator_20g.toml",
            "--set",
            "sensors.flow={ground_m=-2.0, every_s=0.01, flow_rad_s=0.1}",
            "--set",
            "flight.duration_s=0.5",
            "--out",
            "sensor",
        ],
        leaves: "sensor/summary.json",
        says: "estimate",
    },
    Door {
        name: "figure",
        lines: 2,
        call: &["fly", "scenarios/glide.toml", "--set", "flight.duration_s=0.2", "--out", "figure"],
        leaves: "figure/figures/altitude.png",
        says: "",
    },
    Door { name: "verb", lines: 2, call: &["rows", "figure"], leaves: "figure/record.parquet", says: "" },
    Door {
        name: "quantity",
        lines: 2,
        call: &["fly", "scenarios/glide.toml", "--set", "flight.duration_s=0.2", "--out", "quantity"],
        leaves: "quantity/summary.json",
        says: "speed_max_m_s",
    },
];

/// Counts the lines of each patch, then builds, tests and runs them all in one copy.
pub fn check() -> Tally {
    let mut tally = Tally::default();
    let copy = tools::root().join(COPY);
    if let Err(error) = copied(&copy) {
        eprintln!("error: {}: {error}", copy.display());
        return Tally::one(false);
    }
    for door in &DOORS {
        let patch = format!("{PATCHES}/{}.patch", door.name);
        tally += Tally::one(counted(door, &patch));
        tally += Tally::one(applied(&["--directory", COPY, &patch]));
    }
    let target = tools::root().join("target/doors/target");
    let mut tests = tools::cargo(&["test"]);
    tests.args(tools::TESTS).current_dir(&copy).env("CARGO_TARGET_DIR", &target);
    // Generated pages do not know the new parts before `cargo xtask reference`.
    tests.args([
        "--no-fail-fast",
        "--",
        "law",
        "crank",
        "drive",
        "sensor",
        "estimator",
        "--skip",
        "the_page_of",
    ]);
    tally += Tally::of(tests);
    for door in &DOORS {
        tally += Tally::one(used(door, &copy, &target.join("release/wingbeat")));
    }
    tally
}

/// A new copy of the files of this tree, their times kept so that what is built stays.
fn copied(copy: &Path) -> io::Result<()> {
    let mut list = Command::new("git");
    list.args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"]).current_dir(tools::root());
    let files = tools::output(list).ok_or(io::ErrorKind::NotFound)?;
    if copy.exists() {
        fs::remove_dir_all(copy)?;
    }
    for file in files.split('\0').filter(|file| !file.is_empty()) {
        let (from, to) = (tools::root().join(file), copy.join(file));
        if !from.is_file() {
            continue;
        }
        fs::create_dir_all(to.parent().unwrap_or(copy))?;
        fs::copy(&from, &to)?;
        fs::File::options().write(true).open(&to)?.set_modified(fs::metadata(&from)?.modified()?)?;
    }
    Ok(())
}

/// Whether git takes a patch as `arguments` say.
fn applied(arguments: &[&str]) -> bool {
    let mut apply = Command::new("git");
    apply.arg("apply").args(arguments).current_dir(tools::root());
    tools::succeeds(apply)
}

/// Prints what a patch takes beside its new file; whether that is no more than the door allows.
fn counted(door: &Door, patch: &str) -> bool {
    let text = fs::read_to_string(tools::root().join(patch)).unwrap_or_default();
    let PatchCost { new, touched, lines, inside } = PatchCost::of(&text);
    println!(
        "{:<8} new files {new} with {inside} lines, files touched {touched}, lines in them {lines}",
        door.name
    );
    new == 1 && touched == 1 && lines <= door.lines && inside <= 40
}

/// What a patch takes, comments and empty lines not counted.
#[derive(Debug, Default, PartialEq)]
struct PatchCost {
    new: usize,
    touched: usize,
    /// Lines added in files that were there.
    lines: usize,
    /// Lines of new files.
    inside: usize,
}

impl PatchCost {
    fn of(patch: &str) -> Self {
        let mut taken = Self::default();
        let mut in_new = false;
        // A hunk follows the names of its file, or another of the same.
        let mut named = false;
        for line in patch.lines() {
            if line.starts_with("+++ ") {
                named = true;
            } else if line.starts_with("@@ ") {
                in_new = line.starts_with("@@ -0,0 ");
                *(if in_new { &mut taken.new } else { &mut taken.touched }) += usize::from(named);
                named = false;
            } else if let Some(added) = line.strip_prefix('+') {
                let counts = !added.trim().is_empty() && !added.trim_start().starts_with("//");
                *(if in_new { &mut taken.inside } else { &mut taken.lines }) += usize::from(counts);
            }
        }
        taken
    }
}

/// Runs what uses a door; whether that is there which it should leave.
fn used(door: &Door, copy: &Path, program: &PathBuf) -> bool {
    let mut call = Command::new(program);
    call.args(door.call).current_dir(copy);
    let output = call.output();
    let code = output.as_ref().ok().and_then(|output| output.status.code());
    // A verdict other than ok keeps the run: the part flies as well as the document of another one lets it.
    let summary = fs::read_to_string(copy.join(door.leaves)).unwrap_or_default();
    let flown = !summary.contains("\"status\": \"failed\"");
    let passed = matches!(code, Some(0 | 3))
        && copy.join(door.leaves).is_file()
        && flown
        && summary.contains(door.says);
    if !passed {
        eprintln!("{}: {output:?}", door.name);
    }
    passed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_counted_by_its_files_and_lines() {
        let patch = "\
--- a/old.rs
+++ b/old.rs
@@ -1,2 +1,3 @@
 kept
+mod new;
+    // said
@@ -9,2 +10,3 @@
+    New(new),
--- a/new.rs
+++ b/new.rs
@@ -0,0 +1,4 @@
+//! Said.
+
+fn new() {}
";
        assert_eq!(PatchCost::of(patch), PatchCost { new: 1, touched: 1, lines: 2, inside: 1 });
    }

    #[test]
    fn the_doors_fit_this_tree_and_are_as_narrow_as_they_are_said_to_be() {
        for door in &DOORS {
            let patch = format!("{PATCHES}/{}.patch", door.name);
            assert!(counted(door, &patch) && applied(&["--check", &patch]), "{patch}");
        }
    }
}
