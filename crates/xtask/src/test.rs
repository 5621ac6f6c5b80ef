//! `cargo xtask test`: everything that must hold before a change goes in.

use std::process::Command;

use crate::report::{Account, Tally};
use crate::{dependencies, documents, hostile, python, soak, tools};

/// Length of the soak test; `cargo xtask soak` takes ten minutes.
const SOAK_SECONDS: u64 = 10;

/// Runs every check; true when all pass.
pub fn test() -> bool {
    let mut account = Account::default();
    account.step("format", || one(&["fmt", "--all", "--check"]));
    account.step("lints", || {
        one(&["clippy", "--release", "--workspace", "--all-targets", "--", "--deny", "warnings"])
    });
    account.step("pages of the code", || {
        let mut pages = tools::cargo(&["doc", "--release", "--workspace", "--lib", "--no-deps", "--quiet"]);
        pages.env("RUSTDOCFLAGS", "--deny warnings");
        Tally::one(tools::succeeds(pages))
    });
    // What follows runs the program that the tests have built: built alone it would take other features.
    account.step("tests", || counted(&["test", "--release", "--workspace", "--no-fail-fast"]));
    // So does this: the extension is packed as it lies there.
    account.step("python", python::check);
    account.step("hostile", hostile::quick);
    account.step("soak", || Tally::one(soak::run(SOAK_SECONDS)));
    account.step("dependencies", dependencies::check);
    account.step("comparisons", comparisons);
    account.close()
}

/// The quick comparisons, and the numbers of docs/validation.md beside theirs.
fn comparisons() -> Tally {
    let file = tools::root().join("target/quick.json");
    let path = file.to_string_lossy();
    let mut tally = tallied(tools::wingbeat(&["validate", "--quick", "--quiet", "--json", &path]));
    let stale = documents::rows_of(&file).map(|rows| documents::stale(&rows)).unwrap_or_default();
    for what in &stale {
        println!("docs/validation.md is stale, run `cargo xtask docs`: {what}");
    }
    tally.failed += stale.len();
    tally
}

fn one(arguments: &[&str]) -> Tally {
    Tally::one(tools::succeeds(tools::cargo(arguments)))
}

/// The checks that the output of cargo counts.
fn counted(arguments: &[&str]) -> Tally {
    tallied(tools::cargo(arguments))
}

/// The checks that the command's output counts; a failure that it does not count is one.
fn tallied(command: Command) -> Tally {
    let mut tally = Tally::default();
    let success = tools::lines(command, |line| tally.add(line));
    if !success && tally.failed == 0 {
        tally.failed = 1;
    }
    tally
}
