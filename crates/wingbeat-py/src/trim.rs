//! Periodic flight.

use crate::controller::{Raised, Told};
use crate::flight::Scenario;
use crate::table::{Named, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use wingbeat::scenario::{SearchProgress, TrimProgress};

/// A table that there may be.
type Table<'py> = Option<Vec<Named<'py>>>;

/// The cycle, the multipliers, the family, the starts of a search, the summary as JSON, and the files by name.
type Trimmed<'py> = (Table<'py>, Table<'py>, Table<'py>, Table<'py>, String, Vec<(String, String)>);

/// Finds the periodic flight, or the gait, that a scenario's `[trim]` asks for. `progress` hears of every iteration.
#[pyfunction]
#[pyo3(signature = (scenario, progress=None))]
pub fn trim<'py>(
    py: Python<'py>,
    scenario: &Scenario,
    progress: Option<Py<PyAny>>,
) -> PyResult<Trimmed<'py>> {
    let scenario = scenario.0.clone();
    let raised = Raised::new(wait::Stop::default());
    let told = Told::new(progress, raised.clone());
    let trimmed = wait::work(py, move |stop| {
        scenario.trim(&mut |at| {
            stop.flow()?;
            told.of(&numbers(at))
        })
    })?;
    raised.check()?;
    let trimmed = trimmed.map_err(refused)?;
    let summary = serde_json::to_string(&trimmed.summary).map_err(refused)?;
    let files = trimmed.files.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    let [record, multipliers, family, starts] =
        [trimmed.record, trimmed.multipliers, trimmed.family, trimmed.starts]
            .map(|table| table.map(|table| columns(py, table)));
    Ok((record, multipliers, family, starts, summary, files))
}

/// What is told on the way, by name.
fn numbers(at: TrimProgress) -> Vec<(&'static str, f64)> {
    match at {
        TrimProgress::Search(SearchProgress { start, iteration, power_w_kg, frequency_hz, violation }) => {
            vec![
                ("start", start as f64),
                ("iteration", iteration as f64),
                ("power_w_kg", power_w_kg),
                ("frequency_hz", frequency_hz),
                ("violation", violation),
            ]
        }
        TrimProgress::Turn { flight } => {
            vec![("flight", flight as f64)]
        }
        TrimProgress::Orbit { orbits, iteration, residual } => {
            vec![("orbits", orbits as f64), ("iteration", iteration as f64), ("residual", residual)]
        }
    }
}
