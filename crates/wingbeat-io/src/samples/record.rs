//! From a file's columns to the record that processing reads: known names, SI units, equal steps of time.

use serde::Serialize;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::InputSpec;
use wingbeat::rig::unit::Quantity;
use wingbeat::simulate::{Column, Record};

use super::Table;
use super::grid::Grid;
use crate::Error;

/// Samples as they were found in a file.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Import {
    /// Layout of the file.
    pub layout: String,
    /// Rows of the file.
    pub rows: usize,
    /// Samples per second.
    pub rate_hz: f64,
    /// Samples that are missing between the first and the last.
    pub missing: usize,
    /// Places where some are missing.
    pub gaps: usize,
    /// Longest run of missing samples.
    pub longest_gap: usize,
    /// Missing samples that were bridged, as `bridge_samples` allows.
    pub bridged: usize,
    /// Rows left out because they came again.
    pub duplicates: usize,
    /// Rows that stood behind later ones.
    pub late: usize,
}

/// A record on equal steps of time, and what was found on the way.
#[derive(Clone, Debug)]
pub struct Imported {
    /// Columns t, Fx .. Tz and what else the file has, in SI units; missing samples are not-a-number.
    pub record: Record,
    /// How it was found.
    pub import: Import,
}

/// A channel by its name in the record, what it measures, and names that files give it.
struct Known {
    name: &'static str,
    quantity: Option<Quantity>,
    others: &'static [&'static str],
}

const fn known(name: &'static str, quantity: Option<Quantity>, others: &'static [&'static str]) -> Known {
    Known { name, quantity, others }
}

const TIME: Known = known("t", Some(Quantity::Time), &["time"]);
const SIX: [Known; 6] = [
    known("Fx", Some(Quantity::Force), &["force_x", "f_x"]),
    known("Fy", Some(Quantity::Force), &["force_y", "f_y"]),
    known("Fz", Some(Quantity::Force), &["force_z", "f_z"]),
    known("Tx", Some(Quantity::Moment), &["mx", "torque_x", "moment_x", "m_x"]),
    known("Ty", Some(Quantity::Moment), &["my", "torque_y", "moment_y", "m_y"]),
    known("Tz", Some(Quantity::Moment), &["mz", "torque_z", "moment_z", "m_z"]),
];
const PHASE: Known = known("phase", Some(Quantity::Angle), &["encoder", "stroke_phase"]);
const STATUS: Known = known("status", None, &[]);
/// Joints of the longest arm.
const JOINTS: [&str; 7] = ["q1", "q2", "q3", "q4", "q5", "q6", "q7"];
/// Numbers that count samples, the better ones first.
const SEQUENCES: [&str; 2] = ["rdt_sequence", "ft_sequence"];

impl Table {
    /// The samples with the names of the record, in SI units, at equal steps of time.
    ///
    /// # Errors
    /// A channel without column or unit, columns of different length, time that goes back.
    pub fn import(&self, input: &InputSpec) -> Result<Imported, Error> {
        self.check_mapping(input)?;
        let mut columns = Vec::new();
        for (known, (_, unit)) in SIX.iter().zip(CHANNELS) {
            let column = self.find(known, input)?.ok_or_else(|| self.no_column(known.name))?;
            columns.push(Column { name: known.name.into(), ..self.in_si(column, known, unit, input)? });
        }
        let rows = columns[0].values.len();
        for (known, unit) in [(&PHASE, "rad"), (&STATUS, "")] {
            if let Some(column) = self.find(known, input)? {
                columns.push(Column { name: known.name.into(), ..self.in_si(column, known, unit, input)? });
            }
        }
        for name in JOINTS {
            let joint = known(name, Some(Quantity::Angle), &[]);
            if let Some(column) = self.find(&joint, input)? {
                columns.push(Column { name: name.into(), ..self.in_si(column, &joint, "rad", input)? });
            }
        }
        self.check_lengths(&columns, rows)?;
        let grid = self.grid(input, rows)?;
        self.add_others(&mut columns, input, rows);
        self.on_grid(columns, &grid, input)
    }

    /// Names in the mapping that are no channels.
    fn check_mapping(&self, input: &InputSpec) -> Result<(), Error> {
        let channels = || {
            let fixed = [&TIME, &PHASE, &STATUS].map(|known| known.name);
            SIX.iter().map(|known| known.name).chain(fixed).chain(JOINTS)
        };
        match input.columns.keys().find(|key| !channels().any(|name| name == key.as_str())) {
            None => Ok(()),
            Some(key) => {
                let allowed: Vec<_> = channels().collect();
                Err(self.bad(format!("process.input.columns.{key}: allowed are {}", allowed.join(", "))))
            }
        }
    }

    /// The column of a channel: the one that the mapping names, or one with a name known for it.
    fn find(&self, known: &Known, input: &InputSpec) -> Result<Option<&Column>, Error> {
        if let Some(name) = input.columns.get(known.name) {
            let found = self.columns.iter().find(|column| column.name == *name);
            let missing =
                || self.bad(format!("no column `{name}` for {}; found {}", known.name, self.names()));
            return found.ok_or_else(missing).map(Some);
        }
        let named = |column: &&Column, wanted: &str| base(&column.name).0.eq_ignore_ascii_case(wanted);
        let mut names = std::iter::once(known.name).chain(known.others.iter().copied());
        Ok(names.find_map(|name| self.columns.iter().find(|column| named(column, name))))
    }

    fn no_column(&self, channel: &str) -> Error {
        self.bad(format!(
            "no column for {channel}; found {}: name it with --set process.input.columns.{channel}=NAME",
            self.names()
        ))
    }

    fn names(&self) -> String {
        let names: Vec<_> = self.columns.iter().map(|column| column.name.as_str()).take(40).collect();
        match (names.is_empty(), self.skipped.is_empty()) {
            (true, true) => "nothing".into(),
            (true, false) => format!("only what holds no numbers: {}", self.skipped.join(", ")),
            _ => names.join(", "),
        }
    }

    /// The column in its SI unit.
    fn in_si(&self, column: &Column, known: &Known, si: &str, input: &InputSpec) -> Result<Column, Error> {
        let scaled = |factor: f64| Column {
            unit: si.into(),
            low: column.low * factor,
            high: column.high * factor,
            values: column.values.iter().map(|value| value * factor).collect(),
            ..column.clone()
        };
        let Some(quantity) = known.quantity else { return Ok(scaled(1.0)) };
        let (key, given, counts) = match quantity {
            Quantity::Force => ("force", &input.units.force, ("counts_per_newton", input.counts_per_newton)),
            Quantity::Moment => {
                ("moment", &input.units.moment, ("counts_per_newton_metre", input.counts_per_newton_metre))
            }
            Quantity::Time => ("time", &input.units.time, ("", None)),
            Quantity::Angle => ("angle", &input.units.angle, ("", None)),
        };
        let said = (!column.unit.is_empty()).then(|| column.unit.clone());
        let Some(unit) = given.clone().or(said).or_else(|| base(&column.name).1.map(String::from)) else {
            return Err(self.bad(format!(
                "column {}: unit missing: say --set process.input.units.{key}=UNIT, one of {}",
                column.name,
                allowed(quantity)
            )));
        };
        if unit.eq_ignore_ascii_case("counts") && !counts.0.is_empty() {
            let per = counts.1.filter(|per| *per > 0.0 && per.is_finite());
            return per.map(|per| scaled(1.0 / per)).ok_or_else(|| {
                self.bad(format!(
                    "column {} is in counts: say --set process.input.{}=N",
                    column.name, counts.0
                ))
            });
        }
        quantity.factor(&unit).map(scaled).ok_or_else(|| {
            let allowed = allowed(quantity);
            self.bad(format!(
                "column {}: unit `{unit}` is not known: say --set process.input.units.{key}=UNIT, one of {allowed}",
                column.name
            ))
        })
    }

    fn check_lengths(&self, columns: &[Column], rows: usize) -> Result<(), Error> {
        if rows == 0 {
            return Err(self.bad("no samples"));
        }
        match columns.iter().find(|column| column.values.len() != rows) {
            None => Ok(()),
            Some(column) => {
                let found = column.values.len();
                let (name, cut) = (&column.name, found.min(rows));
                Err(self.bad(format!("cut short at sample {cut}: {name} has {found} samples, Fx {rows}")))
            }
        }
    }

    /// Where the rows lie in time: by the rate given or said and the numbers of the samples, or by their times.
    fn grid(&self, input: &InputSpec, rows: usize) -> Result<Grid, Error> {
        let sequence = SEQUENCES.iter().find_map(|name| self.columns.iter().find(|c| c.name == *name));
        let sequence = sequence.filter(|column| column.values.len() == rows);
        let rate = input.rate_hz.or(self.rate);
        if let Some(rate) = rate.filter(|rate| !(*rate > 0.0 && rate.is_finite())) {
            return Err(
                self.bad(format!("process.input.rate_hz = {rate}: allowed is a finite number above 0"))
            );
        }
        let why = |what: String| {
            self.bad(format!("{what}; to take samples as equally spaced: --set process.input.rate_hz=HZ"))
        };
        match (rate, sequence) {
            (Some(rate), Some(column)) => Grid::numbered(&column.values, rate).map_err(|what| self.bad(what)),
            (Some(rate), None) => Ok(Grid::counted(rows, rate)),
            (None, _) => {
                let missing = || why(format!("no column for time; found {}", self.names()));
                let column = self.find(&TIME, input)?.ok_or_else(missing)?;
                let column = self.in_si(column, &TIME, "s", input)?;
                self.check_lengths(std::slice::from_ref(&column), rows)?;
                Grid::timed(&column.values, self.unordered).map_err(why)
            }
        }
    }

    /// Everything else of the same length, as it is.
    fn add_others(&self, columns: &mut Vec<Column>, input: &InputSpec, rows: usize) {
        for column in &self.columns {
            let mapped = input.columns.values().any(|name| *name == column.name);
            let taken = mapped || columns.iter().any(|other| other.name == column.name) || column.name == "t";
            if column.values.len() == rows && !taken {
                columns.push(column.clone());
            }
        }
    }

    fn on_grid(&self, mut columns: Vec<Column>, grid: &Grid, input: &InputSpec) -> Result<Imported, Error> {
        let length = grid.len();
        let mut import = Import {
            layout: self.layout.into(),
            rows: columns[0].values.len(),
            rate_hz: grid.rate,
            duplicates: grid.duplicates,
            late: grid.late,
            ..Import::default()
        };
        for pair in grid.place.windows(2).filter(|pair| pair[1] > pair[0] + 1) {
            let missing = pair[1] - pair[0] - 1;
            import.gaps += 1;
            import.missing += missing;
            import.longest_gap = import.longest_gap.max(missing);
            import.bridged += if missing <= input.bridge_samples { missing } else { 0 };
        }
        for column in &mut columns {
            column.values = spread(&column.values, grid, input.bridge_samples);
        }
        let mut time = Column::new("t", "s", "");
        let begin = grid.start - input.start_s;
        time.values = (0..length).map(|k| begin + k as f64 / grid.rate).collect();
        columns.insert(0, time);
        let record = Record::new(columns, 0).map_err(|error| self.bad(error))?;
        Ok(Imported { record, import })
    }
}

/// `values` on the grid; gaps of at most `bridge` samples by straight lines, others not-a-number.
fn spread(values: &[f64], grid: &Grid, bridge: usize) -> Vec<f64> {
    let mut out = vec![f64::NAN; grid.len()];
    let mut last: Option<(usize, f64)> = None;
    for (place, row) in grid.place.iter().zip(&grid.rows) {
        let value = values[*row];
        if let Some((from, before)) = last
            && place - from <= bridge + 1
        {
            for k in from + 1..*place {
                out[k] = before + (value - before) * (k - from) as f64 / (place - from) as f64;
            }
        }
        out[*place] = value;
        last = Some((*place, value));
    }
    out
}

fn allowed(quantity: Quantity) -> String {
    let counts = matches!(quantity, Quantity::Force | Quantity::Moment).then_some("counts");
    quantity.names().into_iter().chain(counts).collect::<Vec<_>>().join(", ")
}

/// Name and unit of a column called `Fx [N]`, `Fx (N)` or `fx_N`.
fn base(name: &str) -> (&str, Option<&str>) {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((start, rest)) = name.split_once(open)
            && let Some((unit, "")) = rest.split_once(close)
            && !start.is_empty()
            && unit.parse::<usize>().is_err()
        {
            return (start.trim(), Some(unit.trim()));
        }
    }
    let unit = |text: &str| text == "counts" || Quantity::ALL.iter().any(|q| q.factor(text).is_some());
    match name.rsplit_once('_') {
        Some((start, end)) if unit(end) && !start.is_empty() => (start, Some(end)),
        _ => (name, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_off_names() {
        assert_eq!(base("Fx [N]"), ("Fx", Some("N")));
        assert_eq!(base("Tx (N-mm)"), ("Tx", Some("N-mm")));
        assert_eq!(base("time_s"), ("time", Some("s")));
        assert_eq!(base("force_x"), ("force_x", None));
        assert_eq!(base("wrench[2]"), ("wrench[2]", None));
    }
}
