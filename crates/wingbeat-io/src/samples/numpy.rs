//! Arrays of NumPy: one in an npy file, several in an npz archive (numpy.lib.format, version 1 to 3).

use std::io::{BufReader, Read};

use super::numbers::NumberKind;
use super::opened;
use super::table::{ArrayShape, SampleTable};
use crate::Error;
#[cfg(feature = "npz")]
use crate::MOST_COLUMNS;

/// First bytes of an npy file.
pub const MAGIC: &[u8] = b"\x93NUMPY";
/// Longest header that is read, bytes.
const MOST_HEADER: usize = 1 << 16;

/// The one array of an npy file; its name is that of the file.
pub fn read_npy(mut table: SampleTable) -> Result<SampleTable, Error> {
    let name = table.path.file_stem().map_or("array".into(), |stem| stem.to_string_lossy().into_owned());
    let (file, length) = opened(&table.path)?;
    array(&mut table, &name, BufReader::new(file), Some(length))?;
    Ok(table)
}

/// Every array of an npz archive.
#[cfg(not(feature = "npz"))]
pub fn read_npz(table: SampleTable) -> Result<SampleTable, Error> {
    Err(table.bad(crate::not_built("a NumPy npz archive")))
}

/// Every array of an npz archive.
#[cfg(feature = "npz")]
pub fn read_npz(mut table: SampleTable) -> Result<SampleTable, Error> {
    let path = table.path.clone();
    let (file, _) = opened(&path)?;
    let broken = |error| Error::format(&path, format!("cut short, or not an npz archive: {error}"));
    let mut archive = zip::ZipArchive::new(BufReader::new(file)).map_err(broken)?;
    if archive.len() > MOST_COLUMNS {
        return Err(table.bad(format!("{} arrays; read are at most {MOST_COLUMNS}", archive.len())));
    }
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(broken)?;
        let name = entry.name().map_err(broken)?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else { continue };
        array(&mut table, name, BufReader::new(entry), None)?;
    }
    Ok(table)
}

/// Adds the array that `data`, an npy file of `length` bytes where that is known, holds.
fn array(table: &mut SampleTable, name: &str, mut data: impl Read, length: Option<u64>) -> Result<(), Error> {
    let Some((header, begin)) = header(&mut data) else {
        return Err(table.bad(format!("array {name}: no npy header, cut short or damaged")));
    };
    let field = |key: &str| value(&header, key).unwrap_or("");
    let shape: Option<Vec<usize>> = numbers(field("shape"));
    let Some(shape) = shape else {
        return Err(table.bad(format!("array {name}: shape {} is not known", field("shape"))));
    };
    let Some((kind, big_endian)) = kind(field("descr")).filter(|_| shape.len() <= 2) else {
        table.skipped.push(name.into());
        return Ok(());
    };
    let (a, b) = (shape.first().copied().unwrap_or(1), shape.get(1).copied().unwrap_or(1));
    let fortran = field("fortran_order") == "True";
    let shape = if fortran { ArrayShape { rows: b, columns: a } } else { ArrayShape { rows: a, columns: b } };
    // An array that ends too soon is told even if nobody asked for it.
    let there =
        length.map_or(usize::MAX, |length| (length.saturating_sub(begin) / kind.size() as u64) as usize);
    if shape.count().is_some_and(|count| there < count) {
        return Err(table.cut(name, shape, there));
    }
    table.add(name, "", shape, kind.stream(data, big_endian))
}

/// The header, and the bytes up to its end.
fn header(data: &mut impl Read) -> Option<(String, u64)> {
    let mut start = [0; 8];
    data.read_exact(&mut start).ok()?;
    let version = *start.strip_prefix(MAGIC)?.first()?;
    let mut size = [0; 4];
    let digits = if version == 1 { 2 } else { 4 };
    data.read_exact(&mut size[..digits]).ok()?;
    let length = u32::from_le_bytes(size) as usize;
    let mut header = vec![0; length.min(MOST_HEADER)];
    data.read_exact(&mut header).ok()?;
    let whole = length <= MOST_HEADER;
    Some((String::from_utf8(header).ok().filter(|_| whole)?, (8 + digits + length) as u64))
}

/// The value of `key` in the header's Python dictionary, without quotes.
fn value<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let rest = header.split_once(&format!("'{key}':"))?.1.trim_start();
    let end = match rest.chars().next()? {
        '(' => rest.find(')')? + 1,
        '[' => rest.find(']')? + 1,
        _ => rest.find([',', '}'])?,
    };
    Some(rest[..end].trim().trim_matches('\''))
}

/// The whole numbers of a tuple.
fn numbers(tuple: &str) -> Option<Vec<usize>> {
    let inside = tuple.strip_prefix('(')?.strip_suffix(')')?;
    inside.split(',').map(str::trim).filter(|part| !part.is_empty()).map(|part| part.parse().ok()).collect()
}

/// Kind and byte order of a type such as `<f8`.
fn kind(descr: &str) -> Option<(NumberKind, bool)> {
    let mut letters = descr.chars();
    let big_endian = letters.next()? == '>';
    let kind = letters.next()?;
    let size = letters.as_str().parse().ok()?;
    let kind = match kind {
        'f' => NumberKind::Float(size),
        'i' => NumberKind::Signed(size),
        'u' | 'b' => NumberKind::Unsigned(size),
        _ => return None,
    };
    Some((kind.checked()?, big_endian))
}
