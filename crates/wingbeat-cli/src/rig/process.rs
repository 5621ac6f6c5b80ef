//! `wingbeat rig process`.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use wingbeat::flight::{Column, Record};
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::{Comparison, compare, envelope};
use wingbeat::scenario::{Processed, RigRun};
use wingbeat_io::{read_parquet, write_parquet};

use super::runs;
use super::simulate::Summary;
use crate::args::RigProcess;
use crate::error::Error;

/// The run whose noise-free wrench stands for the simulation when several are processed.
const REFERENCE: &str = "roll15_speed08";

/// Cycles drawn side by side.
const CYCLES: usize = 3;

/// The numbers beside the figure.
#[derive(Serialize)]
struct Numbers {
    /// Steps made, as configured.
    steps: wingbeat::rig::process::Steps,
    /// Run whose simulation is the black line.
    simulation: String,
    /// Middle of the envelope against the simulation, by channel.
    envelope_against_simulation: BTreeMap<&'static str, Comparison>,
    /// Each run's phase average against its own noise-free wrench, by channel.
    runs_against_truth: BTreeMap<String, BTreeMap<&'static str, Comparison>>,
    /// Saturated samples of each run.
    saturated: BTreeMap<String, usize>,
}

/// Processes a run folder or a folder of run folders.
pub fn process(arguments: &RigProcess) -> Result<(), Error> {
    let folders = run_folders(&arguments.folder)?;
    let done = runs::shared(&folders, |_, folder| one(folder));
    let mut processed: Vec<(RigRun, Processed)> = Vec::new();
    for answer in done {
        processed.push(answer?);
    }
    let out = arguments.out.clone().unwrap_or_else(|| arguments.folder.join("processed"));
    let figures = out.join("figures");
    fs::create_dir_all(&figures).map_err(|source| Error::file(&figures, source))?;
    for (run, result) in &processed {
        let file = out.join(format!("{}.parquet", run.spec.name));
        write_parquet(&file, &result.record()?)?;
    }
    let (record, numbers) = together(&processed)?;
    write_parquet(&out.join("envelope.parquet"), &record)?;
    let text = serde_json::to_string_pretty(&numbers).map_err(|e| Error::Input(e.to_string()))?;
    let file = out.join("summary.json");
    fs::write(&file, text + "\n").map_err(|source| Error::file(&file, source))?;
    match wingbeat_figures::force_moment(&record) {
        Ok(figure) => wingbeat_figures::write(&figures, &figure).map_err(|e| Error::Input(e.to_string()))?,
        Err(error) => eprintln!("a figure is left out: {error}"),
    }
    if !arguments.quiet {
        print!("{}", table(&numbers));
        println!("results: {}", out.display());
    }
    Ok(())
}

/// Folders with a record: `folder` itself or those in it.
fn run_folders(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let holds = |path: &Path| path.join("record.parquet").is_file();
    if holds(folder) {
        return Ok(vec![folder.into()]);
    }
    let entries = fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
    let mut found: Vec<PathBuf> =
        entries.filter_map(|e| e.ok()).map(|e| e.path()).filter(|p| holds(p)).collect();
    found.sort();
    if found.is_empty() {
        let folder = folder.display();
        return Err(Error::Input(format!("{folder}: no record.parquet in it or in a folder in it")));
    }
    Ok(found)
}

fn one(folder: &Path) -> Result<(RigRun, Processed), Error> {
    let run = RigRun::load(&folder.join("scenario.toml"), &[])?;
    let file = folder.join("summary.json");
    let text = fs::read_to_string(&file).map_err(|source| Error::file(&file, source))?;
    let summary: Summary =
        serde_json::from_str(&text).map_err(|error| Error::Input(format!("{}: {error}", file.display())))?;
    let record = read_parquet(&folder.join("record.parquet"))?;
    match run.process(&record, summary.window_s)? {
        Ok(processed) => Ok((run, processed)),
        Err(fault) => Err(Error::Input(format!("{}: {fault}", folder.display()))),
    }
}

/// The envelope over all runs beside the simulation, over three cycles, and the numbers.
fn together(processed: &[(RigRun, Processed)]) -> Result<(Record, Numbers), Error> {
    let reference = processed.iter().position(|(run, _)| run.spec.name == REFERENCE).unwrap_or(0);
    let (run, black) = &processed[reference];
    let bins = black.cycles[0].mean.len();
    let frequency = run.frequency();
    let mut columns = vec![Column::new("t", "s", "")];
    columns[0].values = (0..=CYCLES * bins).map(|k| k as f64 / bins as f64 / frequency).collect();
    let mut against = BTreeMap::new();
    for (i, (name, unit)) in CHANNELS.iter().enumerate() {
        let (low, high) = envelope(processed.iter().map(|(_, p)| &p.cycles[i]));
        let simulation = black.truth.as_ref().map_or(&black.cycles[i].mean, |truth| &truth[i].mean);
        let middle: Vec<f64> = low.iter().zip(&high).map(|(a, b)| 0.5 * (a + b)).collect();
        against.insert(*name, compare(&middle, simulation));
        for (prefix, values) in [("low_", &low), ("high_", &high), ("simulation_", simulation)] {
            let column = Column::new(format!("{prefix}{name}"), *unit, "B");
            let values = (0..=CYCLES * bins).map(|k| values[k % bins]).collect();
            columns.push(Column { values, ..column });
        }
    }
    let named = |c: [Comparison; 6]| CHANNELS.iter().map(|(name, _)| *name).zip(c).collect();
    let numbers = Numbers {
        steps: run.spec.process.steps,
        simulation: run.spec.name.clone(),
        envelope_against_simulation: against,
        runs_against_truth: processed
            .iter()
            .filter_map(|(run, p)| Some((run.spec.name.clone(), named(p.against_truth()?))))
            .collect(),
        saturated: processed.iter().map(|(run, p)| (run.spec.name.clone(), p.saturated)).collect(),
    };
    Ok((Record::new(columns, 0)?, numbers))
}

fn table(numbers: &Numbers) -> String {
    let mut text = format!(
        "middle of the envelope against the simulation of {}\n{:8}{:>12}{:>12}{:>13}{:>12}\n",
        numbers.simulation, "channel", "rmse", "range", "correlation", "peak ratio"
    );
    for (name, c) in &numbers.envelope_against_simulation {
        text +=
            &format!("{name:8}{:12.5}{:12.5}{:13.4}{:12.3}\n", c.rmse, c.range, c.correlation, c.peak_ratio);
    }
    text += "largest RMSE of a run against its noise-free wrench, % of the channel's range\n";
    for (name, _) in CHANNELS {
        let share =
            |runs: &BTreeMap<&str, Comparison>| runs.get(name).map_or(0.0, |c| 100.0 * c.rmse / c.range);
        let worst = numbers.runs_against_truth.values().map(share).fold(0.0, f64::max);
        text += &format!("{name:8}{worst:12.2}\n");
    }
    for (name, count) in numbers.saturated.iter().filter(|(_, count)| **count > 0) {
        text += &format!("{name}: {count} samples saturated: the averages are not to be trusted there\n");
    }
    text
}
