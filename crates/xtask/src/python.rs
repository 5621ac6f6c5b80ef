//! The Python package: its wheel, what it is tested with, and what that says.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::report::Tally;
use crate::tools;

/// The crate of the package.
const CRATE: &str = "crates/wingbeat-py";

/// Packs the extension that the tests have built, installs the wheel into target/tools/python and tests it there.
pub fn check() -> Tally {
    let Some((python, _)) = installed("tests/requirements.txt", "target/tools/python") else {
        return Tally::one(false);
    };
    let mut tests = Command::new(python);
    tests.args([
        "-m",
        "pytest",
        "--quiet",
        "--strict-markers",
        "-rP",
        "-p",
        "no:cacheprovider",
        "tests/python",
    ]);
    tests.current_dir(tools::root().join(CRATE)).env("WINGBEAT_PROGRAM", tools::program());
    tests.env("PYTHONDONTWRITEBYTECODE", "1");
    let mut tally = Tally::default();
    let passed = tools::lines(tests, |line| {
        if let Some((passed, failed)) = counts(line) {
            (tally.passed, tally.failed) = (passed, failed);
        }
    });
    if !passed && tally.failed == 0 {
        tally.failed = 1;
    }
    tally
}

/// What may be asked of the package beyond its tests.
const HEAVY: &str = "measure, or policies [STEPS [SEED...]]";

/// Measures the package, or puts policies that were trained beside the predictive controller.
pub fn heavy(arguments: &[String]) -> bool {
    let build = ["test", "--release", "--workspace", "--no-run", "--test", "library"];
    let (script, requirements) = match arguments.first().map(String::as_str) {
        Some("measure") => ("measure.py", None),
        Some("policies") => ("ppo.py", Some("heavy/requirements.txt")),
        other => {
            eprintln!("error: no {}: there are {HEAVY}", other.unwrap_or("task"));
            return false;
        }
    };
    if !tools::succeeds(tools::cargo(&build)) {
        return false;
    }
    let folder = if requirements.is_some() { "target/tools/policies" } else { "target/tools/python" };
    let Some((python, wheel)) = installed("tests/requirements.txt", folder) else { return false };
    let file = requirements.map(|file| tools::root().join(CRATE).join(file));
    if file.is_some_and(|file| pip(&python, &["--requirement"], &file).is_none()) {
        return false;
    }
    let mut run = Command::new(python);
    run.arg(tools::root().join(CRATE).join("heavy").join(script));
    match script {
        "measure.py" => run.arg(wheel),
        _ if arguments.len() > 1 => run.args(&arguments[1..]),
        _ => run.arg("1000000"),
    };
    tools::succeeds(run)
}

/// Makes the environment `folder` with what `requirements` lists and the wheel; its Python and the wheel.
fn installed(requirements: &str, folder: &str) -> Option<(PathBuf, PathBuf)> {
    let root = tools::root();
    let folder = root.join(folder);
    let python = folder.join("bin/python");
    if !python.exists() {
        let mut make = Command::new("python3");
        make.args(["-m", "venv"]).arg(&folder);
        tools::succeeds(make).then_some(())?;
    }
    let wheel = wheel(&python)?;
    pip(&python, &["--requirement"], &root.join(CRATE).join(requirements))?;
    pip(&python, &["--force-reinstall", "--no-deps"], &wheel)?;
    Some((python, wheel))
}

/// The wheel of the extension that was built with the tests.
fn wheel(python: &Path) -> Option<PathBuf> {
    let root = tools::root();
    let mut pack = Command::new(python);
    pack.arg(root.join(CRATE).join("pack.py")).arg(root.join("target/release/deps/lib_wingbeat.so"));
    pack.arg(root.join("target/wheels"));
    let wheel = PathBuf::from(tools::output(pack)?.trim());
    let size = std::fs::metadata(&wheel).map_or(0, |data| data.len());
    println!("{}: {:.1} MB", wheel.display(), size as f64 * 1e-6);
    Some(wheel)
}

fn pip(python: &Path, options: &[&str], what: &Path) -> Option<()> {
    let mut install = Command::new(python);
    install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(options).arg(what);
    tools::succeeds(install).then_some(())
}

/// Passed and failed tests of the last line of pytest, `2 failed, 30 passed in 56.22s`.
fn counts(line: &str) -> Option<(usize, usize)> {
    let (counts, _) = line.trim_matches(['=', ' ']).split_once(" in ")?;
    let count = |words: &[&str]| {
        let of = |part: &str| {
            let (number, word) = part.split_once(' ')?;
            words.contains(&word).then(|| number.parse::<usize>().ok()).flatten()
        };
        counts.split(", ").filter_map(of).sum::<usize>()
    };
    let all = (count(&["passed"]), count(&["failed", "error", "errors"]));
    (all != (0, 0)).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::counts;

    #[test]
    fn the_last_line_of_pytest_is_counted() {
        assert_eq!(counts("===== 2 failed, 30 passed, 1 error in 56.22s ====="), Some((30, 3)));
        assert_eq!(counts("31 passed in 3.42s"), Some((31, 0)));
        assert_eq!(counts("Ctrl-C in fly: 0.007 s"), None);
    }
}
