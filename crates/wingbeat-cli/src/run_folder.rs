//! The folder of a run: written under another name and moved when it is whole.

use std::fs::{self, File};
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
    /// The folder, locked: a lock that can be had shows that its owner is dead.
    _owner: File,
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
        if folder.holds(identity, text) {
            return Ok(folder);
        }
        folder.clear()?;
        folder.write(identity, text)?;
        Ok(folder)
    }

    /// Begins or takes up a folder as [`RunFolder::resume`] does, but leaves alone what cannot be made again.
    ///
    /// # Errors
    /// A folder left by a run whose file `identity` holds another text.
    pub fn resume_measured(out: &Path, force: bool, (identity, text): (&str, &str)) -> Result<Self, Error> {
        let folder = Self::begin(checked(out, force)?, "partial", true)?;
        let left = fs::read_dir(&folder.partial).map_err(|source| Error::file(&folder.partial, source))?;
        if left.count() == 0 {
            folder.write(identity, text)?;
        } else if !folder.holds(identity, text) {
            return Err(Error::Input(format!(
                "--out {}: an unfinished recording with other settings waits in {}; finish it with the settings of \
                 its {identity}, move it away, or record to another folder",
                out.display(),
                folder.partial.display()
            )));
        }
        Ok(folder)
    }

    fn begin(target: PathBuf, mark: &str, keep: bool) -> Result<Self, Error> {
        remove_orphans(&target);
        let partial = target.with_file_name(format!(".{}.{mark}", label(&target)));
        let failed = |source| Error::file(&partial, source);
        fs::create_dir_all(&partial).map_err(failed)?;
        let owner = File::open(&partial).map_err(failed)?;
        if owner.try_lock().is_err() {
            let (out, partial) = (target.display(), partial.display());
            return Err(Error::Input(format!("--out {out}: another command is writing {partial}")));
        }
        Ok(Self { partial, target, keep, _owner: owner })
    }

    fn holds(&self, identity: &str, text: &str) -> bool {
        fs::read_to_string(self.file(identity)).is_ok_and(|left| left == text)
    }

    /// Removes everything inside.
    fn clear(&self) -> Result<(), Error> {
        let failed = |source| Error::file(&self.partial, source);
        for entry in fs::read_dir(&self.partial).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let removed = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
            removed.map_err(failed)?;
        }
        Ok(())
    }

    /// Leaves nothing, though it could be resumed.
    pub fn discard(mut self) {
        self.keep = false;
    }

    /// Where the folder is while it is written.
    pub fn partial(&self) -> &Path {
        &self.partial
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
        let replaced = replaced(&self.target);
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

fn label(target: &Path) -> String {
    target.file_name().map_or("run".into(), |name| name.to_string_lossy().into_owned())
}

/// Where an earlier run waits while a new one takes its name.
fn replaced(target: &Path) -> PathBuf {
    target.with_file_name(format!(".{}.replaced", label(target)))
}

/// Removes, and says so, what commands that were killed left of a run called `target`.
fn remove_orphans(target: &Path) {
    let start = format!(".{}.partial-", label(target));
    let entries = target.parent().and_then(|parent| fs::read_dir(parent).ok());
    for path in entries.into_iter().flatten().flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let by_number = name.strip_prefix(&start).is_some_and(|id| id.parse::<u32>().is_ok());
        let orphan = by_number && File::open(&path).is_ok_and(|folder| folder.try_lock().is_ok());
        if orphan && fs::remove_dir_all(&path).is_ok() {
            eprintln!("removed {}, left by a command that was killed", path.display());
        }
    }
}

/// Brings an earlier run back to its name when the command that was to replace it was killed in between.
fn restore(target: &Path) -> io::Result<()> {
    let replaced = replaced(target);
    match (replaced.exists(), target.exists()) {
        (true, false) => fs::rename(replaced, target),
        (true, true) => fs::remove_dir_all(replaced),
        (false, _) => Ok(()),
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
    restore(out).map_err(|source| Error::file(out, source))?;
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
    fn what_a_killed_command_left_goes_and_what_a_living_one_writes_stays() {
        let parent = scratch("orphans");
        let out = parent.join("a");
        let left = parent.join(".a.partial-4294967295");
        for folder in [&left, &parent.join(".a.partial-x"), &parent.join(".b.partial-4294967295")] {
            fs::create_dir(folder).unwrap();
        }
        let living = RunFolder::create(Some(&out), "x", false).unwrap();
        assert!(!left.exists() && living.partial().exists());
        remove_orphans(&out);
        assert!(living.partial().exists());
        drop(living);
        assert_eq!(entries(&parent), 2);
        let resumed = RunFolder::resume(Some(&out), "x", false, ("i", "1")).unwrap();
        let second = RunFolder::resume(Some(&out), "x", false, ("i", "1")).unwrap_err();
        assert!(second.to_string().contains("another command"), "{second}");
        drop(resumed);
        fs::remove_dir_all(parent).unwrap();
    }

    #[test]
    fn a_run_that_was_to_be_replaced_comes_back() {
        let parent = scratch("restore");
        let out = parent.join("a");
        RunFolder::create(Some(&out), "x", false).unwrap().finish(&1).unwrap();
        fs::rename(&out, parent.join(".a.replaced")).unwrap();
        RunFolder::create(Some(&out), "x", true).unwrap().finish(&2).unwrap();
        assert_eq!(fs::read_to_string(out.join(MANIFEST)).unwrap(), "2\n");
        assert_eq!(entries(&parent), 1);
        fs::remove_dir_all(parent).unwrap();
    }

    #[test]
    fn an_unfinished_recording_is_never_thrown_away() {
        let parent = scratch("measured");
        let out = parent.join("a");
        let resume = |text: &str| RunFolder::resume_measured(&out, false, ("recording.json", text));
        resume("one").unwrap().write("raw", "rows").unwrap();
        assert!(resume("two").unwrap_err().to_string().contains(".a.partial"));
        assert!(resume("one").unwrap().file("raw").exists());
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
