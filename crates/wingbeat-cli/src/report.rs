//! `wingbeat report`, and the page in every run folder.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat_report::files::Files;
use wingbeat_report::page::{Without, page};
use wingbeat_report::run::{FlownScenario, ShownRun, of, one_axis, read};
use wingbeat_report::sheet::sheet;

use crate::args::ReportArguments;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::run_folder::{RunFolder, add_file, replace};
use crate::say;

/// The page of a run in its folder.
const PAGE: &str = "report.html";
/// Most runs on one page.
const MOST_RUNS: usize = 16;

/// Writes the page of runs that are there.
pub fn report(arguments: &ReportArguments) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    if arguments.runs.len() > MOST_RUNS {
        let given = arguments.runs.len();
        return Err(Error::Input(format!("{given} runs: allowed are at most {MOST_RUNS} on one page")));
    }
    if let Some(out) = arguments.out.as_ref().filter(|out| out.extension().is_none_or(|e| e != "html")) {
        return Err(Error::Input(format!("--out {}: allowed is a page, PAGE.html", out.display())));
    }
    let mut runs = Vec::new();
    for folder in &arguments.runs {
        runs.extend(read(folder).map_err(refused)?);
        interrupt.check()?;
    }
    one_axis(&runs).map_err(Error::Input)?;
    if let Some(file) = &arguments.sheet {
        return drawn(file, &runs, arguments);
    }
    if let (true, None) = (arguments.force, &arguments.out) {
        return Err(Error::Input("--force: allowed with --out or --sheet".into()));
    }
    let text = page(&runs, Without { wake: arguments.no_wake, strips: arguments.no_strips });
    let place = match (&arguments.out, arguments.runs.as_slice()) {
        (Some(out), _) => written(out, &text, arguments.force)?,
        (None, [only]) => {
            add_file(only, PAGE, text.as_bytes())?;
            only.join(PAGE)
        }
        (None, _) => written(Path::new(PAGE), &text, false)?,
    };
    say::unless(arguments.quiet, || {
        let status = |run: &ShownRun| {
            let status = run.summary["status"].as_str().unwrap_or("no status");
            format!("{}: {}, {status}\n", run.name, run.kind)
        };
        format!("{}page: {}\n", runs.iter().map(status).collect::<String>(), place.display())
    })
}

/// Writes the plots of the runs as one figure.
fn drawn(file: &Path, runs: &[ShownRun], arguments: &ReportArguments) -> Result<(), Error> {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let vector = match ending.as_deref() {
        Some("png") => false,
        Some("svg") => true,
        _ => {
            let what = format!("--sheet {}: allowed is a figure, FILE.png or FILE.svg", file.display());
            return Err(Error::Input(what));
        }
    };
    free(file, arguments.force)?;
    let figure = sheet(runs).map_err(Error::Input)?;
    let bytes = if vector { Ok(figure.svg().into_bytes()) } else { figure.png() };
    replace(file, &bytes.map_err(|error| Error::Input(error.to_string()))?)?;
    say::unless(arguments.quiet, || format!("{}\n", file.display()))
}

/// Writes a file that is not there, or may be replaced.
fn written(path: &Path, text: &str, force: bool) -> Result<PathBuf, Error> {
    free(path, force)?;
    replace(path, text.as_bytes())?;
    Ok(path.into())
}

/// Refuses a file that is there, unless it may be replaced, and what is no file.
///
/// # Errors
/// That.
pub fn free(path: &Path, force: bool) -> Result<(), Error> {
    match fs::symlink_metadata(path) {
        Err(_) => Ok(()),
        Ok(data) if force && data.is_file() => Ok(()),
        Ok(data) => Err(Error::Input(format!(
            "{}: {}",
            path.display(),
            if data.is_file() { "is there already; --out FILE --force replaces it" } else { "is no file" }
        ))),
    }
}

pub fn refused(error: wingbeat_report::Error) -> Error {
    match error {
        wingbeat_report::Error::File { path, source } => Error::File { path, source },
        wingbeat_report::Error::Record(error) => Error::Record(error),
        error => Error::Input(error.to_string()),
    }
}

/// Writes the page of the run in `folder`, which is called `name`, unless it is not wanted; what cannot be shown is said.
///
/// # Errors
/// What the system refuses: the disk is full.
pub fn beside(
    folder: &RunFolder,
    name: &str,
    flown: Option<FlownScenario>,
    wanted: bool,
) -> Result<(), Error> {
    if !wanted {
        return Ok(());
    }
    match of(Files::Folder(folder.partial()), name, flown) {
        Ok(runs) => folder.write(PAGE, &page(&runs, Without::default())),
        // What the system refuses is refused; what cannot be shown is said.
        Err(error @ wingbeat_report::Error::File { .. })
        | Err(error @ wingbeat_report::Error::Record(wingbeat_io::Error::File { .. })) => Err(refused(error)),
        Err(error) => {
            let hidden = format!("{}: ", folder.partial().display());
            say::note(&format!("report.html is left out: {}", error.to_string().replace(&hidden, "")));
            Ok(())
        }
    }
}
