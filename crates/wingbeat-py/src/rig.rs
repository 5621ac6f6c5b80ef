//! Runs of the bench.

use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Mutex;
use wingbeat::parallel;
use wingbeat::scenario::{ConfigError, Document, ProcessedRun, RigRun, SimulatedRun};
use wingbeat::simulate::Record;
use wingbeat_calibrate::{ProcessedTogether, SampleSource};

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
        let (source, lent) = (SampleSource { samples, run: None, window: window_s }, Mutex::new(Some(run)));
        let given = |_: &SampleSource| lent.lock().ok().and_then(|mut run| run.take()).ok_or(LENT.to_owned());
        let ProcessedTogether { runs, summary, .. } = ProcessedTogether::of(&[source], given)?;
        let record = runs.first().and_then(averages).transpose()?;
        Ok((record, serde_json::to_string(&summary).map_err(|error| error.to_string())?))
    })?;
    let (record, summary) = done.map_err(refused)?;
    Ok((name, record.map(|record| columns(py, record)), summary, resolved))
}

/// Why a run that is given for one file is none for another.
const LENT: &str = "the run was given for one file";

/// Phase averages of a run; none of static tilts.
fn averages(one: &ProcessedRun) -> Option<Result<Record, String>> {
    let record = one.averaged()?.record(one.run.processed_frame());
    Some(record.map_err(|error| error.to_string()))
}

/// Name, phase averages (none of static tilts) and the run as TOML.
type AveragedPart<'py> = (String, Option<Vec<NamedColumn<'py>>>, String);

/// Processes a folder of folders of samples, each as the run that its folder holds, or all as that of a document; `overrides`, `key=value`, are for every
/// run. The runs, the envelope of all where they have one, and the numbers as JSON.
#[pyfunction]
pub fn rig_process_all<'py>(
    py: Python<'py>,
    path: PathBuf,
    run: Option<&PyDocument>,
    overrides: Vec<String>,
) -> PyResult<(Vec<AveragedPart<'py>>, Option<Vec<NamedColumn<'py>>>, String)> {
    let given = run.map(|run| run.0.clone());
    let done = wait::work(py, move |_| -> Result<_, String> {
        let doors = wingbeat_lattice::doors();
        let load = |source: &SampleSource| {
            let document = match (&source.run, &given) {
                (Some(file), _) => Document::file(file).map_err(|error| error.to_string())?,
                (None, Some(run)) => run.clone(),
                (None, None) => return Err(LENT.into()),
            };
            let run = RigRun::new(document.overridden(&overrides), &wingbeat_io::urdf_as_toml);
            Ok(run.map_err(|error| error.to_string())?.through(&doors))
        };
        let sources = SampleSource::find(&path, given.is_some(), "run=\"RUN.toml\"")?;
        let ProcessedTogether { runs, together, summary } = ProcessedTogether::of(&sources, load)?;
        let parts = runs
            .iter()
            .map(|one| Ok((one.name().to_owned(), averages(one).transpose()?, one.run.resolved.clone())));
        let parts = parts.collect::<Result<Vec<_>, String>>()?;
        let summary = serde_json::to_string(&summary).map_err(|error| error.to_string())?;
        Ok((parts, together.map(|together| together.envelope), summary))
    })?;
    let (parts, envelope, summary) = done.map_err(refused)?;
    let part = |(name, record, resolved): (String, Option<Record>, String)| {
        (name, record.map(|record| columns(py, record)), resolved)
    };
    let parts = parts.into_iter().map(part).collect();
    Ok((parts, envelope.map(|envelope| columns(py, envelope)), summary))
}
