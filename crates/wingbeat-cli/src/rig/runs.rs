//! One run or a list of runs, with arms of any format.

use std::path::Path;

use wingbeat::scenario::{Document, RigRun};
use wingbeat_io::urdf_as_toml;

use crate::error::Error;

/// Reads one run; its arm may be a URDF file.
pub fn run(file: &Path, overrides: &[String]) -> Result<RigRun, Error> {
    Ok(RigRun::new(Document::file(file)?.overridden(overrides), &urdf_as_toml)?
        .through(&wingbeat_lattice::doors()))
}

/// Reads the runs of `file`: itself, or those that it lists.
pub fn load(file: &Path, overrides: &[String]) -> Result<Vec<RigRun>, Error> {
    let runs = RigRun::load_all(Document::file(file)?, overrides, &urdf_as_toml)?;
    Ok(runs.into_iter().map(|run| run.through(&wingbeat_lattice::doors())).collect())
}
