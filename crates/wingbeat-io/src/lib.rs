//! Records, arms and joint trajectories to and from files.

mod arrow_schema;
mod parquet;
pub mod samples;
mod table;
pub mod trajectory;
mod urdf;

pub use parquet::{ParquetWriter, read_parquet, write_parquet};
pub use table::{read_csv, write_csv};
pub use urdf::{parse_urdf, read_urdf, urdf_as_toml};

use std::path::{Path, PathBuf};

/// Why a file could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file could not be opened, written or moved.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file does not hold a record.
    #[error("{path}: {what}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

impl Error {
    fn file(path: &Path, source: std::io::Error) -> Self {
        Self::File { path: path.into(), source }
    }

    fn format(path: &Path, what: impl ToString) -> Self {
        Self::Format { path: path.into(), what: what.to_string() }
    }
}

/// Largest text file that is read, bytes.
const LARGEST_TEXT: u64 = 256 << 20;

/// The text of a file of bounded size.
fn text(path: &Path) -> Result<String, Error> {
    let size = std::fs::metadata(path).map_err(|source| Error::file(path, source))?.len();
    if size > LARGEST_TEXT {
        return Err(Error::format(path, format!("{size} bytes; read are at most {LARGEST_TEXT}")));
    }
    std::fs::read_to_string(path).map_err(|source| Error::file(path, source))
}
