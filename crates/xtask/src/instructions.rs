//! `cargo xtask long instructions`: instructions of the work that flights are made of, counted by Valgrind. They do not depend on what
//! else the machine does.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::report::Tally;
use crate::{against, tools};

/// `spars` and `rigid` are evaluations of `soft_20g` and of its twin without spars; the first may cost twice the second at most. `lanes` are
/// evaluations of eight robots at once in single precision. `update` is one of the predictive controller of `banking_turn`.
///
/// Work, preset, its strips, and the most instructions, in thousands: at most 5 % above those of rustc 1.95.0. A filling of memory counts by the byte where the processor
/// is asked to fill it at once, so that it weighs more here than in time.
const LIMITS: [(&str, &str, u32, f64); 18] = [
    ("evaluation", "paper", 9, 15.1),
    ("evaluation", "paper", 12, 17.5),
    ("evaluation", "full", 9, 32.5),
    ("evaluation", "full", 12, 37.1),
    ("evaluation", "full", 16, 49.7),
    ("evaluation", "full", 24, 88.3),
    ("rigid", "full", 16, 54.6),
    ("spars", "full", 16, 102.0),
    ("lanes", "paper", 12, 18.6),
    ("lanes", "full", 9, 63.0),
    ("jacobian", "paper", 12, 382.0),
    ("jacobian", "full", 9, 735.0),
    ("jacobian", "full", 16, 1191.0),
    ("inputs", "full", 16, 104.3),
    ("sample", "paper", 12, 54.6),
    ("sample", "full", 16, 126.6),
    ("update", "paper", 12, 6500.0),
    ("update", "full", 16, 16000.0),
];
/// Runs between the two counts.
const RUNS: u64 = 4;

/// Counts and judges; says so where Valgrind or the processor that the limits are of is not there.
pub fn check() -> Tally {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) || !tools::here("valgrind") {
        println!("left out: it counts by valgrind on Linux on x86-64");
        return Tally::default();
    }
    let Some(program) = against::built(&tools::root()) else {
        return Tally { failed: 1, ..Tally::default() };
    };
    let mut tally = Tally::default();
    for (work, preset, strips, most) in LIMITS {
        let count = |runs: u64| counted(&program, &[work, preset, &strips.to_string(), &runs.to_string()]);
        let thousands = count(2)
            .zip(count(2 + RUNS))
            .map(|(few, more)| more.saturating_sub(few) as f64 / (1e3 * RUNS as f64));
        let passes = thousands.is_some_and(|value| value > 0.0 && value <= most);
        let told = thousands.map_or("not counted".into(), |value| format!("{value:.1} k instructions"));
        let failed = if passes { "" } else { "  FAILED" };
        println!("{work:<11} {preset} {strips:>2}: {told}, at most {most} k{failed}");
        tally.passed += usize::from(passes);
        tally.failed += usize::from(!passes);
    }
    tally
}

/// Instructions of the bench with these arguments.
fn counted(program: &Path, arguments: &[&str]) -> Option<u64> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(program).arg("count");
    let output = command.args(arguments).stdout(Stdio::null()).output().ok()?;
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(())?;
    let (_, rest) = told.split_once("Collected : ")?;
    rest.split_whitespace().next()?.parse().ok()
}
