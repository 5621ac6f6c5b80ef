//! The search of a sweep.

use std::ops::ControlFlow;

use wingbeat::judge::Verdict;
use wingbeat::parallel;
use wingbeat::scenario::{CandidateSearch, Sweep, SweepFound};
use wingbeat::simulate::Record;

use super::log::SweepLog;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::outcome::overridden;
use crate::progress;
use crate::run_folder::RunFolder;

/// Flies the candidates that are not in the log, generation by generation.
pub fn candidates<'a>(
    sweep: &'a Sweep,
    log: &mut SweepLog,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<CandidateSearch<'a>, Error> {
    let Some(mut search) = sweep.search() else { return Err(Error::Input("search: none is given".into())) };
    let all = sweep.runs();
    let bar = progress::bar(Some(all as u64), "searching {bar:30} {pos} of {len} candidates  {msg}", quiet);
    bar.set_position(log.len() as u64);
    let mut best = f64::INFINITY;
    while !search.generation().is_empty() {
        let generation = search.generation();
        let todo: Vec<usize> = generation.clone().filter(|run| !log.has(*run)).collect();
        let mut outcome = Ok(());
        parallel::each(
            &todo,
            |_, run| search.row(*run, || interrupt.flow()),
            |_, made| match made.map_err(Error::from).and_then(|row| kept(log, row)) {
                Ok(true) => {
                    bar.inc(1);
                    ControlFlow::Continue(())
                }
                stopped => {
                    outcome = stopped.map(drop);
                    ControlFlow::Break(())
                }
            },
        );
        outcome?;
        let rows: Vec<Vec<f64>> =
            log.rows().filter(|row| generation.contains(&(row[0] as usize))).map(<[f64]>::to_vec).collect();
        if rows.len() < generation.len() {
            return Err(Error::Paused { done: log.len(), all });
        }
        // What lies in the log from before is of this search only where it holds the same values.
        if rows.iter().any(|row| !search.has_row(row)) {
            return Err(Error::Input(
                "the log holds candidates of another search: begin in another folder".into(),
            ));
        }
        let cost = |row: &Vec<f64>| row.last().copied().unwrap_or(f64::NAN);
        best = rows.iter().map(cost).fold(best, f64::min);
        bar.set_message(format!("least cost {best:.4}"));
        search.tell(rows.iter().map(Vec::as_slice));
    }
    bar.finish_and_clear();
    Ok(search)
}

/// Puts a row into the log; false where the candidate was stopped.
fn kept(log: &mut SweepLog, row: Option<Vec<f64>>) -> Result<bool, Error> {
    row.as_deref().map(|row| log.append(row)).transpose().map(|kept| kept.is_some())
}

/// Writes summary.json, the best scenario and the figure; the verdict, and what it says in words.
pub fn summary(
    folder: &RunFolder,
    sweep: &Sweep,
    search: &CandidateSearch<'_>,
    record: &Record,
) -> Result<(Verdict, String), Error> {
    let summary =
        sweep.searched(record).ok_or_else(|| Error::Input("runs: no candidate was flown".into()))?;
    folder.write_json("summary.json", &summary)?;
    let SweepFound { verdict, found } = summary;
    folder.write("best.toml", &search.scenario(&found)?)?;
    let figures = folder.folder("figures")?;
    let drawn = wingbeat_figures::convergence_of_search(record)
        .and_then(|figure| wingbeat_figures::write(&figures, &figure));
    crate::fly::left_out(drawn)?;
    let mut text = format!(
        "{} candidates, the best is number {} at a cost of {:.4}\nstatus: {}\n\n",
        found.candidates, found.best, found.cost, verdict.status
    );
    for (key, value) in &found.values {
        text += &format!("{key:<48}{value:>12.5}\n");
    }
    for (number, flight) in found.flights.iter().enumerate() {
        let status = flight.status.unwrap_or("refused");
        text += &format!("\nflight {number}  {status}  {}\n", flight.overrides.join(", "));
        for (key, value, asked, met) in &flight.goals {
            let value = value.map_or("-".into(), |value| format!("{value:.4}"));
            let met = if *met { "met" } else { "missed" };
            text += &format!("  {key:<30}{value:>12}  {met:<8}asked is {asked}\n");
        }
    }
    if let Some(apart) = found.ends_apart_m {
        text += &format!("\nend points up to {apart:.3} m apart\n");
    }
    text += &overridden(&verdict.judged);
    Ok((verdict, text))
}
