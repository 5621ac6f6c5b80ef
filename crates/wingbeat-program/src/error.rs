//! Why a command ended, and the exit code that says so.

use std::path::{Path, PathBuf};

use wingbeat::judge::Status;
use wingbeat::scenario::ConfigError;

/// Why a command ended without success.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A comparison failed; the table printed says which.
    #[error("a comparison failed")]
    ComparisonFailed,
    /// Bad input on the command line.
    #[error("{0}")]
    Input(String),
    /// Bad input in a configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A value that the library refuses.
    #[error(transparent)]
    Refused(#[from] wingbeat::Error),
    /// A calibration that cannot be made.
    #[error(transparent)]
    Calibration(#[from] wingbeat_calibrate::CalibrationFailure),
    /// A file could not be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The record could not be written.
    #[error(transparent)]
    Record(#[from] wingbeat_io::Error),
    /// The run did not do what its scenario asks.
    #[error("{status}: {reason}; the run is kept in {folder}")]
    Failed {
        /// The status in summary.json.
        status: String,
        /// Why.
        reason: String,
        /// The run folder.
        folder: PathBuf,
    },
    /// What was only looked at cannot be used.
    #[error("{status}: {reason}")]
    Unsound {
        /// The status.
        status: String,
        /// Why.
        reason: String,
    },
    /// The output cannot be written.
    #[error("the output could not be printed: {0}; what was asked to be kept is whole")]
    Output(std::io::Error),
    /// Ctrl-C in a run that can be resumed.
    #[error("interrupted with {done} of {all} done; the same command goes on from here")]
    Paused {
        /// What is done.
        done: usize,
        /// What is to do.
        all: usize,
    },
    /// Ctrl-C, or asked to end by the system.
    #[error("interrupted; nothing is kept")]
    Interrupted,
}

impl Error {
    /// How a command ends whose result is kept in `folder`: without an error where its status lets the result be used.
    pub fn unless_usable(status: Status, reason: Option<&str>, folder: &Path) -> Result<(), Self> {
        match status.exit_code() {
            0 => Ok(()),
            _ => Err(Self::Failed {
                status: status.name().into(),
                reason: reason.unwrap_or_default().into(),
                folder: folder.into(),
            }),
        }
    }

    /// How a command ends that keeps nothing: without an error where the status lets what it looked at be used.
    pub fn unless_sound(status: Status, reason: Option<&str>) -> Result<(), Self> {
        let (name, reason) = (status.name().into(), reason.unwrap_or_default().into());
        if status.exit_code() == 0 { Ok(()) } else { Err(Self::Unsound { status: name, reason }) }
    }

    /// A file that could not be read or written.
    pub fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }

    /// 1 a comparison failed, 2 bad input, 3 a failed run, 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::ComparisonFailed => 1,
            Self::Input(_)
            | Self::Config(_)
            | Self::Refused(_)
            | Self::Calibration(_)
            | Self::File { .. }
            | Self::Record(_)
            | Self::Output(_) => 2,
            Self::Failed { status, .. } if status == Status::Interrupted.name() => {
                Status::Interrupted.exit_code()
            }
            Self::Failed { .. } | Self::Unsound { .. } => 3,
            Self::Interrupted | Self::Paused { .. } => 130,
        }
    }

    /// True when what was printed before already says it.
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::ComparisonFailed)
    }
}
