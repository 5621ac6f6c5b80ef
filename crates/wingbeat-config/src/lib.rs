//! TOML to checked objects: the only place where strings become things.

// Its derive writes nothing: schemas are made by tests alone.
#[cfg(not(feature = "schema"))]
extern crate wingbeat_no_schema as schemars;

mod build;
mod calibration;
mod chosen;
mod cost;
mod dived;
mod document;
mod doors;
mod dryden;
mod estimate;
mod finer;
mod fit;
mod fit_draw;
mod flight_verdict;
mod flow_past;
mod followed;
mod governed;
mod grounded;
mod hinged;
mod hovered;
#[doc(hidden)]
pub mod inside;
mod lattice;
#[cfg(feature = "learn")]
pub mod learn;
mod link_spar;
mod measure;
mod mismatch;
mod motion_table;
mod moved;
mod name;
mod nearness;
mod perch;
mod pinned;
mod plan;
mod planned;
mod plausible;
mod recorder;
mod rig;
mod rig_model;
mod rig_process;
mod rig_simulated;
mod rig_spec;
mod rig_statement;
mod rig_together;
mod rig_truth;
mod schema;
mod search;
mod search_spec;
mod shared;
mod side_by_side;
mod skin;
mod sound;
mod span_keys;
mod spar_numbers;
mod spar_spec;
mod spec;
mod stall;
mod step_error;
mod summary;
mod sweep;
mod sweep_row;
mod sweep_spec;
mod sweep_verdict;
mod tether;
mod told_errors;
mod trim;
mod turned;
mod unheard;
mod verdict_limits;
mod watched;
mod web;
mod written;

pub use calibration::{
    CalibratedCaseSpec, CalibratedRunSpec, CalibrationSpec, DesignSpec, ParameterSpec, StructureOfModel,
    TruthSpec, VariedSpec,
};
pub use chosen::{Chosen, Named};
pub use cost::{CostLine, CostSummary};
pub use document::{
    ConfigError, Document, KeyProblem, Migrated, Other, Translate, ValuePlace, Wrong, largest, migrated,
    nearest_names, spoken, text_of, unit,
};
pub use doors::Doors;
pub use dryden::DrydenSpec;
pub use estimate::EstimateSummary;
pub use followed::PathSummary;
pub use governed::GovernedSummary;
pub use hovered::HoverSummary;
pub use lattice::{LatticeSpec, LatticeSummary, LatticeTask, MakeLattice};
pub use measure::{Measure, Measured, measures};
pub use mismatch::Mismatch;
pub use motion_table::{Smoothed, TableBy, TableSpec};
pub use moved::Moved;
pub use name::RunName;
pub use perch::{PerchKind, PerchSpec, PerchSummary};
pub use plan::{
    GaitNumbers, LeastPowerSummary, PassNumbers, PlanConstants, PlanNodes, PlanSpec, PlanSummary, PlanValue,
    Planned, RollInSummary, SolverNumbers,
};
pub use planned::{PreparedSummary, ReducedPlanSummary};
pub use rig::RigRun;
pub use rig_model::Modelled;
pub use rig_process::{Outside, Processed, TiltWeighing};
pub use rig_simulated::{SimulatedRun, SimulatedSummary};
pub use rig_spec::{EnvelopeSpec, HoldSpec, MountSpec, ProcessSpec, RigRunSpec, RigSpec};
pub use rig_together::{CombinedRuns, Evaluated, ProcessedRun, WindowedRun, subtract_still_air, together};
pub use rig_truth::RigTruthSpec;
pub use schema::{DocumentKind, Schemas};
pub use search::{CandidateSearch, SearchFound, SweepFound};
pub use search_spec::{SearchGoal, SweepSearch};
pub use shared::what_a_controller_knows;
pub use span_keys::SPAN_KEYS;
pub use spar_spec::{SparMassSpec, SparSpec, SparStationSpec};
pub use spec::{
    AeroSpec, AirSpec, FlightSpec, GoalSpec, GustSpec, PaperAeroSpec, PaperResults, ScenarioSpec, StartSpec,
};
pub use summary::{ControllerSummary, LawState, Summary};
pub use sweep::{Sweep, SweepOf};
pub use sweep_row::SweepRows;
pub use sweep_spec::{Draw, Hold, Sampling, SweepSpec};
pub use sweep_verdict::SweepCounts;
pub use tether::{
    ClockSpec, CompareSpec, Compared, Convergence, ConvergenceCell, ConvergenceRun, CoordinateSpec,
    FourierSpec, HingeSpec, Levels, MeasuredComparison, QUANTITIES, QuantitySpread, ReadTable, ReferenceSpec,
    SparSummary, StepChange, TetherCase, TetherSpec, TetherSummary, TetheredBodySpec, TetheredWingSpec,
    WindSpec, mended_in_compare,
};
pub use trim::{
    AloneSummary, Ended, FamilySpec, GaitSearch, Goal, LimitsSpec, Multiplier, RobotTrim, SearchProgress,
    SearchSpec, SearchSummary, Searched, Tried, TrimProgress, TrimSpec, TrimSummary, Trimmed, TurnSummary,
    VarySpec,
};
pub use verdict_limits::VerdictLimits;
pub use watched::{ShownSample, Watched};

use build::{Built, whole};
use doors::ChosenKinds;
use finer::SecondFlight;
use recorder::{Recorded, Recorder};
use std::ops::ControlFlow;
use std::path::Path;
use step_error::StepError;
use wingbeat_aero::Aero;
use wingbeat_flight::guide::{HeldCommands, Manoeuvre, Prepared, SearchWatch};
use wingbeat_flight::simulate::{
    Accuracy, Controller, Ending, Event, Flight, Record, Sample, Schedule, Sensors, fly_in, fly_within,
};
use wingbeat_judge::{RunLimits, Warning};
use wingbeat_math::Error;
use wingbeat_math::parallel;
use wingbeat_math::{Quat, Vec3, pitch_of_nose_up};
use wingbeat_ocp::plant::{Channel, Plant};
use wingbeat_robot::Robot;

/// Keys of a scenario that name a file to be put in their place.
const INCLUDES: [&str; 3] = ["robot", "robot.numbers", "robot.residual"];
/// What an override may change of a case of which numbers are published: it flies as before.
const BESIDE_THE_CASE: [&str; 5] =
    ["name", "paper", "limits", "flight.record_every_s", "flight.record_strips_every_s"];

/// A checked scenario, ready to fly.
#[derive(Debug)]
pub struct Scenario {
    /// What the files and overrides said.
    pub spec: ScenarioSpec,
    /// The merged configuration as TOML; flies the same flight.
    pub resolved: String,
    document: Document,
    choice: ChosenKinds,
    robot: Robot,
    model: Robot,
    schedule: Schedule,
    samples_per_strips: Option<usize>,
    /// What its verdict rests on.
    limits: RunLimits,
    /// What its controller shares with others.
    prepared: Option<Prepared>,
}

/// Who sees the samples of a flight, and may stop it.
type FlightObserver<'a> = &'a mut dyn FnMut(&Sample) -> ControlFlow<()>;

/// A flown scenario.
#[derive(Clone, Debug)]
pub struct Run {
    /// Time histories.
    pub record: Record,
    /// Loads of the strips, one row per strip and instant,
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
        Self::new(Document::file(path)?.overridden(overrides))
    }

    /// Merges and checks a scenario from files or memory. Its key `robot` names a file, or holds the robot.
    ///
    /// ```no_run
    /// use std::path::Path;
    /// use wingbeat_config::{Document, Scenario, ScenarioSpec};
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
        Self::open(document, &Doors::shipped())
    }

    /// As [`new`](Self::new), with manoeuvres, controllers and horizon solvers of one's own.
    ///
    /// # Errors
    /// Those of [`new`](Self::new), and what those kinds refuse.
    pub fn open(document: Document, doors: &Doors) -> Result<Self, ConfigError> {
        let document = document.merged(&INCLUDES, &|_, _| None)?;
        let mut spec: ScenarioSpec = document.parse()?;
        let mut resolved: toml::Table = document.parse()?;
        if spec.paper.is_some() && !document.overridden_only_at(&BESIDE_THE_CASE) {
            spec.paper = None;
            resolved.remove("paper");
        }
        let choice = doors.choose(&spec, &document)?;
        match spec.build(&choice).and_then(|built| Ok((built, spec.limits.limits()?))) {
            Ok((Built { robot, model, schedule, samples_per_strips }, limits)) => {
                let mut scenario = Self {
                    limits,
                    spec,
                    resolved: String::new(),
                    document,
                    choice,
                    robot,
                    model,
                    schedule,
                    samples_per_strips,
                    prepared: None,
                };
                scenario.begins().map_err(|error| scenario.explain(&error))?;
                scenario.resolve_span_keys(&mut resolved, "", &[]);
                scenario.resolved = resolved.to_string();
                Ok(scenario)
            }
            Err(error) => Err(document.explain(&error)),
        }
    }

    /// Refuses a start that is already at the perch.
    fn begins(&self) -> Result<(), Error> {
        let seen = self.robot.at_perch(&self.start());
        let begins = self.spec.perch.as_ref().zip(seen).map(|(perch, seen)| perch.begins(&seen));
        begins.unwrap_or(Ok(())).map_err(|error| error.within("perch"))
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.document.explain(error)
    }

    /// The robot that flies, in its air.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Tells `watch` how far the search is with which a controller begins a flight.
    pub fn watch_search(&mut self, watch: SearchWatch) {
        self.choice.watch = watch;
    }

    /// Limits of the verdicts on its runs.
    pub fn limits(&self) -> &RunLimits {
        &self.limits
    }

    /// The robot and air as the controller knows them.
    pub fn model(&self) -> &Robot {
        &self.model
    }

    /// Commands that the start holds.
    fn held_commands(&self) -> Vec<f64> {
        let given = |channel: &Channel| self.spec.start.commands.get(&channel.name).copied();
        self.robot.inputs().iter().map(|channel| given(channel).unwrap_or(0.0)).collect()
    }

    /// State at t = 0, in the units of its channels: at the origin, structure at rest under the commands that the start holds,
    /// still wake but for what the start says.
    pub fn start(&self) -> Vec<f64> {
        self.start_of(&self.robot)
    }

    /// The same of `robot`.
    fn start_of(&self, robot: &Robot) -> Vec<f64> {
        let (start, layout) = (&self.spec.start, robot.layout());
        let mut x = vec![0.0; layout.len];
        let [roll, yaw] = [start.roll_deg, start.yaw_deg].map(f64::to_radians);
        let pitch = pitch_of_nose_up(start.nose_up_deg);
        Quat::from_roll_pitch_yaw(roll, pitch, yaw).store_wxyz(&mut x[layout.attitude..]);
        Vec3(start.velocity_m_s).store(&mut x[layout.velocity..]);
        let coordinates = robot.start_coordinates();
        x[layout.joints..][..coordinates.len()].copy_from_slice(&coordinates);
        Vec3(start.rate_rad_s).store(&mut x[layout.rate..]);
        let held = self.held_commands();
        let gains = robot.rest_gains();
        for (y, gains) in x[layout.structure..].iter_mut().zip(gains.chunks_exact(held.len().max(1))) {
            *y = gains.iter().zip(&held).map(|(gain, held)| gain * held).sum();
        }
        let say = |x: &mut [f64]| {
            for (channel, x) in robot.states().iter().zip(x).skip(layout.joints) {
                *x = start.states.get(&channel.name).copied().unwrap_or(*x);
            }
        };
        say(&mut x);
        // A fault here is that of the first step, which tells it.
        if robot.settle(0.0, &mut x, &held).is_ok() {
            say(&mut x);
        }
        x
    }

    /// The scenario's controller at the start of a flight, if it has one.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the offending key.
    pub fn controller(&self) -> Result<Option<Box<dyn Controller + '_>>, Error> {
        self.spec.controller(&self.choice, &self.model, self.prepared.clone())
    }

    /// What its controller shares with others of the same model; none where that is nothing, or refused.
    fn prepare(&self) -> Option<Prepared> {
        let task = self.spec.task(&self.choice, &self.model);
        self.choice.controller.as_ref()?.prepare(task).ok().flatten()
    }

    /// What the scenario flies, if it says.
    pub fn manoeuvre(&self) -> Option<&dyn Manoeuvre> {
        self.choice.manoeuvre.as_deref()
    }

    /// Flies the scenario. `observe` sees every recorded sample and may stop the flight.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the controller's settings are out of range.
    pub fn fly(&self, mut observe: impl FnMut(&Sample) -> ControlFlow<()>) -> Result<Run, Error> {
        if !self.flies_again() {
            let mut pilot = self.pilot(self.prepared.clone())?;
            let halved = || self.end_in_half_steps();
            // Steps chosen by an error have measured it.
            let again = match self.spec.flight.error_m {
                None => SecondFlight::Halved(&halved),
                Some(_) => SecondFlight::Never,
            };
            return self.fly_under(&mut *pilot, self.sensors(), &self.schedule, (&mut observe, again));
        }
        // Both begin with one search.
        let prepared = self.prepared.clone().or_else(|| self.prepare());
        let mut pilot = self.pilot(prepared.clone())?;
        let (finer, first) = finer::pair();
        let again = SecondFlight::Beside(finer);
        let fly = || self.fly_under(&mut *pilot, self.sensors(), &self.schedule, (&mut observe, again));
        parallel::beside(move || self.fly_again(prepared, &first), fly)
    }

    /// The scenario's controller, with what it shares with others of the same model; without one, the commands that the start holds.
    fn pilot(&self, prepared: Option<Prepared>) -> Result<Box<dyn Controller + '_>, Error> {
        let controller = self.spec.controller(&self.choice, &self.model, prepared)?;
        Ok(controller.unwrap_or_else(|| Box::new(HeldCommands(self.held_commands()))))
    }

    /// By how much the claw in the state `x` is short of latching, dimensionless; infinite without a perch.
    fn short_of_latching(&self, x: &[f64]) -> f64 {
        let seen = self.spec.perch.as_ref().zip(self.robot.at_perch(x));
        seen.map_or(f64::INFINITY, |(perch, seen)| perch.short_of_latching(&seen))
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
    /// use wingbeat_ocp::plant::{Plant, Role};
    /// use wingbeat_config::Scenario;
    /// use wingbeat_flight::simulate::{Controller, Measurement, Update};
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
        mut observe: impl FnMut(&Sample) -> ControlFlow<()>,
    ) -> Result<Run, Error> {
        let period = whole("period_s", period_s, self.schedule.step, "steps of")?;
        let schedule = Schedule { steps_per_update: Some(period), ..self.schedule };
        let mut run = self.fly_under(controller, sensors, &schedule, (&mut observe, SecondFlight::Never))?;
        run.summary.warnings.extend(self.spec.flight.error_m.map(|_| finer::flown_once()));
        Ok(run)
    }

    /// What the scenario's controller is told of the robot.
    pub fn sensors(&self) -> Sensors {
        match &self.spec.sensors {
            Some(spec) => Sensors::of(&self.robot, spec, self.schedule.step, self.spec.seed),
            None => Sensors::perfect(&self.robot),
        }
    }

    /// Compiled once, whoever steers and watches.
    fn fly_under<'c>(
        &self,
        controller: &mut (dyn Controller + 'c),
        mut sensors: Sensors,
        schedule: &Schedule,
        (observe, again): (FlightObserver, SecondFlight),
    ) -> Result<Run, Error> {
        let rows = schedule.steps / schedule.steps_per_sample + 1;
        let mut lattice = self.lattice()?;
        // The steps of the robot alone are not those of the flight in a lattice.
        let asked_error = self.spec.flight.error_m;
        let mut error =
            (lattice.is_none() && asked_error.is_none()).then(|| StepError::new(&self.robot, schedule));
        let end = schedule.step * schedule.steps as f64;
        let reach = |t: f64, states: [&[f64]; 2]| step_error::reach(self.robot.layout(), end - t, states);
        let breaks = self.spec.air.breaks();
        let asked = asked_error.map(|error| Accuracy { error, reach: &reach, breaks: &breaks });
        let told = (&*controller, sensors.columns(schedule.steps_per_update.is_some()));
        let mut recorder = Recorder::new(&self.robot, self.manoeuvre(), told, rows, self.samples_per_strips)
            .map_err(|error| recorder::of_part(&self.spec.robot, error))?;
        recorder.beside(self.spec.perch.as_ref());
        let mut x = self.start();
        let see = |sample: &Sample, controller: &(dyn Controller + 'c)| {
            recorder.sample(sample, controller)?;
            if let Some(error) = &mut error {
                error.see(sample);
            }
            let seen = observe(sample);
            if let SecondFlight::Beside(finer) = &again {
                finer.go_on();
            }
            Ok(if recorder.latched() { ControlFlow::Break(()) } else { seen })
        };
        let (robot, sensors) = (&self.robot, &mut sensors);
        // In a lattice the claw is looked at with the records alone.
        let latches = |_: f64, x: &[f64]| self.short_of_latching(x);
        let (mut flight, coupling) = match &mut lattice {
            None => {
                let ends: (Event, _) = (&latches, asked.as_ref());
                (fly_within(robot, sensors, controller, schedule, &mut x, ends, see), None)
            }
            Some(flow) => {
                let flow = flow.as_mut();
                let (flight, coupling) = fly_in(robot, flow, sensors, controller, schedule, &mut x, see);
                (flight, Some(LatticeSummary::new(coupling, self.spec.lattice.as_ref())))
            }
        };
        recorder.complete(&mut flight);
        let measured = flight.taken.map(|taken| taken.error);
        let error = error.and_then(|error| error.at_end(flight.duration)).or(measured);
        let mut recorded = recorder.finish();
        let cut = recorded.cut(&flight.ending);
        let whole = flight.ending == Ending::Complete;
        let position = Vec3::from_slice(&x[robot.layout().position..]);
        let error = error.filter(|_| !cut);
        let errors = match again {
            SecondFlight::Never => [error, None],
            SecondFlight::Halved(end) if whole => {
                [error.map(|most| self.measured_error(most, end, position)), None]
            }
            SecondFlight::Halved(_) => [error, None],
            SecondFlight::Beside(finer) => [error, finer.distance(position).filter(|_| whole)],
        };
        let mut summary = self.summarise(&recorded, &flight, schedule, errors, coupling);
        let cautions = coupling.iter().flat_map(LatticeSummary::cautions);
        summary.warnings.extend(cautions.map(|caution| Warning::new("flight.lattice", caution)));
        summary.warnings.extend(fit::of_flown(&self.spec));
        summary.warnings.extend(self.in_vain());
        let past_stall = summary.stall_fraction;
        let surfaces = self.robot.surfaces().map(|(_, aero)| aero);
        summary.warnings.extend(unheard::side_edges(self.spec.flown_aero(), surfaces, past_stall));
        summary.warnings.extend(grounded::crossing_gusts(&self.spec.air));
        summary.warnings.extend(self.spec.near_ground(summary.ground_distance_m));
        Ok(Run { record: recorded.record, strips: recorded.strips, summary })
    }

    /// The warnings that overrides have no effect: numbers that are given by name too, keys of models that no surface has.
    fn in_vain(&self) -> Vec<Warning> {
        let mut warnings = fit::given_twice(&self.document, &self.spec);
        let models = [&self.robot, &self.model];
        let surfaces = models.into_iter().flat_map(|robot| robot.surfaces().map(|(_, aero)| aero));
        warnings.extend(unheard::in_vain(&self.document, "aero", surfaces));
        warnings
    }

    /// A word for all surfaces of `robot`: where they differ each after its surface's name, without any `plain`.
    fn named(&self, robot: &Robot, plain: &str, word: impl Fn(&Aero) -> &'static str) -> String {
        let words: Vec<(&str, &str)> = robot.surfaces().map(|(name, aero)| (name, word(aero))).collect();
        match words.first() {
            None => plain.into(),
            Some((_, first)) if words.iter().all(|(_, word)| word == first) => (*first).into(),
            _ => words.iter().map(|(name, word)| format!("{name} {word}")).collect::<Vec<_>>().join(", "),
        }
    }

    fn summarise(
        &self,
        recorded: &Recorded,
        flight: &Flight,
        schedule: &Schedule,
        [step_error_m, grown_error_m]: [Option<f64>; 2],
        lattice: Option<LatticeSummary>,
    ) -> Summary {
        let context = summary::Context {
            robot: &self.robot,
            lattice,
            strips_chord_m: self.spec.strips_chord_m(),
            panels: self.spec.lattice.as_ref().map(|spec| [spec.chordwise, spec.spanwise]),
            manoeuvre: self.manoeuvre(),
            goal: self.spec.goal.as_ref(),
            limits: self.limits.clone(),
            inputs: self.robot.inputs(),
            clearances: self.robot.clearances(),
            preset: self
                .named(&self.robot, self.spec.flown_aero().preset.name(), |aero| aero.preset().name()),
            law: self.named(&self.robot, self.spec.flown_aero().law.name(), |aero| aero.law().name()),
            means: recorded.means.as_ref(),
            period_s: schedule.steps_per_update.map(|steps| steps as f64 * schedule.step),
            step_error_m,
            asked_error_m: self.spec.flight.error_m,
            grown_error_m,
            turbulence: self.spec.turbulence(),
            path: self.spec.path.as_ref(),
            gusty: self.spec.air.gust_m_s != 0.0 || !self.spec.air.gusts.is_empty(),
            perch: self.spec.perch.as_ref(),
            wind: Vec3(self.spec.air.wind_m_s),
        };
        let mut summary = Summary::new(&recorded.record, flight, &context);
        let (lattice, surfaces) =
            (self.spec.lattice.as_ref(), || self.robot.surfaces().map(|(_, aero)| aero));
        summary.warnings.extend(unheard::of_strips(self.spec.flown_aero(), lattice, surfaces()));
        summary.warnings.extend(web::open(&self.spec.robot, &self.robot));
        // A lattice hears it whatever the preset.
        summary.warnings.extend(web::unheard(&self.spec.robot, &self.robot).filter(|_| lattice.is_none()));
        summary.warnings.extend(unheard::frictionless(&self.spec.robot, &self.robot));
        summary.warnings.extend(unheard::unlifted(&self.robot));
        summary.warnings.extend(nearness::in_pieces(&self.robot));
        summary.warnings.extend(self.spec.never_begun(&self.choice));
        summary.warnings.extend(self.spec.unweighed());
        if schedule.steps_per_update.is_none() {
            summary.warnings.extend(self.spec.unfollowed());
        }
        summary.warnings.extend(unheard::inertance(&self.spec.flight, &self.robot));
        summary.warnings.extend(lattice::soft(lattice, surfaces()));
        summary
    }
}
