//! Quantities of a flight's summary that follow from its record, a file each.
//!
//! One new file and its line in the list bring a quantity into `summary.json` and its schema, the printed table, the numbers that a search may
//! ask of flights, and, where it says so, the rows of sweeps.

use serde::ser::{Serialize, SerializeMap, Serializer};

use super::summary::Settled;

/// Declares the modules of a list and the table of what they hold.
macro_rules! measures {
    ($($module:ident,)+) => {
        $(pub(crate) mod $module;)+

        /// All quantities, in the order of the file.
        const ALL: &[&[Measure]] = &[$($module::MEASURES),+];
    };
}

measures! {
    asked_speed,
    joint_power,
    motor,
}

/// A number that a record tells of a flight.
pub struct Measure {
    /// Its key in `summary.json`; the unit ends it (`_w`, `_m_s`).
    pub key: &'static str,
    /// What it is, for the schema.
    pub meaning: &'static str,
    /// Its line of the printed table: what, digits after the point, unit with a remark; none is printed without one.
    pub line: Option<(&'static str, usize, &'static str)>,
    /// Whether the file has the key, as null, where there is no value.
    pub always: bool,
    /// Its column in the rows of a sweep with its unit; none without one.
    pub swept: Option<(&'static str, &'static str)>,
    /// The value from the samples that count; none where the record does not tell it.
    pub(super) value: fn(&Settled<'_>) -> Option<f64>,
}

/// The table as one list.
pub fn measures() -> impl Iterator<Item = &'static Measure> {
    ALL.iter().copied().flatten()
}

/// The quantities of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured(Vec<Option<f64>>);

impl Measured {
    pub(super) fn new(settled: &Settled<'_>) -> Self {
        Self(measures().map(|measure| (measure.value)(settled)).collect())
    }

    /// Each quantity with its value, in its unit.
    pub fn iter(&self) -> impl Iterator<Item = (&'static Measure, Option<f64>)> {
        measures().zip(self.0.iter().copied())
    }

    /// The value of a key of the table, in the unit that ends the key.
    pub fn get(&self, key: &str) -> Option<f64> {
        self.iter().find(|(measure, _)| measure.key == key).and_then(|(_, value)| value)
    }
}

impl Serialize for Measured {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (measure, value) in self.iter().filter(|(measure, value)| measure.always || value.is_some()) {
            map.serialize_entry(measure.key, &value)?;
        }
        map.end()
    }
}
