//! Runs on the test rig, checked and built.

use super::rig_simulated::LOOKS;
use super::rig_spec::{HoldSpec, RigRunSpec, RunList};
use super::span_keys::{aeros, resolve};
use super::{ConfigError, Document, Doors, LatticeTask, MakeLattice, RunName, Translate, fit};
use std::path::Path;
use wingbeat_judge::{RunLimits, Warning};
use wingbeat_math::Error;
use wingbeat_math::{Mat3, NamedNumber, Vec3};
use wingbeat_ocp::plant::Fault;
use wingbeat_rig::arm::{LimitProfile, Payload, SerialArm};
use wingbeat_rig::carrier::{CellMount, ToolCarrier};
use wingbeat_rig::plan::{ArmApproach, Envelope, Margins, PlacementWorkspace, Refusal, TurnPlan, TurnSpec};
use wingbeat_rig::{BenchDeviations, Experiment, Outcome, Pose, RigNumbers};
use wingbeat_robot::{FittedModel, Robot};

/// A checked run.
#[derive(Debug)]
pub struct RigRun {
    /// What the files and overrides said.
    pub spec: RigRunSpec,
    /// The merged configuration as TOML.
    pub resolved: String,
    document: Document,
    /// The robot in its air.
    pub robot: Robot,
    /// The same without the motor that turns its crank, where it has one.
    without_motor: Option<Robot>,
    /// The arm.
    pub arm: SerialArm,
    /// Its limits.
    pub profile: LimitProfile,
    /// Cell and mount as they are.
    pub mount: CellMount,
    /// Cell and mount as drawn.
    drawn: CellMount,
    /// How the rig differs from that.
    pub(super) numbers: RigNumbers,
    /// Limits of its verdicts.
    pub limits: RunLimits,
    /// What makes the air of a lattice.
    lattice: Option<MakeLattice>,
}

/// Part of the reach of a robot by which it may leave its envelope. *Choice*: the outline of the shipped one is 0.11 off.
const BEYOND: f64 = 0.15;

impl RigRun {
    /// Keys of a run that name a file to be put in their place, outer ones first.
    pub const FILES: [&str; 5] = ["rig", "rig.robot", "rig.robot.numbers", "rig.robot.residual", "rig.arm"];

    /// Reads, merges and checks a run; `overrides` are `key=value`.
    ///
    /// # Errors
    /// One message with file, line, key, the value given and what is allowed.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, ConfigError> {
        Self::new(Document::file(path)?.overridden(overrides), &|_, _| None)
    }

    /// Merges and checks a run from files or memory; `translate` reads arms that are not written in TOML.
    ///
    /// ```no_run
    /// use std::path::Path;
    /// use wingbeat_config::{Document, RigRun};
    ///
    /// let rig = Document::file(Path::new("rigs/aerobat_on_gen3.toml"))?;
    /// let text = "name = \"bank\"\n[turn]\nspeed_m_s = 0.8\nroll_deg = 15.0\nnose_up_deg = 15.0\nmeasured_s = 0.86";
    /// let run = RigRun::new(Document::text("bank", text)?.put("rig", rig)?, &|_, _| None)?;
    /// match run.plan()? {
    ///     Ok(plan) => println!("{}", plan.report(&run.arm, &run.profile)),
    ///     Err(refusal) => println!("{refusal}"),
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Messages with the place, the key, the value given and what is allowed.
    pub fn new(document: Document, translate: Translate) -> Result<Self, ConfigError> {
        let document = document.merged(&RigRun::FILES, translate)?;
        let spec: RigRunSpec = document.parse()?;
        let resolved = document.parse()?;
        Self::build(spec, resolved, document.clone()).map_err(|error| document.explain(&error))
    }

    /// The runs of a document: itself, or those that it lists, `runs = ["a.toml", ...]`, each with `overrides`. A run
    /// without a seed gets its number, from 0; an override of the seed is that of the first run.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); two runs of one name.
    pub fn load_all(
        list: Document,
        overrides: &[String],
        translate: Translate,
    ) -> Result<Vec<Self>, ConfigError> {
        if list.written("runs").is_none() {
            return Ok(vec![Self::new(seeded(list, overrides, 0), translate)?]);
        }
        let names = list.parse::<RunList>()?.runs;
        let mut runs: Vec<Self> = Vec::with_capacity(names.len());
        for k in 0..names.len() {
            let run = Self::new(seeded(list.part(&format!("runs[{k}]"))?, overrides, k as u64), translate)?;
            let name = &run.spec.name;
            if runs.iter().any(|earlier| earlier.spec.name.eq_ignore_ascii_case(name)) {
                let error = Error::invalid(format!("runs[{k}]"), name, "a run whose name no other one has");
                return Err(list.explain(&error));
            }
            runs.push(run);
        }
        Ok(runs)
    }

    /// The run in the air of a lattice, where it asks for one and `doors` have it.
    #[must_use]
    pub fn through(self, doors: &Doors) -> Self {
        Self { lattice: doors.makes_lattice(), ..self }
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.document.explain(error)
    }

    fn build(spec: RigRunSpec, mut resolved: toml::Table, document: Document) -> Result<Self, Error> {
        RunName::new("name", &spec.name)?;
        spec.in_range()?;
        spec.check_frequency()?;
        spec.process.check().map_err(|e| e.within("process"))?;
        spec.hold.as_ref().map_or(Ok(()), HoldSpec::check).map_err(|e| e.within("hold"))?;
        spec.turn.as_ref().map_or(Ok(()), TurnSpec::check).map_err(|e| e.within("turn"))?;
        if spec.turn.is_some() == spec.hold.is_some() {
            let given = if spec.turn.is_some() { "turn and hold" } else { "neither" };
            return Err(Error::invalid("turn", given, "either [turn] or [hold]"));
        }
        spec.rig.check().map_err(|e| e.within("rig"))?;
        spec.check_samples()?;
        spec.lattice_samples()?;
        let (profile, key) = match &spec.profile {
            Some(profile) => (profile, "profile"),
            None => (&spec.rig.profile, "rig.profile"),
        };
        let drawn = spec.rig.mount.drawn();
        let given = RigNumbers::of(&drawn).given(&spec.rig.robot.numbers);
        let numbers = given.map_err(|e| e.within("rig.robot"))?;
        let mount = numbers.mount(&drawn);
        let robot = spec.robot()?;
        spec.check_inertia()?;
        let without_motor = robot.motor().map(|_| spec.without_motor().robot()).transpose()?;
        resolve(&mut resolved, "rig.aero", aeros(&robot));
        Ok(Self {
            robot,
            without_motor,
            arm: spec.rig.arm.build().map_err(|e| e.within("rig.arm"))?,
            profile: spec.rig.arm.profile(profile).map_err(|e| e.renamed(&[("profile", key)]))?,
            mount,
            drawn,
            numbers,
            lattice: None,
            limits: spec.limits.limits()?,
            resolved: resolved.to_string(),
            document,
            spec,
        })
    }

    /// What is said of the fit that the numbers of its robot are from, and of overrides that they make vain.
    pub fn of_fit(&self) -> impl Iterator<Item = Warning> {
        let of = fit::of_numbers("rig.robot.numbers", &self.spec.rig.robot.numbers, &self.fitted_model());
        of.chain(fit::given_twice_on_rig(&self.document, &self.spec))
    }

    /// The model that numbers that are fitted to it are of.
    pub fn fitted_model(&self) -> FittedModel {
        fit::model_of(&self.spec.rig.robot, &self.spec.rig.aero)
    }

    /// Flapping frequency, Hz.
    pub fn frequency(&self) -> f64 {
        self.spec.frequency_hz.unwrap_or_else(|| self.spec.rig.robot.gait.frequency_hz())
    }

    /// Cell and mount as the rig's file draws them, without the numbers that say how they are.
    pub fn mount_as_drawn(&self) -> CellMount {
        self.drawn
    }

    /// The robot with its crank at the gait's clock: where an encoder says how the crank turned, no motor does.
    pub fn cranked(&self) -> &Robot {
        self.without_motor.as_ref().unwrap_or(&self.robot)
    }

    /// Body in the tool frame, X_TB.
    fn body_in_tool(&self) -> Pose {
        self.mount.cell * self.mount.body
    }

    /// Mount and robot as one payload in the tool frame.
    fn payload(&self) -> Payload {
        let robot = self.robot.mass();
        let mass = robot + self.mount.mass;
        let at = self.mount.cell.point(self.mount.com) * self.mount.mass + self.body_in_tool().origin * robot;
        Payload { mass, com: at * (1.0 / mass), inertia: Mat3::ZERO, radius: 0.0 }
    }

    /// Plans the run's turn.
    ///
    /// # Errors
    /// A run without a turn, or bad numbers in it.
    pub fn plan(&self) -> Result<Result<TurnPlan, Refusal>, Error> {
        let Some(turn) = &self.spec.turn else {
            return Err(Error::invalid("turn", "absent", "a [turn] to plan"));
        };
        let (payload, envelope) = (self.payload(), self.envelope());
        self.check_reach(&envelope)?;
        self.workspace(&payload, &envelope).plan(turn)
    }

    /// The motion from rest at `from` (rad) to the begin of `plan`.
    ///
    /// # Errors
    /// A pose outside the joint limits.
    pub fn approach(&self, from: &[f64], plan: &TurnPlan) -> Result<Result<ArmApproach, Refusal>, Error> {
        let (payload, envelope) = (self.payload(), self.envelope());
        let Some(start) = plan.trajectory.position.first() else {
            return Err(Error::invalid("plan", "no points", "a plan with points"));
        };
        self.workspace(&payload, &envelope).approach(from, start)
    }

    fn envelope(&self) -> Envelope {
        let e = self.spec.rig.envelope;
        Envelope::fan(e.half_span_m, e.low_rad, e.high_rad, e.front_m, e.back_m)
    }

    /// Refuses an envelope beyond which the robot reaches by more than the clearance that is asked, or a part of its reach, along the
    /// directions of a cube's corners, edges and faces: the arm would be planned through its wings.
    fn check_reach(&self, envelope: &Envelope) -> Result<(), Error> {
        let frequency = self.frequency();
        let looks = if frequency > 0.0 { LOOKS } else { 1 };
        let mut points = Vec::new();
        for k in 0..looks {
            let t = k as f64 / (looks as f64 * frequency.max(f64::MIN_POSITIVE));
            // A gait that cannot be posed is refused where it is flapped.
            let Ok(robot) = self.cranked().at_rest(t) else { return Ok(()) };
            points.extend(robot.outlines.iter().flat_map(|outline| outline.ribs.iter().flatten().copied()));
        }
        let most = |of: &[Vec3], along: Vec3| of.iter().map(|p| p.dot(along)).fold(f64::MIN, f64::max);
        let (mut beyond, mut where_) = (0.0, Vec3::ZERO);
        for k in (0..27).filter(|k| *k != 13) {
            let of = |by: i32| f64::from(k / by % 3 - 1);
            let along = Vec3([of(1), of(3), of(9)]).unit();
            let over = most(&points, along) - most(&envelope.points, along);
            if over > beyond {
                (beyond, where_) = (over, along);
            }
        }
        let reach = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
        let clearance = self.spec.rig.clearance_m.max(BEYOND * reach);
        if points.is_empty() || beyond <= clearance {
            return Ok(());
        }
        let [x, y, z] = where_.0;
        let allowed = format!(
            "an envelope that holds the surfaces of the robot over a cycle but for {clearance:.3} m: they reach {beyond:.3} m beyond it \
             along ({x:.1}, {y:.1}, {z:.1}) of the body"
        );
        let half_span = self.spec.rig.envelope.half_span_m;
        Err(Error::invalid("rig.envelope.half_span_m", half_span, allowed).against(["rig.clearance_m"]))
    }

    fn workspace<'a>(&'a self, payload: &'a Payload, envelope: &'a Envelope) -> PlacementWorkspace<'a> {
        let rig = &self.spec.rig;
        PlacementWorkspace {
            arm: &self.arm,
            profile: &self.profile,
            payload,
            body: self.body_in_tool(),
            envelope,
            table: rig.table_m,
            margins: Margins { singularity: rig.singularity_margin, clearance: rig.clearance_m },
        }
    }

    /// What carries the robot in this run; a turn needs its `plan`.
    pub fn carrier(&self, plan: Option<&TurnPlan>) -> ToolCarrier {
        match (&self.spec.hold, plan) {
            (None, Some(plan)) => {
                ToolCarrier::Arm { arm: Box::new(self.arm.clone()), trajectory: plan.trajectory.clone() }
            }
            (Some(hold), _) => ToolCarrier::Stand { holds: self.holds(hold) },
            (None, None) => ToolCarrier::Stand { holds: vec![(0.0, Pose::IDENTITY)] },
        }
    }

    fn holds(&self, hold: &HoldSpec) -> Vec<(f64, Pose)> {
        let tool_in_body = self.body_in_tool().inverse();
        let tool = |[roll, pitch]: [f64; 2]| {
            let rotation = Mat3::from_roll_pitch_yaw(roll.to_radians(), pitch.to_radians(), 0.0);
            Pose { rotation, origin: Vec3::ZERO } * tool_in_body
        };
        hold.tilts_deg.iter().enumerate().map(|(k, tilt)| (k as f64 * hold.each_s, tool(*tilt))).collect()
    }

    /// Duration after the rest, s.
    pub fn duration(&self, carrier: &ToolCarrier) -> f64 {
        carrier.duration() + self.spec.hold.as_ref().map_or(0.0, |hold| hold.each_s)
    }

    /// Begin and end of what is averaged, s.
    pub fn window(&self, plan: Option<&TurnPlan>, carrier: &ToolCarrier) -> (f64, f64) {
        match plan {
            Some(plan) => plan.measured,
            None => (self.spec.rig.spin_up_s, self.duration(carrier)),
        }
    }

    /// Simulates the run; `progress` hears the share that is done.
    ///
    /// # Errors
    /// Bad numbers; a fault of the model comes back with its time.
    pub fn simulate(
        &self,
        carrier: &ToolCarrier,
        seed: u64,
        progress: impl FnMut(f64),
    ) -> Result<Result<Outcome, Fault>, Error> {
        self.simulate_in(&self.experiment(&self.robot, self.numbers, carrier, seed), progress)
    }

    /// Simulates `experiment`, in the lattice where the run asks for one.
    pub(super) fn simulate_in(
        &self,
        experiment: &Experiment,
        progress: impl FnMut(f64),
    ) -> Result<Result<Outcome, Fault>, Error> {
        let (Some(spec), Some(every)) = (&self.spec.lattice, self.spec.lattice_samples()?) else {
            return experiment.simulate(None, progress);
        };
        let task = LatticeTask {
            spec,
            robot: experiment.robot,
            outlines: experiment
                .robot
                .surface_outlines(&self.spec.rig.robot)
                .map_err(|e| e.within("rig.robot"))?,
            density_kg_m3: experiment.robot.density(),
            every,
            steps: experiment.samples().div_ceil(every),
        };
        experiment.simulate(Some(task.air(self.lattice)?.as_mut()), progress)
    }

    /// The run with `robot` and rig as these numbers say, ready to be simulated.
    pub fn experiment<'a>(
        &'a self,
        robot: &'a Robot,
        numbers: RigNumbers,
        carrier: &'a ToolCarrier,
        seed: u64,
    ) -> Experiment<'a> {
        Experiment {
            robot,
            carrier,
            mount: &self.drawn,
            numbers,
            cell: &self.spec.rig.cell,
            seed,
            rest: self.spec.rig.rest_s,
            duration: self.duration(carrier),
            flapping: self.frequency() > 0.0,
            spin_up: self.spec.rig.spin_up_s,
            deviations: BenchDeviations::default(),
        }
    }

    /// The run as another one whose files say this too, `key=value`.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub(super) fn overridden(&self, texts: &[String]) -> Result<Self, ConfigError> {
        let run = Self::new(self.document.clone().overridden(texts), &|_, _| None)?;
        Ok(Self { lattice: self.lattice, ..run })
    }

    /// Names and values of the numbers of robot and rig that a fit can find, in their declared units.
    pub fn named_numbers(&self) -> Vec<(String, f64)> {
        self.parameters().into_iter().map(|number| (number.name, number.value)).collect()
    }

    /// The same with what is declared of them.
    pub fn parameters(&self) -> Vec<NamedNumber> {
        let mut named = self.robot.parameters();
        named.extend(self.numbers.parameters());
        named
    }

    /// Robot and rig with other numbers, in their declared units; names as for [`Robot::adjusted`]. A fit tries many: the
    /// values are not checked.
    ///
    /// # Errors
    /// An unknown name.
    pub fn adjusted(&self, to: &[(&str, f64)]) -> Result<(Robot, RigNumbers), Error> {
        let (rig, robot): (Vec<_>, Vec<_>) =
            to.iter().copied().partition(|(name, _)| RigNumbers::names_one(name));
        let mut numbers = self.numbers;
        rig.iter().try_for_each(|(name, value)| numbers.set(name, *value))?;
        Ok((self.robot.with(&self.robot.given(&robot)?)?, numbers))
    }

    /// Refuses numbers, in their declared units, that no robot has, as [`Robot::adjusted`] does.
    ///
    /// # Errors
    /// An unknown name, a value that cannot be.
    pub fn check(&self, to: &[(&str, f64)]) -> Result<(), Error> {
        let robot: Vec<_> = to.iter().copied().filter(|(name, _)| !RigNumbers::names_one(name)).collect();
        self.robot.adjusted(&robot).map(drop)
    }
}

/// A run with `overrides` and a seed: that of an override plus `number`, its own, or `number`.
fn seeded(document: Document, overrides: &[String], number: u64) -> Document {
    let seed = |text: &String| {
        text.split_once('=').filter(|(key, _)| key.trim() == "seed").map(|(_, v)| v.trim().parse())
    };
    let given: Option<u64> = overrides.iter().rev().find_map(seed).and_then(Result::ok);
    let own = document.written("seed").is_some();
    let document = document.overridden(overrides);
    match given {
        Some(first) => document.set(format!("seed={}", first.saturating_add(number))),
        None if own || overrides.iter().any(|text| seed(text).is_some()) => document,
        None => document.set(format!("seed={number}")),
    }
}
