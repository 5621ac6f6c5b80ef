//! `wingbeat migrate`: documents with the names of keys that hold today.

use std::fs;
use std::path::Path;

use wingbeat::scenario::{Migrated, migrated, text_of};

use crate::args::Migrate;
use crate::error::Error;
use crate::say;

/// Rewrites every file, or says what would change; a file that cannot be read leaves all as they are.
pub fn migrate(arguments: &Migrate) -> Result<(), Error> {
    let all = arguments.files.iter().map(|path| today(path)).collect::<Result<Vec<_>, Error>>()?;
    for (path, new) in arguments.files.iter().zip(&all) {
        let shown = path.display();
        let mut told = String::new();
        for (line, then, now) in &new.lines {
            told += &format!("{shown}:{line}: {then}\n{shown}:{line}: {now}\n");
        }
        if new.lines.is_empty() {
            told = format!("{shown}: nothing to change\n");
        } else if !arguments.dry_run {
            replace(path, &new.text).map_err(|source| Error::file(path, source))?;
            told += &format!("{shown}: written\n");
        }
        say::say(&told)?;
    }
    Ok(())
}

fn today(path: &Path) -> Result<Migrated, Error> {
    let text = text_of(path).map_err(|source| Error::file(path, source))?;
    migrated(&text)
        .map_err(|(line, what)| Error::Input(format!("{}:{line}: not TOML: {what}", path.display())))
}

/// Puts `text` in the place of a file, whole or not at all; of a link in that of the file it leads to.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let target = fs::canonicalize(path)?;
    let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let partial = target.with_file_name(format!(".{name}.partial"));
    let written = fs::write(&partial, text)
        .and_then(|()| fs::set_permissions(&partial, fs::metadata(&target)?.permissions()))
        .and_then(|()| fs::rename(&partial, &target));
    if written.is_err() {
        let _ = fs::remove_file(&partial);
    }
    written
}
