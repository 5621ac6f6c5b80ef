//! `wingbeat fly`.

use std::sync::Arc;
use std::time::Instant;

use indicatif::{HumanDuration, ProgressBar};
use wingbeat::guide::SearchWatch;
use wingbeat::parallel;
use wingbeat::scenario::{Document, Run, Scenario};
use wingbeat::simulate::Record;
use wingbeat_figures::{FigureMaker, FigureTargets, of_flight};
use wingbeat_io::write_parquet;

use crate::args::Fly;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::outcome;
use crate::progress;
use crate::report;
use crate::run_folder::RunFolder;
use crate::say;
use crate::time_left::TimeLeft;
use crate::watch::FlightWatch;

/// Ticks of the progress bar per simulated second.
const TICKS: f64 = 1000.0;

/// Flies the scenario and writes its run folder.
pub fn fly(arguments: &Fly) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let mut scenario = Scenario::open(
        Document::file(&arguments.scenario)?.overridden(&options.all_overrides()),
        &wingbeat_lattice::doors(),
    )?;
    let progress = progress(scenario.spec.flight.duration_s, options.quiet);
    let bar = progress.clone();
    let told = move |found, all| bar.set_message(format!("before the start: {found} of {all} orbits found"));
    scenario.watch_search(SearchWatch::new(told));
    let scenario = Arc::new(scenario);
    let folder = RunFolder::create(options.out.as_deref(), &scenario.spec.run_name()?, options.force)?;
    wingbeat_figures::prepare();
    let mut watch = FlightWatch::begin(&arguments.live, &scenario)?;
    let run = simulate(&scenario, &interrupt, &progress, &mut watch)?;
    watch.end();
    folder.write("scenario.toml", &scenario.resolved)?;
    folder.write_json("summary.json", &run.summary)?;
    write_parquet(&folder.file("record.parquet"), &run.record)?;
    if let Some(strips) = &run.strips {
        write_parquet(&folder.file("strips.parquet"), strips)?;
    }
    let (goal, paper) = (scenario.spec.goal.as_ref(), scenario.spec.paper.as_ref());
    let asked = FigureTargets { robot: Some(scenario.robot()), goal, paper, plan_start_s: None };
    draw(&folder, &run.record, asked, &of_flight(&run.record), &interrupt)?;
    let flown = wingbeat_report::run::FlownScenario { scenario: &scenario, record: &run.record };
    report::beside(&folder, &scenario.spec.name, Some(flown), !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(scenario.spec.seed, start.elapsed()))?;
    let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
    let table = || outcome::table(&run.summary, scenario.spec.paper.as_ref());
    let printed = say::unless(options.quiet, || format!("{}\nrun folder: {}\n", table(), shown.display()));
    Error::unless_usable(run.summary.status, run.summary.reason.as_deref(), shown)?;
    printed
}

fn simulate(
    scenario: &Scenario,
    interrupt: &Interrupt,
    progress: &ProgressBar,
    watch: &mut FlightWatch,
) -> Result<Run, Error> {
    let duration = scenario.spec.flight.duration_s;
    let mut left = scenario.spec.lattice.as_ref().map_or(TimeLeft::even(), TimeLeft::in_lattice);
    progress.set_message("before the start: what the controller asks for");
    let run = scenario.fly(|sample| {
        watch.see(sample);
        progress.set_position((TICKS * sample.t) as u64);
        let elapsed = sample.elapsed.as_secs_f64();
        let factor = sample.t / elapsed.max(1e-6);
        left.see(sample.t, elapsed);
        let left =
            left.at(sample.t, duration).map_or(String::new(), |s| format!("  ({} left)", HumanDuration(s)));
        progress.set_message(format!("{:.2} s simulated, {factor:.2} x real time{left}", sample.t));
        interrupt.flow()
    });
    let run = run.map_err(|error| scenario.explain(&error))?;
    progress.finish_and_clear();
    interrupt.check()?;
    Ok(run)
}

fn progress(duration: f64, quiet: bool) -> ProgressBar {
    let template = "flying {bar:30} {percent:>3} %  {msg}";
    progress::bar(Some((TICKS * duration) as u64), template, quiet)
}

/// Draws what the record has the columns for, on all cores; what it has not is said and left out.
pub fn draw(
    folder: &RunFolder,
    record: &Record,
    asked: FigureTargets,
    draws: &[FigureMaker],
    interrupt: &Interrupt,
) -> Result<(), Error> {
    let draws: Vec<_> = draws.iter().map(|draw| (record, *draw)).collect();
    draw_each(folder, &draws, asked, interrupt)
}

/// As [`draw`] for figures of several records.
pub fn draw_each(
    folder: &RunFolder,
    draws: &[(&Record, FigureMaker)],
    asked: FigureTargets,
    interrupt: &Interrupt,
) -> Result<(), Error> {
    if draws.is_empty() {
        return Ok(());
    }
    let figures = folder.folder("figures")?;
    let drawn = parallel::map(draws, |_, (record, draw)| {
        interrupt.check()?;
        Ok::<_, Error>(draw(record, asked).and_then(|figure| wingbeat_figures::write(&figures, &figure)))
    });
    drawn.into_iter().try_for_each(|drawn| left_out(drawn?))
}

/// A figure that cannot be drawn is left out with a note.
///
/// # Errors
/// A figure that cannot be written: the disk is full, and what follows would not be whole.
pub fn left_out(drawn: Result<(), wingbeat_figures::Error>) -> Result<(), Error> {
    match drawn {
        Err(wingbeat_figures::Error::File { path, source }) => Err(Error::File { path, source }),
        Err(error) => {
            say::note(&format!("a figure is left out: {error}"));
            Ok(())
        }
        Ok(()) => Ok(()),
    }
}
