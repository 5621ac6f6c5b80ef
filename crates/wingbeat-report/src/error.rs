//! Why a run cannot be shown.

use std::path::{Path, PathBuf};

/// Why a run cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The folder holds no run, or a damaged one.
    #[error("{path}: {what}")]
    Run {
        /// The folder or the file in it.
        path: PathBuf,
        /// What is wrong, and what is allowed.
        what: String,
    },
    /// A file of the run.
    #[error(transparent)]
    Record(#[from] wingbeat_io::Error),
}

impl Error {
    pub(crate) fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }

    pub(crate) fn run(path: &Path, what: impl ToString) -> Self {
        Self::Run { path: path.into(), what: what.to_string() }
    }
}
