//! The errors of a flight under a controller: the true motion beside what was asked, whatever the controller is told of it.

use std::ops::Range;
use wingbeat_flight::guide::{PathSpec, angle_error};
use wingbeat_flight::simulate::{Record, is_at};
use wingbeat_math::Vec3;

/// Part of a period that rounding takes from a whole one, dimensionless. *Choice.*
const ROUNDING: f64 = 1e-9;

/// The updates of a flight's controller, the first at its start. Where it ends there is none.
#[derive(Clone, Copy)]
pub(super) struct Updates {
    /// Time between two, s.
    pub period: f64,
    /// How many there were.
    pub count: usize,
}

impl Updates {
    /// Those of the `rows` of `record` that are at an update.
    pub fn rows(self, record: &Record, rows: Range<usize>) -> Vec<usize> {
        let t = record.values("t").unwrap_or_default();
        let updated = |row: &usize| {
            let number = (t[*row] / self.period).round();
            number < self.count as f64 && is_at(t[*row], number * self.period)
        };
        (rows.start..rows.end.min(t.len())).filter(updated).collect()
    }
}

/// An update that a record knows of.
struct Sighting {
    /// The record at it or the first after it, where what it asks stands.
    row: usize,
    /// Shares of the records from this one on that give the true motion at it.
    from: usize,
    shares: Vec<f64>,
}

impl Sighting {
    /// The record `row` as it is.
    fn at(row: usize) -> Self {
        Self { row, from: row, shares: vec![1.0] }
    }

    /// The time `update`, s, before the record `row`: a cubic through two records on either side of it, of the times `t`, s.
    fn before(t: &[f64], row: usize, update: f64) -> Self {
        let from = row.saturating_sub(2);
        let end = if row + 1 < t.len() && !is_at(t[row + 1], t[row]) { row + 2 } else { row + 1 };
        let share = |i: usize| {
            let others = (from..end).filter(|j| *j != i);
            others.map(|j| (update - t[j]) / (t[i] - t[j])).product()
        };
        Self { row, from, shares: (from..end).map(share).collect() }
    }

    /// The true value of a number, of which `off` is the difference of two values.
    fn truth(&self, values: &[f64], off: impl Fn(f64, f64) -> f64) -> f64 {
        let own = values[self.row];
        let parts = self.shares.iter().zip(&values[self.from..]);
        own + parts.map(|(share, value)| share * off(*value, own)).sum::<f64>()
    }
}

/// True errors at the updates. Between records, of which there is one a period or more, the motion is a cubic; where records are rarer
/// they are those at updates, or if there are none all, with what was asked last.
pub(super) struct TrueErrors<'a> {
    record: &'a Record,
    seen: Vec<Sighting>,
}

impl<'a> TrueErrors<'a> {
    /// Of these `rows` under a controller with such `updates`.
    pub fn new(record: &'a Record, rows: Range<usize>, updates: Updates) -> Self {
        let t = record.values("t").unwrap_or_default();
        let Updates { period, count } = updates;
        let mut next = match t.get(rows.start) {
            Some(start) => (start / period).round() as usize,
            None => 0,
        };
        let mut seen = Vec::new();
        for row in rows.start..rows.end.min(t.len()) {
            // The newest update up to this record.
            let number = (t[row] / period + ROUNDING).floor() as usize;
            if number < next || number >= count {
                continue;
            }
            next = number + 1;
            let update = number as f64 * period;
            if is_at(t[row], update) {
                seen.push(Sighting::at(row));
            } else if row > rows.start && t[row] - t[row - 1] <= period {
                seen.push(Sighting::before(t, row, update));
            }
        }
        if seen.is_empty() {
            seen = rows.map(Sighting::at).collect();
        }
        Self { record, seen }
    }

    /// True values of a column; none without it.
    fn truth(&self, name: &str) -> Option<Vec<f64>> {
        let values = self.record.values(name)?;
        Some(self.seen.iter().map(|seen| seen.truth(values, |is, own| is - own)).collect())
    }

    /// Values of a column that an update sets; none without it.
    fn set(&self, name: &str) -> Option<Vec<f64>> {
        let values = self.record.values(name)?;
        Some(self.seen.iter().map(|seen| values[seen.row]).collect())
    }

    /// What the column `is` differs by from the column `asked`, `off` of two values.
    fn by(&self, [is, asked]: [&str; 2], off: impl Fn(f64, f64) -> f64) -> Option<Vec<f64>> {
        let (is, asked) = (self.record.values(is)?, self.set(asked)?);
        let errors = self.seen.iter().zip(&asked);
        Some(errors.map(|(seen, asked)| off(seen.truth(is, &off), *asked)).collect())
    }

    /// Errors of the height about an orbit, m.
    pub fn height(&self) -> Option<Vec<f64>> {
        self.by(["p_WB_z", "orbit_height_asked"], |is, asked| is - asked)
    }

    /// Errors of the angle `name` about an orbit, rad.
    pub fn angle(&self, name: &str) -> Option<Vec<f64>> {
        self.by([name, &format!("orbit_{name}_asked")], angle_error)
    }

    /// Velocities along the heading that were asked about an orbit, and the errors of those flown, m/s.
    pub fn speed(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let asked = self.set("orbit_speed_asked")?;
        let [x, y] = ["x", "y"].map(|axis| self.truth(&format!("v_WB_W_{axis}")));
        let (x, y) = (x?, y?);
        let yaw = self.set("yaw")?;
        let along = |k: usize| x[k] * yaw[k].cos() + y[k] * yaw[k].sin() - asked[k];
        let errors = (0..asked.len()).map(along).collect();
        Some((asked, errors))
    }

    /// Distances across the path and arcs ahead of what time and speed ask, m, and the arc at the end of the flight.
    pub fn path(&self, spec: &PathSpec) -> Option<([Vec<f64>; 2], f64)> {
        let path = spec.build().ok()?;
        let place = |axis: &str| format!("p_WB_{axis}");
        let last = |name: &str| self.record.values(name)?.last().copied();
        let end = Vec3::new(last(&place("x"))?, last(&place("y"))?, last(&place("z"))?);
        let end = path.beside(end, last("path_arc")?).arc;
        let [x, y, z] = ["x", "y", "z"].map(|axis| self.truth(&place(axis)));
        let (x, y, z) = (x?, y?, z?);
        let (arcs, ahead) = (self.set("path_arc")?, self.set("path_along")?);
        let beside = (0..x.len()).map(|k| path.beside(Vec3::new(x[k], y[k], z[k]), arcs[k]));
        let beside: Vec<_> = beside.collect();
        let along =
            beside.iter().zip(arcs.iter().zip(&ahead)).map(|(own, (arc, along))| own.arc - arc + along);
        let across = beside.iter().map(|own| own.cross).collect();
        Some(([across, along.collect()], end))
    }

    /// Vectors from the place at which to hover to where the robot is, m, W.
    pub fn hover(&self) -> Option<Vec<Vec3>> {
        let axis =
            |axis: &str| self.by([&format!("p_WB_{axis}"), &format!("hover_asked_{axis}")], |is, to| is - to);
        let [x, y, z] = ["x", "y", "z"].map(axis);
        let (x, y, z) = (x?, y?, z?);
        Some((0..x.len()).map(|k| Vec3::new(x[k], y[k], z[k])).collect())
    }
}
