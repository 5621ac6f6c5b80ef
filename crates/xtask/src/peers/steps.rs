//! Steps of the environments beside MuJoCo's steps of a tree without air.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::{circumstances, peers, script};
use crate::{documents, python, tools};

/// Largest difference of MuJoCo's accelerations from those of the reference tree, relative.
const AGREEMENT: f64 = 1e-9;

/// The Python of an environment with the package and MuJoCo.
pub fn environment() -> Option<PathBuf> {
    python::with_package(&peers().join("steps.txt"), "target/peers-steps")
}

/// Runs both sides in turns, prints the table and puts it into docs/performance.md.
pub fn compare(python: &Path) -> bool {
    let folder = tools::root().join("validation/multibody");
    let run = script(python, "steps.py", &[&folder.to_string_lossy()]);
    let Some(answer) = tools::output(run).and_then(|text| serde_json::from_str::<Value>(&text).ok()) else {
        return false;
    };
    let table = table(&answer);
    println!("{table}");
    let table = format!("{table}\n\n{}", circumstances(&["mujoco"]));
    let agrees = answer["difference"].as_f64().is_some_and(|difference| difference <= AGREEMENT);
    agrees && documents::put_into("docs/performance.md", "steps", &table)
}

fn table(answer: &Value) -> String {
    let clock = answer["clock_ghz"].as_f64().unwrap_or(f64::NAN);
    let mut text = format!(
        "| 5 ms in steps of 1 ms, for each robot | median us | least to most | thousand cycles at {clock:.2} GHz |\n|---|---:|---:|---:|"
    );
    for (what, times) in answer["rows"].as_object().into_iter().flatten() {
        let [median, least, most] = [0, 1, 2].map(|i| times[i].as_f64().unwrap_or(f64::NAN));
        text += &format!("\n| {what} | {median:.1} | {least:.1} to {most:.1} | {:.1} |", median * clock);
    }
    text
}
