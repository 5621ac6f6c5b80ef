//! `wingbeat export`.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, read_parquet, write_csv};
use wingbeat_report::export::{glb, mat, mcap, npz, series, vtk};
use wingbeat_report::motion::Motion;
use wingbeat_report::run::{Run, read};

use crate::animate::only;
use crate::args::Export;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::report::{folder_of, free, refused};
use crate::run_folder::{replace, replace_by};
use crate::say;

/// Writes a run in another format.
pub fn export(arguments: &Export) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    let run = only(read(&arguments.run).map_err(refused)?)?;
    interrupt.check()?;
    let named = |ending: &str| {
        let name = run.name.replace('/', "_");
        arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}{ending}")))
    };
    let place = match arguments {
        Export { vtk: true, .. } => {
            let (folder, moves) = (named("-vtk"), motion(&run)?);
            folder_of(&folder, ("frame", ".vtk"), arguments.force)?;
            // Nothing is left of what could not be written.
            frames(&folder, moves, &interrupt).inspect_err(|_| {
                let _ = folder_of(&folder, ("frame", ".vtk"), true).and_then(|()| gone(&folder));
            })?;
            folder
        }
        Export { gltf: true, .. } => {
            file(named(".glb"), arguments.force, || glb(motion(&run)?, &run.name).map_err(Error::Input))?
        }
        Export { mcap: true, .. } => file(named(".mcap"), arguments.force, || {
            mcap(motion(&run)?, &record(&arguments.run)?, run.title()).map_err(Error::Input)
        })?,
        Export { npz: true, .. } => {
            file(named(".npz"), arguments.force, || npz(&record(&arguments.run)?).map_err(Error::Input))?
        }
        Export { mat: true, .. } => {
            file(named(".mat"), arguments.force, || mat(&record(&arguments.run)?).map_err(Error::Input))?
        }
        _ => {
            let path = named(".csv");
            free(&path, arguments.force)?;
            let record = record(&arguments.run)?;
            replace_by(&path, |beside| Ok(write_csv(beside, &record)?))?;
            path
        }
    };
    say::unless(arguments.quiet, || format!("{}\n", place.display()))
}

fn motion(run: &Run) -> Result<&Motion, Error> {
    let why = || {
        let notes: String = run.notes.iter().map(|note| format!("; {note}")).collect();
        Error::Input(format!("{}: nothing moves in this {}{notes}", run.name, run.kind))
    };
    run.motion.as_ref().ok_or_else(why)
}

/// Writes the bytes of a file that is not there, or may be replaced.
fn file(
    path: PathBuf,
    force: bool,
    bytes: impl FnOnce() -> Result<Vec<u8>, Error>,
) -> Result<PathBuf, Error> {
    free(&path, force)?;
    replace(&path, &bytes()?)?;
    Ok(path)
}

/// The record of a run as it was written.
fn record(folder: &Path) -> Result<Record, Error> {
    let parquet = folder.join("record.parquet");
    let (loads, cycles) = (folder.join("loads.csv"), folder.join("cycles.csv"));
    match () {
        () if parquet.is_file() => Ok(read_parquet(&parquet)?),
        () if loads.is_file() => Ok(read_csv(&loads)?),
        () if cycles.is_file() => Ok(read_csv(&cycles)?),
        () => Err(Error::Input(format!(
            "{}: holds none of record.parquet, loads.csv and cycles.csv",
            folder.display()
        ))),
    }
}

/// Removes an empty folder.
pub fn gone(folder: &Path) -> Result<(), Error> {
    fs::remove_dir(folder).map_err(|source| Error::file(folder, source))
}

/// Writes the frames and their list.
fn frames(folder: &Path, motion: &Motion, interrupt: &Interrupt) -> Result<(), Error> {
    let mut files = Vec::new();
    for i in 0..motion.frames() {
        interrupt.check()?;
        let name = format!("frame_{i:05}.vtk");
        let path = folder.join(&name);
        fs::write(&path, vtk(motion, i)).map_err(|source| Error::file(&path, source))?;
        files.push((name, motion.t[i]));
    }
    let path = folder.join("frames.vtk.series");
    fs::write(&path, series(&files)).map_err(|source| Error::file(&path, source))
}
