//! Cases that are data: the lists of `crates/xtask/hostile/*.toml`.
//!
//! A list has a class, commands by name and cases. A case has a name, texts that lie there before, and steps
//! ([`CaseStep`]). With `rows`, it stands for one case of each row: `{0}` is the first cell of the row. With `times`, each
//! row is followed by the cells of each of these. A word that is `{0}` or `@command` and no more is replaced by the
//! whole cell or command, which may be several words.

use serde::Deserialize;
use toml::{Table, Value};

use super::case::ScriptedCase;
use super::step::{CaseStep, StepRemains};

/// The lists.
const LISTS: [(&str, &str); 9] = [
    ("boxes", include_str!("../../hostile/boxes.toml")),
    ("documents", include_str!("../../hostile/documents.toml")),
    ("files", include_str!("../../hostile/files.toml")),
    ("odd", include_str!("../../hostile/odd.toml")),
    ("pictures", include_str!("../../hostile/pictures.toml")),
    ("places", include_str!("../../hostile/places.toml")),
    ("ranges", include_str!("../../hostile/ranges.toml")),
    ("snapshots", include_str!("../../hostile/snapshots.toml")),
    ("status", include_str!("../../hostile/status.toml")),
];

/// A short flight without a controller.
pub const GLIDE: &str = include_str!("../../hostile/texts/glide.toml");
/// Three flights of it.
pub const SWEEP: &str = include_str!("../../hostile/texts/sweep.toml");
/// A hold of less than three cycles on the rig.
pub const HOLD: &str = include_str!("../../hostile/texts/hold.toml");

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    class: u8,
    #[serde(default)]
    commands: Table,
    cases: Vec<Rows>,
}

#[derive(Deserialize)]
struct Rows {
    #[serde(default)]
    rows: Vec<Vec<Value>>,
    #[serde(default)]
    times: Vec<Vec<Value>>,
    #[serde(flatten)]
    case: Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    class: Option<u8>,
    /// Whether the short flight, its sweep and the hold lie there.
    #[serde(default)]
    texts: bool,
    #[serde(default)]
    long: bool,
    #[serde(default)]
    alone: bool,
    steps: Vec<CaseStep>,
}

/// The cases of all lists.
///
/// # Panics
/// A list that is not in order, by its name: it is compiled in.
pub fn cases() -> Vec<ScriptedCase> {
    let of = |(name, text): &(&str, &str)| {
        read(text).unwrap_or_else(|error| panic!("hostile/{name}.toml: {error}"))
    };
    LISTS.iter().flat_map(of).collect()
}

fn read(text: &str) -> Result<Vec<ScriptedCase>, String> {
    let List { class, commands, cases } = toml::from_str(text).map_err(|error| error.to_string())?;
    let mut all = Vec::new();
    for Rows { rows, times, case } in cases {
        for cells in product(rows, times) {
            let table = expanded(&Value::Table(case.clone()), &cells, &commands);
            let entry: Entry =
                table.try_into().map_err(|error| format!("{:?}: {error}", case.get("name")))?;
            all.push(entry.case(class));
        }
    }
    Ok(all)
}

/// Each row with each that follows it; no cells where there are no rows.
fn product(rows: Vec<Vec<Value>>, times: Vec<Vec<Value>>) -> Vec<Vec<Value>> {
    let or_one = |rows: Vec<Vec<Value>>| if rows.is_empty() { vec![Vec::new()] } else { rows };
    let times = or_one(times);
    let with = |row: Vec<Value>| times.iter().map(move |more| [&row[..], more].concat()).collect::<Vec<_>>();
    or_one(rows).into_iter().flat_map(with).collect()
}

/// `value` with cells and commands in the place of their names.
fn expanded(value: &Value, cells: &[Value], commands: &Table) -> Value {
    match value {
        Value::String(text) => match whole(text, cells, commands) {
            Some(cell) => expanded(cell, &[], commands),
            None => filled(text, cells).into(),
        },
        Value::Array(items) => {
            Value::Array(items.iter().flat_map(|item| spliced(item, cells, commands)).collect())
        }
        Value::Table(table) => {
            let entry =
                |(key, value): (&String, &Value)| (filled(key, cells), expanded(value, cells, commands));
            Value::Table(table.iter().map(entry).collect())
        }
        other => other.clone(),
    }
}

/// An item of a list, or the items of the list that it names.
fn spliced(item: &Value, cells: &[Value], commands: &Table) -> Vec<Value> {
    let named = item.as_str().and_then(|text| whole(text, cells, commands)).is_some();
    match expanded(item, cells, commands) {
        Value::Array(items) if named => items,
        one => vec![one],
    }
}

/// The cell or command that `text` names and nothing else.
fn whole<'a>(text: &str, cells: &'a [Value], commands: &'a Table) -> Option<&'a Value> {
    let index = text.strip_prefix('{').and_then(|text| text.strip_suffix('}'));
    let cell = index.and_then(|index| cells.get(index.parse::<usize>().ok()?));
    cell.or_else(|| commands.get(filled(text, cells).strip_prefix('@')?))
}

fn filled(text: &str, cells: &[Value]) -> String {
    let cell = |text: String, (i, cell): (usize, &Value)| match cell.as_str() {
        Some(word) => text.replace(&format!("{{{i}}}"), word),
        None => text,
    };
    cells.iter().enumerate().fold(text.to_owned(), cell)
}

impl Entry {
    fn case(self, class: u8) -> ScriptedCase {
        let Self { name, class: own, texts, long, alone, steps } = self;
        let case = ScriptedCase::new(own.unwrap_or(class), name, move |place| {
            if texts {
                place.write_texts()?;
            }
            let mut kept = StepRemains::default();
            steps.iter().try_for_each(|step| step.play(place, &mut kept))
        });
        ScriptedCase { quick: !long, alone, ..case }
    }
}
