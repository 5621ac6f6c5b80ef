//! Runs of the bench.

use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::PathBuf;
use wingbeat::parallel;
use wingbeat::scenario::{ConfigError, ProcessedRun, RigRun, SimulatedRun, subtract_still_air, together};
use wingbeat_calibrate::{ProcessSummary, ProcessedFile};

/// What became of a run, by name: record where there is one, the numbers as JSON, and the run as TOML.
type Simulated<'py> = (String, Option<Vec<NamedColumn<'py>>>, String, String);

/// Plans and simulates the run of a document, or those that a file lists; `overrides` are `key=value`.
#[pyfunction]
pub fn rig_simulate<'py>(
    py: Python<'py>,
    document: &PyDocument,
    overrides: Vec<String>,
) -> PyResult<Vec<Simulated<'py>>> {
    let runs = RigRun::load_all(document.0.clone(), &overrides, &wingbeat_io::urdf_as_toml);
    let runs = runs.map_err(refused)?;
    let doors = wingbeat_lattice::doors();
    let runs: Vec<RigRun> = runs.into_iter().map(|run| run.through(&doors)).collect();
    let done = wait::work(py, move |_| {
        let simulated = parallel::map(&runs, |_, run| {
            run.simulated(run.spec.seed.unwrap_or(0), |_| {}).map_err(|error| run.explain(&error))
        });
        let told = |(run, simulated): (&RigRun, Result<SimulatedRun, ConfigError>)| {
            let told = simulated.map(|simulated| (simulated.summary(run), simulated.record));
            (run.spec.name.clone(), told, run.resolved.clone())
        };
        runs.iter().zip(simulated).map(told).collect::<Vec<_>>()
    })?;
    done.into_iter()
        .map(|(name, told, resolved)| {
            let (summary, record) = told.map_err(refused)?;
            let summary = serde_json::to_string(&summary).map_err(refused)?;
            Ok((name, record.map(|record| columns(py, record)), summary, resolved))
        })
        .collect()
}

/// Name, phase averages (none of static tilts), the numbers as JSON, and the run as TOML.
type AveragedRun<'py> = (String, Option<Vec<NamedColumn<'py>>>, String, String);

/// Processes a file of samples as the run of a document; `window_s` is what a simulation measured.
#[pyfunction]
pub fn rig_process<'py>(
    py: Python<'py>,
    samples: PathBuf,
    run: &PyDocument,
    window_s: Option<(f64, f64)>,
) -> PyResult<AveragedRun<'py>> {
    let run = RigRun::new(run.0.clone(), &wingbeat_io::urdf_as_toml).map_err(refused)?;
    let run = run.through(&wingbeat_lattice::doors());
    let (name, resolved) = (run.spec.name.clone(), run.resolved.clone());
    let done = wait::work(py, move |_| -> Result<_, String> {
        let named = |what: String| format!("{}: {what}", samples.display());
        let input = &run.spec.process.input;
        let read = wingbeat_io::samples::read_samples(&samples, input).and_then(|read| read.import(input));
        let imported = read.map_err(|error| error.to_string())?;
        let evaluated = run.evaluated(imported.record, window_s);
        let evaluated = evaluated.map_err(|error| named(run.explain(&error).to_string()))?;
        let (result, window) = evaluated.map_err(named)?;
        let mut runs = [ProcessedRun { run, result }];
        subtract_still_air(&mut runs).map_err(|error| error.to_string())?;
        let together = together(&runs).map_err(|error| error.to_string())?;
        let files = [ProcessedFile { file: samples, import: imported.import, window }];
        let summary = ProcessSummary::new(&runs, &files, together.as_ref());
        let [one] = &runs;
        let record = one.averaged().map(|done| done.record(one.run.processed_frame()));
        let record = record.transpose().map_err(|error| error.to_string())?;
        Ok((record, serde_json::to_string(&summary).map_err(|error| error.to_string())?))
    })?;
    let (record, summary) = done.map_err(refused)?;
    Ok((name, record.map(|record| columns(py, record)), summary, resolved))
}
