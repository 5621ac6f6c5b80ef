//! The Python extension `wingbeat._wingbeat`: a thin face over the library, below the package in `python/wingbeat`.

mod calibrate;
mod controller;
mod document;
mod flight;
mod flock;
mod plan;
mod rig;
mod stepper;
mod sweep;
mod table;
mod tether;
mod trim;
mod views;
mod wait;
mod wake;

use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;
use std::fmt::Display;
use wingbeat::Error;

/// What the program would say of bad input, as a `ValueError`.
fn refused(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// A number of things; in place of Python's `OverflowError` what is allowed.
fn whole(key: &str, given: &Bound<PyAny>, allowed: &str) -> PyResult<usize> {
    given.extract().map_err(|error: PyErr| {
        let beyond = error.is_instance_of::<PyOverflowError>(given.py());
        if beyond { refused(Error::invalid(key, given, allowed)) } else { error }
    })
}

#[pymodule(name = "_wingbeat")]
mod module {
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;

    /// Refuses a processor that the extension was not built for.
    #[pymodule_init]
    fn begin(module: &Bound<'_, PyModule>) -> PyResult<()> {
        // Not `add`, which would put the name into `__all__`.
        module.setattr("__version__", env!("CARGO_PKG_VERSION"))?;
        // Else the first array imports it, and Ctrl-C in that import is a panic.
        module.py().import("numpy")?;
        drop(numpy::PyArray1::<f64>::zeros(module.py(), 0, false));
        wingbeat::processor::lacks().map_or(Ok(()), |lacks| Err(PyImportError::new_err(lacks)))
    }

    #[pymodule_export]
    use super::calibrate::calibrate;
    #[pymodule_export]
    use super::controller::PyMeasurement;
    #[pymodule_export]
    use super::document::{PyDocument, overrides};
    #[pymodule_export]
    use super::flight::{PyScenario, fly};
    #[pymodule_export]
    use super::flock::PyFlock;
    #[pymodule_export]
    use super::plan::plan;
    #[pymodule_export]
    use super::rig::{rig_process, rig_process_all, rig_simulate};
    #[pymodule_export]
    use super::stepper::{PySaved, PyStepper};
    #[pymodule_export]
    use super::sweep::PySweep;
    #[pymodule_export]
    use super::table::{read_csv, read_parquet, write_parquet};
    #[pymodule_export]
    use super::tether::tether;
    #[pymodule_export]
    use super::trim::{trim, trim_robot};
    #[pymodule_export]
    use super::views::{animation_of, export_of, page_of, picture_of};
    #[pymodule_export]
    use super::wake::{wake_case, wake_flight};
}
