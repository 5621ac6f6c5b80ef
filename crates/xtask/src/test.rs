//! `cargo xtask test`: everything that must hold before a change goes in.

use crate::report::{Account, Tally};
use crate::{copies, dependencies, documents, hostile, python, soak, tools};

/// Length of the soak test; `cargo xtask long soak` takes an hour.
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
    // The examples are part of the tests of the library; built by themselves each would take the models once more.
    account.step("tests", || {
        let mut tests = tools::cargo(&[&["test"], &tools::TESTS[..], &["--no-fail-fast"]].concat());
        // Some wait for a box or a clock: one more than there are cores keeps these busy.
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        tests.env("RUST_TEST_THREADS", (cores + 1).to_string());
        Tally::of(tests)
    });
    account.step("doc tests", || counted(&["test", "--release", "--workspace", "--doc", "--no-fail-fast"]));
    account.step("copies", copies::check);
    // So do these: the extension is packed as it lies there. Python's tests take one core, and run beside the rest.
    account.beside("python", python::packed(), |account| {
        account.step("hostile", hostile::quick);
        account.step("soak", || Tally::one(soak::run(&tools::program(), SOAK_SECONDS, 0)));
        account.step("dependencies", dependencies::check);
        account.step("comparisons", comparisons);
    });
    account.close()
}

/// The quick comparisons, and the numbers of docs/validation.md beside theirs.
fn comparisons() -> Tally {
    documents::compared("target/quick.json", &["--quick"])
}

fn one(arguments: &[&str]) -> Tally {
    Tally::one(tools::succeeds(tools::cargo(arguments)))
}

/// The checks that the output of cargo counts.
fn counted(arguments: &[&str]) -> Tally {
    Tally::of(tools::cargo(arguments))
}
