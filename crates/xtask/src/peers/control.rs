//! Predictive control beside CasADi, in turn on the same instances of FLAPBODY-14 A.

use std::path::Path;

use serde_json::Value;

use super::{circumstances, script};
use crate::{documents, tools};

/// Times each instance is solved by each program; the best counts.
const REPEATS: usize = 7;

/// Runs both sides in turn on every instance, prints the table and puts it into docs/performance.md.
pub fn compare(python: &Path) -> bool {
    // The plant is of the comparisons, which only benches optimise.
    let worker =
        ["build", "--profile", "bench", "--package", "wingbeat-comparisons", "--example", "flapbody_worker"];
    if !tools::succeeds(tools::cargo(&worker)) {
        return false;
    }
    let root = tools::root();
    let path = |below: &str| root.join(below).to_string_lossy().into_owned();
    let arguments = [
        path("target/release/examples/flapbody_worker"),
        path("validation/flapbody14/instances.csv"),
        path("target/peers/flapbody14"),
        REPEATS.to_string(),
    ];
    let run = script(python, "flapbody14.py", &arguments.each_ref().map(String::as_str));
    let Some(answer) = tools::output(run).and_then(|text| serde_json::from_str::<Value>(&text).ok()) else {
        return false;
    };
    let table = table(&answer["rows"]);
    println!("{table}");
    documents::put_into(
        "docs/performance.md",
        "flapbody14",
        &format!("{table}\n\n{}", circumstances(&["casadi"])),
    )
}

fn table(rows: &Value) -> String {
    let mut text = String::from(
        "| solver | median us | 99 % us | times the first | input error, median | max |\n|---|---:|---:|---:|---:|---:|",
    );
    let rows: &[Value] = rows.as_array().map_or(&[], Vec::as_slice);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap_or(f64::NAN);
    for row in rows {
        text += &format!(
            "\n| {} | {:.1} | {:.1} | {:.1} | {:.0e} | {:.0e} |",
            row["solver"].as_str().unwrap_or("?"),
            number(row, "median_us"),
            number(row, "p99_us"),
            number(row, "median_us") / number(&rows[0], "median_us"),
            number(row, "input_error_median"),
            number(row, "input_error_max"),
        );
    }
    text
}
