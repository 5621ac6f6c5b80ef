//! Periodic flight.

use crate::flight::Scenario;
use crate::table::{Named, columns};
use crate::{refused, wait};
use pyo3::prelude::*;

/// A table that there may be.
type Table<'py> = Option<Vec<Named<'py>>>;

/// The cycle, the multipliers, the family, the summary as JSON, and the files by name.
type Trimmed<'py> = (Table<'py>, Table<'py>, Table<'py>, String, Vec<(String, String)>);

/// Finds the periodic flight that a scenario's `[trim]` asks for.
#[pyfunction]
pub fn trim<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<Trimmed<'py>> {
    let scenario = scenario.0.clone();
    let trimmed = wait::work(py, move |stop| {
        scenario.trim(&mut |_| stop.flow()).map_err(|error| scenario.explain(&error))
    })?;
    let trimmed = trimmed.map_err(refused)?;
    let summary = serde_json::to_string(&trimmed.summary).map_err(refused)?;
    let files = trimmed.files.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    let [record, multipliers, family] = [trimmed.record, trimmed.multipliers, trimmed.family]
        .map(|table| table.map(|table| columns(py, table)));
    Ok((record, multipliers, family, summary, files))
}
