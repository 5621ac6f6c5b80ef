//! Kinds of feedback controllers and horizon solvers of a robot: what their tables in a scenario say, and how
//! they are made.

use super::attitude_tracking::AttitudeTracking;
use super::manoeuvre::Manoeuvre;
use super::path::PathSpec;
use crate::simulate::{Controller, SensorSpec};
use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;
use wingbeat_math::Error;
use wingbeat_ocp::plant::LocalChart;
use wingbeat_ocp::realtime::{HorizonSolver, Settings};
use wingbeat_robot::{Perch, Robot};

/// What a controller takes long to make, and controllers of one model and one table share.
pub type Prepared = Arc<dyn Any + Send + Sync>;

/// Who is told how many of how many orbits were searched, before a flight that a controller begins with a long search.
#[derive(Clone, Default)]
pub struct SearchWatch(Option<Arc<dyn Fn(usize, usize) + Send + Sync>>);

impl SearchWatch {
    /// `told` is called after each orbit with the number of those found and of all.
    pub fn new(told: impl Fn(usize, usize) + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(told)))
    }

    /// Tells that `found` orbits of `all` are there.
    pub fn see(&self, found: usize, all: usize) {
        if let Some(told) = &self.0 {
            told(found, all);
        }
    }
}

impl Debug for SearchWatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SearchWatch")
    }
}

/// What a controller is made for.
#[derive(Clone, Debug)]
pub struct ControllerTask<'a> {
    /// The robot and its air as the controller knows them.
    pub model: &'a Robot,
    /// What to fly, where the scenario says it.
    pub manoeuvre: Option<Arc<dyn Manoeuvre>>,
    /// The horizon solver, where the scenario names another than the shipped one.
    pub solver: Option<Arc<dyn SolverSpec>>,
    /// The sensors, as their data sheets have them, where the scenario says them.
    pub sensors: Option<SensorSpec>,
    /// What to fly along, where the scenario says it.
    pub path: Option<PathSpec>,
    /// The perch to land on, where the scenario says it.
    pub perch: Option<Perch>,
    /// What [`ControllerSpec::prepare`] made for the same model, if it was asked.
    pub prepared: Option<Prepared>,
    /// Who is told how far a long search is.
    pub watch: SearchWatch,
}

/// A kind of feedback controller. [`MpcSpec`](super::MpcSpec) is the one that ships;
/// a scenario names another by its table, `[controller.NAME]`.
pub trait ControllerSpec: Debug + Send + Sync {
    /// Time between updates, s.
    fn period_s(&self) -> f64;

    /// Refuses what `build` would refuse, as a scenario is read; what takes long to find out may be left to `build`.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    fn check(&self, task: ControllerTask) -> Result<(), Error> {
        self.build(task).map(drop)
    }

    /// Whether the controller estimates the state from readings of instruments; one that does not is told states.
    fn reads_instruments(&self) -> bool {
        false
    }

    /// Keys of its table that say when something begins, with that time, s. A flight that ends before says that it never does.
    fn begins(&self) -> Vec<(String, f64)> {
        Vec::new()
    }

    /// Whether the controller follows a path.
    fn follows_path(&self) -> bool {
        false
    }

    /// What takes long to make and does not change with the flight: given to [`build`](Self::build) again, it makes the
    /// same controller in less time.
    ///
    /// # Errors
    /// As [`build`](Self::build).
    fn prepare(&self, _: ControllerTask) -> Result<Option<Prepared>, Error> {
        Ok(None)
    }

    /// The controller at the start of a flight.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key, as the controller's table has it; an empty key is the table itself.
    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, Error>;
}

/// A horizon solver of a robot's attitude tracking.
pub type RobotSolver<'a> = Box<dyn HorizonSolver<LocalChart<'a, Robot>, AttitudeTracking<'a, Robot>> + 'a>;

/// A kind of horizon solver. [`RealTime`](wingbeat_ocp::realtime::RealTime) is the one that ships;
/// a scenario names another by its table, `[solver.NAME]`.
pub trait SolverSpec: Debug + Send + Sync {
    /// A solver for the sizes and limits of `plant` and `tracking`, on the horizon of `settings`.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key, as the solver's table has it.
    fn build<'a>(
        &self,
        plant: &LocalChart<'a, Robot>,
        tracking: &AttitudeTracking<'a, Robot>,
        settings: Settings,
    ) -> Result<RobotSolver<'a>, Error>;
}
