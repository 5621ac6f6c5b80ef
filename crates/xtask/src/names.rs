//! Names of types: a reader who meets one knows which type is meant.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Every crate has one error enum of this name.
const OF_EVERY_CRATE: &str = "Error";

/// Sources below `folder`.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|extension| extension == "rs") {
            found.push(entry);
        }
    }
}

/// The name of the type that a line declares; associated types stand in a block without `pub`.
fn declared(line: &str) -> Option<&str> {
    let inner = line.trim_start();
    let plain = match inner.strip_prefix("pub") {
        Some(rest) => rest.trim_start_matches(|c: char| c != ' ').trim_start(),
        None => inner,
    };
    let (kind, rest) = plain.split_once(' ')?;
    let associated = kind == "type" && line != inner && plain == inner;
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (["struct", "enum", "trait", "type"].contains(&kind) && !associated && !name.is_empty()).then_some(name)
}

#[test]
fn a_type_has_a_name_of_its_own() {
    let mut files = Vec::new();
    for entry in fs::read_dir(crate::tools::root().join("crates")).unwrap() {
        sources(&entry.unwrap().path().join("src"), &mut files);
    }
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        for line in fs::read_to_string(&file).unwrap().lines() {
            if let Some(name) = declared(line).filter(|name| *name != OF_EVERY_CRATE) {
                places.entry(name.into()).or_default().push(file.display().to_string());
            }
        }
    }
    assert!(places.len() > 1000, "{}", places.len());
    places.retain(|_, files| files.len() > 1);
    assert!(places.is_empty(), "names of several types: {places:#?}");
}

#[test]
fn declarations_are_told_from_associated_types() {
    let names = [
        "pub(super) struct A {",
        "    type Output = f64;",
        "    pub type B = u8;",
        "enum C<'a> {",
        "let x = 1;",
    ];
    assert_eq!(names.map(declared), [Some("A"), None, Some("B"), Some("C"), None]);
}
