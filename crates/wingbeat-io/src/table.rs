//! Records as CSV: a `#` line with the units, a header, one row per instant.

use std::fs;
use std::path::Path;

use wingbeat::simulate::{Column, Record};

use crate::Error;

/// Writes `record` to `path`; numbers keep all their digits.
pub fn write_csv(path: &Path, record: &Record) -> Result<(), Error> {
    let format = |error: csv::Error| Error::format(path, error);
    let units: Vec<String> = record.columns().iter().map(unit).collect();
    let mut text = format!("# units: {}\n", units.join(", ")).into_bytes();
    let mut writer = csv::Writer::from_writer(&mut text);
    writer.write_record(record.columns().iter().map(|column| &column.name)).map_err(format)?;
    for row in 0..record.rows() {
        let cells = record.columns().iter().map(|column| column.values[row].to_string());
        writer.write_record(cells).map_err(format)?;
    }
    writer.flush().map_err(|source| Error::file(path, source))?;
    drop(writer);
    fs::write(path, text).map_err(|source| Error::file(path, source))
}

fn unit(column: &Column) -> String {
    let unit = if column.unit.is_empty() { "1" } else { &column.unit };
    if column.frame.is_empty() { unit.into() } else { format!("{unit} in {}", column.frame) }
}

/// Reads a record from `path`: a header of names, then rows of numbers; `#` starts a comment line.
pub fn read_csv(path: &Path) -> Result<Record, Error> {
    let format = |error: csv::Error| Error::format(path, error);
    let text = fs::read(path).map_err(|source| Error::file(path, source))?;
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_slice());
    let header = reader.headers().map_err(format)?;
    let mut columns: Vec<Column> = header.iter().map(|name| Column::new(name, "", "")).collect();
    for row in reader.records() {
        let row = row.map_err(format)?;
        for (column, cell) in columns.iter_mut().zip(&row) {
            let line = row.position().map_or(0, csv::Position::line);
            let number = cell.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| {
                Error::format(path, format!("line {line}, column {}: `{cell}` is not a number", column.name))
            })?;
            column.values.push(number);
        }
    }
    Record::new(columns, 0).map_err(|error| Error::format(path, error))
}
