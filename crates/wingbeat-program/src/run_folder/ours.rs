//! Which files a run folder's own manifest lists, and what else lies there.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use serde::Deserialize;

use super::{MANIFEST, PROGRAM};

/// What of a manifest is read again.
#[derive(Deserialize)]
struct OwnManifest {
    program: String,
    files: Vec<PathBuf>,
}

/// A finished run of ours: nothing lies there but what its manifest lists.
#[derive(Debug)]
pub struct Ours {
    folder: PathBuf,
    files: BTreeSet<PathBuf>,
    folders: BTreeSet<PathBuf>,
}

impl Ours {
    /// Looks at `folder`.
    ///
    /// # Errors
    /// Why it may not be replaced, in words.
    pub fn at(folder: &Path) -> Result<Self, String> {
        let text = fs::read_to_string(folder.join(MANIFEST));
        let text = text.map_err(|_| format!("it has no {MANIFEST} that could be read"))?;
        let listed: OwnManifest = serde_json::from_str(&text)
            .map_err(|_| format!("its {MANIFEST} does not list the files of a run of wingbeat"))?;
        if listed.program != PROGRAM {
            return Err(format!("its {MANIFEST} is of another program"));
        }
        let inside = |path: &PathBuf| {
            path.components().all(|part| matches!(part, Component::Normal(_)))
                && path.components().count() > 0
        };
        if !listed.files.iter().all(inside) {
            return Err(format!("its {MANIFEST} lists files outside of it"));
        }
        let mut files: BTreeSet<PathBuf> = listed.files.into_iter().collect();
        files.insert(MANIFEST.into());
        let above = |file: &PathBuf| file.ancestors().skip(1).map(Path::to_path_buf).collect::<Vec<_>>();
        let folders: BTreeSet<PathBuf> =
            files.iter().flat_map(above).filter(|path| !path.as_os_str().is_empty()).collect();
        // A run that failed may have left this one empty.
        let folders = folders.into_iter().chain([PathBuf::from("figures")]).collect();
        let ours = Self { folder: folder.into(), files, folders };
        ours.check(Path::new(""))?;
        Ok(ours)
    }

    /// Refuses what is not listed, or is not a regular file.
    fn check(&self, below: &Path) -> Result<(), String> {
        let path = self.folder.join(below);
        let told = |error: io::Error| format!("{}: {error}", path.display());
        for entry in fs::read_dir(&path).map_err(told)? {
            let entry = entry.map_err(told)?;
            let (name, kind) = (below.join(entry.file_name()), entry.file_type().map_err(told)?);
            if kind.is_dir() && self.folders.contains(&name) {
                self.check(&name)?;
            } else if !kind.is_file() || !self.files.contains(&name) {
                return Err(format!("{} is not among the files that its {MANIFEST} lists", name.display()));
            }
        }
        Ok(())
    }

    /// Removes the listed files, at the place `moved` to which the folder was moved, and the folders that are then
    /// empty.
    pub fn remove(&self, moved: &Path) -> io::Result<()> {
        let gone = |outcome: io::Result<()>| match outcome {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
        // The manifest last: what a killed command leaves of it still says what it is.
        let others = self.files.iter().filter(|file| *file != Path::new(MANIFEST));
        others.map(|file| moved.join(file)).try_for_each(|file| gone(fs::remove_file(file)))?;
        gone(fs::remove_file(moved.join(MANIFEST)))?;
        self.folders.iter().rev().try_for_each(|folder| gone(fs::remove_dir(moved.join(folder))))?;
        fs::remove_dir(moved)
    }
}

/// The files below `folder`, by their paths from there, sorted.
pub fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    gather(folder, Path::new(""), &mut found)?;
    found.sort();
    Ok(found)
}

fn gather(folder: &Path, below: &Path, found: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder.join(below))? {
        let entry = entry?;
        let name = below.join(entry.file_name());
        if entry.file_type()?.is_dir() { gather(folder, &name, found)? } else { found.push(name) }
    }
    Ok(())
}
