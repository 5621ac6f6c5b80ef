//! A robot step by step.

use crate::flight::Scenario;
use crate::refused;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::{Duration, Instant};
use wingbeat::Error;
use wingbeat::aero::LoadSource;
use wingbeat::robot::Robot;

/// Time between two looks for signals. *Choice.*
const LOOK: Duration = Duration::from_millis(20);

/// All that changes while a robot is stepped.
#[pyclass(frozen, module = "wingbeat._wingbeat")]
pub struct Saved(wingbeat::simulate::Saved);

/// The robot of a scenario under way: state, clock and inputs.
#[pyclass(module = "wingbeat._wingbeat")]
pub struct Stepper {
    stepper: wingbeat::simulate::Stepper<Arc<Robot>>,
    start: Vec<f64>,
}

#[pymethods]
impl Stepper {
    #[new]
    fn new(scenario: &Scenario) -> Self {
        let (robot, start) = (Arc::new(scenario.0.robot().clone()), scenario.0.start());
        Self { stepper: wingbeat::simulate::Stepper::new(robot, 0.0, &start), start }
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
        check("state", &state, self.stepper.state().len())?;
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
        check("state", &state, self.start.len())?;
        self.stepper.reset(t, &state);
        Ok(())
    }

    /// Steps of `dt` seconds under the inputs as they are set.
    #[pyo3(signature = (dt=1e-3, steps=1))]
    fn step(&mut self, py: Python, dt: f64, steps: usize) -> PyResult<()> {
        if !(dt.is_finite() && dt > 0.0) {
            return Err(refused(Error::invalid("dt", dt, "a finite number above 0")));
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
            py.check_signals()?;
        }
        Ok(())
    }

    /// All that changes, for `restore`.
    fn save(&self) -> Saved {
        Saved(self.stepper.save())
    }

    /// Goes back to what was saved; what follows repeats to the bit.
    fn restore(&mut self, saved: &Saved) {
        self.stepper.restore(&saved.0);
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
