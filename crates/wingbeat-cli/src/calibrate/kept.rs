//! Fits that are done, for a command that goes on.

use std::collections::BTreeMap;

use wingbeat_calibrate::{Fit, Keep};

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Fits that are done, kept in the folder for a command that goes on.
pub struct KeptFits<'a> {
    folder: &'a RunFolder,
    fits: BTreeMap<usize, Fit>,
}

/// The file of fits that are done.
const KEPT: &str = "starts.json";

impl<'a> KeptFits<'a> {
    /// What an interrupted command left.
    pub fn open(folder: &'a RunFolder) -> Self {
        let text = std::fs::read_to_string(folder.file(KEPT)).unwrap_or_default();
        Self { folder, fits: serde_json::from_str(&text).unwrap_or_default() }
    }

    /// How many fits are done.
    pub fn count(&self) -> usize {
        self.fits.len()
    }

    /// Removes the file: the summary holds what it held.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn remove(folder: &RunFolder) -> Result<(), Error> {
        let path = folder.file(KEPT);
        match std::fs::remove_file(&path) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(Error::file(&path, source)),
            _ => Ok(()),
        }
    }
}

impl Keep for KeptFits<'_> {
    fn kept(&self, number: usize) -> Option<Fit> {
        self.fits.get(&number).cloned()
    }
    fn keep(&mut self, number: usize, fit: &Fit) {
        self.fits.insert(number, fit.clone());
        // Without the file the command begins anew: nothing else is lost.
        let _ = self.folder.write_json(KEPT, &self.fits);
    }
}
