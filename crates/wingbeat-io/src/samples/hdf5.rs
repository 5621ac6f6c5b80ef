//! HDF5 files, and MATLAB files of version 7.3, which are such: numeric datasets with the path as name
//! and the attribute `unit` or `units`.

use std::collections::HashSet;

use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::group::Group;
use hdf5_reader::{ByteOrder, Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem};

use super::numbers::NumberKind;
use super::opened;
use super::table::{ArrayShape, SampleTable};
use crate::Error;

/// Deepest nesting of groups.
const DEEPEST: usize = 16;
/// Most groups of a file.
const MOST_GROUPS: usize = 4096;
/// Numbers that are read at once: 8 MiB of the longest kind.
const PART: usize = 1 << 20;
/// Largest chunk that is read, bytes.
const MOST_CHUNK: usize = 64 << 20;
/// Largest description of an object that is read, bytes.
const MOST_HEADER: usize = 4 << 20;
/// Numbers that a byte of a file can hold at most: those of deflate, 1032 times its length (RFC 1951), and some more.
const MOST_PER_BYTE: u64 = 1100;

/// Every numeric dataset of one or two dimensions.
pub fn read(mut table: SampleTable) -> Result<SampleTable, Error> {
    let path = table.path.clone();
    let bad = |error: Hdf5Error| Error::format(&path, format!("cut short or damaged: {error}"));
    let (_, length) = opened(&path)?;
    let options = OpenOptions::default()
        .with_max_read_bytes(8 * PART + MOST_CHUNK)
        .with_max_chunk_bytes(MOST_CHUNK)
        .with_max_object_header_bytes(MOST_HEADER);
    let file = Hdf5File::open_with_options(&path, options).map_err(bad)?;
    let root = file.root_group().map_err(bad)?;
    let mut walk = GroupWalk { table: &mut table, seen: HashSet::from([root.address()]), length };
    walk.group(&root, "", 0)?;
    Ok(table)
}

/// The way through the groups: each is entered once, by whatever names it has.
struct GroupWalk<'a> {
    table: &'a mut SampleTable,
    /// Groups by their addresses.
    seen: HashSet<u64>,
    /// Bytes of the file.
    length: u64,
}

impl GroupWalk<'_> {
    fn group(&mut self, group: &Group, at: &str, depth: usize) -> Result<(), Error> {
        let members = group.members();
        let (groups, datasets) =
            members.map_err(|error| self.table.bad(format!("group /{at}: cut short or damaged: {error}")))?;
        if self.seen.len() + groups.len() > MOST_GROUPS {
            return Err(self.table.bad(format!("more than {MOST_GROUPS} groups")));
        }
        for member in &datasets {
            dataset(self.table, member, &joined(at, member.name()), self.length)?;
        }
        // MATLAB keeps the contents of cells there.
        for member in groups.iter().filter(|group| group.name() != "#refs#") {
            if !self.seen.insert(member.address()) {
                continue;
            }
            let name = joined(at, member.name());
            match depth < DEEPEST {
                true => self.group(member, &name, depth + 1)?,
                false => self.table.skipped.push(name),
            }
        }
        Ok(())
    }
}

fn joined(at: &str, name: &str) -> String {
    let name = name.trim_matches('/');
    let last = name.rsplit('/').next().unwrap_or(name);
    if at.is_empty() { last.into() } else { format!("{at}/{last}") }
}

fn dataset(table: &mut SampleTable, dataset: &Dataset, name: &str, length: u64) -> Result<(), Error> {
    let Some((kind, shape)) = plain(dataset) else {
        table.skipped.push(name.into());
        return Ok(());
    };
    let bytes = (shape.rows as u64).saturating_mul(shape.columns as u64).saturating_mul(kind.size() as u64);
    if bytes > length.saturating_mul(MOST_PER_BYTE) {
        let ArrayShape { rows, columns } = shape;
        return Err(table.bad(format!(
            "dataset {name}: {rows} x {columns} numbers do not fit into a file of {length} bytes: damaged"
        )));
    }
    let numbers = DatasetParts::of(dataset, shape);
    let (unit, mut failed) = (unit(dataset), None);
    let numbers = numbers.map_while(|part| part.map_err(|error| failed = Some(error)).ok()).flatten();
    let added = table.add(name, &unit, shape, numbers);
    match failed {
        Some(error) => Err(table.bad(format!("dataset {name}: cut short or damaged: {error}"))),
        None => added,
    }
}

/// A dataset some rows, or some numbers of a long row, at a time.
struct DatasetParts<'a> {
    dataset: &'a Dataset,
    shape: ArrayShape,
    /// Row and number in it that come next.
    next: (usize, usize),
}

impl<'a> DatasetParts<'a> {
    fn of(dataset: &'a Dataset, shape: ArrayShape) -> Self {
        Self { dataset, shape, next: (0, 0) }
    }

    /// The rows and columns that come next.
    fn advance(&mut self) -> Option<[std::ops::Range<usize>; 2]> {
        let (row, column) = self.next;
        let ArrayShape { rows, columns } = self.shape;
        if row >= rows || columns == 0 {
            return None;
        }
        let (end, last) = match PART / columns {
            0 => (row + 1, (column + PART).min(columns)),
            some => ((row + some).min(rows), columns),
        };
        self.next = if last == columns { (end, 0) } else { (row, last) };
        Some([row..end, column..last])
    }

    fn part(&self, block: [std::ops::Range<usize>; 2]) -> Result<Vec<f64>, Hdf5Error> {
        let dimensions = self.dataset.ndim();
        let plain = |number: &Number| number.0;
        if dimensions == 0 {
            return Ok(self.dataset.read_array::<Number>()?.iter().map(plain).collect());
        }
        let all = |range: std::ops::Range<usize>| SliceInfoElem::Slice {
            start: range.start as u64,
            end: range.end as u64,
            step: 1,
        };
        let selection = SliceInfo { selections: block.into_iter().take(dimensions).map(all).collect() };
        Ok(self.dataset.read_slice::<Number>(&selection)?.iter().map(plain).collect())
    }
}

impl Iterator for DatasetParts<'_> {
    type Item = Result<Vec<f64>, Hdf5Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let block = self.advance()?;
        Some(self.part(block))
    }
}

/// A number as it is kept, whatever its kind: the reader's code, which is long, is compiled for it alone.
#[derive(Clone, Copy)]
struct Number(f64);

impl H5Type for Number {
    fn hdf5_type() -> Datatype {
        Datatype::FloatingPoint { size: 8, byte_order: ByteOrder::LittleEndian }
    }

    fn from_bytes(bytes: &[u8], dtype: &Datatype) -> Result<Self, Hdf5Error> {
        let stored = stored(dtype).filter(|(kind, _)| kind.size() <= bytes.len());
        let Some((kind, big_endian)) = stored else {
            return Err(Hdf5Error::InvalidData(format!("{} bytes are no number of {dtype:?}", bytes.len())));
        };
        Ok(Self(kind.one(&bytes[..kind.size()], big_endian)))
    }

    fn element_size(dtype: &Datatype) -> usize {
        stored(dtype).map_or(8, |(kind, _)| kind.size())
    }

    fn decode_vec(raw: &[u8], dtype: &Datatype, count: usize) -> Option<Result<Vec<Self>, Hdf5Error>> {
        let (kind, big_endian) = stored(dtype)?;
        let raw = raw.get(..count.checked_mul(kind.size())?)?;
        Some(Ok(kind.read(raw, big_endian).into_iter().map(Self).collect()))
    }
}

/// How a dataset's numbers are stored: their kind, and whether their first byte counts most; none of others.
fn stored(dtype: &Datatype) -> Option<(NumberKind, bool)> {
    let (kind, order) = match dtype {
        Datatype::FixedPoint { size, signed: true, byte_order } => (NumberKind::Signed(*size), byte_order),
        Datatype::FixedPoint { size, signed: false, byte_order } => (NumberKind::Unsigned(*size), byte_order),
        Datatype::FloatingPoint { size, byte_order } => (NumberKind::Float(*size), byte_order),
        _ => return None,
    };
    Some((kind.checked()?, *order == ByteOrder::BigEndian))
}

/// Kind and shape of a dataset of plain numbers in at most two dimensions.
fn plain(dataset: &Dataset) -> Option<(NumberKind, ArrayShape)> {
    let (kind, _) = stored(dataset.dtype())?;
    let size = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let shape = match dataset.shape() {
        [] => ArrayShape { rows: 1, columns: 1 },
        [n] => ArrayShape { rows: size(*n), columns: 1 },
        [n, m] => ArrayShape { rows: size(*n), columns: size(*m) },
        _ => return None,
    };
    Some((kind, shape))
}

/// The attribute that says the unit.
fn unit(dataset: &Dataset) -> String {
    let named = |name: &str| dataset.attribute(name).ok()?.read_string().ok();
    let text = named("unit").or_else(|| named("units")).unwrap_or_default();
    text.trim_matches(['\0', ' ']).into()
}
