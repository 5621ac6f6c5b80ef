//! The flights done so far, one line each, so that an interrupted sweep can go on.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use wingbeat::simulate::{Column, Record};

use crate::error::Error;

/// Rows by the number of their flight, on disk as soon as they are known.
pub struct Log {
    path: PathBuf,
    file: File,
    rows: BTreeMap<usize, Vec<f64>>,
}

impl Log {
    /// Opens the log; rows have `width` numbers, the first of which is the flight's. A line cut short is left out.
    pub fn open(path: &Path, width: usize) -> Result<Self, Error> {
        let text = fs::read_to_string(path).unwrap_or_default();
        let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
        let rows: BTreeMap<usize, Vec<f64>> =
            whole.lines().filter_map(|line| row(line, width)).map(|row| (row[0] as usize, row)).collect();
        let file = OpenOptions::new().create(true).append(true).open(path);
        let mut log =
            Self { path: path.into(), file: file.map_err(|source| Error::file(path, source))?, rows };
        if text.len() > whole.len() + 1 {
            log.line("")?;
        }
        Ok(log)
    }

    /// True when flight `run` is done.
    pub fn has(&self, run: usize) -> bool {
        self.rows.contains_key(&run)
    }

    /// Number of flights done.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Adds a row. Numbers keep all their digits.
    pub fn append(&mut self, row: &[f64]) -> Result<(), Error> {
        let cells: Vec<String> = row.iter().map(f64::to_string).collect();
        self.line(&cells.join(","))?;
        self.rows.insert(row[0] as usize, row.to_vec());
        Ok(())
    }

    /// The rows in the order of their flights.
    pub fn record(&self, columns: &[(String, &str)]) -> Result<Record, Error> {
        let columns = columns.iter().map(|(name, unit)| Column::new(name, *unit, "")).collect();
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

fn row(line: &str, width: usize) -> Option<Vec<f64>> {
    let numbers: Option<Vec<f64>> = line.split(',').map(|cell| cell.parse().ok()).collect();
    numbers.filter(|numbers| numbers.len() == width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_goes_on_where_it_was_cut() {
        let path = std::env::temp_dir().join(format!("wingbeat-log-{}", std::process::id()));
        let _ = fs::remove_file(&path);
        let mut log = Log::open(&path, 2).unwrap();
        log.append(&[3.0, 0.1 + 0.2]).unwrap();
        log.append(&[1.0, f64::NAN]).unwrap();
        drop(log);
        let cut = fs::read_to_string(&path).unwrap() + "2,0.";
        fs::write(&path, cut).unwrap();
        let mut log = Log::open(&path, 2).unwrap();
        assert!(log.has(1) && log.has(3) && !log.has(2));
        log.append(&[2.0, 7.0]).unwrap();
        drop(log);
        let log = Log::open(&path, 2).unwrap();
        let record = log.record(&[("run".into(), ""), ("x".into(), "m")]).unwrap();
        assert_eq!(record.values("run"), Some([1.0, 2.0, 3.0].as_slice()));
        assert_eq!(record.values("x").unwrap()[2].to_bits(), (0.1_f64 + 0.2).to_bits());
        log.remove().unwrap();
        assert!(!path.exists());
    }
}
