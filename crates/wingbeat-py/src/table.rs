//! Records as columns of NumPy, which take over the numbers without a copy.

use crate::refused;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use std::path::PathBuf;
use wingbeat::simulate::{Column, Record};

/// Name, unit, frame, lower and upper limit, numbers.
pub type NamedColumn<'py> = (String, String, String, f64, f64, Bound<'py, PyArray1<f64>>);

/// The columns of a record, in their own units; their numbers cannot be written to.
pub fn columns(py: Python<'_>, record: Record) -> Vec<NamedColumn<'_>> {
    let column = |column: Column| {
        let Column { name, unit, frame, low, high, values } = column;
        let values = values.into_pyarray(py);
        let values = values.readwrite().make_nonwriteable();
        (name, unit, frame, low, high, values.as_any().clone().cast_into().expect("an array"))
    };
    record.into_columns().into_iter().map(column).collect()
}

/// Columns as Python hands them back.
pub type Given<'py> = (String, String, String, f64, f64, PyReadonlyArray1<'py, f64>);

/// The record of columns that Python hands back, in their own units.
///
/// # Errors
/// Columns of different lengths.
pub fn record(columns: Vec<Given<'_>>) -> PyResult<Record> {
    let column = |(name, unit, frame, low, high, values): Given<'_>| Column {
        name,
        unit,
        frame,
        low,
        high,
        values: values.as_array().to_vec(),
    };
    Record::new(columns.into_iter().map(column).collect(), 0).map_err(refused)
}

/// Writes columns, in their own units, as the program writes its records: the same bytes.
#[pyfunction]
pub fn write_parquet(path: PathBuf, columns: Vec<Given<'_>>) -> PyResult<()> {
    wingbeat_io::write_parquet(&path, &record(columns)?).map_err(refused)
}

/// Reads the columns of a table in text.
#[pyfunction]
pub fn read_csv(py: Python<'_>, path: PathBuf) -> PyResult<Vec<NamedColumn<'_>>> {
    let record = py.detach(|| wingbeat_io::read_csv(&path)).map_err(refused)?;
    Ok(columns(py, record))
}

/// Reads the columns of a record.
#[pyfunction]
pub fn read_parquet(py: Python<'_>, path: PathBuf) -> PyResult<Vec<NamedColumn<'_>>> {
    let record = py.detach(|| wingbeat_io::read_parquet(&path)).map_err(refused)?;
    Ok(columns(py, record))
}
