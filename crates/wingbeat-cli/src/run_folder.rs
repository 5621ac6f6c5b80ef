//! The folder of a run: written under another name and moved when it is whole.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process;

use serde::Serialize;

use crate::error::Error;

/// The file that tells a run folder from any other folder.
const MANIFEST: &str = "manifest.json";

/// A run folder while it is written. Dropped before [`RunFolder::finish`], it leaves nothing, unless it can be resumed.
#[derive(Debug)]
pub struct RunFolder {
    partial: PathBuf,
    target: PathBuf,
    keep: bool,
}

impl RunFolder {
    /// Begins the folder `out`, or else `runs/<name>`, `runs/<name>-2` and so on, the first that is free.
    ///
    /// # Errors
    /// `out` holds something, unless it is a run folder and `force` allows to replace it.
    pub fn create(out: Option<&Path>, name: &str, force: bool) -> Result<Self, Error> {
        Self::begin(target(out, name, force)?, &format!("partial-{}", process::id()), false)
    }

    /// Begins a folder as [`RunFolder::create`] does, or takes up what an interrupted run of the same name left, if
    /// its file `identity` holds `text`.
    pub fn resume(
        out: Option<&Path>,
        name: &str,
        force: bool,
        (identity, text): (&str, &str),
    ) -> Result<Self, Error> {
        let folder = Self::begin(target(out, name, force)?, "partial", true)?;
        if fs::read_to_string(folder.file(identity)).is_ok_and(|left| left == text) {
            return Ok(folder);
        }
        fs::remove_dir_all(&folder.partial).map_err(|source| Error::file(&folder.partial, source))?;
        fs::create_dir_all(&folder.partial).map_err(|source| Error::file(&folder.partial, source))?;
        folder.write(identity, text)?;
        Ok(folder)
    }

    fn begin(target: PathBuf, mark: &str, keep: bool) -> Result<Self, Error> {
        let label = target.file_name().map_or("run".into(), |name| name.to_string_lossy().into_owned());
        let partial = target.with_file_name(format!(".{label}.{mark}"));
        fs::create_dir_all(&partial).map_err(|source| Error::file(&partial, source))?;
        Ok(Self { partial, target, keep })
    }

    /// Path of a file inside, while the folder is written.
    pub fn file(&self, name: &str) -> PathBuf {
        self.partial.join(name)
    }

    /// Makes a folder inside.
    pub fn folder(&self, name: &str) -> Result<PathBuf, Error> {
        let path = self.file(name);
        fs::create_dir_all(&path).map_err(|source| Error::file(&path, source))?;
        Ok(path)
    }

    /// Writes a text file inside.
    pub fn write(&self, name: &str, text: &str) -> Result<(), Error> {
        let path = self.file(name);
        fs::write(&path, text).map_err(|source| Error::file(&path, source))
    }

    /// Writes a JSON file inside.
    pub fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(value).map_err(io::Error::from);
        let text = text.map_err(|source| Error::file(&self.file(name), source))?;
        self.write(name, &(text + "\n"))
    }

    /// Writes the manifest and moves the folder to its name, which is returned.
    pub fn finish(mut self, manifest: &impl Serialize) -> Result<PathBuf, Error> {
        self.write_json(MANIFEST, manifest)?;
        let replaced = self.partial.with_extension("replaced");
        let moved = |from: &Path, to: &Path| fs::rename(from, to).map_err(|source| Error::file(to, source));
        if is_run(&self.target) {
            moved(&self.target, &replaced)?;
        }
        moved(&self.partial, &self.target)?;
        self.keep = true;
        if replaced.exists() {
            fs::remove_dir_all(&replaced).map_err(|source| Error::file(&replaced, source))?;
        }
        Ok(self.target.clone())
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if !self.keep {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

/// The folder asked for, or else the first free one of `name`.
fn target(out: Option<&Path>, name: &str, force: bool) -> Result<PathBuf, Error> {
    match out {
        Some(out) => checked(out, force),
        None => Ok(free(Path::new("runs"), name)),
    }
}

/// The folder asked for, when a run may take its place.
fn checked(out: &Path, force: bool) -> Result<PathBuf, Error> {
    let empty = match fs::read_dir(out) {
        Ok(mut entries) => entries.next().is_none(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => true,
        Err(source) => return Err(Error::file(out, source)),
    };
    if empty || (force && is_run(out)) {
        return std::path::absolute(out).map_err(|source| Error::file(out, source));
    }
    let allowed = if is_run(out) {
        "a new or empty folder; --force replaces this earlier run"
    } else {
        "a new or empty folder; this one holds other files"
    };
    Err(Error::Input(format!("--out {}: allowed is {allowed}", out.display())))
}

/// The first of `name`, `name-2`, `name-3`, ... that is not taken.
fn free(parent: &Path, name: &str) -> PathBuf {
    let names = std::iter::once(name.to_owned()).chain((2..).map(|number| format!("{name}-{number}")));
    names.map(|name| parent.join(name)).find(|path| !path.exists()).unwrap_or_else(|| parent.join(name))
}

fn is_run(path: &Path) -> bool {
    path.join(MANIFEST).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scratch(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("wingbeat-{name}-{}", process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        path
    }

    fn entries(path: &Path) -> usize {
        fs::read_dir(path).unwrap().count()
    }

    #[test]
    fn a_run_appears_whole_or_not_at_all() {
        let parent = scratch("whole");
        let out = parent.join("a");
        let folder = RunFolder::create(Some(&out), "x", false).unwrap();
        folder.write("scenario.toml", "x = 1\n").unwrap();
        assert!(!out.exists());
        drop(folder);
        assert_eq!(entries(&parent), 0);
        RunFolder::create(Some(&out), "x", false).unwrap().finish(&"m").unwrap();
        assert_eq!(entries(&parent), 1);
        assert!(out.join(MANIFEST).is_file());
        fs::remove_dir_all(parent).unwrap();
    }

    #[test]
    fn only_force_replaces_a_run_and_nothing_replaces_other_files() {
        let parent = scratch("force");
        let out = parent.join("a");
        RunFolder::create(Some(&out), "x", false).unwrap().finish(&1).unwrap();
        let refused = RunFolder::create(Some(&out), "x", false).unwrap_err();
        assert!(refused.to_string().contains("--force"), "{refused}");
        RunFolder::create(Some(&out), "x", true).unwrap().finish(&2).unwrap();
        assert_eq!(fs::read_to_string(out.join(MANIFEST)).unwrap(), "2\n");
        assert_eq!(entries(&parent), 1);
        assert!(RunFolder::create(Some(&parent), "x", true).is_err());
        fs::remove_dir_all(parent).unwrap();
    }

    #[test]
    fn an_interrupted_run_is_taken_up_only_by_its_like() {
        let parent = scratch("resume");
        let out = parent.join("a");
        let resume = |text: &str| RunFolder::resume(Some(&out), "x", false, ("sweep.toml", text)).unwrap();
        resume("one").write("log", "flown").unwrap();
        assert!(resume("one").file("log").exists());
        assert!(!resume("two").file("log").exists());
        resume("two").finish(&1).unwrap();
        assert_eq!(entries(&parent), 1);
        fs::remove_dir_all(parent).unwrap();
    }

    #[test]
    fn names_count_up() {
        let parent = scratch("names");
        assert_eq!(free(&parent, "turn"), parent.join("turn"));
        fs::create_dir(parent.join("turn")).unwrap();
        assert_eq!(free(&parent, "turn"), parent.join("turn-2"));
        fs::remove_dir_all(parent).unwrap();
    }
}
