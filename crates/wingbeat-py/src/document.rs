//! Documents from files, texts and Python's dictionaries.

use crate::refused;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use std::path::PathBuf;
use toml::{Table, Value};
use wingbeat::Error;

/// Most dictionaries and lists in one another. *Choice*: the deepest value of a robot has eight.
const DEEPEST: usize = 64;
/// Most values of a dictionary, where 16 letters of a text count as one. *Choice*: as many as the largest file holds.
const MOST: usize = 500_000;

/// How much more a dictionary may hold: Python's may hold themselves.
struct DictionaryRoom {
    depth: usize,
    left: usize,
}

impl DictionaryRoom {
    fn new() -> Self {
        Self { depth: 0, left: MOST }
    }

    /// Takes `count` values in `key`.
    fn take(&mut self, key: &str, count: usize) -> PyResult<()> {
        let left = self.left.checked_sub(count);
        self.left =
            left.ok_or_else(|| refused(format!("{}: allowed are at most {MOST} values in all", brief(key))))?;
        Ok(())
    }

    /// Does `work` a level deeper.
    fn below<R>(&mut self, key: &str, work: impl FnOnce(&mut Self) -> PyResult<R>) -> PyResult<R> {
        if self.depth == DEEPEST {
            let what = format!(
                "allowed are at most {DEEPEST} dictionaries and lists in one another, none in itself"
            );
            return Err(refused(format!("{}: {what}", brief(key))));
        }
        self.depth += 1;
        let done = work(self);
        self.depth -= 1;
        done
    }
}

/// The beginning of a long key.
fn brief(key: &str) -> String {
    const SHOWN: usize = 60;
    if key.chars().count() <= SHOWN {
        key.to_owned()
    } else {
        key.chars().take(SHOWN).chain("...".chars()).collect()
    }
}

/// A configuration: a file, a text or a dictionary, what is put into it, and overrides.
#[pyclass(frozen, name = "Document", module = "wingbeat._wingbeat")]
pub struct PyDocument(pub wingbeat::scenario::Document);

#[pymethods]
impl PyDocument {
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
        let table = table(value, name, &mut DictionaryRoom::new())?;
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

    /// Whether it is of a robot by itself.
    fn is_of_robot(&self) -> bool {
        wingbeat::scenario::RobotTrim::takes(&self.0)
    }

    /// Checks that the document is a robot; its name.
    fn robot(&self) -> PyResult<String> {
        let spec = self.0.robot().map_err(refused)?;
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
    spread(given, "", &mut texts, &mut DictionaryRoom::new())?;
    Ok(texts)
}

/// Overrides `key=value` of all that is no dictionary.
fn spread(
    overrides: &Bound<PyDict>,
    above: &str,
    texts: &mut Vec<String>,
    room: &mut DictionaryRoom,
) -> PyResult<()> {
    for (key, value) in overrides {
        let key = name(&key)?;
        // A number's own name has points, which lead nowhere.
        let whole = above == "numbers." || above.ends_with(".numbers.");
        let key = if whole && !key.starts_with('"') {
            format!("{above}\"{key}\"")
        } else {
            format!("{above}{key}")
        };
        match value.cast::<PyDict>() {
            Ok(below) if !below.is_empty() => {
                room.below(&key, |room| spread(below, &format!("{key}."), texts, room))?;
            }
            _ => texts.push(format!("{key}={}", given(&value, &key, room)?)),
        }
    }
    Ok(())
}

/// A value as it stands in an override: a word without quotes, numbers as Python writes them.
fn given(value: &Bound<PyAny>, key: &str, room: &mut DictionaryRoom) -> PyResult<String> {
    if value.is_instance_of::<PyFloat>() {
        // Of Python's own type: the representation of NumPy's names its type.
        return Ok(PyFloat::new(value.py(), value.extract()?).repr()?.to_string());
    }
    if let Ok(list) = value.cast::<PyList>() {
        room.take(key, list.len())?;
        let items = room.below(key, |room| {
            let items = list.iter().enumerate();
            items.map(|(i, item)| given(&item, &format!("{key}[{i}]"), room)).collect::<PyResult<Vec<_>>>()
        })?;
        return Ok(format!("[{}]", items.join(", ")));
    }
    Ok(match toml_of(value, key, room)? {
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

fn table(dictionary: &Bound<PyDict>, above: &str, room: &mut DictionaryRoom) -> PyResult<Table> {
    room.take(above, dictionary.len())?;
    room.below(above, |room| {
        let entries = dictionary.iter();
        let entry = |(key, value): (Bound<PyAny>, Bound<PyAny>)| {
            let key = name(&key)?;
            let value = toml_of(&value, &format!("{above}.{key}"), room)?;
            Ok((key, value))
        };
        entries.map(entry).collect()
    })
}

/// A Python value as TOML has it; numbers and arrays of NumPy too.
fn toml_of(value: &Bound<PyAny>, key: &str, room: &mut DictionaryRoom) -> PyResult<Value> {
    if let Ok(dictionary) = value.cast::<PyDict>() {
        return table(dictionary, key, room).map(Value::Table);
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
        let text: String = value.extract()?;
        room.take(key, text.len() / 16)?;
        return Ok(Value::String(text));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        room.take(key, value.len()?)?;
        return room.below(key, |room| {
            let items = value.try_iter()?.enumerate();
            let items = items.map(|(i, item)| toml_of(&item?, &format!("{key}[{i}]"), room));
            items.collect::<PyResult<_>>().map(Value::Array)
        });
    }
    // Paths, and the scalars and arrays of NumPy.
    if let Ok(path) = value.call_method0("__fspath__") {
        return room.below(key, |room| toml_of(&path, key, room));
    }
    // Before a list is made of them.
    let size = value.getattr("size").and_then(|size| size.extract::<usize>());
    if size.is_ok_and(|size| size > room.left) {
        room.take(key, usize::MAX)?;
    }
    if let Ok(plain) = value.call_method0("tolist") {
        return room.below(key, |room| toml_of(&plain, key, room));
    }
    let class = value.get_type().name()?;
    Err(PyTypeError::new_err(format!("{key}: a {class} has no place in a configuration")))
}
