//! The account of checks that passed and failed.

use std::collections::VecDeque;
use std::ops::AddAssign;
use std::process::{Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::tools;

/// Checks done so far, by step.
#[derive(Default)]
pub struct CheckAccount {
    steps: Vec<CheckStep>,
}

struct CheckStep {
    name: String,
    passed: usize,
    failed: usize,
    took: Duration,
}

/// Commands that are run one after another, while other jobs are.
pub struct Job {
    /// What the account calls them.
    pub name: String,
    /// Each is run whether or not those before it have succeeded.
    pub commands: Vec<Command>,
}

/// Checks of one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    /// Checks that passed.
    pub passed: usize,
    /// Checks that failed.
    pub failed: usize,
}

impl Tally {
    /// One check.
    pub fn one(passed: bool) -> Self {
        Self { passed: usize::from(passed), failed: usize::from(!passed) }
    }

    /// The checks that the command's output counts; a failure that it does not count is one.
    pub fn of(command: Command) -> Self {
        let mut tally = Self::default();
        let success = tools::lines(command, |line| tally.add(line));
        if !success && tally.failed == 0 {
            tally.failed = 1;
        }
        tally
    }

    /// The checks that the output of a command counts, or the command itself where it counts none; a failure that is not counted is one.
    fn counted(text: &str, success: bool) -> Self {
        let mut tally = Self::default();
        text.lines().for_each(|line| tally.add(line));
        match (success, tally) {
            (true, Self { passed: 0, failed: 0 }) => Self::one(true),
            (false, Self { failed: 0, .. }) => Self { failed: 1, ..tally },
            _ => tally,
        }
    }

    /// Adds what a line like `test result: ok. 3 passed; 0 failed; ...` or `3 passed, 0 failed` says.
    pub fn add(&mut self, line: &str) {
        let words: Vec<&str> = line.split([' ', ',', ';']).filter(|word| !word.is_empty()).collect();
        let count = |name: &str| {
            let at = words.iter().position(|word| *word == name)?;
            words.get(at.checked_sub(1)?)?.parse::<usize>().ok()
        };
        if let (Some(passed), Some(failed)) = (count("passed"), count("failed")) {
            self.passed += passed;
            self.failed += failed;
        }
    }
}

impl Job {
    /// Runs the commands and shows what they said.
    fn run(self) -> CheckStep {
        let start = Instant::now();
        let mut tally = Tally::default();
        let mut said = String::new();
        for mut command in self.commands {
            match command.stdin(Stdio::null()).output() {
                Ok(output) => {
                    let text = [output.stdout, output.stderr]
                        .map(|text| String::from_utf8_lossy(&text).into_owned());
                    let text = text.concat();
                    tally += Tally::counted(&text, output.status.success());
                    said += &text;
                }
                Err(error) => {
                    tally += Tally::one(false);
                    said += &format!("error: {command:?}: {error}\n");
                }
            }
        }
        println!("\n== {}\n{said}", self.name);
        CheckStep { name: self.name, passed: tally.passed, failed: tally.failed, took: start.elapsed() }
    }
}

/// The job that has waited longest.
fn next(waiting: &Mutex<VecDeque<Job>>) -> Option<Job> {
    lock(waiting).pop_front()
}

/// What stands behind a lock, also where a thread that held it has panicked.
fn lock<T>(behind: &Mutex<T>) -> MutexGuard<'_, T> {
    behind.lock().unwrap_or_else(PoisonError::into_inner)
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
    }
}

impl CheckAccount {
    /// Does a step and keeps account of it.
    pub fn step(&mut self, name: &'static str, run: impl FnOnce() -> Tally) {
        println!("\n== {name}");
        let start = Instant::now();
        let Tally { passed, failed } = run();
        self.steps.push(CheckStep { name: name.into(), passed, failed, took: start.elapsed() });
    }

    /// Does jobs side by side, as many at once as there are cores, with the steps of `others` in the place of one of them. What a job
    /// says is shown when it has ended.
    pub fn together(&mut self, jobs: Vec<Job>, others: impl FnOnce(&mut Self)) {
        let waiting = Mutex::new(VecDeque::from(jobs));
        let done = Mutex::new(Vec::new());
        let work = || {
            while let Some(job) = next(&waiting) {
                let step = job.run();
                lock(&done).push(step);
            }
        };
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        std::thread::scope(|scope| {
            for _ in 1..cores {
                scope.spawn(work);
            }
            others(self);
            work();
        });
        self.steps.append(&mut lock(&done));
    }

    /// Prints the account; true when nothing failed.
    pub fn close(&self) -> bool {
        println!("\n{:<28} {:>7} {:>7} {:>9}", "step", "passed", "failed", "time");
        for step in &self.steps {
            let seconds = step.took.as_secs_f64();
            println!("{:<28} {:>7} {:>7} {:>7.1} s", step.name, step.passed, step.failed, seconds);
        }
        let total = |of: fn(&CheckStep) -> usize| self.steps.iter().map(of).sum::<usize>();
        let (passed, failed) = (total(|step| step.passed), total(|step| step.failed));
        println!("\n{passed} passed, {failed} failed");
        failed == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn result_lines_are_counted_and_others_are_not() {
        let mut tally = Tally::default();
        tally.add("test result: ok. 14 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        tally.add("12 passed, 1 failed, 3 shown without a limit in 0.1 s");
        tally.add("test it_passed ... ok");
        assert_eq!(tally, Tally { passed: 26, failed: 1 });
    }
}
