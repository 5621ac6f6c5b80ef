//! Records as CSV: a header, one row per instant.

use std::fs;
use std::io::Read;
use std::path::Path;

use wingbeat::simulate::{Column, Record};

use crate::{Error, MOST_COLUMNS, regular};

/// Writes `record` to `path`, names in the first line, numbers as [`shortest`].
pub fn write_csv(path: &Path, record: &Record) -> Result<(), Error> {
    let text = csv_bytes(record).map_err(|error| Error::format(path, error))?;
    fs::write(path, text).map_err(|source| Error::file(path, source))
}

/// What [`write_csv`] writes.
///
/// # Errors
/// A record that is no table.
pub fn csv_bytes(record: &Record) -> Result<Vec<u8>, String> {
    let format = |error: csv::Error| error.to_string();
    let mut text = Vec::new();
    let mut writer = csv::Writer::from_writer(&mut text);
    writer.write_record(record.columns().iter().map(|column| &column.name)).map_err(format)?;
    for row in 0..record.rows() {
        let cells = record.columns().iter().map(|column| shortest(column.values[row]));
        writer.write_record(cells).map_err(format)?;
    }
    writer.flush().map_err(|error| error.to_string())?;
    drop(writer);
    Ok(text)
}

/// Whole numbers below it are exact: 2^53.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// A number, in the caller's unit, in the fewest letters that read back as the same number; a whole one below 2^53 in full, as other
/// programs take one with a power for a number that is not whole.
pub fn shortest(value: f64) -> String {
    let plain = value.to_string();
    if value.fract() == 0.0 && value.abs() < WHOLE {
        return plain;
    }
    let power = format!("{value:e}");
    if power.len() < plain.len() { power } else { plain }
}

/// Largest file that is read, bytes.
const LARGEST: u64 = 64 << 20;
/// Most numbers that are read.
const MOST: usize = 1 << 24;

/// A column as it fills.
struct FillingColumn {
    column: Column,
    /// Line and text of the first cell that is no finite number.
    word: Option<(u64, String)>,
}

impl FillingColumn {
    fn take(&mut self, cell: &str, line: u64) {
        match cell.parse().ok().filter(|number: &f64| number.is_finite()) {
            Some(number) => self.column.values.push(number),
            None if self.word.is_none() => self.word = Some((line, cell.chars().take(40).collect())),
            None => {}
        }
    }

    /// Whether no cell is a number and the first is a word: a column of remarks. What programs write for a number that is
    /// missing or wrong (`#DIV/0!`, `n/a`, `--`) is none.
    fn is_words(&self) -> bool {
        const MISSING: [&str; 7] = ["na", "n/a", "null", "none", "error", "err", "missing"];
        let word = |cell: &str| {
            let letters = cell.chars().filter(|c| c.is_alphabetic()).count();
            let missing = MISSING.contains(&cell.to_lowercase().as_str());
            letters > 1 && !cell.starts_with('#') && !missing && cell.parse::<f64>().is_err()
        };
        self.column.values.is_empty() && self.word.as_ref().is_some_and(|(_, cell)| word(cell))
    }
}

/// Reads a record from `path`: a header of names, then rows of numbers, with commas, semicolons or tabs between them; `#` starts a comment line. Columns in which no cell is a
/// number are left out, as long as one is left. The last line ends with a line break: without it, its last number may be cut.
pub fn read_csv(path: &Path) -> Result<Record, Error> {
    let format = |error: csv::Error| Error::format(path, error);
    let bytes = bytes(path)?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .delimiter(delimiter(&bytes))
        .from_reader(bytes.as_slice());
    let header = reader.headers().map_err(format)?;
    if header.len() > MOST_COLUMNS {
        let count = header.len();
        return Err(Error::format(path, format!("{count} columns; read are at most {MOST_COLUMNS}")));
    }
    let empty = |name| FillingColumn { column: Column::new(name, "", ""), word: None };
    let mut columns: Vec<FillingColumn> = header.iter().map(empty).collect();
    for (rows, row) in reader.records().enumerate() {
        let row = row.map_err(format)?;
        if (rows + 1) * columns.len() > MOST {
            return Err(Error::format(path, format!("more than {MOST} numbers")));
        }
        let line = row.position().map_or(0, csv::Position::line);
        columns.iter_mut().zip(&row).for_each(|(column, cell)| column.take(cell, line));
    }
    let words = !columns.iter().all(FillingColumn::is_words);
    columns.retain(|column| !(words && column.is_words()));
    if let Some((line, name, cell)) = first_word(&columns) {
        return Err(Error::format(path, format!("line {line}, column {name}: `{cell}` is not a number")));
    }
    let columns = columns.into_iter().map(|cells| cells.column).collect();
    Record::new(columns, 0).map_err(|error| Error::format(path, error))
}

/// The first cell among `columns` that is no number: its line, its column and its text.
fn first_word(columns: &[FillingColumn]) -> Option<(u64, &str, &str)> {
    let words = columns.iter().filter_map(|c| Some((&c.column.name, c.word.as_ref()?)));
    words.map(|(name, (line, cell))| (*line, name.as_str(), cell.as_str())).min_by_key(|(line, ..)| *line)
}

/// What stands between the names of the header: commas, or where it has none semicolons or tabs.
fn delimiter(bytes: &[u8]) -> u8 {
    let mut lines = bytes.split(|byte| *byte == b'\n').filter(|line| !line.starts_with(b"#"));
    let header = lines.next().unwrap_or_default();
    [b',', b';', b'\t'].into_iter().find(|mark| header.contains(mark)).unwrap_or(b',')
}

/// The bytes of a file of bounded size that ends with a line break.
fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    regular(path)?.take(LARGEST + 1).read_to_end(&mut bytes).map_err(|source| Error::file(path, source))?;
    if bytes.len() as u64 > LARGEST {
        return Err(Error::format(path, format!("more than {LARGEST} bytes, the most that is read")));
    }
    if bytes.last().is_some_and(|byte| *byte != b'\n') {
        let lines = 1 + bytes.iter().filter(|byte| **byte == b'\n').count();
        return Err(Error::format(path, unended(lines)));
    }
    Ok(bytes)
}

/// What is said of a last line without its end: digits of its last number may be missing.
pub fn unended(line: usize) -> String {
    format!(
        "line {line}, the last, has no line break behind it: the file may be cut short; add the line break if it is \
         whole, else delete the line"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_read_back_the_same() {
        assert_eq!(
            [0.0, -0.25, 100.0, 1e3, -4e6, 9_007_199_254_740_991.0, 1e16, 1e-7, 1.5e300].map(shortest),
            ["0", "-0.25", "100", "1000", "-4000000", "9007199254740991", "1e16", "1e-7", "1.5e300"]
        );
        for value in [0.1 + 0.2, f64::MIN_POSITIVE, f64::MAX, -1.0 / 3.0, 5e-324] {
            assert_eq!(shortest(value).parse::<f64>().unwrap().to_bits(), value.to_bits());
        }
    }
}
