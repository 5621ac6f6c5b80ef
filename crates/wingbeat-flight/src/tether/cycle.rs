//! Means over the last cycle, and whether it repeats the one before.

use super::spar::STRAIN;
use crate::simulate::{Column, Record};
use std::ops::Range;

/// Mean and range of one quantity over the last cycle.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct CycleMean {
    /// Name of its column.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Mean, in the unit of the quantity.
    pub mean: f64,
    /// Smallest value, in the unit of the quantity.
    pub low: f64,
    /// Largest value, in the unit of the quantity.
    pub high: f64,
    /// Mean less that of the cycle before, in its unit; none where there is no cycle before.
    pub mean_change: Option<f64>,
    /// Half the range less that of the cycle before, in its unit; none where there is no cycle before.
    pub amplitude_change: Option<f64>,
}

impl CycleMean {
    /// Of a cycle whose end is in `values`: half of it and half of the begin count for the mean, so that it is of
    /// second order in the steps where the cycle does not close.
    fn of(column: &Column, values: &[f64]) -> Self {
        let ends = [values.first(), values.last()].into_iter().flatten().sum::<f64>() * 0.5;
        let steps = (values.len().max(2) - 1) as f64;
        let (low, high) =
            values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        Self {
            name: column.name.clone(),
            unit: column.unit.clone(),
            mean: (values.iter().sum::<f64>() - ends) / steps,
            low,
            high,
            mean_change: None,
            amplitude_change: None,
        }
    }

    /// Half the range, in the unit of the quantity.
    pub fn amplitude(&self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// The largest magnitude, in the unit of the quantity.
    pub fn largest(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    fn after(self, before: &Self) -> Self {
        let (mean, amplitude) = (self.mean - before.mean, self.amplitude() - before.amplitude());
        Self { mean_change: Some(mean), amplitude_change: Some(amplitude), ..self }
    }
}

/// How far the last cycle is from the one before.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Periodicity {
    /// Largest change of a mean or of half a range of the forces, moments, torques and powers from the last cycle but
    /// one to the last, each over the largest magnitude of any of its unit in the last; moments over a tenth of the largest force
    /// times the chord at least.
    pub change: f64,
    /// The column with that change.
    pub quantity: String,
}

/// Power over that of the forces at the speed of the wind below which it is none.
pub(super) const ROUNDING: f64 = 1e-9;

/// Moment over force and chord, dimensionless, below which a change of moments is measured by that: moments about the quarter chord are
/// what larger ones leave, and a hundredth of this is a centre of pressure that moves by a thousandth of the chord. *Choice.*
const LEAST_ARM: f64 = 0.1;

/// Units of what must repeat for a run to be periodic.
const LOADS: [&str; 3] = ["N", "N m", "W"];

impl Periodicity {
    /// Of the rows of the last cycle in a wind of `speed` m/s, of a wing of that `chord` (m); none where there is no cycle before or no load at all.
    pub(super) fn of(rows: &[CycleMean], speed: f64, chord: f64) -> Option<Self> {
        let of_unit = |unit: &'static str| rows.iter().filter(move |row| row.unit == unit);
        let largest = |unit| of_unit(unit).map(CycleMean::largest).fold(0.0, f64::max);
        let mut worst: Option<Self> = None;
        for unit in LOADS {
            let arm = if unit == "N m" { LEAST_ARM * chord } else { 0.0 };
            let scale = largest(unit).max(arm * largest("N"));
            // Of a wing at rest the power is what rounding leaves.
            let least = if unit == "W" { ROUNDING * largest("N") * speed } else { 0.0 };
            for row in of_unit(unit).filter(|_| scale > least) {
                let change = row.mean_change?.abs().max(row.amplitude_change?.abs()) / scale;
                if worst.as_ref().is_none_or(|worst| !(change <= worst.change)) {
                    worst = Some(Self { change, quantity: row.name.clone() });
                }
            }
        }
        worst
    }
}

/// Rows of the cycle `back` cycles before the end of `rows` rows, its end left out; none where the run is shorter.
pub(super) fn rows_of_cycle(rows: usize, steps: usize, back: usize) -> Option<Range<usize>> {
    let end = rows.checked_sub(1 + back * steps)?;
    (end >= steps).then(|| end - steps..end)
}

/// Means of the columns but those of a spar's coordinates over the last cycle, or over the rows there are, with their change from the one before.
pub(super) fn means(record: &Record, steps: usize) -> Vec<CycleMean> {
    let rows = record.rows();
    let closed = |cycle: Range<usize>| cycle.start..cycle.end + 1;
    let last = rows_of_cycle(rows, steps, 0).map_or(0..rows, closed);
    let before = rows_of_cycle(rows, steps, 1).map(closed);
    let of = |column: &Column| {
        let mean = CycleMean::of(column, &column.values[last.clone()]);
        match &before {
            Some(before) => mean.after(&CycleMean::of(column, &column.values[before.clone()])),
            None => mean,
        }
    };
    record.columns()[2..].iter().filter(|column| !column.name.starts_with(STRAIN)).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_cycle_is_compared_with_the_one_before() {
        let columns = [("t", "s"), ("phase", "cycles"), ("lift", "N"), ("thrust", "N"), ("surge", "m")];
        let columns = columns.map(|(name, unit)| Column::new(name, unit, "")).to_vec();
        let mut record = Record::new(columns, 9).unwrap();
        let lift = [9.0, 0.0, 0.0, 0.0, 2.0, 0.0, -2.0, 0.0, 2.0, 0.1, -1.9, 0.1, 2.1];
        for (i, lift) in lift.into_iter().enumerate() {
            record.append(&[i as f64, 0.0, lift, 0.01, i as f64]);
        }
        let rows = means(&record, 4);
        assert_eq!((rows[0].low, rows[0].high, rows[1].mean_change), (-1.9, 2.1, Some(0.0)));
        let found = Periodicity::of(&rows, 0.0, 1.0).unwrap();
        assert!((rows[0].mean - 0.0875).abs() < 1e-15, "{}", rows[0].mean);
        assert!((found.change - 0.0875 / 2.1).abs() < 1e-15 && found.quantity == "lift", "{found:?}");
        assert_eq!(Periodicity::of(&means(&record, 12), 0.0, 1.0), None);
    }

    /// A power of 1e-12 W of a wing that bears 2 N at 3 m/s is that of rounding; without wind it counts.
    #[test]
    fn a_power_of_rounding_does_not_change() {
        let columns = [("t", "s"), ("phase", "cycles"), ("lift", "N"), ("power", "W")];
        let mut record =
            Record::new(columns.map(|(name, unit)| Column::new(name, unit, "")).to_vec(), 9).unwrap();
        for i in 0..9 {
            record.append(&[f64::from(i), 0.0, 2.0, if i < 5 { 1e-12 } else { -3e-12 }]);
        }
        let change = |speed: f64| Periodicity::of(&means(&record, 4), speed, 1.0).unwrap().change;
        assert_eq!(change(3.0), 0.0);
        assert!(change(0.0) > 0.5);
    }

    /// Moments of 1e-13 N m of a wing that bears 2 N on a chord of .1 m are rounding, those of 1e-3 N m are not.
    #[test]
    fn a_moment_of_rounding_does_not_change() {
        let columns = [("t", "s"), ("phase", "cycles"), ("lift", "N"), ("moment", "N m")];
        let columns = columns.map(|(name, unit)| Column::new(name, unit, "")).to_vec();
        let change = |moment: f64| {
            let mut record = Record::new(columns.clone(), 9).unwrap();
            for i in 0..9 {
                record.append(&[f64::from(i), 0.0, 2.0, if i < 5 { moment } else { -3.0 * moment }]);
            }
            Periodicity::of(&means(&record, 4), 3.0, 0.1).unwrap().change
        };
        assert!(change(1e-13) < 1e-8 && change(1e-3) > 0.1 && change(1e-5) < 0.01);
    }
}
