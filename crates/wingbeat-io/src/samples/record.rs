//! From a file's columns to the record that processing reads: known names, SI units, equal steps of time.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use wingbeat::rig::cell::CHANNELS;
use wingbeat::rig::process::InputSpec;
use wingbeat::simulate::{Column, Record};

use super::SampleTable;
use super::grid::SampleGrid;
use super::resolve::{KnownChannel, OTHERS, SEQUENCES, SIX, TIME, names};
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
    /// What of the file was left out, and what it says otherwise than the keys that were followed.
    pub cautions: Vec<String>,
}

/// A record on equal steps of time, and what was found on the way.
#[derive(Clone, Debug)]
pub struct ImportedRecord {
    /// Columns t, Fx .. Tz and what else processing reads, in SI units; missing samples are not-a-number.
    pub record: Record,
    /// How it was found.
    pub import: Import,
}

impl SampleTable {
    /// The samples with the names of the record, in SI units, at equal steps of time.
    ///
    /// # Errors
    /// A channel without column or unit, one with several, columns of different length, time that goes back.
    pub fn import(mut self, input: &InputSpec) -> Result<ImportedRecord, Error> {
        self.check_mapping(input)?;
        let (mut used, mut factors) = (Vec::new(), Vec::new());
        for known in SIX.iter().chain(&OTHERS) {
            let found = self.find(known, input)?;
            if used.len() < SIX.len() && found.is_none() {
                return Err(self.no_column(known.name));
            }
            if let Some(column) = found {
                let sign = self.sign(known, column, input);
                factors.push(sign * self.to_si(&self.columns[column], known, input)?);
                used.push((known, column));
            }
        }
        let by_name: Vec<(&str, usize)> = used.iter().map(|(known, column)| (known.name, *column)).collect();
        self.check_used_once(&by_name)?;
        if let (true, Some(time)) = (input.columns.contains_key("t"), self.find(&TIME, input)?) {
            self.check_used_once(&[&by_name[..], &[("t", time)]].concat())?;
        }
        let rows = self.columns[used[0].1].values.len();
        self.check_lengths(used.iter().map(|(_, column)| &self.columns[*column]), rows)?;
        let (grid, otherwise) = self.grid(input, rows)?;
        let cautions = std::mem::take(&mut self.cautions).into_iter().chain(otherwise).collect();
        let columns = self.taken(&used, &factors, input, rows);
        on_grid(columns, &grid, input, Import { layout: self.layout.into(), cautions, ..Import::default() })
            .map_err(|error| self.bad(error))
    }

    /// The columns of the channels in SI units, and then those without channel that are as long.
    fn taken(
        &mut self,
        used: &[(&KnownChannel, usize)],
        factors: &[f64],
        input: &InputSpec,
        rows: usize,
    ) -> Vec<Column> {
        let mut columns = Vec::new();
        for (k, ((known, index), &factor)) in used.iter().zip(factors).enumerate() {
            let mut column = std::mem::take(&mut self.columns[*index].values);
            if factor != 1.0 {
                column.iter_mut().for_each(|value| *value *= factor);
            }
            let source = &self.columns[*index];
            let unit = if k < SIX.len() { CHANNELS[k].1 } else { angle(known) };
            columns.push(Column {
                name: known.name.into(),
                unit: unit.into(),
                frame: source.frame.clone(),
                low: (source.low * factor).min(source.high * factor),
                high: (source.low * factor).max(source.high * factor),
                values: column,
            });
        }
        for column in &mut self.columns {
            let mapped = input.columns.values().any(|name| names(name, &column.name));
            let taken = mapped || columns.iter().any(|other| other.name == column.name) || column.name == "t";
            if column.values.len() == rows && !taken {
                columns.push(std::mem::replace(column, Column::new("", "", "")));
            }
        }
        columns
    }

    pub(super) fn check_lengths<'a>(
        &self,
        columns: impl Iterator<Item = &'a Column>,
        rows: usize,
    ) -> Result<(), Error> {
        if rows == 0 {
            return Err(self.bad("no samples"));
        }
        match columns.into_iter().find(|column| column.values.len() != rows) {
            None => Ok(()),
            Some(column) => {
                let found = column.values.len();
                let (name, cut) = (&column.name, found.min(rows));
                Err(self.bad(format!("cut short at sample {cut}: {name} has {found} samples, Fx {rows}")))
            }
        }
    }

    /// Where the rows lie in time, by the rate given or said and the numbers of the samples, or by their times; and
    /// what of the file says otherwise.
    fn grid(&self, input: &InputSpec, rows: usize) -> Result<(SampleGrid, Vec<String>), Error> {
        let sequence = SEQUENCES.iter().find_map(|name| self.columns.iter().find(|c| c.name == *name));
        let sequence = sequence.filter(|column| column.values.len() == rows);
        let rate = input.rate_hz.or(self.rate);
        if let Some(rate) = rate.filter(|rate| !(*rate > 0.0 && rate.is_finite())) {
            return Err(
                self.bad(format!("process.input.rate_hz = {rate}: allowed is a finite number above 0"))
            );
        }
        match (rate, sequence) {
            (Some(rate), Some(column)) => {
                let grid = SampleGrid::numbered(&column.values, rate).map_err(|what| self.bad(what))?;
                Ok((grid, self.other_rate(input).into_iter().collect()))
            }
            (Some(rate), None) => {
                let cautions = self.other_rate(input).into_iter().chain(self.other_time(input, rate, rows));
                Ok((SampleGrid::counted(rows, rate), cautions.collect()))
            }
            (None, _) => Ok((self.timed(input, rows)?, Vec::new())),
        }
    }

    fn timed(&self, input: &InputSpec, rows: usize) -> Result<SampleGrid, Error> {
        let why = |what: String| {
            self.bad(format!("{what}; to take samples as equally spaced: --set process.input.rate_hz=HZ"))
        };
        let missing = || why(format!("no column for time; found {}", self.found()));
        let column = &self.columns[self.find(&TIME, input)?.ok_or_else(missing)?];
        self.check_lengths(std::iter::once(column), rows)?;
        let factor = self.to_si(column, &TIME, input)?;
        SampleGrid::timed(&column.values, factor, self.unordered).map_err(why)
    }

    /// The rate that the file says, where the key says another.
    fn other_rate(&self, input: &InputSpec) -> Option<String> {
        let (given, said) = (input.rate_hz?, self.rate?);
        let apart = (given / said - 1.0).abs() > ANOTHER_RATE;
        apart.then(|| format!("process.input.rate_hz = {given} was followed; the file says {said} Hz"))
    }

    /// What the file's own times say, where a rate is followed instead.
    fn other_time(&self, input: &InputSpec, rate: f64, rows: usize) -> Option<String> {
        input.rate_hz?;
        let column = &self.columns[self.find(&TIME, input).ok()??];
        let followed = format!("process.input.rate_hz = {rate} was followed; by its column {}", column.name);
        match self.timed(input, rows) {
            Ok(own) => {
                let missing = own.len() - own.place.len();
                let apart = missing > 0 || (own.rate / rate - 1.0).abs() > ANOTHER_RATE;
                let own = own.rate;
                apart.then(|| format!("{followed} the file has {own:.6} Hz and {missing} samples missing"))
            }
            Err(_) => Some(format!("{followed} the file has no even times")),
        }
    }
}

/// Share by which two rates differ that are not the same (*choice*: ten times the error of a quartz clock of a PC).
pub(super) const ANOTHER_RATE: f64 = 1e-3;

fn angle(known: &KnownChannel) -> &'static str {
    if known.quantity.is_some() { "rad" } else { "" }
}

fn on_grid(
    mut columns: Vec<Column>,
    grid: &SampleGrid,
    input: &InputSpec,
    mut import: Import,
) -> Result<ImportedRecord, wingbeat::Error> {
    import.rows = columns[0].values.len();
    (import.rate_hz, import.duplicates, import.late) = (grid.rate, grid.duplicates, grid.late);
    for (from, to) in grid.place.iter().zip(&grid.place[1..]).filter(|(from, to)| **to > **from + 1) {
        let missing = (to - from - 1) as usize;
        import.gaps += 1;
        import.missing += missing;
        import.longest_gap = import.longest_gap.max(missing);
        import.bridged += if missing <= input.bridge_samples { missing } else { 0 };
    }
    if !grid.is_whole(import.rows) {
        for column in &mut columns {
            let bridged = Bridged::of(column);
            column.values = spread(&column.values, grid, (input.bridge_samples, bridged));
        }
    }
    let mut time = Column::new("t", "s", "");
    let begin = grid.start - input.start_s;
    time.values = (0..grid.len()).map(|k| begin + k as f64 / grid.rate).collect();
    columns.insert(0, time);
    Ok(ImportedRecord { record: Record::new(columns, 0)?, import })
}

/// How values between two samples are made up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bridged {
    /// By a straight line.
    Line,
    /// By a straight line the shorter way round, rad: an encoder falls back by a turn in each cycle.
    Angle,
    /// Bits, of which those of either hold.
    Bits,
}

impl Bridged {
    fn of(column: &Column) -> Self {
        let reach = |of: &[f64]| {
            let there = || of.iter().copied().filter(|x| x.is_finite());
            there().fold(f64::MIN, f64::max) - there().fold(f64::MAX, f64::min)
        };
        match column.name.as_str() {
            "status" => Self::Bits,
            // One that counts turns does not fall back.
            "phase" if reach(&column.values) <= TAU * (1.0 + 1e-6) => Self::Angle,
            _ => Self::Line,
        }
    }

    /// The value at the part `share` of the way from `before` to `after`.
    fn at(self, before: f64, after: f64, share: f64) -> f64 {
        match self {
            Self::Line => before + (after - before) * share,
            Self::Angle => before + ((after - before + PI).rem_euclid(TAU) - PI) * share,
            Self::Bits => f64::from(before as u32 | after as u32),
        }
    }
}

/// `values` on the grid; gaps of at most so many samples bridged as is said, others not-a-number.
pub(super) fn spread(values: &[f64], grid: &SampleGrid, (bridge, how): (usize, Bridged)) -> Vec<f64> {
    let mut out = vec![f64::NAN; grid.len()];
    let mut last: Option<(usize, f64)> = None;
    for (place, row) in grid.place.iter().zip(&grid.rows) {
        let (place, value) = (*place as usize, values[*row as usize]);
        if let Some((from, before)) = last
            && place - from <= bridge.saturating_add(1)
        {
            for k in from + 1..place {
                out[k] = how.at(before, value, (k - from) as f64 / (place - from) as f64);
            }
        }
        out[place] = value;
        last = Some((place, value));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_bridged_the_shorter_way_round_and_by_the_bits_of_either() {
        let named =
            |name: &str, values: &[f64]| Column { values: values.to_vec(), ..Column::new(name, "", "") };
        let wrap = Bridged::of(&named("phase", &[0.0, 6.2]));
        // From 6.2 rad over the wrap to 0.2 rad.
        let half = 6.2 + 0.5 * (0.2 + TAU - 6.2);
        assert!(
            (wrap.at(6.2, 0.2, 0.5) - half).abs() < 1e-12
                && (wrap.at(0.2, 6.2, 0.5) - (0.2 + 6.2 - half)).abs() < 1e-12
        );
        let turns = Bridged::of(&named("phase", &[0.0, 60.0]));
        assert_eq!((turns, turns.at(1.0, 9.0, 0.5)), (Bridged::Line, 5.0));
        let bits = Bridged::of(&named("status", &[0.0, 1.0]));
        assert_eq!(bits.at(f64::from(0x8002_0000_u32), 1.0, 0.5), f64::from(0x8002_0001_u32));
        assert_eq!(Bridged::of(&named("Fz", &[0.0, 1.0])), Bridged::Line);
    }
}
