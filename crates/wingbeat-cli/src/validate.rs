//! `wingbeat validate`: a program of its own does the comparisons, as they would make up a fifth of this one.

use std::path::Path;
use std::process::Command;

use wingbeat_program::comparisons::Comparisons;

use crate::error::Error;

/// The program that compares; it stands beside this one.
const PROGRAM: &str = "wingbeat-validate";

/// Hands over to the program of the comparisons with the arguments behind the verb.
pub fn validate(_: &Comparisons) -> Result<(), Error> {
    let own = std::env::current_exe().map_err(|source| Error::file(Path::new("wingbeat"), source))?;
    let program = own.with_file_name(PROGRAM).with_extension(std::env::consts::EXE_EXTENSION);
    if !program.is_file() {
        return Err(missing(&program));
    }
    let mut command = Command::new(&program);
    command.args(std::env::args_os().skip(2));
    Err(Error::file(&program, replace_by(command)))
}

/// Without it the comparisons have to be built.
fn missing(program: &Path) -> Error {
    let get = format!("get it by `cargo build --release -p {PROGRAM}`, or copy it there");
    Error::Input(format!(
        "the comparisons are a program of their own, and {} is missing; {get}",
        program.display()
    ))
}

/// Runs `command` in place of this program: its signals are those of this process. Returns only when that fails.
#[cfg(unix)]
fn replace_by(mut command: Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(&mut command)
}

/// Runs `command` and ends with its exit code. Returns only when it cannot be started.
#[cfg(not(unix))]
fn replace_by(mut command: Command) -> std::io::Error {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(2)),
        Err(error) => error,
    }
}
