//! `wingbeat paper`: the figures of the paper by our numbers, and one sheet.

mod figures;
mod sheet;
mod statements;

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::Value;
use wingbeat::judge::limits::paper as limits;
use wingbeat::judge::{Judge, RunLimits, Status, Verdict, Warning};
use wingbeat::scenario::{PaperResults, RunName};

use crate::args::{Fly, Page, PaperArguments, RigProcess, RigRuns, RigSimulate, RunArguments};
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::watch::WatchArguments;
use crate::{fly, rig};
use figures::PaperFigures;
use statements::{Statement, StatementSources};

/// The sheet stands in the place of the pages of its runs.
const PAGE: Page = Page { no_report: true };
/// The flights, as folder and file.
const FLIGHTS: [(&str, &str); 2] =
    [("turn", "scenarios/banking_turn.toml"), ("clear", "scenarios/paper_turn_clear.toml")];
/// The runs on the rig.
const RUNS: &str = "rigs/seven_runs.toml";
/// Pieces of work that the bar counts: flights, rig, processing, set-up, arm, wake, figures.
const WORK: u64 = 8;

/// `summary.json`.
#[derive(Serialize)]
struct PaperSummary<'a> {
    #[serde(flatten)]
    verdict: &'a Verdict,
    statements: &'a [Statement],
    steps: &'a [PaperStep],
    figures: Vec<&'a str>,
}

/// A command that the sheet rests on, and how it ended.
#[derive(Clone, Debug, Serialize)]
pub struct PaperStep {
    /// What makes the same.
    pub command: String,
    /// Its folder; empty where it keeps none of its own.
    pub folder: &'static str,
    /// Its status.
    pub status: String,
    /// Why, where it is not `ok`.
    pub reason: Option<String>,
}

/// Makes the runs that the figures show, draws them and writes the sheet.
pub fn paper(arguments: &PaperArguments) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let from = &arguments.from;
    let folder =
        RunFolder::create(arguments.out.as_deref(), &RunName::new("name", "paper")?, arguments.force)?;
    let bar = progress::bar(Some(WORK), "paper {bar:30} {pos} of {len}  {msg}", arguments.quiet);
    let mut work = PaperWork { folder: &folder, from, interrupt: &interrupt, bar: &bar, steps: Vec::new() };
    for (name, file) in FLIGHTS {
        work.fly(name, file)?;
    }
    work.rig()?;
    let mut drawn = PaperFigures::new(&folder, arguments.wide)?;
    let (told, paper) = work.draw(&mut drawn)?;
    let statements = statements::all(&told, paper.as_ref());
    let steps = work.steps;
    let verdict = judged(drawn.missing(), &steps);
    let names = drawn.names();
    let summary = PaperSummary { verdict: &verdict, statements: &statements, steps: &steps, figures: names };
    folder.write_json("summary.json", &summary)?;
    folder.write("sheet.html", &sheet::html(&statements, &steps, &drawn, &verdict))?;
    bar.finish_and_clear();
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed = say::unless(arguments.quiet, || {
        format!("{}\nsheet: {}\n", statements::table(&statements), shown.join("sheet.html").display())
    });
    Error::unless_usable(verdict.status, verdict.reason.as_deref(), shown)?;
    printed
}

/// Holds the sheet against its limits.
fn judged(missing: usize, steps: &[PaperStep]) -> Verdict {
    let limits_of = RunLimits::default();
    let mut judge = Judge::new(&limits_of);
    judge.hold(&limits::MISSING, missing as f64);
    let failed = steps.iter().filter(|step| step.status == Status::Failed.name()).count();
    judge.hold(&limits::FAILED, failed as f64);
    for step in steps.iter().filter(|step| step.status != "ok") {
        let reason = step.reason.as_deref().unwrap_or("no reason is given");
        judge.warn(Warning::new("paper.step", format!("{}: {}: {reason}", step.command, step.status)));
    }
    judge.verdict()
}

/// What the pieces of work share.
struct PaperWork<'a> {
    folder: &'a RunFolder,
    from: &'a Path,
    interrupt: &'a Interrupt,
    bar: &'a ProgressBar,
    steps: Vec<PaperStep>,
}

impl PaperWork<'_> {
    fn begin(&self, what: &str) -> Result<(), Error> {
        self.bar.set_message(what.to_owned());
        self.interrupt.check()
    }

    /// Options of a run of our own in the folder `name`.
    fn options(&self, name: &str) -> RunArguments {
        let out = Some(self.folder.file(name));
        RunArguments { out, force: false, overrides: Vec::new(), seed: None, quiet: true }
    }

    /// Keeps how a run ended: one whose verdict is not `ok` is a result too.
    fn ended(&mut self, command: String, folder: &'static str, made: Result<(), Error>) -> Result<(), Error> {
        let (status, reason) = match made {
            Ok(()) => {
                let told = summaries(&self.folder.file(folder))?;
                let status = |told: &Value| told["status"].as_str().unwrap_or("without status").to_owned();
                let unlike = told.iter().find(|told| status(told) != Status::Ok.name());
                let reason = unlike.and_then(|told| told["reason"].as_str()).map(str::to_owned);
                (unlike.map_or(Status::Ok.name().to_owned(), status), reason)
            }
            Err(Error::Failed { status, reason, .. }) => (status, Some(reason)),
            Err(error) => return Err(error),
        };
        self.steps.push(PaperStep { command, folder, status, reason });
        self.bar.inc(1);
        Ok(())
    }

    fn fly(&mut self, name: &'static str, file: &str) -> Result<(), Error> {
        self.begin(&format!("flying {file}"))?;
        let made = fly::fly(&Fly {
            scenario: self.from.join(file),
            run: self.options(name),
            page: PAGE,
            live: WatchArguments::default(),
        });
        self.ended(format!("wingbeat fly {file}"), name, made)
    }

    /// Simulates the seven runs and takes weight and inertia away.
    fn rig(&mut self) -> Result<(), Error> {
        self.begin("simulating the rig")?;
        let runs = RigRuns { file: self.from.join(RUNS), run: self.options("rig") };
        self.ended(
            format!("wingbeat rig simulate {RUNS}"),
            "rig",
            rig::simulate(&RigSimulate { runs, page: PAGE }),
        )?;
        self.begin("processing the runs")?;
        let process = RigProcess {
            path: self.folder.file("rig"),
            run: None,
            out: Some(self.folder.file("forces")),
            force: false,
            overrides: Vec::new(),
            quiet: true,
            page: PAGE,
        };
        self.ended("wingbeat rig process rig".into(), "forces", rig::process(&process))
    }

    /// Draws the figures; the numbers that the statements need, and what the paper gives.
    fn draw(&self, drawn: &mut PaperFigures) -> Result<(StatementSources, Option<PaperResults>), Error> {
        self.begin("drawing the set-up")?;
        drawn.set_up(self.from)?;
        self.bar.inc(1);
        self.begin("drawing the arm")?;
        drawn.arm(self.from)?;
        let arm = figures::slowest(self.from)?;
        self.bar.inc(1);
        self.begin("drawing forces and moments")?;
        let forces = drawn.forces(&self.folder.file("forces"))?;
        self.bar.inc(1);
        self.begin("stepping the wake")?;
        let (wake, paper) = drawn.flight(&self.folder.file("turn"), self.interrupt)?;
        self.bar.inc(1);
        let [turn, clear] = FLIGHTS.map(|(name, _)| summary(&self.folder.file(name)));
        Ok((StatementSources { turn: turn?, clear: clear?, wake, forces, arm }, paper))
    }
}

/// `summary.json` of a folder that a run of ours wrote.
fn summary(folder: &Path) -> Result<Value, Error> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|source| Error::file(&path, source))?;
    serde_json::from_str(&text).map_err(|error| Error::Input(format!("{}: {error}", path.display())))
}

/// That of a folder, or those of its folders: runs on the rig have one each.
fn summaries(folder: &Path) -> Result<Vec<Value>, Error> {
    if folder.join("summary.json").is_file() {
        return Ok(vec![summary(folder)?]);
    }
    let entries = std::fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let mut runs: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    runs.retain(|run| run.join("summary.json").is_file());
    runs.sort();
    // Of none the missing file is named.
    if runs.is_empty() {
        summary(folder).map(|told| vec![told])
    } else {
        runs.iter().map(|run| summary(run)).collect()
    }
}

/// The path of a shipped document below `from`.
fn shipped(from: &Path, file: &str) -> PathBuf {
    from.join(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_run_fails_the_sheet_and_a_missed_goal_does_not() {
        let step =
            |status: &str| PaperStep { command: "a".into(), folder: "", status: status.into(), reason: None };
        let status = |missing, steps: &[PaperStep]| judged(missing, steps).status;
        assert_eq!(status(0, &[step("ok"), step("off_target")]), Status::Ok);
        assert_eq!(status(0, &[step("ok"), step("failed")]), Status::Failed);
        assert_eq!(status(1, &[step("ok")]), Status::Failed);
        assert_eq!(judged(0, &[step("off_target")]).warnings.len(), 1);
    }

    #[test]
    fn a_summary_that_cannot_be_read_is_named() {
        let folder = std::env::temp_dir().join(format!("wingbeat-sheet-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let said = |folder: &Path| summary(folder).unwrap_err().to_string();
        assert!(said(&folder.join("none")).contains("summary.json"));
        std::fs::write(folder.join("summary.json"), "{\"status\": ").unwrap();
        assert!(said(&folder).contains("summary.json"));
        assert!(summaries(&folder).is_err());
        std::fs::remove_file(folder.join("summary.json")).unwrap();
        assert!(summaries(&folder).is_err());
        std::fs::create_dir_all(folder.join("a")).unwrap();
        std::fs::write(folder.join("a/summary.json"), "{\"status\": \"ok\"}").unwrap();
        assert_eq!(summaries(&folder).unwrap().len(), 1);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
