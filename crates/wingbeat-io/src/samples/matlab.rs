//! MATLAB files of level 5 (MathWorks, MAT-File Format): numeric arrays with their names.

use std::io::Read;
use std::path::Path;

use flate2::read::ZlibDecoder;

use super::numbers::Kind;
use super::{MOST_NUMBERS, Table, bytes};
use crate::Error;

/// Bytes before the first element.
const HEADER: usize = 128;
/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array classes double .. uint64; those below hold no plain numbers.
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;

/// Every numeric array of a file.
pub fn read(path: &Path) -> Result<Table, Error> {
    let mut table = Table::new(path, "MATLAB 5");
    let data = bytes(path)?;
    let big_endian = match data.get(HEADER - 2..HEADER) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        _ => return Err(table.bad("cut short in its header")),
    };
    let reader = Elements { data: data.get(HEADER..).unwrap_or(&[]), big_endian };
    for (number, element) in reader.enumerate() {
        let cut = || table.bad(format!("cut short in variable {}", number + 1));
        let (kind, body) = element.ok_or_else(cut)?;
        match kind {
            MATRIX => variable(&mut table, body, big_endian, number)?,
            COMPRESSED => {
                let inflated = inflate(&table, body, number)?;
                if let Some(Some((MATRIX, body))) = (Elements { data: &inflated, big_endian }).next() {
                    variable(&mut table, body, big_endian, number)?;
                }
            }
            _ => {}
        }
    }
    Ok(table)
}

fn inflate(table: &Table, body: &[u8], number: usize) -> Result<Vec<u8>, Error> {
    let most = 8 * MOST_NUMBERS as u64;
    let mut data = Vec::new();
    let read = ZlibDecoder::new(body).take(most).read_to_end(&mut data);
    read.map_err(|error| table.bad(format!("variable {}: cut short or damaged: {error}", number + 1)))?;
    match data.len() as u64 == most {
        true => Err(table.bad(format!("variable {}: more than {MOST_NUMBERS} numbers", number + 1))),
        false => Ok(data),
    }
}

/// Adds the array in the body of a matrix element: flags, dimensions, name, real part.
fn variable(table: &mut Table, body: &[u8], big_endian: bool, number: usize) -> Result<(), Error> {
    let broken = |what: &str| format!("variable {}: {what}", number + 1);
    let mut parts = Elements { data: body, big_endian }.flatten();
    let (Some((_, flags)), Some((_, shape)), Some((_, name))) = (parts.next(), parts.next(), parts.next())
    else {
        return Err(table.bad(broken("cut short in its description")));
    };
    let class = if big_endian { flags.get(3) } else { flags.first() };
    let name = String::from_utf8_lossy(name).into_owned();
    let shape = Kind::Signed(4).read(shape, big_endian);
    let ([rows, columns], true) = (shape.as_slice(), class.is_some_and(|class| NUMERIC.contains(class)))
    else {
        table.skipped.push(name);
        return Ok(());
    };
    // Columns follow one another: rows of the transpose.
    let shape = (columns.max(0.0) as usize, rows.max(0.0) as usize);
    let count = table.room(&name, shape)?;
    let (kind, data) = parts.next().unwrap_or((0, &[]));
    let kind = stored(kind).ok_or_else(|| table.bad(format!("variable {name}: cut short at sample 0")))?;
    let mut values = kind.read(data, big_endian);
    if values.len() < count {
        return Err(table.bad(format!("variable {name}: cut short at sample {} of {count}", values.len())));
    }
    values.truncate(count);
    table.add(&name, "", shape, values);
    Ok(())
}

/// How the numbers of a data element are stored.
fn stored(kind: u32) -> Option<Kind> {
    Some(match kind {
        1 => Kind::Signed(1),
        2 => Kind::Unsigned(1),
        3 => Kind::Signed(2),
        4 => Kind::Unsigned(2),
        5 => Kind::Signed(4),
        6 => Kind::Unsigned(4),
        7 => Kind::Float(4),
        9 => Kind::Float(8),
        12 => Kind::Signed(8),
        13 => Kind::Unsigned(8),
        _ => return None,
    })
}

/// Type and body of the elements one after another; none where one is cut short.
struct Elements<'a> {
    data: &'a [u8],
    big_endian: bool,
}

impl<'a> Iterator for Elements<'a> {
    type Item = Option<(u32, &'a [u8])>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.data.is_empty() {
            return None;
        }
        let element = self.split();
        if element.is_none() {
            self.data = &[];
        }
        Some(element)
    }
}

impl<'a> Elements<'a> {
    fn word(&self, at: usize) -> Option<u32> {
        let word = self.data.get(at..at + 4)?.try_into().ok()?;
        Some(if self.big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
    }

    fn split(&mut self) -> Option<(u32, &'a [u8])> {
        let kind = self.word(0)?;
        // Up to four bytes of data stand in the tag itself, their number in its upper half.
        let (kind, from, size): (u32, usize, usize) = match kind >> 16 {
            0 => (kind, 8, self.word(4)? as usize),
            small => (kind & 0xffff, 4, small.min(4) as usize),
        };
        let body = self.data.get(from..from.checked_add(size)?)?;
        let padded = if kind == COMPRESSED { from + size } else { (from + size).next_multiple_of(8) };
        self.data = self.data.get(padded..).unwrap_or(&[]);
        Some((kind, body))
    }
}
