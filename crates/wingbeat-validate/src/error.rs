//! Why a comparison could not be computed.

/// Why a comparison could not be computed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The library refused its input.
    #[error(transparent)]
    Input(#[from] wingbeat::Error),
    /// The model could not be evaluated.
    #[error(transparent)]
    Model(#[from] wingbeat::plant::Fault),
    /// The vortex lattice could not be built or stepped.
    #[error(transparent)]
    Lattice(#[from] wingbeat_lattice::Error),
    /// A reference table does not hold what the case needs.
    #[error("validation/{file}: {what}")]
    Reference {
        /// Path below `validation/`.
        file: String,
        /// What is wrong.
        what: String,
    },
    /// A solver ended without an answer.
    #[error("no answer: {0}")]
    NoAnswer(String),
    /// Rows of a comparison that cannot be told apart.
    #[error("the rows do not carry the comparison's id, each its own")]
    Ids,
    /// The comparison itself broke off.
    #[error("the comparison broke off; its message is above")]
    Panicked,
}

impl Error {
    /// A reference table that does not hold what the case needs.
    pub fn reference(file: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Reference { file: file.into(), what: what.into() }
    }
}
