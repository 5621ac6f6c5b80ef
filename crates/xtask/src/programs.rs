//! The programs of the tests, which are built at once and then run side by side.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::report::Job;
use crate::{plain, tools};

/// A program of tests.
#[derive(Debug, PartialEq)]
struct TestProgram {
    /// The crate, and the name of the test where it is no part of the library.
    name: String,
    executable: PathBuf,
    /// The folder of the crate, where cargo runs its tests.
    folder: PathBuf,
}

/// The programs that take longest, which are begun first so that none is left over at the end.
const SLOW: [&str; 4] =
    ["wingbeat-cli cli", "wingbeat library", "wingbeat-calibrate all", "wingbeat-netft all"];

/// Builds the tests; a job for each of their programs. None when they do not build.
pub fn built() -> Option<Vec<Job>> {
    let arguments =
        [&["test"], &tools::TESTS[..], &["--no-run", "--message-format=json-render-diagnostics"]].concat();
    let mut build = tools::cargo(&arguments);
    plain::compiled_plain(&mut build);
    let messages = tools::output(build)?;
    let mut programs: Vec<TestProgram> = messages.lines().filter_map(program).collect();
    programs.sort_by_key(|program| SLOW.iter().position(|name| *name == program.name).unwrap_or(SLOW.len()));
    Some(programs.into_iter().map(job).collect())
}

/// The program that a message of cargo tells of (The Cargo Book, External tools, JSON messages); none of another message.
fn program(message: &str) -> Option<TestProgram> {
    let message: Value = serde_json::from_str(message).ok()?;
    let text = |value: &Value| value.as_str().map(str::to_owned);
    let tests = message["reason"] == "compiler-artifact" && message["profile"]["test"] == true;
    tests.then_some(())?;
    let executable = PathBuf::from(text(&message["executable"])?);
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?.to_owned();
    let package = folder.file_name()?.to_string_lossy().into_owned();
    let target = text(&message["target"]["name"])?;
    let name = if message["target"]["kind"][0] == "test" { format!("{package} {target}") } else { package };
    Some(TestProgram { name, executable, folder })
}

/// Whether the tests of the program `name` keep time. They mostly wait: ten seconds of recordings cost half a second of a core.
pub fn timed(name: &str) -> bool {
    name.starts_with("wingbeat-netft")
}

/// As cargo runs it. Some tests wait for a box or a clock: each program takes a thread more than its share of the cores, and more where
/// all of its tests wait.
fn job(program: TestProgram) -> Job {
    let mut command = Command::new(program.executable);
    command.current_dir(&program.folder).env("CARGO_MANIFEST_DIR", program.folder);
    command.env("RUST_TEST_THREADS", if timed(&program.name) { "8" } else { "2" });
    Job { name: program.name, commands: vec![command] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_cargo_tell_the_programs_of_tests() {
        let message = |reason: &str, test: bool| {
            format!(
                r#"{{"reason":"{reason}","manifest_path":"/a/crates/bird/Cargo.toml","target":{{"name":"all","kind":["test"]}},
                "profile":{{"test":{test}}},"executable":"/a/target/all-1"}}"#
            )
        };
        let found = program(&message("compiler-artifact", true)).expect("a program");
        assert_eq!(found.name, "bird all");
        assert_eq!(found.executable, Path::new("/a/target/all-1"));
        assert_eq!(found.folder, Path::new("/a/crates/bird"));
        assert_eq!(program(&message("compiler-artifact", false)), None);
        assert_eq!(program(&message("build-finished", true)), None);
        assert_eq!(program("not JSON"), None);
    }
}
