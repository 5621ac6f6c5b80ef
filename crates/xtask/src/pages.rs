//! Checks of README.md and of the pages in docs.

use std::fs;

use crate::tools;

/// The most lines of README.md.
const README_LINES: usize = 120;

/// The text of a page, by its path from the root.
fn text(page: &str) -> String {
    fs::read_to_string(tools::root().join(page)).unwrap()
}

#[test]
fn the_readme_is_short() {
    let lines = text("README.md").lines().count();
    assert!(lines <= README_LINES, "README.md has {lines} lines, allowed are {README_LINES}");
}
