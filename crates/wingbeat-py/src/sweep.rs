//! Runs of a sweep, one by one.

use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::tether::read;
use crate::{refused, wait};
use pyo3::prelude::*;
use std::collections::HashSet;
use std::sync::Arc;
use wingbeat::scenario::CandidateSearch;
use wingbeat::simulate::Record;

/// A checked sweep.
#[pyclass(frozen, name = "Sweep", module = "wingbeat._wingbeat")]
pub struct PySweep {
    sweep: Arc<wingbeat::scenario::Sweep>,
    stop: wait::Stop,
}

#[pymethods]
impl PySweep {
    #[new]
    fn new(document: &PyDocument) -> PyResult<Self> {
        let sweep = wingbeat::scenario::Sweep::new(document.0.clone(), &read).map_err(refused)?;
        Ok(Self { sweep: Arc::new(sweep), stop: wait::Stop::default() })
    }

    /// Name of the sweep.
    #[getter]
    fn name(&self) -> String {
        self.sweep.spec.name.clone()
    }

    /// Number of runs.
    #[getter]
    fn runs(&self) -> usize {
        self.sweep.runs()
    }

    /// The sweep as TOML, what is run inside.
    #[getter]
    fn resolved(&self) -> &str {
        &self.sweep.resolved
    }

    /// The values drawn for a run.
    fn values(&self, run: usize) -> PyResult<Vec<f64>> {
        self.check(run)?;
        Ok(self.sweep.values(run))
    }

    /// The runs that are left, in the company in which they are made.
    fn batches(&self, todo: Vec<usize>) -> PyResult<Vec<Vec<usize>>> {
        todo.iter().try_for_each(|run| self.check(*run))?;
        Ok(self.sweep.batches(todo))
    }

    /// Makes a batch of runs: of each its number, its draws and what is kept of it; none where `stop` was called.
    fn rows(&self, py: Python, batch: Vec<usize>) -> PyResult<Vec<Vec<f64>>> {
        batch.iter().try_for_each(|run| self.check(*run))?;
        let (sweep, asked) = (self.sweep.clone(), self.stop.clone());
        let made = wait::work(py, move |stop| {
            let watch = || {
                asked.flow()?;
                stop.flow()
            };
            sweep.rows(&batch, &read, watch)
        })?;
        made.map(|made| made.rows).map_err(refused)
    }

    /// Whether it searches.
    #[getter]
    fn searches(&self) -> bool {
        self.sweep.spec.search.is_some()
    }

    /// The candidates of a search that follow on those of `rows`, each with its values: a generation, of which those in `rows` are
    /// left out; none at its end.
    fn candidates(&self, rows: Vec<Vec<f64>>) -> PyResult<Vec<(usize, Vec<f64>)>> {
        let search = self.after(&rows)?;
        let done: HashSet<u64> = rows.iter().filter_map(|row| Some(row.first()?.to_bits())).collect();
        let left = search.generation().filter(|run| !done.contains(&(*run as f64).to_bits()));
        Ok(left.map(|run| (run, search.values(run))).collect())
    }

    /// Flies a candidate with its values: its row; none where `stop` was called.
    fn candidate(&self, py: Python, run: usize, values: Vec<f64>) -> PyResult<Option<Vec<f64>>> {
        self.check(run)?;
        let draws = self.sweep.draws().len();
        if values.len() != draws || !values.iter().all(|value| value.is_finite()) {
            let allowed = format!("{draws} finite numbers, one for each draw");
            return Err(refused(wingbeat::Error::invalid("values", format!("{values:?}"), allowed)));
        }
        let (sweep, asked) = (self.sweep.clone(), self.stop.clone());
        let made = wait::work(py, move |stop| {
            let watch = || {
                asked.flow()?;
                stop.flow()
            };
            sweep.search().map_or(Ok(None), |search| search.row_of(run, &values, watch))
        })?;
        made.map_err(refused)
    }

    /// What a search came to: its summary as JSON and the scenario of the best candidate as TOML.
    fn found(&self, rows: Vec<Vec<f64>>) -> PyResult<(String, String)> {
        let summary = self.sweep.searched(&self.record(&rows)?);
        let summary = summary.ok_or_else(|| refused("rows: allowed are those of a search"))?;
        Ok((summary.json(), self.after(&[])?.scenario(&summary.found).map_err(refused)?))
    }

    /// Ends the runs that are under way.
    fn stop(&self) {
        self.stop.set();
    }

    /// Whether a row is one of this sweep.
    fn has_row(&self, row: Vec<f64>) -> bool {
        self.has(&row)
    }

    /// Rows as columns.
    fn table<'py>(&self, py: Python<'py>, rows: Vec<Vec<f64>>) -> PyResult<Vec<NamedColumn<'py>>> {
        Ok(columns(py, self.record(&rows)?))
    }
}

impl PySweep {
    /// Whether a row is one of this sweep.
    fn has(&self, row: &[f64]) -> bool {
        self.sweep.search().map_or_else(|| self.sweep.has_row(row), |search| search.has_row(row))
    }

    /// Rows as a record.
    fn record(&self, rows: &[Vec<f64>]) -> PyResult<Record> {
        let of = self.sweep.search().map_or_else(|| self.sweep.columns(), |search| search.columns());
        let mut record = Record::new(of, rows.len()).map_err(refused)?;
        for row in rows {
            if !self.has(row) {
                return Err(refused(format!("{row:?}: allowed is a row of this sweep")));
            }
            record.append(row);
        }
        Ok(record)
    }

    /// The search that follows on `rows`.
    fn after(&self, rows: &[Vec<f64>]) -> PyResult<CandidateSearch<'_>> {
        let search = self.sweep.search_after(rows);
        search.ok_or_else(|| refused("search: none is asked"))?.map_err(refused)
    }

    fn check(&self, run: usize) -> PyResult<()> {
        let runs = self.sweep.runs();
        let refuse = || refused(wingbeat::Error::invalid("run", run, format!("below {runs}")));
        if run < runs { Ok(()) } else { Err(refuse()) }
    }
}
