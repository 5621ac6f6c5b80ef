//! HDF5 files, and MATLAB files of version 7.3, which are such: numeric datasets with the path as name
//! and the attribute `unit` or `units`.

use std::path::Path;

use hdf5_reader::error::Error as Hdf5Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File, OpenOptions};

use super::numbers::Kind;
use super::{MOST_NUMBERS, Table};
use crate::Error;

/// Deepest nesting of groups.
const DEEPEST: usize = 16;
/// Most datasets of a file.
const MOST_DATASETS: usize = 4096;

/// Every numeric dataset of one or two dimensions.
pub fn read(path: &Path) -> Result<Table, Error> {
    let mut table = Table::new(path, "HDF5");
    let bad = |error: Hdf5Error| Error::format(path, format!("cut short or damaged: {error}"));
    let options = OpenOptions::default().with_max_read_bytes(8 * MOST_NUMBERS);
    let file = Hdf5File::open_with_options(path, options).map_err(bad)?;
    group(&mut table, &file.root_group().map_err(bad)?, "", 0)?;
    Ok(table)
}

fn group(table: &mut Table, group: &Group, at: &str, depth: usize) -> Result<(), Error> {
    let bad =
        |error: Hdf5Error| Error::format(&table.path, format!("group /{at}: cut short or damaged: {error}"));
    let (groups, datasets) = group.members().map_err(bad)?;
    for member in datasets {
        dataset(table, &member, &joined(at, member.name()))?;
    }
    // MATLAB keeps the contents of cells there.
    for member in groups.iter().filter(|group| group.name() != "#refs#") {
        let name = joined(at, member.name());
        match depth < DEEPEST {
            true => self::group(table, member, &name, depth + 1)?,
            false => table.skipped.push(name),
        }
    }
    Ok(())
}

fn joined(at: &str, name: &str) -> String {
    let name = name.trim_matches('/');
    let last = name.rsplit('/').next().unwrap_or(name);
    if at.is_empty() { last.into() } else { format!("{at}/{last}") }
}

fn dataset(table: &mut Table, dataset: &Dataset, name: &str) -> Result<(), Error> {
    let Some((kind, shape)) = plain(dataset) else {
        table.skipped.push(name.into());
        return Ok(());
    };
    table.room(name, shape)?;
    if table.columns.len() > MOST_DATASETS {
        return Err(table.bad(format!("more than {MOST_DATASETS} datasets")));
    }
    let data = dataset.read_native_bytes();
    let data = data.map_err(|error| table.bad(format!("dataset {name}: cut short or damaged: {error}")))?;
    let values = kind.read(&data, cfg!(target_endian = "big"));
    table.add(name, &unit(dataset), shape, values);
    Ok(())
}

/// Kind and shape of a dataset of plain numbers in at most two dimensions.
fn plain(dataset: &Dataset) -> Option<(Kind, (usize, usize))> {
    let kind = match dataset.dtype() {
        Datatype::FixedPoint { size, signed: true, .. } => Kind::Signed(*size),
        Datatype::FixedPoint { size, signed: false, .. } => Kind::Unsigned(*size),
        Datatype::FloatingPoint { size, .. } => Kind::Float(*size),
        _ => return None,
    };
    let shape = match dataset.shape() {
        [] => (1, 1),
        [n] => (*n as usize, 1),
        [n, m] => (*n as usize, *m as usize),
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
