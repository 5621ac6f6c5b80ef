//! Runs of the bench.

use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::PathBuf;
use wingbeat::parallel;
use wingbeat::scenario::{ConfigError, Document as Text, Evaluated, RigRun, SimulatedRun};

/// What became of a run, by name: record where there is one, the numbers as JSON, and the run as TOML.
type Simulated<'py> = (String, Option<Vec<NamedColumn<'py>>>, String, String);

/// Plans and simulates the run of a file, or those that it lists; `overrides` are `key=value`.
#[pyfunction]
pub fn rig_simulate(py: Python<'_>, path: PathBuf, overrides: Vec<String>) -> PyResult<Vec<Simulated<'_>>> {
    let runs = RigRun::load_all(&path, &overrides, &wingbeat_io::urdf_as_toml).map_err(refused)?;
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

/// Name, phase averages (none of static tilts), and the numbers as JSON.
type AveragedRun<'py> = (String, Option<Vec<NamedColumn<'py>>>, String);

/// Processes a file of samples as the run of a file; `window_s` is what a simulation measured.
#[pyfunction]
pub fn rig_process(
    py: Python<'_>,
    samples: PathBuf,
    run: PathBuf,
    overrides: Vec<String>,
    window_s: Option<(f64, f64)>,
) -> PyResult<AveragedRun<'_>> {
    let text = Text::file(&run).map_err(refused)?.overridden(&overrides);
    let run = RigRun::new(text, &wingbeat_io::urdf_as_toml).map_err(refused)?;
    let done = wait::work(py, move |_| -> Result<_, String> {
        let named = |what: String| format!("{}: {what}", samples.display());
        let input = &run.spec.process.input;
        let read = wingbeat_io::samples::read_samples(&samples, input).and_then(|read| read.import(input));
        let record = read.map_err(|error| error.to_string())?.record;
        let evaluated =
            run.evaluated(record, window_s).map_err(|error| named(run.explain(&error).to_string()))?;
        let (evaluated, window_s) = evaluated.map_err(named)?;
        let name = run.spec.name.clone();
        match evaluated {
            Evaluated::Averaged(done) => {
                let record = done.record(run.processed_frame()).map_err(|error| error.to_string())?;
                let json = serde_json::json!({
                    "window_s": window_s,
                    "cycles": done.cycles[0].cycles,
                    "cycles_left_out": done.cycles[0].left_out,
                    "saturated": done.saturated,
                    "serious": done.serious,
                    "simulated": done.is_simulated(),
                    "statement": done.statement,
                });
                Ok((name, Some(record), json))
            }
            Evaluated::Weighed(done) => {
                Ok((name, None, serde_json::to_value(done).map_err(|error| error.to_string())?))
            }
        }
    })?;
    let (name, record, json) = done.map_err(refused)?;
    Ok((name, record.map(|record| columns(py, record)), json.to_string()))
}
