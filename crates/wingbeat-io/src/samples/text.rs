//! Columns of text: commas, semicolons (with decimal commas) or tabs between them, a header above.

use std::io::{BufRead, BufReader, Read};

use wingbeat::simulate::Column;

use super::table::SampleTable;
use super::{ati, opened};
use crate::table::unended as unended_line;
use crate::{Error, MOST_COLUMNS, MOST_NUMBERS};

/// Bytes in which the header must stand.
const HEAD: u64 = 1 << 16;
/// Longest line that is read, bytes.
const LONGEST_LINE: u64 = 1 << 16;

/// What stands above the rows.
struct Head {
    /// Lines before the first row.
    lines: usize,
    /// Names of the columns.
    names: Vec<String>,
    /// Units by column, where a line `# units:` says them.
    units: Vec<String>,
    delimiter: u8,
    /// The lines before the header of ATI's layout.
    ati: Option<Vec<String>>,
}

/// One column as it fills.
#[derive(Default)]
pub struct TextColumn {
    /// Its numbers, in the unit of the file.
    pub values: Vec<f64>,
    /// False of a column that is not kept.
    pub wanted: bool,
    /// True when its first cell is no number.
    pub words: bool,
    /// True while no cell has a decimal point.
    pub whole: bool,
}

/// Reads a file of text.
pub fn read(mut table: SampleTable) -> Result<SampleTable, Error> {
    let failed = |source| Error::file(&table.path, source);
    let mut top = Vec::new();
    let (file, _) = opened(&table.path)?;
    file.take(HEAD).read_to_end(&mut top).map_err(failed)?;
    let head = head(&String::from_utf8_lossy(&top)).map_err(|what| table.bad(what))?;
    let mut lines = Lines::of(BufReader::with_capacity(1 << 16, opened(&table.path)?.0));
    for _ in 0..head.lines {
        lines.next().map_err(|what| table.bad(what))?;
    }
    let cells = rows(&table, &head, &mut lines)?;
    table.names = head.names.iter().zip(&cells).filter(|(_, c)| !c.words).map(|(n, _)| n.clone()).collect();
    match head.ati {
        Some(preamble) => {
            table.layout = "CSV of ATI's demo application";
            ati::fill(&mut table, &preamble, &head.names, cells)?;
        }
        None => {
            for ((name, unit), cells) in head.names.iter().zip(&head.units).zip(cells) {
                match cells.words {
                    true => table.skipped.push(name.clone()),
                    false if cells.wanted => {
                        table.columns.push(Column { values: cells.values, ..Column::new(name, unit, "") })
                    }
                    false => {}
                }
            }
        }
    }
    Ok(table)
}

/// Finds the header in the first part of a file.
fn head(top: &str) -> Result<Head, String> {
    let lines: Vec<&str> = top.trim_start_matches('\u{feff}').lines().take(64).collect();
    let (at, ati) = match lines.iter().position(|line| ati::is_header(line)) {
        Some(at) => (at, Some(lines[..at].iter().map(|line| (*line).to_owned()).collect())),
        None => {
            let header = |line: &&str| !line.trim().is_empty() && !line.starts_with('#');
            (lines.iter().position(header).ok_or("no header and no rows")?, None)
        }
    };
    let line = lines[at];
    let delimiter = *[b'\t', b';', b','].iter().find(|d| line.contains(char::from(**d))).unwrap_or(&b',');
    let cells = |line: &str, delimiter: u8| -> Vec<String> {
        line.split(char::from(delimiter))
            .map(|cell| cell.trim().trim_matches('"').trim().to_owned())
            .collect()
    };
    let mut names = cells(line, delimiter);
    let bare = names.iter().all(|name| number(name, delimiter).is_some());
    if bare {
        names = (0..names.len()).map(|k| format!("[{k}]")).collect();
    }
    if names.len() > MOST_COLUMNS {
        return Err(format!("{} columns; read are at most {MOST_COLUMNS}", names.len()));
    }
    let said = lines[..at].iter().find_map(|line| line.trim_start_matches('#').trim().strip_prefix("units:"));
    let mut units = said.map_or(Vec::new(), |units| cells(units, b','));
    units.resize(names.len(), String::new());
    // A unit may name its frame: `N in B`.
    let units = units.iter().map(|unit| unit.split(" in ").next().unwrap_or("").to_owned()).collect();
    Ok(Head { lines: at + usize::from(!bare), names, units, delimiter, ati })
}

/// The lines of a file, none longer than [`LONGEST_LINE`].
struct Lines<R> {
    reader: R,
    bytes: Vec<u8>,
    /// Number of the line in `bytes`, from 1.
    number: usize,
    /// False of a line that the end of the file ends.
    ended: bool,
}

impl<R: BufRead> Lines<R> {
    fn of(reader: R) -> Self {
        Self { reader, bytes: Vec::new(), number: 0, ended: true }
    }

    /// Takes the next line in; false where there is none.
    fn next(&mut self) -> Result<bool, String> {
        self.bytes.clear();
        let mut part = (&mut self.reader).take(LONGEST_LINE);
        let size = part.read_until(b'\n', &mut self.bytes).map_err(|error| error.to_string())?;
        self.number += usize::from(size > 0);
        self.ended = self.bytes.last() == Some(&b'\n');
        if !self.ended && size as u64 == LONGEST_LINE {
            return Err(format!("line {} is longer than {LONGEST_LINE} bytes", self.number));
        }
        Ok(size > 0)
    }
}

/// Reads the rows below the header.
fn rows(table: &SampleTable, head: &Head, lines: &mut Lines<impl BufRead>) -> Result<Vec<TextColumn>, Error> {
    let names = head.names.iter();
    let mut columns: Vec<TextColumn> = names
        .map(|name| TextColumn { whole: true, wanted: wanted(table, head, name), ..TextColumn::default() })
        .collect();
    let kept = columns.iter().filter(|column| column.wanted).count();
    let mut samples = 0;
    while lines.next().map_err(|what| table.bad(what))? {
        let (text, line) = (String::from_utf8_lossy(&lines.bytes), lines.number);
        let text = text.trim_end_matches(['\n', '\r']);
        if text.trim().is_empty() || text.starts_with('#') {
            continue;
        }
        let row = row(text, head, &mut columns, samples == 0);
        row.map_err(|what| match (what, lines.ended) {
            (RowFault::Number(column, cell), true) => {
                let name = &head.names[column];
                table.bad(format!("line {line}, column {name}: `{cell}` is not a number"))
            }
            (RowFault::Count(found), true) if !at_end(lines) => {
                table.bad(format!("line {line}: {found} columns; the header has {}", head.names.len()))
            }
            (RowFault::Count(found), _) => cut(table, samples, line, found, head.names.len()),
            (RowFault::Number(..), false) => unended(table, samples, line),
        })?;
        if !lines.ended {
            return Err(unended(table, samples, line));
        }
        samples += 1;
        if samples * kept > MOST_NUMBERS {
            return Err(table.bad(format!("more than {MOST_NUMBERS} numbers of use")));
        }
    }
    Ok(columns)
}

fn at_end(lines: &mut Lines<impl BufRead>) -> bool {
    lines.reader.fill_buf().is_ok_and(<[u8]>::is_empty)
}

fn cut(table: &SampleTable, samples: usize, line: usize, found: usize, wanted: usize) -> Error {
    table.bad(format!(
        "cut short at sample {samples}: line {line}, the last, has {found} of {wanted} columns; delete it to use what \
         stands before"
    ))
}

fn unended(table: &SampleTable, samples: usize, line: usize) -> Error {
    table.bad(format!("cut short at sample {samples}? {}", unended_line(line)))
}

fn wanted(table: &SampleTable, head: &Head, name: &str) -> bool {
    let plain = if head.ati.is_some() { ati::plain(name) } else { name.to_owned() };
    table.wanted.wants(&plain)
}

/// What is wrong with a row.
enum RowFault {
    /// So many columns.
    Count(usize),
    /// This column holds this text.
    Number(usize, String),
}

/// Takes the cells of a row in.
fn row(text: &str, head: &Head, columns: &mut [TextColumn], first: bool) -> Result<(), RowFault> {
    let mut found = 0;
    for cell in (Split { rest: Some(text), delimiter: head.delimiter }) {
        if let Some(column) = columns.get_mut(found) {
            column.take(cell, head.delimiter, first).map_err(|()| RowFault::Number(found, cell.into()))?;
        }
        found += 1;
    }
    // The date of ATI's layout may hold a comma of its own.
    let most = columns.len() + usize::from(head.ati.is_some());
    if (columns.len()..=most).contains(&found) { Ok(()) } else { Err(RowFault::Count(found)) }
}

/// The cells of a line; a delimiter between quotes parts none.
struct Split<'a> {
    rest: Option<&'a str>,
    delimiter: u8,
}

impl<'a> Iterator for Split<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?;
        let mut quoted = false;
        let end = rest.bytes().position(|byte| {
            quoted ^= byte == b'"';
            byte == self.delimiter && !quoted
        });
        self.rest = end.map(|end| &rest[end + 1..]);
        Some(rest[..end.unwrap_or(rest.len())].trim())
    }
}

impl TextColumn {
    fn take(&mut self, cell: &str, delimiter: u8, first: bool) -> Result<(), ()> {
        if self.words || !(self.wanted || first) {
            return Ok(());
        }
        match number(cell, delimiter) {
            Some(value) if self.wanted => {
                self.whole &= !cell.contains(['.', 'e', 'E']);
                self.values.push(value);
            }
            Some(_) => {}
            None if first => self.words = true,
            None => return Err(()),
        }
        Ok(())
    }
}

/// The number in a cell; an empty cell and `nan` are not-a-number, `0x` begins a hexadecimal one.
fn number(cell: &str, delimiter: u8) -> Option<f64> {
    let cell = cell.trim().trim_matches('"').trim();
    if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
        return Some(f64::NAN);
    }
    if let Some(hex) = cell.strip_prefix("0x").or_else(|| cell.strip_prefix("0X")) {
        return u32::from_str_radix(hex, 16).ok().map(f64::from);
    }
    let value: Option<f64> =
        if delimiter == b';' { cell.replace(',', ".").parse().ok() } else { cell.parse().ok() };
    value.filter(|value| value.is_finite())
}
