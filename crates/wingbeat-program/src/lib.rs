//! What the programs `wingbeat` and `wingbeat-validate` share: run folders, manifest, Ctrl-C, messages and exit codes.

pub mod comparisons;
pub mod error;
pub mod interrupt;
pub mod manifest;
pub mod progress;
pub mod run_folder;
pub mod say;

use std::io::Write;
use std::process::ExitCode;

use error::Error;

/// The commit that the programs were built from, or `unknown`.
pub const COMMIT: &str = env!("WINGBEAT_COMMIT");

/// The exit code of a program that ran `main`, whose error is printed; 2, and a line, on a processor for which it was not built.
pub fn run(main: impl FnOnce() -> Result<(), Error>) -> ExitCode {
    if let Some(lacks) = wingbeat::processor::lacks() {
        let mut out = std::io::stderr();
        let _ = out.write_all(b"error: ").and_then(|()| out.write_all(lacks.as_bytes()));
        let _ = out.write_all(b"\n");
        return ExitCode::from(2);
    }
    ran(main)
}

/// Apart, so that nothing of it is done before the processor is known.
#[inline(never)]
fn ran(main: impl FnOnce() -> Result<(), Error>) -> ExitCode {
    silence_decoders();
    match main() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            if !error.is_silent() {
                say::note(&format!("error: {error}"));
            }
            ExitCode::from(error.exit_code())
        }
    }
}

/// Keeps what a decoder of another library says when it fails on a damaged file from the user: it becomes an error.
fn silence_decoders() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().name() != Some(wingbeat_io::DECODER) {
            usual(panic);
        }
    }));
}
