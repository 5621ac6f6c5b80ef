//! `wingbeat export`.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, read_parquet, write_csv};
use wingbeat_report::export::{fits, glb, mat, mcap, npz, record_fits, series, vtk};
use wingbeat_report::motion::Motion;
use wingbeat_report::run::{Run, read};

use crate::animate::only;
use crate::args::Export;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::report::{free, refused};
use crate::run_folder::{Numbered, replace, replace_by, replace_folder};
use crate::say;

/// The frames for VTK in a folder.
const FRAMES: Numbered = Numbered { prefix: "frame_", suffix: ".vtk", list: "frames.vtk.series" };

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
            // About the letters of a rib, its panel and its strip.
            let ribs: usize = moves.surfaces.iter().map(|surface| surface.ribs.len()).sum();
            fits("the frames", moves.frames() as f64 * ribs as f64 * 400.0).map_err(Error::Input)?;
            replace_folder(&folder, FRAMES, arguments.force, &mut |beside| {
                frames(beside, moves, &interrupt)
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
            // The most letters of a number.
            record_fits("the .csv file", &record, 25.0).map_err(Error::Input)?;
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
