//! Records, arms and joint trajectories to and from files.

mod arrow_schema;
mod checksums;
mod parquet;
pub mod samples;
mod table;
mod thrift;
pub mod trajectory;
#[cfg(feature = "urdf")]
pub mod urdf;
#[cfg(not(feature = "urdf"))]
#[path = "without_urdf.rs"]
mod urdf;

pub use checksums::{checksum, unchanged};
pub use parquet::{ParquetWriter, read_parquet, read_parquet_columns, write_parquet};
pub use table::{csv_bytes, read_csv, shortest, write_csv};
pub use urdf::{parse_urdf, read_urdf, urdf_as_toml};

use std::fs::File;
use std::io::Read;
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

/// Most numbers that are kept of one file: 512 MiB of them, 16 minutes of ten channels at 7 kHz.
const MOST_NUMBERS: usize = 1 << 26;
/// Most columns of a file.
const MOST_COLUMNS: usize = 4096;

/// A file opened to be read, if it is a regular one, and as its run wrote it: what is not regular may have no end, or never begin.
fn regular(path: &Path) -> Result<File, Error> {
    let failed = |source| Error::file(path, source);
    if !std::fs::metadata(path).map_err(failed)?.is_file() {
        return Err(Error::format(path, "not a regular file"));
    }
    unchanged(path)?;
    File::open(path).map_err(failed)
}

/// Largest text that is read whole, bytes: a trajectory of 30 s at 1 kHz has 12 MB in YAML.
const LARGEST_TEXT: u64 = 32 << 20;

/// The text of a file of bounded size.
fn text(path: &Path) -> Result<String, Error> {
    let mut text = String::new();
    let read = regular(path)?.take(LARGEST_TEXT + 1).read_to_string(&mut text);
    read.map_err(|source| Error::file(path, source))?;
    match text.len() as u64 <= LARGEST_TEXT {
        true => Ok(text),
        false => Err(Error::format(path, format!("more than {LARGEST_TEXT} bytes, the most that is read"))),
    }
}

/// What is said of a file of a kind that this build does not read.
#[cfg(not(all(feature = "hdf5", feature = "npz", feature = "urdf", feature = "yaml")))]
fn not_built(kind: &str) -> String {
    format!(
        "{kind}, which this build does not read; `cargo build --release -p wingbeat-cli --features formats` makes one \
         that does"
    )
}

/// Name of the threads in which decoders of other libraries run: some panic on damaged files, which becomes an error.
pub const DECODER: &str = "decoder";

/// Runs a decoder of a file; its panic is the file's fault.
fn decoded<T: Send>(path: &Path, decode: impl FnOnce() -> Result<T, Error> + Send) -> Result<T, Error> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().name(DECODER.into()).spawn_scoped(scope, decode);
        let thread = thread.map_err(|source| Error::file(path, source))?;
        thread.join().unwrap_or_else(|_| Err(Error::format(path, "damaged: cannot be decoded")))
    })
}
