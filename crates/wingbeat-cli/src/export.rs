//! `wingbeat export`.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, read_parquet};
use wingbeat_report::export::{Format, SERIES, of_run, series, vtk, vtk_fits};
use wingbeat_report::motion::RunMotion;
use wingbeat_report::run::{ShownRun, read};

use crate::animate::only;
use crate::args::Export;
use crate::error::Error;
use crate::interrupt::Interrupt;
use crate::report::{free, refused};
use crate::run_folder::{Numbered, replace, replace_folder};
use crate::say;

/// The frames for VTK in a folder.
const FRAMES: Numbered = Numbered { prefix: "frame_", suffix: ".vtk", list: SERIES };

/// Writes a run in another format.
pub fn export(arguments: &Export) -> Result<(), Error> {
    let interrupt = Interrupt::listen()?;
    let run = only(read(&arguments.run).map_err(refused)?)?;
    interrupt.check()?;
    let (format, ending) = match arguments {
        Export { vtk: true, .. } => (Format::Vtk, "-vtk"),
        Export { gltf: true, .. } => (Format::Gltf, ".glb"),
        Export { mcap: true, .. } => (Format::Mcap, ".mcap"),
        Export { npz: true, .. } => (Format::Npz, ".npz"),
        Export { mat: true, .. } => (Format::Mat, ".mat"),
        _ => (Format::Csv, ".csv"),
    };
    let name = run.name.replace('/', "_");
    let place = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}{ending}")));
    if format == Format::Vtk {
        // Frame by frame: together they may not fit into memory.
        let moves = run.moves().map_err(Error::Input)?;
        vtk_fits(moves).map_err(Error::Input)?;
        replace_folder(&place, FRAMES, arguments.force, &mut |beside| frames(beside, moves, &interrupt))?;
    } else {
        free(&place, arguments.force)?;
        let record = match format {
            Format::Gltf => Record::default(),
            _ => record(&arguments.run, &run)?,
        };
        for (_, bytes) in of_run(format, &run, &record).map_err(Error::Input)? {
            replace(&place, &bytes)?;
        }
    }
    say::unless(arguments.quiet, || format!("{}\n", place.display()))
}

/// The record of a run as it was written; of the rig each run has a folder inside.
fn record(folder: &Path, run: &ShownRun) -> Result<Record, Error> {
    let inside = run.name.split_once('/').map(|(_, name)| folder.join(name));
    let folder = inside.as_deref().filter(|inside| inside.is_dir()).unwrap_or(folder);
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
fn frames(folder: &Path, motion: &RunMotion, interrupt: &Interrupt) -> Result<(), Error> {
    let mut files = Vec::new();
    for i in 0..motion.frames() {
        interrupt.check()?;
        let name = format!("frame_{i:05}.vtk");
        let path = folder.join(&name);
        fs::write(&path, vtk(motion, i)).map_err(|source| Error::file(&path, source))?;
        files.push((name, motion.t[i]));
    }
    let path = folder.join(SERIES);
    fs::write(&path, series(&files)).map_err(|source| Error::file(&path, source))
}
