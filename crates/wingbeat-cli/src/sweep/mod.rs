//! `wingbeat sweep`.

mod cases;
mod end_points;
mod flights;
pub mod log;
mod search;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use indicatif::ProgressBar;
use serde::Serialize;
use wingbeat::judge::Verdict;
use wingbeat::parallel;
use wingbeat::scenario::{Sampling, Sweep, SweepCounts, SweepOf, SweepRows};
use wingbeat::simulate::{Column, Record};
use wingbeat_io::{write_csv, write_parquet};

use crate::args;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::outcome::overridden;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::tether::CaseTables;
use log::SweepLog;

/// Makes what is left of the sweep and writes its run folder.
pub fn sweep(arguments: &args::SweepArguments) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let tables = CaseTables::default();
    let read = |path: &std::path::Path| tables.read(path);
    let sweep = Sweep::load(&arguments.sweep, &options.all_overrides(), &read)?;
    let kept = sweep.kept(&read, |path| tables.name(path))?;
    let name = &sweep.spec.run_name()?;
    let folder = RunFolder::resume(options.out.as_deref(), name, options.force, ("sweep.toml", &kept))?;
    tables.keep(&folder)?;
    let log = folder.file(&format!("{}.log", noun(&sweep)));
    let (verdict, said) = match sweep.search() {
        Some(asked) => {
            let mut log = SweepLog::open(&log, |row| asked.has_row(row))?;
            let search = search::candidates(&sweep, &mut log, &interrupt, options.quiet)?;
            let record = tabled(&folder, &sweep, log, search.columns())?;
            search::summary(&folder, &sweep, &search, &record)?
        }
        None => {
            let mut log = SweepLog::open(&log, |row| sweep.has_row(row))?;
            let work = SweepWork { sweep: &sweep, tables: &tables, interrupt: &interrupt };
            let stepped = work.all(&mut log, options.quiet)?;
            let record = tabled(&folder, &sweep, log, sweep.columns())?;
            let (verdict, said) = summary(&folder, &sweep, &record)?;
            draw(&folder, &sweep, &record)?;
            (verdict, said + &stepped.told())
        }
    };
    crate::report::beside(&folder, &sweep.spec.name, None, !arguments.page.no_report)?;
    let path = folder.finish(&Manifest::new(sweep.spec.seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed = say::unless(options.quiet, || format!("{said}\nrun folder: {}\n", shown.display()));
    Error::unless_usable(verdict.status, verdict.reason.as_deref(), shown)?;
    printed
}

/// Writes the rows of the log as tables, and removes it.
fn tabled(folder: &RunFolder, sweep: &Sweep, log: SweepLog, columns: Vec<Column>) -> Result<Record, Error> {
    let record = log.record(columns)?;
    log.remove()?;
    write_csv(&folder.file(&format!("{}.csv", noun(sweep))), &record)?;
    write_parquet(&folder.file("record.parquet"), &record)?;
    Ok(record)
}

/// What the runs are called.
fn noun(sweep: &Sweep) -> &'static str {
    match sweep.of {
        _ if sweep.spec.search.is_some() => "candidates",
        SweepOf::Flights(_) => "flights",
        SweepOf::Cases => "runs",
    }
}

/// What the cores share.
struct SweepWork<'a> {
    sweep: &'a Sweep,
    tables: &'a CaseTables,
    interrupt: &'a Interrupt,
}

impl SweepWork<'_> {
    /// Makes the runs that are not in the log, on all cores.
    fn all(&self, log: &mut SweepLog, quiet: bool) -> Result<SteppingCounts, Error> {
        let all = self.sweep.runs();
        let todo: Vec<usize> = (0..all).filter(|run| !log.has(*run)).collect();
        let progress = progress(noun(self.sweep), all, log.len(), quiet);
        let mut stepped = SteppingCounts { lanes: self.sweep.spec.lanes, runs: 0, groups: 0 };
        let mut outcome = Ok(());
        parallel::each(
            &self.sweep.batches(todo),
            |_, batch| self.rows(batch),
            |_, made| {
                let kept = made.and_then(|SweepRows { rows, groups }| {
                    rows.iter().try_for_each(|row| log.append(row))?;
                    progress.inc(rows.len() as u64);
                    stepped.runs += rows.len();
                    stepped.groups += groups;
                    Ok(!rows.is_empty())
                });
                match kept {
                    Ok(true) => ControlFlow::Continue(()),
                    stopped => {
                        outcome = stopped.map(drop);
                        ControlFlow::Break(())
                    }
                }
            },
        );
        outcome?;
        progress.finish_and_clear();
        let done = log.len();
        if done < all { Err(Error::Paused { done, all }) } else { Ok(stepped) }
    }

    /// The rows of a batch of runs; none when it was interrupted.
    fn rows(&self, batch: &[usize]) -> Result<SweepRows, Error> {
        Ok(self.sweep.rows(batch, &|path| self.tables.read(path), || self.interrupt.flow())?)
    }
}

/// How the flights were stepped that were made now.
struct SteppingCounts {
    lanes: bool,
    runs: usize,
    groups: usize,
}

impl SteppingCounts {
    /// In words, where lanes were asked for.
    fn told(&self) -> String {
        if !self.lanes || self.groups == 0 {
            return String::new();
        }
        let filled = self.runs as f64 / self.groups as f64;
        format!("{} flights in lanes: on average {filled:.1} side by side\n", self.runs)
    }
}

fn progress(noun: &str, runs: usize, done: usize, quiet: bool) -> ProgressBar {
    let template = format!("sweeping {{bar:30}} {{pos}} of {{len}} {noun}  ({{eta}} left)");
    progress::bar(Some(runs as u64), &template, quiet).with_position(done as u64)
}

/// Writes summary.json; the verdict, and what it says in words.
fn summary(folder: &RunFolder, sweep: &Sweep, record: &Record) -> Result<(Verdict, String), Error> {
    let (verdict, counts) = (sweep.verdict(record), SweepCounts::new(record));
    let shared = SharedSummary {
        verdict: &verdict,
        ending: if counts.completed == counts.runs { "complete" } else { "incomplete" },
        completed: counts.completed,
        usable: counts.usable,
        statuses: &counts.statuses,
    };
    let table = match sweep.of {
        SweepOf::Flights(hold) => {
            let is_sample = sweep.spec.sampling != Sampling::Grid && !sweep.all_alike(record);
            let ends = end_points::table(record, sweep);
            let own = flights::FlightSweepSummary::new(record, hold, is_sample, ends);
            folder.write_json("summary.json", &SweepSummary { shared, own: &own })?;
            own.table()
        }
        SweepOf::Cases => {
            let own = cases::CaseSweepSummary::new(record);
            folder.write_json("summary.json", &SweepSummary { shared, own: &own })?;
            own.table(record, sweep)
        }
    };
    let noun = noun(sweep);
    let mut text = format!("{} of {} {noun} completed: {}\n", counts.completed, counts.runs, counts.words());
    let why = verdict.why_not_judged().map_or(String::new(), |reason| format!("; {reason}"));
    text += &format!("status: {}{why}\n\n{table}", verdict.status);
    text += &overridden(&verdict.judged);
    text.extend(verdict.warnings.iter().map(|warning| format!("\n{warning}\n")));
    Ok((verdict, text))
}

/// What is said of sweeps of either kind.
#[derive(Serialize)]
struct SharedSummary<'a> {
    #[serde(flatten)]
    verdict: &'a Verdict,
    /// `complete`, or `incomplete` where a run broke down.
    ending: &'static str,
    completed: usize,
    /// Completed runs whose own verdict lets them be used.
    usable: usize,
    /// Runs by the status of their own verdict.
    statuses: &'a BTreeMap<&'static str, usize>,
}

/// `summary.json`.
#[derive(Serialize)]
struct SweepSummary<'a, T: Serialize> {
    #[serde(flatten)]
    shared: SharedSummary<'a>,
    #[serde(flatten)]
    own: &'a T,
}

fn draw(folder: &RunFolder, sweep: &Sweep, record: &Record) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    let drawn = match sweep.of {
        SweepOf::Flights(hold) => [flights::drawn(record, hold), end_points::drawn(record, sweep)]
            .into_iter()
            .chain(flights::mapped(record, sweep))
            .collect(),
        SweepOf::Cases => vec![cases::drawn(record, sweep)],
    };
    for drawn in drawn {
        crate::fly::left_out(drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure)))?;
    }
    Ok(())
}
