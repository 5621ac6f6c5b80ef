//! The flights done so far, one line each, so that an interrupted sweep can go on.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use wingbeat::simulate::{Column, Record};
use wingbeat_io::shortest;

use crate::error::Error;

/// Rows by the number of their flight, on disk as soon as they are known.
#[derive(Debug)]
pub struct SweepLog {
    path: PathBuf,
    file: File,
    rows: BTreeMap<usize, Vec<f64>>,
}

impl SweepLog {
    /// Opens the log, whose rows are in the units of their columns; the first number of a row is its flight's. A last line cut
    /// short goes.
    ///
    /// # Errors
    /// A line that is no row for which `belongs` holds, a flight that is there twice.
    pub fn open(path: &Path, belongs: impl Fn(&[f64]) -> bool) -> Result<Self, Error> {
        let failed = |source| Error::file(path, source);
        let text = match fs::read_to_string(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            other => other.map_err(failed)?,
        };
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut rows = BTreeMap::new();
        for (number, line) in text[..whole].lines().enumerate() {
            let row = row(line).filter(|row| belongs(row));
            let new = row.is_some_and(|row| rows.insert(row[0] as usize, row).is_none());
            if !new {
                let at = number + 1;
                let what = "no flight of this sweep, or one that is there already: move the file away";
                return Err(Error::Input(format!("{}:{at}: {what}", path.display())));
            }
        }
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(failed)?;
        file.set_len(whole as u64).map_err(failed)?;
        Ok(Self { path: path.into(), file, rows })
    }

    /// True when flight `run` is done.
    pub fn has(&self, run: usize) -> bool {
        self.rows.contains_key(&run)
    }

    /// Number of flights done.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Adds a row, in the units of its columns. Numbers keep all their digits.
    pub fn append(&mut self, row: &[f64]) -> Result<(), Error> {
        let cells: Vec<String> = row.iter().copied().map(shortest).collect();
        self.line(&cells.join(","))?;
        self.rows.insert(row[0] as usize, row.to_vec());
        Ok(())
    }

    /// The rows in the order of their flights, in the units of their columns.
    pub fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.values().map(Vec::as_slice)
    }

    /// The same as a table.
    pub fn record(&self, columns: Vec<Column>) -> Result<Record, Error> {
        let mut record = Record::new(columns, self.len())?;
        self.rows.values().for_each(|row| record.append(row));
        Ok(record)
    }

    /// Removes the file.
    pub fn remove(self) -> Result<(), Error> {
        fs::remove_file(&self.path).map_err(|source| Error::file(&self.path, source))
    }

    fn line(&mut self, text: &str) -> Result<(), Error> {
        writeln!(self.file, "{text}").map_err(|source| Error::file(&self.path, source))
    }
}

fn row(line: &str) -> Option<Vec<f64>> {
    line.split(',').map(|cell| cell.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_goes_on_where_it_was_cut() {
        let path = std::env::temp_dir().join(format!("wingbeat-log-{}", std::process::id()));
        let _ = fs::remove_file(&path);
        let two = |row: &[f64]| row.len() == 2;
        let mut log = SweepLog::open(&path, two).unwrap();
        log.append(&[3.0, 0.1 + 0.2]).unwrap();
        log.append(&[1.0, f64::NAN]).unwrap();
        drop(log);
        let cut = fs::read_to_string(&path).unwrap() + "2,0.";
        fs::write(&path, cut).unwrap();
        let mut log = SweepLog::open(&path, two).unwrap();
        assert!(log.has(1) && log.has(3) && !log.has(2));
        log.append(&[2.0, 7.0]).unwrap();
        drop(log);
        assert!(SweepLog::open(&path, |row| row[0] < 3.0).unwrap_err().to_string().contains(":1:"));
        let log = SweepLog::open(&path, two).unwrap();
        let record = log.record(vec![Column::new("run", "", ""), Column::new("x", "m", "")]).unwrap();
        assert_eq!(record.values("run"), Some([1.0, 2.0, 3.0].as_slice()));
        assert_eq!(record.values("x").unwrap()[2].to_bits(), (0.1_f64 + 0.2).to_bits());
        log.remove().unwrap();
        assert!(!path.exists());
    }
}
