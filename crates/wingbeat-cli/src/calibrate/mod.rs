//! `wingbeat calibrate`.

mod data;
mod draw;
mod found;
mod words;

use std::ops::ControlFlow;
use std::time::Instant;

use serde::Serialize;
use wingbeat::scenario::Document;
use wingbeat_calibrate::{
    Calibration, Failure, Information, Linear, Observed, Plan, Problem, Progress, Solved, Structure, checked,
    solve,
};
use wingbeat_io::{urdf_as_toml, write_parquet};

use crate::args;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use data::Files;
use found::{Found, Kept, Rival};

#[cfg(test)]
pub use found::columns;

/// Fits the numbers and writes the run folder.
pub fn calibrate(arguments: &args::Calibrate) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let document = Document::file(&arguments.calibration)?.overridden(&options.all_overrides());
    let calibration = Calibration::new(document)?;
    let files = Files::of(&calibration)?;
    let name = calibration.spec.run_name()?;
    let identity = files.identity(&calibration.resolved);
    let folder =
        RunFolder::resume(options.out.as_deref(), &name, options.force, ("calibration.toml", &identity))?;
    match found(&calibration, &folder, &interrupt, arguments) {
        Ok(Some(found)) => {
            write(&folder, &found, &files)?;
            interrupt.check()?;
            let path = folder.finish(&Manifest::new(calibration.spec.seed, start.elapsed()))?;
            let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
            say::unless(options.quiet, || {
                format!("{}\nrun folder: {}\n", words::report(&found), shown.display())
            })
        }
        Ok(None) => {
            folder.discard();
            Ok(())
        }
        Err(Error::Calibration(Failure::Other(fault @ wingbeat_calibrate::Error::Model { .. }))) => {
            let reason = fault.to_string();
            folder.write_json("summary.json", &Failed { status: "fault", reason: &reason })?;
            Kept::remove(&folder);
            let path = folder.finish(&Manifest::new(calibration.spec.seed, start.elapsed()))?;
            Err(Error::Failed { status: "fault".into(), reason, folder: path })
        }
        Err(error) => {
            if !matches!(error, Error::Interrupted) {
                folder.discard();
            }
            Err(error)
        }
    }
}

/// summary.json of a calibration whose model has no answer.
#[derive(Serialize)]
struct Failed<'a> {
    status: &'a str,
    reason: &'a str,
}

/// All that is to be told; nothing where only the information was asked for.
fn found<'a>(
    calibration: &'a Calibration,
    folder: &RunFolder,
    interrupt: &Interrupt,
    arguments: &args::Calibrate,
) -> Result<Option<Found>, Error> {
    let quiet = arguments.run.quiet;
    let structure = calibration.structure(&[], &urdf_as_toml)?;
    let runs = calibration.observed(&structure, &urdf_as_toml, &data::read)?;
    interrupt.check()?;
    let values: Vec<f64> = structure.parameters.iter().map(|parameter| parameter.start).collect();
    let cautions = checked(&structure, &runs, &values).map_err(Failure::from)?;
    cautions.iter().for_each(|caution| say::note(&format!("note: {caution}")));
    let problem = Problem::new(&structure.model, &runs, &structure.parameters).map_err(Failure::from)?;
    let at = Linear::at(&problem, &problem.fitted(), &values).map_err(Failure::from)?;
    let information = Information::of(&problem, &at, &values);
    say::unless(quiet, || words::information(&information, &structure.parameters))?;
    interrupt.check()?;
    information.check(&problem).map_err(Failure::from)?;
    if arguments.information {
        return Ok(None);
    }
    let plan = calibration.plan();
    let mut kept = Kept::open(folder);
    let solved = watched(&structure, &runs, &plan, &mut kept, interrupt, quiet)?;
    let mut found = Found::of(calibration, &structure, &runs, &solved, information, cautions)?;
    interrupt.check()?;
    for rival in calibration.structures() {
        found.rivals.push(one_rival(calibration, &rival.name, &rival.set, &runs, &solved, interrupt)?);
    }
    if !calibration.spec.candidates.is_empty() {
        found.next = next_run(calibration, &solved, interrupt)?;
    }
    found.rank_structures();
    Ok(Some(found))
}

/// The fit, with cost, parameters and time on a bar.
fn watched<'a>(
    structure: &'a Structure,
    runs: &'a [Observed],
    plan: &Plan,
    kept: &mut Kept,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Solved<'a>, Error> {
    let bar = progress::bar(
        Some(plan.starts as u64),
        "fitting {bar:20} start {pos} of {len}, {eta} left  {wide_msg}",
        quiet,
    );
    let mut watch = |at: &Progress| {
        bar.set_position(at.start.min(plan.starts) as u64);
        let values: Vec<String> = at.values.iter().map(|value| format!("{value:.4}")).collect();
        bar.set_message(format!("step {}, cost {:.5e}, at {}", at.step, at.cost, values.join(" ")));
        interrupt.flow()
    };
    let solved = solve(&structure.model, runs, &structure.parameters, plan, kept, &mut watch);
    bar.finish_and_clear();
    interrupt.check()?;
    Ok(solved.map_err(Failure::from)?)
}

/// Another structure fitted to the same runs from the values found, and its error in runs left out.
fn one_rival(
    calibration: &Calibration,
    name: &str,
    set: &[String],
    runs: &[Observed],
    solved: &Solved,
    interrupt: &Interrupt,
) -> Result<Rival, Error> {
    let mut structure = calibration.structure(set, &urdf_as_toml)?;
    for (parameter, value) in structure.parameters.iter_mut().zip(&solved.values) {
        parameter.start = *value;
    }
    let plan = Plan { starts: 1, ..calibration.plan() };
    let mut watch = |_: &Progress| -> ControlFlow<()> { interrupt.flow() };
    let fitted = solve(&structure.model, runs, &structure.parameters, &plan, &mut (), &mut watch);
    interrupt.check()?;
    Rival::of(name, runs, &fitted.map_err(Failure::from)?)
}

/// The candidates by what they leave of the largest uncertainty.
fn next_run(
    calibration: &Calibration,
    solved: &Solved,
    interrupt: &Interrupt,
) -> Result<Vec<found::NextRun>, Error> {
    let candidates = calibration.candidates(&urdf_as_toml)?;
    interrupt.check()?;
    let passes = calibration.spec.truth.as_ref().map_or(7, |truth| truth.passes);
    Ok(found::NextRun::all(&candidates, solved, passes)?)
}

/// Everything into the folder.
fn write(folder: &RunFolder, found: &Found, files: &Files) -> Result<(), Error> {
    folder.write_json("summary.json", &found.summary(files))?;
    folder.write("numbers.toml", &words::numbers(found, files))?;
    folder.write("report.md", &words::report(found))?;
    folder.write("information.csv", &words::information_csv(found))?;
    write_parquet(&folder.file("record.parquet"), &found.record()?)?;
    Kept::remove(folder);
    draw::draw(folder, found)
}
