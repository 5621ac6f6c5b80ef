//! Results as pages, animations and the files of other programs, and robots as pixels.

use std::collections::BTreeMap;

use numpy::{IntoPyArray, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use wingbeat_figures::animation::{Animation, rgb};
use wingbeat_report::animate::{AnimationSettings, Film, Viewpoint, still};
use wingbeat_report::export::{Format, of_run};
use wingbeat_report::files::{Files, RunMemory};
use wingbeat_report::page::{Without, page};
use wingbeat_report::run::{ShownRun, of, one_axis};

use crate::flock::PyFlock;
use crate::table::{Given, record};
use crate::{refused, wait};

/// What a result holds: its name, its texts and its records, by the names of files.
type ResultFiles<'py> = (String, Vec<(String, String)>, Vec<(String, Vec<Given<'py>>)>);
/// Names and bytes of files.
type Written = Vec<(String, Vec<u8>)>;

/// A result away from Python.
fn taken((name, texts, records): ResultFiles) -> PyResult<(String, RunMemory)> {
    let records: PyResult<BTreeMap<_, _>> =
        records.into_iter().map(|(name, columns)| Ok((name, record(columns)?))).collect();
    Ok((name, RunMemory { texts: texts.into_iter().collect(), records: records? }))
}

fn runs((name, memory): &(String, RunMemory)) -> Result<Vec<ShownRun>, String> {
    of(Files::Memory(memory), name, None).map_err(|error| error.to_string())
}

fn one(result: &(String, RunMemory)) -> Result<ShownRun, String> {
    runs(result)?.into_iter().next().ok_or_else(|| "no run".into())
}

/// The page of results.
#[pyfunction]
pub fn page_of(py: Python<'_>, results: Vec<ResultFiles<'_>>, wake: bool, strips: bool) -> PyResult<String> {
    let results = results.into_iter().map(taken).collect::<PyResult<Vec<_>>>()?;
    let made = wait::work(py, move |_| {
        let runs: Vec<ShownRun> = results.iter().map(runs).collect::<Result<Vec<_>, _>>()?.concat();
        one_axis(&runs)?;
        Ok::<_, String>(page(&runs, Without { wake: !wake, strips: !strips }))
    })?;
    made.map_err(refused)
}

/// The animation of a result: an animated PNG, or a PNG of every frame where `frames` says so. `numbers` are the ratio of the time of the
/// result to that of the film, the frames a second, and the width in px.
#[pyfunction]
pub fn animation_of(
    py: Python<'_>,
    result: ResultFiles<'_>,
    view: &str,
    numbers: (f64, f64, f64),
    wide: bool,
    frames: bool,
) -> PyResult<Written> {
    let seen = Viewpoint::named(view).map_err(refused)?;
    let (speed, rate, width) = numbers;
    let asked = AnimationSettings { seen, speed, rate, width, wide }.checked("").map_err(refused)?;
    let result = taken(result)?;
    let made = wait::work(py, move |stop| {
        let run = one(&result)?;
        let film = Film::new(&run, asked)?;
        let mut animation = Animation::default();
        for k in 0..film.frames() {
            if stop.flow().is_break() {
                return Err("stopped".into());
            }
            animation.push(&film.picture(k)).map_err(|error| error.to_string())?;
        }
        animation.cover(&film.cover()).map_err(|error| error.to_string())?;
        let written = match frames {
            true => animation.stills(),
            false => animation.bytes(1.0 / asked.rate).map(|bytes| vec![(String::new(), bytes)]),
        };
        written.map_err(|error| error.to_string())
    })?;
    made.map_err(refused)
}

/// A result in the files of another program; one file has no name of its own.
#[pyfunction]
pub fn export_of(py: Python<'_>, result: ResultFiles<'_>, format: &str) -> PyResult<Written> {
    let format = Format::named(format).map_err(refused)?;
    let result = taken(result)?;
    let made = wait::work(py, move |_| {
        let memory = &result.1;
        let record = ["record.parquet", "loads.csv"].iter().find_map(|name| memory.records.get(*name));
        let record = record.or(memory.records.values().next()).ok_or("the result holds no record")?;
        of_run(format, &one(&result)?, record)
    })?;
    made.map_err(refused)
}

/// Pixels of robot `number`: rows of `width` pixels of red, green and blue.
#[pyfunction]
pub fn picture_of<'py>(
    flock: &Bound<'py, PyFlock>,
    number: usize,
    width: usize,
    height: usize,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let standing = flock.borrow();
    let (t, stepper) = standing.standing(number)?;
    let size = [width, height].map(|pixels| pixels as f64);
    let picture = still(stepper.system(), t, stepper.state(), stepper.inputs(), size);
    let picture = picture.map_err(PyRuntimeError::new_err)?;
    let drawn = rgb(&picture).map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    drawn.into_pyarray(flock.py()).reshape([height, width, 3])
}
