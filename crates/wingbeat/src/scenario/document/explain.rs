//! From what serde, the TOML reader and the builders say to one message with its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

use super::source::Sources;
use super::{ConfigError, Problem, tree};
use crate::Error;

type Tree<'i> = Spanned<DeValue<'i>>;

/// What deserialising says, with its place.
pub fn schema(sources: &Sources, root: &Tree, error: &toml::de::Error) -> ConfigError {
    let message = error.message();
    let span = error.span().unwrap_or_else(|| root.span());
    let found = located(root, &span);
    let names = || quoted(message.split_once("expected").map_or("", |(_, expected)| expected));
    if let Some(name) = after(message, "missing field ") {
        return missing(sources, &found.0, &found.1, &name);
    }
    if let Some(name) = after(message, "unknown field ") {
        let (key, span) = unknown(root, found, &name);
        let value = Some(sources.text(&span)).filter(|text| !text.starts_with('['));
        let place = sources.place(span.start);
        return ConfigError { place, key, value, problem: Problem::UnknownKey { allowed: names() } };
    }
    let problem = if message.starts_with("unknown variant") {
        Problem::UnknownName { allowed: names() }
    } else if let Some((_, expected)) = message.split_once(", expected ") {
        Problem::Value(in_words(expected))
    } else {
        Problem::Value(message.into())
    };
    let place = sources.place(found.1.start);
    ConfigError { place, key: found.0, value: Some(sources.text(&found.1)), problem }
}

/// What a builder says of a value, with the place where it was given.
pub fn value(sources: &Sources, root: &Tree, error: &Error) -> ConfigError {
    let Error::Invalid { key, value, allowed } = error;
    let steps = tree::steps(key);
    let mut node = tree::Node { key: None, value: root };
    let mut depth = 0;
    while let Some(child) = steps.get(depth).and_then(|step| tree::child(node.value.get_ref(), step)) {
        node = child;
        depth += 1;
    }
    let span = node.value.span();
    let written = sources.text(&span);
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok();
    let same =
        number(&written).is_some_and(|a| number(value).is_some_and(|b| (a - b).abs() <= 1e-9 * a.abs()));
    let value = if depth == steps.len() && same { written } else { value.clone() };
    ConfigError {
        place: sources.place(span.start),
        key: key.clone(),
        value: Some(value),
        problem: Problem::Value(allowed.clone()),
    }
}

/// The key whose name or value has exactly this span: its path, and the span of its value.
fn located(root: &Tree, span: &Range<usize>) -> (String, Range<usize>) {
    let of_value = tree::find(root, &|node| node.value.span() == *span);
    let of_key = || tree::find(root, &|node| node.key.as_ref() == Some(span));
    of_value.or_else(of_key).unwrap_or((String::new(), span.clone()))
}

fn missing(sources: &Sources, table: &str, span: &Range<usize>, name: &str) -> ConfigError {
    ConfigError {
        place: sources.place(span.start),
        key: dotted(table, name),
        value: None,
        problem: Problem::MissingKey,
    }
}

/// The unknown key's path and the span of its value, also where only its table is known.
fn unknown(root: &Tree, found: (String, Range<usize>), name: &str) -> (String, Range<usize>) {
    if found.0.rsplit('.').next() == Some(name) {
        return found;
    }
    let key = dotted(&found.0, name);
    let span = lookup(root, &key).unwrap_or(found.1);
    (key, span)
}

fn lookup(root: &Tree, path: &str) -> Option<Range<usize>> {
    let mut value = root;
    for step in tree::steps(path) {
        value = tree::child(value.get_ref(), &step)?.value;
    }
    Some(value.span())
}

fn dotted(table: &str, name: &str) -> String {
    if table.is_empty() { name.into() } else { format!("{table}.{name}") }
}

/// The name in backticks after `start`, where `message` begins with it.
fn after(message: &str, start: &str) -> Option<String> {
    quoted(message.strip_prefix(start)?).into_iter().next()
}

/// The names in backticks.
fn quoted(text: &str) -> Vec<String> {
    text.split('`').skip(1).step_by(2).map(String::from).collect()
}

/// serde's names of types, in words.
fn in_words(expected: &str) -> String {
    let whole = ["u8", "u16", "u32", "u64", "usize"];
    match expected {
        "f64" | "f32" => "a number".into(),
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number".into(),
        name if whole.contains(&name) => "a whole number, not negative".into(),
        "a boolean" => "true or false".into(),
        "a string" => "text in quotes".into(),
        "a sequence" => "a list".into(),
        name if name.starts_with("struct ") => "a table".into(),
        other => other.replace("an array of length", "a list of length"),
    }
}
