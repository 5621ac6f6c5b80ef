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

    /// The same error with `prefix.` before its key; `prefix` alone where there is none.
    pub fn within(self, prefix: &str) -> Self {
        match self {
            Self::Invalid { key, value, allowed } => {
                let key = if key.is_empty() { prefix.into() } else { format!("{prefix}.{key}") };
                Self::Invalid { key, value, allowed }
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

    /// Fit to be the name of a folder.
    pub fn name(key: &str, value: &str) -> Result<(), Error> {
        if value.is_empty() || value.starts_with('.') || value.contains(['/', '\\']) {
            let allowed = "a name for a folder: not empty, without slashes, not starting with a dot";
            return Err(Error::invalid(key, format!("{value:?}"), allowed));
        }
        Ok(())
    }

    /// Principal inertias of a real body: none negative, none above the sum of the others.
    pub fn principal_inertias(key: &str, inertias: [f64; 3]) -> Result<(), Error> {
        inertias.iter().try_for_each(|&i| not_negative(key, i))?;
        let [a, b, c] = inertias;
        let slack = 1e-9 * (a + b + c);
        let possible = [a + b - c, b + c - a, c + a - b].iter().all(|&x| x >= -slack);
        let allowed = "no principal inertia above the sum of the others";
        if possible { Ok(()) } else { Err(Error::invalid(key, format!("{inertias:?}"), allowed)) }
    }

    fn check(key: &str, value: f64, good: bool, allowed: &str) -> Result<(), Error> {
        if good { Ok(()) } else { Err(Error::invalid(key, value, allowed)) }
    }
}
