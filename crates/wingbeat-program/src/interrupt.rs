//! Ctrl-C as a flag that loops look at, and the end of the program where none looks in time.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use crate::error::Error;
use crate::say::note;

/// Time that work has to end by itself, so that the program ends within a second. *Choice.*
const GRACE: Duration = Duration::from_millis(600);
/// Tries to empty a folder while other threads may still write to it.
const TRIES: usize = 5;

/// Folders of runs, and files, that are not finished, with whether they are kept for the same command to go on.
static UNFINISHED: Mutex<Vec<(PathBuf, bool)>> = Mutex::new(Vec::new());

/// The flag of this program, once it listens.
static LISTENING: OnceLock<Interrupt> = OnceLock::new();

/// Set by Ctrl-C, or when the system asks the program to end.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Flags>);

#[derive(Debug, Default)]
struct Flags {
    set: AtomicBool,
    patient: AtomicBool,
}

impl Interrupt {
    /// Listens from now on; a program listens once, and whoever asks again gets the same. Work that does not end soon after the signal is ended with the
    /// program: what is not finished goes, unless the same command can go on from it.
    pub fn listen() -> Result<Self, Error> {
        if let Some(listening) = LISTENING.get() {
            return Ok(listening.clone());
        }
        let flag = Self::default();
        let set = flag.clone();
        ctrlc::set_handler(move || {
            let again = set.0.set.swap(true, Ordering::Relaxed);
            if again {
                end();
            }
            if !set.0.patient.load(Ordering::Relaxed) {
                let waits = thread::Builder::new().spawn(|| {
                    thread::sleep(GRACE);
                    end();
                });
                // Without a thread that waits, a second signal ends it.
                drop(waits);
            }
        })
        .map_err(|error| Error::Input(format!("Ctrl-C cannot be caught: {error}")))?;
        Ok(LISTENING.get_or_init(|| flag).clone())
    }

    /// From now on the first signal only sets the flag: what follows has to be finished. The second one ends.
    pub fn patient(&self) {
        self.0.patient.store(true, Ordering::Relaxed);
    }

    /// Break once interrupted, for observers.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.0.set.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// An error once interrupted.
    pub fn check(&self) -> Result<(), Error> {
        if self.flow().is_break() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// A folder in the list of those that are not finished, as long as this lives.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Unfinished {
    /// Adds a folder; `keep` when the same command goes on from it.
    pub fn new(folder: &Path, keep: bool) -> Self {
        list().push((folder.into(), keep));
        Self(folder.into())
    }

    /// Takes the folder out of the list; the program is not ended as long as the answer lives.
    pub fn settle(&self) -> impl Drop + use<> {
        let mut list = list();
        list.retain(|(folder, _)| *folder != self.0);
        list
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Ok(mut list) = UNFINISHED.try_lock() {
            list.retain(|(folder, _)| *folder != self.0);
        }
    }
}

fn list() -> MutexGuard<'static, Vec<(PathBuf, bool)>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the program at once.
fn end() -> ! {
    let list = list();
    let mut kept = false;
    for (folder, keep) in list.iter() {
        kept |= keep;
        let gone =
            || !folder.exists() || fs::remove_dir_all(folder).is_ok() || fs::remove_file(folder).is_ok();
        if !keep && !(0..TRIES).any(|_| gone()) {
            note(&format!("{} could not be removed", folder.display()));
        }
    }
    let what = if kept { "the same command goes on from what is done" } else { "nothing is kept" };
    note(&format!("error: interrupted; {what}"));
    std::process::exit(130)
}
