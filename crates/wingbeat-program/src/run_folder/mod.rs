//! The folder of a run: reserved and locked under a hidden name before work begins, moved to its name when it is whole.

mod ours;
mod place;

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use wingbeat::scenario::RunName;
use wingbeat_io::checksum;

use crate::error::Error;
use crate::interrupt::Unfinished;
use crate::say::note;
use ours::Ours;
use place::{FolderRequest, MadeFolders, numbered};

/// The file that tells a run folder from any other folder.
const MANIFEST: &str = "manifest.json";
/// The file that says of a folder that its run is not finished.
const MARK: &str = "unfinished.json";
/// What both say that they are of.
const PROGRAM: &str = "wingbeat";

/// A run folder while it is written. Dropped before [`RunFolder::finish`], it leaves nothing, unless it can be resumed.
#[derive(Debug)]
pub struct RunFolder {
    partial: PathBuf,
    target: PathBuf,
    /// How messages call it.
    words: String,
    /// The run of ours that it replaces.
    replaces: bool,
    keep: bool,
    made: MadeFolders,
    /// What goes when the program must end at once.
    unfinished: Unfinished,
    /// The folder, locked: a lock that can be had shows that its owner is dead.
    _owner: File,
}

/// The contents of [`MARK`].
#[derive(Serialize, Deserialize)]
struct Mark {
    program: String,
    /// Whether the same command goes on from there.
    resumes: bool,
}

/// The manifest with what it is of and the files of its run.
#[derive(Serialize)]
struct ManifestRecord<'a, M> {
    program: &'static str,
    #[serde(flatten)]
    manifest: &'a M,
    files: Vec<PathBuf>,
    /// What [`checksum`] says of each.
    checksums: BTreeMap<String, String>,
}

/// Whether a folder is begun anew, or goes on from what an interrupted command left.
#[derive(Clone, Copy)]
enum FolderMode<'a> {
    Anew,
    /// A file, and the text that it must hold.
    GoesOn(&'a str, &'a str),
}

/// What lies in a hidden folder.
enum HiddenContent {
    Nothing,
    /// What the command goes on from.
    Ours,
    /// What a killed command left that could not be gone on from.
    Dead,
    /// What must stay, and why.
    Other(String),
}

/// Why a name cannot be had.
enum NameRefusal {
    /// Another one may be had.
    Busy(String),
    /// Nothing can.
    Failed(Error),
}

impl RunFolder {
    /// Begins the folder `out`, or else `runs/<name>`, `runs/<name>-2` and so on, the first that is free.
    ///
    /// # Errors
    /// `out` holds something, unless it is a run of ours alone and `force` allows to replace it.
    pub fn create(out: Option<&Path>, name: &RunName, force: bool) -> Result<Self, Error> {
        Self::begin(&wanted(out, Path::new("runs"), name), force, FolderMode::Anew)
    }

    /// Begins the folder `out`, or else the first free one of `<name>`, `<name>-2` and so on in `parent`.
    ///
    /// # Errors
    /// Those of [`create`](Self::create).
    pub fn create_in(out: Option<&Path>, parent: &Path, name: &RunName, force: bool) -> Result<Self, Error> {
        Self::begin(&wanted(out, parent, name), force, FolderMode::Anew)
    }

    /// Begins a folder as [`RunFolder::create`] does, or takes up what an interrupted run of the same name left, if
    /// its file `identity` holds `text`. What another one left stays.
    ///
    /// # Errors
    /// Those of [`create`](Self::create); `out` waits for a run whose file `identity` holds another text.
    pub fn resume(
        out: Option<&Path>,
        name: &RunName,
        force: bool,
        (identity, text): (&str, &str),
    ) -> Result<Self, Error> {
        Self::begin(&wanted(out, Path::new("runs"), name), force, FolderMode::GoesOn(identity, text))
    }

    /// [`resume`](Self::resume) of the folder `out`.
    ///
    /// # Errors
    /// Those of [`resume`](Self::resume).
    pub fn resume_measured(out: &Path, force: bool, (identity, text): (&str, &str)) -> Result<Self, Error> {
        Self::begin(&FolderRequest::Out(out), force, FolderMode::GoesOn(identity, text))
    }

    fn begin(wanted: &FolderRequest, force: bool, mode: FolderMode) -> Result<Self, Error> {
        let mut place = wanted.settle()?;
        let made = std::mem::take(&mut place.made);
        let mut busy = String::new();
        for target in place.targets() {
            match Self::claim(wanted, &target, force, mode) {
                Ok(mut folder) => {
                    folder.made = made;
                    return Ok(folder);
                }
                Err(NameRefusal::Busy(why)) => busy = why,
                Err(NameRefusal::Failed(error)) => return Err(error),
            }
            if !place.counts() {
                break;
            }
        }
        Err(wanted.refused(busy))
    }

    /// Reserves and locks the hidden folder of `target`, and looks whether `target` may be moved to.
    fn claim(
        wanted: &FolderRequest,
        target: &Path,
        force: bool,
        mode: FolderMode,
    ) -> Result<Self, NameRefusal> {
        let partial = hidden(target, "partial");
        let failed = |source: io::Error| {
            NameRefusal::Failed(Error::Input(format!("{}: {}: {source}", wanted.words(), partial.display())))
        };
        let new = match fs::create_dir(&partial) {
            Ok(()) => true,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => false,
            Err(source) => return Err(failed(source)),
        };
        let busy =
            || NameRefusal::Busy(format!("another folder: another command is writing {}", partial.display()));
        let owner = File::open(&partial).map_err(|_| busy())?;
        if owner.try_lock().is_err() || !is_at(&owner, &partial) {
            return Err(busy());
        }
        // From here on the name is ours; what is not taken is given back.
        let give_back = |taken: NameRefusal| {
            if new {
                let _ = fs::remove_dir(&partial);
            }
            taken
        };
        let replaces = may_move_to(wanted, target, force).map_err(give_back)?;
        let fresh = match left(&partial, mode) {
            HiddenContent::Nothing => true,
            HiddenContent::Ours => false,
            HiddenContent::Dead => {
                clear(&partial).map_err(failed)?;
                note(&format!("removed {}, left by a command that was killed", partial.display()));
                true
            }
            HiddenContent::Other(why) => return Err(give_back(NameRefusal::Busy(why))),
        };
        let resumes = matches!(mode, FolderMode::GoesOn(..));
        let mut folder = Self {
            unfinished: Unfinished::new(&partial, resumes),
            partial,
            target: target.into(),
            words: wanted.words(),
            replaces,
            keep: resumes,
            made: MadeFolders::default(),
            _owner: owner,
        };
        if let Err(error) = folder.mark(mode, fresh) {
            folder.keep &= !fresh;
            return Err(NameRefusal::Failed(error));
        }
        Ok(folder)
    }

    /// Says of the folder that it is not finished, and what it is of.
    fn mark(&self, mode: FolderMode, fresh: bool) -> Result<(), Error> {
        let resumes = matches!(mode, FolderMode::GoesOn(..));
        if fresh || !self.file(MARK).exists() {
            self.write_json(MARK, &Mark { program: PROGRAM.into(), resumes })?;
        }
        match mode {
            FolderMode::GoesOn(identity, text) if fresh => self.write(identity, text),
            _ => Ok(()),
        }
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

    /// Writes the manifest, which lists the files, and moves the folder to its name, which is returned. Where that
    /// name was taken meanwhile, it is the first free one of NAME-2, NAME-3, ..., and a note says so.
    pub fn finish(mut self, manifest: &impl Serialize) -> Result<PathBuf, Error> {
        let failed = |path: &Path| {
            let path = path.to_path_buf();
            move |source| Error::File { path, source }
        };
        let mut files = ours::files(&self.partial).map_err(failed(&self.partial))?;
        // A manifest lies there where the move failed and the same command went on. The mark goes last: at each instant the folder says
        // what it is.
        files.retain(|file| file != Path::new(MANIFEST) && file != Path::new(MARK));
        let mut checksums = BTreeMap::new();
        for file in &files {
            let (path, name) = (self.partial.join(file), file.to_string_lossy().replace('\\', "/"));
            checksums.insert(name, checksum(&path).map_err(failed(&path))?);
        }
        self.write_json(MANIFEST, &ManifestRecord { program: PROGRAM, manifest, files, checksums })?;
        fs::remove_file(self.file(MARK)).map_err(failed(&self.partial))?;
        let _whole = self.unfinished.settle();
        let moved = self.moved()?;
        self.keep = true;
        self.made.keep();
        Ok(moved)
    }

    /// Moves the folder to its name, or another one.
    fn moved(&self) -> Result<PathBuf, Error> {
        let old = self.replaces.then(|| Ours::at(&self.target)).transpose();
        let aside = hidden(&self.target, "replaced");
        let outcome = match &old {
            Ok(None) => fs::rename(&self.partial, &self.target),
            Ok(Some(_)) => {
                fs::rename(&self.target, &aside).and_then(|()| fs::rename(&self.partial, &self.target))
            }
            Err(why) => Err(io::Error::other(why.clone())),
        };
        let Err(why) = outcome else {
            if let Ok(Some(old)) = old {
                old.remove(&aside).map_err(|source| Error::file(&aside, source))?;
            }
            return Ok(self.target.clone());
        };
        if old.is_ok_and(|old| old.is_some()) && !self.target.exists() {
            let _ = fs::rename(&aside, &self.target);
        }
        let label = label(&self.target);
        let others = (2..).map(|number| self.target.with_file_name(numbered(&label, number))).take(1000);
        for other in others.filter(|other| fs::symlink_metadata(other).is_err()) {
            if fs::rename(&self.partial, &other).is_ok() {
                note(&format!(
                    "{} was taken meanwhile ({why}): the run is in {}",
                    self.words,
                    other.display()
                ));
                return Ok(other);
            }
        }
        Err(Error::file(&self.target, why))
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if !self.keep {
            let _ = fs::remove_dir_all(&self.partial);
        }
    }
}

fn wanted<'a>(out: Option<&'a Path>, parent: &Path, name: &RunName) -> FolderRequest<'a> {
    out.map_or_else(|| FolderRequest::Named(parent.into(), name.clone()), FolderRequest::Out)
}

/// The name of the runs of a file, where no run names them.
///
/// # Errors
/// A file name that is none for a folder.
pub fn named_after(file: &Path, out: Option<&Path>) -> Result<RunName, Error> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    match (RunName::new("name", &stem), out) {
        (Err(_), Some(_)) => Ok(RunName::new("name", "runs")?),
        (Err(why), None) => Err(Error::Input(format!(
            "{}: the runs cannot be called after it, give --out DIR: {why}",
            file.display()
        ))),
        (name, _) => Ok(name?),
    }
}

/// Writes the file `name` into the finished run `folder`, in place of an earlier one, and lists it there.
///
/// # Errors
/// A folder that is no run; a file of that name that is none of the run; what cannot be written.
pub fn add_file(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Error> {
    let (manifest, path) = (folder.join(MANIFEST), folder.join(name));
    let not_ours = |why: &str| Error::Input(format!("{}: {why}", manifest.display()));
    let text = fs::read_to_string(&manifest).map_err(|source| Error::file(&manifest, source))?;
    let mut listed: serde_json::Value =
        serde_json::from_str(&text).map_err(|_| not_ours("no manifest of a run of wingbeat"))?;
    if listed["program"] != PROGRAM {
        return Err(not_ours("no manifest of a run of wingbeat"));
    }
    let files = listed["files"].as_array_mut().ok_or_else(|| not_ours("lists no files"))?;
    let known = files.iter().any(|file| file == name);
    if !known && fs::symlink_metadata(&path).is_ok() {
        let why = "is no file of the run; move it, or give --out";
        return Err(Error::Input(format!("{}: {why}", path.display())));
    }
    // Listed first: a file that is not there is no harm, one that is not listed is.
    if !known {
        files.push(name.into());
    }
    // The next reader takes it as it is.
    let forgotten = listed["checksums"].as_object_mut().and_then(|checksums| checksums.remove(name));
    if !known || forgotten.is_some() {
        let text = serde_json::to_string_pretty(&listed).map_err(io::Error::from);
        replace(&manifest, (text.map_err(|source| Error::file(&manifest, source))? + "\n").as_bytes())?;
    }
    replace(&path, bytes)
}

/// Writes a file beside `path` and moves it there, so that it is whole or not there.
///
/// # Errors
/// What cannot be written; then nothing is left.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    replace_by(path, |beside| fs::write(beside, bytes).map_err(|source| Error::file(path, source)))
}

/// The same of a file that `write` writes.
///
/// # Errors
/// Those of `write`; what cannot be moved.
pub fn replace_by(path: &Path, write: impl FnOnce(&Path) -> Result<(), Error>) -> Result<(), Error> {
    let beside = hidden(path, "partial");
    let unfinished = Unfinished::new(&beside, false);
    let moved = || {
        let _whole = unfinished.settle();
        fs::rename(&beside, path).map_err(|source| Error::file(path, source))
    };
    write(&beside).and_then(|()| moved()).inspect_err(|_| {
        let _ = fs::remove_file(&beside);
    })
}

/// Files with numbers, PREFIX0000SUFFIX and so on, and one that lists them.
#[derive(Clone, Copy)]
pub struct Numbered {
    /// What their names begin with.
    pub prefix: &'static str,
    /// What they end with.
    pub suffix: &'static str,
    /// The list.
    pub list: &'static str,
}

impl Numbered {
    fn holds(self, name: &str) -> bool {
        let number = name.strip_prefix(self.prefix).and_then(|rest| rest.strip_suffix(self.suffix));
        let digits = |number: &str| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
        name == self.list || number.is_some_and(digits)
    }

    /// What lies in `folder`: nothing, or such files alone where they may be replaced.
    fn within(self, folder: &Path, force: bool) -> Result<Vec<PathBuf>, Error> {
        let failed = |source| Error::file(folder, source);
        if fs::symlink_metadata(folder).is_err() {
            return Ok(Vec::new());
        }
        let entries =
            fs::read_dir(folder).map_err(failed)?.collect::<io::Result<Vec<_>>>().map_err(failed)?;
        let known = |entry: &fs::DirEntry| {
            entry.file_type().is_ok_and(|kind| kind.is_file())
                && self.holds(&entry.file_name().to_string_lossy())
        };
        if let Some(other) = entries.iter().find(|entry| !force || !known(entry)) {
            let hint = if force { "" } else { "; --force replaces earlier frames" };
            return Err(Error::Input(format!(
                "{}: holds {}; allowed is a new or empty folder{hint}",
                folder.display(),
                other.file_name().to_string_lossy()
            )));
        }
        Ok(entries.iter().map(fs::DirEntry::path).collect())
    }
}

/// Writes the folder `path` of `files` beside it and moves it there, so that it is whole or not there; it is new or empty, or holds such
/// files alone where `force` allows to replace them.
///
/// # Errors
/// A folder with other files; those of `write`; what cannot be moved.
pub fn replace_folder(
    path: &Path,
    files: Numbered,
    force: bool,
    write: &mut dyn FnMut(&Path) -> Result<(), Error>,
) -> Result<(), Error> {
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.into());
    if path.file_name().is_none() || is_here(path) {
        return Err(Error::Input(format!(
            "{}: allowed is a folder below the present one, or beside it",
            path.display()
        )));
    }
    let failed = |source| Error::file(path, source);
    let (old, beside) = (files.within(path, force)?, hidden(path, "partial"));
    // What a killed command left.
    let left = files.within(&beside, true)?;
    left.iter().try_for_each(fs::remove_file).and_then(|()| fs::create_dir_all(&beside)).map_err(failed)?;
    let unfinished = Unfinished::new(&beside, false);
    let moved = || {
        let _whole = unfinished.settle();
        old.iter().try_for_each(fs::remove_file).and_then(|()| fs::rename(&beside, path)).map_err(failed)
    };
    write(&beside).and_then(|()| moved()).inspect_err(|_| {
        let _ = fs::remove_dir_all(&beside);
    })
}

/// Whether `path` is the present folder.
fn is_here(path: &Path) -> bool {
    std::env::current_dir().and_then(fs::canonicalize).is_ok_and(|here| here == path)
}

fn label(target: &Path) -> String {
    target.file_name().map_or("run".into(), |name| name.to_string_lossy().into_owned())
}

/// The hidden neighbour of a folder: `partial` while it is written, `replaced` while a new run takes its place.
fn hidden(target: &Path, mark: &str) -> PathBuf {
    target.with_file_name(format!(".{}.{mark}", label(target)))
}

/// True when `folder` is what stands at `path`, and not what stood there before.
#[cfg(unix)]
fn is_at(folder: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(held), Ok(there)) = (folder.metadata(), fs::symlink_metadata(path)) else { return false };
    (held.dev(), held.ino()) == (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.is_dir()
}

/// Whether a run may be moved to `target`, and takes the place of an earlier one there.
fn may_move_to(wanted: &FolderRequest, target: &Path, force: bool) -> Result<bool, NameRefusal> {
    restore(target).map_err(NameRefusal::Failed)?;
    wanted.check(target).map_err(|error| match wanted {
        FolderRequest::Out(_) => NameRefusal::Failed(error),
        FolderRequest::Named(..) => NameRefusal::Busy(error.to_string()),
    })?;
    let empty = fs::read_dir(target).map_or(true, |mut entries| entries.next().is_none());
    let named = matches!(wanted, FolderRequest::Named(..));
    match Ours::at(target) {
        _ if empty && !(named && target.exists()) => Ok(false),
        Ok(_) if force && !named => Ok(true),
        Ok(_) => Err(NameRefusal::Busy("a new or empty folder; --force replaces this earlier run".into())),
        Err(_) if !force => {
            Err(NameRefusal::Busy("a new or empty folder; this one holds other files".into()))
        }
        Err(why) => Err(NameRefusal::Busy(format!(
            "a new or empty folder, or with --force a run of wingbeat and nothing else: here {why}"
        ))),
    }
}

/// Brings an earlier run back to its name when the command that was to replace it was killed in between.
fn restore(target: &Path) -> Result<(), Error> {
    let aside = hidden(target, "replaced");
    if fs::symlink_metadata(&aside).is_err() {
        return Ok(());
    }
    let waits = |why| Error::Input(format!("{}: a replaced run waits here, and {why}", aside.display()));
    let old = Ours::at(&aside).map_err(waits)?;
    let outcome = match fs::symlink_metadata(target) {
        Ok(_) => old.remove(&aside),
        Err(_) => fs::rename(&aside, target),
    };
    outcome.map_err(|source| Error::file(&aside, source))
}

/// What lies in the hidden folder `partial`, which nobody else holds.
fn left(partial: &Path, mode: FolderMode) -> HiddenContent {
    if fs::read_dir(partial).is_ok_and(|mut entries| entries.next().is_none()) {
        return HiddenContent::Nothing;
    }
    let mark: Option<Mark> =
        fs::read_to_string(partial.join(MARK)).ok().and_then(|text| serde_json::from_str(&text).ok());
    let mark = mark.filter(|mark| mark.program == PROGRAM);
    let resumes = mark.as_ref().is_none_or(|mark| mark.resumes);
    let holds =
        |identity, text| fs::read_to_string(partial.join(identity)).is_ok_and(|left: String| left == text);
    match mode {
        FolderMode::GoesOn(identity, text) if resumes && holds(identity, text) => HiddenContent::Ours,
        _ if begun(partial, mode) => HiddenContent::Dead,
        _ if mark.is_some() && !resumes => HiddenContent::Dead,
        _ if mark.is_none() && Ours::at(partial).is_ok() => HiddenContent::Dead,
        FolderMode::GoesOn(identity, _) if resumes => HiddenContent::Other(format!(
            "another folder: an unfinished run with other settings waits in {}; finish it with those of its \
             {identity}, or move it away",
            partial.display()
        )),
        _ if mark.is_some() => HiddenContent::Other(format!(
            "another folder: an unfinished run waits in {} for its command to go on",
            partial.display()
        )),
        _ => HiddenContent::Other(format!("another folder: {} holds other files", partial.display())),
    }
}

/// Whether a folder holds no more than what says of what it is, perhaps cut short: nothing was done.
fn begun(partial: &Path, mode: FolderMode) -> bool {
    let identity = match mode {
        FolderMode::GoesOn(identity, _) => identity,
        FolderMode::Anew => MARK,
    };
    let known = |entry: io::Result<fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.file_name() == MARK || entry.file_name() == identity)
    };
    fs::read_dir(partial).is_ok_and(|mut entries| entries.all(known))
}

/// Removes everything inside a folder that a killed command of ours left.
fn clear(partial: &Path) -> io::Result<()> {
    for entry in fs::read_dir(partial)? {
        let entry = entry?;
        match entry.file_type()?.is_dir() {
            true => fs::remove_dir_all(entry.path())?,
            false => fs::remove_file(entry.path())?,
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
