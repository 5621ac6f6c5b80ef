//! From what a scenario says to robots, aerodynamic models and clocks.

use super::chosen::Chosen;
use super::doors::ChosenKinds;
use super::mismatch::Mismatch;
use super::name::RunName;
use super::plan::PlanSpec;
use super::recorder::check_columns;
use super::spec::{AeroSpec, GustSpec, ScenarioSpec, StartSpec};
use wingbeat_aero::{
    Aero, LiftLaw, LiftingLine, LiftingLineSettings, Preset, SectionSettings, StripModel, StripSettings,
};
use wingbeat_flight::guide::{ControllerTask, ORBIT_STEP, Prepared};
use wingbeat_flight::simulate::{Controller, Schedule, SensorSpec, follow};
use wingbeat_math::Error;
use wingbeat_math::Vec3;
use wingbeat_math::names::one_of;
use wingbeat_math::require;
use wingbeat_ocp::plant::Plant;
use wingbeat_robot::{
    Air, Dryden, Pulse, Robot, RobotSpec, SurfaceOutline, Wind, counts_on_rig_alone, stands_for,
};

/// Largest number of records of a flight: 1 GB in memory.
const MAX_SAMPLES: usize = 500_000;
/// Largest number of rows of a flight's strips: 1 GB in memory.
const MAX_STRIP_ROWS: usize = 5_000_000;
/// Most steps of a flight: about twenty minutes of computing.
const MAX_STEPS: usize = 1_000_000_000;

/// What a scenario describes.
pub(super) struct Built {
    /// The robot that flies.
    pub robot: Robot,
    /// The robot as its controller knows it.
    pub model: Robot,
    /// The clock.
    pub schedule: Schedule,
    /// Samples between the records of the strips.
    pub samples_per_strips: Option<usize>,
}

impl ScenarioSpec {
    /// The checked name.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key `name`.
    pub fn run_name(&self) -> Result<RunName, Error> {
        RunName::new("name", &self.name)
    }

    /// Checks and builds; keys of errors are those of the scenario.
    pub(super) fn build(&self, choice: &ChosenKinds) -> Result<Built, Error> {
        self.check()?;
        let mut model = self.known_robot()?;
        let own_air = self.mismatch.as_ref().is_some_and(|mismatch| mismatch.aero.is_some());
        let own_numbers = self.mismatch.as_ref().is_some_and(|mismatch| mismatch.numbers.is_some());
        let robot = self.flown_robot().map_err(|error| {
            let Error::Invalid { key, .. } = &error;
            if own_air && key.starts_with("aero.") {
                return error.within("mismatch");
            }
            if own_numbers && key.starts_with("robot.numbers.") {
                return error.renamed(&[("robot.numbers", "mismatch.numbers")]);
            }
            let allowed = format!("what leaves a robot that can be built; with it {error}");
            Error::invalid("mismatch", "given", allowed)
                .against(Mismatch::KEYS.map(|key| format!("mismatch.{key}")))
        })?;
        let mut robot = self.over_ground(robot)?;
        check_columns(&self.robot, &robot)?;
        let trim = self.trim.as_ref().map_or(0.0, |trim| trim.step_s);
        let orbit = if choice.controller.is_some() { ORBIT_STEP } else { 0.0 };
        self.follow(&mut model, self.flight.step_s.max(trim).max(orbit));
        // Steps of a stated error shorten by themselves.
        let step = if self.flight.error_m.is_some() { 0.0 } else { self.flight.step_s };
        self.follow(&mut robot, step);
        self.start.check(&robot).map_err(|e| e.within("start"))?;
        let schedule = self.schedule(choice)?;
        let samples_per_strips = self.samples_per_strips(&schedule, &robot)?;
        self.check_controller(choice, &model)?;
        self.lattice_steps(&schedule)?;
        Ok(Built { robot, model, schedule, samples_per_strips })
    }

    /// Gives `robot` the inertance that `flight.inertance_s` says, or that steps of `step` s need. Where it fails at rest, the run does, and says
    /// why.
    fn follow(&self, robot: &mut Robot, step: f64) {
        let _ = match self.flight.inertance_s {
            Some(time) => robot.set_inertance(time),
            None => follow(robot, step),
        };
    }

    /// The controller of `model`, if the scenario has one.
    pub(super) fn controller<'a>(
        &self,
        choice: &ChosenKinds,
        model: &'a Robot,
        prepared: Option<Prepared>,
    ) -> Result<Option<Box<dyn Controller + 'a>>, Error> {
        let Some(spec) = &choice.controller else { return Ok(None) };
        let task = ControllerTask { prepared, ..self.task(choice, model) };
        spec.build(task).map(Some).map_err(|e| self.of_controller(e))
    }

    /// Refuses what a controller of `model` cannot be made of.
    fn check_controller(&self, choice: &ChosenKinds, model: &Robot) -> Result<(), Error> {
        let Some(spec) = &choice.controller else { return Ok(()) };
        if self.sensors.as_ref().is_some_and(SensorSpec::reads) && !spec.reads_instruments() {
            let allowed = "no instruments: this controller is told states; controller.orbit with an estimator reads them";
            return Err(Error::invalid("sensors", "given", allowed));
        }
        if self.path.is_some() && !spec.follows_path() {
            let allowed = "no path: this controller follows none; controller.orbit with tracking does";
            return Err(Error::invalid("path", "given", allowed));
        }
        spec.check(self.task(choice, model)).map_err(|e| self.of_controller(e))
    }

    /// What a controller of `model` is made for.
    pub(super) fn task<'a>(&self, choice: &ChosenKinds, model: &'a Robot) -> ControllerTask<'a> {
        let (manoeuvre, solver) = (choice.manoeuvre.clone(), choice.solver.clone());
        let (sensors, path) = (self.sensors.clone(), self.path.clone());
        let perch = self.perch.as_ref().map(|perch| perch.beside(model));
        ControllerTask {
            model,
            manoeuvre,
            solver,
            sensors,
            path,
            perch,
            prepared: None,
            watch: choice.watch.clone(),
        }
    }

    /// An error of the controller's settings, of its solver's, or of the gait that it is made for.
    fn of_controller(&self, error: Error) -> Error {
        let table = self.controller_table();
        let gait = format!("robot.gait.{}", self.robot.gait.kind());
        let path = (format!("{table}.tracking.path"), "path".into());
        // What a controller refuses of its robot stands in the robot's tables.
        let of_robot = ["drive", "structure", "surfaces", "thrusters"]
            .map(|key| (format!("{table}.{key}"), format!("robot.{key}")));
        let solver = self.solver.as_ref().map_or("solver".into(), |named| format!("solver.{}", named.name));
        let wind = (format!("{table}.wind_m_s"), "air.wind_m_s".into());
        let own = [(format!("{table}.gait"), gait), path, (format!("{table}.solver"), solver), wind];
        error.within(&table).renamed(&[own.as_slice(), &of_robot].concat())
    }

    /// Key of the table that the manoeuvre is made of.
    pub(super) fn manoeuvre_table(&self) -> String {
        match &self.manoeuvre {
            Some(Chosen::Own(named)) => format!("manoeuvre.{}", named.name),
            _ => "manoeuvre".into(),
        }
    }

    /// Key of the table that the controller is made of.
    pub(super) fn controller_table(&self) -> String {
        match &self.controller {
            Some(Chosen::Own(named)) => format!("controller.{}", named.name),
            _ => "controller".into(),
        }
    }

    fn check(&self) -> Result<(), Error> {
        self.run_name()?;
        self.robot.check().map_err(|e| e.within("robot"))?;
        self.air.check().map_err(|e| e.within("air"))?;
        self.flight.in_range().map_err(|e| e.within("flight"))?;
        if let (Some(error), Some(_)) = (self.flight.error_m, &self.lattice) {
            let allowed = "none beside [lattice], whose wake is shed in equal steps";
            return Err(Error::invalid("flight.error_m", error, allowed).against(["lattice.step_s"]));
        }
        self.start.in_range().map_err(|e| e.within("start"))?;
        self.aero.check().map_err(|e| e.within("aero"))?;
        if let Some(goal) = &self.goal {
            goal.check().map_err(|e| e.within("goal"))?;
        }
        if let Some(sensors) = &self.sensors {
            sensors.check().map_err(|e| e.within("sensors"))?;
            self.check_readings(sensors)?;
        }
        if let Some(path) = &self.path {
            path.build().map_err(|e| e.within("path"))?;
        }
        if let Some(perch) = &self.perch {
            perch.check().map_err(|e| e.within("perch"))?;
            let seen = perch.seen_by(self.flight.step_s, self.flight.record_every_s);
            let seen = seen.map_err(|e| e.within("perch"));
            seen.map_err(|e| e.against(["flight.step_s", "flight.record_every_s"]))?;
        }
        if let Some(mismatch) = &self.mismatch {
            mismatch.check(&self.robot).map_err(|e| e.within("mismatch"))?;
        }
        if let Some(trim) = &self.trim {
            trim.check().map_err(|e| e.within("trim"))?;
        }
        if let Some(plan) = &self.plan {
            plan.check().map_err(|e| e.within("plan"))?;
        }
        let vacuum = self.air.density_kg_m3 == 0.0;
        let played = matches!(&self.controller, Some(Chosen::Own(named)) if named.name == "commands");
        let turned = matches!(&self.plan, Some(PlanSpec::Reorientation(_)));
        if vacuum && !played && !turned {
            let allowed = "above 0; a vacuum, 0, beside [plan.reorientation] or [controller.commands]";
            return Err(Error::invalid("air.density_kg_m3", 0.0, allowed));
        }
        if vacuum && self.lattice.is_some() {
            let allowed = "none in a vacuum (air.density_kg_m3 = 0)";
            return Err(Error::invalid("lattice", "given", allowed).against(["air.density_kg_m3"]));
        }
        if vacuum && !self.robot.thrusters.is_empty() {
            let allowed = "none in a vacuum (air.density_kg_m3 = 0), where propellers have nothing to push";
            return Err(Error::invalid("robot.thrusters", "given", allowed).against(["air.density_kg_m3"]));
        }
        if let Some(PlanSpec::RollIn(plan)) = &self.plan {
            let checked = require::at_most("plan.roll_in.start_s", plan.start_s, self.flight.duration_s);
            checked.map_err(|e| e.against(["flight.duration_s"]))?;
        }
        Ok(())
    }

    /// That the times between readings are whole steps.
    fn check_readings(&self, sensors: &SensorSpec) -> Result<(), Error> {
        let every = [
            ("imu", sensors.imu.as_ref().map(|imu| imu.every_s)),
            ("height", sensors.height.as_ref().map(|height| height.every_s)),
            ("airspeed", sensors.airspeed.as_ref().map(|airspeed| airspeed.every_s)),
        ];
        for (name, every) in every.into_iter().filter_map(|(name, every)| Some((name, every?))) {
            let steps = whole(&format!("sensors.{name}.every_s"), every, self.flight.step_s, "steps of");
            steps.map_err(|e| e.against(["flight.step_s"]))?;
        }
        Ok(())
    }

    /// The robot that flies: mismatch and gust included.
    fn flown_robot(&self) -> Result<Robot, Error> {
        let mismatch = self.mismatch.clone().unwrap_or_default();
        let pulse = |gust: &GustSpec| Pulse {
            start: gust.start_s,
            duration: gust.duration_s,
            velocity: Vec3(gust.velocity_m_s),
        };
        let mut wind = Wind::gusty(Vec3(self.air.wind_m_s), self.air.gust_m_s, self.seed)
            .with(self.air.gusts.iter().map(pulse));
        if let Some(spec) = &self.air.dryden {
            let duration = self.flight.duration_s;
            let of = spec.turbulence(duration).map_err(|e| e.within("air.dryden"))?;
            wind = wind.turbulent(&of, self.start.yaw_deg.to_radians(), duration, self.seed);
        }
        let mut real = mismatch.apply(&self.robot);
        if self.lattice.is_some() {
            real.residual = None;
        }
        let air = Air { density: self.air.density_kg_m3, wind };
        let robot = self.robot_in(&real, self.flown_aero(), air, Some(&mismatch))?;
        let perch = self.perch.as_ref().map(|perch| perch.beside(&robot));
        Ok(match perch {
            Some(perch) => robot.beside(perch),
            None => robot,
        })
    }

    /// The turbulence of its air.
    pub(super) fn turbulence(&self) -> Option<Dryden> {
        self.air.dryden.as_ref()?.turbulence(self.flight.duration_s).ok()
    }

    /// The robot as its controller knows it.
    pub(super) fn known_robot(&self) -> Result<Robot, Error> {
        let wind = Wind::steady(Vec3(self.air.wind_m_s));
        self.robot_in(&self.robot, &self.aero, Air { density: self.air.density_kg_m3, wind }, None)
    }

    /// The aerodynamics of the robot that flies.
    pub(super) fn flown_aero(&self) -> &AeroSpec {
        self.mismatch.as_ref().and_then(|mismatch| mismatch.aero.as_ref()).unwrap_or(&self.aero)
    }

    fn robot_in(
        &self,
        spec: &RobotSpec,
        aero: &AeroSpec,
        air: Air,
        mismatch: Option<&Mismatch>,
    ) -> Result<Robot, Error> {
        let mut spec = spec.clone();
        spec.numbers.retain(|name, _| !counts_on_rig_alone(name));
        if !self.flight.flapping {
            spec.hold_still();
        }
        robot(&spec, aero, air, self.start.phase_rad, mismatch)
    }

    /// Whole samples between the records of the strips.
    fn samples_per_strips(&self, schedule: &Schedule, robot: &Robot) -> Result<Option<usize>, Error> {
        let Some(every) = self.flight.record_strips_every_s else { return Ok(None) };
        let key = "flight.record_strips_every_s";
        let samples = whole(key, every, self.flight.record_every_s, "records every")
            .map_err(|e| e.against(["flight.record_every_s"]))?;
        let strips: usize = robot.surfaces().map(|(_, aero)| aero.strips()).sum();
        let rows = strips.saturating_mul(schedule.steps / schedule.steps_per_sample / samples + 1);
        if rows > MAX_STRIP_ROWS {
            let allowed = format!("at most {MAX_STRIP_ROWS} rows of strips; these make {rows}");
            return Err(Error::invalid(key, every, allowed).against(["flight.duration_s"]));
        }
        Ok(Some(samples))
    }

    /// Whole steps for duration, updates and records.
    fn schedule(&self, choice: &ChosenKinds) -> Result<Schedule, Error> {
        let flight = &self.flight;
        let step = flight.step_s;
        let whole = |key: &str, time: f64| {
            whole(key, time, step, "steps of").map_err(|e| e.against(["flight.step_s"]))
        };
        let period_key = format!("{}.period_s", self.controller_table());
        let period = choice.controller.as_ref().map(|c| whole(&period_key, c.period_s()));
        let schedule = Schedule {
            step,
            steps: whole("flight.duration_s", flight.duration_s)?,
            steps_per_update: period.transpose()?,
            steps_per_sample: whole("flight.record_every_s", flight.record_every_s)?,
        };
        if schedule.steps > MAX_STEPS {
            let allowed = format!("long enough for at most {MAX_STEPS} steps of the flight");
            return Err(Error::invalid("flight.step_s", step, allowed).against(["flight.duration_s"]));
        }
        let samples = schedule.steps / schedule.steps_per_sample;
        if samples > MAX_SAMPLES {
            let allowed = format!("at most {MAX_SAMPLES} records; these make {samples}");
            let error = Error::invalid("flight.record_every_s", flight.record_every_s, allowed);
            return Err(error.against(["flight.duration_s", "flight.step_s"]));
        }
        Ok(schedule)
    }
}

impl StartSpec {
    /// That the states and commands by name are there, finite and within their limits.
    fn check(&self, robot: &Robot) -> Result<(), Error> {
        let first = robot.layout().joints;
        let states = &robot.states()[first..];
        for (table, given, channels) in
            [("states", &self.states, states), ("commands", &self.commands, robot.inputs())]
        {
            for (name, value) in given {
                let key = format!("{table}.{name}");
                let Some(channel) = channels.iter().find(|channel| channel.name == *name) else {
                    let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
                    let none = format!("{} (without any: --set start.{table}={{}})", one_of(name, &names));
                    return Err(Error::invalid(key, value, none));
                };
                require::finite(&key, &[*value])?;
                require::between(&key, *value, channel.low, channel.high)?;
            }
        }
        Ok(())
    }
}

/// How many times `unit` (s) goes into `time`, if it does; `units` names it.
pub(super) fn whole(key: &str, time: f64, unit: f64, units: &str) -> Result<usize, Error> {
    let count = (time / unit).round();
    if count >= 1.0 && (count * unit - time).abs() <= 1e-9 * time {
        return Ok(count as usize);
    }
    Err(Error::invalid(key, time, format!("a whole number of {units} {unit} s, at least one")))
}

/// A robot in air, with the numbers that its file gives by name, and then as the `mismatch` has it; keys of errors begin with
/// `robot`, `aero` and `air`.
pub(super) fn robot(
    spec: &RobotSpec,
    aero: &AeroSpec,
    air: Air,
    phase: f64,
    mismatch: Option<&Mismatch>,
) -> Result<Robot, Error> {
    spec.check().map_err(|e| e.within("robot"))?;
    let vacuum = air.density == 0.0;
    // The models of the surfaces are checked in any air, and then taken away.
    let air = Air { density: if vacuum { 1.0 } else { air.density }, ..air };
    let outlines = spec.outlines().map_err(|e| e.within("robot"))?;
    let both = aero.has_both_kinds(&outlines);
    let model = |outline: &SurfaceOutline| {
        let key = format!("robot.{}", outline.key);
        let mut names = vec![
            ("half_span", format!("{key}.planform[{}].arc_m", outline.planform.stations() - 1)),
            ("hinge_arcs_m[0]", format!("{key}.shoulder_m[1]")),
            ("hinge_arcs_m[1]", format!("{key}.proximal.length_m")),
            ("gaps", format!("{key}.gaps")),
            ("membrane", format!("{key}.membrane")),
            ("flap", format!("{key}.flap")),
            ("density_kg_m3", "air.density_kg_m3".into()),
        ];
        if outline.strips.is_some() {
            names.extend(["strips", "nodes"].map(|name| (name, format!("{key}.strips"))));
        }
        names.push(("drag", key));
        aero.build(outline, air.density, both, &names)
    };
    let models = outlines.iter().map(model).collect::<Result<_, _>>()?;
    let robot = Robot::new(spec, models, air, phase).map_err(|e| {
        let error = e.within("robot");
        let Error::Invalid { key, .. } = &error;
        // Where surfaces leave it open, their strips are those of the model.
        let open = key == "robot.surfaces" && spec.surfaces.iter().any(|surface| surface.strips.is_none());
        if open { error.against(["aero.full.strips"]) } else { error }
    })?;
    let own = spec.own_numbers();
    let given = robot.check_given(&own).and_then(|()| robot.given(&own));
    let mut numbers = given.map_err(|e| of_numbers(e, spec).within("robot"))?;
    if let Some(mismatch) = mismatch {
        mismatch.deviate(&robot, &mut numbers, spec.structure.elements.len());
    }
    let robot = robot.renumbered(&numbers).map_err(|e| of_numbers(e, spec).within("robot"))?;
    Ok(if vacuum { robot.in_vacuum() } else { robot })
}

/// An error of a number, at the place where `numbers` gives it if they do.
fn of_numbers(error: Error, spec: &RobotSpec) -> Error {
    let given = |name: &str| spec.numbers.keys().find(|key| stands_for(key, name).is_some());
    let quoted = |name: &str| given(name).map(|key| (name.to_owned(), format!("numbers.\"{key}\"")));
    let Error::Invalid { key, against, .. } = &error;
    let places: Vec<_> = std::iter::once(key).chain(against).filter_map(|name| quoted(name)).collect();
    error.renamed(&places)
}

impl AeroSpec {
    /// Checks what this table says by itself.
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()
    }

    /// Whether some of the surfaces that are strips are flat and some are not.
    fn has_both_kinds(&self, outlines: &[SurfaceOutline]) -> bool {
        let are_strips = |outline: &&SurfaceOutline| outline.preset.unwrap_or(self.preset) == Preset::Full;
        let mut kinds = outlines.iter().filter(are_strips).map(|outline| self.strips(outline, 1.0).is_flat());
        kinds.next().is_some_and(|first| kinds.any(|other| other != first))
    }

    /// The model of a surface, among others of `both` kinds, flat and not, or of one. Settings of the model that another table gives have
    /// their keys in `names`: as the model calls them, and as they were written.
    pub(super) fn build<F: AsRef<str>, T: AsRef<str>>(
        &self,
        outline: &SurfaceOutline,
        density_kg_m3: f64,
        both: bool,
        names: &[(F, T)],
    ) -> Result<Aero, Error> {
        self.check().map_err(|e| e.within("aero"))?;
        let of = |table: &str, error: Error| {
            let name = |(from, to): &(F, T)| (format!("{table}.{}", from.as_ref()), to.as_ref().to_owned());
            error.within(table).renamed(&names.iter().map(name).collect::<Vec<_>>())
        };
        let (paper, full) = (|e| of("aero.paper", e), |e| of("aero.full", e));
        let line = self.lifting_line(outline, density_kg_m3);
        let strips = self.strips(outline, density_kg_m3);
        let strips = if both { strips.among_both_kinds() } else { strips };
        // The preset that is not used has to have a meaning too.
        line.check().map_err(paper)?;
        strips.check().map_err(full)?;
        let preset = outline.preset.unwrap_or(self.preset);
        let lives = outline.membrane.is_some() || outline.flap.is_some();
        if lives && preset != Preset::Full {
            let key =
                outline.preset.map_or("aero.preset".into(), |_| format!("robot.{}.preset", outline.key));
            return Err(Error::invalid(
                key,
                format!("\"{}\"", preset.name()),
                if outline.flap.is_some() {
                    "\"full\" where a surface has a flap"
                } else {
                    "\"full\" where a surface is a membrane"
                },
            ));
        }
        match preset {
            Preset::AsPrinted => {
                self.printed_law(outline)?;
                let mut printed = line.printed();
                if self.paper.printed_drag {
                    printed.section.drag = line.section.drag;
                }
                self.laid(outline, printed).map_err(paper)
            }
            Preset::Paper => self.laid(outline, line).map_err(paper),
            Preset::Full => StripModel::new(&outline.planform, strips).map(Aero::Strip).map_err(full),
        }
    }

    /// The lifting line of a surface, on cells or on even angles.
    fn laid(&self, outline: &SurfaceOutline, line: LiftingLineSettings) -> Result<Aero, Error> {
        let line = match self.paper.cells {
            true => LiftingLine::hinged(&outline.planform, &outline.hinges, line),
            false => LiftingLine::new(&outline.planform, line),
        };
        line.map(Aero::LiftingLine)
    }

    /// Preset `as_printed` knows the law `linear` only.
    fn printed_law(&self, outline: &SurfaceOutline) -> Result<(), Error> {
        let law = outline.law.unwrap_or(self.law);
        if law == LiftLaw::Linear {
            return Ok(());
        }
        let key = outline.law.map_or("aero.law".into(), |_| format!("robot.{}.law", outline.key));
        Err(Error::invalid(key, format!("\"{}\"", law.name()), "\"linear\" under preset `as_printed`"))
    }

    /// Section and air of a surface: what it says of them, and else what the scenario says.
    fn section(&self, outline: &SurfaceOutline, density_kg_m3: f64) -> SectionSettings {
        let (own, law) = (&outline.section, outline.law.unwrap_or(self.law));
        SectionSettings {
            law,
            section_slope: own.lift_slope_per_rad.unwrap_or(self.lift_slope_per_rad),
            zero_lift_angle_rad: own.zero_lift_angle_deg.unwrap_or(self.zero_lift_angle_deg).to_radians(),
            stall_angle_rad: own.stall_angle_deg.unwrap_or(self.stall_angle_deg).to_radians(),
            critical_suction: own.critical_suction.unwrap_or(self.critical_suction),
            drag: outline.drag(law),
            added_mass: self.added_mass,
            section_moment: self.section_moment,
            pitch_suction: self.pitch_suction,
            density_kg_m3,
        }
    }

    fn lifting_line(&self, outline: &SurfaceOutline, density_kg_m3: f64) -> LiftingLineSettings {
        LiftingLineSettings {
            nodes: outline.strips.unwrap_or(self.paper.nodes),
            regularisation_m_s: self.paper.regularisation_m_s,
            chord_floor_m: self.paper.chord_floor_m,
            as_printed: false,
            lag_speed: self.paper.lag_speed,
            lift_tilt: self.paper.lift_tilt,
            section: self.section(outline, density_kg_m3),
        }
    }

    fn strips(&self, outline: &SurfaceOutline, density_kg_m3: f64) -> StripSettings {
        StripSettings {
            strips: outline.strips.unwrap_or(self.full.strips),
            hinge_arcs_m: outline.hinges.clone(),
            webs_m: outline.webs.clone(),
            regularisation_m_s: self.full.regularisation_m_s,
            lags: self.full.lags,
            wake_wash: self.full.wake_wash,
            doublet_wash: self.full.doublet_wash,
            folding_rates: self.full.folding_rates,
            turning_impulse: self.full.turning_impulse,
            edge_suction: self.full.edge_suction,
            side_edges: self.full.side_edges,
            vortex_core: self.full.vortex_core,
            force_tilt: self.full.force_tilt,
            section: self.section(outline, density_kg_m3),
            membrane: outline.membrane.clone(),
            flap: outline.flap,
        }
    }
}
