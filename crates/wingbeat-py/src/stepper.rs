//! A robot step by step.

use crate::flight::PyScenario;
use crate::refused;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::{Duration, Instant};
use wingbeat::Error;
use wingbeat::aero::LoadSource;
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;

/// Time between two looks for signals. *Choice.*
const LOOK: Duration = Duration::from_millis(20);

/// Longest step, s. *Choice*: a wingbeat of the slowest robots takes ten.
const LONGEST: f64 = 0.1;
/// Largest number of a state that steps can go on from, as of a document.
const LARGEST: f64 = 1e12;

/// State, inputs, and the clock: when it was set, the length of its steps (s), and their number.
type StateParts = (Vec<f64>, Vec<f64>, (f64, f64, usize));

/// All that changes while a robot is stepped, and the scenario that it belongs to.
#[pyclass(frozen, name = "Saved", module = "wingbeat._wingbeat")]
pub struct PySaved {
    saved: wingbeat::simulate::Saved,
    scenario: Arc<wingbeat::scenario::Scenario>,
}

#[pymethods]
impl PySaved {
    /// What an instance is made of again: its scenario as TOML, and its numbers.
    fn parts(&self) -> (String, StateParts) {
        let (x, u, clock) = self.saved.parts();
        (self.scenario.resolved.clone(), (x.to_vec(), u.to_vec(), clock))
    }

    /// An instance of what `parts` told.
    #[staticmethod]
    fn of(scenario: &PyScenario, parts: StateParts) -> PyResult<Self> {
        let (x, u, (start, length, first)) = parts;
        let robot = scenario.0.robot();
        check_state(robot, &x)?;
        check("inputs", &u, robot.inputs().len())?;
        check("clock", &[start, length], 2)?;
        let saved = wingbeat::simulate::Saved::of_parts(x, u, (start, length, first));
        Ok(Self { saved, scenario: scenario.0.clone() })
    }
}

/// The robot of a scenario under way: state, clock and inputs.
#[pyclass(name = "Stepper", module = "wingbeat._wingbeat")]
pub struct PyStepper {
    stepper: wingbeat::simulate::Stepper<Arc<Robot>>,
    start: Vec<f64>,
    scenario: Arc<wingbeat::scenario::Scenario>,
}

#[pymethods]
impl PyStepper {
    #[new]
    fn new(scenario: &PyScenario) -> Self {
        let (robot, start) = (Arc::new(scenario.0.robot().clone()), scenario.0.start());
        let stepper = wingbeat::simulate::Stepper::new(robot, 0.0, &start);
        Self { stepper, start, scenario: scenario.0.clone() }
    }

    /// Time, s.
    #[getter]
    fn t(&self) -> f64 {
        self.stepper.time()
    }

    /// The state, a copy.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.stepper.state())
    }

    #[setter]
    fn set_state(&mut self, state: PyReadonlyArray1<f64>) -> PyResult<()> {
        let state = state.as_array().to_vec();
        check_state(self.stepper.system(), &state)?;
        self.stepper.state_mut().copy_from_slice(&state);
        Ok(())
    }

    /// The inputs in force, a copy.
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.stepper.inputs())
    }

    #[setter]
    fn set_inputs(&mut self, inputs: PyReadonlyArray1<f64>) -> PyResult<()> {
        let inputs = inputs.as_array().to_vec();
        check("inputs", &inputs, self.stepper.inputs().len())?;
        self.stepper.set_inputs(&inputs);
        Ok(())
    }

    /// Starts anew at the time `t` (s) in the state `state`, or that of the scenario.
    #[pyo3(signature = (t=0.0, state=None))]
    fn reset(&mut self, t: f64, state: Option<PyReadonlyArray1<f64>>) -> PyResult<()> {
        let state = state.map_or_else(|| self.start.clone(), |state| state.as_array().to_vec());
        check_state(self.stepper.system(), &state)?;
        check("t", &[t], 1)?;
        self.stepper.reset(t, &state);
        Ok(())
    }

    /// Steps of `dt` seconds under the inputs as they are set.
    #[pyo3(signature = (dt=1e-3, steps=1))]
    fn step(&mut self, py: Python, dt: f64, steps: i64) -> PyResult<()> {
        let Ok(steps) = u64::try_from(steps) else {
            return Err(refused(Error::invalid("steps", steps, "0 or more")));
        };
        if !(dt > 0.0 && dt <= LONGEST) {
            return Err(refused(Error::invalid("dt", dt, format!("above 0, at most {LONGEST} s"))));
        }
        let mut done = 0;
        while done < steps {
            let stepper = &mut self.stepper;
            let outcome = py.detach(|| {
                let begun = Instant::now();
                while done < steps && begun.elapsed() < LOOK {
                    stepper.step(dt)?;
                    done += 1;
                }
                Ok(())
            });
            outcome.map_err(|fault: wingbeat::plant::Fault| PyRuntimeError::new_err(fault.to_string()))?;
            self.refuse_lost()?;
            py.check_signals()?;
        }
        Ok(())
    }

    /// All that changes, for `restore`.
    fn save(&self) -> PySaved {
        PySaved { saved: self.stepper.save(), scenario: self.scenario.clone() }
    }

    /// Goes back to what was saved; what follows repeats to the bit.
    fn restore(&mut self, saved: &PySaved) -> PyResult<()> {
        let (own, other) = (&self.scenario, &saved.scenario);
        if !Arc::ptr_eq(own, other) && own.resolved != other.resolved {
            let of = format!("of {}", other.spec.name);
            return Err(refused(Error::invalid("saved", of, "what a stepper of the same scenario saved")));
        }
        self.stepper.restore(&saved.saved);
        Ok(())
    }

    /// Angles, joints, power and loads by source now.
    fn observe<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let seen = self.stepper.observe().map_err(|fault| PyRuntimeError::new_err(fault.to_string()))?;
        let all = PyDict::new(py);
        all.set_item("phase", seen.phase)?;
        for (name, angle) in ["roll", "pitch", "yaw"].iter().zip(seen.attitude.roll_pitch_yaw().0) {
            all.set_item(name, angle)?;
        }
        let robot = self.stepper.system();
        for (name, coordinate) in robot.joint_names().zip(&seen.joints) {
            all.set_item(name, coordinate)?;
        }
        for (name, value) in [
            ("joint_power", seen.power),
            ("drive_power", seen.drive_power),
            ("regulator_power", seen.regulator_power),
        ] {
            all.set_item(name, value)?;
        }
        for (source, wrench) in LoadSource::ALL.iter().zip(seen.parts()) {
            all.set_item(format!("force_{}", source.name()), PyArray1::from_slice(py, &wrench.force.0))?;
            all.set_item(format!("moment_{}", source.name()), PyArray1::from_slice(py, &wrench.moment.0))?;
        }
        Ok(all)
    }
}

impl PyStepper {
    /// Refuses to go on from numbers that no robot has.
    fn refuse_lost(&self) -> PyResult<()> {
        let state = self.stepper.state();
        let Some(place) = state.iter().position(|value| value.abs() > LARGEST) else { return Ok(()) };
        let (name, value) = (&self.stepper.system().states()[place].name, state[place]);
        Err(PyRuntimeError::new_err(format!(
            "{name} is {value:.1e} at t = {:.4} s: the steps are too long, or the state is none of a flight",
            self.stepper.time()
        )))
    }
}

/// Largest difference from 1 of the norm of an attitude that is set: rounding and noise on a state are less, and beyond it loads change with
/// the norm. *Choice.*
const TURNED: f64 = 1e-3;

/// Refuses what is no state of `robot`: numbers too many or too few, and an attitude that is none.
fn check_state(robot: &Robot, state: &[f64]) -> PyResult<()> {
    check("state", state, robot.states().len())?;
    let at = robot.layout().attitude;
    let norm = state[at..at + 4].iter().map(|q| q * q).sum::<f64>().sqrt();
    if (norm - 1.0).abs() <= TURNED {
        return Ok(());
    }
    let key = format!("state[{at}:{}]", at + 4);
    Err(refused(Error::invalid(key, format!("a quaternion of norm {norm}"), "a norm of 1, within 0.001")))
}

fn check(key: &str, given: &[f64], wanted: usize) -> PyResult<()> {
    if given.len() != wanted {
        return Err(refused(Error::invalid(
            key,
            format!("{} numbers", given.len()),
            format!("{wanted} numbers"),
        )));
    }
    match given.iter().position(|value| !value.is_finite()) {
        Some(place) => {
            Err(refused(Error::invalid(format!("{key}[{place}]"), given[place], "a finite number")))
        }
        None => Ok(()),
    }
}
