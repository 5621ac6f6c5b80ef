//! Why a command ended, and the exit code that says so.

use std::path::{Path, PathBuf};

/// Why a command ended without success.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A comparison failed; the table printed says which.
    #[error("a comparison failed")]
    ComparisonFailed,
    /// Bad input.
    #[error("{0}")]
    Input(String),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl Error {
    /// A file that could not be read or written.
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }

    /// 1 a comparison failed, 2 bad input.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::ComparisonFailed => 1,
            Self::Input(_) | Self::File { .. } => 2,
        }
    }

    /// True when what was printed before already says it.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::ComparisonFailed)
    }
}
