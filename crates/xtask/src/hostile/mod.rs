//! `cargo xtask hostile`: what an unlucky or hostile user does, as scripted cases run against the built program.
//!
//! Every call of the program runs under limits of memory, file size and time, and is judged on its exit code, on what
//! it says, on what lies on disk before and after, and that it neither panics nor aborts. Most cases are data, the lists
//! of `crates/xtask/hostile` ([`data`]); what needs code is a short script ([`ScriptedCase::new`]).
//! A case that cannot be run has failed.

mod case;
mod data;
pub mod disturbed;
mod judge;
mod learn;
mod pictures;
mod place;
mod readers;
mod runs;
mod series;
mod sizes;
mod snapshot;
mod status;
mod step;
mod text;

use std::fs;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::report::Tally;
use crate::tools;
pub use case::ScriptedCase;
use place::CaseFolder;

/// What a class asks for.
const CLASSES: [(u8, &str); 8] = [
    (1, "a run destroys nothing it did not make"),
    (2, "no panic, no abort, no endless wait"),
    (3, "status is honest"),
    (4, "a run is a snapshot"),
    (5, "every sample is in a count"),
    (6, "large real files"),
    (7, "pictures and tables tell the truth"),
    (8, "a stranger can learn every input and output"),
];

/// What is to be run.
struct CaseChoice {
    program: PathBuf,
    /// Only the short cases.
    quick: bool,
    class: Option<u8>,
    /// Only cases whose name holds one of these, where there are any.
    names: Vec<String>,
}

/// All cases.
fn cases() -> Vec<ScriptedCase> {
    [
        runs::cases(),
        sizes::cases(),
        status::cases(),
        snapshot::cases(),
        readers::cases(),
        pictures::cases(),
        learn::cases(),
        data::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Runs the cases that `arguments` choose; true when all pass.
pub fn hostile(arguments: &[String]) -> bool {
    if arguments.iter().any(|argument| argument == "--list") {
        cases().iter().for_each(|case| println!("{} {}", case.class, case.name));
        return true;
    }
    let Some(choice) = CaseChoice::of(arguments) else { return false };
    let tally = choice.run();
    tally.failed == 0 && tally.passed > 0
}

/// Runs the short cases against the program that was built.
pub fn quick() -> Tally {
    CaseChoice { program: tools::program(), quick: true, class: None, names: Vec::new() }.run()
}

impl CaseChoice {
    fn of(arguments: &[String]) -> Option<Self> {
        let mut choice = Self { program: PathBuf::new(), quick: false, class: None, names: Vec::new() };
        let mut rest = arguments.iter();
        while let Some(argument) = rest.next() {
            match argument.as_str() {
                "--quick" => choice.quick = true,
                "--class" => choice.class = Some(rest.next()?.parse().ok()?),
                "--program" => choice.program = std::path::absolute(rest.next()?).ok()?,
                option if option.starts_with('-') => {
                    eprintln!(
                        "error: no option {option}; there are --list, --quick, --class N, --program FILE"
                    );
                    return None;
                }
                name => choice.names.push(name.into()),
            }
        }
        if choice.program.as_os_str().is_empty() {
            choice.program = tools::program();
            tools::built().then_some(())?;
        }
        Some(choice)
    }

    fn takes(&self, case: &ScriptedCase) -> bool {
        (!self.quick || case.quick)
            && self.class.is_none_or(|class| class == case.class)
            && (self.names.is_empty() || self.names.iter().any(|name| case.name.contains(name)))
    }

    /// Runs what is chosen, those that need the machine to themselves last and one by one.
    fn run(&self) -> Tally {
        let start = Instant::now();
        let chosen: Vec<ScriptedCase> = cases().into_iter().filter(|case| self.takes(case)).collect();
        let (alone, side): (Vec<&ScriptedCase>, Vec<&ScriptedCase>) =
            chosen.iter().partition(|case| case.alone);
        let failures = Mutex::new(Vec::new());
        let workers = std::thread::available_parallelism().map_or(1, usize::from);
        for (cases, workers) in [(side, workers), (alone, 1)] {
            let next = AtomicUsize::new(0);
            std::thread::scope(|scope| {
                for _ in 0..workers {
                    scope.spawn(|| {
                        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                            let Err(why) = self.one(case) else { continue };
                            println!("FAILED {} {}: {why}", case.class, case.name);
                            failures.lock().unwrap_or_else(|broken| broken.into_inner()).push(case.class);
                        }
                    });
                }
            });
        }
        let failures = failures.into_inner().unwrap_or_else(|broken| broken.into_inner());
        println!("\n{:<46}{:>8}{:>8}", "class", "passed", "failed");
        for (class, what) in CLASSES {
            let all = chosen.iter().filter(|case| case.class == class).count();
            let failed = failures.iter().filter(|failed| **failed == class).count();
            println!("{:<46}{:>8}{failed:>8}", format!("{class} {what}"), all - failed);
        }
        let (failed, passed) = (failures.len(), chosen.len() - failures.len());
        println!("\n{passed} passed, {failed} failed in {:.1} s", start.elapsed().as_secs_f64());
        Tally { passed, failed }
    }

    /// Runs one case in an empty folder, which goes when it passes.
    fn one(&self, case: &ScriptedCase) -> Result<(), String> {
        let folder = tools::root().join("target/hostile").join(format!("{}-{}", case.class, case.name));
        let place = CaseFolder::new(&self.program, &folder)?;
        (case.play)(&place)?;
        place.within_disk()?;
        fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_unique_and_every_case_has_a_class() {
        let all = cases();
        let names: BTreeSet<_> = all.iter().map(|case| (case.class, &case.name)).collect();
        assert_eq!(names.len(), all.len());
        assert!(all.iter().all(|case| CLASSES.iter().any(|(class, _)| *class == case.class)));
    }
}
