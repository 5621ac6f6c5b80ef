//! The page of the comparisons: text with its numbers taken from the rows.

use crate::{ComparisonRow, report};

/// The text; between double braces stand `rows ID ...` for a table, `percent ID` for a value, and `k` for the reduced
/// frequency of the flapping wings.
const TEXT: &str = include_str!("page.md");

/// A piece of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PagePiece {
    /// Words as they are.
    Words(&'static str),
    /// What stands between double braces, in whose place numbers come.
    Place(&'static str),
}

/// The text in its pieces.
pub fn pieces() -> impl Iterator<Item = PagePiece> {
    TEXT.split("{{").enumerate().flat_map(|(i, part)| match part.split_once("}}") {
        Some((place, words)) if i > 0 => vec![PagePiece::Place(place), PagePiece::Words(words)],
        _ => vec![PagePiece::Words(part)],
    })
}

/// The page as Markdown, its figures in the folder `figures`; none when `rows` lack one that it names.
pub fn page(rows: &[ComparisonRow]) -> Option<String> {
    let mut page = String::new();
    for piece in pieces() {
        match piece {
            PagePiece::Words(words) => page += words,
            PagePiece::Place(place) => page += &filled(place, rows)?,
        }
    }
    Some(page)
}

fn filled(place: &str, rows: &[ComparisonRow]) -> Option<String> {
    let (kind, names) = place.split_once(' ').unwrap_or((place, ""));
    match kind {
        "rows" => table(names.split(' '), rows),
        "percent" => {
            let row = rows.iter().find(|row| row.id == names)?;
            Some(format!("{} %", significant(100.0 * row.value, 2)))
        }
        "k" => Some(significant(crate::aero_full::reduced_frequency(), 2)),
        _ => None,
    }
}

/// The rows that are called one of `names`, or stand below one.
fn table<'a>(names: impl Iterator<Item = &'a str>, rows: &[ComparisonRow]) -> Option<String> {
    let mut text = String::from("| id | error | value | limit |\n|---|---|---:|---:|");
    for name in names {
        let mut found = rows.iter().filter(|row| crate::case::below(&row.id, name)).peekable();
        found.peek()?;
        for row in found {
            let limit = row.limit.map_or("-".into(), short);
            let failed = if row.passes() { "" } else { " **fails**" };
            let metric = report::metric(row).replace('|', "\\|");
            text += &format!("\n| `{}` | {metric} | {}{failed} | {limit} |", row.id, short(row.value));
        }
    }
    Some(text)
}

/// Three digits of a number, in the unit of its row, that the model determines, one of what is left by rounding or a solver's
/// tolerance.
pub fn short(value: f64) -> String {
    if value == 0.0 || value.abs() >= ROUNDING { significant(value, 3) } else { format!("{value:.0e}") }
}

/// Below this size a value is what rounding or the tolerance of a solver leave.
const ROUNDING: f64 = 1e-4;

/// `value` with `digits` significant digits and no exponent, in the unit of its row.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals = (digits - 1 - value.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
