//! Where samples lie, which run they are of, and what processing all of them gives.

use std::fs;
use std::path::{Path, PathBuf};

use wingbeat::parallel;
use wingbeat::scenario::{
    CombinedRuns, ProcessedRun, RigRun, subtract_still_air, text_of, together as combined,
};

use super::{ProcessSummary, ProcessedFile};

/// A file of samples and its run.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSource {
    /// The samples.
    pub samples: PathBuf,
    /// The file of the run; none where the caller gives the run.
    pub run: Option<PathBuf>,
    /// Begin and end of what is averaged, s, where a simulation says it.
    pub window: Option<(f64, f64)>,
}

impl SampleSource {
    /// The samples at `path`: a file, a folder with record.parquet, or a folder of such folders. All are of the run of the caller where one
    /// is `given`; else each folder holds the scenario.toml of its own, and `give` says how to give one.
    ///
    /// # Errors
    /// What cannot be read or found, in words.
    pub fn find(path: &Path, given: bool, give: &str) -> Result<Vec<Self>, String> {
        let unread = |source: std::io::Error| format!("{}: {source}", path.display());
        if !path.is_dir() {
            fs::metadata(path).map_err(unread)?;
            return Ok(vec![Self::measured(path, given, give)?]);
        }
        if holds(path) {
            return Ok(vec![Self::of_folder(path, given, give)?]);
        }
        let entries = fs::read_dir(path).map_err(unread)?;
        let mut found: Vec<PathBuf> = entries.filter_map(Result::ok).map(|entry| entry.path()).collect();
        let hidden =
            |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        found.retain(|path| holds(path) && !hidden(path));
        found.sort();
        if found.is_empty() {
            return Err(format!(
                "{}: no record.parquet in it or in a folder in it: allowed are a folder of rig simulate or rig record, \
                 or a file of samples",
                path.display()
            ));
        }
        found.iter().map(|path| Self::of_folder(path, given, give)).collect()
    }

    fn of_folder(path: &Path, given: bool, give: &str) -> Result<Self, String> {
        let samples = path.join("record.parquet");
        let scenario = path.join("scenario.toml");
        if given || !scenario.is_file() {
            return Self::measured(&samples, given, give);
        }
        let file = path.join("summary.json");
        let text = text_of(&file).map_err(|source| format!("{}: {source}", file.display()))?;
        let summary: serde_json::Value =
            serde_json::from_str(&text).map_err(|error| format!("{}: {error}", file.display()))?;
        let window = || match summary.get("window_s")?.as_array()?.as_slice() {
            [begin, end] => Some((begin.as_f64()?, end.as_f64()?)),
            _ => None,
        };
        let window = window().ok_or_else(|| {
            format!("{}: window_s: allowed are begin and end of what is averaged, s", file.display())
        })?;
        Ok(Self { samples, run: Some(scenario), window: Some(window) })
    }

    fn measured(samples: &Path, given: bool, give: &str) -> Result<Self, String> {
        let unknown = || {
            format!("{}: the file does not say which run it is of: give it with {give}", samples.display())
        };
        given.then(|| Self { samples: samples.into(), run: None, window: None }).ok_or_else(unknown)
    }

    /// The samples processed as `run`.
    ///
    /// # Errors
    /// Samples that cannot be those of the run, in words.
    pub fn processed(&self, run: RigRun) -> Result<(ProcessedRun, ProcessedFile), String> {
        let file = self.samples.clone();
        let named = |what: String| format!("{}: {what}", file.display());
        let input = &run.spec.process.input;
        let read = wingbeat_io::samples::read_samples(&file, input).and_then(|read| read.import(input));
        let imported = read.map_err(|error| error.to_string())?;
        let evaluated = run.evaluated(imported.record, self.window);
        let evaluated = evaluated.map_err(|error| named(run.explain(&error).to_string()))?;
        let (result, window) = evaluated.map_err(named)?;
        Ok((ProcessedRun { run, result }, ProcessedFile { file, import: imported.import, window }))
    }
}

fn holds(folder: &Path) -> bool {
    folder.join("record.parquet").is_file()
}

/// Runs that were processed together.
pub struct ProcessedTogether {
    /// Each with what it gave.
    pub runs: Vec<ProcessedRun>,
    /// What several say together; none of static tilts alone.
    pub together: Option<CombinedRuns>,
    /// The contents of summary.json.
    pub summary: ProcessSummary,
}

impl ProcessedTogether {
    /// The samples of all `sources`, each as the run that `load` gives for it.
    ///
    /// # Errors
    /// The first of them that cannot be processed, and runs that do not belong together, in words.
    pub fn of(
        sources: &[SampleSource],
        load: impl Fn(&SampleSource) -> Result<RigRun, String> + Sync,
    ) -> Result<Self, String> {
        let answers = parallel::map(sources, |_, source| source.processed(load(source)?));
        let answers = answers.into_iter().collect::<Result<Vec<_>, String>>()?;
        let (mut runs, files): (Vec<ProcessedRun>, Vec<_>) = answers.into_iter().unzip();
        for (k, run) in runs.iter().enumerate() {
            if runs[..k].iter().any(|other| other.name().eq_ignore_ascii_case(run.name())) {
                let what = "allowed is one run of a name: give each its run, or process them one by one";
                let name = run.name();
                return Err(format!(
                    "{}: a second run called {name:?}; {what}",
                    sources[k].samples.display()
                ));
            }
        }
        subtract_still_air(&mut runs).map_err(|error| error.to_string())?;
        let together = combined(&runs).map_err(|error| error.to_string())?;
        let summary = ProcessSummary::new(&runs, &files, together.as_ref());
        Ok(Self { runs, together, summary })
    }
}
