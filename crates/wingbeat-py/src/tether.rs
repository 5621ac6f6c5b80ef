//! Wings in prescribed motion.

use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use wingbeat::scenario::{Convergence, MeasuredComparison, TetherCase};
use wingbeat::simulate::{Ending, Record};
use wingbeat::tether::TetherRun;

/// Loads, strips, the compared cycle where there is one, the summary as JSON, and the case as TOML.
type TetherTables<'py> =
    (Vec<NamedColumn<'py>>, Vec<NamedColumn<'py>>, Option<Vec<NamedColumn<'py>>>, String, String);

/// The table in a file; the text says what is wrong with it.
pub fn read(path: &Path) -> Result<Record, String> {
    wingbeat_io::read_csv(path).map_err(|error| error.to_string())
}

/// A measured file whose channels and times fit the case.
struct MeasuredTable {
    path: PathBuf,
    record: Record,
    channels: Vec<(String, String)>,
}

impl MeasuredTable {
    fn open(path: PathBuf, case: &TetherCase) -> PyResult<Self> {
        let record = wingbeat_io::samples::read_measured(&path).map_err(refused)?;
        let channels = case.channels(&record).map_err(refused)?;
        case.measured_phase(&record).map_err(|error| refused(format!("{}: {error}", path.display())))?;
        Ok(Self { path, record, channels })
    }

    fn compare(&self, case: &TetherCase, run: &TetherRun) -> Result<MeasuredComparison, String> {
        let compared = case.compare(run, &self.record, &self.channels);
        compared.map_err(|error| format!("{}: {error}", self.path.display()))
    }
}

/// Moves the wing of a case, and again with other steps, to say how much these matter.
#[pyfunction]
#[pyo3(signature = (document, compare=None, converge=false))]
pub fn tether<'py>(
    py: Python<'py>,
    document: &PyDocument,
    compare: Option<PathBuf>,
    converge: bool,
) -> PyResult<TetherTables<'py>> {
    let case = TetherCase::new(document.0.clone(), &read).map_err(refused)?;
    let measured = compare.map(|path| MeasuredTable::open(path, &case)).transpose()?;
    let done = wait::work(py, move |stop| {
        let run = case.tether.run(|_| stop.flow());
        let again = |other: &wingbeat::tether::Tether| Ok::<_, String>(other.run(|_| stop.flow()));
        let step_change = case.step_change(&run, again)?;
        let measured = measured.filter(|_| run.ending == Ending::Complete);
        let compared = measured.map(|measured| measured.compare(&case, &run)).transpose()?;
        let summary = case.summary(&run, step_change, compared.as_ref());
        let mut json = serde_json::to_value(&summary).map_err(|error| error.to_string())?;
        let mut put = |key: &str, value: serde_json::Result<serde_json::Value>| {
            json[key] = value.map_err(|error| error.to_string())?;
            Ok::<_, String>(())
        };
        if converge {
            let table: Option<Convergence> =
                case.converge(&read, &|| stop.flow(), |_| {}).map_err(|error| error.to_string())?;
            put("converge", serde_json::to_value(table))?;
        }
        let mut cycle = None;
        if let Some(MeasuredComparison { channels, cycle: compared, .. }) = compared {
            put("compare", serde_json::to_value(channels))?;
            cycle = Some(compared);
        }
        Ok::<_, String>((run, cycle, json, case.resolved))
    })?;
    let (run, cycle, json, resolved) = done.map_err(refused)?;
    let cycle = cycle.map(|cycle| columns(py, cycle));
    Ok((columns(py, run.loads), columns(py, run.strips), cycle, json.to_string(), resolved))
}
