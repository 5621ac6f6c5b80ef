//! `wingbeat validate`.

use std::fs;
use std::num::NonZero;
use std::thread;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use wingbeat_validate::{Row, Selection};

use crate::args::Validate;
use crate::error::Error;

/// Runs the wanted comparisons and prints their table.
pub fn validate(arguments: &Validate) -> Result<(), Error> {
    let selection = Selection { only: arguments.only.clone(), quick: arguments.quick };
    let all = wingbeat_validate::cases();
    let cases = wingbeat_validate::select(&all, &selection);
    let start = Instant::now();
    let progress = progress(cases.len(), arguments.quiet);
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    let rows = wingbeat_validate::run(&cases, &selection, threads, |rows| {
        progress.inc(1);
        progress.set_message(rows.first().map_or(String::new(), |row| row.id.clone()));
    });
    progress.finish_and_clear();
    if rows.is_empty() {
        return Err(nothing_selected(&selection, &all));
    }
    print!("{}", wingbeat_validate::table(&rows));
    println!("\n{} in {:.1} s", tally(&rows), start.elapsed().as_secs_f64());
    if let Some(path) = &arguments.json {
        let lines = wingbeat_validate::to_json(&rows);
        let mut text = serde_json::to_string_pretty(&lines).map_err(|e| Error::Input(e.to_string()))?;
        text.push('\n');
        fs::write(path, text).map_err(|source| Error::file(path, source))?;
    }
    if rows.iter().all(Row::passes) { Ok(()) } else { Err(Error::ComparisonFailed) }
}

fn progress(cases: usize, quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {wide_msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(cases as u64), target).with_style(style)
}

fn nothing_selected(selection: &Selection, all: &[&wingbeat_validate::Case]) -> Error {
    let ids: Vec<_> = all.iter().map(|case| case.id).collect();
    let only = selection.only.as_deref().unwrap_or("");
    Error::Input(format!("--only {only}: no such comparison; there are {}", ids.join(", ")))
}

fn tally(rows: &[Row]) -> String {
    let failed = rows.iter().filter(|row| !row.passes()).count();
    let shown = rows.iter().filter(|row| row.limit.is_none()).count();
    let passed = rows.len() - failed - shown;
    format!("{passed} passed, {failed} failed, {shown} shown without a limit")
}
