//! Running of cargo and of the programs it built.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The root of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap_or(Path::new(".")).into()
}

/// The program that was built, or that of the environment variable `WINGBEAT_PROGRAM`.
pub fn program() -> PathBuf {
    std::env::var_os("WINGBEAT_PROGRAM").map_or_else(|| root().join("target/release/wingbeat"), PathBuf::from)
}

/// The program that was built with `arguments`, at the root.
pub fn wingbeat(arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments).current_dir(root());
    command
}

/// What is built and run of tests by themselves, all with the same features: what has `test = true`, and the programs.
pub const TESTS: [&str; 3] = ["--release", "--workspace", "--tests"];

/// Builds the tests, and with them the programs and the Python extension; true when that succeeds.
pub fn tests_built() -> bool {
    succeeds(cargo(&[&["test", "--quiet", "--no-run"], &TESTS[..]].concat()))
}

/// Builds the program; true when that succeeds.
pub fn built() -> bool {
    succeeds(cargo(&["build", "--release", "--quiet", "--workspace"]))
}

/// Whether there is a program `name` that tells its version.
pub fn here(name: &str) -> bool {
    Command::new(name).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// `cargo` with `arguments`, at the root.
pub fn cargo(arguments: &[&str]) -> Command {
    let program = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// Runs `command`, its output shown; true when it succeeds.
pub fn succeeds(mut command: Command) -> bool {
    match command.status() {
        Ok(status) => status.success(),
        Err(error) => {
            eprintln!("error: {command:?}: {error}");
            false
        }
    }
}

/// Runs `command`, shows each line of its output as it comes and hands it to `line`; true when it succeeds.
pub fn lines(mut command: Command, mut line: impl FnMut(&str)) -> bool {
    let mut child = match command.stdout(Stdio::piped()).spawn() {
        Ok(child) => child,
        Err(error) => {
            eprintln!("error: {command:?}: {error}");
            return false;
        }
    };
    if let Some(output) = child.stdout.take() {
        for text in BufReader::new(output).lines().map_while(Result::ok) {
            println!("{text}");
            line(&text);
        }
    }
    child.wait().is_ok_and(|status| status.success())
}

/// The program `name` of that version in target/tools, installed from the registry with `options` where it is not yet
/// there; none when that fails.
pub fn installed(name: &str, version: &str, options: &[&str]) -> Option<PathBuf> {
    let folder = root().join("target/tools");
    let listed = std::fs::read_to_string(folder.join(".crates.toml")).unwrap_or_default();
    if !listed.contains(&format!("\"{name} {version} ")) {
        let mut install =
            cargo(&["install", name, "--locked", "--version", version, "--root", "target/tools"]);
        install.args(options);
        succeeds(install).then_some(())?;
    }
    Some(folder.join("bin").join(name))
}

/// The output of `command`; none when it fails.
pub fn output(mut command: Command) -> Option<String> {
    let output = command.stderr(Stdio::inherit()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// The value of `--seconds N` in `arguments`, else `otherwise`, and the other arguments; none, and a message, when it
/// is no number or another option is given.
pub fn seconds(arguments: &[String], otherwise: u64) -> Option<(u64, Vec<String>)> {
    let (mut seconds, mut others) = (otherwise, Vec::new());
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        match argument.as_str() {
            "--seconds" => {
                match rest.next().and_then(|word| word.parse().ok()).filter(|number| *number > 0) {
                    Some(number) => seconds = number,
                    None => {
                        eprintln!("error: --seconds takes a whole number above zero");
                        return None;
                    }
                }
            }
            option if option.starts_with('-') => {
                eprintln!("error: no option {option}; there is --seconds N");
                return None;
            }
            _ => others.push(argument.clone()),
        }
    }
    Some((seconds, others))
}

/// README.md and all pages in docs, as paths from the root.
pub fn pages() -> Vec<String> {
    let mut found = vec!["README.md".to_owned()];
    let mut folders = vec![PathBuf::from("docs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).into_iter().flatten().flatten() {
            let path = folder.join(entry.file_name());
            if root().join(&path).is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "md") {
                found.push(path.to_string_lossy().into_owned());
            }
        }
    }
    found.sort();
    found
}

/// The Python that makes all environments and pages: that of the environment variable `WINGBEAT_PYTHON`, else the one on the path.
pub fn python() -> Command {
    let usual = if cfg!(windows) { "python" } else { "python3" };
    Command::new(std::env::var_os("WINGBEAT_PYTHON").unwrap_or_else(|| usual.into()))
}

/// Makes the Python environment `folder`, seen from the root, where there is none; its Python.
pub fn python_environment(folder: &str) -> Option<PathBuf> {
    let folder = root().join(folder);
    let own = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    if !own.exists() {
        let mut make = python();
        make.args(["-m", "venv"]).arg(&folder);
        succeeds(make).then_some(())?;
    }
    Some(own)
}

/// Installs into an environment what pip is asked for by `options` and `what`.
pub fn pip(python: &Path, options: &[&str], what: &Path) -> Option<()> {
    let mut install = Command::new(python);
    install.args(["-m", "pip", "install", "--no-compile", "--quiet", "--disable-pip-version-check"]);
    install.args(options).arg(what);
    succeeds(install).then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_stand_anywhere_and_are_a_number() {
        let given =
            |words: &[&str]| seconds(&words.iter().map(|word| (*word).into()).collect::<Vec<_>>(), 600);
        assert_eq!(given(&["a", "--seconds", "5", "b"]), Some((5, vec!["a".into(), "b".into()])));
        assert_eq!(given(&[]), Some((600, vec![])));
        assert_eq!((given(&["--seconds", "x"]), given(&["--minutes"])), (None, None));
    }
}
