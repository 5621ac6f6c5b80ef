//! The recorder's log: rows of fixed length, appended, whole up to the last one
//! written whatever happens.

use std::fs;
use std::path::Path;

use wingbeat::rig::netft::RdtRecord;

use crate::Error;

/// Bytes of one row.
pub const ROW_BYTES: usize = 52;

/// One record with the times of its arrival.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Row {
    /// Clock of the host when the program got it, ns since 1970.
    pub host_ns: u64,
    /// Clock of the kernel when the datagram came, ns since 1970; 0 when not known.
    pub kernel_ns: u64,
    /// The record.
    pub record: RdtRecord,
}

impl Row {
    /// The bytes in the log, little-endian times, then the record as it came.
    pub fn bytes(&self) -> [u8; ROW_BYTES] {
        let mut out = [0; ROW_BYTES];
        out[..8].copy_from_slice(&self.host_ns.to_le_bytes());
        out[8..16].copy_from_slice(&self.kernel_ns.to_le_bytes());
        out[16..].copy_from_slice(&self.record.bytes());
        out
    }

    fn parse(bytes: &[u8]) -> Option<Self> {
        let word = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
        let record = RdtRecord::parse(bytes.get(16..ROW_BYTES)?)?.next()?;
        Some(Self { host_ns: word(0)?, kernel_ns: word(8)?, record })
    }
}

/// The whole rows of a log; a last row cut short is left out.
///
/// # Errors
/// A file that cannot be read.
pub fn read_log(path: &Path) -> Result<Vec<Row>, Error> {
    let bytes = fs::read(path).map_err(|source| Error::file(path, source))?;
    Ok(bytes.chunks_exact(ROW_BYTES).filter_map(Row::parse).collect())
}
