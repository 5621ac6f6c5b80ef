//! Predictive control beside CasADi, in turn on the same instances of FLAPBODY-14 A.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use super::script;
use crate::{documents, tools};

/// Times each instance is solved by each program; the best counts.
const REPEATS: usize = 7;

/// Runs both sides in turn on every instance, prints the table and puts it into docs/performance.md.
pub fn compare(python: &Path) -> bool {
    let worker = ["build", "--release", "--package", "wingbeat-validate", "--example", "flapbody_worker"];
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
        &format!("{table}\n\n{}", circumstances(&answer)),
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

/// Date, machine and versions.
fn circumstances(answer: &Value) -> String {
    let casadi = answer["casadi"].as_str().unwrap_or("?");
    let date = first_line("date", &["-u", "+%Y-%m-%d"]);
    let (rustc, cc) = (first_line("rustc", &["--version"]), first_line("cc", &["--version"]));
    format!("{date}; {}; CasADi {casadi}, {rustc}, {cc}.", machine())
}

/// First line that a program prints.
fn first_line(program: &str, arguments: &[&str]) -> String {
    let mut command = Command::new(program);
    command.args(arguments);
    tools::output(command)
        .and_then(|text| text.lines().next().map(String::from))
        .unwrap_or_else(|| "?".into())
}

/// Model of the processor.
fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{}, {cores} cores", model.map_or("unknown processor", |(_, name)| name))
}
