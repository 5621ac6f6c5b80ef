//! `wingbeat wake`.

mod case;
mod course;
mod draw;
mod flown;
mod stroke;
mod summary;
mod watch;

use std::time::Instant;

use wingbeat::scenario::TetherCase;
use wingbeat_io::write_parquet;
use wingbeat_lattice::{Core, Lattice, Panels, Settings, Spacing, WakeMotion};

use crate::args::Wake;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::tether::Tables;
use course::Course;
use flown::FlownRun;
use summary::Summary;
use watch::Watch;

/// Most rings of a wake: minutes of work.
const MOST_RINGS: usize = 200_000;
/// Segments of a wake from which it is summed by multipoles.
const FAST_FROM: usize = 20_000;
/// Core of bound vortices where wings pass through each other, over the distance along the arc. *Choice.*
const CROSSING: f64 = 0.2;
/// Fewest and most steps of a cycle that are chosen.
const STEPS: (f64, f64) = (24.0, 400.0);

/// Where the motion comes from.
enum Source {
    Case(Box<TetherCase>, Tables),
    Flight(Box<FlownRun>),
}

/// Steps the lattice of a case or along a flight and writes its run folder.
pub fn wake(arguments: &Wake) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let source = Source::open(arguments)?;
    let courses = source.courses(arguments, &interrupt)?;
    check_size(arguments, &courses)?;
    let folder = RunFolder::create(options.out.as_deref(), &source.run_name()?, options.force)?;
    let mut watches = Vec::new();
    for course in &courses {
        watches.push(step(course, settings(arguments, course), &interrupt, options.quiet)?);
    }
    let summary = Summary::new(source.name(), arguments, &watches);
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
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(options.seed.unwrap_or(0), start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    match watches.iter().find_map(|watch| watch.failed.clone()) {
        Some(reason) => Err(Error::Failed { status: summary.status, reason, folder: shown.into() }),
        None => {
            say::unless(options.quiet, || format!("{}\nrun folder: {}\n", summary.table(), shown.display()))
        }
    }
}

impl Source {
    /// A run folder of a flight, or else a case.
    fn open(arguments: &Wake) -> Result<Self, Error> {
        let path = &arguments.case;
        if path.is_dir() && path.join("scenario.toml").is_file() {
            if !arguments.run.overrides.is_empty() {
                let text = format!("--set: {} has been flown; allowed is a case", path.display());
                return Err(Error::Input(text));
            }
            return Ok(Self::Flight(Box::new(FlownRun::open(path)?)));
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
        let tables = Tables::default();
        let case = TetherCase::load(path, &arguments.run.overrides, &|path| tables.read(path))?;
        Ok(Self::Case(Box::new(case), tables))
    }

    fn courses(&self, arguments: &Wake, interrupt: &Interrupt) -> Result<Vec<Course>, Error> {
        if arguments.steps == Some(0) {
            return Err(Error::Input("--steps 0: allowed is 1 or more".into()));
        }
        match self {
            Self::Case(case, _) => Ok(vec![case::course(arguments, case, interrupt)?]),
            Self::Flight(run) => run.courses(arguments),
        }
    }

    fn name(&self) -> &str {
        match self {
            Self::Case(case, _) => &case.spec.name,
            Self::Flight(run) => &run.scenario().spec.name,
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

/// What the lattice refuses.
fn refused(error: wingbeat_lattice::Error) -> Error {
    Error::Input(error.to_string())
}

/// Panels that the command line asks for.
fn panels(arguments: &Wake) -> Panels {
    Panels { chordwise: arguments.chordwise, spanwise: arguments.spanwise, spacing: Spacing::Lan }
}

/// Steps of a cycle in which the way is `way` m so that the way of each is a panel's chord.
fn fitting(way: f64, chord: f64, chordwise: usize) -> usize {
    (way * chordwise as f64 / chord).round().clamp(STEPS.0, STEPS.1) as usize
}

/// Refuses wakes of too many rings.
fn check_size(arguments: &Wake, courses: &[Course]) -> Result<(), Error> {
    for clock in courses.iter().map(|course| course.clock) {
        let rings = clock.cycles.saturating_mul(clock.steps).saturating_mul(arguments.spanwise);
        if rings > MOST_RINGS {
            let text = format!(
                "cycles times steps times spanwise panels are {rings} rings of the wake: allowed are at most {MOST_RINGS}"
            );
            return Err(Error::Input(text));
        }
    }
    Ok(())
}

/// What the command line asks of the lattice.
fn settings(arguments: &Wake, course: &Course) -> Settings {
    let core = Core { radius_m: arguments.core * course.chord, viscosity_m2_s: 0.0, squire: 0.0 };
    let wake = if arguments.prescribed { WakeMotion::Prescribed } else { WakeMotion::Free };
    let crossing = if course.crosses { CROSSING } else { 0.0 };
    let own = Settings::new(course.clock.step_s(), core.radius_m);
    Settings { wake, core, crossing, fast_from: FAST_FROM, ..own }
}

/// Steps a course; a lattice that fails ends it with what there is.
fn step<'a>(
    course: &'a Course,
    settings: Settings,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Watch<'a>, Error> {
    let mut lattice = Lattice::new(course.scene.clone(), settings).map_err(refused)?;
    let total = course.clock.total();
    let mut watch = Watch::new(course);
    let template = format!("{} {{bar:30}} {{percent:>3}} %  ({{eta}} left)", course.title);
    let bar = progress::bar(Some(total as u64), &template, quiet);
    for k in 0..total {
        if let Err(error) = advance(course, &mut lattice, &mut watch, k) {
            watch.failed = Some(error.to_string());
            break;
        }
        bar.set_position(k as u64);
        interrupt.check()?;
    }
    bar.finish_and_clear();
    watch.circulation_error = lattice.circulation_error();
    Ok(watch)
}

/// One step, with the circulations of the model that flew where these are wanted.
fn advance(
    course: &Course,
    lattice: &mut Lattice,
    watch: &mut Watch<'_>,
    k: usize,
) -> Result<(), wingbeat_lattice::Error> {
    let t = k as f64 * course.clock.step_s();
    match course.flown.as_ref().filter(|flown| flown.by_model) {
        None => {
            let loads = lattice.step()?;
            watch.see(k, lattice, Some(&loads));
        }
        Some(flown) => {
            let rings = flown.flight.circulations(flown.from_s + t, &flown.layouts)?;
            lattice.step_with(&rings.unwrap_or_default())?;
            watch.see(k, lattice, None);
        }
    }
    Ok(())
}
