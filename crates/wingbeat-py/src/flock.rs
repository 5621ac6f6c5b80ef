//! Robots side by side, to be learned with.

use crate::flight::{ColumnDescription, PyScenario, described};
use crate::wait::{self, Stop};
use crate::{refused, whole};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use wingbeat::Error;
use wingbeat::learn::{BankingTurn, Batch, Precision, SavedRobot, Task, View};
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::simulate::Stepper;

/// Observations, rewards, terms of the rewards, terminated, truncated.
type FlockStep<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<bool>>,
    Bound<'py, PyArray1<bool>>,
);

/// State, inputs and clock; action; seed and episode; spread and begin; actions; whether over.
type MemberState = ((Vec<f64>, Vec<f64>, (f64, f64, usize)), Vec<f64>, (u64, u64), (f64, f64), usize, bool);

/// Robots whose step takes so long that signals are heard meanwhile. *Choice*: a tenth of a second on one core.
const MANY: usize = 512;
/// Time between two looks for signals. *Choice.*
const LOOK: Duration = Duration::from_millis(2);

/// Robots of one scenario under one task.
#[pyclass(name = "Flock", module = "wingbeat._wingbeat")]
pub struct PyFlock(wingbeat::learn::Flock);

#[pymethods]
impl PyFlock {
    #[new]
    fn new(
        py: Python,
        scenario: &PyScenario,
        task: &str,
        count: &Bound<PyAny>,
        threads: &Bound<PyAny>,
        precision: &str,
    ) -> PyResult<Self> {
        let (count, threads) =
            (whole("count", count, "1 or more")?, whole("threads", threads, "0 (all cores) or more")?);
        let explained = |error: Error| refused(scenario.0.explain(&error));
        let task: Arc<dyn Task> = match task {
            "banking_turn" => Arc::new(BankingTurn::of(&scenario.0).map_err(explained)?),
            unknown => return Err(refused(Error::invalid("task", unknown, "banking_turn"))),
        };
        let precision = match precision {
            "f64" => Precision::Double,
            "f32" => Precision::Single,
            unknown => return Err(refused(Error::invalid("precision", unknown, "f64, f32"))),
        };
        let scenario = scenario.0.clone();
        let made = move || wingbeat::learn::Flock::new(&scenario, task, count, threads, precision);
        let flock = if count < MANY { made() } else { wait::work(py, move |_| made())? };
        flock.map(Self).map_err(refused)
    }

    /// What an observation holds: name, unit, frame, lower and upper limit.
    #[getter]
    fn observation(&self) -> Vec<ColumnDescription> {
        self.0.task().observation().iter().map(described).collect()
    }

    /// What an action moves: name, unit, frame, lower and upper limit.
    #[getter]
    fn action(&self) -> Vec<ColumnDescription> {
        self.0.member(0).0.system().inputs().iter().map(described).collect()
    }

    /// Names of the terms of the reward.
    #[getter]
    fn terms(&self) -> Vec<&'static str> {
        self.0.task().terms().to_vec()
    }

    /// Starts all anew, each from its seed; the observations.
    fn reset<'py>(
        &mut self,
        py: Python<'py>,
        seeds: Vec<u64>,
        spread: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if seeds.len() != self.0.count() {
            let given = format!("{} seeds", seeds.len());
            return Err(refused(Error::invalid(
                "seeds",
                given,
                format!("one of each of {}", self.0.count()),
            )));
        }
        if !(spread.is_finite() && spread >= 0.0) {
            return Err(refused(Error::invalid("spread", spread, "a finite number, at least 0")));
        }
        let observations = self.0.reset(&seeds, spread);
        self.table(py, observations)
    }

    /// Starts all on their next episodes; the observations.
    fn again<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let observations = self.0.again();
        self.table(py, observations)
    }

    /// A step of all robots under actions in [-1, 1], a row each.
    fn step<'py>(&mut self, py: Python<'py>, actions: PyReadonlyArray2<f64>) -> PyResult<FlockStep<'py>> {
        let actions: Vec<f64> = actions.as_array().iter().copied().collect();
        let batch = match self.0.count() < MANY {
            true => py.detach(|| self.0.step(&actions)),
            false => self.heard(py, &actions)?,
        };
        let batch = batch.map_err(refused)?;
        let terms = batch.terms.into_pyarray(py).reshape([self.0.count(), self.0.task().terms().len()])?;
        Ok((
            self.table(py, batch.observations)?,
            batch.rewards.into_pyarray(py),
            terms,
            batch.terminated.into_pyarray(py),
            batch.truncated.into_pyarray(py),
        ))
    }

    /// The terms of the reward of the time `t` (s), a state and the action in force, whoever flew there.
    fn judge(
        &self,
        t: f64,
        state: PyReadonlyArray1<f64>,
        action: PyReadonlyArray1<f64>,
    ) -> PyResult<Vec<f64>> {
        let robot = self.0.member(0).0.system();
        let (x, action) = (state.as_array().to_vec(), action.as_array().to_vec());
        for (key, given, wanted) in
            [("state", x.len(), robot.states().len()), ("action", action.len(), self.0.actions())]
        {
            if given != wanted {
                return Err(refused(Error::invalid(
                    key,
                    format!("{given} numbers"),
                    format!("{wanted} numbers"),
                )));
            }
        }
        let mut terms = vec![0.0; self.0.task().terms().len()];
        self.0.task().reward(&View { t, phase: robot.phase(t), x: &x, action: &action }, &mut terms);
        Ok(terms)
    }

    /// All that changes, robot after robot: state, inputs and clock; action; seed and episode; spread and begin; actions; whether over.
    fn save(&self) -> Vec<MemberState> {
        let kept = |one: SavedRobot| {
            let (x, u, clock) = one.robot.parts();
            let robot = (x.to_vec(), u.to_vec(), clock);
            (robot, one.action, (one.seed, one.episode), (one.spread, one.begun), one.count, one.over)
        };
        self.0.save().into_iter().map(kept).collect()
    }

    /// Goes back to what was saved; what follows repeats to the bit.
    fn restore(&mut self, saved: Vec<MemberState>) -> PyResult<()> {
        let robot = |((x, u, clock), action, (seed, episode), (spread, begun), count, over): MemberState| {
            let robot = wingbeat::simulate::Saved::of_parts(x, u, clock);
            SavedRobot { robot, action, seed, spread, episode, begun, count, over }
        };
        let saved: Vec<SavedRobot> = saved.into_iter().map(robot).collect();
        self.0.restore(&saved).map_err(refused)
    }
}

impl PyFlock {
    /// Robot `number` and the time of its episode, s.
    ///
    /// # Errors
    /// A number beyond the last.
    pub fn standing(&self, number: usize) -> PyResult<(f64, &Stepper<Arc<Robot>>)> {
        if number >= self.0.count() {
            return Err(refused(Error::invalid("number", number, format!("below {}", self.0.count()))));
        }
        let (stepper, t) = self.0.member(number);
        Ok((t, stepper))
    }

    /// A step of many robots, which a signal ends: all stand again as they stood before.
    fn heard(&mut self, py: Python, actions: &[f64]) -> PyResult<Result<Batch, Error>> {
        let (before, stop, flock) = (self.0.save(), Stop::default(), &mut self.0);
        let (batch, raised) = py.detach(|| {
            thread::scope(|scope| {
                let work = scope.spawn(|| flock.step_while(actions, &|| stop.flow()));
                let mut raised = None;
                while !work.is_finished() {
                    thread::sleep(LOOK);
                    if raised.is_none() {
                        raised = Python::attach(|py| py.check_signals()).err();
                        raised.iter().for_each(|_| stop.set());
                    }
                }
                (work.join(), raised)
            })
        });
        if let Some(raised) = raised {
            self.0.restore(&before).map_err(refused)?;
            return Err(raised);
        }
        batch.map_err(|_| PyRuntimeError::new_err("the step broke down"))
    }

    /// Numbers of all robots, a row each.
    fn table<'py>(&self, py: Python<'py>, values: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        values.into_pyarray(py).reshape([self.0.count(), self.0.observations()])
    }
}
