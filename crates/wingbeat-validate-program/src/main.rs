//! The program `wingbeat-validate`, which `wingbeat validate` hands over to.

use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use serde::Serialize;
use wingbeat::scenario::RunName;
use wingbeat_io::shortest;
use wingbeat_program::comparisons::Comparisons;
use wingbeat_program::error::Error;
use wingbeat_program::interrupt::Interrupt;
use wingbeat_program::manifest::Manifest;
use wingbeat_program::run_folder::RunFolder;
use wingbeat_program::{progress, say};
use wingbeat_validate::figures::{PICTURES, SLOW_PICTURES};
use wingbeat_validate::{Case, ComparisonRow, LongCase, Selection, select, select_long};

#[derive(Parser)]
#[command(name = "wingbeat-validate", version, max_term_width = 100)]
struct Arguments {
    #[command(flatten)]
    comparisons: Comparisons,
}

fn main() -> ExitCode {
    wingbeat_program::run(|| validate(&Arguments::parse().comparisons))
}

/// The contents of `summary.json`.
#[derive(Serialize)]
struct ComparisonSummary {
    status: &'static str,
    passed: usize,
    failed: usize,
    shown: usize,
}

/// Runs the wanted comparisons, prints their table and writes their folder when one is asked for.
fn validate(arguments: &Comparisons) -> Result<(), Error> {
    let selection = Selection { only: arguments.only.clone(), quick: arguments.quick };
    let mut all = wingbeat_validate::cases();
    let mut long = Vec::new();
    if arguments.long {
        all.extend(wingbeat_validate::slow_cases());
        long = select_long(&wingbeat_validate::long_cases(), &selection);
    }
    let cases = select(&all, &selection);
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    arguments.json.as_deref().map_or(Ok(()), may_replace)?;
    let name = RunName::new("name", "validate")?;
    let out = arguments.out.as_deref();
    let folder = out.map(|out| RunFolder::create(Some(out), &name, arguments.force)).transpose()?;
    if !arguments.quiet {
        tell_minutes(&long);
    }
    let mut rows = compare(&cases, &selection, &interrupt, arguments.quiet);
    interrupt.check()?;
    rows.extend(compare_long(&long, &selection, &interrupt, arguments.quiet));
    interrupt.check()?;
    if rows.is_empty() {
        return Err(nothing_selected(&selection, arguments.long));
    }
    let summary = ComparisonSummary::of(&rows);
    let mut told = wingbeat_validate::table(&rows);
    told += &format!("\n{} in {:.1} s\n", summary.tally(), start.elapsed().as_secs_f64());
    if let Some(path) = &arguments.json {
        replace(path, &json(&rows)?)?;
    }
    if let Some(folder) = folder {
        fill(&folder, &rows, &summary)?;
        draw(&folder, &cases, &interrupt)?;
        let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
        told += &format!("folder: {}\n", shown(&path).display());
    }
    let printed = say::say(&told);
    if summary.failed == 0 { printed } else { Err(Error::ComparisonFailed) }
}

/// Refuses to write over a file that is no list of rows.
fn may_replace(path: &Path) -> Result<(), Error> {
    if fs::symlink_metadata(path).is_err() {
        return Ok(());
    }
    let is_file = fs::symlink_metadata(path).is_ok_and(|data| data.is_file());
    let text = if is_file { fs::read_to_string(path).unwrap_or_default() } else { String::new() };
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap_or_default();
    match rows.first().is_some_and(|row| row.get("id").is_some() && row.get("metric").is_some()) {
        true => Ok(()),
        false => {
            Err(Error::Input(format!("--json {}: allowed is a new file, or one with rows", path.display())))
        }
    }
}

/// Writes a file under another name and moves it when it is whole.
fn replace(path: &Path, text: &str) -> Result<(), Error> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".{name}.partial"));
    let written = fs::write(&partial, text).and_then(|()| fs::rename(&partial, path));
    written.map_err(|source| {
        let _ = fs::remove_file(&partial);
        Error::file(path, source)
    })
}

/// Runs `cases` on all cores, until interrupted.
fn compare(cases: &[&Case], selection: &Selection, interrupt: &Interrupt, quiet: bool) -> Vec<ComparisonRow> {
    let progress = progress::bar(Some(cases.len() as u64), "{bar:30} {pos}/{len} {wide_msg}", quiet);
    let rows = wingbeat_validate::run(cases, selection, |rows| {
        progress.inc(1);
        progress.set_message(rows.first().map_or(String::new(), |row| row.id.clone()));
        interrupt.flow()
    });
    progress.finish_and_clear();
    rows
}

/// Says how long `cases` take, where there are any.
fn tell_minutes(cases: &[&LongCase]) {
    let minutes: f64 = cases.iter().map(|case| case.core_minutes).sum();
    if minutes > 0.0 {
        let cores = std::thread::available_parallelism().map_or(1, usize::from) as f64;
        let ids = cases.iter().map(|case| case.id).collect::<Vec<_>>().join(", ");
        let here = minutes / cores;
        say::note(&format!(
            "{ids}: {minutes:.0} min of processor time, about {here:.0} min on {cores} cores"
        ));
    }
}

/// Runs `cases` one after another, each on all cores, until interrupted.
fn compare_long(
    cases: &[&LongCase],
    selection: &Selection,
    interrupt: &Interrupt,
    quiet: bool,
) -> Vec<ComparisonRow> {
    let progress = progress::bar(None, "{bar:30} {pos}/{len} {msg}  ({eta} left)", quiet);
    let told = |id: &str, done: usize, all: usize| {
        if done == 0 {
            progress.reset();
            progress.set_length(all as u64);
            progress.set_message(id.to_owned());
        }
        progress.set_position(done as u64);
        interrupt.flow()
    };
    let rows = wingbeat_validate::run_long(cases, selection, told, |_| ());
    progress.finish_and_clear();
    rows
}

/// Writes rows, summary and, when all its rows are there, the page.
fn fill(folder: &RunFolder, rows: &[ComparisonRow], summary: &ComparisonSummary) -> Result<(), Error> {
    folder.write("rows.json", &json(rows)?)?;
    folder.write("rows.csv", &csv(rows))?;
    folder.write_json("summary.json", summary)?;
    if let Some(page) = wingbeat_validate::page(rows) {
        folder.write("validation.md", &page)?;
    }
    Ok(())
}

/// Draws what `cases` compare; what cannot be drawn is said and left out.
fn draw(folder: &RunFolder, cases: &[&Case], interrupt: &Interrupt) -> Result<(), Error> {
    let pictures: Vec<_> = PICTURES
        .iter()
        .chain(SLOW_PICTURES)
        .filter(|p| cases.iter().any(|case| p.cases.contains(&case.id)))
        .collect();
    if pictures.is_empty() {
        return Ok(());
    }
    let figures = folder.folder("figures")?;
    for picture in pictures {
        interrupt.check()?;
        let drawn = (picture.draw)().map_err(|error| error.to_string()).and_then(|figure| {
            match wingbeat_figures::write_for_screen(&figures, &figure) {
                // The disk is full, or broken: what follows would not be whole.
                Err(wingbeat_figures::Error::File { path, source }) => Ok(Err(Error::File { path, source })),
                written => written.map(Ok).map_err(|error| error.to_string()),
            }
        });
        match drawn {
            Ok(written) => written?,
            Err(error) => say::note(&format!("the figure {} is left out: {error}", picture.name)),
        }
    }
    Ok(())
}

fn json(rows: &[ComparisonRow]) -> Result<String, Error> {
    let lines = wingbeat_validate::to_json(rows);
    let text = serde_json::to_string_pretty(&lines).map_err(|error| Error::Input(error.to_string()))?;
    Ok(text + "\n")
}

/// The rows as CSV.
fn csv(rows: &[ComparisonRow]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut text = String::from("id,source,metric,unit,value,limit,pass\n");
    for row in rows {
        let limit = row.limit.map_or(String::new(), shortest);
        let words = [&row.source, &row.metric].map(|words| quoted(words)).join(",");
        text += &format!(
            "{},{words},{},{},{limit},{}\n",
            row.id,
            quoted(row.unit),
            shortest(row.value),
            row.passes()
        );
    }
    text
}

fn shown(path: &Path) -> &Path {
    let here = std::env::current_dir().unwrap_or_default();
    path.strip_prefix(here).unwrap_or(path)
}

fn nothing_selected(selection: &Selection, long: bool) -> Error {
    let only = selection.only.as_deref().unwrap_or("");
    let (short, slow) = (wingbeat_validate::cases(), wingbeat_validate::slow_cases());
    let longest = wingbeat_validate::long_cases();
    let named = |selection: &Selection| {
        let (slow, longest) = (select(&slow, selection), select_long(&longest, selection));
        !slow.is_empty() || !longest.is_empty()
    };
    if !long && named(selection) {
        return Error::Input(format!("--only {only}: it takes minutes and is run with --long"));
    }
    let unhurried = Selection { quick: false, ..selection.clone() };
    if selection.quick && !select(&short, &unhurried).is_empty() {
        return Error::Input(format!(
            "--only {only}: it is none of the quick comparisons: leave --quick out"
        ));
    }
    let mut ids: Vec<&str> = short.iter().map(|case| case.id).collect();
    if long {
        ids.extend(slow.iter().map(|case| case.id).chain(longest.iter().map(|case| case.id)));
    }
    Error::Input(format!("--only {only}: no such comparison; there are {}", ids.join(", ")))
}

impl ComparisonSummary {
    fn of(rows: &[ComparisonRow]) -> Self {
        let failed = rows.iter().filter(|row| !row.passes()).count();
        let shown = rows.iter().filter(|row| row.limit.is_none()).count();
        let status = if failed == 0 { "ok" } else { "failed" };
        Self { status, passed: rows.len() - failed - shown, failed, shown }
    }

    fn tally(&self) -> String {
        format!("{} passed, {} failed, {} shown without a limit", self.passed, self.failed, self.shown)
    }
}
