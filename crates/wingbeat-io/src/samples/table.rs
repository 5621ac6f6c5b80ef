//! What a file of samples holds: the columns that are of use, with the names and units that the file gives them.

use std::path::{Path, PathBuf};

use wingbeat::simulate::Column;

use super::resolve::WantedColumns;
use crate::{Error, MOST_COLUMNS, MOST_NUMBERS};

/// Room made at once for a column that may be claimed longer than it is.
const PREPARED: usize = 1 << 16;

/// What a file of samples holds.
#[derive(Clone, Debug, Default)]
pub struct SampleTable {
    /// The file.
    pub path: PathBuf,
    /// Its layout, in words.
    pub layout: &'static str,
    /// Columns that are wanted; their lengths may differ.
    pub columns: Vec<Column>,
    /// Names of all columns of numbers, wanted or not.
    pub names: Vec<String>,
    /// What else is there, without numbers or of more than two dimensions.
    pub skipped: Vec<String>,
    /// What of the columns that are wanted was left out, in words.
    pub cautions: Vec<String>,
    /// Samples per second, Hz, where the file says it.
    pub rate: Option<f64>,
    /// True when records may stand in another order than they were measured.
    pub unordered: bool,
    pub(super) wanted: WantedColumns,
}

/// An array of one or two dimensions whose numbers come row by row: the longer dimension is time.
#[derive(Clone, Copy, Debug)]
pub struct ArrayShape {
    /// Rows as stored.
    pub rows: usize,
    /// Numbers of each row.
    pub columns: usize,
}

impl ArrayShape {
    /// Columns of the table that it makes.
    fn series(self) -> usize {
        match self {
            Self { rows: 0 | 1, .. } | Self { columns: 0 | 1, .. } => 1,
            _ => self.rows.min(self.columns),
        }
    }

    /// Numbers of all.
    pub fn count(self) -> Option<usize> {
        self.rows.checked_mul(self.columns)
    }

    /// Samples of each.
    fn length(self) -> usize {
        if self.series() == 1 { self.rows * self.columns } else { self.rows.max(self.columns) }
    }

    /// Series and sample of the number `k`.
    fn place(self, k: usize) -> (usize, usize) {
        match self.series() {
            1 => (0, k),
            _ if self.rows >= self.columns => (k % self.columns, k / self.columns),
            _ => (k / self.columns, k % self.columns),
        }
    }
}

impl SampleTable {
    pub(super) fn new(path: &Path, layout: &'static str, wanted: WantedColumns) -> Self {
        Self { path: path.into(), layout, wanted, ..Self::default() }
    }

    pub(super) fn bad(&self, what: impl ToString) -> Error {
        Error::format(&self.path, what)
    }

    /// Takes note of an array: the names of its columns, and which of them are wanted.
    ///
    /// # Errors
    /// More columns, or more numbers, than are read.
    pub(super) fn announce(&mut self, name: &str, shape: ArrayShape) -> Result<Vec<Option<usize>>, Error> {
        let ArrayShape { rows, columns } = shape;
        let most = 4 * MOST_NUMBERS;
        if shape.count().is_none_or(|count| count > most) {
            return Err(self.bad(format!("{name}: {rows} x {columns} numbers; read are at most {most}")));
        }
        let series = shape.series();
        if self.names.len() + series > MOST_COLUMNS {
            return Err(self.bad(format!("{name}: the file has more than {MOST_COLUMNS} columns")));
        }
        let part = |k: usize| if series == 1 { name.to_owned() } else { format!("{name}[{k}]") };
        let wanted = (0..series).filter(|k| self.wanted.wants(&part(*k))).count();
        self.room(name, wanted * shape.length())?;
        let mut targets = Vec::with_capacity(series);
        for name in (0..series).map(part) {
            let wanted = self.wanted.wants(&name);
            targets.push(wanted.then_some(self.columns.len()));
            if wanted {
                let mut column = Column::new(name.clone(), "", "");
                column.values.reserve(shape.length().min(PREPARED));
                self.columns.push(column);
            }
            self.names.push(name);
        }
        Ok(targets)
    }

    /// Refuses so many numbers more than there is room for beside those that are there.
    fn room(&self, name: &str, more: usize) -> Result<(), Error> {
        let held: usize = self.columns.iter().map(|column| column.values.len()).sum();
        match more <= MOST_NUMBERS.saturating_sub(held) {
            true => Ok(()),
            false => Err(self.bad(format!("{name}: the file has more than {MOST_NUMBERS} numbers of use"))),
        }
    }

    /// Adds an array of this unit whose `numbers` come row by row; those of no use are not taken.
    ///
    /// # Errors
    /// Those of [`announce`](Self::announce), or numbers that end too soon.
    pub(super) fn add(
        &mut self,
        name: &str,
        unit: &str,
        shape: ArrayShape,
        numbers: impl IntoIterator<Item = f64>,
    ) -> Result<(), Error> {
        let targets = self.announce(name, shape)?;
        if targets.iter().all(Option::is_none) {
            return Ok(());
        }
        for column in targets.iter().flatten() {
            self.columns[*column].unit = unit.into();
        }
        let (count, mut taken) = (shape.rows * shape.columns, 0);
        for value in numbers.into_iter().take(count) {
            if let Some(column) = targets[shape.place(taken).0] {
                self.columns[column].values.push(value);
            }
            taken += 1;
        }
        if taken == count {
            return Ok(());
        }
        Err(self.cut(name, shape, taken))
    }

    /// An array of which only so many numbers are there.
    pub(super) fn cut(&self, name: &str, shape: ArrayShape, there: usize) -> Error {
        let ((series, sample), length) = (shape.place(there), shape.length());
        let of = if shape.series() > 1 { format!("{name}[{series}]") } else { name.into() };
        self.bad(format!("{name}: cut short at sample {sample} of {length} of {of}, or damaged there"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat::rig::process::InputSpec;

    fn table() -> SampleTable {
        SampleTable::new(Path::new("a.npy"), "test", WantedColumns::of(&InputSpec::default()))
    }

    #[test]
    fn the_longer_dimension_is_time_however_it_is_stored() {
        let mut input = InputSpec::default();
        input.columns.insert("Fx".into(), "w[1]".into());
        for (shape, numbers) in [
            (ArrayShape { rows: 3, columns: 2 }, [1.0, 10.0, 2.0, 20.0, 3.0, 30.0]),
            (ArrayShape { rows: 2, columns: 3 }, [1.0, 2.0, 3.0, 10.0, 20.0, 30.0]),
        ] {
            let mut table = SampleTable::new(Path::new("a.npy"), "test", WantedColumns::of(&input));
            table.add("w", "N", shape, numbers).unwrap();
            assert_eq!(table.names, ["w[0]", "w[1]"]);
            assert_eq!((table.columns.len(), table.columns[0].unit.as_str()), (1, "N"));
            assert_eq!(table.columns[0].values, [10.0, 20.0, 30.0]);
        }
    }

    #[test]
    fn the_place_of_a_cut_is_a_sample_of_a_column() {
        let mut table = table();
        table.wanted.names.push("fx[1]".into());
        let error = table.add("Fx", "", ArrayShape { rows: 6, columns: 48 }, vec![0.0; 75]).unwrap_err();
        assert!(error.to_string().contains("at sample 27 of 48 of Fx[1]"), "{error}");
    }

    #[test]
    fn claims_beyond_the_limits_take_no_memory() {
        let huge = [usize::MAX, 1 << 40, MOST_NUMBERS + 1];
        for rows in huge {
            let error = table().add("Fx", "", ArrayShape { rows, columns: 1 }, []).unwrap_err();
            assert!(error.to_string().contains("at most") || error.to_string().contains("more than"));
        }
        let wide = ArrayShape { rows: 5000, columns: 5000 };
        assert!(table().add("Fx", "", wide, []).unwrap_err().to_string().contains("columns"));
    }
}
