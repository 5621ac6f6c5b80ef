//! What is generated into docs: the command line (cli.md), keys and columns (reference.md), schemas (schema/*.json).

mod cli;
mod columns;
mod commands;
mod keys;
mod meets;
mod page;
mod ranges;
mod recorded;
mod shipped;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use wingbeat::scenario::Schemas;

/// The root of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The schemas as the specs have them, made once.
fn schemas() -> &'static Schemas {
    static MADE: OnceLock<Schemas> = OnceLock::new();
    MADE.get_or_init(Schemas::made)
}

/// The file `name` of docs holds `text`; it is written where that is asked for.
fn is_current(name: &str, text: &str) {
    let path = root().join("docs").join(name);
    if std::env::var_os("WINGBEAT_WRITE_DOCS").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(written == text, "docs/{name} is stale: run `cargo xtask docs`");
}
