//! The tables of a case.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use wingbeat::scenario::RunName;
use wingbeat::simulate::Record;
use wingbeat_io::{read_csv, write_csv};

use crate::error::Error;
use crate::run_folder::RunFolder;

/// Tables of its own that a run folder has.
const TAKEN: [&str; 5] = ["loads.csv", "means.csv", "converge.csv", "compare.csv", "runs.csv"];
/// How names begin that are given to tables without one of their own.
const NUMBERED: &str = "table-";

/// The tables of a case, each read once and kept beside it, so that it runs again from its folder.
#[derive(Default)]
pub struct CaseTables(Mutex<Vec<(PathBuf, Record)>>);

impl CaseTables {
    fn all(&self) -> MutexGuard<'_, Vec<(PathBuf, Record)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The table in a file; the text says what is wrong with it.
    pub fn read(&self, path: &Path) -> Result<Record, String> {
        let mut tables = self.all();
        if let Some((_, record)) = tables.iter().find(|(known, _)| known == path) {
            return Ok(record.clone());
        }
        let record = read_csv(path).map_err(|error| error.to_string())?;
        tables.push((path.into(), record.clone()));
        Ok(record)
    }

    /// The name under which the table of a file is kept: its own, where that is of a table and free.
    pub fn name(&self, path: &Path) -> String {
        let tables = self.all();
        let own = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let alone = tables.iter().filter(|(known, _)| own(known) == own(path)).count() == 1;
        let of_table = own(path).ends_with(".csv") && !own(path).starts_with(NUMBERED);
        let free = alone && of_table && !TAKEN.contains(&own(path).as_str());
        let name = path.file_name().and_then(|name| name.to_str());
        match name.filter(|name| free && RunName::new("file", name).is_ok()) {
            Some(name) => name.into(),
            None => {
                format!(
                    "{NUMBERED}{}.csv",
                    1 + tables.iter().position(|(known, _)| known == path).unwrap_or(0)
                )
            }
        }
    }

    /// Writes the tables into a folder.
    ///
    /// # Errors
    /// A folder that already has a table of that name with other numbers.
    pub fn keep(&self, folder: &RunFolder) -> Result<(), Error> {
        let tables: Vec<(PathBuf, Record)> = self.all().clone();
        for (path, record) in tables {
            let kept = folder.file(&self.name(&path));
            if kept.exists() && read_csv(&kept)? != record {
                return Err(Error::Input(format!(
                    "{}: the table it held when the unfinished run in {} began",
                    path.display(),
                    folder.partial().display()
                )));
            }
            write_csv(&kept, &record)?;
        }
        Ok(())
    }
}
