//! Files of measured samples, of whatever program, as one kind of table.

mod ati;
mod grid;
#[cfg(feature = "hdf5")]
mod hdf5;
mod matlab;
mod matlab4;
mod mcap;
mod numbers;
mod numpy;
mod plain;
mod record;
mod resolve;
mod table;
mod text;

pub use mcap::MAGIC as MCAP_MAGIC;
pub use plain::{ChannelRequest, Plain, read_measured};
pub use record::{Import, ImportedRecord};
pub use table::SampleTable;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use wingbeat::rig::process::InputSpec;

use crate::{Error, decoded, parquet, regular};
use resolve::WantedColumns;

/// Reads a file of samples: Parquet, MATLAB (level 4, 5 and 7.3), NumPy (npz, npy), HDF5, MCAP of ROS 2, or
/// text with commas, semicolons or tabs, that of ATI's demo application included. The first
/// bytes say which. Kept are the columns that `input` names or processing knows.
///
/// # Errors
/// A file that cannot be read, is of none of these kinds, holds more than is read, or is cut short.
pub fn read_samples(path: &Path, input: &InputSpec) -> Result<SampleTable, Error> {
    read_wanted(path, &WantedColumns::of(input))
}

/// Every column of a file of samples, of the kinds that [`read_samples`] reads.
///
/// # Errors
/// Those of [`read_samples`].
pub fn read_channels(path: &Path) -> Result<SampleTable, Error> {
    read_wanted(path, &WantedColumns::every())
}

fn read_wanted(path: &Path, wanted: &WantedColumns) -> Result<SampleTable, Error> {
    let mut head = Vec::new();
    let open = |source| Error::file(path, source);
    let file = regular(path)?;
    file.take(1024).read_to_end(&mut head).map_err(open)?;
    if head.is_empty() {
        return Err(Error::format(path, "the file is empty"));
    }
    let begins = |magic: &[u8]| head.starts_with(magic);
    let hdf5 = [0, 512].iter().any(|at| head.get(*at..).is_some_and(|rest| rest.starts_with(HDF5)));
    let table = |layout| SampleTable::new(path, layout, wanted.clone());
    if begins(b"PAR1") {
        of_parquet(table("Parquet"))
    } else if hdf5 {
        decoded(path, || hierarchical(table("HDF5")))
    } else if begins(mcap::MAGIC) {
        mcap::read(table("MCAP"))
    } else if begins(b"MATLAB 5.0") {
        matlab::read(table("MATLAB 5"))
    } else if begins(b"PK\x03\x04") {
        numpy::read_npz(table("NumPy npz"))
    } else if begins(numpy::MAGIC) {
        numpy::read_npy(table("NumPy npy"))
    } else if matlab4::begins(&head) {
        matlab4::read(table("MATLAB 4"))
    } else if head.contains(&0) {
        Err(Error::format(path, UNKNOWN))
    } else {
        text::read(table("text"))
    }
}

/// Signature of an HDF5 superblock.
const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
/// What can be read.
const UNKNOWN: &str = "not a file of samples: allowed are Parquet, MATLAB 4, 5 and 7.3, NumPy npz and npy, HDF5, \
                       MCAP of ROS 2, and text with columns";

#[cfg(feature = "hdf5")]
use hdf5::read as hierarchical;

#[cfg(not(feature = "hdf5"))]
fn hierarchical(table: SampleTable) -> Result<SampleTable, Error> {
    Err(table.bad(crate::not_built("an HDF5 or MATLAB 7.3 file")))
}

fn of_parquet(mut table: SampleTable) -> Result<SampleTable, Error> {
    let read = parquet::read_some(&table.path, &|name| table.wanted.wants(name))?;
    table.unordered = read.names.iter().any(|name| name == "rdt_sequence");
    (table.names, table.columns) = (read.names, read.columns);
    Ok(table)
}

/// A file with its length.
fn opened(path: &Path) -> Result<(File, u64), Error> {
    let file = regular(path)?;
    let length = file.metadata().map_err(|source| Error::file(path, source))?.len();
    Ok((file, length))
}
