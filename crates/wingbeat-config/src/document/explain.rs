//! From what is refused to one message with its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use super::error::Other;
use super::read::{Complaint, Fault};
use super::source::Sources;
use super::{ConfigError, Problem, Wrong, tree};
use wingbeat_math::Error;

type Tree<'i> = Spanned<DeValue<'i>>;

/// What is wrong with the form of a document, with the places.
pub fn form(sources: &Sources, root: &Tree, complaints: &[Complaint]) -> ConfigError {
    complaints.iter().map(|complaint| one(sources, root, complaint)).collect()
}

fn one(sources: &Sources, root: &Tree, complaint: &Complaint) -> Wrong {
    let path = complaint.path().unwrap_or_default();
    let (span, _) = deepest(root, path);
    let place = sources.place(span.start);
    let problem = match complaint.fault() {
        Fault::Missing(name) => {
            return Wrong::new(place, tree::dotted(path, name), None, Problem::MissingKey);
        }
        Fault::Unknown(name, allowed) => {
            let key = tree::dotted(path, name);
            let (span, _) = deepest(root, &key);
            let value = Some(sources.text(&span)).filter(|text| !text.starts_with('['));
            let problem = Problem::UnknownKey { allowed: allowed.clone() };
            return Wrong::new(sources.place(span.start), key, value, problem);
        }
        Fault::Name(allowed) => Problem::UnknownName { allowed: allowed.clone() },
        Fault::Value(allowed) => Problem::Value(allowed.clone()),
    };
    Wrong::new(place, path, Some(sources.text(&span)), problem)
}

/// What a builder says of a value, with the place where it was given.
pub fn value(sources: &Sources, root: &Tree, error: &Error) -> ConfigError {
    let Error::Invalid { key, value, allowed, against } = error;
    let (span, whole) = deepest(root, key);
    let written = sources.text(&span);
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok();
    let same =
        number(&written).is_some_and(|a| number(value).is_some_and(|b| (a - b).abs() <= 1e-9 * a.abs()));
    let value = if whole && same { written } else { value.clone() };
    let problem = Problem::Value(allowed.clone());
    let error = Wrong::new(sources.place(span.start), key, Some(value), problem);
    let others = against.iter().filter_map(|key| {
        let (span, whole) = deepest(root, key);
        let value = sources.text(&span);
        let new = whole && *key != error.key;
        new.then(|| Other { place: sources.place(span.start), key: key.clone(), value })
    });
    Wrong { against: others.collect(), ..error }.into()
}

/// The span of the value at `path`, and true; or of the innermost one on the way there, and false.
fn deepest(root: &Tree, path: &str) -> (Range<usize>, bool) {
    let mut value = root;
    for step in tree::steps(path) {
        match tree::child(value.get_ref(), &step) {
            Some(below) => value = below,
            None => return (value.span(), false),
        }
    }
    (value.span(), true)
}
