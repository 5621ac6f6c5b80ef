//! A TOML file with the files it names and the overrides of the command line, and where each value came from.
//!
//! All texts lie one after another in one numbering of bytes, so that the span of a key or value says which
//! line of which file it stands in, or which override. Schemas deserialised from a document should use
//! `deny_unknown_fields` and, for a choice of kinds, serde's external tagging (`[gait.fourier]`): internal tags,
//! `flatten` and untagged enums lose the spans and with them the line of an error.

mod error;
mod explain;
mod source;
mod tree;

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::de::ValueDeserializer;

use crate::Error;
pub use error::{ConfigError, Place, Problem};
use source::Sources;
pub use source::Translate;

/// A merged configuration: a file, the files it names, and overrides.
#[derive(Clone, Debug)]
pub struct Document {
    sources: Sources,
}

impl Document {
    /// Reads the TOML file `path`, puts the file named by each key of `includes` in the place of its name
    /// (relative to the file that names it), and applies `overrides` (`a.b.c=value`, `list[0].c=value`).
    ///
    /// The value of an override is TOML, or else text: `law=stall` means `law="stall"`.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML, an override that names no place, a number that is not finite.
    pub fn load(path: &Path, overrides: &[String], includes: &[&str]) -> Result<Self, ConfigError> {
        Self::load_translated(path, overrides, includes, &|_, _| None)
    }

    /// As [`load`](Self::load); the included files that `translate` knows need not be TOML.
    ///
    /// # Errors
    /// Those of [`load`](Self::load), and what `translate` says of a file.
    pub fn load_translated(
        path: &Path,
        overrides: &[String],
        includes: &[&str],
        translate: Translate,
    ) -> Result<Self, ConfigError> {
        let mut document = Self { sources: Sources::default() };
        document.sources.read_file(path, &[], None)?;
        let key_of = |text: &str| text.split('=').next().unwrap_or_default().trim().to_owned();
        for key in includes {
            let mut named = overrides.iter().filter(|text| key_of(text) == *key);
            named.try_for_each(|text| document.sources.read_override(text))?;
            document.include(key, translate)?;
        }
        let mut rest = overrides.iter().filter(|text| !includes.contains(&key_of(text).as_str()));
        rest.try_for_each(|text| document.sources.read_override(text))?;
        document.refuse_non_finite()?;
        Ok(document)
    }

    /// The document as a `T`.
    ///
    /// # Errors
    /// The first key that is unknown, missing or of the wrong type.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ConfigError> {
        let tree = self.sources.tree()?;
        T::deserialize(ValueDeserializer::from(tree.clone()))
            .map_err(|error| explain::schema(&self.sources, &tree, &error))
    }

    /// Says where the value that `error` refuses was given.
    pub fn explain(&self, error: &Error) -> ConfigError {
        self.sources.tree().map_or_else(|broken| broken, |tree| explain::value(&self.sources, &tree, error))
    }

    /// The merged configuration as TOML, keys in alphabetical order.
    ///
    /// # Errors
    /// Those of [`Document::parse`].
    pub fn resolved(&self) -> Result<String, ConfigError> {
        Ok(self.parse::<toml::Table>()?.to_string())
    }

    /// The files read: the first one and those it names.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.sources.files()
    }

    fn include(&mut self, key: &str, translate: Translate) -> Result<(), ConfigError> {
        let tree = self.sources.tree()?;
        let steps = tree::steps(key);
        let found = steps
            .iter()
            .try_fold(&tree, |value, step| tree::child(value.get_ref(), step).map(|node| node.value));
        let Some(value) = found else { return Ok(()) };
        let Some(name) = value.get_ref().as_str() else { return Ok(()) };
        let at = value.span().start;
        let blame = ConfigError {
            place: self.sources.place(at),
            key: key.into(),
            value: Some(format!("\"{name}\"")),
            problem: Problem::Value(String::new()),
        };
        let folder = self.sources.folder(at);
        let (file, part) = name.split_once('#').map_or((name, None), |(file, part)| (file, Some(part)));
        let path = source::joined(&folder, file);
        match translate(&path, part) {
            Some(text) => self.sources.read_text(&path, text, &steps, Some(blame)),
            None => self.sources.read_file(&source::joined(&folder, name), &steps, Some(blame)),
        }
    }

    fn refuse_non_finite(&self) -> Result<(), ConfigError> {
        let infinite = |text: &str| text.contains("inf") || text.contains("nan");
        let tree = self.sources.tree()?;
        let found =
            tree::find(&tree, &|node| node.value.get_ref().as_float().is_some_and(|f| infinite(f.as_str())));
        found.map_or(Ok(()), |(key, span)| {
            Err(ConfigError {
                place: self.sources.place(span.start),
                key,
                value: Some(self.sources.text(&span)),
                problem: Problem::Value("a finite number".into()),
            })
        })
    }
}
