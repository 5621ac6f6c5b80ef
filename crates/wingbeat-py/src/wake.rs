//! The vortex lattice of a case or along a flight.

use crate::document::PyDocument;
use crate::flight::PyScenario;
use crate::table::{Given, NamedColumn, columns, record};
use crate::tether::read;
use crate::{refused, wait, whole};
use pyo3::prelude::*;
use wingbeat::judge::RunLimits;
use wingbeat::scenario::TetherCase;
use wingbeat_lattice::course::{self, CourseRequest, LatticeCourse, RecordedFlight, WakeSummary};

/// Name of a stretch, its record, and its phases as VTK by name.
type StretchTables<'py> = (String, Vec<NamedColumn<'py>>, Vec<(String, String)>);

/// Settings: times at which stretches end, cycles, whether the model's circulations are shed, panels along chord and span, steps per
/// cycle, whether the wake is prescribed, core, critical suction. Where there is none, that of [`CourseRequest`].
type WakeSettings<'py> = (
    Vec<f64>,
    Option<Bound<'py, PyAny>>,
    bool,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
    bool,
    Option<f64>,
    Option<f64>,
);

/// The wake of a case.
#[pyfunction]
pub fn wake_case<'py>(
    py: Python<'py>,
    document: &PyDocument,
    settings: WakeSettings<'py>,
) -> PyResult<(Vec<StretchTables<'py>>, String)> {
    let case = TetherCase::new(document.0.clone(), &read).map_err(refused)?;
    let asked = asked(settings)?;
    let stepped = wait::work(py, move |stop| {
        let course = course::case(&asked, &case, &|| stop.flow())?;
        step((&case.spec.name, &case.limits), &[course], &asked, stop)
    })?;
    told(py, stepped.map_err(refused)?)
}

/// The wakes along a flight of a scenario; columns are in their own units.
#[pyfunction]
pub fn wake_flight<'py>(
    py: Python<'py>,
    scenario: &PyScenario,
    flown: Vec<Given<'py>>,
    settings: WakeSettings<'py>,
) -> PyResult<(Vec<StretchTables<'py>>, String)> {
    let scenario = scenario.0.clone();
    let flown = record(flown)?;
    let asked = asked(settings)?;
    let stepped = wait::work(py, move |stop| {
        let (name, limits) = (scenario.spec.name.clone(), scenario.limits().clone());
        let courses = RecordedFlight::new(scenario, flown)?.courses(&asked)?;
        step((&name, &limits), &courses, &asked, stop)
    })?;
    told(py, stepped.map_err(refused)?)
}

fn asked(settings: WakeSettings) -> PyResult<CourseRequest> {
    let (at, cycles, model, chordwise, spanwise, steps, prescribed, core, critical_suction) = settings;
    let count = |key: &str, given: Option<Bound<PyAny>>| {
        given.map(|given| whole(key, &given, "1 or more")).transpose()
    };
    let usual = CourseRequest::default();
    Ok(CourseRequest {
        at,
        cycles: count("cycles", cycles)?,
        model,
        chordwise: count("chordwise", chordwise)?.unwrap_or(usual.chordwise),
        spanwise: count("spanwise", spanwise)?.unwrap_or(usual.spanwise),
        steps: count("steps", steps)?,
        prescribed,
        core: core.unwrap_or(usual.core),
        critical_suction,
    })
}

/// Name, record and pictures of a stretch.
type StretchFiles = (String, wingbeat::simulate::Record, Vec<(String, String)>);

fn step(
    (name, limits): (&str, &RunLimits),
    courses: &[LatticeCourse],
    asked: &CourseRequest,
    stop: &wait::Stop,
) -> Result<(Vec<StretchFiles>, WakeSummary), wingbeat_lattice::Error> {
    let stepped = courses.iter().map(|course| course.step(asked, &mut |_| stop.flow()));
    let watches = stepped.collect::<Result<Vec<_>, _>>()?;
    let summary = WakeSummary::new(name, asked, &watches, limits);
    let kept = watches.into_iter().map(|watch| {
        let shots = watch.shots.iter().map(|shot| (shot.name.clone(), shot.picture.vtk()));
        (watch.course.name.clone(), watch.record.clone(), shots.collect())
    });
    Ok((kept.collect(), summary))
}

fn told(
    py: Python<'_>,
    (kept, summary): (Vec<StretchFiles>, WakeSummary),
) -> PyResult<(Vec<StretchTables<'_>>, String)> {
    let stepped = kept.into_iter().map(|(name, record, shots)| (name, columns(py, record), shots));
    Ok((stepped.collect(), serde_json::to_string(&summary).map_err(refused)?))
}
