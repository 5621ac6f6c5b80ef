//! `cargo xtask bench --against REVISION`: the running times of this tree and of another revision, run in turns on one machine, so that
//! their ratios hold wherever it is slower than another.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::{documents, peers, tools};

/// Rounds in which the two programs take turns; the least time of each row counts, as other work of the machine only adds to it.
const ROUNDS: usize = 5;
/// The first version that flew its controller by both presets and has the rows of today.
const FIRST: &str = "394631f9";

/// A row of the running times: what, time or number, unit.
type BenchRow = (String, f64, String);

/// The running times, beside those of another revision where the arguments name one.
pub fn bench(arguments: &[String]) -> bool {
    match arguments {
        [] => tools::succeeds(tools::cargo(&["bench", "--workspace", "--bench", "running_times"])),
        [flag, revision] if flag == "--against" => compare(revision),
        _ => {
            eprintln!("error: cargo xtask bench takes --against REVISION or nothing");
            false
        }
    }
}

/// The same beside the first version that flew, as a table of docs/performance.md.
pub fn first() -> bool {
    compared(FIRST).is_some_and(|table| {
        println!("{table}");
        documents::put_into("docs/performance.md", "first", &table)
    })
}

fn compare(revision: &str) -> bool {
    let table = compared(revision);
    println!("{}", table.as_deref().unwrap_or_default());
    table.is_some()
}

/// The table of this tree and a revision; none where one of them cannot be built or run.
fn compared(revision: &str) -> Option<String> {
    commit(revision).and_then(|commit| {
        let folder = taken_out(&commit)?;
        let programs = [built(&tools::root())?, built(&folder)?];
        let mut least = [HashMap::new(), HashMap::new()];
        let mut rows = Vec::new();
        for round in 0..ROUNDS {
            println!("round {} of {ROUNDS}", round + 1);
            // Whoever runs second finds a warmer processor: they change places.
            for turn in [round % 2, 1 - round % 2] {
                let read = read(&tools::output(Command::new(&programs[turn]))?);
                for (name, value, _) in &read {
                    let known = least[turn].entry(name.clone()).or_insert(*value);
                    *known = value.min(*known);
                }
                if turn == 0 {
                    rows = read;
                }
            }
        }
        Some(table(&rows, &least, &commit))
    })
}

/// The commit that a revision names, in ten digits.
fn commit(revision: &str) -> Option<String> {
    let mut git = Command::new("git");
    git.args(["rev-parse", "--short=10", "--verify", &format!("{revision}^{{commit}}")])
        .current_dir(tools::root());
    let found = tools::output(git).map(|text| text.trim().to_owned());
    if found.is_none() {
        eprintln!("error: no revision {revision} in this clone (git fetch --unshallow fetches all of them)");
    }
    found
}

/// The tree of a commit, in a folder of its own under target; it stays there for the next time.
fn taken_out(commit: &str) -> Option<PathBuf> {
    let folder = tools::root().join("target/against").join(commit);
    if folder.exists() {
        return Some(folder);
    }
    // Under its name only once it is whole.
    let part = folder.with_extension("part");
    if part.exists() {
        std::fs::remove_dir_all(&part).ok()?;
    }
    std::fs::create_dir_all(&part).ok()?;
    let mut archive = Command::new("git");
    archive.args(["archive", commit]).current_dir(tools::root()).stdout(Stdio::piped());
    let mut archive = archive.spawn().ok()?;
    let mut tar = Command::new("tar");
    tar.arg("-x").current_dir(&part).stdin(archive.stdout.take()?);
    let unpacked = tools::succeeds(tar);
    if !archive.wait().ok()?.success() || !unpacked {
        return None;
    }
    std::fs::rename(part, &folder).ok()?;
    Some(folder)
}

/// The bench of a tree, built with the target folder of that tree.
pub fn built(tree: &Path) -> Option<PathBuf> {
    let build = ["bench", "--workspace", "--bench", "running_times", "--no-run", "--message-format", "json"];
    let mut cargo = tools::cargo(&build);
    cargo.current_dir(tree);
    if tree != tools::root() {
        cargo.env("CARGO_TARGET_DIR", tree.join("target"));
    }
    let output = tools::output(cargo)?;
    let path = |line: &str| {
        let artifact: serde_json::Value = serde_json::from_str(line).ok()?;
        let named = artifact["target"]["name"] == "running_times";
        named.then(|| artifact["executable"].as_str().map(PathBuf::from))?
    };
    output.lines().find_map(path)
}

/// The rows that a bench prints: a name, a number, and a unit where it has one.
fn read(text: &str) -> Vec<BenchRow> {
    let row = |line: &str| {
        let (rest, last) = line.trim_end().rsplit_once(' ')?;
        if let Ok(value) = last.parse() {
            return Some((rest.trim_end().to_owned(), value, String::new()));
        }
        let (name, value) = rest.trim_end().rsplit_once(' ')?;
        Some((name.trim_end().to_owned(), value.parse().ok()?, last.to_owned()))
    };
    text.lines().filter_map(row).collect()
}

/// Both least times of every row that has a time on both sides, as Markdown.
fn table(rows: &[BenchRow], least: &[HashMap<String, f64>; 2], commit: &str) -> String {
    let mut table = format!("| what | here | {commit} | here / {commit} |\n|---|---:|---:|---:|");
    for (name, _, unit) in rows.iter().filter(|row| matches!(row.2.as_str(), "ns" | "us" | "ms" | "s")) {
        if let (Some(own), Some(other)) = (least[0].get(name), least[1].get(name)) {
            table += &format!("\n| {name} | {own} {unit} | {other} {unit} | {:.2} |", own / other);
        }
    }
    table + &format!("\n\nLeast of {ROUNDS} rounds in turns; {}", peers::circumstances(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_and_paired_by_their_names() {
        let text = "paper, 12 strips: evaluation of the plant       0.832 us\nfull:   in evaluations    30.7 
x: real-time factor  5.4\nnoise";
        let rows = read(text);
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[0], ("paper, 12 strips: evaluation of the plant".into(), 0.832, "us".into()));
        let side = |value: f64| HashMap::from([(rows[0].0.clone(), value), (rows[1].0.clone(), 30.0)]);
        let table = table(&rows, &[side(0.5), side(1.0)], "abc");
        assert!(
            table.contains("| paper, 12 strips: evaluation of the plant | 0.5 us | 1 us | 0.50 |"),
            "{table}"
        );
        // A number without a unit of time is no time.
        assert!(!table.contains("in evaluations"), "{table}");
    }

    #[test]
    fn a_revision_that_is_not_there_is_refused() {
        assert!(!bench(&["--against".into(), "no-such-revision".into()]));
        assert!(!bench(&["--since".into()]));
    }
}
