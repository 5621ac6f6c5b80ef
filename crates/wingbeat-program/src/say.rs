//! What a command prints. A reader that went away (`| head`) is no error; a full disk is one, told when the work is
//! safe.

use std::io::{self, Write};

use crate::error::Error;

/// Prints a text.
///
/// # Errors
/// The standard output cannot be written, though someone reads it.
pub fn say(text: &str) -> Result<(), Error> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome.map_err(Error::Output),
    }
}

/// Prints what `text` makes, unless `quiet`.
///
/// # Errors
/// Those of [`say`].
pub fn unless(quiet: bool, text: impl FnOnce() -> String) -> Result<(), Error> {
    if quiet { Ok(()) } else { say(&text()) }
}

/// Prints a line on the error stream, or nowhere when that cannot be written.
pub fn note(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
