//! `wingbeat sweep`.

mod log;

use std::ops::ControlFlow;
use std::time::Instant;

use indicatif::ProgressBar;
use serde::Serialize;
use wingbeat::parallel;
use wingbeat::scenario::{Hold, Summary, Sweep};
use wingbeat::simulate::Record;
use wingbeat_io::{write_csv, write_parquet};

use crate::args;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use log::Log;

/// Columns of a flight beside its number and its draws, with their units.
const MEASURES: [(&str, &str); 10] = [
    ("held", ""),
    ("completed", ""),
    ("roll_max_error", "deg"),
    ("pitch_max_error", "deg"),
    ("roll_mean", "deg"),
    ("pitch_mean", "deg"),
    ("distance_x", "m"),
    ("distance_y", "m"),
    ("altitude_change", "m"),
    ("controller_failures", ""),
];

/// Flies what is left of the sweep and writes its run folder.
pub fn sweep(arguments: &args::Sweep) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let sweep = Sweep::load(&arguments.sweep, &options.all_overrides())?;
    let name = &sweep.spec.run_name()?;
    let folder =
        RunFolder::resume(options.out.as_deref(), name, options.force, ("sweep.toml", &sweep.resolved))?;
    let mut log = Log::open(&folder.file("flights.log"), |row| is_of(&sweep, row))?;
    fly_all(&sweep, &mut log, &interrupt, options.quiet)?;
    let record = log.record(&columns(&sweep))?;
    log.remove()?;
    let outcome = Outcome::new(&record, sweep.spec.hold);
    write_csv(&folder.file("flights.csv"), &record)?;
    write_parquet(&folder.file("record.parquet"), &record)?;
    folder.write_json("summary.json", &outcome)?;
    draw(&folder, &record, sweep.spec.hold)?;
    let path = folder.finish(&Manifest::new(sweep.spec.seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    say::unless(options.quiet, || format!("{}\nrun folder: {}\n", outcome.table(), shown.display()))
}

/// Whether `row` is that of a flight of the sweep: its number and its draws.
fn is_of(sweep: &Sweep, row: &[f64]) -> bool {
    let draws = sweep.spec.draws.len();
    let run = row.first().copied().unwrap_or(f64::NAN);
    row.len() == 1 + draws + MEASURES.len()
        && run.fract() == 0.0
        && (0.0..sweep.spec.runs as f64).contains(&run)
        && sweep.values(run as usize) == row[1..=draws]
}

/// Flies the flights that are not in the log, on all cores.
fn fly_all(sweep: &Sweep, log: &mut Log, interrupt: &Interrupt, quiet: bool) -> Result<(), Error> {
    let todo: Vec<usize> = (0..sweep.spec.runs).filter(|run| !log.has(*run)).collect();
    let progress = progress(sweep.spec.runs, log.len(), quiet);
    let mut outcome = Ok(());
    parallel::each(
        &todo,
        |_, run| one(sweep, *run, interrupt),
        |_, row| match row.and_then(|row| row.map(|row| log.append(&row)).transpose()) {
            Ok(Some(())) => {
                progress.inc(1);
                ControlFlow::Continue(())
            }
            stopped => {
                outcome = stopped.map(drop);
                ControlFlow::Break(())
            }
        },
    );
    outcome?;
    progress.finish_and_clear();
    let (done, all) = (log.len(), sweep.spec.runs);
    if done < all { Err(Error::Paused { done, all }) } else { Ok(()) }
}

/// The row of a flight; none when it was interrupted.
fn one(sweep: &Sweep, run: usize, interrupt: &Interrupt) -> Result<Option<Vec<f64>>, Error> {
    let scenario = sweep.scenario(run)?;
    let flown = scenario.fly(|_| interrupt.flow()).map_err(|error| scenario.explain(&error))?;
    if interrupt.flow() == ControlFlow::Break(()) {
        return Ok(None);
    }
    let mut row = vec![run as f64];
    row.extend(sweep.values(run));
    row.extend(measures(&flown.summary, sweep.spec.hold));
    Ok(Some(row))
}

fn measures(summary: &Summary, hold: Hold) -> [f64; MEASURES.len()] {
    let of = |value: Option<f64>| value.unwrap_or(f64::NAN);
    [
        f64::from(u8::from(hold.met(summary))),
        f64::from(u8::from(summary.completed())),
        of(summary.roll_max_error_deg),
        of(summary.pitch_max_error_deg),
        of(summary.roll_mean_deg),
        of(summary.pitch_mean_deg),
        summary.distance_x_m,
        summary.distance_y_m,
        summary.altitude_change_m,
        summary.controller.failures as f64,
    ]
}

/// Names and units of the columns.
pub fn columns(sweep: &Sweep) -> Vec<(String, &'static str)> {
    let draws = sweep.spec.draws.iter().map(|draw| (draw.key.clone(), ""));
    let measures = MEASURES.iter().map(|(name, unit)| ((*name).to_owned(), *unit));
    std::iter::once(("run".to_owned(), "")).chain(draws).chain(measures).collect()
}

fn progress(flights: usize, done: usize, quiet: bool) -> ProgressBar {
    let template = "flying {bar:30} {pos} of {len} flights  ({eta} left)";
    progress::bar(Some(flights as u64), template, quiet).with_position(done as u64)
}

fn draw(folder: &RunFolder, record: &Record, hold: Hold) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    let limits = (hold.roll_within_deg, hold.pitch_within_deg);
    let drawn = wingbeat_figures::robustness(record, limits);
    if let Err(error) = drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure)) {
        say::note(&format!("the figure is left out: {error}"));
    }
    Ok(())
}

/// `summary.json` of a sweep.
#[derive(Debug, Serialize)]
struct Outcome {
    status: &'static str,
    flights: usize,
    held: usize,
    share_held: f64,
    /// Share held with 95 % confidence: Wilson 1927.
    share_held_low: f64,
    share_held_high: f64,
    roll_max_error_deg: [f64; 3],
    pitch_max_error_deg: [f64; 3],
    roll_within_deg: f64,
    pitch_within_deg: f64,
}

impl Outcome {
    fn new(record: &Record, hold: Hold) -> Self {
        let values = |name: &str| record.values(name).unwrap_or_default();
        let held = values("held").iter().filter(|held| **held == 1.0).count();
        let flights = record.rows();
        let (low, high) = wilson(held, flights);
        Self {
            status: "ok",
            flights,
            held,
            share_held: held as f64 / flights as f64,
            share_held_low: low,
            share_held_high: high,
            roll_max_error_deg: quantiles(values("roll_max_error")),
            pitch_max_error_deg: quantiles(values("pitch_max_error")),
            roll_within_deg: hold.roll_within_deg,
            pitch_within_deg: hold.pitch_within_deg,
        }
    }

    fn table(&self) -> String {
        let percent = |share: f64| 100.0 * share;
        let mut text = format!(
            "held {} of {} flights: {:.1} % (95 % confidence {:.1} to {:.1} %)\n\n{:<24}{:>9}{:>9}{:>9}{:>9}\n",
            self.held,
            self.flights,
            percent(self.share_held),
            percent(self.share_held_low),
            percent(self.share_held_high),
            "",
            "median",
            "90 %",
            "worst",
            "limit",
        );
        for (name, [median, most, worst], limit) in [
            ("roll, largest error", self.roll_max_error_deg, self.roll_within_deg),
            ("pitch, largest error", self.pitch_max_error_deg, self.pitch_within_deg),
        ] {
            text += &format!("{name:<24}{median:>9.2}{most:>9.2}{worst:>9.2}{limit:>9.2} deg\n");
        }
        text
    }
}

/// Median, 90th percentile and largest.
fn quantiles(values: &[f64]) -> [f64; 3] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get(((sorted.len() as f64 * share).ceil() as usize).max(1) - 1);
    [0.5, 0.9, 1.0].map(|share| at(share).copied().unwrap_or(f64::NAN))
}

/// Interval of a share with 95 % confidence.
fn wilson(held: usize, flights: usize) -> (f64, f64) {
    const Z: f64 = 1.959964;
    let (n, p) = (flights as f64, held as f64 / flights as f64);
    let centre = p + Z * Z / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    ((centre - half) / scale, (centre + half) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_share_is_wilsons() {
        let (low, high) = wilson(8, 10);
        assert!((low - 0.4902).abs() < 1e-4 && (high - 0.9433).abs() < 1e-4, "{low} {high}");
        assert!((wilson(10, 10).1 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!(quantiles(&values), [5.0, 9.0, 10.0]);
    }
}
