//! HDF5 files, and MATLAB files of version 7.3, which are such: numeric datasets with the path as name
//! and the attribute `unit` or `units`.

use std::collections::HashSet;

use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, H5Type, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem};

use super::numbers::Kind;
use super::opened;
use super::table::{Shape, Table};
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
pub fn read(mut table: Table) -> Result<Table, Error> {
    let path = table.path.clone();
    let bad = |error: Hdf5Error| Error::format(&path, format!("cut short or damaged: {error}"));
    let (_, length) = opened(&path)?;
    let options = OpenOptions::default()
        .with_max_read_bytes(8 * PART + MOST_CHUNK)
        .with_max_chunk_bytes(MOST_CHUNK)
        .with_max_object_header_bytes(MOST_HEADER);
    let file = Hdf5File::open_with_options(&path, options).map_err(bad)?;
    let root = file.root_group().map_err(bad)?;
    let mut walk = Walk { table: &mut table, seen: HashSet::from([root.address()]), length };
    walk.group(&root, "", 0)?;
    Ok(table)
}

/// The way through the groups: each is entered once, by whatever names it has.
struct Walk<'a> {
    table: &'a mut Table,
    /// Groups by their addresses.
    seen: HashSet<u64>,
    /// Bytes of the file.
    length: u64,
}

impl Walk<'_> {
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

fn dataset(table: &mut Table, dataset: &Dataset, name: &str, length: u64) -> Result<(), Error> {
    let Some((kind, shape)) = plain(dataset) else {
        table.skipped.push(name.into());
        return Ok(());
    };
    let bytes = (shape.rows as u64).saturating_mul(shape.columns as u64).saturating_mul(kind.size() as u64);
    if bytes > length.saturating_mul(MOST_PER_BYTE) {
        let Shape { rows, columns } = shape;
        return Err(table.bad(format!(
            "dataset {name}: {rows} x {columns} numbers do not fit into a file of {length} bytes: damaged"
        )));
    }
    let numbers = Parts::of(dataset, kind, shape);
    let (unit, mut failed) = (unit(dataset), None);
    let numbers = numbers.map_while(|part| part.map_err(|error| failed = Some(error)).ok()).flatten();
    let added = table.add(name, &unit, shape, numbers);
    match failed {
        Some(error) => Err(table.bad(format!("dataset {name}: cut short or damaged: {error}"))),
        None => added,
    }
}

/// A dataset some rows, or some numbers of a long row, at a time.
struct Parts<'a> {
    dataset: &'a Dataset,
    kind: Kind,
    shape: Shape,
    /// Row and number in it that come next.
    next: (usize, usize),
}

impl<'a> Parts<'a> {
    fn of(dataset: &'a Dataset, kind: Kind, shape: Shape) -> Self {
        Self { dataset, kind, shape, next: (0, 0) }
    }

    /// The rows and columns that come next.
    fn advance(&mut self) -> Option<[std::ops::Range<usize>; 2]> {
        let (row, column) = self.next;
        let Shape { rows, columns } = self.shape;
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

    fn part<T: H5Type + Copy>(
        &self,
        block: [std::ops::Range<usize>; 2],
        to: impl Fn(T) -> f64,
    ) -> Result<Vec<f64>, Hdf5Error> {
        let dimensions = self.dataset.ndim();
        if dimensions == 0 {
            return Ok(self.dataset.read_array::<T>()?.iter().map(|value| to(*value)).collect());
        }
        let all = |range: std::ops::Range<usize>| SliceInfoElem::Slice {
            start: range.start as u64,
            end: range.end as u64,
            step: 1,
        };
        let selection = SliceInfo { selections: block.into_iter().take(dimensions).map(all).collect() };
        Ok(self.dataset.read_slice::<T>(&selection)?.iter().map(|value| to(*value)).collect())
    }
}

impl Iterator for Parts<'_> {
    type Item = Result<Vec<f64>, Hdf5Error>;

    fn next(&mut self) -> Option<Self::Item> {
        let block = self.advance()?;
        Some(match self.kind {
            Kind::Float(4) => self.part(block, |x: f32| f64::from(x)),
            Kind::Float(_) => self.part(block, |x: f64| x),
            Kind::Signed(1) => self.part(block, |x: i8| f64::from(x)),
            Kind::Signed(2) => self.part(block, |x: i16| f64::from(x)),
            Kind::Signed(4) => self.part(block, |x: i32| f64::from(x)),
            Kind::Signed(_) => self.part(block, |x: i64| x as f64),
            Kind::Unsigned(1) => self.part(block, |x: u8| f64::from(x)),
            Kind::Unsigned(2) => self.part(block, |x: u16| f64::from(x)),
            Kind::Unsigned(4) => self.part(block, |x: u32| f64::from(x)),
            Kind::Unsigned(_) => self.part(block, |x: u64| x as f64),
        })
    }
}

/// Kind and shape of a dataset of plain numbers in at most two dimensions.
fn plain(dataset: &Dataset) -> Option<(Kind, Shape)> {
    let kind = match dataset.dtype() {
        Datatype::FixedPoint { size, signed: true, .. } => Kind::Signed(*size),
        Datatype::FixedPoint { size, signed: false, .. } => Kind::Unsigned(*size),
        Datatype::FloatingPoint { size, .. } => Kind::Float(*size),
        _ => return None,
    };
    let size = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
    let shape = match dataset.shape() {
        [] => Shape { rows: 1, columns: 1 },
        [n] => Shape { rows: size(*n), columns: 1 },
        [n, m] => Shape { rows: size(*n), columns: size(*m) },
        _ => return None,
    };
    Some((kind.checked()?, shape))
}

/// The attribute that says the unit.
fn unit(dataset: &Dataset) -> String {
    let named = |name: &str| dataset.attribute(name).ok()?.read_string().ok();
    let text = named("unit").or_else(|| named("units")).unwrap_or_default();
    text.trim_matches(['\0', ' ']).into()
}
