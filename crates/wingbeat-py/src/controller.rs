//! Controllers and observers that are written in Python.

use crate::wait::Stop;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::{PyAttributeError, PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyIterator};
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use wingbeat::math::Quat;
use wingbeat::plant::Channel;
use wingbeat::simulate::{Controller, Sample, Update};

/// What a controller sees: a mapping from the names of the states that are measured to their numbers.
///
/// A name that several begin with gives them side by side: `measurement["quat"]` has four numbers.
#[pyclass(frozen, mapping, name = "Measurement", module = "wingbeat._wingbeat")]
pub struct PyMeasurement {
    /// Time at which it was taken, s.
    #[pyo3(get)]
    taken: f64,
    /// One number per channel, in the order of `names`.
    #[pyo3(get)]
    array: Py<PyArray1<f64>>,
    places: Py<PyDict>,
}

impl PyMeasurement {
    /// The numbers of the channels whose names are `name` and an ending; none where there is no such channel.
    fn group(&self, py: Python, name: &str) -> PyResult<Vec<f64>> {
        let mut found = Vec::new();
        for (key, place) in self.places.bind(py) {
            let key: String = key.extract()?;
            if key.strip_prefix(name).is_some_and(|rest| rest.starts_with('_')) {
                found.extend(self.array.bind(py).get_owned(place.extract::<usize>()?));
            }
        }
        Ok(found)
    }

    /// Roll, pitch and yaw of the measured attitude, rad.
    fn angles(&self, py: Python) -> PyResult<[f64; 3]> {
        let quat = self.group(py, "quat")?;
        if quat.len() != 4 {
            return Err(PyAttributeError::new_err("the attitude is not measured: `sees` leaves out quat"));
        }
        Ok(Quat::from_wxyz(&quat).matrix().roll_pitch_yaw().0)
    }
}

#[pymethods]
impl PyMeasurement {
    /// A measurement of these channels, as it was pickled.
    #[staticmethod]
    fn of(py: Python, taken: f64, names: Vec<String>, values: PyReadonlyArray1<f64>) -> PyResult<Self> {
        let values = values.as_array().to_vec();
        if names.len() != values.len() {
            let (given, wanted) = (values.len(), names.len());
            return Err(PyValueError::new_err(format!(
                "{given} values: allowed is one of each of {wanted} names"
            )));
        }
        let places = PyDict::new(py);
        names.iter().enumerate().try_for_each(|(place, name)| places.set_item(name, place))?;
        let array = PyArray1::from_vec(py, values).unbind();
        Ok(Self { taken, array, places: places.unbind() })
    }

    /// Names of the channels, in order.
    #[getter]
    fn names(&self, py: Python) -> PyResult<Vec<String>> {
        self.places.bind(py).keys().extract()
    }

    /// The number of a channel, or an array of all whose names begin so.
    fn __getitem__(&self, py: Python, name: &str) -> PyResult<Py<PyAny>> {
        if let Some(place) = self.places.bind(py).get_item(name)? {
            let number = self.array.bind(py).get_owned(place.extract::<usize>()?);
            return Ok(PyFloat::new(py, number.unwrap_or(f64::NAN)).into_any().unbind());
        }
        let group = self.group(py, name)?;
        if group.is_empty() {
            let names = self.names(py)?.join(", ");
            return Err(PyKeyError::new_err(format!(
                "{name}: allowed are {names}, or what these begin with"
            )));
        }
        Ok(PyArray1::from_vec(py, group).into_any().unbind())
    }

    fn __len__(&self, py: Python) -> usize {
        self.places.bind(py).len()
    }

    /// Whether `measurement[name]` has an answer.
    fn __contains__(&self, py: Python, name: &Bound<PyAny>) -> PyResult<bool> {
        let Ok(name) = name.extract::<String>() else { return Ok(false) };
        Ok(self.places.bind(py).contains(&name)? || !self.group(py, &name)?.is_empty())
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.places.bind(py).keys().try_iter()
    }

    /// Names of the channels.
    fn keys(&self, py: Python) -> PyResult<Vec<String>> {
        self.names(py)
    }

    /// The numbers of the channels.
    fn values(&self, py: Python) -> PyResult<Vec<f64>> {
        Ok(self.array.bind(py).readonly().as_array().to_vec())
    }

    /// Names and numbers of the channels.
    fn items(&self, py: Python) -> PyResult<Vec<(String, f64)>> {
        Ok(self.names(py)?.into_iter().zip(self.values(py)?).collect())
    }

    /// The number of a channel, or `default` where it is not measured.
    #[pyo3(signature = (name, default=None))]
    fn get(&self, py: Python, name: &str, default: Option<Py<PyAny>>) -> PyResult<Option<Py<PyAny>>> {
        match self.__getitem__(py, name) {
            Err(error) if error.is_instance_of::<PyKeyError>(py) => Ok(default),
            found => found.map(Some),
        }
    }

    /// Roll of the measured attitude, rad; positive is right wing down.
    #[getter]
    fn roll(&self, py: Python) -> PyResult<f64> {
        self.angles(py).map(|angles| angles[0])
    }

    /// Pitch of the measured attitude, rad, as in records; negative is nose up.
    #[getter]
    fn pitch(&self, py: Python) -> PyResult<f64> {
        self.angles(py).map(|angles| angles[1])
    }

    /// Heading of the measured attitude, rad; positive is to the left.
    #[getter]
    fn yaw(&self, py: Python) -> PyResult<f64> {
        self.angles(py).map(|angles| angles[2])
    }

    fn __repr__(&self, py: Python) -> String {
        format!("Measurement({} states, taken {} s)", self.__len__(py), self.taken)
    }
}

/// The exception that ends a flight, and the flag that ends it.
#[derive(Clone)]
pub struct Raised {
    stop: Stop,
    first: Arc<Mutex<Option<PyErr>>>,
}

impl Raised {
    /// None yet.
    pub fn new(stop: Stop) -> Self {
        Self { stop, first: Arc::default() }
    }

    /// Keeps the first exception and ends the work.
    fn raise(&self, error: PyErr) {
        self.stop.set();
        self.first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    /// Break where Python answered true, or raised.
    fn flow(&self, ends: PyResult<bool>) -> ControlFlow<()> {
        match ends {
            Ok(false) => ControlFlow::Continue(()),
            Ok(true) => ControlFlow::Break(()),
            Err(error) => {
                self.raise(error);
                ControlFlow::Break(())
            }
        }
    }

    /// The exception, if there was one.
    ///
    /// # Errors
    /// It.
    pub fn check(&self) -> PyResult<()> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
    }
}

/// A Python object that steers: `update(t, measurement)` answers the inputs that hold until the next update.
pub struct Own {
    update: Py<PyAny>,
    places: Option<Py<PyDict>>,
    inputs: Vec<String>,
    held: Vec<f64>,
    raised: Raised,
}

impl Own {
    /// Of an object with the method `update`, or something to be called itself.
    pub fn new(object: &Bound<PyAny>, inputs: &[Channel], raised: Raised) -> PyResult<Self> {
        let update = match object.getattr("update") {
            Ok(update) => update,
            Err(_) if object.is_callable() => object.clone(),
            Err(_) => return Err(PyTypeError::new_err("a controller has a method update(t, measurement)")),
        };
        let names: Vec<String> = inputs.iter().map(|input| input.name.clone()).collect();
        let held = inputs.iter().map(|input| input.clamp(0.0)).collect();
        Ok(Self { update: update.unbind(), places: None, inputs: names, held, raised })
    }

    /// What is said of an `answer` that is no list of numbers.
    fn refused(&self, answer: &Bound<'_, PyAny>) -> PyErr {
        let given = answer.repr().map_or_else(|_| "something else".into(), |text| text.to_string());
        let (wanted, names) = (self.inputs.len(), self.inputs.join(", "));
        PyTypeError::new_err(format!(
            "the controller answers {given}: allowed are None, or {wanted} numbers, {names}"
        ))
    }

    fn asked(&mut self, py: Python, t: f64, measured: &wingbeat::simulate::Measurement) -> PyResult<Update> {
        let places = match &self.places {
            Some(places) => places.clone_ref(py),
            None => {
                let places = PyDict::new(py);
                for (place, channel) in measured.channels().iter().enumerate() {
                    places.set_item(&channel.name, place)?;
                }
                self.places.insert(places.unbind()).clone_ref(py)
            }
        };
        let array = PyArray1::from_slice(py, measured.values()).unbind();
        let seen = PyMeasurement { taken: measured.taken(), array, places };
        let answer = self.update.bind(py).call1((t, seen))?;
        if answer.is_none() {
            return Ok(Update::Kept);
        }
        let wanted = self.inputs.len();
        let taken = match answer.extract::<PyReadonlyArray1<f64>>() {
            Ok(array) => array.as_array().to_vec(),
            Err(_) => answer.extract::<Vec<f64>>().map_err(|_| self.refused(&answer))?,
        };
        if taken.len() != wanted {
            let (given, names) = (taken.len(), self.inputs.join(", "));
            return Err(PyValueError::new_err(format!(
                "the controller answers {given} inputs: allowed are {wanted}, {names}"
            )));
        }
        if let Some(place) = taken.iter().position(|input| !input.is_finite()) {
            let (name, value) = (&self.inputs[place], taken[place]);
            return Err(PyValueError::new_err(format!(
                "the controller answers {name} = {value} at t = {t:.4} s: allowed is a finite number"
            )));
        }
        self.held = taken;
        Ok(Update::Fresh)
    }
}

impl Controller for Own {
    fn update(&mut self, t: f64, measurement: &wingbeat::simulate::Measurement) -> Update {
        if self.raised.stop.flow().is_break() {
            return Update::Kept;
        }
        let outcome = Python::attach(|py| self.asked(py, t, measurement));
        outcome.unwrap_or_else(|error| {
            self.raised.raise(error);
            Update::Kept
        })
    }

    fn input(&self, _: f64, u: &mut [f64]) {
        u.copy_from_slice(&self.held);
    }
}

/// A Python function that sees every sample, `observe(t, x, u)`; a true answer ends the flight.
pub struct SampleWatch {
    observe: Option<Py<PyAny>>,
    raised: Raised,
}

impl SampleWatch {
    /// Of a function, if there is one.
    pub fn new(observe: Option<Py<PyAny>>, raised: Raised) -> Self {
        Self { observe, raised }
    }

    /// Shows a sample.
    pub fn see(&self, sample: &Sample) -> ControlFlow<()> {
        self.raised.stop.flow()?;
        let Some(observe) = &self.observe else { return ControlFlow::Continue(()) };
        let ends = Python::attach(|py| {
            let [x, u] = [sample.x, sample.u].map(|values| PyArray1::from_slice(py, values));
            observe.bind(py).call1((sample.t, x, u))?.is_truthy()
        });
        self.raised.flow(ends)
    }
}

/// A Python function that hears how far work has come, `progress(numbers)`; a true answer ends the work.
pub struct ProgressListener {
    progress: Option<Py<PyAny>>,
    raised: Raised,
}

impl ProgressListener {
    /// Of a function, if there is one.
    pub fn new(progress: Option<Py<PyAny>>, raised: Raised) -> Self {
        Self { progress, raised }
    }

    /// Tells numbers by name, each in its own unit.
    pub fn of(&self, numbers: &[(&str, f64)]) -> ControlFlow<()> {
        self.raised.stop.flow()?;
        let Some(progress) = &self.progress else { return ControlFlow::Continue(()) };
        let ends = Python::attach(|py| {
            let told = PyDict::new(py);
            numbers.iter().try_for_each(|(name, number)| told.set_item(name, number))?;
            progress.bind(py).call1((told,))?.is_truthy()
        });
        self.raised.flow(ends)
    }
}
