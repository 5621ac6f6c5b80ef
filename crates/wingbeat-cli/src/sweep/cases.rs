//! Runs of a tethered wing in a sweep: what they say together.

use serde::Serialize;
use wingbeat::scenario::{Sampling, Sweep, SweepOf};
use wingbeat::simulate::Record;
use wingbeat_figures::Figure;

/// Those that the map shows.
const MAPPED: [&str; 4] = ["mean_lift", "mean_thrust", "mean_power", "propulsive_efficiency"];

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
            measures: SweepOf::Cases.measures()[1..].iter().copied().map(range).collect(),
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
