//! Runs of the bench.

use crate::table::{Named, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::PathBuf;
use wingbeat::parallel;
use wingbeat::scenario::RigRun;

/// What became of a run, by name: record where there is one, and the numbers as JSON.
type Simulated<'py> = (String, Option<Vec<Named<'py>>>, String);

/// Plans and simulates the run of a file, or those that it lists; `overrides` are `key=value`.
#[pyfunction]
pub fn rig_simulate(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Vec<Simulated<'_>>> {
    let runs = RigRun::load_all(&path, &overrides, &wingbeat_io::urdf_as_toml).map_err(refused)?;
    let done = wait::work(py, move |_| {
        let simulated = parallel::map(&runs, |_, run| {
            run.simulated(run.spec.seed.unwrap_or(0), |_| {}).map_err(|error| run.explain(&error))
        });
        let named = runs.iter().map(|run| (run.spec.name.clone(), run.frequency()));
        named.zip(simulated).collect::<Vec<_>>()
    })?;
    done.into_iter()
        .map(|((name, frequency_hz), simulated)| {
            let simulated = simulated.map_err(refused)?;
            let summary = serde_json::json!({
                "status": simulated.status,
                "reason": simulated.reason,
                "frequency_hz": frequency_hz,
                "window_s": simulated.window_s,
                "samples": simulated.record.as_ref().map_or(0, wingbeat::simulate::Record::rows),
                "saturated": simulated.saturated,
            });
            Ok((name, simulated.record.map(|record| columns(py, record)), summary.to_string()))
        })
        .collect()
}
