//! Where samples lie and which run they are of.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::scenario::text_of;

use super::super::simulate::MeasuredWindow;
use crate::error::Error;

/// A file of samples and its run.
pub struct SampleSource {
    /// The samples.
    pub samples: PathBuf,
    /// The run's file.
    pub run: PathBuf,
    /// Begin and end of what is averaged, s, where a simulation says it.
    pub window: Option<(f64, f64)>,
}

/// The samples at `path`: a file, a folder with record.parquet, or a folder of such folders. Those without
/// a scenario.toml are of the run `run`.
pub fn find(path: &Path, run: Option<&Path>) -> Result<Vec<SampleSource>, Error> {
    if !path.is_dir() {
        fs::metadata(path).map_err(|source| Error::file(path, source))?;
        return Ok(vec![measured(path, run)?]);
    }
    if holds(path) {
        return Ok(vec![folder(path, run)?]);
    }
    let entries = fs::read_dir(path).map_err(|source| Error::file(path, source))?;
    let mut found: Vec<PathBuf> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
    let hidden =
        |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    found.retain(|path| holds(path) && !hidden(path));
    found.sort();
    if found.is_empty() {
        return Err(Error::Input(format!(
            "{}: no record.parquet in it or in a folder in it: allowed are a folder of rig simulate or rig record, \
             or a file of samples",
            path.display()
        )));
    }
    found.iter().map(|path| folder(path, run)).collect()
}

fn holds(folder: &Path) -> bool {
    folder.join("record.parquet").is_file()
}

fn folder(path: &Path, run: Option<&Path>) -> Result<SampleSource, Error> {
    let samples = path.join("record.parquet");
    let scenario = path.join("scenario.toml");
    if run.is_some() || !scenario.is_file() {
        return measured(&samples, run);
    }
    let file = path.join("summary.json");
    let text = text_of(&file).map_err(|source| Error::file(&file, source))?;
    let summary: MeasuredWindow =
        serde_json::from_str(&text).map_err(|error| Error::Input(format!("{}: {error}", file.display())))?;
    Ok(SampleSource { samples, run: scenario, window: Some(summary.window_s) })
}

fn measured(samples: &Path, run: Option<&Path>) -> Result<SampleSource, Error> {
    let run = run.ok_or_else(|| {
        Error::Input(format!(
            "{}: the file does not say which run it is of: give it with --run RUN.toml",
            samples.display()
        ))
    })?;
    Ok(SampleSource { samples: samples.into(), run: run.into(), window: None })
}
