//! Files of measured samples, of whatever program, as one kind of table.

mod ati;
mod grid;
#[cfg(feature = "hdf5")]
mod hdf5;
mod matlab;
mod numbers;
mod numpy;
mod record;
mod text;

pub use record::{Import, Imported};

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use wingbeat::simulate::Column;

use crate::{Error, read_parquet};

/// Most numbers that are read of one file: 2 GiB of them.
const MOST_NUMBERS: usize = 1 << 28;
/// Most bytes of a file that is read whole.
const MOST_BYTES: u64 = 4 << 30;

/// What a file of samples holds.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// Its layout, in words.
    pub layout: &'static str,
    /// Columns with the names and units that the file gives them; their lengths may differ.
    pub columns: Vec<Column>,
    /// What else is there, without numbers or of more than two dimensions.
    pub skipped: Vec<String>,
    /// Samples per second, Hz, where the file says it.
    pub rate: Option<f64>,
    /// True when records may stand in another order than they were measured.
    pub unordered: bool,
}

impl Table {
    fn new(path: &Path, layout: &'static str) -> Self {
        Self { path: path.into(), layout, ..Self::default() }
    }

    fn bad(&self, what: impl ToString) -> Error {
        Error::format(&self.path, what)
    }

    /// The size of an array, if the table has room for it.
    fn room(&self, name: &str, (rows, columns): (usize, usize)) -> Result<usize, Error> {
        let held: usize = self.columns.iter().map(|column| column.values.len()).sum();
        let count = rows.checked_mul(columns).filter(|count| *count <= MOST_NUMBERS - held.min(MOST_NUMBERS));
        count.ok_or_else(|| self.bad(format!("{name}: the file has more than {MOST_NUMBERS} numbers")))
    }

    /// An array of one or two dimensions as columns: the longer one is time. `rows` by
    /// `columns`, `values` by rows.
    fn add(&mut self, name: &str, unit: &str, (rows, columns): (usize, usize), values: Vec<f64>) {
        if rows <= 1 || columns <= 1 {
            return self.columns.push(Column { values, ..Column::new(name, unit, "") });
        }
        let by_rows = rows >= columns;
        let (count, length) = if by_rows { (columns, rows) } else { (rows, columns) };
        for k in 0..count {
            let at = |i: usize| if by_rows { i * columns + k } else { k * columns + i };
            let values = (0..length).map(|i| values[at(i)]).collect();
            self.columns.push(Column { values, ..Column::new(format!("{name}[{k}]"), unit, "") });
        }
    }
}

/// Reads a file of samples: Parquet, MATLAB (level 5 and 7.3), NumPy (npz, npy), HDF5, or
/// text with commas, semicolons or tabs, that of ATI's demo application included. The first
/// bytes say which.
///
/// # Errors
/// A file that cannot be read, is of none of these kinds, or is cut short.
pub fn read_samples(path: &Path) -> Result<Table, Error> {
    let mut head = Vec::new();
    let open = |source| Error::file(path, source);
    File::open(path).map_err(open)?.take(1024).read_to_end(&mut head).map_err(open)?;
    if head.is_empty() {
        return Err(Error::format(path, "the file is empty"));
    }
    let begins = |magic: &[u8]| head.starts_with(magic);
    let hdf5 = [0, 512].iter().any(|at| head.get(*at..).is_some_and(|rest| rest.starts_with(HDF5)));
    if begins(b"PAR1") {
        parquet(path)
    } else if hdf5 {
        hierarchical(path)
    } else if begins(b"MATLAB 5.0") {
        matlab::read(path)
    } else if begins(b"PK\x03\x04") {
        numpy::read_npz(path)
    } else if begins(numpy::MAGIC) {
        numpy::read_npy(path)
    } else if head.contains(&0) {
        Err(Error::format(path, UNKNOWN))
    } else {
        text::read(path)
    }
}

/// Signature of an HDF5 superblock.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// What can be read.
const UNKNOWN: &str = "not a file of samples: allowed are Parquet, MATLAB 5 and 7.3 (in MATLAB: save -v7), \
                       NumPy npz and npy, HDF5, and text with columns";

#[cfg(feature = "hdf5")]
use hdf5::read as hierarchical;

#[cfg(not(feature = "hdf5"))]
fn hierarchical(path: &Path) -> Result<Table, Error> {
    Err(Error::format(path, "an HDF5 file, which this build does not read: build with --features hdf5"))
}

fn parquet(path: &Path) -> Result<Table, Error> {
    let record = read_parquet(path)?;
    let mut table = Table::new(path, "Parquet");
    table.unordered = record.column("rdt_sequence").is_some();
    table.columns = record.columns().to_vec();
    Ok(table)
}

/// The bytes of a file of bounded size.
fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let size = std::fs::metadata(path).map_err(|source| Error::file(path, source))?.len();
    if size > MOST_BYTES {
        return Err(Error::format(path, format!("{size} bytes; read are at most {MOST_BYTES}")));
    }
    std::fs::read(path).map_err(|source| Error::file(path, source))
}
