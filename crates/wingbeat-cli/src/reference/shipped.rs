//! The documents that ship, by kind.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use toml::{Table, Value};
use wingbeat::scenario::{Document, DocumentKind};

use super::root;

/// Longest example, letters.
const LONGEST: usize = 48;

/// A shipped document.
pub struct ShippedDocument {
    /// Its file, from the root.
    pub file: String,
    /// What it is of.
    pub kind: DocumentKind,
    /// Its text.
    pub text: String,
    /// The files that it is based on.
    bases: Vec<PathBuf>,
    /// What it says, over what it is based on.
    pub table: Table,
}

/// All shipped documents, in the order of their files.
pub fn all() -> Vec<ShippedDocument> {
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

fn in_folder(folder: &str) -> Vec<ShippedDocument> {
    let entries = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    let document = |path: PathBuf| {
        let text = fs::read_to_string(&path).unwrap();
        let document = Document::file(&path).unwrap();
        let table: Table = document.parse().unwrap();
        let bases = document.files().skip(1).map(Path::to_path_buf).collect();
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
        ShippedDocument { file, kind, text, bases, table }
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

/// Words of docs/sources.md that a number's comment may have.
fn sources() -> Vec<String> {
    let page = fs::read_to_string(root().join("docs/sources.md")).unwrap();
    let word = |line: &str| line.strip_prefix("| `")?.split('`').next().map(str::to_owned);
    page.lines().filter_map(word).collect()
}

fn is_sourced(comment: &str, sources: &[String]) -> bool {
    sources.iter().any(|word| comment.contains(word.as_str()))
}

/// Whether a file says for all of its numbers where they are from.
fn is_sourced_as_a_whole(text: &str, sources: &[String]) -> bool {
    let top = text.lines().take_while(|line| line.starts_with('#'));
    top.filter_map(|line| line.strip_prefix("# Sources:")).any(|comment| is_sourced(comment, sources))
}

/// Places of numbers without a source, by line: by its comment, that of its table's header, or the file's.
fn unsourced(text: &str, sources: &[String]) -> Vec<usize> {
    let sourced = |comment: &str| is_sourced(comment, sources);
    let whole = is_sourced_as_a_whole(text, sources);
    let (mut table, mut covered) = (String::new(), false);
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let (code, comment) = split(line);
        if code.starts_with('[') && code.trim_end().ends_with(']') && !code.contains(['=', ',']) {
            // A list of tables goes on under the comment of its first.
            covered = sourced(comment) || (code.trim() == table && covered);
            table = code.trim().to_owned();
        } else if has_number(code) && !sourced(comment) && !covered && !whole {
            found.push(i + 1);
        }
    }
    found
}

/// A line of TOML and its comment.
fn split(line: &str) -> (&str, &str) {
    let mut quoted = false;
    for (i, c) in line.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '#' if !quoted => return (&line[..i], &line[i..]),
            _ => {}
        }
    }
    (line, "")
}

/// Whether the value of a line holds a number: a digit outside of words and keys.
fn has_number(code: &str) -> bool {
    let (mut quoted, mut before) = (false, ' ');
    for c in code.chars() {
        if c == '"' {
            quoted = !quoted;
        }
        let begins = c.is_ascii_digit() && !(before.is_alphanumeric() || before == '_');
        if begins && !quoted {
            return true;
        }
        before = c;
    }
    false
}

#[test]
fn every_number_of_robots_scenarios_and_rigs_has_a_source() {
    let (sources, mut bare) = (sources(), Vec::new());
    assert!(sources.iter().any(|word| word == "choice") && sources.len() > 5);
    let kept = ["robots/", "scenarios/", "rigs/"];
    for document in all().iter().filter(|d| kept.iter().any(|folder| d.file.starts_with(folder))) {
        let text_of = |path: &PathBuf| fs::read_to_string(path).unwrap();
        if document.bases.iter().map(text_of).any(|text| is_sourced_as_a_whole(&text, &sources)) {
            continue;
        }
        bare.extend(
            unsourced(&document.text, &sources).iter().map(|line| format!("{}:{line}", document.file)),
        );
    }
    assert!(bare.is_empty(), "numbers without a word of docs/sources.md: {}", bare.join(", "));
}

#[test]
fn a_number_is_sourced_by_line_table_or_file() {
    let sources = ["choice".to_owned()];
    let text = "a_2 = \"no 1\"\n[t]\nb = 1\n[u] # choice\nc = 2\n[[v]] # choice\nd = 3\n[[v]]\ne = 4\n[w]\nf = [\n  5,\n]\ng = 6 # choice\n";
    assert_eq!(unsourced(text, &sources), [3, 12]);
    assert!(unsourced(&format!("# Sources: choice\n{text}"), &sources).is_empty());
}
