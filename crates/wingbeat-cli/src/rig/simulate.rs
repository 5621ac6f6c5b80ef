//! `wingbeat rig simulate`.

use std::path::Path;
use std::time::Instant;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use serde::Serialize;
use wingbeat::judge::Verdict;
use wingbeat::parallel;
use wingbeat::scenario::{RigRun, SimulatedSummary};
use wingbeat_io::write_parquet;

use super::runs;
use crate::args::RigSimulate;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::outcome::overridden;
use crate::progress;
use crate::run_folder::{RunFolder, named_after};
use crate::say;

/// `summary.json`.
#[derive(Debug, Serialize)]
struct SimulationSummary {
    #[serde(flatten)]
    told: SimulatedSummary,
    /// Wall time, s.
    wall_s: f64,
}

/// Plans and simulates every run into its own folder.
pub fn simulate(arguments: &RigSimulate) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let (page, arguments) = (&arguments.page, &arguments.runs);
    let options = &arguments.run;
    let runs = runs::load(&arguments.file, &options.all_overrides())?;
    let name = named_after(&arguments.file, options.out.as_deref())?;
    let folder = RunFolder::create(options.out.as_deref(), &name, options.force)?;
    let bars = MultiProgress::with_draw_target(progress::target(options.quiet));
    let folders = runs.iter().map(|run| folder.folder(&run.spec.name)).collect::<Result<Vec<_>, _>>()?;
    let summaries = parallel::map(&runs, |index, run| {
        let bar = bars.add(bar(&run.spec.name));
        let summary = one(run, &folders[index], run.spec.seed.unwrap_or(0), &bar);
        bar.finish_and_clear();
        summary
    });
    let summaries = runs.iter().zip(summaries).map(|(run, summary)| Ok((run.spec.name.as_str(), summary?)));
    let summaries = summaries.collect::<Result<Vec<_>, Error>>()?;
    for (name, summary) in &summaries {
        folder.write_json(&format!("{name}/summary.json"), summary)?;
    }
    let verdict = Verdict::together(summaries.iter().map(|(name, summary)| (*name, &summary.told.verdict)));
    let reason = verdict.reason.as_deref().unwrap_or_default();
    // Where no run can be planned there is nothing to keep.
    if summaries.iter().all(|(_, summary)| summary.told.ending == "refused") {
        return Err(Error::Input(reason.replace("; ", "\n")));
    }
    crate::report::beside(&folder, name.as_str(), None, !page.no_report)?;
    interrupt.check()?;
    let path = folder
        .finish(&Manifest::new(runs.first().and_then(|run| run.spec.seed).unwrap_or(0), start.elapsed()))?;
    let told: String = summaries.iter().map(|(name, summary)| text(name, summary)).collect();
    let printed = say::unless(options.quiet, || format!("{told}runs: {}\n", path.display()));
    Error::unless_usable(verdict.status, Some(reason), &path)?;
    printed
}

/// What is printed of a run.
fn text(name: &str, SimulationSummary { told, wall_s }: &SimulationSummary) -> String {
    let SimulatedSummary { verdict, samples, saturated, .. } = told;
    let mut text = format!(
        "{name:20} {:8} {samples:6} samples of the simulated load cell, {saturated} saturated, {wall_s:.1} s\n",
        verdict.status
    );
    if let (Some(lattice), Some(stalled)) = (&told.lattice, told.stall_fraction) {
        text += &format!(
            "{:20} in the lattice, attached flow assumed: {:.1} % of the strips past stall, {:.2} states tried a step\n",
            "",
            100.0 * stalled,
            lattice.iterations_mean
        );
    }
    text += overridden(&verdict.judged).trim_start_matches('\n');
    text.extend(verdict.warnings.iter().map(|warning| format!("{name}: {warning}\n")));
    text
}

fn bar(name: &str) -> ProgressBar {
    let style = ProgressStyle::with_template("{prefix:20} {bar:30} {percent:>3} %  {msg}");
    let bar = ProgressBar::new(1000).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.with_prefix(name.to_owned())
}

fn one(run: &RigRun, folder: &Path, seed: u64, bar: &ProgressBar) -> Result<SimulationSummary, Error> {
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
        let place = folder.join("figures");
        for draw in wingbeat_figures::of_deformation(record) {
            std::fs::create_dir_all(&place).map_err(|source| Error::file(&place, source))?;
            let figure = draw(record, wingbeat_figures::FigureTargets::default());
            crate::fly::left_out(figure.and_then(|figure| wingbeat_figures::write(&place, &figure)))?;
        }
    }
    Ok(SimulationSummary { told: simulated.summary(run), wall_s: start.elapsed().as_secs_f64() })
}
