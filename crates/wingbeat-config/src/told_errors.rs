//! The errors of a flight under a controller: the true motion beside what was asked, whatever the controller is told of it.

use std::ops::Range;
use wingbeat_flight::guide::{PathSpec, angle_error};
use wingbeat_flight::simulate::{Record, is_at};

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
use wingbeat_math::Vec3;

/// True errors at the records of updates, as what is asked is recorded there; at all records where none falls on an update, with
/// what was asked last.
pub(super) struct TrueErrors<'a> {
    record: &'a Record,
    rows: Vec<usize>,
}

impl<'a> TrueErrors<'a> {
    /// Of these `rows` under a controller with such `updates`.
    pub fn new(record: &'a Record, rows: Range<usize>, updates: Updates) -> Self {
        let updated = updates.rows(record, rows.clone());
        let rows = if updated.is_empty() { rows.collect() } else { updated };
        Self { record, rows }
    }

    /// Values of a column there; none without it.
    fn column(&self, name: &str) -> Option<Vec<f64>> {
        let values = self.record.values(name)?;
        Some(self.rows.iter().map(|&row| values[row]).collect())
    }

    /// By `error` of the column `is` and the column `asked`.
    fn by(&self, [is, asked]: [&str; 2], error: impl Fn(f64, f64) -> f64) -> Option<Vec<f64>> {
        let (is, asked) = (self.column(is)?, self.column(asked)?);
        Some(is.iter().zip(&asked).map(|(is, asked)| error(*is, *asked)).collect())
    }

    /// Errors of the height about an orbit, m.
    pub fn height(&self) -> Option<Vec<f64>> {
        self.by(["p_WB_z", "orbit_height_asked"], |is, asked| is - asked)
    }

    /// Errors of the angle `name` about an orbit, rad.
    pub fn angle(&self, name: &str) -> Option<Vec<f64>> {
        self.by([name, &format!("orbit_{name}_asked")], angle_error)
    }

    /// Distances across the path and arcs ahead of what time and speed ask, m, and the arc at the end of the flight.
    pub fn path(&self, spec: &PathSpec) -> Option<([Vec<f64>; 2], f64)> {
        let path = spec.build().ok()?;
        let place = |axis: &str| format!("p_WB_{axis}");
        let last = |name: &str| self.record.values(name)?.last().copied();
        let end = Vec3::new(last(&place("x"))?, last(&place("y"))?, last(&place("z"))?);
        let end = path.beside(end, last("path_arc")?).arc;
        let [x, y, z] = ["x", "y", "z"].map(|axis| self.column(&place(axis)));
        let (x, y, z) = (x?, y?, z?);
        let (arcs, ahead) = (self.column("path_arc")?, self.column("path_along")?);
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
