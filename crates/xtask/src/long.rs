//! `cargo xtask long`: what takes hours and so does not run before every change.

use crate::report::{CheckAccount, Tally};
use crate::{
    blocks, book, browser, documents, doors, exports, fuzz, hostile, instructions, paper, peers, python,
    soak, tools, tutorials,
};

/// A task by its name.
type LongTask = (&'static str, fn() -> Tally);

/// The tasks, the shorter ones first. docs/testing.md lists them.
const TASKS: [LongTask; 17] = [
    ("tests", tests),
    ("doors", doors::check),
    ("instructions", instructions::check),
    ("tutorials", || Tally::one(tutorials::all())),
    ("pages", || Tally::one(blocks::all())),
    ("book", || Tally::one(book::build())),
    ("paper", || Tally::one(paper::run())),
    ("browser", browser::check),
    ("exports", exports::check),
    ("soak", || Tally::one(soak::hour())),
    ("hostile", || Tally::one(hostile::hostile(&[]))),
    ("faults", hostile::disturbed::faults),
    ("kills", hostile::disturbed::kills),
    ("python-calls", || Tally::one(python::task(&["calls".into()]))),
    ("comparisons", comparisons),
    ("fuzz", || Tally::one(fuzz::fuzz(&[]))),
    ("peers", || Tally::one(peers::compare(None))),
];

/// Runs the tasks that `arguments` name, or all whose tools are here; true when all pass.
pub fn long(arguments: &[String]) -> bool {
    let unknown = arguments.iter().find(|name| TASKS.iter().all(|(known, _)| known != name));
    if let Some(unknown) = unknown {
        eprintln!("error: no long task {unknown}; there are {}", TASKS.map(|(name, _)| name).join(", "));
        return false;
    }
    if !tools::tests_built() {
        return false;
    }
    let mut account = CheckAccount::default();
    for (name, run) in TASKS {
        if !chosen(name, arguments) {
            if !arguments.is_empty() {
                continue;
            }
            println!("\n== {name}\nleft out: target/peers is missing, `cargo xtask long {name}` makes it");
        } else {
            account.step(name, run);
        }
    }
    account.close()
}

/// Whether a task was asked for. The other programs that the peers are take gigabytes: unless asked for they are met only where they
/// are installed.
fn chosen(name: &str, arguments: &[String]) -> bool {
    if arguments.is_empty() {
        return name != "peers" || tools::root().join("target/peers").is_dir();
    }
    arguments.iter().any(|asked| asked == name)
}

/// The tests that `cargo xtask test` leaves out, Python's too.
fn tests() -> Tally {
    let mut tally = Tally::of(tools::cargo(
        &[&["test"], &tools::TESTS[..], &["--no-fail-fast", "--", "--ignored"]].concat(),
    ));
    let python = python::check(true);
    tally.passed += python.passed;
    tally.failed += python.failed;
    tally
}

/// Every comparison, those that take minutes too, and the numbers of docs/validation.md beside theirs.
fn comparisons() -> Tally {
    documents::compared("target/long.json", &["--long"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_named_alone_runs_and_every_task_is_on_the_page() {
        let asked = ["soak".to_owned()];
        assert!(chosen("soak", &asked) && !chosen("paper", &asked) && chosen("paper", &[]));
        let page = std::fs::read_to_string(tools::root().join("docs/testing.md")).unwrap();
        for (name, _) in TASKS {
            assert!(page.contains(&format!("| `{name}`")), "{name}");
        }
    }
}
