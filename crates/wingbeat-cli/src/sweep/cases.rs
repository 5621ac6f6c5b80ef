//! Runs of a tethered wing in a sweep: what is kept of each, and what they say together.

use std::ops::ControlFlow;

use serde::Serialize;
use wingbeat::scenario::{Sampling, Sweep};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::TetherRun;
use wingbeat_figures::Figure;

use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::tether::Tables;

/// Columns of a run beside its number and its draws, with their units.
pub const MEASURES: [(&str, &str); 9] = [
    ("completed", ""),
    ("mean_lift", "N"),
    ("mean_thrust", "N"),
    ("peak_lift", "N"),
    ("mean_power", "W"),
    ("peak_power", "W"),
    ("propulsive_efficiency", ""),
    ("stall_fraction", ""),
    ("periodicity", ""),
];

/// Those that the map shows.
const MAPPED: [&str; 4] = ["mean_lift", "mean_thrust", "mean_power", "propulsive_efficiency"];

/// The measures of a run; none when it was interrupted.
pub fn tether(
    sweep: &Sweep,
    run: usize,
    tables: &Tables,
    interrupt: &Interrupt,
) -> Result<Option<Vec<f64>>, Error> {
    let case = sweep.case(run, &|path| tables.read(path))?;
    let moved = case.tether.run(|_| interrupt.flow());
    Ok((interrupt.flow() == ControlFlow::Continue(())).then(|| measures(&moved).into()))
}

fn measures(run: &TetherRun) -> [f64; MEASURES.len()] {
    let completed = run.ending == Ending::Complete;
    let row = |name: &str| run.means.iter().find(|row| row.name == name && completed);
    let mean = |name: &str| row(name).map_or(f64::NAN, |row| row.mean);
    let peak = |name: &str| row(name).map_or(f64::NAN, |row| row.high);
    [
        f64::from(u8::from(completed)),
        mean("force_wind_lift"),
        mean("thrust"),
        peak("force_wind_lift"),
        mean("power"),
        peak("power"),
        run.efficiency.filter(|_| completed).unwrap_or(f64::NAN),
        if completed { run.stall_fraction } else { f64::NAN },
        run.periodicity.as_ref().filter(|_| completed).map_or(f64::NAN, |periodicity| periodicity.change),
    ]
}

/// Maps over the first two draws.
pub fn drawn(record: &Record, sweep: &Sweep) -> Result<Figure, wingbeat_figures::Error> {
    let keys: Vec<&str> = sweep.spec.draws.iter().map(|draw| draw.key.as_str()).collect();
    wingbeat_figures::map(record, &keys, &MAPPED, sweep.spec.sampling == Sampling::Grid)
}

/// `summary.json` of a sweep of a case.
#[derive(Debug, Serialize)]
pub struct Outcome {
    /// `ok`, or `incomplete` where a run failed.
    status: &'static str,
    runs: usize,
    completed: usize,
    measures: Vec<Range>,
}

/// Least and most of a measure over the runs, and where.
#[derive(Debug, Serialize)]
struct Range {
    name: &'static str,
    unit: &'static str,
    least: f64,
    least_run: f64,
    most: f64,
    most_run: f64,
}

impl Outcome {
    pub fn new(record: &Record) -> Self {
        let values = |name: &str| record.values(name).unwrap_or_default();
        let completed = values("completed").iter().filter(|done| **done == 1.0).count();
        let range = |(name, unit): (&'static str, &'static str)| {
            let there = || values(name).iter().zip(values("run")).filter(|(value, _)| value.is_finite());
            let least = there().min_by(|a, b| a.0.total_cmp(b.0)).unwrap_or((&f64::NAN, &f64::NAN));
            let most = there().max_by(|a, b| a.0.total_cmp(b.0)).unwrap_or((&f64::NAN, &f64::NAN));
            Range { name, unit, least: *least.0, least_run: *least.1, most: *most.0, most_run: *most.1 }
        };
        Self {
            status: if completed == record.rows() { "ok" } else { "incomplete" },
            runs: record.rows(),
            completed,
            measures: MEASURES[1..].iter().copied().map(range).collect(),
        }
    }

    pub fn table(&self) -> String {
        let mut text = format!(
            "{} of {} runs completed\n\n{:<24}{:>12}{:>7}{:>12}{:>7}\n",
            self.completed, self.runs, "", "least", "run", "most", "run"
        );
        for Range { name, unit, least, least_run, most, most_run } in &self.measures {
            text +=
                format!("{name:<24}{least:>12.5}{least_run:>7}{most:>12.5}{most_run:>7}  {unit}").trim_end();
            text.push('\n');
        }
        text
    }
}
