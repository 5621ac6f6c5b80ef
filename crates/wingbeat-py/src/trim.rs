//! Periodic flight.

use crate::controller::{ProgressListener, Raised};
use crate::document::PyDocument;
use crate::flight::PyScenario;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use wingbeat::scenario::{ConfigError, RobotTrim, SearchProgress, TrimProgress};

/// A table that there may be.
type OptionalTable<'py> = Option<Vec<NamedColumn<'py>>>;

/// The cycle, the multipliers, the family, the starts of a search, the summary as JSON, and the files by name.
type TrimTables<'py> = (
    OptionalTable<'py>,
    OptionalTable<'py>,
    OptionalTable<'py>,
    OptionalTable<'py>,
    String,
    Vec<(String, String)>,
);

/// Finds the periodic flight, or the gait, that a scenario's `[trim]` asks for. `progress` hears of every iteration.
#[pyfunction]
#[pyo3(signature = (scenario, progress=None))]
pub fn trim<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    progress: Option<Py<PyAny>>,
) -> PyResult<TrimTables<'py>> {
    let scenario = scenario.0.clone();
    found(py, progress, move |see| scenario.trim(see))
}

/// The same of a robot from its document alone; `overrides` are of the scenario around it. Also that scenario.
#[pyfunction]
#[pyo3(signature = (robot, overrides, bank_deg, progress=None))]
pub fn trim_robot<'py>(
    py: Python<'py>,
    robot: &PyDocument,
    overrides: Vec<String>,
    bank_deg: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, TrimTables<'py>)> {
    RobotTrim::check_bank(bank_deg).map_err(refused)?;
    let asked = RobotTrim::new(robot.0.clone(), &overrides, bank_deg).map_err(refused)?;
    let around = asked.scenario.resolved.clone();
    Ok((around, found(py, progress, move |see| asked.trim(see))?))
}

/// What is told on the way may end it.
type See<'a> = &'a mut dyn FnMut(TrimProgress) -> ControlFlow<()>;

/// What `work` finds, in Python's types.
fn found<'py>(
    py: Python<'py>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(See) -> Result<wingbeat::scenario::Trimmed, ConfigError> + Send + 'static,
) -> PyResult<TrimTables<'py>> {
    let raised = Raised::new(wait::Stop::default());
    let told = ProgressListener::new(progress, raised.clone());
    let trimmed = wait::work(py, move |stop| {
        work(&mut |at| {
            stop.flow()?;
            told.of(&numbers(at))
        })
    })?;
    raised.check()?;
    let trimmed = trimmed.map_err(refused)?;
    let summary = serde_json::to_string(&trimmed.summary).map_err(refused)?;
    let files = trimmed.files.into_iter().map(|(name, text)| (name.to_string(), text)).collect();
    let [record, multipliers, family, starts] =
        [trimmed.record, trimmed.multipliers, trimmed.family, trimmed.starts]
            .map(|table| table.map(|table| columns(py, table)));
    Ok((record, multipliers, family, starts, summary, files))
}

/// What is told on the way, by name.
fn numbers(at: TrimProgress) -> Vec<(&'static str, f64)> {
    match at {
        TrimProgress::Search(SearchProgress { start, iteration, power_w_kg, frequency_hz, violation }) => {
            vec![
                ("start", start as f64),
                ("iteration", iteration as f64),
                ("power_w_kg", power_w_kg),
                ("frequency_hz", frequency_hz),
                ("violation", violation),
            ]
        }
        TrimProgress::Turn { flight } => {
            vec![("flight", flight as f64)]
        }
        TrimProgress::Orbit { orbits, iteration, residual } => {
            vec![("orbits", orbits as f64), ("iteration", iteration as f64), ("residual", residual)]
        }
    }
}
