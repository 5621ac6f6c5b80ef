//! Why a lattice could not be built or stepped.

/// Why a lattice could not be built or stepped.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting that is not allowed.
    #[error("{key} = {value}: allowed is {allowed}")]
    Setting {
        /// Name of the setting.
        key: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// A half of a wing, beside which the lattice has no mirror.
    #[error("wing.side = {side}: allowed is both, whose lattice is whole")]
    Half {
        /// The half.
        side: &'static str,
    },
    /// Panels cannot be laid out on the wing.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// Panels that lie on one another, or one without area: the strengths are not determined.
    #[error(
        "at t = {time} s the panels do not determine their circulations: surfaces touch or a panel has no area"
    )]
    Singular {
        /// Time, s.
        time: f64,
    },
    /// A number that is not finite.
    #[error("at t = {time} s the {what} is not finite")]
    NotFinite {
        /// Time, s.
        time: f64,
        /// What is not finite.
        what: &'static str,
    },
}

/// What the library said when panels were laid out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct LayoutError(pub String);

impl From<wingbeat::Error> for Error {
    fn from(error: wingbeat::Error) -> Self {
        Self::Layout(LayoutError(error.to_string()))
    }
}
