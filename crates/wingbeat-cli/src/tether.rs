//! `wingbeat tether`.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::time::Instant;

use wingbeat::scenario::{RunName, TetherCase, TetherSummary};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::{CycleMean, TetherRun};
use wingbeat_figures::{cycle_loads, span_loading};
use wingbeat_io::{read_csv, shortest, write_csv, write_parquet};

use crate::args::Tether;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;

/// Ticks of the progress bar.
const TICKS: f64 = 1000.0;

/// Columns of the printed table of means.
const PRINTED: [&str; 10] = [
    "force_wind_lift",
    "force_wind_drag",
    "force_wind_side",
    "moment_x",
    "moment_y",
    "moment_z",
    "CL",
    "CD",
    "CY",
    "CM",
];

/// Runs the case and writes its run folder.
pub fn tether(arguments: &Tether) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let tables = Tables::default();
    let case = TetherCase::load(&arguments.case, &options.overrides, &|path| tables.read(path))?;
    let folder = RunFolder::create(options.out.as_deref(), &case.spec.run_name()?, options.force)?;
    let run = simulate(&case.tether, &interrupt, options.quiet)?;
    let step_change = case.step_change(&run, |other| simulate(other, &interrupt, true))?;
    let summary = case.summary(&run, step_change);
    folder.write("case.toml", &case.kept(|path| tables.name(path))?)?;
    tables.keep(&folder)?;
    folder.write("means.csv", &means(&run.means))?;
    folder.write_json("summary.json", &summary)?;
    write_csv(&folder.file("loads.csv"), &run.loads)?;
    write_parquet(&folder.file("strips.parquet"), &run.strips)?;
    draw(&folder, &run)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed =
        say::unless(options.quiet, || format!("{}\nrun folder: {}\n", table(&summary), shown.display()));
    match run.ending {
        Ending::Fault(fault) => {
            let status = if fault.is_not_finite() { "not_finite" } else { "fault" };
            Err(Error::Failed { status: status.into(), reason: fault.to_string(), folder: shown.into() })
        }
        _ if summary.status == "not_resolved" => {
            let reason = summary.warnings.last().cloned().unwrap_or_default();
            Err(Error::Failed { status: summary.status, reason, folder: shown.into() })
        }
        _ => printed,
    }
}

/// The tables of a case, each read once and kept beside it, so that it runs again from its folder.
#[derive(Default)]
pub struct Tables(RefCell<Vec<(PathBuf, Record)>>);

impl Tables {
    /// The table of a file.
    pub fn read(&self, path: &Path) -> Result<Record, String> {
        let mut tables = self.0.borrow_mut();
        if let Some((_, record)) = tables.iter().find(|(known, _)| known == path) {
            return Ok(record.clone());
        }
        let record = read_csv(path).map_err(|error| error.to_string())?;
        tables.push((path.into(), record.clone()));
        Ok(record)
    }

    /// The name under which the table of a file is kept.
    pub fn name(&self, path: &Path) -> String {
        let tables = self.0.borrow();
        let own = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let alone = tables.iter().filter(|(known, _)| own(known) == own(path)).count() == 1;
        let free = alone && !["loads.csv", "means.csv", "case.toml"].contains(&own(path).as_str());
        let name = path.file_name().and_then(|name| name.to_str());
        match name.filter(|name| free && RunName::new("file", name).is_ok()) {
            Some(name) => name.into(),
            None => {
                format!("table-{}.csv", 1 + tables.iter().position(|(known, _)| known == path).unwrap_or(0))
            }
        }
    }

    /// Writes the tables into the run folder.
    pub fn keep(&self, folder: &RunFolder) -> Result<(), Error> {
        for (path, record) in self.0.borrow().iter() {
            write_csv(&folder.file(&self.name(path)), record)?;
        }
        Ok(())
    }
}

fn simulate(
    tether: &wingbeat::tether::Tether,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<TetherRun, Error> {
    let template = "moving {bar:30} {percent:>3} %  ({eta} left)";
    let progress = progress::bar(Some(TICKS as u64), template, quiet);
    let run = tether.run(|share| {
        progress.set_position((TICKS * share) as u64);
        interrupt.flow()
    });
    progress.finish_and_clear();
    interrupt.check()?;
    Ok(run)
}

/// Draws what can be drawn; what cannot is said and left out.
fn draw(folder: &RunFolder, run: &TetherRun) -> Result<(), Error> {
    let figures = folder.folder("figures")?;
    for drawn in [cycle_loads(&run.loads), span_loading(&run.strips)] {
        let outcome = drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure));
        if let Err(error) = outcome {
            say::note(&format!("a figure is left out: {error}"));
        }
    }
    Ok(())
}

/// Means of every quantity as CSV.
fn means(means: &[CycleMean]) -> String {
    let row = |m: &CycleMean| {
        let [mean, low, high] = [m.mean, m.low, m.high].map(shortest);
        format!("{},{},{mean},{low},{high}\n", m.name, m.unit)
    };
    let rows = means.iter().map(row);
    std::iter::once("quantity,unit,mean,least,most\n".into()).chain(rows).collect()
}

/// The table of means over the last cycle, with the cautions below.
fn table(summary: &TetherSummary) -> String {
    let TetherSummary { name, preset, lift_law, .. } = summary;
    let mut text = format!("{name}: preset {preset}, law {lift_law}; last cycle, from rest\n\n");
    text += &format!("{:<18}{:>11}{:>11}{:>11}\n", "", "mean", "least", "most");
    for row in summary.cycle.iter().filter(|row| PRINTED.contains(&row.name.as_str())) {
        let CycleMean { name, unit, mean, low, high } = row;
        text += format!("{name:<18}{mean:>11.5}{low:>11.5}{high:>11.5}  {unit}").trim_end();
        text.push('\n');
    }
    for warning in &summary.warnings {
        text += &format!("\nnote: {warning}\n");
    }
    text
}
