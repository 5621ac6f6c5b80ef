//! `wingbeat tether`.

mod compare;
mod converge;
mod tables;

use std::time::Instant;

use serde::Serialize;
use wingbeat::aero::Aero;
use wingbeat::judge::Verdict;
use wingbeat::scenario::{
    Compared, Convergence, MeasuredComparison, Smoothed, SparSummary, TetherCase, TetherSummary, unit,
};
use wingbeat::simulate::Ending;
use wingbeat::tether::{CycleMean, Periodicity, TetherRun};
use wingbeat_figures::{bent_wing, comparison, convergence, cycle_loads, span_loading};
use wingbeat_io::{shortest, write_csv, write_parquet};

use crate::args::TetherArguments;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use compare::MeasuredFile;
pub use tables::CaseTables;

/// Ticks of the progress bar.
const TICKS: f64 = 1000.0;

/// Columns of the printed table of means, beside those of the hinges.
const PRINTED: [&str; 16] = [
    "tip_up",
    "tip_ahead",
    "tip_nose_up",
    "force_wind_lift",
    "force_wind_drag",
    "force_wind_side",
    "moment_x",
    "moment_y",
    "moment_z",
    "thrust",
    "power",
    "power_body",
    "CL",
    "CD",
    "CY",
    "CM",
];

/// Runs the case and writes its run folder.
pub fn tether(arguments: &TetherArguments) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let tables = CaseTables::default();
    let case = TetherCase::load(&arguments.case, &options.overrides, &|path| tables.read(path))?;
    let measured = arguments.compare.as_deref().map(|path| MeasuredFile::open(path, &case)).transpose()?;
    let folder = RunFolder::create(options.out.as_deref(), &case.spec.run_name()?, options.force)?;
    let run = simulate(&case.tether, &interrupt, options.quiet)?;
    let step_change = case.step_change(&run, |other| simulate(other, &interrupt, true))?;
    let comparison = match &measured {
        Some(measured) if run.ending == Ending::Complete => Some(measured.compare(&case, &run)?),
        _ => None,
    };
    let found = TetherOutcome {
        summary: case.summary(&run, step_change, comparison.as_ref()),
        convergence: match arguments.converge {
            true => Some(converge::converge(&case, &tables, &interrupt, options.quiet)?),
            false => None,
        },
        comparison,
        run,
    };
    folder.write("case.toml", &case.kept(|path| tables.name(path))?)?;
    tables.keep(&folder)?;
    found.write(&folder, &case.tether)?;
    crate::report::beside(&folder, &case.spec.name, None, !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed =
        say::unless(options.quiet, || format!("{}\nrun folder: {}\n", found.text(), shown.display()));
    let Verdict { status, reason, .. } = &found.summary.verdict;
    Error::unless_usable(*status, reason.as_deref(), shown)?;
    printed
}

/// What a run gave, and what it was held against.
struct TetherOutcome {
    run: TetherRun,
    summary: TetherSummary,
    convergence: Option<Convergence>,
    comparison: Option<MeasuredComparison>,
}

/// `summary.json`.
#[derive(Serialize)]
struct CaseSummary<'a> {
    #[serde(flatten)]
    own: &'a TetherSummary,
    #[serde(skip_serializing_if = "Option::is_none")]
    converge: Option<&'a Convergence>,
    #[serde(skip_serializing_if = "Option::is_none")]
    compare: Option<&'a [Compared]>,
}

impl TetherOutcome {
    fn write(&self, folder: &RunFolder, tether: &wingbeat::tether::Tether) -> Result<(), Error> {
        folder.write("means.csv", &means(&self.summary.cycle))?;
        let compare = self.comparison.as_ref().map(|comparison| comparison.channels.as_slice());
        let summary = CaseSummary { own: &self.summary, converge: self.convergence.as_ref(), compare };
        folder.write_json("summary.json", &summary)?;
        write_csv(&folder.file("loads.csv"), &self.run.loads)?;
        write_parquet(&folder.file("strips.parquet"), &self.run.strips)?;
        if let Some(table) = &self.convergence {
            folder.write("converge.csv", &converge::csv(table))?;
        }
        if let Some(comparison) = &self.comparison {
            write_csv(&folder.file("compare.csv"), &comparison.cycle)?;
        }
        self.draw(folder, tether)
    }

    /// Draws what can be drawn; what cannot is said and left out.
    fn draw(&self, folder: &RunFolder, tether: &wingbeat::tether::Tether) -> Result<(), Error> {
        let figures = folder.folder("figures")?;
        let mut drawn = Vec::new();
        // Of a run that broke down there is no last cycle.
        if self.run.ending == Ending::Complete {
            let edges = matches!(&tether.aero, Aero::Strip(strips) if strips.span_keys()[0]);
            drawn.extend([cycle_loads(&self.run.loads), span_loading(&self.run.strips, edges)]);
        }
        if let (Some(spar), Some(steady)) = (&tether.spar, self.run.steady.as_ref().filter(|s| s.found)) {
            drawn.push(Ok(bent_wing(spar, steady)));
        }
        drawn.extend(self.convergence.as_ref().map(|table| Ok(convergence(table))));
        drawn.extend(self.comparison.as_ref().map(comparison));
        for drawn in drawn {
            let outcome = drawn.and_then(|figure| wingbeat_figures::write(&figures, &figure));
            crate::fly::left_out(outcome)?;
        }
        Ok(())
    }

    fn text(&self) -> String {
        let mut text = table(&self.summary);
        text.extend(self.convergence.as_ref().map(converge::text));
        text.extend(self.comparison.as_ref().map(compare::text));
        text
    }
}

/// The shape at rest of a wing with spars.
fn spar(spar: &SparSummary) -> String {
    let SparSummary { tip_up_m, tip_ahead_m, tip_nose_up_deg, .. } = spar;
    let frequencies: Vec<String> = spar.frequencies_hz.iter().map(|hz| format!("{hz:.2}")).collect();
    let mut text = format!("frequencies of the spar without air: {} Hz\n", frequencies.join(", "));
    if spar.found {
        text += &format!(
            "at rest in the wind: tip {tip_up_m:.5} m up, {tip_ahead_m:.5} m ahead, {tip_nose_up_deg:.3} deg nose up\n"
        );
    }
    if let (Some(growth), Some(frequency)) = (spar.growth_1_s, spar.frequency_hz) {
        text += &format!("least damped motion about it: growth {growth:.3} 1/s at {frequency:.3} Hz\n");
    }
    text
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

/// Means of every quantity as CSV.
fn means(means: &[CycleMean]) -> String {
    let row = |m: &CycleMean| {
        let [mean, low, high] = [m.mean, m.low, m.high].map(shortest);
        format!("{},{},{mean},{low},{high}\n", m.name, m.unit)
    };
    let rows = means.iter().map(row);
    std::iter::once("quantity,unit,mean,least,most\n".into()).chain(rows).collect()
}

/// Whether a column has a row of the printed table: body rows where the body moves, hinges by side.
fn is_printed(name: &str) -> bool {
    PRINTED.contains(&name) || ["torque_", "power_"].iter().any(|kind| name.starts_with(kind))
}

/// A number in a column of eleven characters.
fn cell(number: f64) -> String {
    // As far as the column goes with a blank before it.
    let plain = format!("{number:>11.5}");
    if plain.len() > 11 || plain.starts_with(|c: char| c != ' ') { format!("{number:>11.3e}") } else { plain }
}

/// The table of means over the last cycle, with the cautions below.
fn table(summary: &TetherSummary) -> String {
    let TetherSummary { name, preset, lift_law, .. } = summary;
    let mut text = format!("{name}: preset {preset}, law {lift_law}; last cycle, from rest\n\n");
    if let Some(reason) = summary.verdict.reason.as_ref().filter(|_| summary.cycle.is_empty()) {
        text += &format!("{}: no means: {reason}\n", summary.verdict.status);
    }
    text += &format!("{:<22}{:>11}{:>11}{:>11}\n", "", "mean", "least", "most");
    for row in summary.cycle.iter().filter(|row| is_printed(&row.name)) {
        let CycleMean { name, unit, mean, low, high, .. } = row;
        text += format!("{name:<22}{}{}{}  {unit}", cell(*mean), cell(*low), cell(*high)).trim_end();
        text.push('\n');
    }
    if let (Some(positive), Some(net)) = (summary.mean_positive_power_w, summary.mean_power_w) {
        text += &format!("\nmean power given to the air: positive part {positive:.5} W, net {net:.5} W\n");
    }
    if let Some(efficiency) = summary.propulsive_efficiency {
        text += &format!("propulsive efficiency, mean thrust x wind speed / mean power: {efficiency:.4}\n");
    }
    if let Some(Periodicity { change, quantity }) = &summary.periodicity {
        let percent = 100.0 * change;
        let percent = if percent < 1e-3 { format!("{percent:.1e}") } else { format!("{percent:.3}") };
        text += &format!("last two cycles: {percent} % apart ({quantity})\n");
    }
    if let Some(reason) = summary.verdict.why_not_judged() {
        text += &format!("\n{}: {reason}\n", summary.verdict.status);
    }
    text.extend(summary.spar.as_ref().map(spar));
    for Smoothed { key, harmonics, samples, residual_rms, residual_largest } in &summary.smoothed {
        text += &format!(
            "{key}: {harmonics} harmonics of {samples} samples leave {residual_rms:.4} rms, {residual_largest:.4} at most{}\n",
            match unit(key) {
                "" => String::new(),
                unit => format!(" [{unit}]"),
            }
        );
    }
    for warning in &summary.verdict.warnings {
        text += &format!("\n{warning}\n");
    }
    text
}
