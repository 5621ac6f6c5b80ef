//! The account of checks that passed and failed.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::tools;

/// Checks done so far, by step.
#[derive(Default)]
pub struct Account {
    steps: Vec<Step>,
}

struct Step {
    name: &'static str,
    passed: usize,
    failed: usize,
    took: Duration,
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

impl Account {
    /// Does a step and keeps account of it.
    pub fn step(&mut self, name: &'static str, run: impl FnOnce() -> Tally) {
        println!("\n== {name}");
        let start = Instant::now();
        let Tally { passed, failed } = run();
        self.steps.push(Step { name, passed, failed, took: start.elapsed() });
    }

    /// Does a step by a command of its own, whose output comes when it has ended, while `others` are done.
    pub fn beside(&mut self, name: &'static str, mut command: Command, others: impl FnOnce(&mut Self)) {
        println!("\n== {name} (told at its end)");
        let start = Instant::now();
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let told = std::thread::scope(|scope| {
            let run = scope.spawn(move || (command.output(), start.elapsed()));
            others(self);
            run.join().ok()
        });
        println!("\n== {name}");
        let mut tally = Tally::default();
        let Some((Ok(output), took)) = told else {
            println!("it could not be run");
            self.steps.push(Step { name, passed: 0, failed: 1, took: start.elapsed() });
            return;
        };
        for line in [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text)) {
            for line in line.lines() {
                println!("{line}");
                tally.add(line);
            }
        }
        if !output.status.success() && tally.failed == 0 {
            tally.failed = 1;
        }
        self.steps.push(Step { name, passed: tally.passed, failed: tally.failed, took });
    }

    /// Prints the account; true when nothing failed.
    pub fn close(&self) -> bool {
        println!("\n{:<12} {:>7} {:>7} {:>9}", "step", "passed", "failed", "time");
        for step in &self.steps {
            let seconds = step.took.as_secs_f64();
            println!("{:<12} {:>7} {:>7} {:>7.1} s", step.name, step.passed, step.failed, seconds);
        }
        let total = |of: fn(&Step) -> usize| self.steps.iter().map(of).sum::<usize>();
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
