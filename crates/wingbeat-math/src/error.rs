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
        /// Paths of the other keys that it clashes with.
        against: Vec<String>,
    },
}

impl Error {
    /// A value that is not allowed.
    pub fn invalid(key: impl Into<String>, value: impl ToString, allowed: impl Into<String>) -> Self {
        Self::Invalid {
            key: key.into(),
            value: value.to_string(),
            allowed: allowed.into(),
            against: Vec::new(),
        }
    }

    /// The same error, which the values of these keys have part in.
    pub fn against<K: Into<String>>(mut self, keys: impl IntoIterator<Item = K>) -> Self {
        let Self::Invalid { against, .. } = &mut self;
        against.extend(keys.into_iter().map(Into::into));
        self
    }

    /// The same error with `prefix.` before its keys; `prefix` alone where there is none.
    pub fn within(self, prefix: &str) -> Self {
        self.with_keys(|key| match key.chars().next() {
            None => prefix.into(),
            Some('[') => format!("{prefix}{key}"),
            Some(_) => format!("{prefix}.{key}"),
        })
    }

    /// The same error with keys by the names of who wrote them: `names` holds pairs of a path as the error has it
    /// and as it was written. The first path that a key is, or lies below, is replaced.
    pub fn renamed<F: AsRef<str>, T: AsRef<str>>(self, names: &[(F, T)]) -> Self {
        let below = |key: &str, from: &str| {
            let rest = key.strip_prefix(from)?;
            (rest.is_empty() || rest.starts_with(['.', '['])).then(|| rest.to_owned())
        };
        self.with_keys(|key| {
            let found = names.iter().find_map(|(from, to)| Some((to, below(&key, from.as_ref())?)));
            found.map_or(key, |(to, rest)| format!("{}{rest}", to.as_ref()))
        })
    }

    fn with_keys(self, rename: impl Fn(String) -> String) -> Self {
        let Self::Invalid { key, value, allowed, against } = self;
        Self::Invalid { key: rename(key), value, allowed, against: against.into_iter().map(rename).collect() }
    }
}

/// Checks of numbers from a configuration, with the message of what is allowed. Values are in the unit of their key, the
/// caller's unit.
pub mod require {
    use super::Error;
    use crate::range::Range;
    use std::fmt::Display;

    /// Finite and above 0.
    pub fn positive(key: &str, value: f64) -> Result<(), Error> {
        Range::POSITIVE.check(key, value)
    }

    /// Finite, 0 or more.
    pub fn not_negative(key: &str, value: f64) -> Result<(), Error> {
        Range::NOT_NEGATIVE.check(key, value)
    }

    /// From `low` to `high`, both allowed.
    pub fn between<T: PartialOrd + Display + Copy>(
        key: &str,
        value: T,
        low: T,
        high: T,
    ) -> Result<(), Error> {
        check(key, value, value >= low && value <= high, || format!("{low} to {high}"))
    }

    /// `high` or less.
    pub fn at_most<T: PartialOrd + Display + Copy>(key: &str, value: T, high: T) -> Result<(), Error> {
        check(key, value, value <= high, || format!("at most {high}"))
    }

    /// All finite; the key says which of several is not.
    pub fn finite(key: &str, values: &[f64]) -> Result<(), Error> {
        let each = |key: &str, value: f64| check(key, value, value.is_finite(), || "a finite number".into());
        match values {
            [value] => each(key, *value),
            values => all(key, values, each),
        }
    }

    /// What `each` asks of every item of a list; the key says which.
    pub fn all(
        key: &str,
        values: &[f64],
        each: impl Fn(&str, f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        values.iter().enumerate().try_for_each(|(i, &value)| each(&format!("{key}[{i}]"), value))
    }

    /// Finite, the lower one first.
    pub fn range(key: &str, [low, high]: [f64; 2]) -> Result<(), Error> {
        finite(key, &[low, high])?;
        let [first, second] = [0, 1].map(|i| format!("{key}[{i}]"));
        let ascending = low <= high;
        if ascending {
            Ok(())
        } else {
            Err(Error::invalid(first, low, format!("at most {high}")).against([second]))
        }
    }

    /// Principal inertias of a real body: none negative, none above the sum of the others.
    pub fn principal_inertias(key: &str, inertias: [f64; 3]) -> Result<(), Error> {
        all(key, &inertias, not_negative)?;
        let largest = (0..3).max_by(|i, j| inertias[*i].total_cmp(&inertias[*j])).unwrap_or(0);
        let others: f64 = (0..3).filter(|i| *i != largest).map(|i| inertias[i]).sum();
        if inertias[largest].is_finite() && inertias[largest] <= others * (1.0 + 1e-9) {
            return Ok(());
        }
        let item = |i: usize| format!("{key}[{i}]");
        let allowed = format!("at most the sum of the other two principal inertias, {others}");
        let clash = (0..3).filter(|i| *i != largest).map(item);
        Err(Error::invalid(item(largest), inertias[largest], allowed).against(clash))
    }

    fn check<T: Display>(
        key: &str,
        value: T,
        good: bool,
        allowed: impl FnOnce() -> String,
    ) -> Result<(), Error> {
        if good { Ok(()) } else { Err(Error::invalid(key, value, allowed())) }
    }
}

#[cfg(test)]
mod tests {
    use super::require::principal_inertias;

    #[test]
    fn the_sum_of_the_other_inertias_is_told_as_it_was_given() {
        let refused = principal_inertias("inertia_kg_m2", [1e-5, 1e-5, 1.0]).unwrap_err().to_string();
        assert!(refused.ends_with(", 0.00002"), "{refused}");
        assert!(principal_inertias("inertia_kg_m2", [1e-5, 1e-5, 2e-5]).is_ok());
    }
}
