//! Ctrl-C as a flag that loops look at.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Error;

/// Set by Ctrl-C, or when the system asks the program to end.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; a program listens once.
    pub fn listen() -> Result<Self, Error> {
        let flag = Self::default();
        let set = flag.clone();
        ctrlc::set_handler(move || set.0.store(true, Ordering::Relaxed))
            .map_err(|error| Error::Input(format!("Ctrl-C cannot be caught: {error}")))?;
        Ok(flag)
    }

    /// Break once interrupted, for observers.
    pub fn flow(&self) -> ControlFlow<()> {
        if self.0.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// An error once interrupted.
    pub fn check(&self) -> Result<(), Error> {
        if self.flow().is_break() { Err(Error::Interrupted) } else { Ok(()) }
    }
}
