//! `wingbeat wake`.

mod draw;

pub use draw::{notes, phases};

use std::path::Path;
use std::time::Instant;

use wingbeat::judge::{RunLimits, Verdict};
use wingbeat::scenario::{Scenario, TetherCase};
use wingbeat_io::{read_parquet_columns, shortest, write_parquet};
use wingbeat_lattice::RecordError;
use wingbeat_lattice::course::{
    self, CourseRequest, CourseWatch, LatticeCourse, RecordedFlight, WakeSummary,
};

use crate::args::WakeArguments;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::outcome::overridden;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::tether::CaseTables;

/// Where the motion comes from.
enum MotionSource {
    Case(Box<TetherCase>, CaseTables),
    Flight(Box<RecordedFlight>),
}

/// Steps the lattice of a case or along a flight and writes its run folder.
pub fn wake(arguments: &WakeArguments) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let source = MotionSource::open(arguments)?;
    let asked = asked(arguments);
    let courses = source.courses(&asked, &interrupt)?;
    let folder = RunFolder::create(options.out.as_deref(), &source.run_name()?, options.force)?;
    let mut watches = Vec::new();
    for course in &courses {
        watches.push(step(course, &asked, &interrupt, options.quiet)?);
    }
    let summary = WakeSummary::new(source.name(), &asked, &watches, source.limits());
    source.keep(&folder)?;
    folder.write_json("summary.json", &summary)?;
    for watch in &watches {
        write_parquet(&folder.file(&format!("{}record.parquet", watch.prefix())), &watch.record)?;
        for shot in &watch.shots {
            let name = format!("{}{}.vtk", watch.prefix(), shot.name.replace(' ', "_"));
            folder.write(&name, &shot.picture.vtk())?;
        }
    }
    draw::draw(&folder, &watches)?;
    crate::report::beside(&folder, source.name(), None, !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let printed = say::unless(options.quiet, || {
        let limits = overridden(&summary.verdict.judged);
        format!("{}{limits}\nrun folder: {}\n", summary.table(), shown.display())
    });
    let Verdict { status, reason, .. } = &summary.verdict;
    Error::unless_usable(*status, reason.as_deref(), shown)?;
    printed
}

impl MotionSource {
    /// A run folder of a flight, or else a case.
    fn open(arguments: &WakeArguments) -> Result<Self, Error> {
        let path = &arguments.case;
        if path.is_dir() && path.join("scenario.toml").is_file() {
            if !arguments.run.overrides.is_empty() {
                let text = format!("--set: {} has been flown; allowed is a case", path.display());
                return Err(Error::Input(text));
            }
            return Ok(Self::Flight(Box::new(recorded(path)?)));
        }
        let only_flights = [
            ("--at", !arguments.at.is_empty()),
            ("--cycles", arguments.cycles.is_some()),
            ("--model", arguments.model),
        ];
        if let Some((name, _)) = only_flights.iter().find(|(_, given)| *given) {
            let text = format!("{name}: allowed for the run folder of a flight, not for a case");
            return Err(Error::Input(text));
        }
        // The run folder of a tether holds its case.
        let inside = path.join("case.toml");
        let path = if path.is_dir() && inside.is_file() { &inside } else { path };
        let tables = CaseTables::default();
        let case = TetherCase::load(path, &arguments.run.overrides, &|path| tables.read(path))?;
        Ok(Self::Case(Box::new(case), tables))
    }

    fn courses(&self, asked: &CourseRequest, interrupt: &Interrupt) -> Result<Vec<LatticeCourse>, Error> {
        let courses = match self {
            Self::Case(case, _) => course::case(asked, case, &|| interrupt.flow()).map(|course| vec![course]),
            Self::Flight(run) => run.courses(asked),
        };
        interrupt.check()?;
        courses.map_err(refused)
    }

    fn name(&self) -> &str {
        match self {
            Self::Case(case, _) => &case.spec.name,
            Self::Flight(run) => &run.scenario().spec.name,
        }
    }

    /// Limits of the document that the motion came from.
    fn limits(&self) -> &RunLimits {
        match self {
            Self::Case(case, _) => &case.limits,
            Self::Flight(run) => run.scenario().limits(),
        }
    }

    fn run_name(&self) -> Result<wingbeat::scenario::RunName, Error> {
        Ok(match self {
            Self::Case(case, _) => case.spec.run_name()?,
            Self::Flight(run) => run.scenario().spec.run_name()?,
        })
    }

    /// Writes what the motion came from.
    fn keep(&self, folder: &RunFolder) -> Result<(), Error> {
        match self {
            Self::Case(case, tables) => {
                folder.write("case.toml", &case.kept(|path| tables.name(path))?)?;
                tables.keep(folder)
            }
            Self::Flight(run) => folder.write("scenario.toml", &run.scenario().resolved),
        }
    }
}

/// What the lattice refuses; of what the command line asked, by its option.
pub fn refused(error: wingbeat_lattice::Error) -> Error {
    match error {
        wingbeat_lattice::Error::Setting {
            key: key @ ("steps" | "cycles" | "chordwise" | "spanwise"),
            value,
            allowed,
        } => Error::Input(format!("--{key} {value}: allowed is {allowed}")),
        wingbeat_lattice::Error::Setting { key: "core.radius_m", value, allowed } => {
            Error::Input(format!("--core: a radius of {} m: allowed is {allowed}", shortest(value)))
        }
        wingbeat_lattice::Error::Setting { key: "critical_suction", value, allowed } => {
            Error::Input(format!("--critical-suction {}: allowed is {allowed}", shortest(value)))
        }
        wingbeat_lattice::Error::Setting { key: key @ "zero_lift_angle_deg", value, allowed } => {
            let value = shortest((value * 1e9).round() / 1e9);
            Error::Input(format!("{key} of `aero` or of a section = {value}: allowed is {allowed}"))
        }
        wingbeat_lattice::Error::Setting { key: "panels", value, allowed } => {
            Error::Input(format!("--chordwise times --spanwise: {value} panels: allowed is {allowed}"))
        }
        wingbeat_lattice::Error::Record(error @ RecordError::Cycles { .. }) => {
            Error::Input(format!("{error}; ask for fewer with --cycles or another end with --at"))
        }
        error => Error::Input(error.to_string()),
    }
}

/// What the command line asks.
fn asked(arguments: &WakeArguments) -> CourseRequest {
    CourseRequest {
        at: arguments.at.clone(),
        cycles: arguments.cycles,
        model: arguments.model,
        chordwise: arguments.chordwise,
        spanwise: arguments.spanwise,
        steps: arguments.steps,
        prescribed: arguments.prescribed,
        core: arguments.core,
        critical_suction: arguments.critical_suction,
    }
}

/// Scenario and record of the run folder `folder`.
pub fn recorded(folder: &Path) -> Result<RecordedFlight, Error> {
    wingbeat_io::unchanged(&folder.join("scenario.toml"))?;
    let scenario = Scenario::load(&folder.join("scenario.toml"), &[])?;
    let record = read_parquet_columns(&folder.join("record.parquet"), &RecordedFlight::columns(&scenario))?;
    RecordedFlight::new(scenario, record).map_err(refused)
}

/// Steps a course; a lattice that fails ends it with what there is.
fn step<'a>(
    course: &'a LatticeCourse,
    asked: &CourseRequest,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<CourseWatch<'a>, Error> {
    let template = format!("{} {{bar:30}} {{percent:>3}} %  ({{eta}} left)", course.title);
    let bar = progress::bar(Some(course.clock.total() as u64), &template, quiet);
    let watch = course.step(asked, &mut |done| {
        bar.set_position(done as u64);
        interrupt.flow()
    });
    bar.finish_and_clear();
    interrupt.check()?;
    watch.map_err(refused)
}
