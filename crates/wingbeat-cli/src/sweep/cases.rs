//! Runs of a tethered wing in a sweep: what they say together.

use serde::Serialize;
use wingbeat::scenario::{Sampling, Sweep, SweepCounts, SweepOf};
use wingbeat::simulate::Record;
use wingbeat_figures::Figure;

/// Those that the map shows.
const MAPPED: [&str; 4] = ["mean_lift", "mean_thrust", "mean_power", "propulsive_efficiency"];

/// The keys that are drawn, with what their axes are called.
pub fn labelled(sweep: &Sweep) -> Vec<(&str, String)> {
    sweep.draws().iter().map(|draw| (draw.key.as_str(), sweep.spoken(&draw.key))).collect()
}

/// Maps over the first two draws.
pub fn drawn(record: &Record, sweep: &Sweep) -> Result<Figure, wingbeat_figures::Error> {
    let keys = labelled(sweep);
    let whole = sweep.spec.sampling == Sampling::Grid;
    wingbeat_figures::map(record, &keys, &MAPPED, (whole, &SweepCounts::usable_rows(record)))
}

/// `summary.json` of a sweep of a case.
#[derive(Debug, Serialize)]
pub struct CaseSweepSummary {
    runs: usize,
    measures: Vec<MeasureRange>,
}

/// Least and most of a measure over the completed runs whose own verdict lets them be used, and where.
#[derive(Debug, Serialize)]
struct MeasureRange {
    name: &'static str,
    unit: &'static str,
    counted: usize,
    least: Option<f64>,
    least_run: Option<f64>,
    most: Option<f64>,
    most_run: Option<f64>,
}

impl CaseSweepSummary {
    pub fn new(record: &Record) -> Self {
        let values = |name: &str| record.values(name).unwrap_or_default();
        let usable = SweepCounts::usable_rows(record);
        let range = |(name, unit): (&'static str, &'static str)| {
            let of: Vec<(f64, f64)> = usable
                .iter()
                .filter_map(|row| Some((*values(name).get(*row)?, *values("run").get(*row)?)))
                .filter(|(value, _)| value.is_finite())
                .collect();
            let least = of.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let most = of.iter().max_by(|a, b| a.0.total_cmp(&b.0));
            MeasureRange {
                name,
                unit,
                counted: of.len(),
                least: least.map(|least| least.0),
                least_run: least.map(|least| least.1),
                most: most.map(|most| most.0),
                most_run: most.map(|most| most.1),
            }
        };
        // How a run ended is no measure.
        let measures = SweepOf::Cases.measures()[3..].iter().copied().map(range).collect();
        Self { runs: record.rows(), measures }
    }

    /// Its rows, and what was drawn for the runs that they name.
    pub fn table(&self, record: &Record, sweep: &Sweep) -> String {
        let mut text =
            format!("{:<24}{:>6}{:>12}{:>7}{:>12}{:>7}\n", "", "runs", "least", "run", "most", "run");
        let cell = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.5}"));
        let number = |run: Option<f64>| run.map_or("-".into(), |run| run.to_string());
        for MeasureRange { name, unit, counted, least, least_run, most, most_run } in &self.measures {
            let (least, most) = (cell(*least), cell(*most));
            let (first, second) = (number(*least_run), number(*most_run));
            text += format!("{name:<24}{counted:>6}{least:>12}{first:>7}{most:>12}{second:>7}  {unit}")
                .trim_end();
            text.push('\n');
        }
        let runs = record.values("run").unwrap_or_default();
        let named = |run: &f64| {
            self.measures.iter().any(|of| of.least_run == Some(*run) || of.most_run == Some(*run))
        };
        for (row, run) in runs.iter().enumerate().filter(|(_, run)| named(run)) {
            let drawn = sweep.draws().iter().filter_map(|draw| {
                let value = record.values(&draw.key)?[row];
                let word = draw.word(value).map_or_else(|| value.to_string(), |word| word.to_string());
                Some(format!("{} = {word}", draw.key))
            });
            text += &format!("run {run}: {}\n", drawn.collect::<Vec<_>>().join(", "));
        }
        text
    }
}
