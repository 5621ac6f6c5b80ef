//! `cargo xtask test`: everything that must hold before a change goes in.

use crate::report::{Account, Tally};
use crate::{licences, tools};

/// Runs every check; true when all pass.
pub fn test() -> bool {
    let mut account = Account::default();
    account.step("format", || one(&["fmt", "--all", "--check"]));
    account.step("lints", || {
        one(&["clippy", "--release", "--workspace", "--all-targets", "--", "--deny", "warnings"])
    });
    account.step("tests", || counted(&["test", "--release", "--workspace", "--no-fail-fast"]));
    account.step("licences", licences::check);
    account.step("comparisons", || {
        counted(&["run", "--release", "--quiet", "--", "validate", "--quick", "--quiet"])
    });
    account.close()
}

fn one(arguments: &[&str]) -> Tally {
    Tally::one(tools::succeeds(tools::cargo(arguments)))
}

/// The checks that the command's output counts; a failure that it does not count is one.
fn counted(arguments: &[&str]) -> Tally {
    let mut tally = Tally::default();
    let success = tools::lines(tools::cargo(arguments), |line| tally.add(line));
    if !success && tally.failed == 0 {
        tally.failed = 1;
    }
    tally
}
