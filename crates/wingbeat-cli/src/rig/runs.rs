//! One run or a list of runs, and work shared among the cores.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use serde::Deserialize;
use wingbeat::scenario::{Document, RigRun};

use crate::error::Error;

/// A file that lists runs.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    /// Run files, relative to the list.
    runs: Vec<PathBuf>,
}

/// Reads one run; its arm may be a URDF file.
pub fn run(file: &Path, overrides: &[String]) -> Result<RigRun, Error> {
    Ok(RigRun::load_translated(file, overrides, &wingbeat_io::urdf_as_toml)?)
}

/// Reads the runs of `file`: itself, or those that it lists.
pub fn load(file: &Path, overrides: &[String]) -> Result<Vec<RigRun>, Error> {
    let text = std::fs::read_to_string(file).map_err(|source| Error::file(file, source))?;
    let listed = text.lines().any(|line| line.split('=').next().is_some_and(|key| key.trim() == "runs"));
    if !listed {
        return Ok(vec![run(file, overrides)?]);
    }
    let list: List = Document::load(file, &[], &[])?.parse()?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let runs = list.runs.iter().map(|name| run(&folder.join(name), overrides));
    let runs = runs.collect::<Result<Vec<_>, _>>()?;
    for (k, run) in runs.iter().enumerate() {
        if runs[..k].iter().any(|earlier| earlier.spec.name == run.spec.name) {
            let name = &run.spec.name;
            return Err(Error::Input(format!("{}: two runs are called {name}", file.display())));
        }
    }
    Ok(runs)
}

/// `work` on every item, on all cores; the answers in the order of the items.
pub fn shared<T: Sync, R: Send>(items: &[T], work: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let answers: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(items.len()));
    let cores = thread::available_parallelism().map_or(1, NonZero::get).min(items.len().max(1));
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some((index, item)) = {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    items.get(index).map(|item| (index, item))
                } {
                    let answer = work(index, item);
                    answers.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push((index, answer));
                }
            });
        }
    });
    let mut answers = answers.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    answers.sort_by_key(|answer| answer.0);
    answers.into_iter().map(|answer| answer.1).collect()
}
