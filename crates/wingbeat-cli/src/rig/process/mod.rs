//! `wingbeat rig process`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use wingbeat::judge::Verdict;
use wingbeat::scenario::{CombinedRuns, ProcessedRun, RunName};
use wingbeat_calibrate::{ProcessedTogether, SampleSource};
use wingbeat_figures::{CellOrigin, Figure};
use wingbeat_io::write_parquet;

use super::runs;
use crate::args::RigProcess;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::run_folder::RunFolder;
use crate::say;

/// Processes a file, a run folder, a recording, or a folder of run folders.
pub fn process(arguments: &RigProcess) -> Result<(), Error> {
    let start = Instant::now();
    let interrupt = Interrupt::listen()?;
    let sources = SampleSource::find(&arguments.path, arguments.run.is_some(), "--run RUN.toml");
    let sources = sources.map_err(Error::Input)?;
    let (parent, name) = results_beside(&arguments.path)?;
    let folder = RunFolder::create_in(arguments.out.as_deref(), &parent, &name, arguments.force)?;
    let load = |source: &SampleSource| {
        let file = source.run.as_ref().or(arguments.run.as_ref());
        let file = file.ok_or_else(|| format!("{}: no run", source.samples.display()))?;
        runs::run(file, &arguments.overrides).map_err(|error| error.to_string())
    };
    let ProcessedTogether { runs, together, summary } =
        ProcessedTogether::of(&sources, load).map_err(Error::Input)?;
    for run in &runs {
        write(&folder, run)?;
    }
    folder.write_json("summary.json", &summary)?;
    if let Some(CombinedRuns { envelope, .. }) = &together {
        write_parquet(&folder.file("envelope.parquet"), envelope)?;
        let simulated = summary.simulated().len();
        let all = runs.iter().filter(|run| run.averaged().is_some()).count();
        let cell = CellOrigin::of(simulated, all - simulated);
        draw(&folder.folder("figures")?, wingbeat_figures::force_moment(envelope, cell))?;
    }
    crate::report::beside(&folder, name.as_str(), None, !arguments.page.no_report)?;
    interrupt.check()?;
    let path = folder.finish(&Manifest::new(0, start.elapsed()))?;
    let printed =
        say::unless(arguments.quiet, || format!("{}results: {}\n", summary.words(), path.display()));
    let Verdict { status, reason, .. } = summary.verdict;
    Error::unless_usable(status, reason.as_deref(), &path)?;
    printed
}

/// `processed` in a folder, NAME-processed beside a file: where that is, and its name.
fn results_beside(path: &Path) -> Result<(PathBuf, RunName), Error> {
    if path.is_dir() {
        return Ok((path.into(), RunName::new("name", "processed")?));
    }
    let stem = path.file_stem().map_or("samples".into(), |stem| stem.to_string_lossy());
    let name =
        RunName::new("name", &format!("{stem}-processed")).or(RunName::new("name", "samples-processed"))?;
    Ok((path.parent().unwrap_or(Path::new("")).into(), name))
}

/// Writes the averages of a run, with its figures.
fn write(folder: &RunFolder, done: &ProcessedRun) -> Result<(), Error> {
    let name = done.name();
    let Some(processed) = done.averaged() else { return Ok(()) };
    let cycles = processed.record(done.run.processed_frame())?;
    write_parquet(&folder.file(&format!("{name}.parquet")), &cycles)?;
    let figures = folder.folder(&format!("figures/{name}"))?;
    let cell = if processed.is_simulated() { CellOrigin::Simulated } else { CellOrigin::Measured };
    draw(&figures, wingbeat_figures::filtered(&processed.trace, cell))?;
    draw(&figures, wingbeat_figures::cycles(&processed.trace, &cycles, cell))
}

/// Writes a figure; one that cannot be drawn is said and left out.
fn draw(folder: &Path, figure: Result<Figure, wingbeat_figures::Error>) -> Result<(), Error> {
    match figure {
        Ok(figure) => wingbeat_figures::write(folder, &figure).map_err(|e| Error::Input(e.to_string())),
        Err(error) => {
            say::note(&format!("a figure is left out: {error}"));
            Ok(())
        }
    }
}
