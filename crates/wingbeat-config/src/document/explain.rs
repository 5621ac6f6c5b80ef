//! From what is refused to one message with its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use super::error::Other;
use super::read::{Complaint, FormFault};
use super::source::Sources;
use super::{ConfigError, KeyProblem, ValuePlace, Wrong, tree};
use crate::DocumentKind;
use wingbeat_math::Error;

type ValueTree<'i> = Spanned<DeValue<'i>>;

/// What is wrong with the form of a document, with the places.
pub fn form(sources: &Sources, root: &ValueTree, complaints: &[Complaint]) -> ConfigError {
    if let Some(kind) = another(sources, root, complaints) {
        let what = format!("this is a {}, which is read by {}", kind.name(), kind.readers());
        let place = sources.place(root.span().start);
        return Wrong::new(place, "", None, KeyProblem::File(what)).into();
    }
    complaints.iter().map(|complaint| one(sources, root, complaint)).collect()
}

/// The kind that a document is of by its keys, where it is not of the kind that was asked for: keys of its own are unknown at its top,
/// others missing.
fn another(sources: &Sources, root: &ValueTree, complaints: &[Complaint]) -> Option<DocumentKind> {
    let unknown = |complaint: &Complaint| {
        complaint.path().is_none_or(str::is_empty) && matches!(complaint.fault(), FormFault::Unknown(..))
    };
    let unlike = complaints.iter().any(unknown)
        && complaints.iter().any(|complaint| matches!(complaint.fault(), FormFault::Missing(_)));
    let table = root.get_ref().as_table().filter(|_| unlike)?;
    let overrides = |start| matches!(sources.place(start), ValuePlace::Override(_));
    let mut written = table.keys().filter(|key| !overrides(key.span().start)).map(|key| &**key.get_ref());
    DocumentKind::with_keys(&|key| table.contains_key(key), &mut written)
}

fn one(sources: &Sources, root: &ValueTree, complaint: &Complaint) -> Wrong {
    let path = complaint.path().unwrap_or_default();
    let (span, _) = deepest(root, path);
    let place = sources.place(span.start);
    let problem = match complaint.fault() {
        FormFault::Missing(name) => {
            return Wrong::new(place, tree::dotted(path, name), None, KeyProblem::MissingKey);
        }
        FormFault::Unknown(name, allowed) => {
            let key = tree::dotted(path, name);
            let (span, _) = deepest(root, &key);
            // Of a table of dotted keys the span is that of a value inside.
            let value =
                Some(sources.text(&span)).filter(|text| !text.starts_with('[') && !is_table(root, &key));
            let problem = KeyProblem::UnknownKey { allowed: allowed.clone() };
            return Wrong::new(sources.place(span.start), key, value, problem);
        }
        FormFault::Name(allowed) => KeyProblem::UnknownName { allowed: allowed.clone() },
        FormFault::Value(allowed) => KeyProblem::Value(allowed.clone()),
    };
    Wrong::new(place, path, Some(sources.text(&span)), problem)
}

/// What a builder says of a value, with the place where it was given.
pub fn value(sources: &Sources, root: &ValueTree, error: &Error) -> ConfigError {
    let Error::Invalid { key, value, allowed, against } = error;
    let (span, whole) = deepest(root, key);
    let written = sources.text(&span);
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok();
    let same =
        number(&written).is_some_and(|a| number(value).is_some_and(|b| (a - b).abs() <= 1e-9 * a.abs()));
    let value = if whole && same { written } else { value.clone() };
    let problem = KeyProblem::Value(allowed.clone());
    // A name that a table may not have stands where it is written in there.
    let start = key_in(root, key, &value).unwrap_or(span.start);
    let error = Wrong::new(sources.place(start), key, Some(value), problem);
    let others = against.iter().filter_map(|key| {
        let (span, whole) = deepest(root, key);
        let value = sources.text(&span);
        let new = whole && *key != error.key;
        new.then(|| Other { place: sources.place(span.start), key: key.clone(), value })
    });
    Wrong { against: others.collect(), ..error }.into()
}

/// The span of the value at `path`, and true; or of the innermost one on the way there, and false.
fn deepest(root: &ValueTree, path: &str) -> (Range<usize>, bool) {
    let mut value = root;
    for step in tree::steps(path) {
        match tree::child(value.get_ref(), &step) {
            Some(below) => value = below,
            None => return (value.span(), false),
        }
    }
    (value.span(), true)
}

/// Where the key whose quoted name is `name` stands in the table at `path`.
fn key_in(root: &ValueTree, path: &str, name: &str) -> Option<usize> {
    let at = tree::steps(path)
        .into_iter()
        .try_fold(root.get_ref(), |value, step| tree::child(value, &step).map(Spanned::get_ref));
    let mut keys = at?.as_table()?.keys();
    keys.find(|key| format!("{:?}", key.get_ref()) == name).map(|key| key.span().start)
}

/// Whether there is a table at `path`.
fn is_table(root: &ValueTree, path: &str) -> bool {
    let at = tree::steps(path)
        .into_iter()
        .try_fold(root.get_ref(), |value, step| tree::child(value, &step).map(Spanned::get_ref));
    matches!(at, Some(DeValue::Table(_)))
}
