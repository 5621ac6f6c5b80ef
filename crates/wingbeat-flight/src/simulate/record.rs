//! The border between computing and looking: named columns with units and frames.

use wingbeat_math::Error;
use wingbeat_ocp::plant::{Channel, Fault};

/// Largest difference of the time of a record from that of an update, s. *Choice*: rounding alone.
const ROUNDING: f64 = 1e-9;

/// Whether a record of the time `t` is that of an update at the time `update`, both in s.
pub fn is_at(t: f64, update: f64) -> bool {
    (t - update).abs() < ROUNDING
}

/// One named column of a [`Record`].
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, unique within its record, e.g. `p_WB_x`.
    pub name: String,
    /// SI unit, e.g. `m`; empty when dimensionless.
    pub unit: String,
    /// Frame in which the number is resolved, e.g. `W`; empty when it has none.
    pub frame: String,
    /// Lower limit of the number, in `unit`; minus infinity when it has none.
    pub low: f64,
    /// Upper limit of the number, in `unit`; infinity when it has none.
    pub high: f64,
    /// The numbers, one per row, in `unit`.
    pub values: Vec<f64>,
}

impl Column {
    /// An empty column without limits.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, frame: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
            frame: frame.into(),
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            values: Vec::new(),
        }
    }
}

impl From<&Channel> for Column {
    fn from(channel: &Channel) -> Self {
        let column = Self::new(channel.name.clone(), channel.unit, channel.frame);
        Self { low: channel.low, high: channel.high, ..column }
    }
}

/// A run as a table: columns of equal length, one row per recorded instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    columns: Vec<Column>,
}

impl Record {
    /// The key of the refusal of a column that comes twice.
    pub const COLUMN: &str = "record.column";

    /// A record of `columns` with room for `rows` rows.
    ///
    /// # Errors
    /// Two columns of one name, or columns of different length.
    pub fn new(mut columns: Vec<Column>, rows: usize) -> Result<Self, Error> {
        for (index, column) in columns.iter().enumerate() {
            if columns[..index].iter().any(|earlier| earlier.name == column.name) {
                return Err(Error::invalid(Self::COLUMN, &column.name, "each name once"));
            }
            if column.values.len() != columns[0].values.len() {
                let rows = columns[0].values.len();
                let key = format!("record.{}.rows", column.name);
                return Err(Error::invalid(
                    key,
                    column.values.len(),
                    format!("{rows}, as in the first column"),
                ));
            }
        }
        for column in &mut columns {
            column.values.reserve_exact(rows.saturating_sub(column.values.len()));
        }
        Ok(Self { columns })
    }

    /// Appends a row: one number per column, in order and in the units of the columns. Allocates nothing while the room lasts.
    ///
    /// # Panics
    /// When `row` has not one number per column.
    pub fn append(&mut self, row: &[f64]) {
        assert_eq!(row.len(), self.columns.len(), "a row has one number per column");
        for (column, &value) in self.columns.iter_mut().zip(row) {
            column.values.push(value);
        }
    }

    /// Appends a row as [`append`](Self::append) does, its first number the time, unless one is not finite.
    ///
    /// # Errors
    /// [`Fault::NotRecorded`] with the column.
    ///
    /// # Panics
    /// When `row` has not one number per column.
    pub fn append_finite(&mut self, row: &[f64]) -> Result<(), Fault> {
        match row.iter().position(|value| !value.is_finite()) {
            Some(column) => Err(Fault::NotRecorded { column, time: row[0] }),
            None => {
                self.append(row);
                Ok(())
            }
        }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The columns, in order.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The columns alone.
    pub fn into_columns(self) -> Vec<Column> {
        self.columns
    }

    /// The first `rows` rows.
    pub fn head(&self, rows: usize) -> Self {
        let short = |column: &Column| Column {
            values: column.values[..rows.min(column.values.len())].to_vec(),
            name: column.name.clone(),
            unit: column.unit.clone(),
            frame: column.frame.clone(),
            ..*column
        };
        Self { columns: self.columns.iter().map(short).collect() }
    }

    /// The column called `name`.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// The numbers of the column called `name`, in its unit.
    pub fn values(&self, name: &str) -> Option<&[f64]> {
        self.column(name).map(|column| column.values.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two() -> Vec<Column> {
        vec![Column::new("t", "s", ""), Column::new("p_WB_x", "m", "W")]
    }

    #[test]
    fn rows_are_appended_within_the_room_reserved() {
        let mut record = Record::new(two(), 3).unwrap();
        let room = record.columns[1].values.as_ptr();
        for i in 0..3 {
            record.append(&[f64::from(i), f64::from(10 * i)]);
        }
        assert_eq!(record.columns[1].values.as_ptr(), room);
        assert_eq!(record.rows(), 3);
        assert_eq!(record.values("p_WB_x"), Some([0.0, 10.0, 20.0].as_slice()));
        assert_eq!(record.values("p_WB_y"), None);
    }

    #[test]
    fn a_channel_hands_its_limits_to_its_column() {
        let column = Column::from(&Channel::limited("stroke", "rad", "", -0.3, 0.4));
        assert_eq!((column.low, column.high, column.unit.as_str()), (-0.3, 0.4, "rad"));
    }

    #[test]
    fn names_are_unique_and_lengths_equal() {
        let twice = vec![Column::new("t", "s", ""), Column::new("t", "s", "")];
        assert!(Record::new(twice, 0).unwrap_err().to_string().contains("each name once"));
        let mut ragged = two();
        ragged[1].values.push(1.0);
        assert!(Record::new(ragged, 0).unwrap_err().to_string().contains("record.p_WB_x.rows = 1"));
    }
}
