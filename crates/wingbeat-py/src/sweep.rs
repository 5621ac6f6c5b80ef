//! Runs of a sweep, one by one.

use crate::document::Document;
use crate::table::{Named, columns};
use crate::tether::read;
use crate::{refused, wait};
use pyo3::prelude::*;
use std::sync::Arc;
use wingbeat::simulate::Record;

/// A checked sweep.
#[pyclass(frozen, module = "wingbeat._wingbeat")]
pub struct Sweep {
    sweep: Arc<wingbeat::scenario::Sweep>,
    stop: wait::Stop,
}

#[pymethods]
impl Sweep {
    #[new]
    fn new(document: &Document) -> PyResult<Self> {
        let sweep = wingbeat::scenario::Sweep::new(document.0.clone(), &read).map_err(refused)?;
        if sweep.spec.search.is_some() {
            return Err(pyo3::exceptions::PyValueError::new_err("search: allowed is `wingbeat sweep` alone"));
        }
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

    /// Ends the runs that are under way.
    fn stop(&self) {
        self.stop.set();
    }

    /// Whether a row is one of this sweep.
    fn has_row(&self, row: Vec<f64>) -> bool {
        self.sweep.has_row(&row)
    }

    /// Rows as columns.
    fn table<'py>(&self, py: Python<'py>, rows: Vec<Vec<f64>>) -> PyResult<Vec<Named<'py>>> {
        let mut record = Record::new(self.sweep.columns(), rows.len()).map_err(refused)?;
        for row in &rows {
            if !self.sweep.has_row(row) {
                return Err(refused(format!("{row:?}: allowed is a row of this sweep")));
            }
            record.append(row);
        }
        Ok(columns(py, record))
    }
}

impl Sweep {
    fn check(&self, run: usize) -> PyResult<()> {
        let runs = self.sweep.runs();
        let refuse = || refused(wingbeat::Error::invalid("run", run, format!("below {runs}")));
        if run < runs { Ok(()) } else { Err(refuse()) }
    }
}
