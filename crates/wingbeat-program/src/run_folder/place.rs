//! Where a run folder may stand: settled before any work.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use wingbeat::scenario::RunName;

use crate::error::Error;

/// Longest last name of `--out`, bytes: its hidden neighbour's name is longer. *Choice.*
const LONGEST: usize = 200;
/// Most names that are tried: NAME, NAME-2, ...
const NUMBERS: usize = 10_000;

/// What was asked for.
#[derive(Clone, Debug)]
pub enum FolderRequest<'a> {
    /// The folder of `--out`.
    Out(&'a Path),
    /// The first free one of NAME, NAME-2, ... in a folder.
    Named(PathBuf, RunName),
}

/// A settled parent and the names to try in it.
#[derive(Debug)]
pub struct FolderPlace {
    /// The folder above, without links.
    pub parent: PathBuf,
    /// Folders that were made for it, inner ones first.
    pub made: MadeFolders,
    /// The name, and whether numbers may be added to it.
    name: String,
    counted: bool,
}

/// Folders that were made on the way; those that are empty go again, unless kept.
#[derive(Debug, Default)]
pub struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Leaves them.
    pub fn keep(&mut self) {
        self.0.clear();
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in &self.0 {
            let _ = fs::remove_dir(folder);
        }
    }
}

impl FolderRequest<'_> {
    /// How messages call it.
    pub fn words(&self) -> String {
        match self {
            Self::Out(out) => format!("--out {}", out.display()),
            Self::Named(parent, name) => format!("{}", parent.join(name.as_str()).display()),
        }
    }

    /// A refusal of it.
    pub fn refused(&self, allowed: impl std::fmt::Display) -> Error {
        Error::Input(format!("{}: allowed is {allowed}", self.words()))
    }

    /// Settles the parent, which is made where it is missing.
    ///
    /// # Errors
    /// A path that is no text, ends in no name, or whose parent cannot be.
    pub fn settle(&self) -> Result<FolderPlace, Error> {
        let (parent, name, counted) = match self {
            Self::Named(parent, name) => (parent.as_path(), name.to_string(), true),
            Self::Out(out) => {
                let text = out.to_str().ok_or_else(|| self.refused("a path in UTF-8"))?;
                let name = out.file_name().and_then(|name| name.to_str());
                let name = name.filter(|name| !text.is_empty() && name.len() <= LONGEST);
                let name = name.filter(|name| !name.chars().any(char::is_control));
                let allowed = "a path that ends in the name of a folder, which may not be there yet";
                let name = name.ok_or_else(|| self.refused(allowed))?;
                (out.parent().unwrap_or(Path::new("")), name.to_owned(), false)
            }
        };
        let parent = if parent.as_os_str().is_empty() { Path::new(".") } else { parent };
        let failed =
            |source: io::Error| Error::Input(format!("{}: {}: {source}", self.words(), parent.display()));
        let made = make(parent).map_err(failed)?;
        let parent = fs::canonicalize(parent).map_err(failed)?;
        Ok(FolderPlace { parent, made, name, counted })
    }

    /// Refuses a link, a file or a mount point at `target`, which cannot be moved to.
    pub fn check(&self, target: &Path) -> Result<(), Error> {
        let data = match fs::symlink_metadata(target) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            other => other.map_err(|source| Error::Input(format!("{}: {source}", self.words())))?,
        };
        if data.is_symlink() {
            let to = fs::read_link(target).unwrap_or_default();
            return Err(self.refused(format!("a folder itself; this is a link to {}", to.display())));
        }
        if !data.is_dir() {
            return Err(self.refused("a folder; this is a file"));
        }
        if is_mounted(target, &data) {
            return Err(
                self.refused("a folder below it: this is a mount point, which no run can take the place of")
            );
        }
        Ok(())
    }
}

impl FolderPlace {
    /// The folders to try, in order.
    pub fn targets(&self) -> impl Iterator<Item = PathBuf> + '_ {
        let numbers = if self.counted { 1..=NUMBERS } else { 1..=1 };
        numbers.map(|number| self.parent.join(numbered(&self.name, number)))
    }

    /// Whether there are other names to try.
    pub fn counts(&self) -> bool {
        self.counted
    }
}

/// NAME, NAME-2, NAME-3, ...
pub fn numbered(name: &str, number: usize) -> String {
    if number == 1 { name.into() } else { format!("{name}-{number}") }
}

/// Makes `folder` and those above it, unless they are there.
fn make(folder: &Path) -> io::Result<MadeFolders> {
    let upward = folder.components().skip_while(|part| !matches!(part, Component::Normal(_)));
    let missing: Vec<&Path> = folder.ancestors().take_while(|path| !is_there(path)).collect();
    if !missing.is_empty() && upward.into_iter().any(|part| part == Component::ParentDir) {
        let why = "no such folder; .. behind a folder that is not there names nothing";
        return Err(io::Error::new(io::ErrorKind::NotFound, why));
    }
    fs::create_dir_all(folder)?;
    Ok(MadeFolders(missing.into_iter().map(Path::to_path_buf).collect()))
}

fn is_there(path: &Path) -> bool {
    path.as_os_str().is_empty() || fs::symlink_metadata(path).is_ok()
}

#[cfg(unix)]
fn is_mounted(target: &Path, data: &fs::Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    let above = target.parent().and_then(|parent| fs::metadata(parent).ok());
    let listed = fs::read_to_string("/proc/self/mountinfo").is_ok_and(|table| {
        table.lines().filter_map(|line| line.split(' ').nth(4)).any(|point| Path::new(point) == target)
    });
    listed || above.is_some_and(|above| above.dev() != data.dev())
}

#[cfg(not(unix))]
fn is_mounted(_: &Path, _: &fs::Metadata) -> bool {
    false
}
