//! The files of a run: in its folder, or in memory under the same names.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use wingbeat::scenario::{ConfigError, Document};
use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, read_parquet, unchanged};

use crate::Error;
use crate::wake::{self, Shot};

/// Largest text of a run that is read, bytes.
const LARGEST: u64 = 8 << 20;

/// What a run leaves in memory, under the names that its files have.
#[derive(Clone, Debug, Default)]
pub struct RunMemory {
    /// Texts: `summary.json`, `scenario.toml`, pictures of a wake.
    pub texts: BTreeMap<String, String>,
    /// Records: `record.parquet`, `loads.csv`.
    pub records: BTreeMap<String, Record>,
}

/// Where the files of a run are.
#[derive(Clone, Copy, Debug)]
pub enum Files<'a> {
    /// In a folder.
    Folder(&'a Path),
    /// In memory.
    Memory(&'a RunMemory),
}

impl<'a> Files<'a> {
    /// How messages call a file; the whole where `name` is empty.
    pub fn path(self, name: &str) -> PathBuf {
        match self {
            Self::Folder(folder) => folder.join(name),
            Self::Memory(_) if name.is_empty() => "the run".into(),
            Self::Memory(_) => name.into(),
        }
    }

    /// Whether a file is there.
    pub fn has(self, name: &str) -> bool {
        match self {
            Self::Folder(folder) => folder.join(name).is_file(),
            Self::Memory(memory) => memory.texts.contains_key(name) || memory.records.contains_key(name),
        }
    }

    fn none(self, name: &str) -> Error {
        Error::run(&self.path(name), "no such file")
    }

    /// A text.
    pub fn text(self, name: &str) -> Result<String, Error> {
        let path = self.path(name);
        match self {
            Self::Memory(memory) => memory.texts.get(name).cloned().ok_or_else(|| self.none(name)),
            Self::Folder(_) => {
                let size = fs::metadata(&path).map_err(|source| Error::file(&path, source))?.len();
                if size > LARGEST {
                    return Err(Error::run(&path, format!("{size} bytes; read are at most {LARGEST}")));
                }
                unchanged(&path)?;
                fs::read_to_string(&path).map_err(|source| Error::file(&path, source))
            }
        }
    }

    /// An object of JSON.
    pub fn json(self, name: &str) -> Result<Value, Error> {
        let damaged = |what: String| Error::run(&self.path(name), format!("damaged: {what}"));
        let value: Value =
            serde_json::from_str(&self.text(name)?).map_err(|error| damaged(error.to_string()))?;
        if value.is_object() { Ok(value) } else { Err(damaged("not an object".into())) }
    }

    /// A document, from the files that it names.
    pub fn document(self, name: &str) -> Result<Document, ConfigError> {
        match self {
            Self::Folder(folder) => Document::file(&folder.join(name)),
            Self::Memory(memory) => Document::text(name, memory.texts.get(name).map_or("", String::as_str)),
        }
    }

    /// A record.
    pub fn record(self, name: &str) -> Result<Cow<'a, Record>, Error> {
        match self {
            Self::Memory(memory) => {
                memory.records.get(name).map(Cow::Borrowed).ok_or_else(|| self.none(name))
            }
            Self::Folder(folder) if name.ends_with(".csv") => Ok(Cow::Owned(read_csv(&folder.join(name))?)),
            Self::Folder(folder) => Ok(Cow::Owned(read_parquet(&folder.join(name))?)),
        }
    }

    /// The names of the records in Parquet, in their order.
    pub fn parquets(self) -> Result<Vec<String>, Error> {
        let mut names: Vec<String> = match self {
            Self::Memory(memory) => memory.records.keys().cloned().collect(),
            Self::Folder(folder) => {
                let entries = fs::read_dir(folder).map_err(|source| Error::file(folder, source))?;
                entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect()
            }
        };
        names.retain(|name| name.ends_with(".parquet"));
        names.sort();
        Ok(names)
    }

    /// The pictures of a wake.
    pub fn shots(self) -> Result<Vec<Shot>, Error> {
        match self {
            Self::Folder(folder) => wake::shots(folder),
            Self::Memory(memory) => {
                let pictures = memory.texts.iter().filter(|(name, _)| name.ends_with(".vtk"));
                wake::in_order(pictures.map(|(name, text)| wake::read(&self.path(name), text)))
            }
        }
    }
}
