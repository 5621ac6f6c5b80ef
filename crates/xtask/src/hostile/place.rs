//! The folder of a case, and the program called in it under limits.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Deserialize;

use super::case::CaseOutcome;
use super::data::{GLIDE, HOLD, SWEEP};
use crate::tools;

/// Most memory of a call, kB of address space.
const MEMORY_KB: u64 = 1 << 20;
/// Longest processor time of a call, and longest time in which it uses none: on a busy machine it takes longer than alone.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// Longest time of a call over that, whatever it uses.
const BUSY: u32 = 20;
/// Clock ticks of /proc in a second, on every Linux machine (proc(5), USER_HZ).
const TICKS: f64 = 100.0;
/// Longest time from a signal to the end.
pub const ANSWER: Duration = Duration::from_secs(1);
/// Most that may lie in the folder of a case, bytes; no single file may become larger.
const DISK: u64 = 1 << 30;
/// Words of a program that broke.
const BROKEN: [&str; 4] =
    ["panicked at", "overflowed its stack", "memory allocation of", "capacity overflow"];

/// An empty folder and the program.
pub struct CaseFolder {
    program: PathBuf,
    /// The folder.
    pub folder: PathBuf,
}

/// What lies in a folder: contents of files by their hash, targets of links, folders.
pub type FolderState = BTreeMap<PathBuf, String>;

/// Where the standard output goes.
#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "snake_case")]
pub enum Stdout {
    /// It is read.
    #[default]
    Read,
    /// To a full device.
    Full,
    /// It is closed.
    Closed,
    /// One line is read, then its reader goes, as `head -n 1` does.
    Head,
}

/// A call of the program.
pub struct Call<'a> {
    place: &'a CaseFolder,
    arguments: Vec<OsString>,
    folder: PathBuf,
    stdout: Stdout,
    signal: Option<(String, Duration)>,
    /// What the shell does to its error stream.
    stderr: String,
    /// Largest file that it may write, blocks of 512 bytes.
    blocks: u64,
    environment: Vec<(&'static str, String)>,
}

/// How a call ended.
pub struct CallEnd {
    /// Exit code; none after a signal.
    pub code: Option<i32>,
    /// The signal that ended it.
    pub signal: Option<i32>,
    /// What it printed.
    pub stdout: String,
    /// What it said.
    pub stderr: String,
    /// Time from the signal sent to the end.
    pub answered: Option<Duration>,
}

/// `{root}` in `text` as the path of the repository.
pub fn placed(text: &str) -> String {
    text.replace("{root}", &tools::root().to_string_lossy())
}

fn told<T>(path: &Path, outcome: std::io::Result<T>) -> Result<T, String> {
    outcome.map_err(|error| format!("{}: {error}", path.display()))
}

impl CaseFolder {
    /// The folder, empty.
    pub fn new(program: &Path, folder: &Path) -> Result<Self, String> {
        if folder.exists() {
            told(folder, fs::remove_dir_all(folder))?;
        }
        told(folder, fs::create_dir_all(folder))?;
        Ok(Self { program: program.into(), folder: folder.into() })
    }

    /// A path inside.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Writes a file, with the folders above it.
    pub fn write(&self, name: &str, text: &str) -> CaseOutcome {
        self.write_bytes(name, placed(text).as_bytes())
    }

    /// Writes a file that need not be text.
    pub fn write_bytes(&self, name: &str, bytes: &[u8]) -> CaseOutcome {
        let path = self.path(name);
        let above = path.parent().unwrap_or(&self.folder);
        told(above, fs::create_dir_all(above))?;
        told(&path, fs::write(&path, bytes))
    }

    /// Writes the short flight, its sweep and the hold.
    pub fn write_texts(&self) -> CaseOutcome {
        let texts = [("glide.toml", GLIDE), ("sweep.toml", SWEEP), ("hold.toml", HOLD)];
        texts.into_iter().try_for_each(|(name, text)| self.write(name, text))
    }

    /// The text of a file.
    pub fn read(&self, name: &str) -> Result<String, String> {
        let path = self.path(name);
        told(&path, fs::read_to_string(&path))
    }

    /// Names in a folder, sorted.
    pub fn names(&self, folder: &str) -> Result<Vec<String>, String> {
        let path = self.path(folder);
        let entries = told(&path, fs::read_dir(&path))?;
        let mut names: Vec<String> =
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        Ok(names)
    }

    /// Exactly `names` lie in `folder`.
    pub fn holds(&self, folder: &str, names: &[&str]) -> CaseOutcome {
        let found = self.names(folder)?;
        if found == names { Ok(()) } else { Err(format!("{folder} holds {found:?}, wanted {names:?}")) }
    }

    /// Two files have the same bytes.
    pub fn same(&self, a: &str, b: &str) -> CaseOutcome {
        let bytes = |name| told(&self.path(name), fs::read(self.path(name)));
        if bytes(a)? == bytes(b)? { Ok(()) } else { Err(format!("{a} and {b} differ")) }
    }

    /// Everything inside.
    pub fn state(&self) -> Result<FolderState, String> {
        let mut state = FolderState::new();
        look(&self.folder, &mut state)?;
        Ok(state)
    }

    /// Nothing was added, changed or removed.
    pub fn unchanged(&self, before: &FolderState) -> CaseOutcome {
        self.kept(before)?;
        match self.state()?.keys().find(|path| !before.contains_key(*path)) {
            Some(path) => Err(format!("left {}", path.display())),
            None => Ok(()),
        }
    }

    /// Nothing that lay there was changed or removed.
    pub fn kept(&self, before: &FolderState) -> CaseOutcome {
        let after = self.state()?;
        match before.iter().find(|(path, what)| after.get(*path) != Some(what)) {
            Some((path, _)) => Err(format!("destroyed {}", path.display())),
            None => Ok(()),
        }
    }

    /// The folder has not grown beyond the limit.
    pub fn within_disk(&self) -> CaseOutcome {
        let size = size(&self.folder);
        if size <= DISK { Ok(()) } else { Err(format!("{size} bytes on disk")) }
    }

    /// A call in the folder.
    pub fn call(&self, arguments: &[&str]) -> Call<'_> {
        let arguments = arguments.iter().map(|word| placed(word).into()).collect();
        let folder = self.folder.clone();
        Call {
            place: self,
            arguments,
            folder,
            stdout: Stdout::Read,
            signal: None,
            stderr: String::new(),
            blocks: DISK / 512,
            environment: Vec::new(),
        }
    }

    /// Calls the program in the folder and waits for its end.
    pub fn run(&self, arguments: &[&str]) -> Result<CallEnd, String> {
        self.call(arguments).run()
    }
}

impl Call<'_> {
    /// With one more argument, which need not be text.
    pub fn argument(mut self, argument: OsString) -> Self {
        self.arguments.push(argument);
        self
    }

    /// In another folder.
    pub fn within(mut self, folder: &str) -> Self {
        self.folder = self.place.path(folder);
        self
    }

    /// With its standard output elsewhere.
    pub fn stdout(mut self, stdout: Stdout) -> Self {
        self.stdout = stdout;
        self
    }

    /// With its error stream elsewhere, as the shell writes it: `2>/dev/full`, `2>&-`.
    pub fn stderr(mut self, redirection: &str) -> Self {
        self.stderr = redirection.into();
        self
    }

    /// Sends a signal (`INT`, `TERM`) so long after the start.
    pub fn signal(mut self, name: &str, after: Duration) -> Self {
        self.signal = Some((name.into(), after));
        self
    }

    /// No file may become larger than so many blocks of 512 bytes: writing fails as on a full disk.
    pub fn blocks(mut self, blocks: u64) -> Self {
        self.blocks = blocks;
        self
    }

    /// With these variables in its environment.
    pub fn environment(mut self, variables: &[(&'static str, String)]) -> Self {
        self.environment = variables.to_vec();
        self
    }

    /// Starts it.
    pub fn start(&self) -> Result<Running, String> {
        let closed = if self.stdout == Stdout::Closed { " >&-" } else { "" };
        let script = format!(
            "trap '' XFSZ; ulimit -c 0; ulimit -v {MEMORY_KB}; ulimit -f {}; exec \"$@\"{closed} {}",
            self.blocks, self.stderr
        );
        let mut command = Command::new("sh");
        command.args(["-c", &script, "sh"]).arg(&self.place.program).args(&self.arguments);
        command.envs(self.environment.iter().map(|(name, value)| (name, value)));
        command.current_dir(&self.folder).stdin(Stdio::null()).stderr(Stdio::piped());
        match self.stdout {
            Stdout::Full => {
                let full = Path::new("/dev/full");
                command.stdout(told(full, File::options().write(true).open(full))?)
            }
            _ => command.stdout(Stdio::piped()),
        };
        let mut child = command.spawn().map_err(|error| format!("sh: {error}"))?;
        let head = self.stdout == Stdout::Head;
        let stdout = child.stdout.take().map(|pipe| gather(pipe, head));
        let stderr = child.stderr.take().map(|pipe| gather(pipe, false));
        Ok(Running { child, stdout, stderr })
    }

    /// Runs it to its end.
    pub fn run(&self) -> Result<CallEnd, String> {
        let mut running = self.start()?;
        let Some((name, after)) = &self.signal else { return running.end(PATIENCE) };
        thread::sleep(*after);
        if running.child.try_wait().is_ok_and(|ended| ended.is_some()) {
            let ended = running.end(PATIENCE)?;
            return Err(format!("ended before the signal: {:?} {}", ended.code, ended.stderr.trim()));
        }
        let sent = Instant::now();
        running.send(name)?;
        let ended = running.end(PATIENCE)?;
        Ok(CallEnd { answered: Some(sent.elapsed()), ..ended })
    }
}

/// A program under way.
pub struct Running {
    child: Child,
    stdout: Option<JoinHandle<String>>,
    stderr: Option<JoinHandle<String>>,
}

impl Running {
    /// Sends it a signal.
    pub fn send(&self, name: &str) -> CaseOutcome {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").args([&format!("-{name}"), &id]).status();
        if sent.is_ok_and(|status| status.success()) { Ok(()) } else { Err(format!("kill -{name} failed")) }
    }

    /// Waits for its end, at most until it has used so much processor time, or has used none for so long; what broke is an error.
    pub fn end(mut self, patience: Duration) -> Result<CallEnd, String> {
        let (begun, mut moved, mut spent) = (Instant::now(), Instant::now(), Duration::ZERO);
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) => thread::sleep(Duration::from_millis(3)),
                Err(error) => return Err(format!("lost: {error}")),
            }
            // What one tick takes is looked at when it can have passed.
            if moved.elapsed().as_secs_f64() < 1.0 / TICKS {
                continue;
            }
            match processor(self.child.id()) {
                Some(used) if used > spent => (moved, spent) = (Instant::now(), used),
                _ if moved.elapsed() > patience => break None,
                _ => {}
            }
            if spent > patience || begun.elapsed() > BUSY * patience {
                break None;
            }
        };
        if status.is_none() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        let text =
            |reader: Option<JoinHandle<String>>| reader.and_then(|r| r.join().ok()).unwrap_or_default();
        let (stdout, stderr) = (text(self.stdout.take()), text(self.stderr.take()));
        let Some(status) = status else {
            let time = format!("{:?}, {spent:?} of the processor", begun.elapsed());
            return Err(format!("still running after {time}: {}", brief(&stderr)));
        };
        let ended = CallEnd { code: status.code(), signal: status.signal(), stdout, stderr, answered: None };
        match BROKEN.iter().find(|word| ended.stderr.contains(**word)) {
            Some(word) => Err(format!("it broke ({word}): {}", brief(&ended.stderr))),
            None => Ok(ended),
        }
    }
}

impl CallEnd {
    /// It ended by itself with this exit code.
    pub fn exits(self, code: i32) -> Result<Self, String> {
        self.exits_with(&[code])
    }

    /// It ended with one of these exit codes, -1 for an end by a signal; with any where there are none.
    pub fn exits_with(self, codes: &[i32]) -> Result<Self, String> {
        if codes.is_empty() || codes.contains(&self.code.unwrap_or(-1)) {
            return Ok(self);
        }
        let how = self.code.map_or(format!("signal {:?}", self.signal), |code| format!("exit {code}"));
        Err(format!("{how}, wanted exit {codes:?}: {}", brief(&self.stderr)))
    }

    /// Its error stream says each of `words`.
    pub fn says<W: AsRef<str>>(self, words: &[W]) -> Result<Self, String> {
        match words.iter().map(AsRef::as_ref).find(|word| !self.stderr.contains(&placed(word))) {
            Some(word) => Err(format!("does not say {word:?}: {}", brief(&self.stderr))),
            None => Ok(self),
        }
    }

    /// Its output says each of `words`.
    pub fn prints<W: AsRef<str>>(self, words: &[W]) -> Result<Self, String> {
        match words.iter().map(AsRef::as_ref).find(|word| !self.stdout.contains(&placed(word))) {
            Some(word) => Err(format!("does not print {word:?}: {}", brief(&self.stdout))),
            None => Ok(self),
        }
    }

    /// It ended soon enough after its signal.
    pub fn in_time(self) -> Result<Self, String> {
        match self.answered {
            Some(took) if took <= ANSWER => Ok(self),
            took => Err(format!("answered the signal after {took:?}: {}", brief(&self.stderr))),
        }
    }
}

/// Processor time that a process has used, all its threads together; none where the system does not tell it.
fn processor(id: u32) -> Option<Duration> {
    let text = fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
    // The name, which may hold anything, ends at the last bracket; user and system time are the 14th and 15th field.
    let after = text.rsplit_once(')')?.1;
    let ticks = after.split_whitespace().skip(11).take(2).filter_map(|field| field.parse::<f64>().ok());
    Some(Duration::from_secs_f64(ticks.sum::<f64>() / TICKS))
}

/// Reads a stream to its end, or its first line only.
fn gather(pipe: impl Read + Send + 'static, first_line: bool) -> JoinHandle<String> {
    thread::spawn(move || {
        let mut reader = BufReader::with_capacity(if first_line { 64 } else { 8192 }, pipe);
        let mut bytes = Vec::new();
        let _ = match first_line {
            true => reader.read_until(b'\n', &mut bytes),
            false => reader.read_to_end(&mut bytes),
        };
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

fn look(folder: &Path, state: &mut FolderState) -> CaseOutcome {
    for entry in told(folder, fs::read_dir(folder))? {
        let path = told(folder, entry)?.path();
        let kind = told(&path, fs::symlink_metadata(&path))?.file_type();
        let what = if kind.is_symlink() {
            format!("link to {:?}", told(&path, fs::read_link(&path))?)
        } else if kind.is_dir() {
            look(&path, state)?;
            "folder".into()
        } else if kind.is_file() {
            let mut hasher = DefaultHasher::new();
            told(&path, fs::read(&path))?.hash(&mut hasher);
            format!("file {:x}", hasher.finish())
        } else {
            "special".into()
        };
        state.insert(path, what);
    }
    Ok(())
}

fn size(path: &Path) -> u64 {
    match fs::symlink_metadata(path) {
        Ok(data) if data.is_dir() => {
            fs::read_dir(path).into_iter().flatten().flatten().map(|entry| size(&entry.path())).sum()
        }
        Ok(data) => data.len(),
        Err(_) => 0,
    }
}

/// The end of what was said, short.
fn brief(text: &str) -> String {
    let text = text.trim();
    let start = text.char_indices().rev().nth(399).map_or(0, |(at, _)| at);
    text[start..].replace('\n', " | ")
}
