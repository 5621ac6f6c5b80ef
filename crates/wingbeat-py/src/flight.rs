//! Scenarios and their flights.

use crate::controller::{Own, Raised, SampleWatch};
use crate::document::PyDocument;
use crate::table::{NamedColumn, columns};
use crate::{refused, wait};
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;
use wingbeat::Error;
use wingbeat::plant::{Channel, Plant, Role};
use wingbeat::simulate::Sensors;

/// Name, unit, frame, lower and upper limit.
pub type ColumnDescription = (String, String, String, f64, f64);

/// A checked scenario.
#[pyclass(frozen, name = "Scenario", module = "wingbeat._wingbeat")]
pub struct PyScenario(pub Arc<wingbeat::scenario::Scenario>);

#[pymethods]
impl PyScenario {
    #[new]
    fn new(document: &PyDocument) -> PyResult<Self> {
        wingbeat::scenario::Scenario::open(document.0.clone(), &wingbeat_lattice::doors())
            .map(|scenario| Self(Arc::new(scenario)))
            .map_err(refused)
    }

    /// Name of the scenario.
    #[getter]
    fn name(&self) -> String {
        self.0.spec.name.clone()
    }

    /// The merged configuration as TOML; flies the same flight.
    #[getter]
    fn resolved(&self) -> &str {
        &self.0.resolved
    }

    /// The states: name, unit, frame, lower and upper limit.
    #[getter]
    fn states(&self) -> Vec<ColumnDescription> {
        self.0.robot().states().iter().map(described).collect()
    }

    /// The inputs: name, unit, frame, lower and upper limit.
    #[getter]
    fn inputs(&self) -> Vec<ColumnDescription> {
        self.0.robot().inputs().iter().map(described).collect()
    }

    /// State at t = 0.
    #[getter]
    fn start(&self) -> Vec<f64> {
        self.0.start()
    }

    /// Mass of the robot that flies, kg.
    #[getter]
    fn mass_kg(&self) -> f64 {
        self.0.robot().mass()
    }

    /// Roll, pitch (rad) and angular rate (rad/s) that the manoeuvre asks at `t`; none without a manoeuvre.
    fn reference(&self, t: f64) -> PyResult<Option<(f64, f64, [f64; 3])>> {
        if !t.is_finite() {
            return Err(refused(Error::invalid("t", t, "a finite number, s")));
        }
        Ok(self.0.manoeuvre().map(|manoeuvre| manoeuvre.reference(t)).map(|r| (r.roll, r.pitch, r.w.0)))
    }
}

/// A channel as Python sees it: name, unit, frame, limits in its unit.
pub fn described(channel: &Channel) -> ColumnDescription {
    let Channel { name, unit, frame, low, high, .. } = channel;
    (name.clone(), (*unit).into(), (*frame).into(), *low, *high)
}

/// Record, strips where they are recorded, and summary as JSON.
type FlightTables<'py> = (Vec<NamedColumn<'py>>, Option<Vec<NamedColumn<'py>>>, String);

/// Flies a scenario under its own controller, or one of Python's.
#[pyfunction]
#[pyo3(signature = (scenario, controller=None, period_s=0.005, sees=None, observe=None))]
pub fn fly<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    controller: Option<&Bound<'py, PyAny>>,
    period_s: f64,
    sees: Option<Vec<String>>,
    observe: Option<Py<PyAny>>,
) -> PyResult<FlightTables<'py>> {
    let scenario = scenario.0.clone();
    let raised = Raised::new(wait::Stop::default());
    let sensors = sensors(&scenario, sees)?;
    let mut own =
        controller.map(|object| Own::new(object, scenario.robot().inputs(), raised.clone())).transpose()?;
    let watch = SampleWatch::new(observe, raised.clone());
    let flown = wait::work(py, move |stop| {
        let observe = |sample: &wingbeat::simulate::Sample| {
            stop.flow()?;
            watch.see(sample)
        };
        let run = match &mut own {
            Some(own) => scenario.fly_with(own, period_s, sensors, observe),
            None => scenario.fly(observe),
        };
        run.map_err(|error| match &error {
            // An argument, which no document gives.
            Error::Invalid { key, .. } if key == "period_s" => refused(error),
            _ => refused(scenario.explain(&error)),
        })
    })?;
    raised.check()?;
    let run = flown?;
    let summary = serde_json::to_string(&run.summary).map_err(refused)?;
    Ok((columns(py, run.record), run.strips.map(|strips| columns(py, strips)), summary))
}

/// The scenario's sensors, of the channels that are called `sees` or begin so: `quat` is the attitude.
fn sensors(scenario: &wingbeat::scenario::Scenario, sees: Option<Vec<String>>) -> PyResult<Sensors> {
    let Some(sees) = sees else { return Ok(scenario.sensors()) };
    let states = scenario.robot().states();
    let meant = |name: &str, channel: &Channel| {
        channel.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
    };
    for name in &sees {
        if !states.iter().any(|channel| meant(name, channel)) {
            let known: BTreeSet<&str> = states.iter().map(|channel| channel.name.as_str()).collect();
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            return Err(refused(Error::invalid(
                "sees",
                name,
                format!("states or what their names begin with: {known}"),
            )));
        }
    }
    let seen = states.iter().filter(|channel| sees.iter().any(|name| meant(name, channel)));
    let roles: Vec<Role> = seen.map(|channel| channel.role).collect();
    Ok(scenario.sensors().only(|role| roles.contains(&role)))
}
