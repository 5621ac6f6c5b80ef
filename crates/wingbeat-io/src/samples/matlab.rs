//! MATLAB files of level 5 (MathWorks, MAT-File Format): numeric arrays with their names.

use std::io::{BufReader, Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;

use super::numbers::NumberKind;
use super::opened;
use super::table::{ArrayShape, SampleTable};
use crate::Error;

/// Bytes before the first element.
const HEADER: u64 = 128;
/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array classes double .. uint64; those below hold no plain numbers.
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;
/// Longest description (flags, dimensions, name) that is read, bytes.
const MOST_DESCRIPTION: u32 = 1 << 12;

/// Every numeric array of a file.
pub fn read(mut table: SampleTable) -> Result<SampleTable, Error> {
    let (file, length) = opened(&table.path)?;
    let path = table.path.clone();
    let failed = |source| Error::file(&path, source);
    let mut file = BufReader::new(file);
    let mut header = [0; HEADER as usize];
    let big_endian = match file.read_exact(&mut header).map(|()| &header[126..]) {
        Ok(b"IM") => false,
        Ok(b"MI") => true,
        _ => return Err(table.bad("cut short in its header")),
    };
    let (mut at, mut number) = (HEADER, 0);
    while at < length {
        number += 1;
        let cut = |table: &SampleTable| table.bad(format!("cut short in variable {number}"));
        file.seek(SeekFrom::Start(at)).map_err(failed)?;
        let tag = Tag::read(&mut file, big_endian).filter(|tag| at + tag.end() <= length);
        let tag = tag.ok_or_else(|| cut(&table))?;
        let mut body = tag.body(&mut file);
        match tag.kind {
            MATRIX => variable(&mut table, &mut body, big_endian, number)?,
            COMPRESSED => {
                let mut inflated = BufReader::new(ZlibDecoder::new(body));
                let inner = Tag::read(&mut inflated, big_endian).ok_or_else(|| cut(&table))?;
                if inner.kind == MATRIX {
                    variable(&mut table, &mut inner.body(&mut inflated), big_endian, number)?;
                }
            }
            _ => {}
        }
        at += if tag.kind == COMPRESSED { tag.end() } else { tag.end().next_multiple_of(8) };
    }
    Ok(table)
}

/// Adds the array in the body of a matrix element: flags, dimensions, name, real part.
fn variable(
    table: &mut SampleTable,
    body: &mut impl Read,
    big_endian: bool,
    number: usize,
) -> Result<(), Error> {
    let (Some(flags), Some(shape), Some(name)) =
        (part(body, big_endian), part(body, big_endian), part(body, big_endian))
    else {
        return Err(table.bad(format!("variable {number}: cut short in its description")));
    };
    let class = if big_endian { flags.get(3) } else { flags.first() };
    let name = String::from_utf8_lossy(&name).into_owned();
    let shape = NumberKind::Signed(4).read(&shape, big_endian);
    let ([rows, columns], true) = (shape.as_slice(), class.is_some_and(|class| NUMERIC.contains(class)))
    else {
        table.skipped.push(name);
        return Ok(());
    };
    // Columns follow one another: rows of the transpose.
    let shape = ArrayShape { rows: columns.max(0.0) as usize, columns: rows.max(0.0) as usize };
    let data = Tag::read(body, big_endian);
    let stored = data.as_ref().and_then(|tag| stored(tag.kind));
    let (Some(tag), Some(kind)) = (data, stored) else {
        return Err(table.bad(format!("variable {name}: cut short at sample 0")));
    };
    table.add(&name, "", shape, kind.stream(tag.body(body), big_endian))
}

/// The bytes of a short element, and none of what fills it up to a multiple of eight.
fn part(body: &mut impl Read, big_endian: bool) -> Option<Vec<u8>> {
    let tag = Tag::read(body, big_endian).filter(|tag| tag.size <= MOST_DESCRIPTION)?;
    let mut bytes = Vec::new();
    tag.body(body).read_to_end(&mut bytes).ok()?;
    let filling = if tag.small.is_some() { 0 } else { (8 - tag.size % 8) % 8 };
    let mut rest = [0; 8];
    body.read_exact(&mut rest[..filling as usize]).ok()?;
    (bytes.len() == tag.size as usize).then_some(bytes)
}

/// How the numbers of a data element are stored.
fn stored(kind: u32) -> Option<NumberKind> {
    Some(match kind {
        1 => NumberKind::Signed(1),
        2 => NumberKind::Unsigned(1),
        3 => NumberKind::Signed(2),
        4 => NumberKind::Unsigned(2),
        5 => NumberKind::Signed(4),
        6 => NumberKind::Unsigned(4),
        7 => NumberKind::Float(4),
        9 => NumberKind::Float(8),
        12 => NumberKind::Signed(8),
        13 => NumberKind::Unsigned(8),
        _ => return None,
    })
}

/// What an element begins with.
struct Tag {
    kind: u32,
    /// Bytes of its body.
    size: u32,
    /// The body, where it stands in the tag itself: up to four bytes, their number in its upper half.
    small: Option<[u8; 4]>,
}

impl Tag {
    fn read(reader: &mut impl Read, big_endian: bool) -> Option<Self> {
        let (mut first, mut second) = ([0; 4], [0; 4]);
        reader.read_exact(&mut first).and_then(|()| reader.read_exact(&mut second)).ok()?;
        let word = |word| if big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) };
        let kind = word(first);
        Some(match kind >> 16 {
            0 => Self { kind, size: word(second), small: None },
            small => Self { kind: kind & 0xffff, size: small.min(4), small: Some(second) },
        })
    }

    /// Bytes of tag and body.
    fn end(&self) -> u64 {
        if self.small.is_some() { 8 } else { 8 + u64::from(self.size) }
    }

    /// The body, most of which `reader` holds.
    fn body<'a, R: Read>(&self, reader: &'a mut R) -> impl Read + use<'a, R> {
        let (inside, behind) = match self.small {
            Some(bytes) => (bytes, 0),
            None => ([0; 4], u64::from(self.size)),
        };
        let here = if self.small.is_some() { u64::from(self.size) } else { 0 };
        std::io::Cursor::new(inside).take(here).chain(reader.take(behind))
    }
}
