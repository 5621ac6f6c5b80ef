//! pynetft beside our recorder on the emulated Net F/T box.

use std::path::Path;

use serde_json::Value;

use super::script;
use crate::tools;

/// Largest difference of a force (N) or torque (N m) between two readers of the same counts.
const AGREEMENT: f64 = 1e-12;

/// Lets both read the emulator and prints how their forces and torques agree; false when they do not.
pub fn compare(python: &Path) -> bool {
    let worker = ["build", "--release", "--package", "wingbeat-netft", "--example", "netft_worker"];
    if !tools::succeeds(tools::cargo(&worker)) {
        return false;
    }
    let worker = tools::root().join("target/release/examples/netft_worker");
    let run = script(python, "netft.py", &[&worker.to_string_lossy()]);
    let Some(answer) = tools::output(run).and_then(|text| serde_json::from_str::<Value>(&text).ok()) else {
        return false;
    };
    println!("{}", table(&answer));
    let agrees = |key: &str| answer[key].as_f64().is_some_and(|difference| difference <= AGREEMENT);
    agrees("force_n") && agrees("torque_n_m") && answer["malformed"] == 0
}

fn table(answer: &Value) -> String {
    let rows = [
        ("samples read by pynetft 2.1.3", "samples"),
        ("lost, by pynetft", "lost"),
        ("duplicates, by pynetft", "duplicate"),
        ("malformed, by pynetft", "malformed"),
        ("reconnects, by pynetft", "reconnects"),
        ("largest difference of a force, N", "force_n"),
        ("largest difference of a torque, N m", "torque_n_m"),
    ];
    rows.iter().map(|(words, key)| format!("{words:38} {}\n", answer[*key])).collect()
}
