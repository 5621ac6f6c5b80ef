//! Work beside the interpreter, which Ctrl-C ends at once.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two looks for signals. *Choice.*
const LOOK: Duration = Duration::from_millis(10);
/// Time that work has to end by itself after a signal; then it goes on unheard until it looks. *Choice.*
const GRACE: Duration = Duration::from_millis(50);
/// The same of work whose answer is kept, so that a call ends within a second. *Choice.*
const KEEP: Duration = Duration::from_millis(850);
/// Stack of the working thread, bytes: that of a main thread, which the library's dual numbers are used to.
const STACK: usize = 16 << 20;

/// Set when the work is no longer wanted.
#[derive(Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Break once the work is no longer wanted.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
    /// Ends the work.
    pub fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Does `work` in a thread of its own with the interpreter free for others.
///
/// # Errors
/// What a signal raises, `KeyboardInterrupt` for Ctrl-C; a panic of the work.
pub fn work<R: Send + 'static>(py: Python, work: impl FnOnce(&Stop) -> R + Send + 'static) -> PyResult<R> {
    let (answer, raised) = answered(py, GRACE, work)?;
    match (answer, raised) {
        (Some(answer), None) => Ok(answer),
        (_, raised) => Err(raised.unwrap_or_else(nothing)),
    }
}

/// The same for work that has something to keep when it is stopped: its answer, and what a signal raised meanwhile.
///
/// # Errors
/// What a signal raises where the work does not end soon after; a panic of the work.
pub fn kept<R: Send + 'static>(
    py: Python,
    work: impl FnOnce(&Stop) -> R + Send + 'static,
) -> PyResult<(R, Option<PyErr>)> {
    let (answer, raised) = answered(py, KEEP, work)?;
    match answer {
        Some(answer) => Ok((answer, raised)),
        None => Err(raised.unwrap_or_else(nothing)),
    }
}

fn nothing() -> PyErr {
    PyRuntimeError::new_err("the work ended without an answer")
}

/// Hears the answer of the work, and signals; after one it waits so long and no longer.
fn answered<R: Send + 'static>(
    py: Python,
    grace: Duration,
    work: impl FnOnce(&Stop) -> R + Send + 'static,
) -> PyResult<(Option<R>, Option<PyErr>)> {
    let stop = Stop::default();
    let (sender, mut answer) = mpsc::sync_channel(1);
    let told = stop.clone();
    let thread = thread::Builder::new().name("wingbeat".into()).stack_size(STACK);
    let thread = thread.spawn(move || drop(sender.send(work(&told))))?;
    let mut signal: Option<(PyErr, Instant)> = None;
    loop {
        let listener = &mut answer;
        match py.detach(move || listener.recv_timeout(LOOK)) {
            Ok(answer) => return Ok((Some(answer), signal.map(|(raised, _)| raised))),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(raised) = py.check_signals() {
                    stop.set();
                    // A second signal is not waited for.
                    if let Some((first, _)) = signal {
                        return Ok((None, Some(first)));
                    }
                    signal = Some((raised, Instant::now()));
                }
                if let Some((raised, _)) = signal.take_if(|(_, since)| since.elapsed() >= grace) {
                    return Ok((None, Some(raised)));
                }
            }
            Err(RecvTimeoutError::Disconnected) => {
                let panic = py.detach(move || thread.join()).err();
                let text = panic.as_ref().and_then(|panic| {
                    let text = panic.downcast_ref::<String>().map(String::as_str);
                    text.or(panic.downcast_ref::<&str>().copied())
                });
                return Err(text.map_or_else(nothing, |text| PyRuntimeError::new_err(text.to_owned())));
            }
        }
    }
}
