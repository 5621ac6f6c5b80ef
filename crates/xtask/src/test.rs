//! `cargo xtask test`: everything that must hold before a change goes in.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::report::{CheckAccount, Job, Tally};
use crate::{copies, dependencies, documents, hostile, programs, python, soak, tools};

/// Length of the soak test; `cargo xtask long soak` takes an hour.
const SOAK_SECONDS: u64 = 10;

/// Runs every check; true when all pass.
pub fn test() -> bool {
    let mut account = CheckAccount::default();
    account.step("format", || one(&["fmt", "--all", "--check"]));
    // What follows runs the program that the tests have built: built alone it would take other features.
    // The examples are part of the tests of the library; built by themselves each would take the models once more.
    let mut programs = None;
    account.step("build of the tests", || {
        programs = programs::built();
        Tally::one(programs.is_some())
    });
    // Without a program nothing else can be judged; the lints may say why there is none.
    let mut jobs = vec![read_by_cargo()];
    let Some(programs) = programs else {
        account.together(jobs, |_| ());
        return account.close();
    };
    // The box and its recorder keep time, and so have the machine to themselves.
    let (timed, programs): (Vec<Job>, Vec<Job>) =
        programs.into_iter().partition(|job| programs::timed(&job.name));
    account.together(timed, |_| ());
    // The extension is packed as it lies there.
    jobs.push(Job { name: "python".into(), commands: vec![python::packed()] });
    jobs.extend(programs);
    account.together(jobs, |account| {
        account.step("copies", copies::check);
        account.step("hostile", hostile::quick);
        account.step("soak", || Tally::one(soak::run(&tools::program(), SOAK_SECONDS, 0)));
        account.step("dependencies", dependencies::check);
        account.step("comparisons", comparisons);
    });
    account.close()
}

/// Lints, pages of the code and their examples: one after another, as cargo does one thing at a time.
fn read_by_cargo() -> Job {
    let mut lints = tools::cargo(&["clippy", "--release", "--workspace", "--all-targets", "--quiet"]);
    lints.args(["--", "--deny", "warnings"]);
    let mut pages = tools::cargo(&["doc", "--release", "--workspace", "--lib", "--no-deps", "--quiet"]);
    pages.env("RUSTDOCFLAGS", "--deny warnings");
    // What the lints have read is not read again where cargo's compiler is theirs, with the arguments that they had.
    if let Some(compiler) = clippy() {
        pages.env("RUSTC_WORKSPACE_WRAPPER", compiler);
        pages.env(
            "CLIPPY_ARGS",
            ["--deny", "warnings"].map(|word| format!("{word}__CLIPPY_HACKERY__")).concat(),
        );
    }
    let examples = tools::cargo(&["test", "--release", "--workspace", "--doc", "--no-fail-fast", "--quiet"]);
    Job { name: "lints, pages, doc tests".into(), commands: vec![lints, pages, examples] }
}

/// The compiler that tells lints; none where it lies elsewhere than rustup puts it.
fn clippy() -> Option<PathBuf> {
    let mut asked = Command::new("rustc");
    asked.args(["--print", "sysroot"]).current_dir(tools::root());
    let root = tools::output(asked)?;
    let compiler =
        Path::new(root.trim()).join("bin").join(format!("clippy-driver{}", std::env::consts::EXE_SUFFIX));
    compiler.is_file().then_some(compiler)
}

/// The quick comparisons, and the numbers of docs/validation.md beside theirs.
fn comparisons() -> Tally {
    documents::compared("target/quick.json", &["--quick"])
}

fn one(arguments: &[&str]) -> Tally {
    Tally::one(tools::succeeds(tools::cargo(arguments)))
}
