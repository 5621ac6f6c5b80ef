//! The search of gaits of `wingbeat trim`.

use wingbeat::scenario::{GaitSearch, Scenario, SearchSummary, Trimmed};
use wingbeat_io::{write_csv, write_parquet};

use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::sweep::log::Log;

/// Searches from the starts that are left and writes their table; the scenario of the best gait, on its orbit.
pub fn searched(
    search: &GaitSearch,
    folder: &RunFolder,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<(Scenario, SearchSummary), Error> {
    let all = search.starts();
    let mut log = Log::open(&folder.file("starts.log"), |row| search.has_row(row))?;
    let bar = progress::bar(Some(all as u64), "start {pos} of {len}  {msg}", quiet);
    bar.set_position(log.len() as u64);
    for start in (0..all).filter(|start| !log.has(*start)).collect::<Vec<_>>() {
        let row = search.row(start, &mut |at| {
            let missed = if at.violation > 0.0 {
                format!(", limits missed by {:.4}", at.violation)
            } else {
                String::new()
            };
            let (power, frequency) = (at.power_w_kg, at.frequency_hz);
            bar.set_message(format!(
                "iteration {}: {power:.2} W/kg, {frequency:.3} Hz{missed}",
                at.iteration
            ));
            interrupt.flow()
        });
        match row {
            Some(row) => log.append(&row)?,
            None if interrupt.flow().is_break() => return Err(Error::Paused { done: log.len(), all }),
            None => return Err(Error::Input(format!("trim.search: start {start} has no orbit"))),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let record = log.record(search.columns())?;
    let (best, summary) =
        search.best(&record).map_err(|reason| Error::Input(format!("trim.search: {reason}")))?;
    write_csv(&folder.file("starts.csv"), &record)?;
    write_parquet(&folder.file("starts.parquet"), &record)?;
    let robot = toml::to_string(&best.spec.robot).map_err(|error| Error::Input(error.to_string()))?;
    folder.write("robot.toml", &robot)?;
    match wingbeat_figures::starts(&record) {
        Ok(figure) => {
            if let Err(error) = wingbeat_figures::write(&folder.folder("figures")?, &figure) {
                say::note(&format!("a figure is left out: {error}"));
            }
        }
        Err(error) => say::note(&format!("a figure is left out: {error}")),
    }
    log.remove()?;
    Ok((best, summary))
}

/// Puts what the search came to into the summary of its best gait.
pub fn add(trimmed: &mut Trimmed, search: SearchSummary) {
    let summary = &mut trimmed.summary;
    if search.kept == 0 && summary.reason.is_none() {
        summary.status = "limits_missed";
        summary.reason = Some(format!(
            "no gait keeps to trim.search.limits; the nearest misses one by {:.4} of its scale, {}",
            search.violation, search.ended
        ));
    }
    summary.search = Some(search);
}

/// The search in words.
pub fn table(search: &SearchSummary) -> String {
    let SearchSummary { starts, kept, minima, best, ended, iterations, .. } = search;
    let mut text = format!(
        "{:<28}{kept} of {starts} starts keep to the limits, {minima} different minima; start {best}: {ended} after \
         {iterations} iterations\n",
        "search"
    );
    for (key, value) in &search.values {
        text += &format!("{:<28}{key} = {value:.5}\n", "");
    }
    text
}
