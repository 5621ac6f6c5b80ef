//! `wingbeat rig simulate`.

use std::path::Path;
use std::time::Instant;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::{Deserialize, Serialize};
use wingbeat::parallel;
use wingbeat::scenario::{LatticeSummary, RigRun};
use wingbeat::simulate::Record;
use wingbeat_io::write_parquet;

use super::runs;
use crate::args::RigRuns;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::{RunFolder, named_after};
use crate::say;

/// What is said of a simulated run.
#[derive(Debug, Serialize, Deserialize)]
pub struct Summary {
    /// `ok`, `refused` or `fault`.
    pub status: String,
    /// Why, when not `ok`.
    pub reason: Option<String>,
    /// Flapping frequency, Hz.
    pub frequency_hz: f64,
    /// Begin and end of what is averaged, s.
    pub window_s: (f64, f64),
    /// Samples.
    pub samples: usize,
    /// Samples with a saturated channel.
    pub saturated: usize,
    /// Share of strips and samples after the rest that are past their stall angle.
    pub stall_fraction: f64,
    /// How motion and vortex lattice were brought together, where one takes the place of the preset's attached flow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lattice: Option<LatticeSummary>,
    /// Cautions that a reader must know.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Wall time, s.
    pub wall_s: f64,
}

/// Plans and simulates every run into its own folder.
pub fn simulate(arguments: &RigRuns) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let options = &arguments.run;
    let runs = runs::load(&arguments.file, &options.all_overrides())?;
    let name = named_after(&arguments.file, options.out.as_deref())?;
    let folder = RunFolder::create(options.out.as_deref(), &name, options.force)?;
    let target = if options.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bars = MultiProgress::with_draw_target(target);
    let folders = runs.iter().map(|run| folder.folder(&run.spec.name)).collect::<Result<Vec<_>, _>>()?;
    let summaries = parallel::map(&runs, |index, run| {
        let bar = bars.add(bar(&run.spec.name));
        let summary = one(run, &folders[index], run.spec.seed.unwrap_or(0), &bar);
        bar.finish_and_clear();
        summary
    });
    let (mut failed, mut refused, mut told) = (Vec::new(), 0, String::new());
    for (run, summary) in runs.iter().zip(summaries) {
        let summary = summary?;
        let name = &run.spec.name;
        folder.write_json(&format!("{name}/summary.json"), &summary)?;
        let saturated = summary.saturated;
        told += &format!(
            "{name:20} {:8} {:6} samples of the simulated load cell, {saturated} saturated, {:.1} s\n",
            summary.status, summary.samples, summary.wall_s
        );
        if let Some(lattice) = &summary.lattice {
            told += &format!(
                "{:20} in the lattice, attached flow assumed: {:.1} % of the strips past stall, {:.2} states tried a step\n",
                "",
                100.0 * summary.stall_fraction,
                lattice.iterations_mean
            );
        }
        told.extend(summary.warnings.iter().map(|warning| format!("note: {name}: {warning}\n")));
        refused += usize::from(summary.status == "refused");
        if let Some(reason) = summary.reason {
            failed.push(format!("{name}: {reason}"));
        }
    }
    // Where no run can be planned there is nothing to keep.
    if refused == runs.len() {
        return Err(Error::Input(failed.join("\n")));
    }
    interrupt.check()?;
    let path = folder
        .finish(&Manifest::new(runs.first().and_then(|run| run.spec.seed).unwrap_or(0), start.elapsed()))?;
    let printed = say::unless(options.quiet, || format!("{told}runs: {}\n", path.display()));
    match failed.is_empty() {
        true => printed,
        false => Err(Error::Failed { status: "failed".into(), reason: failed.join("\n"), folder: path }),
    }
}

fn bar(name: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:20} {bar:30} {percent:>3} %  {msg}");
    let bar = ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.with_prefix(name.to_owned())
}

fn one(run: &RigRun, folder: &Path, seed: u64, bar: &ProgressBar) -> Result<Summary, Error> {
    let start = Instant::now();
    let file = folder.join("scenario.toml");
    std::fs::write(&file, &run.resolved).map_err(|source| Error::file(&file, source))?;
    bar.set_message("planning");
    let simulated = run.simulated(seed, |share| {
        bar.set_message("simulating");
        bar.set_position((1000.0 * share) as u64);
    });
    let simulated = simulated.map_err(|error| run.explain(&error))?;
    if let Some(record) = &simulated.record {
        write_parquet(&folder.join("record.parquet"), record)?;
    }
    Ok(Summary {
        status: simulated.status.into(),
        reason: simulated.reason,
        frequency_hz: run.frequency(),
        window_s: simulated.window_s,
        samples: simulated.record.as_ref().map_or(0, Record::rows),
        saturated: simulated.saturated,
        stall_fraction: simulated.stall_fraction,
        lattice: simulated.lattice,
        warnings: simulated.warnings,
        wall_s: start.elapsed().as_secs_f64(),
    })
}
