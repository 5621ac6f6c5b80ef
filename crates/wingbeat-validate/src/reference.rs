//! Reading of the reference tables.

use crate::Error;

/// A reference table: `#` lines say the source, then a header (if any), then rows.
#[derive(Clone, Debug)]
pub struct ReferenceTable {
    file: String,
    source: Vec<String>,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// The text of `validation/<path>`, compiled into the program, as a [`ReferenceTable`].
#[macro_export]
macro_rules! reference_table {
    ($path:literal) => {
        $crate::ReferenceTable::parse(
            $path,
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/", $path)),
        )
    };
}

impl ReferenceTable {
    /// Reads `text`; `file` is its path below `validation/`.
    ///
    /// The first line that is not a comment is the header when one of its cells is not a number.
    pub fn parse(file: &str, text: &str) -> Result<Self, Error> {
        let source = text.lines().filter_map(|line| line.strip_prefix('#')).map(|line| line.trim().into());
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .has_headers(false)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| Error::reference(file, error.to_string()))?;
            rows.push(record.iter().map(String::from).collect::<Vec<_>>());
        }
        let named = rows.first().is_some_and(|row| row.iter().any(|cell| cell.parse::<f64>().is_err()));
        let header = if named { rows.remove(0) } else { Vec::new() };
        Ok(Self { file: file.into(), source: source.collect(), header, rows })
    }

    /// The `#` lines, without the `#`.
    pub fn source(&self) -> &[String] {
        &self.source
    }

    /// Number of rows below the header.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// True when there are no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The numbers of the column called `name`, in the unit of the file.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, Error> {
        self.column_at(self.index(name)?)
    }

    /// The numbers of column `index`, counted from 0, in the unit of the file.
    pub fn column_at(&self, index: usize) -> Result<Vec<f64>, Error> {
        (0..self.len()).map(|row| self.number(row, index)).collect()
    }

    /// The words of the column called `name`.
    pub fn words(&self, name: &str) -> Result<Vec<&str>, Error> {
        let index = self.index(name)?;
        (0..self.len()).map(|row| self.cell(row, index)).collect()
    }

    fn index(&self, name: &str) -> Result<usize, Error> {
        self.header.iter().position(|column| column == name).ok_or_else(|| {
            Error::reference(&self.file, format!("no column {name}; there are {}", self.header.join(", ")))
        })
    }

    fn cell(&self, row: usize, column: usize) -> Result<&str, Error> {
        self.rows
            .get(row)
            .and_then(|cells| cells.get(column))
            .map(String::as_str)
            .ok_or_else(|| Error::reference(&self.file, format!("no cell in row {row}, column {column}")))
    }

    fn number(&self, row: usize, column: usize) -> Result<f64, Error> {
        let cell = self.cell(row, column)?;
        cell.parse().map_err(|_| {
            Error::reference(&self.file, format!("row {row}, column {column}: `{cell}` is not a number"))
        })
    }
}
