//! Documents from files, texts and Python's dictionaries.

use crate::refused;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::path::PathBuf;
use toml::{Table, Value};
use wingbeat::Error;

/// A configuration: a file, a text or a dictionary, what is put into it, and overrides.
#[pyclass(frozen, module = "wingbeat._wingbeat")]
pub struct Document(pub wingbeat::scenario::Document);

#[pymethods]
impl Document {
    /// The TOML file `path`.
    #[staticmethod]
    fn file(path: PathBuf) -> PyResult<Self> {
        wingbeat::scenario::Document::file(&path).map(Self).map_err(refused)
    }

    /// A TOML text; errors call it `name`.
    #[staticmethod]
    fn text(name: &str, toml: &str) -> PyResult<Self> {
        wingbeat::scenario::Document::text(name, toml).map(Self).map_err(refused)
    }

    /// A dictionary; errors call it `name`.
    #[staticmethod]
    fn value(name: &str, value: &Bound<PyDict>) -> PyResult<Self> {
        let table = table(value, name)?;
        wingbeat::scenario::Document::value(name, &table).map(Self).map_err(refused)
    }

    /// This document with `other` under `key`, in place of what stands there.
    fn put(&self, key: &str, other: &Self) -> PyResult<Self> {
        self.0.clone().put(key, other.0.clone()).map(Self).map_err(refused)
    }

    /// This document with overrides: keys as paths, or dictionaries in dictionaries.
    fn overridden(&self, overrides: &Bound<PyDict>) -> PyResult<Self> {
        Ok(Self(self.0.clone().overridden(&self::overrides(overrides)?)))
    }

    /// The merged configuration as TOML, keys in alphabetical order.
    fn resolved(&self) -> PyResult<String> {
        self.0.resolved().map_err(refused)
    }

    /// Checks that the document is a robot; its name.
    fn robot(&self) -> PyResult<String> {
        let spec: wingbeat::robot::RobotSpec = self.0.parse().map_err(refused)?;
        match spec.check() {
            Ok(()) => Ok(spec.name),
            Err(error) => Err(refused(self.0.explain(&error))),
        }
    }
}

/// Overrides as the program takes them, `key=value`.
#[pyfunction]
pub fn overrides(given: &Bound<PyDict>) -> PyResult<Vec<String>> {
    let mut texts = Vec::new();
    spread(given, "", &mut texts)?;
    Ok(texts)
}

/// Overrides `key=value` of all that is no dictionary.
fn spread(overrides: &Bound<PyDict>, above: &str, texts: &mut Vec<String>) -> PyResult<()> {
    for (key, value) in overrides {
        let key = format!("{above}{}", name(&key)?);
        match value.cast::<PyDict>() {
            Ok(below) if !below.is_empty() => spread(below, &format!("{key}."), texts)?,
            _ => texts.push(format!("{key}={}", given(&value, &key)?)),
        }
    }
    Ok(())
}

/// A value as it stands in an override: a word without quotes, numbers as Python writes them.
fn given(value: &Bound<PyAny>, key: &str) -> PyResult<String> {
    if value.is_instance_of::<PyFloat>() {
        // Of Python's own type: the representation of NumPy's names its type.
        return Ok(PyFloat::new(value.py(), value.extract()?).repr()?.to_string());
    }
    if let Ok(list) = value.cast::<PyList>() {
        let items = list.iter().enumerate().map(|(i, item)| given(&item, &format!("{key}[{i}]")));
        return Ok(format!("[{}]", items.collect::<PyResult<Vec<_>>>()?.join(", ")));
    }
    Ok(match toml_of(value, key)? {
        Value::String(text) if !key.ends_with(']') && is_word(&text) => text,
        value => value.to_string(),
    })
}

/// True when an override takes the text for a text, without quotes.
fn is_word(text: &str) -> bool {
    let letters = text.chars().all(|c| c.is_ascii_alphanumeric() || "_-./".contains(c));
    letters && toml::from_str::<Table>(&format!("v={text}")).is_err()
}

fn name(key: &Bound<PyAny>) -> PyResult<String> {
    key.extract().map_err(|_| PyTypeError::new_err("keys are text"))
}

fn table(dictionary: &Bound<PyDict>, above: &str) -> PyResult<Table> {
    dictionary
        .iter()
        .map(|(key, value)| {
            let key = name(&key)?;
            let value = toml_of(&value, &format!("{above}.{key}"))?;
            Ok((key, value))
        })
        .collect()
}

/// A Python value as TOML has it; numbers and arrays of NumPy too.
fn toml_of(value: &Bound<PyAny>, key: &str) -> PyResult<Value> {
    if let Ok(dictionary) = value.cast::<PyDict>() {
        return table(dictionary, key).map(Value::Table);
    }
    if value.is_instance_of::<PyBool>() {
        return value.extract().map(Value::Boolean);
    }
    if value.is_instance_of::<PyInt>() {
        let fits = value.extract().map(Value::Integer);
        return fits.map_err(|_| refused(Error::invalid(key, value, "a whole number of 64 bits")));
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float);
    }
    if value.is_instance_of::<PyString>() {
        return value.extract().map(Value::String);
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let items = value.try_iter()?.enumerate();
        return items
            .map(|(i, item)| toml_of(&item?, &format!("{key}[{i}]")))
            .collect::<PyResult<_>>()
            .map(Value::Array);
    }
    // Paths, and the scalars and arrays of NumPy.
    if let Ok(path) = value.call_method0("__fspath__") {
        return toml_of(&path, key);
    }
    if let Ok(plain) = value.call_method0("tolist") {
        return toml_of(&plain, key);
    }
    let class = value.get_type().name()?;
    Err(PyTypeError::new_err(format!("{key}: a {class} has no place in a configuration")))
}
