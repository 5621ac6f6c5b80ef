//! Offline plans.

use crate::flight::Scenario;
use crate::table::{Named, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use wingbeat::scenario::PlanNodes;

/// Record where there is a plan, its nodes and constants as JSON, summary as JSON, and the files by name.
type Planned<'py> =
    (Option<Vec<Named<'py>>>, Option<(Vec<Named<'py>>, String)>, String, Vec<(String, String)>);

/// Plans the manoeuvre of a scenario.
#[pyfunction]
pub fn plan<'py>(py: Python<'py>, scenario: &Scenario) -> PyResult<Planned<'py>> {
    let scenario = scenario.0.clone();
    let planned = wait::work(py, move |stop| {
        scenario.plan(&mut |_| stop.flow()).map_err(|error| scenario.explain(&error))
    })?;
    let planned = planned.map_err(refused)?;
    let summary = serde_json::to_string(&planned.summary).map_err(refused)?;
    let files = planned.files.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    let nodes = planned.nodes.map(|PlanNodes { points, constants }| {
        let constants = serde_json::to_string(&constants).map_err(refused)?;
        Ok::<_, PyErr>((columns(py, points), constants))
    });
    Ok((planned.record.map(|record| columns(py, record)), nodes.transpose()?, summary, files))
}
