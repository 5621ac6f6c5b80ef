//! What can be wrong with the input of the library.

/// Bad input, with the names and numbers a person needs to mend it.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A value outside what is allowed; `key` is its path in the configuration.
    #[error("{key} = {value}: allowed is {allowed}")]
    Invalid {
        /// Path of the key, e.g. `links.distal.mass_kg`.
        key: String,
        /// The value given.
        value: String,
        /// What is allowed.
        allowed: String,
    },
}

impl Error {
    /// A value that is not allowed.
    pub fn invalid(key: impl Into<String>, value: impl ToString, allowed: impl Into<String>) -> Self {
        Self::Invalid { key: key.into(), value: value.to_string(), allowed: allowed.into() }
    }

    /// The same error with `prefix.` before its key.
    pub fn within(self, prefix: &str) -> Self {
        match self {
            Self::Invalid { key, value, allowed } => {
                Self::Invalid { key: format!("{prefix}.{key}"), value, allowed }
            }
        }
    }
}
