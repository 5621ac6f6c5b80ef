//! Fuzzing of everything that reads what others wrote, with cargo-fuzz and libFuzzer.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::tools;

/// The version that is installed into target/tools.
const VERSION: &str = "0.13.2";
/// Seconds for each target, when not said.
const SECONDS: u64 = 600;
/// Longest input, bytes.
const LONGEST: u32 = 16 << 10;
/// Longest time for one input, s.
const PATIENCE: u32 = 10;
/// Most memory of a target, MB. One input may take half of it: fuzz/src/lib.rs.
const MEMORY: u32 = 1024;
/// Examples of the repository that are seeds beside fuzz/seeds/TARGET.
const EXAMPLES: [(&str, &[&str]); 4] = [
    ("documents", &["scenarios", "rigs", "cases", "sweeps", "robots"]),
    ("urdf", &["validation/multibody"]),
    ("record_csv", &["validation"]),
    ("samples", &["crates/wingbeat-io/tests/data"]),
];

/// What came of a target.
struct FuzzOutcome {
    target: String,
    executions: u64,
    coverage: u64,
    peak_mb: u64,
    /// Inputs that crashed it, took too long or too much memory.
    findings: Vec<PathBuf>,
    passed: bool,
}

/// Fuzzes the targets named in `arguments`, or all; `--seconds N` for each. True when no input was found that
/// crashes one.
pub fn fuzz(arguments: &[String]) -> bool {
    let Some((seconds, chosen)) = tools::seconds(arguments, SECONDS) else { return false };
    let all = targets();
    if let Some(unknown) = chosen.iter().find(|name| !all.contains(name)) {
        eprintln!("error: no target {unknown}; there are {}", all.join(", "));
        return false;
    }
    if !build() {
        return false;
    }
    let chosen = if chosen.is_empty() { all } else { chosen };
    let outcomes: Vec<FuzzOutcome> = chosen.iter().map(|target| run(target, seconds)).collect();
    print(&outcomes);
    outcomes.iter().all(|outcome| outcome.passed)
}

/// The targets by name.
fn targets() -> Vec<String> {
    let entries = fs::read_dir(tools::root().join("fuzz/targets")).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| Some(entry.path().file_stem()?.to_string_lossy().into_owned())).collect();
    names.sort();
    names
}

/// Builds all targets with libFuzzer's coverage, without a sanitizer: those need the nightly compiler.
fn build() -> bool {
    let Some(tool) = tools::installed("cargo-fuzz", VERSION, &[]) else { return false };
    let mut build = Command::new(tool);
    build.args(["build", "--sanitizer", "none", "--codegen-units", "16"]);
    build.args(["--fuzz-dir", "fuzz", "--target-dir", "target/fuzz"]).current_dir(tools::root());
    // The tool sets the flags of the compiler itself, in place of those of .cargo/config.toml.
    if cfg!(target_arch = "x86_64") {
        build.env("RUSTFLAGS", "-C target-cpu=x86-64-v3");
    }
    tools::succeeds(build)
}

/// The built program of a target, whatever the machine.
fn program(target: &str) -> Option<PathBuf> {
    let entries = fs::read_dir(tools::root().join("target/fuzz")).into_iter().flatten().flatten();
    entries.map(|entry| entry.path().join("release").join(target)).find(|path| path.is_file())
}

/// Runs a target; its findings stay in target/fuzz/artifacts, its inputs in target/fuzz/corpus.
fn run(target: &str, seconds: u64) -> FuzzOutcome {
    let root = tools::root();
    let (corpus, artifacts) =
        (format!("target/fuzz/corpus/{target}"), format!("target/fuzz/artifacts/{target}"));
    let log = root.join(format!("target/fuzz/{target}.log"));
    let made = [&corpus, &artifacts].iter().all(|folder| fs::create_dir_all(root.join(folder)).is_ok());
    println!("{target}: {seconds} s, log in {}", log.display());
    let passed = made
        && program(target).zip(fs::File::create(&log).ok()).is_some_and(|(program, log)| {
            let mut command = Command::new(program);
            command.current_dir(&root).stdout(Stdio::null()).stderr(log);
            command.arg(format!("-max_total_time={seconds}")).arg(format!("-max_len={LONGEST}"));
            command.arg(format!("-timeout={PATIENCE}")).arg(format!("-rss_limit_mb={MEMORY}"));
            command.arg(format!("-artifact_prefix={artifacts}/")).arg("-print_final_stats=1");
            command.arg(&corpus).args(seeds(target));
            tools::succeeds(command)
        });
    let text = fs::read(&log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    FuzzOutcome {
        target: target.into(),
        executions: number_after(&text, "stat::number_of_executed_units:"),
        coverage: number_after(&text, "cov:"),
        peak_mb: number_after(&text, "stat::peak_rss_mb:"),
        findings: files(&root.join(artifacts)),
        passed,
    }
}

/// Folders with seeds of a target, those that there are.
fn seeds(target: &str) -> Vec<String> {
    let examples = EXAMPLES.iter().filter(|(name, _)| *name == target).flat_map(|(_, folders)| *folders);
    let folders = std::iter::once(format!("fuzz/seeds/{target}")).chain(examples.map(|name| (*name).into()));
    folders.filter(|folder| tools::root().join(folder).is_dir()).collect()
}

/// The number after the last `label`.
fn number_after(text: &str, label: &str) -> u64 {
    let rest = text.rsplit_once(label).map_or("", |(_, rest)| rest);
    rest.split_whitespace().next().and_then(|word| word.parse().ok()).unwrap_or(0)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

fn print(outcomes: &[FuzzOutcome]) {
    println!("\n{:<16} {:>12} {:>9} {:>8} {:>9}", "target", "executions", "coverage", "peak MB", "findings");
    for o in outcomes {
        let failed = if o.passed { "" } else { "  failed" };
        let (target, found) = (&o.target, o.findings.len());
        println!("{target:<16} {:>12} {:>9} {:>8} {found:>9}{failed}", o.executions, o.coverage, o.peak_mb);
        o.findings.iter().for_each(|path| println!("  {}", path.display()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_figure_of_a_log_counts() {
        let log =
            "#2 INITED cov: 12 ft: 3\n#99 DONE   cov: 597 ft: 2523\nstat::peak_rss_mb:              29\n";
        assert_eq!((number_after(log, "cov:"), number_after(log, "stat::peak_rss_mb:")), (597, 29));
        assert_eq!(number_after("", "cov:"), 0);
    }

    #[test]
    fn every_target_is_built_and_has_seeds() {
        let manifest = fs::read_to_string(tools::root().join("fuzz/Cargo.toml")).unwrap();
        for target in targets() {
            assert!(manifest.contains(&format!("path = \"targets/{target}.rs\"")), "{target}");
            assert!(!seeds(&target).is_empty(), "{target}");
        }
    }
}
