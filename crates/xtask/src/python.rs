//! The Python package: its wheel, what it is tested with, and what that says.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::report::Tally;
use crate::tools;

/// The crate of the package.
const CRATE: &str = "crates/wingbeat-py";

/// Packs the extension that the tests have built, installs the wheel into target/tools/python and tests it there, by the tests that are
/// marked `long` or by the others.
pub fn check(long: bool) -> Tally {
    tested(&["tests/python", "-m", if long { "long" } else { "not long" }], &[])
}

/// The notebooks with what their cells print and draw today.
fn notebooks() -> Tally {
    tested(&["tests/python/test_notebooks.py"], &[("WINGBEAT_WRITE_NOTEBOOKS", "1")])
}

/// Installs the wheel of what the tests have built, and runs the tests that `arguments` of pytest choose.
fn tested(arguments: &[&str], variables: &[(&str, &str)]) -> Tally {
    let Some((python, _)) = installed(&requirements(), "target/tools/python") else {
        return Tally::one(false);
    };
    let mut tests = Command::new(python);
    tests.args(["-m", "pytest", "--quiet", "--strict-markers", "-rP", "-p", "no:cacheprovider"]);
    tests.args(arguments).envs(variables.iter().copied());
    tests.current_dir(tools::root().join(CRATE)).env("WINGBEAT_PROGRAM", tools::program());
    // Byte code of what the tests import, and of nothing else, is written, and not beside the sources.
    tests.env_remove("PYTHONDONTWRITEBYTECODE");
    tests.env("PYTHONPYCACHEPREFIX", tools::root().join("target/tools/pycache"));
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

/// [`check`] of what the tests have built, as a program of its own, which says how many checks passed and failed.
pub fn packed() -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap_or_else(|_| "xtask".into()));
    command.args(["python", "packed"]);
    command
}

/// What may be asked of the package.
const TASKS: &str =
    "test, packed, wheel, notebooks, calls [OPTION...], measure [WHAT...], or policies [STEPS [SEED...]]";

/// Builds the extension and, as a test of the program needs it, the program.
const BUILD: [&str; 8] =
    ["test", "--release", "--workspace", "--no-run", "--test", "library", "--test", "cli"];

/// What the package is tested with.
fn requirements() -> PathBuf {
    tools::root().join(CRATE).join("tests/requirements.txt")
}

/// Tests or measures the package, or puts policies that were trained beside the predictive controller.
pub fn task(arguments: &[String]) -> bool {
    let (script, heavy) = match arguments.first().map(String::as_str) {
        Some("test") => {
            return tools::succeeds(tools::cargo(&BUILD)) && check(false).failed == 0;
        }
        Some("packed") => {
            let Tally { passed, failed } = check(false);
            println!("{passed} passed, {failed} failed");
            return failed == 0;
        }
        Some("wheel") => return release(),
        Some("notebooks") => return tools::succeeds(tools::cargo(&BUILD)) && notebooks().failed == 0,
        Some("calls") => ("calls.py", None),
        Some("measure") => ("measure.py", None),
        Some("policies") => ("ppo.py", Some("heavy/requirements.txt")),
        other => {
            eprintln!("error: no {}: there are {TASKS}", other.unwrap_or("task"));
            return false;
        }
    };
    if !tools::succeeds(tools::cargo(&BUILD)) {
        return false;
    }
    let folder = if heavy.is_some() { "target/tools/policies" } else { "target/tools/python" };
    let Some((python, wheel)) = installed(&requirements(), folder) else { return false };
    let file = heavy.map(|file| tools::root().join(CRATE).join(file));
    if file.is_some_and(|file| tools::pip(&python, &["--requirement"], &file).is_none()) {
        return false;
    }
    let mut run = Command::new(python);
    run.arg(tools::root().join(CRATE).join("heavy").join(script));
    match script {
        "measure.py" => run.arg(wheel).args(&arguments[1..]),
        "calls.py" => run.args(&arguments[1..]),
        _ if arguments.len() > 1 => run.args(&arguments[1..]),
        _ => run.arg("1000000"),
    };
    tools::succeeds(run)
}

/// Oldest glibc on which a released wheel runs: that of Debian 10, RHEL 8 and later (manylinux_2_28).
const GLIBC: &str = "2.28";
/// What links against that glibc wherever it runs: the Zig linker and cargo's way to it, from PyPI.
const LINKER: [&str; 2] = ["ziglang", "cargo-zigbuild"];

/// Makes the wheel to be released, in target/wheels: on Linux for any glibc from `GLIBC` on, elsewhere as the system builds it.
fn release() -> bool {
    released().is_some()
}

fn released() -> Option<PathBuf> {
    let python = tools::python_environment("target/tools/wheel")?;
    let packages = ["--package", "wingbeat-py", "--package", "wingbeat-cli"];
    let options = [&["--release", "--target-dir", "target/wheel"][..], &packages].concat();
    if !cfg!(target_os = "linux") {
        tools::succeeds(tools::cargo(&[&["build"][..], &options].concat())).then_some(())?;
        return wheel(&python, &tools::root().join("target/wheel/release"));
    }
    for package in LINKER {
        tools::pip(&python, &[], Path::new(package))?;
    }
    let triple = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let target = format!("{triple}.{GLIBC}");
    let mut build = tools::cargo(&[&["zigbuild", "--target", &target][..], &options].concat());
    let scripts = python.parent()?.to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::iter::once(scripts).chain(std::env::split_paths(&path));
    build.env("PATH", std::env::join_paths(paths).ok()?);
    tools::succeeds(build).then_some(())?;
    wheel(&python, &tools::root().join("target/wheel").join(triple).join("release"))
}

/// The Python of the environment `folder` with what the file `requirements` lists and the package of these sources.
pub fn with_package(requirements: &Path, folder: &str) -> Option<PathBuf> {
    tools::succeeds(tools::cargo(&BUILD)).then_some(())?;
    installed(requirements, folder).map(|(python, _)| python)
}

/// Makes the environment `folder` with what `requirements` lists and the wheel; its Python and the wheel.
fn installed(requirements: &Path, folder: &str) -> Option<(PathBuf, PathBuf)> {
    let python = tools::python_environment(folder)?;
    let wheel = wheel(&python, &tools::root().join("target/release"))?;
    tools::pip(&python, &["--requirement"], requirements)?;
    tools::pip(&python, &["--force-reinstall", "--no-deps"], &wheel)?;
    Some((python, wheel))
}

/// The wheel of the extension and the program that lie in the folder `built`.
fn wheel(python: &Path, built: &Path) -> Option<PathBuf> {
    let root = tools::root();
    // Cargo puts it there whether it was built or tested; the copy one folder up is that of the last build alone.
    let library = format!("{}_wingbeat{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let mut pack = Command::new(python);
    pack.arg(root.join(CRATE).join("pack.py")).arg(built.join("deps").join(library));
    pack.arg(built.join(format!("wingbeat{}", std::env::consts::EXE_SUFFIX))).arg(root.join("target/wheels"));
    let wheel = PathBuf::from(tools::output(pack)?.trim());
    let size = std::fs::metadata(&wheel).map_or(0, |data| data.len());
    println!("{}: {:.1} MB", wheel.display(), size as f64 * 1e-6);
    Some(wheel)
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
