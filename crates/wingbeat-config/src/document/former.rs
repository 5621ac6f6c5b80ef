//! Former names of keys: what the refusal of one says, and the text of a document with the names of today.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};
use wingbeat_robot::former;

/// Angles that were renamed and whose sign was turned: the name of then, that of today, and what a comment said of the sign and says.
const TURNED: [(&str, &str); 1] = [("pitch_deg", "nose_up_deg")];
const SIGNS: (&str, &str) = ("negative is nose up", "positive is nose up");

/// A change of a text: what takes the place of a range of bytes.
type Edit = (Range<usize>, String);

/// A document with the names of today.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Migrated {
    /// Its text; comments and order are kept.
    pub text: String,
    /// What was changed: number of the line from 1, the line of then, that of today.
    pub lines: Vec<(usize, String, String)>,
}

/// How a key of then with its value is written today; none where the key is none of then, or `allowed` has it not.
pub(super) fn today(key: &str, value: Option<&str>, allowed: &[String]) -> Option<String> {
    let (_, new) =
        TURNED.iter().find(|(old, new)| key == *old && allowed.iter().any(|known| known == new))?;
    let value = value.and_then(negative).map_or(String::new(), |value| format!(" = {value}"));
    Some(format!("write {new}{value}, {}; `wingbeat migrate FILE` rewrites a file", SIGNS.1))
}

/// The text of a document with the names of today in place of those of then.
///
/// # Errors
/// A text that is not TOML: why, and the number of its line.
pub fn migrated(text: &str) -> Result<Migrated, (usize, String)> {
    let line_of = |at: usize| 1 + text.as_bytes()[..at].iter().filter(|byte| **byte == b'\n').count();
    let table = DeTable::parse(text)
        .map_err(|error| (line_of(error.span().map_or(0, |span| span.start)), error.message().to_owned()))?;
    let mut edits = Vec::new();
    in_table(text, table.get_ref(), &mut edits);
    signs(text, &mut edits);
    edits.sort_by_key(|(span, _)| (span.start, span.end));
    edits.dedup();
    let mut new = text.to_owned();
    for (span, words) in edits.iter().rev() {
        new.replace_range(span.clone(), words);
    }
    let lines = text.lines().zip(new.lines()).enumerate().filter(|(_, (then, now))| then != now);
    let lines = lines.map(|(k, (then, now))| (k + 1, then.trim().into(), now.trim().into())).collect();
    Ok(Migrated { text: new, lines })
}

fn in_table(text: &str, table: &DeTable, edits: &mut Vec<Edit>) {
    for (key, value) in table {
        let name = key.get_ref();
        if let Some((old, new)) = TURNED.iter().find(|(old, _)| name == old) {
            renamed(text, &key.span(), old, new, edits);
            turned(text, value, edits);
        } else if let Some(new) = former(name).filter(|_| name.contains('.')) {
            renamed(text, &key.span(), name, &new, edits);
        }
        in_value(text, value, edits);
    }
    // A draw names a key by a text, and its range turns round with the sign.
    let of = |key: &str| table.get(key).filter(|value| !value.get_ref().is_table());
    let Some((named, said)) = of("key").and_then(|named| Some((named, named.get_ref().as_str()?))) else {
        return;
    };
    let last = said.rsplit('.').next().unwrap_or_default();
    let draw = TURNED.iter().find(|(old, _)| last == *old);
    if let Some((old, new)) = draw {
        renamed(text, &named.span(), old, new, edits);
        let written =
            |key: &str| of(key).and_then(|value| Some((value.span(), negative(&text[value.span()])?)));
        if let (Some((low, from)), Some((high, to))) = (written("low"), written("high")) {
            edits.extend([(low, to), (high, from)]);
        }
        edits.extend(written("start"));
        if let Some(DeValue::Array(items)) = of("values").map(Spanned::get_ref) {
            edits.extend(items.iter().filter_map(|item| Some((item.span(), negative(&text[item.span()])?))));
        }
    }
    if let Some(DeValue::Array(items)) = of("also").map(Spanned::get_ref) {
        items.iter().for_each(|item| also(text, item, draw.is_some(), edits));
    }
}

/// Another key of a draw: its sign, which is against that of the draw's key, turns where one of the two is turned.
fn also(text: &str, item: &Spanned<DeValue>, turned: bool, edits: &mut Vec<Edit>) {
    let Some(said) = item.get_ref().as_str() else { return };
    let last = said.rsplit(['.', '-']).next().unwrap_or_default();
    let of_then = TURNED.iter().find(|(old, _)| last == *old);
    if turned != of_then.is_some() {
        // Behind the quote.
        let start = item.span().start + 1;
        edits.push(if said.starts_with('-') {
            (start..start + 1, String::new())
        } else {
            (start..start, "-".into())
        });
    }
    if let Some((old, new)) = of_then {
        renamed(text, &item.span(), old, new, edits);
    }
}

fn in_value(text: &str, value: &Spanned<DeValue>, edits: &mut Vec<Edit>) {
    match value.get_ref() {
        DeValue::Table(table) => in_table(text, table, edits),
        DeValue::Array(items) => items.iter().for_each(|item| in_value(text, item, edits)),
        DeValue::String(said) if said.contains('=') => in_override(text, &value.span(), said, edits),
        DeValue::String(said) if !said.contains(char::is_whitespace) => {
            if let Some(new) = former(said) {
                renamed(text, &value.span(), said, &new, edits);
            }
        }
        _ => {}
    }
}

/// Of a text `key=value` at `span`, as lists of overrides hold it, the key and the value; one with escapes stays as it is.
fn in_override(text: &str, span: &Range<usize>, said: &str, edits: &mut Vec<Edit>) {
    let Some(start) = text[span.clone()].find(said).map(|at| span.start + at) else { return };
    let Some((key, given)) = said.split_once('=') else { return };
    let named = start..start + key.len();
    let key = key.trim();
    let old = TURNED.iter().find(|(old, _)| key.rsplit('.').next() == Some(old));
    if let Some((old, new)) = old {
        renamed(text, &named, old, new, edits);
    } else if let Some(new) = former(key) {
        renamed(text, &named, key, &new, edits);
    }
    // The value alone is TOML, for a key may have indices; its places are those of the text.
    let alone = format!("{}={given}", "k".repeat(named.len()));
    let Ok(table) = DeTable::parse(&alone) else { return };
    let mut inner = Vec::new();
    for value in table.get_ref().values() {
        if old.is_some() {
            turned(&alone, value, &mut inner);
        }
        in_value(&alone, value, &mut inner);
    }
    edits.extend(inner.into_iter().map(|(at, words)| (start + at.start..start + at.end, words)));
}

/// Renames what stands at `span`, between quotes or not.
fn renamed(text: &str, span: &Range<usize>, old: &str, new: &str, edits: &mut Vec<Edit>) {
    if let Some(at) = text[span.clone()].rfind(old) {
        let start = span.start + at;
        edits.push((start..start + old.len(), new.to_owned()));
    }
}

/// Turns the sign of a number; of a range also its ends.
fn turned(text: &str, value: &Spanned<DeValue>, edits: &mut Vec<Edit>) {
    match value.get_ref() {
        DeValue::Array(ends) => {
            let places = ends.iter().map(Spanned::span);
            let turned = ends.iter().rev().filter_map(|end| negative(&text[end.span()]));
            edits.extend(places.zip(turned));
        }
        _ => edits.extend(negative(&text[value.span()]).map(|words| (value.span(), words))),
    }
}

/// Minus a number as it is written; none of what is no number.
fn negative(number: &str) -> Option<String> {
    let plain = number.replace('_', "");
    let based = [("0x", 16), ("0o", 8), ("0b", 2)]
        .into_iter()
        .find_map(|(sign, base)| i64::from_str_radix(plain.strip_prefix(sign)?, base).ok());
    if let Some(value) = based {
        // These have no sign.
        return Some((-value).to_string());
    }
    let value: f64 = plain.parse().ok()?;
    let size = number.trim_start_matches(['-', '+']);
    let minus = value > 0.0;
    Some(format!("{}{size}", if minus { "-" } else { "" }))
}

/// What the comments of the lines that change say of the sign.
fn signs(text: &str, edits: &mut Vec<Edit>) {
    let comments: Vec<Edit> = edits
        .iter()
        .filter_map(|(span, _)| {
            let end = text[span.end..].find('\n').map_or(text.len(), |at| span.end + at);
            let at = span.end + text[span.end..end].find(SIGNS.0)?;
            Some((at..at + SIGNS.0.len(), SIGNS.1.to_owned()))
        })
        .collect();
    edits.extend(comments);
}
