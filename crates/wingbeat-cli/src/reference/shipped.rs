//! The documents that ship, by kind.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use toml::{Table, Value};
use wingbeat::scenario::DocumentKind;

use super::root;

/// Longest example, letters.
const LONGEST: usize = 48;

/// A shipped document.
pub struct Shipped {
    /// Its file, from the root.
    pub file: String,
    /// What it is of.
    pub kind: DocumentKind,
    /// Its text.
    pub text: String,
    /// What it says.
    pub table: Table,
}

/// All shipped documents, in the order of their files.
pub fn all() -> Vec<Shipped> {
    let folders = [
        "scenarios",
        "robots",
        "cases",
        "sweeps",
        "rigs",
        "rigs/arms",
        "rigs/runs",
        "rigs/identification",
        "calibrations",
    ];
    folders.into_iter().flat_map(in_folder).collect()
}

fn in_folder(folder: &str) -> Vec<Shipped> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    let document = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        let table: Table = text.parse().unwrap();
        let kind = match folder {
            "scenarios" => DocumentKind::Scenario,
            "robots" => DocumentKind::Robot,
            "cases" => DocumentKind::Case,
            "sweeps" => DocumentKind::Sweep,
            "rigs/arms" => DocumentKind::Arm,
            "rigs" if table.contains_key("runs") => DocumentKind::Runs,
            "rigs" => DocumentKind::Rig,
            "calibrations" => DocumentKind::Calibration,
            _ => DocumentKind::Run,
        };
        let file = format!("{folder}/{}", path.file_name().unwrap().to_str().unwrap());
        Shipped { file, kind, text, table }
    };
    files.into_iter().map(document).collect()
}

/// What the shipped documents of a kind say by key: the first that says it.
pub fn examples(kind: DocumentKind) -> BTreeMap<String, String> {
    let mut examples = BTreeMap::new();
    for document in all().iter().filter(|document| document.kind == kind) {
        walk(&document.table, "", &mut |path, value| {
            let text = value.to_string();
            if !value.is_table() && text.len() <= LONGEST {
                examples.entry(path.to_owned()).or_insert(text);
            }
        });
    }
    examples
}

/// Every key of a table with its value; `[]` stands for any number of a list.
pub fn walk(table: &Table, path: &str, see: &mut impl FnMut(&str, &Value)) {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        see(&path, value);
        match value {
            Value::Table(inner) => walk(inner, &path, see),
            Value::Array(items) => {
                let path = format!("{path}[]");
                items.iter().filter_map(Value::as_table).for_each(|inner| walk(inner, &path, see));
            }
            _ => {}
        }
    }
}

#[test]
fn shipped_documents_name_their_schema_in_the_reference_folder() {
    for document in all() {
        let up = "../".repeat(document.file.matches('/').count());
        let line = format!("#:schema {up}docs/schema/{}.json", document.kind.name());
        assert_eq!(document.text.lines().next(), Some(line.as_str()), "{}", document.file);
    }
}
