//! `wingbeat tether`.

use std::cell::RefCell;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use wingbeat::scenario::{TetherCase, TetherSummary};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::{CycleMean, TetherRun};
use wingbeat_figures::{cycle_loads, span_loading};
use wingbeat_io::{read_csv, write_csv, write_parquet};

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
    let tables = RefCell::new(Vec::new());
    let read = |path: &Path| {
        tables.borrow_mut().push(path.to_path_buf());
        read_csv(path).map_err(|error| error.to_string())
    };
    let case = TetherCase::load(&arguments.case, &options.overrides, &read)?;
    let folder = RunFolder::create(options.out.as_deref(), &case.spec.run_name()?, options.force)?;
    let run = simulate(&case, &interrupt, options.quiet)?;
    let summary = case.summary(&run);
    folder.write("case.toml", &case.resolved)?;
    keep_tables(&folder, &tables.into_inner())?;
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
            Err(Error::Failed { status: "fault".into(), reason: fault.to_string(), folder: shown.into() })
        }
        _ => printed,
    }
}

/// Copies the tables beside the case, so that it runs again from its folder.
fn keep_tables(folder: &RunFolder, tables: &[PathBuf]) -> Result<(), Error> {
    for table in tables {
        let name = table.file_name().unwrap_or_default().to_string_lossy();
        fs::copy(table, folder.file(&name)).map_err(|source| Error::file(table, source))?;
    }
    Ok(())
}

fn simulate(case: &TetherCase, interrupt: &Interrupt, quiet: bool) -> Result<TetherRun, Error> {
    let template = "moving {bar:30} {percent:>3} %  ({eta} left)";
    let progress = progress::bar(Some(TICKS as u64), template, quiet);
    let run = case.tether.run(|share| {
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
    let drawn: [(wingbeat_figures::Draw, &Record); 2] =
        [(cycle_loads, &run.loads), (span_loading, &run.strips)];
    for (draw, record) in drawn {
        let outcome = draw(record).and_then(|figure| wingbeat_figures::write(&figures, &figure));
        if let Err(error) = outcome {
            say::note(&format!("a figure is left out: {error}"));
        }
    }
    Ok(())
}

/// Means of every quantity as CSV.
fn means(means: &[CycleMean]) -> String {
    let rows = means.iter().map(|m| format!("{},{},{},{},{}\n", m.name, m.unit, m.mean, m.low, m.high));
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
