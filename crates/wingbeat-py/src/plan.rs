//! Offline plans.

use crate::flight::PyScenario;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::exceptions::PyBaseException;
use pyo3::prelude::*;
use wingbeat::scenario::PlanNodes;

/// Record where there is a plan, its nodes and constants as JSON, summary as JSON, the files by name, and what a signal raised meanwhile.
type PlanTables<'py> = (
    Option<Vec<NamedColumn<'py>>>,
    Option<(Vec<NamedColumn<'py>>, String)>,
    String,
    Vec<(String, String)>,
    Option<Bound<'py, PyBaseException>>,
);

/// Plans the manoeuvre of a scenario. A signal ends the solver, and the best plan so far comes with what it raised.
#[pyfunction]
pub fn plan<'py>(py: Python<'py>, scenario: &PyScenario) -> PyResult<PlanTables<'py>> {
    let scenario = scenario.0.clone();
    let (planned, raised) = wait::kept(py, move |stop| {
        scenario.plan(&mut |_| stop.flow()).map_err(|error| scenario.explain(&error))
    })?;
    let planned = planned.map_err(refused)?;
    let summary = serde_json::to_string(&planned.summary).map_err(refused)?;
    let files = planned.files.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    let nodes = planned.nodes.map(|PlanNodes { points, constants }| {
        let constants = serde_json::to_string(&constants).map_err(refused)?;
        Ok::<_, PyErr>((columns(py, points), constants))
    });
    let record = planned.record.map(|record| columns(py, record));
    let raised = raised.map(|raised| raised.into_value(py).into_bound(py));
    Ok((record, nodes.transpose()?, summary, files, raised))
}
