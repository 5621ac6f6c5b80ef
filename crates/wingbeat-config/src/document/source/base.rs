//! Documents that are based on others: `base = "cruise_20g.toml"` names a file, which is read below the document.

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Joins, Origin, SourceText, Sources, Texts, joined, limits, tree, unreadable};
use crate::document::{ConfigError, KeyProblem, Wrong, inherit};

/// A base as a document names it.
struct NamedBase {
    /// Its file.
    path: PathBuf,
    /// The steps to the table that names it.
    at: Vec<String>,
    /// The value that names it, to be refused.
    blame: Wrong,
}

impl Sources {
    /// Takes the files that the last text is based on.
    pub(super) fn read_bases(&mut self, texts: Texts) -> Result<(), ConfigError> {
        let base = self.base_of_last()?;
        self.read_chain(base, Joins::Base, texts)
    }

    /// Takes the files that the table at `at` is based on, where it names one.
    pub fn read_bases_of_table(&mut self, at: &[String]) -> Result<(), ConfigError> {
        let tree = self.tree()?;
        let table = at.iter().try_fold(&tree, |value, step| tree::child(value.get_ref(), step));
        let at: Vec<String> = self.root.iter().chain(at).cloned().collect();
        let base = match table.map(Spanned::get_ref) {
            Some(DeValue::Table(table)) => self.base_named_in(table, &at)?,
            _ => None,
        };
        self.read_chain(base, Joins::BaseOfTable, &limits::text_of)
    }

    /// Takes the file that `base` names, the one that this is based on, and so on.
    fn read_chain(&mut self, base: Option<NamedBase>, joins: Joins, texts: Texts) -> Result<(), ConfigError> {
        let (mut next, mut joins, mut chain) = (base, joins, Vec::new());
        while let Some(NamedBase { path, at, blame }) = next {
            refuse_endless(&chain, &path, &blame)?;
            let text = texts(&path).map_err(|error| unreadable(&path, &error.to_string(), Some(blame)))?;
            self.add(Origin::File(path.clone()), text.clone(), &text, at, joins)?;
            chain.push(path);
            joins = Joins::Base;
            next = self.base_of_last()?;
        }
        if chain.is_empty() { Ok(()) } else { self.tree().map(drop) }
    }

    /// The base that the last text names.
    fn base_of_last(&self) -> Result<Option<NamedBase>, ConfigError> {
        let Some(last) = self.texts.last() else { return Ok(None) };
        match self.parsed(last)?.get_ref() {
            DeValue::Table(table) => self.base_named_in(table, &last.at),
            _ => Ok(None),
        }
    }

    /// The base that `table`, which stands at `at`, names. An arm has a table of the same name, the place of its base.
    fn base_named_in(&self, table: &DeTable, at: &[String]) -> Result<Option<NamedBase>, ConfigError> {
        let Some(value) = table.get(inherit::BASE) else { return Ok(None) };
        let key = tree::dotted(&tree::path(at.get(self.root.len()..).unwrap_or_default()), inherit::BASE);
        let (span, problem) = (value.span(), KeyProblem::Value("the name of a file".into()));
        let blame = Wrong::new(self.place(span.start), key, Some(self.text(&span)), problem);
        match value.get_ref() {
            DeValue::String(name) => {
                let path = joined(&self.folder(span.start), name);
                Ok(Some(NamedBase { path, at: at.to_vec(), blame }))
            }
            DeValue::Table(_) => Ok(None),
            _ => Err(blame.into()),
        }
    }

    /// The value of a text, `own`, over those of the files that it is based on, the nearest first.
    pub(super) fn over_bases<'a>(
        &'a self,
        own: Spanned<DeValue<'a>>,
        bases: &'a [SourceText],
    ) -> Result<Spanned<DeValue<'a>>, ConfigError> {
        let Some((base, further)) = bases.split_first() else { return Ok(own) };
        let below = self.over_bases(self.parsed(base)?, further)?;
        inherit::over(below, own).map_err(|refused| {
            let table = tree::path(base.at.get(self.root.len()..).unwrap_or_default());
            let key = if table.is_empty() { refused.key } else { format!("{table}.{}", refused.key) };
            let given = Some(self.text(&refused.span));
            Wrong::new(self.place(refused.span.start), key, given, KeyProblem::Value(refused.allowed)).into()
        })
    }
}

/// Refuses a chain of bases that goes round or on for too long.
fn refuse_endless(chain: &[PathBuf], path: &Path, blame: &Wrong) -> Result<(), ConfigError> {
    let refused = |allowed| Err(Wrong { problem: KeyProblem::Value(allowed), ..blame.clone() }.into());
    if let Some(first) = chain.iter().position(|before| before == path) {
        let names: Vec<String> = chain[first..]
            .iter()
            .map(|path| path.as_path())
            .chain([path])
            .map(|path| path.display().to_string())
            .collect();
        return refused(format!("a file that is not based on itself; these are: {}", names.join(" on ")));
    }
    if chain.len() >= limits::MOST_BASES {
        return refused(format!("a chain of at most {} files, each based on the next", limits::MOST_BASES));
    }
    Ok(())
}
