//! `wingbeat rig process`.

mod numbers;
mod source;

use std::path::{Path, PathBuf};
use std::time::Instant;

use wingbeat::scenario::{Processed, RigRun, Weighed};
use wingbeat_figures::Figure;
use wingbeat_io::samples::Import;
use wingbeat_io::write_parquet;

use super::runs;
use crate::args::RigProcess;
use crate::error::Error;
use crate::manifest::Manifest;
use crate::run_folder::RunFolder;
use source::Source;

/// One processed run.
struct Done {
    run: RigRun,
    file: PathBuf,
    import: Import,
    window: (f64, f64),
    result: Outcome,
}

/// What processing gave.
enum Outcome {
    /// Phase averages.
    Averaged(Box<Processed>),
    /// Mass, centre, offsets of static tilts.
    Weighed(Box<Weighed>),
}

impl Done {
    fn averaged(&self) -> Option<&Processed> {
        match &self.result {
            Outcome::Averaged(processed) => Some(processed),
            Outcome::Weighed(_) => None,
        }
    }
}

/// Processes a file, a run folder, a recording, or a folder of run folders.
pub fn process(arguments: &RigProcess) -> Result<(), Error> {
    let start = Instant::now();
    let sources = source::find(&arguments.path, arguments.run.as_deref())?;
    let target = arguments.out.clone().unwrap_or_else(|| results_beside(&arguments.path));
    // Results of an earlier processing may be replaced where the name is our own choice.
    let folder = RunFolder::create(Some(&target), "processed", arguments.force || arguments.out.is_none())?;
    let answers = runs::shared(&sources, |_, source| one(source, &arguments.overrides));
    let mut done = answers.into_iter().collect::<Result<Vec<_>, _>>()?;
    subtract_still_air(&mut done)?;
    let numbers = numbers::numbers(&done)?;
    for run in &done {
        write(&folder, run)?;
    }
    folder.write_json("summary.json", &numbers.summary)?;
    if let Some(envelope) = &numbers.envelope {
        write_parquet(&folder.file("envelope.parquet"), envelope)?;
        draw(&folder.folder("figures")?, wingbeat_figures::force_moment(envelope))?;
    }
    let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
    if !arguments.quiet {
        print!("{}", numbers.summary.words());
        println!("results: {}", path.display());
    }
    Ok(())
}

/// `processed` in a folder, NAME-processed beside a file.
fn results_beside(path: &Path) -> PathBuf {
    if path.is_dir() {
        return path.join("processed");
    }
    let stem = path.file_stem().map_or("samples".into(), |stem| stem.to_string_lossy());
    path.with_file_name(format!("{stem}-processed"))
}

fn one(source: &Source, overrides: &[String]) -> Result<Done, Error> {
    let (run, file) = (runs::run(&source.run, overrides)?, source.samples.clone());
    let imported = wingbeat_io::samples::read_samples(&file)?.import(&run.spec.process.input)?;
    let named = |what: String| Error::Input(format!("{}: {what}", file.display()));
    let plan = match (&run.spec.turn, &source.window) {
        (Some(_), None) => Some(
            run.plan()?.map_err(|refusal| named(format!("limit profile {}: {refusal}", run.profile.name)))?,
        ),
        _ => None,
    };
    let carrier = run.carrier(plan.as_ref());
    let window = run.spec.process.window_s.map(|[begin, end]| (begin, end));
    let window = window.or(source.window).unwrap_or_else(|| run.window(plan.as_ref(), &carrier));
    let failed = |fault: wingbeat::plant::Fault| named(fault.to_string());
    let refused = |error: wingbeat::Error| named(error.to_string());
    let result = if run.is_weighing() {
        let weighed = run.weigh(&imported.record, &carrier).map_err(refused)?.map_err(failed)?;
        Outcome::Weighed(Box::new(weighed))
    } else {
        let processed = run.process(&imported.record, &carrier, window).map_err(refused)?.map_err(failed)?;
        Outcome::Averaged(Box::new(processed))
    };
    Ok(Done { run, file, import: imported.import, window, result })
}

/// Takes the average of the run in still air away from those that ask for it.
fn subtract_still_air(done: &mut [Done]) -> Result<(), Error> {
    for index in 0..done.len() {
        let Some(name) = done[index].run.spec.process.still_air.clone() else { continue };
        let this = done[index].run.spec.name.clone();
        let found = done.iter().position(|other| other.run.spec.name == name && other.run.spec.name != this);
        let still = found.and_then(|k| Some((done[k].run.frequency(), done[k].averaged()?.clone())));
        let Some((frequency, still)) = still else {
            let names: Vec<_> = done.iter().map(|other| other.run.spec.name.as_str()).collect();
            let names = names.join(", ");
            return Err(Error::Input(format!(
                "{this}: process.still_air = {name}: allowed is another flapping run processed with it: {names}"
            )));
        };
        let own = done[index].run.frequency();
        if (own - frequency).abs() > 0.01 * own {
            return Err(Error::Input(format!(
                "{this}: process.still_air = {name}: it flaps at {frequency} Hz, this run at {own} Hz"
            )));
        }
        if let Outcome::Averaged(processed) = &mut done[index].result {
            processed.subtract(&name, &still);
        }
    }
    Ok(())
}

/// Writes the averages of a run, with its figures.
fn write(folder: &RunFolder, done: &Done) -> Result<(), Error> {
    let name = &done.run.spec.name;
    let Some(processed) = done.averaged() else { return Ok(()) };
    let cycles = processed.record(done.run.processed_frame())?;
    write_parquet(&folder.file(&format!("{name}.parquet")), &cycles)?;
    let figures = folder.folder(&format!("figures/{name}"))?;
    draw(&figures, wingbeat_figures::filtered(&processed.trace))?;
    draw(&figures, wingbeat_figures::cycles(&processed.trace, &cycles))
}

/// Writes a figure; one that cannot be drawn is said and left out.
fn draw(folder: &Path, figure: Result<Figure, wingbeat_figures::Error>) -> Result<(), Error> {
    match figure {
        Ok(figure) => wingbeat_figures::write(folder, &figure).map_err(|e| Error::Input(e.to_string())),
        Err(error) => {
            eprintln!("a figure is left out: {error}");
            Ok(())
        }
    }
}
