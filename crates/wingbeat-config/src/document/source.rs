//! The texts a document was made of, in one numbering of bytes.

mod base;

use std::io;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{ConfigError, KeyProblem, ValuePlace, Wrong, limits, tree};

/// The texts, one after another: a byte's number says which text it is in.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    texts: Vec<SourceText>,
    /// The steps to the table that is looked at.
    root: Vec<String>,
}

/// Where a text comes from.
#[derive(Clone, Debug)]
pub enum Origin {
    /// A file.
    File(PathBuf),
    /// A text in memory, by its name.
    Text(String),
    /// A file of another format, as a value: `v=...`, line by line.
    Table(PathBuf),
    /// A value of the library, by its name.
    Value(String),
    /// `key=value`, of a document that lists it where it does: its place and the folder of its file.
    Override(Option<ListedOverride>),
}

/// Where a document lists an override.
pub type ListedOverride = (ValuePlace, PathBuf);

#[derive(Clone, Debug)]
struct SourceText {
    origin: Origin,
    /// As it was given.
    text: String,
    /// Number of its first byte.
    start: usize,
    /// As TOML, moved right by `start`, so that spans count from the first text.
    toml: String,
    /// The steps to the place in the tree that it takes.
    at: Vec<String>,
    joins: Joins,
}

/// How a text comes into the tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Joins {
    /// In the place of what stands there.
    Instead,
    /// Below the text before it, which is based on it.
    Base,
    /// Below the table that stands there, which is based on it.
    BaseOfTable,
}

/// Tells the text of a file.
pub type Texts<'a> = &'a dyn Fn(&Path) -> io::Result<String>;

/// Tells the TOML of a file of another format, or why it cannot be read; `None` for TOML files.
/// The second argument is the part of the file asked for: what follows a `#` after its name.
pub type Translate<'a> = &'a dyn Fn(&Path, Option<&str>) -> Option<Result<String, String>>;

impl Sources {
    /// Reads a file, one of `texts`, that takes the place `at`, and those that it is based on; `blame` is the key
    /// that names it, if one does.
    pub fn read_file(
        &mut self,
        path: &Path,
        texts: Texts,
        at: &[String],
        blame: Option<Wrong>,
    ) -> Result<(), ConfigError> {
        let text = texts(path).map_err(|error| error.to_string());
        self.read_text(path, text, at, blame)?;
        self.read_bases(texts)
    }

    /// Takes the `text` of a file, or why there is none, without what it is based on.
    pub fn read_text(
        &mut self,
        path: &Path,
        text: Result<String, String>,
        at: &[String],
        blame: Option<Wrong>,
    ) -> Result<(), ConfigError> {
        let text = text.map_err(|error| unreadable(path, &error, blame))?;
        self.read(Origin::File(path.into()), text, at)
    }

    /// Takes a text and the files that it is based on, as seen from the working folder.
    pub fn read_based(&mut self, origin: Origin, text: String) -> Result<(), ConfigError> {
        self.read(origin, text, &[])?;
        self.read_bases(&limits::text_of)
    }

    /// Takes a text.
    pub fn read(&mut self, origin: Origin, text: String, at: &[String]) -> Result<(), ConfigError> {
        let toml = text.clone();
        let at = self.root.iter().chain(at).cloned().collect();
        self.add(origin, text, &toml, at, Joins::Instead)?;
        self.last_is_toml()
    }

    /// Takes the value `toml`, `v=...`, whose lines are those of `file`, in the place `at`.
    pub fn read_table(&mut self, file: &Path, toml: &str, at: &[String]) -> Result<(), ConfigError> {
        let at = self.root.iter().chain(at).cloned().collect();
        self.add(Origin::Table(file.into()), toml.into(), toml, at, Joins::Instead)?;
        self.last_is_toml()
    }

    /// Refuses a last text that is not TOML; what clashes with other texts is told where all are read as one tree.
    fn last_is_toml(&self) -> Result<(), ConfigError> {
        self.texts.last().map_or(Ok(()), |last| self.parsed(last).map(drop))
    }

    /// Takes the texts of `other`, with the place `at` for their root.
    pub fn put(&mut self, other: Self, at: &[String]) -> Result<(), ConfigError> {
        for source in other.texts {
            let at = self.root.iter().chain(at).cloned().chain(source.at).collect();
            self.add(source.origin, source.text, &source.toml[source.start..], at, source.joins)?;
        }
        self.tree().map(drop)
    }

    /// Reads an override `key=value`, of a document that lists it where it does; the value is TOML or else text.
    pub fn read_override(&mut self, text: &str, listed: Option<ListedOverride>) -> Result<(), ConfigError> {
        let Some((key, value)) = text.split_once('=').filter(|(key, _)| !tree::steps(key).is_empty()) else {
            return Err(of_place(place_of(text, &listed), "allowed is KEY=VALUE".into()));
        };
        let mut toml = format!("v={}", value.trim());
        if !DeTable::parse(&toml).is_ok_and(|table| table.get_ref().len() == 1) {
            toml = format!("v={}", toml::Value::from(value.trim()));
        }
        let at: Vec<String> = self.root.iter().cloned().chain(tree::steps(key)).collect();
        if at.len() > limits::DEEPEST {
            let what = format!("allowed is a key of at most {} names", limits::DEEPEST);
            return Err(of_place(place_of(&brief(text), &listed), what));
        }
        self.add(Origin::Override(listed), text.into(), &toml, at, Joins::Instead)
    }

    /// The texts as one tree, later ones in the place of earlier ones, each over those that it is based on.
    pub fn tree(&self) -> Result<Spanned<DeValue<'_>>, ConfigError> {
        let mut root = Spanned::new(0..0, DeValue::Table(DeTable::new()));
        for chain in self.texts.chunk_by(|_, next| next.joins == Joins::Base) {
            let Some((source, bases)) = chain.split_first() else { continue };
            let value = match source.joins {
                Joins::BaseOfTable => self.over_bases(tree::swap(&mut root, &source.at), chain)?,
                _ => self.over_bases(self.parsed(source)?, bases)?,
            };
            if matches!(source.origin, Origin::Override(_)) {
                let written = |at: usize| !self.is_override(at);
                tree::displace(&mut root, &source.at, &written, &crate::schema::are_alternatives);
            }
            tree::assign(&mut root, &source.at, value).map_err(|allowed| {
                let key = tree::path(&source.at);
                Wrong::new(self.place(source.start), key, None, KeyProblem::Value(allowed))
            })?;
        }
        Ok(tree::taken(root, &self.root))
    }

    fn parsed<'a>(&self, source: &'a SourceText) -> Result<Spanned<DeValue<'a>>, ConfigError> {
        source.parse().map_err(|error| {
            let at = error.span().map_or(source.start, |span| span.start);
            of_place(self.place(at), format!("not TOML: {}", error.message()))
        })
    }

    /// The same without overrides.
    pub fn as_written(&self) -> Self {
        let written = |source: &&SourceText| !matches!(source.origin, Origin::Override(_));
        Self { texts: self.texts.iter().filter(written).cloned().collect(), root: self.root.clone() }
    }

    /// The same without each of the overrides in turn, with the steps to the place of that and its text.
    pub fn without_each_override(&self) -> impl Iterator<Item = (&[String], String, Self)> {
        let overrides = self.texts.iter().enumerate();
        let overrides = overrides.filter(|(_, source)| {
            matches!(source.origin, Origin::Override(_)) && source.at.starts_with(&self.root)
        });
        overrides.map(|(k, source)| {
            let mut others = self.clone();
            others.texts.remove(k);
            (&source.at[self.root.len()..], shown(&source.text), others)
        })
    }

    /// Whether byte `at` is in an override.
    pub fn is_override(&self, at: usize) -> bool {
        self.source(at).is_some_and(|source| matches!(source.origin, Origin::Override(_)))
    }

    /// The same texts, of which only what lies at `steps` is looked at.
    pub fn part(&self, steps: &[String]) -> Self {
        let root = self.root.iter().chain(steps).cloned().collect();
        Self { texts: self.texts.clone(), root }
    }

    /// Where byte `at` stands.
    pub fn place(&self, at: usize) -> ValuePlace {
        let Some(source) = self.source(at) else { return ValuePlace::Nowhere };
        let before = source.text.as_bytes().iter().take(at - source.start);
        let line = 1 + before.filter(|byte| **byte == b'\n').count();
        match &source.origin {
            Origin::File(file) | Origin::Table(file) => ValuePlace::Line(file.clone(), line),
            Origin::Text(name) => ValuePlace::Text(name.clone(), line),
            Origin::Value(name) => ValuePlace::Value(name.clone()),
            Origin::Override(listed) => place_of(&source.text, listed),
        }
    }

    /// The folder of the file that byte `at` is in; empty where it is in none.
    pub fn folder(&self, at: usize) -> PathBuf {
        let source = self.source(at);
        if let Some(Origin::Override(Some((_, folder)))) = source.map(|source| &source.origin) {
            return folder.clone();
        }
        let file = source.and_then(|source| source.file()?.parent());
        file.map(Path::to_path_buf).unwrap_or_default()
    }

    /// The text of a value, short enough for one line.
    pub fn text(&self, span: &Range<usize>) -> String {
        let Some(source) = self.source(span.start) else { return String::new() };
        match &source.origin {
            Origin::Override(_) if span.start == source.start => {
                brief(source.text.split_once('=').map_or("", |(_, value)| value.trim()))
            }
            Origin::Override(_) => brief(source.toml.get(span.clone()).unwrap_or("")),
            _ => brief(source.text.get(span.start - source.start..span.end - source.start).unwrap_or("")),
        }
    }

    /// The files, in the order read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.texts.iter().filter_map(SourceText::file)
    }

    fn source(&self, at: usize) -> Option<&SourceText> {
        self.texts.iter().rev().find(|source| source.start <= at)
    }

    /// Adds a text, moved behind all others.
    fn add(
        &mut self,
        origin: Origin,
        text: String,
        toml: &str,
        at: Vec<String>,
        joins: Joins,
    ) -> Result<(), ConfigError> {
        let start = self.texts.last().map_or(0, |last| last.toml.len().max(last.start + last.text.len()) + 1);
        let taken: usize = self.texts.iter().map(|source| source.toml.len()).sum();
        if taken.saturating_add(start).saturating_add(toml.len()) > limits::LARGEST_DOCUMENT {
            let what = format!("allowed are fewer or shorter texts: {} of them so far", self.texts.len());
            return Err(of_place(ValuePlace::Override(brief(&text)), what));
        }
        let toml = " ".repeat(start) + toml;
        self.texts.push(SourceText { origin, text, start, toml, at, joins });
        Ok(())
    }
}

impl SourceText {
    fn file(&self) -> Option<&Path> {
        match &self.origin {
            Origin::File(file) | Origin::Table(file) => Some(file),
            _ => None,
        }
    }

    fn parse(&self) -> Result<Spanned<DeValue<'_>>, toml::de::Error> {
        let table = DeTable::parse(&self.toml)?;
        let span = self.start..self.start + self.text.len();
        let mut table = table.into_inner();
        let value = match self.origin {
            Origin::Override(_) | Origin::Table(_) => table.remove("v").map(Spanned::into_inner),
            _ => None,
        };
        Ok(Spanned::new(span, value.unwrap_or(DeValue::Table(table))))
    }
}

/// Where an override stands.
fn place_of(text: &str, listed: &Option<ListedOverride>) -> ValuePlace {
    listed.as_ref().map_or_else(|| ValuePlace::Override(shown(text)), |(place, _)| place.clone())
}

/// An override as messages show it: whole, unless it is very long.
fn shown(text: &str) -> String {
    if text.len() <= 200 { text.into() } else { brief(text) }
}

/// The error of a file that cannot be read; `blame` is the key that names it, if one does.
fn unreadable(path: &Path, why: &str, blame: Option<Wrong>) -> ConfigError {
    let Some(blame) = blame else { return of_place(ValuePlace::File(path.into()), why.into()) };
    let allowed = format!("a file that can be read; {}: {why}", path.display());
    Wrong { problem: KeyProblem::Value(allowed), ..blame }.into()
}

fn of_place(place: ValuePlace, what: String) -> ConfigError {
    Wrong::new(place, "", None, KeyProblem::File(what)).into()
}

/// `text` on one line of at most 60 letters.
pub fn brief(text: &str) -> String {
    let line = text.lines().next().unwrap_or("");
    if line.len() == text.len() && line.chars().count() <= 60 {
        return line.into();
    }
    line.chars().take(57).chain("...".chars()).collect()
}

/// `name` seen from `folder`, without `.` and with `..` taken out where that is possible.
pub fn joined(folder: &Path, name: &str) -> PathBuf {
    let mut path = PathBuf::new();
    for part in folder.join(name).components() {
        let inside = matches!(path.components().next_back(), Some(Component::Normal(_)));
        match part {
            Component::CurDir => {}
            Component::ParentDir if inside => {
                path.pop();
            }
            part => path.push(part),
        }
    }
    path
}
