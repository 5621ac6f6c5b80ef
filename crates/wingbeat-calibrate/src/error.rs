//! Why a calibration cannot be done.

use wingbeat::plant::Fault;

/// Bad input of a calibration, or a model that cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A value that the library refuses.
    #[error(transparent)]
    Refused(#[from] wingbeat::Error),
    /// A file that says what cannot be.
    #[error(transparent)]
    Config(#[from] wingbeat::scenario::ConfigError),
    /// The model has no answer.
    #[error("{run}: {fault}")]
    Model {
        /// The run.
        run: String,
        /// What the model says.
        fault: Fault,
    },
    /// Samples that cannot be used.
    #[error("{file}: {what}")]
    Data {
        /// The file, or the run.
        file: String,
        /// What is wrong, and what would be right.
        what: String,
    },
    /// The runs say too little of what is to be fitted.
    #[error("{0}")]
    Uninformed(String),
    /// Stopped from outside.
    #[error("stopped")]
    Stopped,
}

impl Error {
    /// Samples of `file` that cannot be used.
    pub fn data(file: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Data { file: file.into(), what: what.into() }
    }
}
