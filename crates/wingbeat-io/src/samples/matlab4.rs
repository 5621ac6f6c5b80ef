//! MATLAB files of level 4 (MathWorks, MAT-File Format, "Level 4 MAT-File Format"): matrices with a header of five
//! words (type, rows, columns, whether complex, length of the name), the name and a zero, then the numbers column by
//! column, the imaginary part after the real one.

use std::io::{BufReader, Read, Seek, SeekFrom};

use super::numbers::NumberKind;
use super::opened;
use super::table::{ArrayShape, SampleTable};
use crate::Error;

/// Bytes of the header.
const HEADER: usize = 20;
/// Longest name with its zero, bytes: names of MATLAB have 63 letters at most.
const MOST_NAME: usize = 64;

/// What stands before the numbers of a matrix.
struct Header {
    big_endian: bool,
    kind: NumberKind,
    /// Numbers; others are text or sparse.
    numeric: bool,
    rows: usize,
    columns: usize,
    complex: bool,
    name: usize,
}

impl Header {
    /// The type is MOPT in decimal digits: byte order (0 little, 1 big), 0, precision, content (0 numbers).
    fn parse(bytes: &[u8]) -> Option<Self> {
        let bytes: &[u8; HEADER] = bytes.get(..HEADER)?.try_into().ok()?;
        let words = |big: bool| -> [u32; 5] {
            std::array::from_fn(|i| {
                let word = [bytes[4 * i], bytes[4 * i + 1], bytes[4 * i + 2], bytes[4 * i + 3]];
                if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) }
            })
        };
        let (big_endian, [kind, rows, columns, complex, name]) = match (words(false), words(true)) {
            (words, _) if words[0] < 100 => (false, words),
            (_, words) if (1000..1100).contains(&words[0]) => (true, words),
            _ => return None,
        };
        let precision = match kind % 1000 / 10 {
            0 => NumberKind::Float(8),
            1 => NumberKind::Float(4),
            2 => NumberKind::Signed(4),
            3 => NumberKind::Signed(2),
            4 => NumberKind::Unsigned(2),
            5 => NumberKind::Unsigned(1),
            _ => return None,
        };
        let content = kind % 10;
        let known = content <= 2 && complex <= 1 && (2..=MOST_NAME as u32).contains(&name);
        known.then_some(Self {
            big_endian,
            kind: precision,
            numeric: content == 0,
            rows: rows as usize,
            columns: columns as usize,
            complex: complex == 1,
            name: name as usize,
        })
    }

    /// Bytes of the numbers.
    fn size(&self) -> Option<u64> {
        let parts = if self.complex { 2 } else { 1 };
        let count = (self.rows as u64).checked_mul(self.columns as u64)?;
        count.checked_mul(parts * self.kind.size() as u64)
    }
}

/// True of a file that begins with a matrix of level 4.
pub fn begins(head: &[u8]) -> bool {
    let name = Header::parse(head).and_then(|header| name(head.get(HEADER..HEADER + header.name)?));
    name.is_some()
}

/// A name: letters, digits and underscores, a letter first, a zero behind.
fn name(bytes: &[u8]) -> Option<String> {
    let (0, letters) = bytes.split_last()? else { return None };
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let good = letters.first()?.is_ascii_alphabetic() && letters.iter().all(plain);
    good.then(|| String::from_utf8_lossy(letters).into_owned())
}

/// Every matrix of numbers of a file.
pub fn read(mut table: SampleTable) -> Result<SampleTable, Error> {
    let (file, length) = opened(&table.path)?;
    let path = table.path.clone();
    let mut file = BufReader::new(file);
    let (mut at, mut number) = (0_u64, 0);
    while at < length {
        number += 1;
        let cut = |what: &str| Error::format(&path, format!("matrix {number}: cut short in its {what}"));
        file.seek(SeekFrom::Start(at)).map_err(|source| Error::file(&path, source))?;
        let mut bytes = [0; HEADER];
        file.read_exact(&mut bytes).map_err(|_| cut("header"))?;
        let header = Header::parse(&bytes).ok_or_else(|| cut("header, or damaged"))?;
        let mut letters = vec![0; header.name];
        file.read_exact(&mut letters).map_err(|_| cut("name"))?;
        let name = name(&letters).ok_or_else(|| cut("name, or damaged"))?;
        let begin = at + (HEADER + header.name) as u64;
        let end = header.size().and_then(|size| begin.checked_add(size));
        if header.numeric && !header.complex {
            // Columns follow one another: rows of the transpose.
            let shape = ArrayShape { rows: header.columns, columns: header.rows };
            let numbers = header.kind.stream((&mut file).take(length - begin), header.big_endian);
            table.add(&name, "", shape, numbers)?;
        } else {
            table.skipped.push(name);
        }
        at = end.filter(|end| *end <= length).ok_or_else(|| cut("numbers"))?;
    }
    Ok(table)
}
