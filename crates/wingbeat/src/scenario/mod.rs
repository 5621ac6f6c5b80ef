//! TOML to checked objects: the only place where strings become things.

mod build;
mod document;
mod mismatch;
mod plan;
mod recorder;
mod rig;
mod rig_process;
mod rig_statement;
mod rig_together;
mod spec;
mod summary;
mod sweep;
mod tether;
mod tether_spec;

pub use document::{ConfigError, Document, Other, Place, Problem, Translate, Wrong};
pub use mismatch::Mismatch;
pub use plan::{
    GaitNumbers, LeastPowerSummary, PassNumbers, PlanSpec, PlanSummary, Planned, RollInSummary, SolverNumbers,
};
pub use rig::{EnvelopeSpec, HoldSpec, MountSpec, ProcessSpec, RigRun, RigRunSpec, RigSpec};
pub use rig_process::{Processed, Weighed};
pub use rig_together::{Evaluated, ProcessedRun, Together, subtract_still_air, together};
pub use spec::{
    AeroSpec, AirSpec, FlightSpec, GoalSpec, PaperAeroSpec, PaperResults, Preset, ScenarioSpec, StartSpec,
};
pub use summary::{ControllerSummary, Status, Summary};
pub use sweep::{Draw, Hold, Sweep, SweepSpec};
pub use tether::{TetherCase, TetherSummary};
pub use tether_spec::{
    ClockSpec, CoordinateSpec, FourierSpec, HingeSpec, ReadTable, ReferenceSpec, TableSpec, TetherSpec,
    TetheredBodySpec, TetheredWingSpec, WindSpec,
};

use crate::Error;
use crate::flight::{AtRest, Controller, Ending, Flight, Record, Sample, Schedule, Sensed, fly};
use crate::guide::Mpc;
use crate::math::{Quat, Vec3};
use crate::robot::Robot;
use build::Built;
use recorder::Recorder;
use std::ops::ControlFlow;
use std::path::Path;

/// Keys of a scenario that name a file to be put in their place.
const INCLUDES: [&str; 1] = ["robot"];

/// A checked scenario, ready to fly.
#[derive(Debug)]
pub struct Scenario {
    /// What the files and overrides said.
    pub spec: ScenarioSpec,
    /// The merged configuration as TOML; flies the same flight.
    pub resolved: String,
    document: Document,
    robot: Robot,
    model: Robot,
    schedule: Schedule,
}

/// A flown scenario.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time histories.
    pub record: Record,
    /// Numbers to compare.
    pub summary: Summary,
}

impl Scenario {
    /// Reads, merges and checks a scenario file; `overrides` are `key=value`.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides))
    }

    /// Merges and checks a scenario from files or memory. Its key `robot` names a file, or holds the robot.
    ///
    /// ```no_run
    /// use std::path::Path;
    /// use wingbeat::scenario::{Document, Scenario, ScenarioSpec};
    ///
    /// // From a file, the robot from another one than it names.
    /// let robot = Document::file(Path::new("robots/aerobat_beta.toml"))?;
    /// let document = Document::file(Path::new("scenarios/glide.toml"))?.put("robot", robot)?;
    /// let scenario = Scenario::new(document.set("air.wind_m_s=[-1.0, 0.0, 0.0]"))?;
    ///
    /// // From what is in memory.
    /// let mut spec: ScenarioSpec = scenario.spec.clone();
    /// spec.flight.duration_s = 0.5;
    /// spec.robot.body.mass_kg *= 1.1;
    /// let heavier = Scenario::new(Document::value("heavier", &spec)?)?;
    /// let run = heavier.fly(|_| std::ops::ControlFlow::Continue(()))?;
    /// println!("{} m down", -run.summary.altitude_change_m);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document) -> Result<Self, ConfigError> {
        let document = document.merged(&INCLUDES, &|_, _| None)?;
        let spec: ScenarioSpec = document.parse()?;
        let resolved = document.resolved()?;
        match spec.build() {
            Ok(Built { robot, model, schedule }) => {
                Ok(Self { spec, resolved, document, robot, model, schedule })
            }
            Err(error) => Err(document.explain(&error)),
        }
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.document.explain(error)
    }

    /// The robot that flies, in its air.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The robot and air as the controller knows them.
    pub fn model(&self) -> &Robot {
        &self.model
    }

    /// State at t = 0: at the origin, structure at rest, still wake.
    pub fn start(&self) -> Vec<f64> {
        let (start, layout) = (&self.spec.start, self.robot.layout());
        let mut x = vec![0.0; layout.len];
        let [roll, pitch, yaw] = [start.roll_deg, start.pitch_deg, start.yaw_deg].map(f64::to_radians);
        Quat::from_roll_pitch_yaw(roll, pitch, yaw).store_wxyz(&mut x[layout.attitude..]);
        Vec3(start.velocity_m_s).store(&mut x[layout.velocity..]);
        let coordinates = self.robot.start_coordinates();
        x[layout.joints..][..coordinates.len()].copy_from_slice(&coordinates);
        x
    }

    /// The scenario's predictive controller, if it has one.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the offending key.
    pub fn controller(&self) -> Result<Option<Mpc<'_, Robot>>, Error> {
        self.spec.controller(&self.model)
    }

    /// Flies the scenario. `observe` sees every recorded sample and may stop the flight.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the controller's settings are out of range.
    pub fn fly(&self, observe: impl FnMut(&Sample) -> ControlFlow<()>) -> Result<Run, Error> {
        match (self.controller()?, &self.spec.sensors) {
            (Some(controller), Some(sensors)) => {
                let mut sensed = Sensed::new(controller, &self.robot, sensors, self.spec.seed);
                self.fly_with(&mut sensed, observe)
            }
            (Some(mut controller), None) => self.fly_with(&mut controller, observe),
            (None, _) => self.fly_with(&mut AtRest, observe),
        }
    }

    fn fly_with<C: Controller>(
        &self,
        controller: &mut C,
        mut observe: impl FnMut(&Sample) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        let rows = self.schedule.steps / self.schedule.steps_per_sample + 1;
        let mut recorder = Recorder::new(&self.robot, controller, rows)?;
        let mut broken = None;
        let mut x = self.start();
        let mut flight = fly(&self.robot, controller, &self.schedule, &mut x, |sample, controller| {
            if let Err(fault) = recorder.sample(sample, controller) {
                broken = Some(fault);
                return ControlFlow::Break(());
            }
            observe(sample)
        });
        if let Some(fault) = broken {
            flight.ending = Ending::Fault(fault);
        }
        let (record, stall_fraction) = recorder.finish();
        let summary = self.summarise(&record, &flight, stall_fraction);
        Ok(Run { record, summary })
    }

    fn summarise(&self, record: &Record, flight: &Flight, stall_fraction: f64) -> Summary {
        let context = summary::Context {
            manoeuvre: self.spec.manoeuvre.as_ref(),
            goal: self.spec.goal.as_ref(),
            preset: self.spec.aero.preset.name(),
            law: self.spec.aero.law.name(),
            stall_fraction,
        };
        Summary::new(record, flight, &context)
    }
}
