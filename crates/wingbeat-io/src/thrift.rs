//! Bounds on what a Parquet file asks of its decoder.
//!
//! Footer and page headers are structs of Thrift's compact protocol. The decoder passes over fields that it does not
//! know; the truth values of a list there take no bytes, so that a few bytes may ask for any number of steps. Here the
//! structs are passed over by the same rules and refused where they hold more elements than bytes.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// Most bytes of the header of a page. *Choice*: it holds sizes and the least and largest value.
const LARGEST_HEADER: u64 = 1 << 20;
/// Bytes read first where a header begins. *Choice.*
const FIRST_PART: u64 = 16 << 10;
/// Deepest nesting; the decoder stops at 64 below the fields it knows.
const DEEPEST: usize = 96;
/// Bytes of the footer's length and the mark behind it.
const TAIL: u64 = 8;
/// Field of a page header that holds the length of what follows, bytes; type and uncompressed size come before it.
const COMPRESSED_SIZE: i64 = 3;

/// Why a struct cannot be passed over.
#[derive(Debug, PartialEq)]
enum StructFault {
    /// More elements than bytes.
    Endless,
    /// The bytes end before the struct.
    Cut,
    /// The bytes are no struct of this kind.
    Broken,
}

/// Most bytes of a footer that are read. *Choice*: 4096 columns in 100 groups of rows take 40 MiB; a hole in a file, which
/// takes no room, may claim 4 GiB.
pub const LARGEST_FOOTER: u64 = 64 << 20;

/// Bytes that the end of `file` claims for its footer; none where there is no end.
pub fn footer_length(file: &mut File) -> io::Result<Option<u64>> {
    let Some(tail) = file.metadata()?.len().checked_sub(TAIL) else { return Ok(None) };
    let mut length = [0; 4];
    file.seek(SeekFrom::Start(tail))?;
    file.read_exact(&mut length)?;
    Ok(Some(u64::from(u32::from_le_bytes(length))))
}

/// Whether the footer of `file` can be decoded in time that its length bounds.
pub fn footer_ends(file: &mut File) -> io::Result<bool> {
    let Some(length) = footer_length(file)? else { return Ok(true) };
    let tail = file.metadata()?.len() - TAIL;
    let Some(start) = tail.checked_sub(length) else { return Ok(true) };
    let bytes = part(file, start, tail - start)?;
    Ok(ThriftRemainder::new(&bytes).header() != Err(StructFault::Endless))
}

/// Whether the headers of the pages in `length` bytes of `file` from `start` on can be, and are no more than `most`.
pub fn pages_end(file: &mut File, start: u64, length: u64, most: u64) -> io::Result<bool> {
    let (mut at, end) = (start, start.saturating_add(length));
    let (mut bytes, mut from, mut pages) = (Vec::new(), start, 0);
    let mut window = FIRST_PART;
    while at < end {
        let rest = usize::try_from(at - from).ok().and_then(|used| bytes.get(used..)).unwrap_or_default();
        let mut walk = ThriftRemainder::new(rest);
        match walk.header() {
            Ok(data) => {
                at = at.saturating_add((rest.len() - walk.bytes.len()) as u64).saturating_add(data);
                (pages, window) = (pages + 1, FIRST_PART);
                if pages > most {
                    return Ok(false);
                }
            }
            Err(StructFault::Broken) => return Ok(false),
            Err(stop) if rest.len() as u64 == end - at => return Ok(stop == StructFault::Cut),
            Err(_) => {
                if window > LARGEST_HEADER {
                    return Ok(false);
                }
                fill(&mut bytes, file, at, window.min(end - at))?;
                (from, window) = (at, 2 * window);
            }
        }
    }
    Ok(true)
}

fn part(file: &mut File, start: u64, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    fill(&mut bytes, file, start, length)?;
    Ok(bytes)
}

/// Puts the part in place of what `bytes` holds.
fn fill(bytes: &mut Vec<u8>, file: &mut File, start: u64, length: u64) -> io::Result<()> {
    bytes.clear();
    file.seek(SeekFrom::Start(start))?;
    file.take(length).read_to_end(bytes).map(drop)
}

/// What is left to be passed over.
struct ThriftRemainder<'a> {
    bytes: &'a [u8],
    /// Elements of lists, sets and maps that may still come.
    elements: u64,
}

impl<'a> ThriftRemainder<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, elements: bytes.len() as u64 }
    }

    /// Passes over a page header; the number in its field [`COMPRESSED_SIZE`]. A struct without it, type or
    /// uncompressed size is broken.
    fn header(&mut self) -> Result<u64, StructFault> {
        let (mut field, mut numbers) = (0, [None; COMPRESSED_SIZE as usize]);
        loop {
            let (delta, kind) = nibbles(self.byte()?);
            field = if delta > 0 { i64::saturating_add(field, i64::from(delta)) } else { field };
            match (kind, delta) {
                (0, _) => {
                    let size = numbers.iter().try_fold(0, |_, number| *number).ok_or(StructFault::Broken)?;
                    return u64::try_from(size).map_err(|_| StructFault::Broken);
                }
                (_, 0) => field = self.signed()?,
                _ => {}
            }
            match (kind, field) {
                (5, 1..=COMPRESSED_SIZE) => numbers[field as usize - 1] = Some(self.signed()?),
                _ => self.skip(kind, DEEPEST)?,
            }
        }
    }

    fn skip(&mut self, kind: u8, depth: usize) -> Result<(), StructFault> {
        let depth = depth.checked_sub(1).ok_or(StructFault::Broken)?;
        match kind {
            1 | 2 => Ok(()),
            3 => self.byte().map(drop),
            4..=6 => self.number().map(drop),
            7 => self.pass(8),
            8 => self.number().and_then(|length| self.pass(length)),
            9 | 10 => {
                let (short, element) = nibbles(self.byte()?);
                let count = if short == 15 { self.number()? } else { u64::from(short) };
                self.each(count, &[element], depth)
            }
            11 => {
                let count = self.number()?;
                let (key, value) = if count > 0 { nibbles(self.byte()?) } else { (0, 0) };
                self.each(count, &[key, value], depth)
            }
            12 => loop {
                let (delta, kind) = nibbles(self.byte()?);
                if kind == 0 {
                    return Ok(());
                }
                if delta == 0 {
                    self.number()?;
                }
                self.skip(kind, depth)?;
            },
            13 => self.pass(16),
            _ => Err(StructFault::Broken),
        }
    }

    /// Passes over `count` elements of `kinds` each.
    fn each(&mut self, count: u64, kinds: &[u8], depth: usize) -> Result<(), StructFault> {
        self.elements = self.elements.checked_sub(count).ok_or(StructFault::Endless)?;
        (0..count).try_for_each(|_| kinds.iter().try_for_each(|kind| self.skip(*kind, depth)))
    }

    fn byte(&mut self) -> Result<u8, StructFault> {
        let (first, rest) = self.bytes.split_first().ok_or(StructFault::Cut)?;
        self.bytes = rest;
        Ok(*first)
    }

    fn pass(&mut self, length: u64) -> Result<(), StructFault> {
        let length = usize::try_from(length).map_err(|_| StructFault::Broken)?;
        self.bytes = self.bytes.get(length..).ok_or(StructFault::Cut)?;
        Ok(())
    }

    /// Seven bits a byte, the lowest first.
    fn number(&mut self) -> Result<u64, StructFault> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(StructFault::Broken)
    }

    /// A number whose lowest bit is its sign.
    fn signed(&mut self) -> Result<i64, StructFault> {
        let number = self.number()?;
        Ok((number >> 1) as i64 ^ -((number & 1) as i64))
    }
}

fn nibbles(byte: u8) -> (u8, u8) {
    (byte >> 4, byte & 15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_says_how_long_its_page_is() {
        // Fields 1 (i32, 0), 2 (i32, 100), 3 (i32, 300), 5 (struct with an i64), stop; then the page.
        let bytes = [0x15, 0, 0x15, 200, 1, 0x15, 216, 4, 0x2c, 0x16, 2, 0, 0, 99];
        let mut walk = ThriftRemainder::new(&bytes);
        assert_eq!((walk.header(), walk.bytes), (Ok(300), &[99][..]));
    }

    #[test]
    fn lists_of_more_than_there_is_are_refused() {
        // Field 1: a list of 2^31 - 1 truth values, of bytes, a map, a list of such lists.
        assert_eq!(
            ThriftRemainder::new(&[0x19, 0xf1, 255, 255, 255, 255, 7, 0]).header(),
            Err(StructFault::Endless)
        );
        assert_eq!(
            ThriftRemainder::new(&[0x19, 0xf3, 255, 255, 255, 255, 7, 0]).header(),
            Err(StructFault::Endless)
        );
        assert_eq!(
            ThriftRemainder::new(&[0x1b, 255, 255, 255, 255, 7, 0x11, 0]).header(),
            Err(StructFault::Endless)
        );
        assert_eq!(
            ThriftRemainder::new(&[0x19, 0x29, 0xa1, 0xa1, 0, 0, 0, 0]).header(),
            Err(StructFault::Endless)
        );
        let page = [0x15, 0, 0x15, 0, 0x15, 8, 0x19, 0x31, 0];
        assert_eq!(ThriftRemainder::new(&page).header(), Ok(4));
    }

    #[test]
    fn what_is_cut_or_broken_is_told_apart() {
        for bytes in [&[][..], &[0x15], &[0x18, 200, 1], &[0x19, 0x1c]] {
            assert_eq!(ThriftRemainder::new(bytes).header(), Err(StructFault::Cut), "{bytes:?}");
        }
        // The last two: no field, no compressed size.
        for bytes in [&[0x1e][..], &[0x1c; 4096], &[0], &[0x15, 0, 0x15, 0, 0]] {
            assert_eq!(ThriftRemainder::new(bytes).header(), Err(StructFault::Broken), "{bytes:?}");
        }
    }
}
