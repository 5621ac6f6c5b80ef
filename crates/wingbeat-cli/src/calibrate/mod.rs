//! `wingbeat calibrate`.

mod draw;
mod kept;

use std::time::Instant;

use serde::Serialize;
use wingbeat::judge::{Status, Verdict};
use wingbeat::scenario::Document;
use wingbeat_calibrate::{
    CalibrationFailure, CalibrationFile, CalibrationResult, FitProgress, PreparedCalibration, SampleFiles,
    words,
};
use wingbeat_io::{urdf_as_toml, write_parquet};

use crate::args;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::manifest::Manifest;
use crate::progress;
use crate::run_folder::RunFolder;
use crate::say;
use crate::watch::{ConvergenceWatch, SearchIteration};
use kept::KeptFits;

/// Parameters whose values are shown on the page of a fit under way.
const SHOWN: usize = 24;

#[cfg(test)]
pub use wingbeat_calibrate::columns;

/// Fits the numbers and writes the run folder.
pub fn calibrate(arguments: &args::Calibrate) -> Result<(), Error> {
    let start = Instant::now();
    let options = &arguments.run;
    let interrupt = Interrupt::listen()?;
    let document = Document::file(&arguments.calibration)?.overridden(&options.all_overrides());
    let calibration = CalibrationFile::new(document)?;
    if arguments.names {
        let named = calibration.named_numbers(&urdf_as_toml)?;
        let line = |(name, value): &(String, f64)| format!("{name} = {}\n", wingbeat_io::shortest(*value));
        return say::say(&named.iter().map(line).collect::<String>());
    }
    let files = SampleFiles::of(&calibration).map_err(CalibrationFailure::from)?;
    let name = calibration.spec.run_name()?;
    let identity = files.identity(&calibration)?;
    let folder =
        RunFolder::resume(options.out.as_deref(), &name, options.force, ("calibration.toml", &identity))?;
    let watch = ConvergenceWatch::begin(
        &arguments.live,
        &calibration.spec.name,
        "fit under way",
        &calibration.resolved,
    )?;
    match found(&calibration, &folder, &interrupt, arguments, &watch) {
        Ok(Some(found)) => {
            let verdict = found.verdict(calibration.limits());
            write(&folder, (&found, &verdict), &files)?;
            crate::report::beside(&folder, &calibration.spec.name, None, !arguments.page.no_report)?;
            interrupt.check()?;
            let path = folder.finish(&Manifest::new(calibration.spec.seed, start.elapsed()))?;
            let shown = path.strip_prefix(std::env::current_dir().unwrap_or_default()).unwrap_or(&path);
            let report = || format!("{}\nrun folder: {}\n", words::report(&found, &verdict), shown.display());
            let printed = say::unless(options.quiet, report);
            Error::unless_usable(verdict.status, verdict.reason.as_deref(), shown)?;
            printed
        }
        Ok(None) => {
            folder.discard();
            Ok(())
        }
        Err(Error::Calibration(CalibrationFailure::Other(
            fault @ wingbeat_calibrate::Error::Model { .. },
        ))) => {
            let reason = fault.to_string();
            folder.write_json(
                "summary.json",
                &FailedCalibration { status: Status::Failed.name(), reason: &reason },
            )?;
            KeptFits::remove(&folder)?;
            let path = folder.finish(&Manifest::new(calibration.spec.seed, start.elapsed()))?;
            Err(Error::Failed { status: Status::Failed.name().into(), reason, folder: path })
        }
        Err(Error::Interrupted) if KeptFits::open(&folder).count() > 0 => {
            let (done, all) = (KeptFits::open(&folder).count(), calibration.spec.starts);
            Err(Error::Paused { done, all })
        }
        Err(error) => {
            folder.discard();
            Err(error)
        }
    }
}

/// summary.json of a calibration whose model has no answer.
#[derive(Serialize)]
struct FailedCalibration<'a> {
    status: &'a str,
    reason: &'a str,
}

/// All that is to be told; nothing where only the information was asked for.
fn found(
    calibration: &CalibrationFile,
    folder: &RunFolder,
    interrupt: &Interrupt,
    arguments: &args::Calibrate,
    watch: &ConvergenceWatch,
) -> Result<Option<CalibrationResult>, Error> {
    let prepared = calibration.prepared()?;
    interrupt.check()?;
    prepared.cautions.iter().for_each(|caution| say::note(&format!("note: {caution}")));
    let found = searched(&prepared, folder, interrupt, arguments, watch);
    // A fit says them with its result.
    if !matches!(found, Ok(Some(_))) {
        prepared.verdict().warnings.iter().for_each(|warning| say::note(&warning.to_string()));
    }
    found
}

/// The fit, or the information of the data alone.
fn searched(
    prepared: &PreparedCalibration<'_>,
    folder: &RunFolder,
    interrupt: &Interrupt,
    arguments: &args::Calibrate,
    watch: &ConvergenceWatch,
) -> Result<Option<CalibrationResult>, Error> {
    let quiet = arguments.run.quiet;
    say::unless(quiet, || words::information(&prepared.information, &prepared.structure.parameters))?;
    prepared.check()?;
    if arguments.information {
        let on_data = prepared.verdict();
        return Error::unless_sound(on_data.status, on_data.reason.as_deref()).map(|()| None);
    }
    watched(prepared, &mut KeptFits::open(folder), interrupt, quiet, watch).map(Some)
}

/// The fit, with cost, parameters and time on a bar.
fn watched(
    prepared: &PreparedCalibration<'_>,
    kept: &mut KeptFits,
    interrupt: &Interrupt,
    quiet: bool,
    live: &ConvergenceWatch,
) -> Result<CalibrationResult, Error> {
    let starts = prepared.plan().starts;
    let bar = progress::bar(
        Some(starts as u64),
        "fitting {bar:20} start {pos} of {len}, {eta} left  {wide_msg}",
        quiet,
    );
    let mut watch = |at: &FitProgress| {
        live.see(|| point(at, prepared));
        bar.set_position(at.start.min(starts) as u64);
        let values: Vec<String> = at.values.iter().map(|value| format!("{value:.4}")).collect();
        bar.set_message(format!("step {}, cost {:.5e}, at {}", at.step, at.cost, values.join(" ")));
        interrupt.flow()
    };
    let found = prepared.fit(kept, &mut watch);
    bar.finish_and_clear();
    live.end();
    interrupt.check()?;
    Ok(found?)
}

/// A step of a fit as it is shown.
fn point(at: &FitProgress, prepared: &PreparedCalibration<'_>) -> SearchIteration {
    let mut values = vec![("decimal logarithm of the sum of squares".into(), "", at.cost.log10())];
    let parameters = prepared.structure.parameters.iter().zip(at.values);
    values.extend(parameters.take(SHOWN).map(|(parameter, value)| (parameter.name.clone(), "", *value)));
    SearchIteration { series: format!("start {}", at.start + 1), values }
}

/// Everything into the folder.
fn write(
    folder: &RunFolder,
    (found, verdict): (&CalibrationResult, &Verdict),
    files: &SampleFiles,
) -> Result<(), Error> {
    folder.write_json("summary.json", &found.summary(files, verdict))?;
    folder.write("numbers.toml", &words::numbers(found, files, wingbeat_program::COMMIT, verdict))?;
    if let Some(residual) = words::residual(found, files, wingbeat_program::COMMIT) {
        folder.write("residual.toml", &residual)?;
    }
    folder.write("report.md", &words::report(found, verdict))?;
    folder.write("information.csv", &words::information_csv(found))?;
    write_parquet(&folder.file("record.parquet"), &found.record().map_err(CalibrationFailure::from)?)?;
    KeptFits::remove(folder)?;
    draw::draw(folder, found)
}
