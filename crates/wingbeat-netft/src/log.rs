//! The recorder's logs: rows of fixed length, appended, whole up to the last one written whatever happens.

use std::fs::{File, OpenOptions};
use std::io::{BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use wingbeat::rig::netft::RdtRecord;

use crate::Error;

/// Bytes of one row.
pub const ROW_BYTES: usize = 52;
/// Rows held before they are written.
const HELD: usize = 1024;

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

    /// The time of arrival that is best known, ns since 1970.
    pub fn arrival_ns(&self) -> u64 {
        if self.kernel_ns > 0 { self.kernel_ns } else { self.host_ns }
    }

    fn parse(bytes: &[u8; ROW_BYTES]) -> Option<Self> {
        let word = |at: usize| Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?));
        let record = RdtRecord::parse(&bytes[16..])?.next()?;
        Some(Self { host_ns: word(0)?, kernel_ns: word(8)?, record })
    }
}

/// The whole rows of a log, one by one; a last row cut short is left out.
///
/// # Errors
/// A file that cannot be opened; an item, when it cannot be read on.
pub fn read_log(path: &Path) -> Result<impl Iterator<Item = Result<Row, Error>>, Error> {
    let file = File::open(path).map_err(|source| Error::file(path, source))?;
    let mut reader = BufReader::with_capacity(ROW_BYTES * HELD, file);
    let path = path.to_path_buf();
    Ok(std::iter::from_fn(move || {
        let mut bytes = [0; ROW_BYTES];
        match reader.read_exact(&mut bytes) {
            Ok(()) => Row::parse(&bytes).map(Ok),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => None,
            Err(source) => Some(Err(Error::file(&path, source))),
        }
    }))
}

/// The logs called `<stem>-NNN.rdt` in `folder`, in order.
///
/// # Errors
/// A folder that cannot be read.
pub fn logs(folder: &Path, stem: &str) -> Result<Vec<PathBuf>, Error> {
    let failed = |source| Error::file(folder, source);
    let start = format!("{stem}-");
    let mut found = Vec::new();
    for entry in folder.read_dir().map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let number = name.strip_prefix(&start).and_then(|rest| rest.strip_suffix(".rdt"));
        if let Some(number) = number.and_then(|digits| digits.parse::<u64>().ok()) {
            found.push((number, path));
        }
    }
    found.sort();
    Ok(found.into_iter().map(|(_, path)| path).collect())
}

/// Logs that follow one another while they are written.
pub struct Log {
    folder: PathBuf,
    stem: String,
    rotate_rows: u64,
    rows: u64,
    writer: BufWriter<File>,
    pub files: Vec<PathBuf>,
}

impl Log {
    /// Begins the first log whose number is free.
    pub fn open(folder: &Path, stem: &str, rotate_rows: u64) -> Result<Self, Error> {
        std::fs::create_dir_all(folder).map_err(|source| Error::file(folder, source))?;
        let (path, file) = next(folder, stem)?;
        let writer = BufWriter::with_capacity(ROW_BYTES * HELD, file);
        Ok(Self { folder: folder.into(), stem: stem.into(), rotate_rows, rows: 0, writer, files: vec![path] })
    }

    /// Appends a row, in a new log once this one is full.
    pub fn append(&mut self, row: &Row) -> Result<(), Error> {
        if self.rotate_rows > 0 && self.rows >= self.rotate_rows {
            self.close()?;
            let (path, file) = next(&self.folder, &self.stem)?;
            self.writer = BufWriter::with_capacity(ROW_BYTES * HELD, file);
            self.files.push(path);
            self.rows = 0;
        }
        self.rows += 1;
        let failed = |source| Error::file(self.files.last().map_or(Path::new(""), |p| p), source);
        self.writer.write_all(&row.bytes()).map_err(failed)
    }

    /// Sees that all is on the disk.
    pub fn close(&mut self) -> Result<(), Error> {
        let path = self.files.last().cloned().unwrap_or_default();
        self.writer.flush().and_then(|()| self.writer.get_ref().sync_all()).map_err(|e| Error::file(&path, e))
    }
}

/// The first free name and its file.
fn next(folder: &Path, stem: &str) -> Result<(PathBuf, File), Error> {
    for number in 0.. {
        let path = folder.join(format!("{stem}-{number:03}.rdt"));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
            Err(source) => return Err(Error::file(&path, source)),
        }
    }
    unreachable!("numbers do not end")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_is_whole_up_to_its_last_whole_row() {
        let folder = std::env::temp_dir().join(format!("wingbeat-log-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let rows: Vec<Row> = (0..5).map(|k| Row { host_ns: k, ..Default::default() }).collect();
        let mut log = Log::open(&folder, "raw", 3).unwrap();
        rows.iter().for_each(|row| log.append(row).unwrap());
        log.close().unwrap();
        assert_eq!(logs(&folder, "raw").unwrap(), log.files);
        let cut = OpenOptions::new().write(true).open(&log.files[1]).unwrap();
        cut.set_len(2 * ROW_BYTES as u64 - 1).unwrap();
        let read: Vec<Row> =
            log.files.iter().flat_map(|f| read_log(f).unwrap()).map(Result::unwrap).collect();
        assert_eq!(read, rows[..4]);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
