//! A configuration from files, texts, values and overrides, and where each of its values came from.
//!
//! All texts lie one after another in one numbering of bytes, so that the span of a value says which line of which
//! text it stands in, or which override. Schemas read from a document use `deny_unknown_fields` and, for a choice of
//! kinds, serde's external tagging (`[gait.fourier]`): internal tags, `flatten` and untagged enums hide the types and
//! with them what is missing.

pub(crate) mod airfoil;
mod error;
mod explain;
mod former;
mod inherit;
mod kinds;
pub(crate) mod limits;
pub(crate) mod outline;
mod read;
pub(crate) mod source;
pub(crate) mod tree;

use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::DeValue;

pub use airfoil::AirfoilFile;
pub(super) use airfoil::KEY as AIRFOIL_KEY;
pub use error::{ConfigError, KeyProblem, Other, ValuePlace, Wrong};
pub use former::{Migrated, migrated};
pub(super) use inherit::{BASE, WITHOUT};
pub use limits::{largest, spoken, text_of, unit};
pub(super) use outline::KEY as OUTLINE_KEY;
pub use outline::OutlineFile;
pub use source::Translate;
use source::{ListedOverride, Origin, Sources};
use wingbeat_math::Error;
pub use wingbeat_math::names::nearest_names;
use wingbeat_math::names::one_of;
use wingbeat_math::range::Range;

use super::spec::StartSpec;

/// A configuration: a file, a text or a value, what is put into it, and overrides.
///
/// ```
/// use wingbeat_config::Document;
///
/// let robot = Document::text("robot", "mass_kg = 0.02\ncolours = [\"red\"]")?;
/// let document = Document::text("flight", "name = \"up\"")?.put("robot", robot)?.set("robot.mass_kg=0.03");
///
/// #[derive(serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Robot {
///     mass_kg: f64,
///     colours: Vec<String>,
/// }
///
/// #[derive(serde::Deserialize)]
/// #[serde(deny_unknown_fields)]
/// struct Flight {
///     name: String,
///     robot: Robot,
/// }
///
/// let flight: Flight = document.parse()?;
/// assert_eq!((flight.name.as_str(), flight.robot.mass_kg), ("up", 0.03));
/// assert_eq!(flight.robot.colours, ["red"]);
///
/// let refused = document.set("robot.mass=1").parse::<Flight>().err().map(|error| error.to_string());
/// let expected = "--set robot.mass=1: unknown key robot.mass = 1: did you mean mass_kg? allowed is mass_kg, colours";
/// assert_eq!(refused.as_deref(), Some(expected));
/// # Ok::<(), wingbeat_config::ConfigError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Document {
    sources: Sources,
    /// Overrides that are not yet applied: files that the document names come before them.
    overrides: Vec<(String, Option<ListedOverride>)>,
    /// Whether it is merged, after which numbers without meaning are refused.
    merged: bool,
}

impl Document {
    /// The TOML file `path`, over the one that its key `base` names, if it has one.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML.
    pub fn file(path: &Path) -> Result<Self, ConfigError> {
        Self::among(path, &text_of)
    }

    /// [`file`](Self::file) where `texts` tells what files hold, such as those that a program has compiled in.
    ///
    /// # Errors
    /// Those of [`file`](Self::file).
    pub fn among(path: &Path, texts: &dyn Fn(&Path) -> io::Result<String>) -> Result<Self, ConfigError> {
        let mut document = Self::default();
        document.sources.read_file(path, texts, &[], None)?;
        Ok(document)
    }

    /// A TOML text; errors call it `name`. Paths in it are seen from the working folder.
    ///
    /// # Errors
    /// A text that is not TOML, a file which it is based on that cannot be read.
    pub fn text(name: &str, toml: &str) -> Result<Self, ConfigError> {
        let mut document = Self::default();
        document.sources.read_based(Origin::Text(name.into()), toml.into())?;
        Ok(document)
    }

    /// A value that can be serialised, such as a [`ScenarioSpec`](super::ScenarioSpec); errors call it `name`.
    ///
    /// # Errors
    /// A value that TOML cannot hold.
    pub fn value(name: &str, value: &impl Serialize) -> Result<Self, ConfigError> {
        let toml = crate::written::toml(value).map_err(|error| {
            let what = format!("cannot be written as TOML: {error}");
            Wrong::new(ValuePlace::Value(name.into()), "", None, KeyProblem::File(what))
        })?;
        let mut document = Self::default();
        document.sources.read(Origin::Value(name.into()), toml, &[])?;
        Ok(document)
    }

    /// This document with `other` under `key`, in place of what stands there.
    ///
    /// # Errors
    /// A key that is inside a value that is no table.
    pub fn put(mut self, key: &str, other: Self) -> Result<Self, ConfigError> {
        self.sources.put(other.sources, &tree::steps(key))?;
        let key = key.to_owned();
        let within = |(text, listed)| (format!("{key}.{text}"), listed);
        self.overrides.extend(other.overrides.into_iter().map(within));
        Ok(self)
    }

    /// This document with an override, `a.b.c=value` or `list[0].c=value`, which is read last.
    ///
    /// The value is TOML, or else text: `law=stall` means `law="stall"`.
    #[must_use]
    pub fn set(mut self, text: impl Into<String>) -> Self {
        self.overrides.push((text.into(), None));
        self
    }

    /// This document with several [overrides](Self::set).
    #[must_use]
    pub fn overridden(mut self, texts: &[String]) -> Self {
        self.overrides.extend(texts.iter().map(|text| (text.clone(), None)));
        self
    }

    /// This document with the overrides of what stands at `within` that it lists itself at `key`; files that they name are sought
    /// from where they are listed.
    ///
    /// # Errors
    /// A list that is none of texts.
    pub fn overridden_by_list(mut self, key: &str, within: &str) -> Result<Self, ConfigError> {
        let texts: Vec<String> = self.parse_at(key)?;
        for (i, text) in texts.iter().enumerate() {
            let item = format!("{key}[{i}]");
            let listed = self.written(&item).map(|(_, place)| (place, self.folder(&item)));
            self.overrides.push((format!("{within}.{text}"), listed));
        }
        Ok(self)
    }

    /// The TOML file `path` with the files named by `includes` and with `overrides`.
    ///
    /// # Errors
    /// Those of [`file`](Self::file) and [`merged`](Self::merged).
    pub fn load(path: &Path, overrides: &[String], includes: &[&str]) -> Result<Self, ConfigError> {
        Self::file(path)?.overridden(overrides).merged(includes, &|_, _| None)
    }

    /// This document with the file named by each key of `includes` in the place of its name (relative to the file
    /// that names it; a table there stays), and with its overrides. Files that `translate` knows need not be TOML.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML, an override that names no place.
    pub fn merged(mut self, includes: &[&str], translate: Translate) -> Result<Self, ConfigError> {
        let key_of = |text: &str| text.split('=').next().unwrap_or_default().trim().to_owned();
        let overrides = std::mem::take(&mut self.overrides);
        for key in includes {
            let mut named = overrides.iter().filter(|(text, _)| key_of(text) == *key);
            named.try_for_each(|(text, listed)| self.sources.read_override(text, listed.clone()))?;
            self.include(key, translate)?;
        }
        let rest = overrides.into_iter().filter(|(text, _)| !includes.contains(&key_of(text).as_str()));
        // The stations of an outline are there before an override names one.
        let (outlines, rest): (Vec<_>, Vec<_>) = rest.partition(|(text, _)| of_outline(&key_of(text)));
        for overrides in [outlines, rest] {
            overrides.into_iter().try_for_each(|(text, listed)| self.sources.read_override(&text, listed))?;
            self.read_outlines()?;
        }
        self.read_airfoils()?;
        self.merged = true;
        Ok(self)
    }

    /// The document as a `T`.
    ///
    /// # Errors
    /// All keys that are unknown, missing or of the wrong type; else, of a merged document, a number that is not finite or beyond any
    /// meaning of the unit that its key ends with.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ConfigError> {
        if !self.overrides.is_empty() {
            return self.clone().merged(&[], &|_, _| None)?.parse();
        }
        self.parse_at("")
    }

    /// What stands at `key` of the merged document as a `T`.
    ///
    /// # Errors
    /// Those of [`parse`](Self::parse) below; nothing at `key`.
    pub fn parse_at<T: DeserializeOwned>(&self, key: &str) -> Result<T, ConfigError> {
        let tree = self.sources.tree()?;
        let Some(node) = tree::follow(&tree, key) else {
            return Err(Wrong { problem: KeyProblem::MissingKey, ..self.blame(&tree, key) }.into());
        };
        let value =
            read::read(node, key).map_err(|complaints| explain::form(&self.sources, &tree, &complaints))?;
        if self.merged {
            self.refuse_immense(&tree)?;
        }
        Ok(value)
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

    /// True when overrides change nothing of the merged document but what stands at `keys`.
    pub fn overridden_only_at(&self, keys: &[&str]) -> bool {
        let written = Self { sources: self.sources.as_written(), ..Self::default() };
        let besides = |document: &Self| {
            let mut table = document.parse::<toml::Table>().ok()?;
            keys.iter().for_each(|key| tree::remove(&mut table, &tree::steps(key)));
            Some(table)
        };
        besides(self) == besides(&written)
    }

    /// Paths of the values that overrides give, each with its value as written.
    pub(super) fn given_by_overrides(&self) -> Vec<(String, String)> {
        let mut given = Vec::new();
        if let Ok(tree) = self.sources.tree() {
            tree::walk(&tree, &mut |path, value| {
                if self.sources.is_override(value.span().start) {
                    given.push((path.to_owned(), self.sources.text(&value.span())));
                }
            });
        }
        given
    }

    /// This merged document without each of its overrides in turn, with the key and the text of that.
    pub(super) fn without_each_override(&self) -> impl Iterator<Item = (String, String, Self)> {
        let each = self.sources.without_each_override();
        each.map(|(at, text, sources)| (tree::path(at), text, Self { sources, ..self.clone() }))
    }

    /// The files read: the first one and those it names.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.sources.files()
    }

    /// The folder from which the value at `key` sees paths: that of its file; empty where it is in none.
    pub fn folder(&self, key: &str) -> PathBuf {
        let found = |tree: &Spanned<DeValue>| tree::follow(tree, key).map(|value| value.span().start);
        let at = self.sources.tree().ok().and_then(|tree| found(&tree));
        at.map(|at| self.sources.folder(at)).unwrap_or_default()
    }

    /// The document that stands at `key`: a table, or the file that a text there names.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML, another value than a table or the name of a file.
    pub fn part(&self, key: &str) -> Result<Self, ConfigError> {
        let tree = self.sources.tree()?;
        match tree::follow(&tree, key).map(Spanned::get_ref) {
            Some(DeValue::Table(_)) => {
                let mut sources = self.sources.part(&tree::steps(key));
                sources.read_bases_of_table(&[])?;
                Ok(Self { sources, overrides: self.overrides.clone(), merged: false })
            }
            Some(DeValue::String(name)) => {
                let mut document = Self::default();
                let path = source::joined(&self.folder(key), name);
                document.sources.read_file(&path, &text_of, &[], Some(self.blame(&tree, key)))?;
                Ok(document)
            }
            _ => {
                let problem = KeyProblem::Value("the name of a file, or a table".into());
                Err(Wrong { problem, ..self.blame(&tree, key) }.into())
            }
        }
    }

    /// An error about the value at `key`.
    fn blame(&self, tree: &Spanned<DeValue>, key: &str) -> Wrong {
        let span = tree::follow(tree, key).unwrap_or(tree).span();
        let given = Some(self.sources.text(&span));
        Wrong::new(self.sources.place(span.start), key, given, KeyProblem::Value(String::new()))
    }

    /// The paths of all numbers, in the order of the tree.
    pub fn numbers(&self) -> Vec<String> {
        let mut paths = Vec::new();
        if let Ok(tree) = self.sources.tree() {
            tree::walk(&tree, &mut |path, value| {
                if matches!(value.get_ref(), DeValue::Integer(_) | DeValue::Float(_)) {
                    paths.push(path.to_owned());
                }
            });
        }
        paths
    }

    /// `key` with the numbers of items of lists where it has their names.
    pub fn numbered(&self, key: &str) -> String {
        self.sources.tree().map_or_else(|_| key.to_owned(), |tree| tree::numbered(&tree, key))
    }

    /// The value at `key` as written, cut to one line, and where; none where it is not given.
    pub fn written(&self, key: &str) -> Option<(String, ValuePlace)> {
        let tree = self.sources.tree().ok()?;
        let span = tree::follow(&tree, key)?.span();
        Some((self.sources.text(&span), self.sources.place(span.start)))
    }

    /// The number at `key`, in the unit that ends the key.
    ///
    /// # Errors
    /// What is allowed, where there is none.
    pub fn number(&self, key: &str) -> Result<f64, String> {
        let written = self.written(key).and_then(|(text, _)| text.replace('_', "").parse().ok());
        written.ok_or_else(|| {
            format!("a key of the scenario with a number, one {}", one_of(key, &self.numbers()))
        })
    }

    fn include(&mut self, key: &str, translate: Translate) -> Result<(), ConfigError> {
        let tree = self.sources.tree()?;
        let Some(value) = tree::follow(&tree, key) else { return Ok(()) };
        let (blame, steps) = (self.blame(&tree, key), tree::steps(key));
        let Some(name) = value.get_ref().as_str() else { return self.sources.read_bases_of_table(&steps) };
        let folder = self.sources.folder(value.span().start);
        let (file, part) = name.split_once('#').map_or((name, None), |(file, part)| (file, Some(part)));
        let path = source::joined(&folder, file);
        let whole = source::joined(&folder, name);
        match translate(&path, part) {
            Some(text) => self.sources.read_text(&path, text, &steps, Some(blame)),
            None => self.sources.read_file(&whole, &text_of, &steps, Some(blame)),
        }
    }

    /// Puts the stations of the files that outlines name in their places.
    fn read_outlines(&mut self) -> Result<(), ConfigError> {
        self.read_named::<OutlineFile>(outline::KEY, "file", &|named| &named.file, &OutlineFile::toml)
    }

    /// Puts the angles of the sections that files hold in their places.
    fn read_airfoils(&mut self) -> Result<(), ConfigError> {
        let toml = |_: &AirfoilFile, file: &Path, text: &str, key: &str| AirfoilFile::toml(file, text, key);
        self.read_named::<AirfoilFile>(airfoil::KEY, "airfoil", &|named| &named.airfoil, &toml)
    }

    /// Puts what a file says, `toml` of it, in the place of each table called `name` that names one by its key `own`.
    fn read_named<T: DeserializeOwned>(
        &mut self,
        name: &str,
        own: &str,
        file: &dyn Fn(&T) -> &PathBuf,
        toml: Toml<T>,
    ) -> Result<(), ConfigError> {
        loop {
            let tree = self.sources.tree()?;
            let Some(steps) = tree::table_called(&tree, name) else { return Ok(()) };
            let key = tree::path(&steps);
            let named = self.parse_at::<T>(&key)?;
            let of_file = format!("{key}.{own}");
            let at = tree::follow(&tree, &of_file).map_or(0, |value| value.span().start);
            let file = source::joined(&self.sources.folder(at), &file(&named).to_string_lossy());
            let text = limits::old_text_of(&file).map_err(|error| {
                let allowed = format!("a file that can be read; {}: {error}", file.display());
                Wrong { problem: KeyProblem::Value(allowed), ..self.blame(&tree, &of_file) }
            })?;
            let toml = toml(&named, &file, &text, &key)?;
            drop(tree);
            self.sources.read_table(&file, &toml, &steps)?;
        }
    }

    /// Refuses numbers without meaning, once the form is right: only a type says where a number may stand.
    fn refuse_immense(&self, tree: &Spanned<DeValue<'_>>) -> Result<(), ConfigError> {
        let immense = |path: &str, text: &str| {
            !text.replace('_', "").parse::<f64>().is_ok_and(|number| number.abs() <= limits::largest(path))
        };
        let number = |value: &DeValue| match value {
            DeValue::Float(float) => Some(float.as_str().to_owned()),
            DeValue::Integer(whole) if whole.radix() == 10 => Some(whole.as_str().to_owned()),
            _ => None,
        };
        let mut found = None;
        tree::walk(tree, &mut |path, value| {
            let fits = number(value.get_ref()).is_none_or(|text| !immense(path, &text));
            if found.is_none() && !fits && !path.ends_with("seed") {
                found = Some((path.to_owned(), value.span()));
            }
        });
        found.map_or(Ok(()), |(key, span)| {
            let (place, given) = (self.sources.place(span.start), Some(self.sources.text(&span)));
            let largest = limits::largest(&key);
            let largest = if largest < 1e5 { largest.to_string() } else { format!("{largest:e}") };
            let own = of_start(&key).map(|range| range.allowed());
            // Of what is no number its size is not at fault, and the key may allow less than its unit.
            let nan = given.as_deref().is_some_and(|given| given.parse().is_ok_and(f64::is_nan));
            let most = if nan { String::new() } else { format!(", {largest} or less in magnitude") };
            let allowed = own.unwrap_or_else(|| format!("a finite number{most}"));
            let problem = KeyProblem::Value(allowed);
            Err(Wrong::new(place, key, given, problem).into())
        })
    }
}

/// The TOML, `v=...`, of what a table names: its file, the text of that, its key.
type Toml<'a, T> = &'a dyn Fn(&T, &Path, &str, &str) -> Result<String, ConfigError>;

/// The range of a number of `[start]`, which is narrower than that of its unit.
fn of_start(key: &str) -> Option<Range> {
    let own = key.strip_prefix("start.")?.split('[').next()?;
    StartSpec::RANGES.iter().find(|(name, _)| *name == own).map(|(_, range)| *range)
}

/// Whether an override is of the file of an outline: of the outline itself, or of a key in it that is no station.
fn of_outline(key: &str) -> bool {
    let steps = tree::steps(key);
    let at = steps.iter().position(|step| step == outline::KEY);
    at.is_some_and(|at| steps.get(at + 1).is_none_or(|step| step.parse::<usize>().is_err()))
}
