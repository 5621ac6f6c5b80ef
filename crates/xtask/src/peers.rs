//! Running times beside those of other programs, measured in the same run.

mod control;
mod lattice;
mod netft;
mod steps;

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{against, documents, tools};

/// Rounds in which the programs take turns; the median of each counts.
const ROUNDS: usize = 3;

type Times = HashMap<String, f64>;

/// Rows of the table: what, our name of it, the other program, its name of what it is compared with.
const ROWS: [(&str, &str, &str, &str); 14] = [
    ("forward dynamics, 10-dof tree", "forward_dynamics", "Pinocchio 4.1.0", "forward_dynamics"),
    ("plant of Aerobat, paper, 9 strips", "plant_paper_9", "Pinocchio 4.1.0", "forward_dynamics"),
    ("plant of Aerobat, full, 9 strips", "plant_full_9", "Pinocchio 4.1.0", "forward_dynamics"),
    ("plant of Aerobat, paper, 16 strips", "plant_paper_16", "Pinocchio 4.1.0", "forward_dynamics"),
    ("plant of Aerobat, full, 16 strips", "plant_full_16", "Pinocchio 4.1.0", "forward_dynamics"),
    ("flapping wing F2, paper, per simulated second", "flap_f2_paper", "PteraSoftware 5.1.0", "flap_f2"),
    ("flapping wing F2, full, per simulated second", "flap_f2_full", "PteraSoftware 5.1.0", "flap_f2"),
    ("vortex lattice of F2, prescribed wake", "lattice_prescribed", "PteraSoftware 5.1.0", "flap_f2"),
    ("the same, both halves computed", "lattice_prescribed_whole", "PteraSoftware 5.1.0", "flap_f2"),
    ("vortex lattice of F2, free wake", "lattice_free", "PteraSoftware 5.1.0", "flap_f2_free"),
    ("the same by multipoles", "lattice_free_fast", "PteraSoftware 5.1.0", "flap_f2_free"),
    ("the same, both halves computed, directly", "lattice_free_whole", "PteraSoftware 5.1.0", "flap_f2_free"),
    ("FLAPBODY-14 B, 100 intervals", "flapbody14_b", "CasADi 3.8.2 + IPOPT", "flapbody14_b"),
    (
        "the same",
        "flapbody14_b",
        "IPOPT without the evaluation of the functions",
        "flapbody14_b_without_evaluation",
    ),
];

/// Runs both sides with the given Python; false when it fails.
type PeerComparison = fn(&Path) -> bool;

/// The comparisons by name.
const COMPARISONS: [(&str, PeerComparison); 7] = [
    ("mechanics", mechanics),
    ("lattice", lattice::compare),
    ("control", control::compare),
    ("offline", offline),
    ("netft", netft::compare),
    ("steps", steps::compare),
    (OF_THE_FIRST, |_| against::first()),
];

/// The comparison that has an environment of its own: it needs the package and none of the other programs.
const OF_THE_PACKAGE: &str = "steps";
/// The comparison with the first version of our own, without any Python.
const OF_THE_FIRST: &str = "first";

/// Makes the environment of the other programs and runs the comparison called `only`, or all.
pub fn compare(only: Option<&str>) -> bool {
    let chosen: Vec<_> =
        COMPARISONS.iter().filter(|(name, _)| only.is_none_or(|only| only == *name)).collect();
    if chosen.is_empty() {
        let names = COMPARISONS.map(|(name, _)| name).join(", ");
        eprintln!("error: no comparison {}; there are {names}", only.unwrap_or_default());
        return false;
    }
    chosen.iter().all(|(name, run)| {
        let python = match *name {
            OF_THE_FIRST => Some(PathBuf::new()),
            OF_THE_PACKAGE => steps::environment(),
            _ => environment(),
        };
        python.is_some_and(|python| run(&python))
    })
}

/// Runs both sides in turns, the vortex lattice once; prints the table and puts it into docs/performance.md.
fn mechanics(python: &Path) -> bool {
    let folder = tools::root().join("validation/multibody");
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let bench =
            tools::cargo(&["bench", "--quiet", "--package", "wingbeat-comparisons", "--bench", "peers"]);
        let tree = script(python, "pinocchio_tree.py", &[&folder.to_string_lossy()]);
        let (Some(bench), Some(tree)) = (times(bench), times(tree)) else { return false };
        ours.push(bench);
        theirs.push(tree);
    }
    let Some(flap) = times(script(python, "pterasoftware_flap.py", &[])) else { return false };
    theirs.push(flap);
    let table = table(&ours, &theirs);
    println!("{table}");
    let table = format!("{table}\n\n{}", circumstances(&["pin", "pterasoftware"]));
    documents::put_into("docs/performance.md", "mechanics", &table)
}

/// Runs the offline solvers in turns; prints the table and puts it into docs/performance.md.
fn offline(python: &Path) -> bool {
    let (mut ours, mut theirs) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let bench =
            tools::cargo(&["bench", "--quiet", "--package", "wingbeat-comparisons", "--bench", "offline"]);
        let (Some(own), Some(other)) = (times(bench), times(script(python, "flapbody14_b.py", &[]))) else {
            return false;
        };
        ours.push(own);
        theirs.push(other);
    }
    let table = table(&ours, &theirs);
    println!("{table}");
    let table = format!("{table}\n\n{}", circumstances(&["casadi"]));
    documents::put_into("docs/performance.md", "offline", &table)
}

/// Date, machine and versions, of the Python packages those required.
pub fn circumstances(packages: &[&str]) -> String {
    let required = ["requirements.txt", "steps.txt"].map(|file| fs::read_to_string(peers().join(file)));
    let required = required.map(Result::unwrap_or_default).concat();
    let version = |package: &&str| {
        let line = required.lines().find(|line| line.split("==").next() == Some(package));
        line.unwrap_or(package).replace("==", " ")
    };
    let compilers = ["rustc", "cc"].map(|compiler| first_line(compiler, &["--version"]));
    let versions: Vec<String> = packages.iter().map(version).chain(compilers).collect();
    format!("{}; {}; {}.", first_line("date", &["-u", "+%Y-%m-%d"]), machine(), versions.join(", "))
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

/// Python with the other programs, in target/peers; none when it cannot be made.
fn environment() -> Option<PathBuf> {
    let python = tools::python_environment("target/peers")?;
    tools::pip(&python, &["--requirement"], &peers().join("requirements.txt"))?;
    Some(python)
}

fn peers() -> PathBuf {
    tools::root().join("crates/xtask/peers")
}

fn script(python: &Path, name: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(python);
    // One thread, as ours.
    command.arg(peers().join(name)).args(arguments).env("OMP_NUM_THREADS", "1");
    command
}

/// The `name<TAB>seconds` lines that `command` prints; none when it fails.
fn times(command: Command) -> Option<Times> {
    Some(parse(&tools::output(command)?))
}

fn parse(text: &str) -> Times {
    let line = |line: &str| {
        let (name, seconds) = line.split_once('\t')?;
        Some((name.to_string(), seconds.trim().parse().ok()?))
    };
    text.lines().filter_map(line).collect()
}

/// Median over the rounds that hold `name`.
fn median(rounds: &[Times], name: &str) -> Option<f64> {
    let mut found: Vec<f64> = rounds.iter().filter_map(|round| round.get(name).copied()).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied()
}

/// The rows of which both sides are known, as Markdown.
fn table(ours: &[Times], theirs: &[Times]) -> String {
    let mut table =
        String::from("| what | wingbeat | other program | its time | its / ours |\n|---|---:|---|---:|---:|");
    for (what, own, program, other) in ROWS {
        let (Some(a), Some(b)) = (median(ours, own), median(theirs, other)) else { continue };
        table += &format!("\n| {what} | {} | {program} | {} | {:.2} |", shown(a), shown(b), b / a);
    }
    table
}

fn shown(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.3} us", s * 1e6),
        s if s < 1.0 => format!("{:.3} ms", s * 1e3),
        s => format!("{s:.2} s"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_come_from_lines_with_a_tab() {
        let rounds = ["a\t1e-6\nnoise\nb\t2", "a\t3e-6", "a\t2e-6"].map(parse);
        assert_eq!(median(&rounds, "a"), Some(2e-6));
        assert_eq!(median(&rounds, "b"), Some(2.0));
        assert_eq!(median(&rounds, "c"), None);
    }
}
