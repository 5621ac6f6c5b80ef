//! TOML to checked objects: the only place where strings become things.

mod document;
mod mismatch;
mod plan;
mod recorder;
mod rig;
mod rig_process;
mod rig_statement;
mod spec;
mod summary;
mod sweep;
mod tether;
mod tether_spec;

pub use document::{ConfigError, Document, Place, Problem, Translate};
pub use mismatch::Mismatch;
pub use plan::{
    GaitNumbers, LeastPowerSummary, PassNumbers, PlanSpec, PlanSummary, Planned, RollInSummary, SolverNumbers,
};
pub use rig::{EnvelopeSpec, HoldSpec, MountSpec, ProcessSpec, RigRun, RigRunSpec, RigSpec};
pub use rig_process::{Processed, Weighed};
pub use spec::{
    AeroSpec, AirSpec, FlightSpec, GoalSpec, PaperAeroSpec, PaperResults, Preset, ScenarioSpec, StartSpec,
};
pub use summary::{ControllerSummary, FlightStatus, Summary};
pub use sweep::{Draw, Hold, Sweep, SweepSpec};
pub use tether::{TetherCase, TetherSummary};
pub use tether_spec::{
    ClockSpec, CoordinateSpec, FourierSpec, HingeSpec, ReadTable, ReferenceSpec, TableSpec, TetherSpec,
    TetheredBodySpec, TetheredWingSpec, WindSpec,
};

use crate::Error;
use crate::aero::{Aero, LiftingLine, LiftingLineSettings, StripModel, StripSettings};
use crate::guide::Mpc;
use crate::math::{Quat, Vec3};
use crate::plant::Plant;
use crate::require;
use crate::robot::{Air, Robot, RobotSpec, SurfaceOutline, Wind};
use crate::simulate::{AtRest, Controller, Flight, Record, Sample, Schedule, Sensors, fly};
use recorder::{Recorded, Recorder};
use std::ops::ControlFlow;
use std::path::Path;

/// Largest number of records of a flight: 1 GB in memory.
const MAX_SAMPLES: usize = 500_000;
/// Largest number of rows of a flight's strips: 1 GB in memory.
const MAX_STRIP_ROWS: usize = 5_000_000;
/// Most steps of a flight: about twenty minutes of computing.
const MAX_STEPS: usize = 1_000_000_000;

/// Keys of a scenario that name a file to be put in their place.
const INCLUDES: [&str; 1] = ["robot"];

/// A checked scenario, ready to fly.
#[derive(Debug)]
pub struct Scenario {
    /// What the files and overrides said.
    pub spec: ScenarioSpec,
    /// The merged configuration as TOML; flies the same flight.
    pub resolved: String,
    robot: Robot,
    model: Robot,
    schedule: Schedule,
    samples_per_strips: Option<usize>,
}

/// A flown scenario.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time histories.
    pub record: Record,
    /// Loads of the strips, one row per strip and instant ([`StripRecorder`](crate::simulate::StripRecorder)),
    /// where `flight.record_strips_every_s` asks for them.
    pub strips: Option<Record>,
    /// Numbers to compare.
    pub summary: Summary,
}

impl Scenario {
    /// Reads, merges and checks a scenario file; `overrides` are `key=value`.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        let document = Document::load(path, overrides, &INCLUDES)?;
        let spec: ScenarioSpec = document.parse()?;
        let resolved = document.resolved()?;
        Self::build(spec, resolved).map_err(|error| document.explain(&error))
    }

    fn build(spec: ScenarioSpec, resolved: String) -> Result<Self, Error> {
        spec.check()?;
        let (robot, model) = (spec.flown_robot()?, spec.known_robot()?);
        let schedule = spec.schedule()?;
        let samples_per_strips = spec.samples_per_strips(&schedule, &robot)?;
        let scenario = Self { spec, resolved, robot, model, schedule, samples_per_strips };
        scenario.controller()?;
        Ok(scenario)
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
        match (&self.spec.controller, &self.spec.manoeuvre) {
            (Some(spec), Some(manoeuvre)) => {
                Mpc::new(&self.model, manoeuvre.clone(), spec).map(Some).map_err(|e| e.within("controller"))
            }
            _ => Ok(None),
        }
    }

    /// Flies the scenario. `observe` sees every recorded sample and may stop the flight.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the controller's settings are out of range.
    pub fn fly(&self, observe: impl FnMut(&Sample) -> ControlFlow<()>) -> Result<Run, Error> {
        match self.controller()? {
            Some(mut controller) => self.fly_under(&mut controller, self.sensors(), &self.schedule, observe),
            None => self.fly_under(&mut AtRest, self.sensors(), &self.schedule, observe),
        }
    }

    /// Flies the scenario's robot from its start under a controller of one's own, updated every
    /// `period_s` (whole steps) with what `sensors` tell; record and summary stay in memory.
    /// `observe` sees every recorded sample and may stop the flight.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the period is no whole number of steps, or a column of the
    /// controller has a name that the record has already.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    /// use wingbeat::plant::{Plant, Role};
    /// use wingbeat::scenario::Scenario;
    /// use wingbeat::simulate::{Controller, Measurement, Update};
    ///
    /// /// Lifts the lower wing in proportion to roll and roll rate.
    /// struct Leveller {
    ///     left: usize,
    ///     right: usize,
    ///     stroke: f64,
    /// }
    ///
    /// impl Controller for Leveller {
    ///     fn update(&mut self, _t: f64, measurement: &Measurement) -> Update {
    ///         let (Some(q), Some(w)) = (measurement.attitude(), measurement.vector(Role::AngularRate))
    ///         else {
    ///             return Update::Kept;
    ///         };
    ///         let roll = q.matrix().roll_pitch_yaw()[0];
    ///         self.stroke = 0.5 * roll + 0.02 * w[0];
    ///         Update::Fresh
    ///     }
    ///     fn input(&self, _t: f64, u: &mut [f64]) {
    ///         u.fill(0.0);
    ///         (u[self.left], u[self.right]) = (-self.stroke, self.stroke);
    ///     }
    /// }
    ///
    /// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    /// let scenario = Scenario::load(path.as_ref(), &["flight.duration_s=0.1".into()])?;
    /// let input = |name: &str| scenario.robot().inputs().iter().position(|input| input.name == name);
    /// let mut own = Leveller {
    ///     left: input("command_shoulder_left").expect("a shoulder"),
    ///     right: input("command_shoulder_right").expect("a shoulder"),
    ///     stroke: 0.0,
    /// };
    /// let inertial_unit =
    ///     scenario.sensors().only(|role| matches!(role, Role::Attitude(_) | Role::AngularRate(_)));
    /// let run = scenario.fly_with(&mut own, 0.005, inertial_unit, |_| ControlFlow::Continue(()))?;
    /// assert_eq!((run.summary.controller.updates, run.summary.controller.failures), (20, 0));
    /// assert!(run.record.values("roll").is_some_and(|roll| roll.len() == 101));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fly_with<C: Controller>(
        &self,
        controller: &mut C,
        period_s: f64,
        sensors: Sensors,
        observe: impl FnMut(&Sample) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        let period = whole("period_s", period_s, self.schedule.step, "steps of")?;
        let schedule = Schedule { steps_per_update: Some(period), ..self.schedule };
        self.fly_under(controller, sensors, &schedule, observe)
    }

    /// What the scenario's controller is told of the robot.
    pub fn sensors(&self) -> Sensors {
        match &self.spec.sensors {
            Some(spec) => Sensors::noisy(&self.robot, spec, self.spec.seed),
            None => Sensors::perfect(&self.robot),
        }
    }

    fn fly_under<C: Controller>(
        &self,
        controller: &mut C,
        mut sensors: Sensors,
        schedule: &Schedule,
        mut observe: impl FnMut(&Sample) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        let rows = schedule.steps / schedule.steps_per_sample + 1;
        let mut recorder = Recorder::new(&self.robot, controller, rows, self.samples_per_strips)?;
        let mut x = self.start();
        let flight = fly(&self.robot, &mut sensors, controller, schedule, &mut x, |sample, controller| {
            recorder.sample(sample, controller)?;
            Ok(observe(sample))
        });
        let Recorded { record, strips, stall_fraction } = recorder.finish();
        let summary = self.summarise(&record, &flight, stall_fraction);
        Ok(Run { record, strips, summary })
    }

    fn summarise(&self, record: &Record, flight: &Flight, stall_fraction: f64) -> Summary {
        let context = summary::Context {
            manoeuvre: self.spec.manoeuvre.as_ref(),
            goal: self.spec.goal.as_ref(),
            inputs: self.robot.inputs(),
            preset: self.spec.aero.preset.name(),
            law: self.spec.aero.law.name(),
            stall_fraction,
        };
        Summary::new(record, flight, &context)
    }
}

impl ScenarioSpec {
    fn check(&self) -> Result<(), Error> {
        require::name("name", &self.name)?;
        self.robot.check().map_err(|e| e.within("robot"))?;
        require::positive("air.density_kg_m3", self.air.density_kg_m3)?;
        require::finite("air.wind_m_s", &self.air.wind_m_s)?;
        require::not_negative("air.gust_m_s", self.air.gust_m_s)?;
        require::finite("start.velocity_m_s", &self.start.velocity_m_s)?;
        let stall = self.aero.stall_angle_deg;
        if !(stall > 0.0 && stall < 90.0) {
            return Err(Error::invalid("aero.stall_angle_deg", stall, "between 0 and 90"));
        }
        if let Some(goal) = &self.goal {
            goal.check().map_err(|e| e.within("goal"))?;
        }
        if let Some(sensors) = &self.sensors {
            sensors.check().map_err(|e| e.within("sensors"))?;
        }
        if let Some(mismatch) = &self.mismatch {
            mismatch.check(&self.robot).map_err(|e| e.within("mismatch"))?;
        }
        if let Some(track) = self.manoeuvre.as_ref().and_then(|m| m.track.as_ref()) {
            track.check().map_err(|e| e.within("manoeuvre.track"))?;
        }
        if let Some(plan) = &self.plan {
            plan.check().map_err(|e| e.within("plan"))?;
        }
        if self.controller.is_some() && self.manoeuvre.is_none() {
            return Err(Error::invalid("controller", "given", "a manoeuvre to fly: add [manoeuvre]"));
        }
        Ok(())
    }

    /// The robot that flies: mismatch and gust included.
    fn flown_robot(&self) -> Result<Robot, Error> {
        let mismatch = self.mismatch.clone().unwrap_or_default();
        let density = self.air.density_kg_m3 * mismatch.density;
        let wind = Wind::gusty(Vec3(self.air.wind_m_s), self.air.gust_m_s, self.seed);
        self.robot_in(&mismatch.apply(&self.robot), Air { density, wind })
    }

    /// The robot as its controller knows it.
    fn known_robot(&self) -> Result<Robot, Error> {
        let wind = Wind::steady(Vec3(self.air.wind_m_s));
        self.robot_in(&self.robot, Air { density: self.air.density_kg_m3, wind })
    }

    fn robot_in(&self, spec: &RobotSpec, air: Air) -> Result<Robot, Error> {
        let mut spec = spec.clone();
        if !self.flight.flapping {
            spec.gait.hold_still();
        }
        let outlines = spec.outlines().map_err(|e| e.within("robot"))?;
        let aero = self.aero.models(&outlines, air.density)?;
        Robot::new(&spec, aero, air, self.start.phase_rad).map_err(|e| e.within("robot"))
    }

    /// Whole samples between the records of the strips.
    fn samples_per_strips(&self, schedule: &Schedule, robot: &Robot) -> Result<Option<usize>, Error> {
        let Some(every) = self.flight.record_strips_every_s else { return Ok(None) };
        let key = "flight.record_strips_every_s";
        let samples = whole(key, every, self.flight.record_every_s, "records every")?;
        let strips: usize = robot.surfaces().map(|(_, aero)| aero.strips()).sum();
        let rows = strips * (schedule.steps / schedule.steps_per_sample / samples + 1);
        if rows > MAX_STRIP_ROWS {
            let allowed = format!("at most {MAX_STRIP_ROWS} rows of strips; these make {rows}");
            return Err(Error::invalid(key, every, allowed));
        }
        Ok(Some(samples))
    }

    /// Whole steps for duration, updates and records.
    fn schedule(&self) -> Result<Schedule, Error> {
        let flight = &self.flight;
        let step = flight.step_s;
        require::positive("flight.step_s", step)?;
        let whole = |key: &str, time: f64| whole(key, time, step, "steps of");
        let period = self.controller.as_ref().map(|c| whole("controller.period_s", c.period_s));
        let schedule = Schedule {
            step,
            steps: whole("flight.duration_s", flight.duration_s)?,
            steps_per_update: period.transpose()?,
            steps_per_sample: whole("flight.record_every_s", flight.record_every_s)?,
        };
        if schedule.steps > MAX_STEPS {
            let allowed = format!("long enough for at most {MAX_STEPS} steps of the flight");
            return Err(Error::invalid("flight.step_s", step, allowed));
        }
        let samples = schedule.steps / schedule.steps_per_sample;
        if samples > MAX_SAMPLES {
            let allowed = format!("at most {MAX_SAMPLES} records; these make {samples}");
            return Err(Error::invalid("flight.record_every_s", flight.record_every_s, allowed));
        }
        Ok(schedule)
    }
}

/// How many times `unit` (s) goes into `time`, if it does; `units` names it.
fn whole(key: &str, time: f64, unit: f64, units: &str) -> Result<usize, Error> {
    let count = (time / unit).round();
    if count >= 1.0 && (count * unit - time).abs() <= 1e-9 * time {
        return Ok(count as usize);
    }
    Err(Error::invalid(key, time, format!("a whole number of {units} {unit} s, at least one")))
}

impl AeroSpec {
    /// The models of all surfaces.
    fn models(&self, outlines: &[SurfaceOutline], density_kg_m3: f64) -> Result<Vec<Aero>, Error> {
        outlines.iter().map(|outline| self.build(outline, density_kg_m3)).collect()
    }

    /// The model of a surface.
    fn build(&self, outline: &SurfaceOutline, density_kg_m3: f64) -> Result<Aero, Error> {
        let SurfaceOutline { planform, drag, .. } = outline;
        match self.preset {
            Preset::Paper => {
                let settings = LiftingLineSettings {
                    nodes: outline.strips.unwrap_or(self.paper.nodes),
                    regularisation_m_s: self.paper.regularisation_m_s,
                    chord_floor_m: self.paper.chord_floor_m,
                    law: self.law,
                    stall_angle_rad: self.stall_angle_deg.to_radians(),
                    drag: *drag,
                    added_mass: self.added_mass,
                    section_moment: self.section_moment,
                    density_kg_m3,
                    ..LiftingLineSettings::default()
                };
                LiftingLine::new(planform, settings)
                    .map(Aero::LiftingLine)
                    .map_err(|e| e.within("aero.paper"))
            }
            Preset::Full => {
                let settings = StripSettings {
                    strips: outline.strips.unwrap_or(self.full.strips),
                    hinge_arcs_m: outline.hinges.clone(),
                    regularisation_m_s: self.full.regularisation_m_s,
                    lags: self.full.lags,
                    wake_wash: self.full.wake_wash,
                    doublet_wash: self.full.doublet_wash,
                    force_tilt: self.full.force_tilt,
                    law: self.law,
                    stall_angle_rad: self.stall_angle_deg.to_radians(),
                    drag: *drag,
                    added_mass: self.added_mass,
                    section_moment: self.section_moment,
                    density_kg_m3,
                };
                StripModel::new(planform, settings).map(Aero::Strip).map_err(|e| e.within("aero.full"))
            }
        }
    }
}
