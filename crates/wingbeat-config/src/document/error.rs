//! One message for everything that can be wrong with a configuration.

use std::fmt;
use std::path::PathBuf;

use super::former::today;
use wingbeat_math::names::nearest;

/// Everything that is wrong with a configuration; printed, one line for each.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigError(Vec<Wrong>);

/// One thing that is wrong with a configuration, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// Where it was given.
    pub place: ValuePlace,
    /// Path of the key, e.g. `robot.links.distal.mass_kg`; empty when the file itself is at fault.
    pub key: String,
    /// The value given, as written; none when there is none.
    pub value: Option<String>,
    /// What is wrong with it.
    pub problem: KeyProblem,
    /// Other values that it clashes with.
    pub against: Vec<Other>,
}

/// A value that another one clashes with.
#[derive(Clone, Debug, PartialEq)]
pub struct Other {
    /// Where it was given.
    pub place: ValuePlace,
    /// Path of its key.
    pub key: String,
    /// The value, as written.
    pub value: String,
}

/// Where a value was given.
#[derive(Clone, Debug, PartialEq)]
pub enum ValuePlace {
    /// A line of a file, counted from 1.
    Line(PathBuf, usize),
    /// A file as a whole.
    File(PathBuf),
    /// A line of a text in memory, counted from 1; the name of the text.
    Text(String, usize),
    /// A value of the library, by its name.
    Value(String),
    /// An override, `key=value`: `--set` of the command line.
    Override(String),
    /// In a document without texts.
    Nowhere,
}

/// What is wrong with a key or its value.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyProblem {
    /// The key is not known here; these are.
    UnknownKey {
        /// The keys that are known here.
        allowed: Vec<String>,
    },
    /// The key must be given and is not.
    MissingKey,
    /// The value is not allowed; what is.
    Value(String),
    /// The value is not one of a list of names.
    UnknownName {
        /// The names that are known here.
        allowed: Vec<String>,
    },
    /// The file cannot be read or is not TOML: what the reader says.
    File(String),
}

impl Wrong {
    /// Without values that it clashes with.
    pub(super) fn new(
        place: ValuePlace,
        key: impl Into<String>,
        value: Option<String>,
        problem: KeyProblem,
    ) -> Self {
        Self { place, key: key.into(), value, problem, against: Vec::new() }
    }
}

impl ConfigError {
    /// Everything that is wrong, at least one thing.
    pub fn all(&self) -> &[Wrong] {
        &self.0
    }
}

impl From<Wrong> for ConfigError {
    fn from(wrong: Wrong) -> Self {
        Self(vec![wrong])
    }
}

impl FromIterator<Wrong> for ConfigError {
    fn from_iter<I: IntoIterator<Item = Wrong>>(wrongs: I) -> Self {
        Self(wrongs.into_iter().collect())
    }
}

impl std::error::Error for ConfigError {}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().enumerate().try_for_each(|(i, wrong)| match i {
            0 => write!(f, "{wrong}"),
            _ => write!(f, "\n{wrong}"),
        })
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.place)?;
        if matches!(self.problem, KeyProblem::UnknownKey { .. }) {
            write!(f, "unknown key ")?;
        }
        write!(f, "{}", self.key)?;
        if let Some(value) = &self.value {
            write!(f, " = {value}")?;
        }
        if !self.key.is_empty() && self.problem != KeyProblem::MissingKey {
            write!(f, ": ")?;
        }
        match &self.problem {
            KeyProblem::UnknownKey { allowed } => {
                let last = self.key.rsplit('.').next().unwrap_or("");
                let today = today(last, self.value.as_deref(), allowed);
                write!(f, "{}", today.unwrap_or_else(|| choice(last, allowed)))
            }
            KeyProblem::UnknownName { allowed } => {
                let given = self.value.as_deref().unwrap_or("").trim_matches('"');
                write!(f, "{}", choice(given, allowed))
            }
            KeyProblem::MissingKey => write!(f, " is missing: it must be given"),
            KeyProblem::Value(allowed) => write!(f, "allowed is {allowed}"),
            KeyProblem::File(what) => write!(f, "{what}"),
        }?;
        let mut others = self.against.iter();
        others.try_for_each(|other| write!(f, "; {} = {} ({})", other.key, other.value, other.place))
    }
}

impl fmt::Display for ValuePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(file, line) => write!(f, "{}:{line}", file.display()),
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Text(name, line) => write!(f, "{name}:{line}"),
            Self::Value(name) => write!(f, "{name}"),
            Self::Nowhere => write!(f, "an empty document"),
            Self::Override(text) => write!(f, "--set {text}"),
        }
    }
}

fn choice(given: &str, allowed: &[String]) -> String {
    match (allowed, nearest(given, allowed)) {
        ([], _) => "nothing is allowed here".into(),
        (_, None) => format!("allowed is {}", allowed.join(", ")),
        (_, Some(name)) => format!("did you mean {name}? allowed is {}", allowed.join(", ")),
    }
}
