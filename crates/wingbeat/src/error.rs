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

/// Checks of numbers from a configuration, with the message of what is allowed.
pub(crate) mod require {
    use super::Error;

    /// Finite and above 0.
    pub fn positive(key: &str, value: f64) -> Result<(), Error> {
        check(key, value, value > 0.0 && value.is_finite(), "a finite number above 0")
    }

    /// Finite, 0 or more.
    pub fn not_negative(key: &str, value: f64) -> Result<(), Error> {
        check(key, value, value >= 0.0 && value.is_finite(), "a finite number, 0 or more")
    }

    /// All finite.
    pub fn finite(key: &str, values: &[f64]) -> Result<(), Error> {
        values.iter().try_for_each(|&v| check(key, v, v.is_finite(), "finite numbers"))
    }

    fn check(key: &str, value: f64, good: bool, allowed: &str) -> Result<(), Error> {
        if good { Ok(()) } else { Err(Error::invalid(key, value, allowed)) }
    }
}
