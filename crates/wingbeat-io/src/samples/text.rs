//! Columns of text: commas, semicolons (with decimal commas) or tabs between them, a header above.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use csv::StringRecord;
use wingbeat::simulate::Column;

use super::{MOST_NUMBERS, Table, ati};
use crate::Error;

/// Bytes in which the header must stand.
const HEAD: u64 = 1 << 16;
/// Most columns.
const MOST_COLUMNS: usize = 1024;

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
pub struct Cells {
    /// Its numbers.
    pub values: Vec<f64>,
    /// True when its first cell is no number.
    pub words: bool,
    /// True while no cell has a decimal point.
    pub whole: bool,
}

/// Reads a file of text.
pub fn read(path: &Path) -> Result<Table, Error> {
    let file = || File::open(path).map_err(|source| Error::file(path, source));
    let mut top = Vec::new();
    file()?.take(HEAD).read_to_end(&mut top).map_err(|source| Error::file(path, source))?;
    let head = head(&String::from_utf8_lossy(&top)).map_err(|what| Error::format(path, what))?;
    let mut reader = BufReader::new(file()?);
    for _ in 0..head.lines {
        reader.skip_until(b'\n').map_err(|source| Error::file(path, source))?;
    }
    let layout = if head.ati.is_some() { "CSV of ATI's demo application" } else { "text" };
    let mut table = Table::new(path, layout);
    let cells = rows(&table, &head, reader)?;
    match head.ati {
        Some(preamble) => ati::fill(&mut table, &preamble, &head.names, cells)?,
        None => {
            for ((name, unit), cells) in head.names.iter().zip(&head.units).zip(cells) {
                match cells.words {
                    true => table.skipped.push(name.clone()),
                    false => {
                        table.columns.push(Column { values: cells.values, ..Column::new(name, unit, "") })
                    }
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

/// Reads the rows below the header.
fn rows(table: &Table, head: &Head, reader: impl Read) -> Result<Vec<Cells>, Error> {
    let wanted = head.names.len();
    let mut columns: Vec<Cells> =
        head.names.iter().map(|_| Cells { whole: true, ..Cells::default() }).collect();
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(head.delimiter)
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(reader);
    let mut row = StringRecord::new();
    let mut samples = 0;
    while reader.read_record(&mut row).map_err(|error| table.bad(error))? {
        let line = row.position().map_or(0, csv::Position::line) as usize + head.lines;
        // The date of ATI's layout may hold a comma of its own.
        let too_many = row.len() > wanted + usize::from(head.ati.is_some());
        if row.len() < wanted || too_many {
            let found = row.len();
            return Err(table.bad(match reader.read_record(&mut row) {
                Ok(true) => format!("line {line}: {found} columns; the header has {wanted}"),
                _ => format!(
                    "cut short at sample {samples}: line {line}, the last, has {found} of {wanted} columns; \
                     delete it to use what stands before"
                ),
            }));
        }
        if (samples + 1) * wanted > MOST_NUMBERS {
            return Err(table.bad(format!("more than {MOST_NUMBERS} numbers")));
        }
        for ((column, cell), name) in columns.iter_mut().zip(&row).zip(&head.names) {
            column
                .take(cell, head.delimiter, samples == 0)
                .map_err(|()| table.bad(format!("line {line}, column {name}: `{cell}` is not a number")))?;
        }
        samples += 1;
    }
    Ok(columns)
}

impl Cells {
    fn take(&mut self, cell: &str, delimiter: u8, first: bool) -> Result<(), ()> {
        if self.words {
            return Ok(());
        }
        match number(cell, delimiter) {
            Some(value) => {
                self.whole &= !cell.contains(['.', 'e', 'E']);
                self.values.push(value);
            }
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
