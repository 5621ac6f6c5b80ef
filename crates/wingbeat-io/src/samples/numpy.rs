//! Arrays of NumPy: one in an npy file, several in an npz archive (numpy.lib.format, version 1 to 3).

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::numbers::Kind;
use super::{MOST_NUMBERS, Table, bytes};
use crate::Error;

/// First bytes of an npy file.
pub const MAGIC: &[u8] = b"\x93NUMPY";
/// Longest header that is read, bytes.
const MOST_HEADER: usize = 1 << 16;

/// The one array of an npy file; its name is that of the file.
pub fn read_npy(path: &Path) -> Result<Table, Error> {
    let mut table = Table::new(path, "NumPy npy");
    let name = path.file_stem().map_or("array".into(), |stem| stem.to_string_lossy().into_owned());
    let data = bytes(path)?;
    array(&mut table, &name, &data)?;
    Ok(table)
}

/// Every array of an npz archive.
pub fn read_npz(path: &Path) -> Result<Table, Error> {
    let mut table = Table::new(path, "NumPy npz");
    let file = File::open(path).map_err(|source| Error::file(path, source))?;
    let broken = |error| Error::format(path, format!("cut short, or not an npz archive: {error}"));
    let mut archive = zip::ZipArchive::new(file).map_err(broken)?;
    let mut left = 8 * MOST_NUMBERS as u64;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).map_err(broken)?;
        let name = entry.name().map_err(broken)?.into_owned();
        let Some(name) = name.strip_suffix(".npy") else { continue };
        let mut data = Vec::new();
        let read = entry.by_ref().take(left).read_to_end(&mut data);
        read.map_err(|error| Error::format(path, format!("array {name}: cut short or damaged: {error}")))?;
        left -= data.len() as u64;
        if left == 0 {
            return Err(table.bad(format!("array {name}: more than {MOST_NUMBERS} numbers")));
        }
        array(&mut table, name, &data)?;
    }
    Ok(table)
}

/// Adds the array in `data`, an npy file.
fn array(table: &mut Table, name: &str, data: &[u8]) -> Result<(), Error> {
    let (header, body) = split(data).ok_or_else(|| table.bad(format!("array {name}: no npy header")))?;
    let field = |key: &str| value(header, key).unwrap_or("");
    let shape: Option<Vec<usize>> = numbers(field("shape"));
    let Some(shape) = shape else {
        return Err(table.bad(format!("array {name}: shape {} is not known", field("shape"))));
    };
    let Some((kind, big_endian)) = kind(field("descr")).filter(|_| shape.len() <= 2) else {
        table.skipped.push(name.into());
        return Ok(());
    };
    let (a, b) = (shape.first().copied().unwrap_or(1), shape.get(1).copied().unwrap_or(1));
    let count = table.room(name, (a, b))?;
    let mut values = kind.read(body, big_endian);
    if values.len() < count {
        let samples = values.len() / if field("fortran_order") == "True" { 1 } else { b.max(1) };
        return Err(table.bad(format!("array {name}: cut short at sample {samples} of {a}")));
    }
    values.truncate(count);
    let shape = if field("fortran_order") == "True" { (b, a) } else { (a, b) };
    table.add(name, "", shape, values);
    Ok(())
}

/// Header and what follows it.
fn split(data: &[u8]) -> Option<(&str, &[u8])> {
    let rest = data.strip_prefix(MAGIC)?;
    let (length, start) = match rest.first()? {
        1 => (usize::from(u16::from_le_bytes(rest.get(2..4)?.try_into().ok()?)), 4),
        _ => (u32::from_le_bytes(rest.get(2..6)?.try_into().ok()?) as usize, 6),
    };
    let header = rest.get(start..start + length.min(MOST_HEADER))?;
    Some((std::str::from_utf8(header).ok()?, rest.get(start + length..)?))
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
fn kind(descr: &str) -> Option<(Kind, bool)> {
    let mut letters = descr.chars();
    let big_endian = letters.next()? == '>';
    let kind = letters.next()?;
    let size = letters.as_str().parse().ok()?;
    let kind = match kind {
        'f' => Kind::Float(size),
        'i' => Kind::Signed(size),
        'u' | 'b' => Kind::Unsigned(size),
        _ => return None,
    };
    Some((kind.checked()?, big_endian))
}
