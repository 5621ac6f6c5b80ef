//! The search of gaits of `wingbeat trim`.

use wingbeat::scenario::{GaitSearch, SearchSummary, Searched};
use wingbeat_io::{write_csv, write_parquet};

use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::sweep::log::SweepLog;
use crate::watch::{ConvergenceWatch, SearchIteration};

/// Searches from the starts that are left and writes their table.
pub fn searched(
    search: &GaitSearch,
    folder: &RunFolder,
    interrupt: &Interrupt,
    quiet: bool,
    watch: &ConvergenceWatch,
) -> Result<Searched, Error> {
    let all = search.starts();
    let mut log = SweepLog::open(&folder.file("starts.log"), |row| search.has_row(row))?;
    let bar = progress::bar(Some(all as u64), "start {pos} of {len}  {msg}", quiet);
    bar.set_position(log.len() as u64);
    let done: Vec<Vec<f64>> = log.rows().map(<[f64]>::to_vec).collect();
    let mut keep = |row: &[f64]| {
        bar.inc(1);
        log.append(row)
    };
    let searched = search.all(done, &mut keep, &mut |at| {
        let missed = if at.violation > 0.0 {
            format!(", limits missed by {:.4}", at.violation)
        } else {
            String::new()
        };
        let (power, frequency) = (at.power_w_kg, at.frequency_hz);
        watch.see(|| SearchIteration {
            series: format!("start {}", at.start),
            values: vec![
                ("power".into(), "W/kg", power),
                ("frequency".into(), "Hz", frequency),
                ("worst limit missed, in its scale".into(), "", at.violation),
            ],
        });
        bar.set_message(format!("iteration {}: {power:.2} W/kg, {frequency:.3} Hz{missed}", at.iteration));
        interrupt.flow()
    })?;
    let searched = searched.ok_or(Error::Paused { done: log.len(), all })?;
    bar.finish_and_clear();
    let record = &searched.starts;
    write_csv(&folder.file("starts.csv"), record)?;
    write_parquet(&folder.file("starts.parquet"), record)?;
    let figures = folder.folder("figures")?;
    let drawn = wingbeat_figures::starts(record);
    crate::fly::left_out(drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure)))?;
    log.remove()?;
    Ok(searched)
}

/// The search in words.
pub fn table(search: &SearchSummary) -> String {
    let SearchSummary { starts, kept, minima, best, ended, iterations, .. } = search;
    let mut text = format!(
        "{:<28}{kept} of {starts} starts keep to the limits, {minima} different minima; start {best}: {ended} after \
         {iterations} steps tried\n",
        "search"
    );
    for (key, value) in &search.values {
        text += &format!("{:<28}{key} = {}\n", "", super::five_places(*value));
    }
    text
}
