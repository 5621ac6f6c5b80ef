//! The channels of a file as they are: any names, the units of the file, no change of sign or frame.

use std::path::Path;

use wingbeat::rig::unit::ChannelQuantity;
use wingbeat::simulate::{Column, Record};

use super::SampleTable;
use super::grid::SampleGrid;
use super::record::ANOTHER_RATE;
use super::record::{Bridged, spread};
use super::resolve::{KnownChannel, SEQUENCES, SIX, TIME, base, names};
use crate::Error;

/// Most channels: as many as letters name the panels of a figure.
const MOST_CHANNELS: usize = 24;
/// Columns beside those of [`SEQUENCES`] and time that are no channels.
const NO_CHANNELS: [&str; 6] = ["status", "phase", "sequence", "seq", "sample", "sample_number"];

/// What is asked of a file of channels.
#[derive(Clone, Debug, Default)]
pub struct ChannelRequest {
    /// Samples per second, Hz; without it the file says it, or has a column of time.
    pub rate: Option<f64>,
    /// Columns to take; all that are channels where none is named.
    pub columns: Vec<String>,
    /// One unit for each channel, or two: of forces and of moments.
    pub units: Vec<String>,
}

/// Channels with their times.
#[derive(Clone, Debug, Default)]
pub struct Plain {
    /// Time of each sample, s.
    pub time: Vec<f64>,
    /// The channels, each as long as `time`; missing samples are not-a-number.
    pub channels: Vec<Column>,
    /// Samples per second.
    pub rate: f64,
    /// Samples that are missing between the first and the last.
    pub missing: usize,
    /// Rows left out because they came again.
    pub duplicates: usize,
    /// What of the file was left out, in words.
    pub cautions: Vec<String>,
    /// The rate by the file's own times, Hz, where another one is given.
    pub other_rate: Option<f64>,
}

/// A measured table: as [`read_csv`](crate::read_csv) reads it where a column is called `t` or `phase`, else as a file of channels with a
/// column of time, `Time (s)`; units of forces, moments and angles that it says become N, N m and rad, channels in
/// other units and rows that are missing between others go.
///
/// # Errors
/// Those of `read_csv` where neither reads it; cells without a number.
pub fn read_measured(path: &Path) -> Result<Record, Error> {
    let plainly = crate::read_csv(path);
    if plainly.as_ref().is_ok_and(|record| ["t", "phase"].iter().any(|name| record.column(name).is_some())) {
        return plainly.and_then(|record| named_plainly(path, record));
    }
    let own_names = super::read_channels(path).map(|table| table.names_of_loads());
    let channels = super::read_channels(path).and_then(|table| table.plain(&ChannelRequest::default()));
    let Ok(Plain { time, mut channels, missing, .. }) = channels else { return plainly };
    // Here columns keep the names of the file, whatever its format; what they are called elsewhere means them too.
    for (own, name) in own_names.iter().flatten() {
        if let Some(column) = channels.iter_mut().find(|column| column.name == *name) {
            column.name.clone_from(own);
        }
    }
    let of = [ChannelQuantity::Force, ChannelQuantity::Moment, ChannelQuantity::Angle];
    // What is no force, moment or angle is none of the loads.
    let is_known = |unit: &str| unit.is_empty() || of.iter().any(|quantity| quantity.factor(unit).is_some());
    channels.retain(|column| is_known(&column.unit));
    for column in &mut channels {
        let known = |quantity: &ChannelQuantity| Some((quantity.factor(&column.unit)?, quantity.names()[0]));
        if let Some((factor, unit)) = of.iter().find_map(known) {
            column.values.iter_mut().for_each(|value| *value *= factor);
            column.unit = unit.into();
        }
    }
    if let Some(text) = no_numbers(&channels, missing) {
        return Err(Error::format(path, text));
    }
    channels.insert(0, Column { values: time, ..Column::new("t", "s", "") });
    let whole: Vec<bool> =
        (0..channels[0].values.len()).map(|k| channels.iter().all(|c| c.values[k].is_finite())).collect();
    for column in &mut channels {
        let mut kept = whole.iter();
        column.values.retain(|_| kept.next() == Some(&true));
    }
    Record::new(channels, 0).map_err(|error| Error::format(path, error))
}

/// `record` with a column more for each whose name has a unit of force, moment or angle behind it, `force_z [mN]`: without the unit in its name, and
/// in N, N m or rad.
fn named_plainly(path: &Path, record: Record) -> Result<Record, Error> {
    let of = [ChannelQuantity::Force, ChannelQuantity::Moment, ChannelQuantity::Angle];
    let mut columns = record.columns().to_vec();
    for column in record.columns() {
        let (plain, unit) = base(&column.name);
        let bracketed = column.name.ends_with([']', ')']) && !columns.iter().any(|other| other.name == plain);
        let known =
            |unit: &str, quantity: &ChannelQuantity| Some((quantity.factor(unit)?, quantity.names()[0]));
        let found =
            unit.filter(|_| bracketed).and_then(|unit| of.iter().find_map(|quantity| known(unit, quantity)));
        if let Some((factor, unit)) = found {
            let values = column.values.iter().map(|value| factor * value).collect();
            columns.push(Column { values, ..Column::new(plain, unit, "") });
        }
    }
    Record::new(columns, 0).map_err(|error| Error::format(path, error))
}

/// The channel that has most cells without a number, where there are more of them than the `missing` rows, which no channel has.
fn no_numbers(channels: &[Column], missing: usize) -> Option<String> {
    let holes = |column: &&Column| column.values.iter().filter(|value| !value.is_finite()).count();
    let worst = channels.iter().max_by_key(holes)?;
    let (empty, rows) = (holes(&worst).saturating_sub(missing), worst.values.len());
    let text = format!(
        "{empty} of {rows} values of `{}` are no numbers: cut these rows or this column out",
        worst.name
    );
    (empty > 0).then_some(text)
}

impl SampleTable {
    /// Names of the columns that are loads, without their units, and the names that the channels of [`plain`](Self::plain) have for them.
    fn names_of_loads(&self) -> Vec<(String, String)> {
        let loads = self.columns.iter().filter(|column| SIX.iter().any(|known| is(&column.name, known)));
        loads.map(|column| (base(&column.name).0.to_owned(), short(&column.name))).collect()
    }

    /// The channels by their own names.
    ///
    /// # Errors
    /// No time and no rate, columns that are not there, units that do not fit, time that goes back.
    pub fn plain(mut self, asked: &ChannelRequest) -> Result<Plain, Error> {
        self.name_bare(asked)?;
        let time = self.columns.iter().position(|column| is(&column.name, &TIME));
        let chosen = self.chosen(asked, time)?;
        let rows = self.columns[chosen[0]].values.len();
        self.check_lengths(chosen.iter().chain(&time).map(|k| &self.columns[*k]), rows)?;
        let units = self.units(asked, &chosen)?;
        let (grid, own) = self.placed(asked, time, rows)?;
        let own_rate =
            time.filter(|_| asked.rate.is_some()).and_then(|k| Some(self.by_column(k).ok()?.0.rate));
        let other_rate = own_rate.filter(|own| (own / grid.rate - 1.0).abs() > ANOTHER_RATE);
        let mut channels: Vec<Column> = Vec::new();
        for (k, unit) in chosen.into_iter().zip(units) {
            let name = short(&self.columns[k].name);
            if channels.iter().any(|channel| channel.name == name) {
                return Err(self.bad(format!("several columns are called `{name}`: rename them")));
            }
            let values = std::mem::take(&mut self.columns[k].values);
            let values =
                if grid.is_whole(rows) { values } else { spread(&values, &grid, (0, Bridged::Line)) };
            channels.push(Column { values, ..Column::new(name, unit, "") });
        }
        let even = || (0..grid.len()).map(|k| grid.start + k as f64 / grid.rate).collect();
        let time = own.filter(|_| grid.is_whole(rows)).unwrap_or_else(even);
        let missing = grid.len() - grid.place.len();
        let cautions = self.cautions;
        let (rate, duplicates) = (grid.rate, grid.duplicates);
        Ok(Plain { time, channels, rate, missing, duplicates, cautions, other_rate })
    }

    /// Names the columns of a file without a header, which must be six.
    fn name_bare(&mut self, asked: &ChannelRequest) -> Result<(), Error> {
        let bare = |(k, name): (usize, &String)| *name == format!("[{k}]");
        if self.layout != "text" || self.names.is_empty() || !self.names.iter().enumerate().all(bare) {
            return Ok(());
        }
        let count = self.names.len();
        if count != SIX.len() || self.columns.len() != count {
            return Err(self.bad(format!(
                "line 1: {count} columns without names; without a header allowed are 6, Fx .. Tz: write the names \
                 of the columns into the first line"
            )));
        }
        if asked.columns.is_empty() {
            for (column, known) in self.columns.iter_mut().zip(SIX) {
                column.name = known.name.into();
            }
        }
        Ok(())
    }

    /// Which columns are taken.
    fn chosen(&self, asked: &ChannelRequest, time: Option<usize>) -> Result<Vec<usize>, Error> {
        let chosen = match asked.columns.is_empty() {
            true => (0..self.columns.len())
                .filter(|k| Some(*k) != time && is_channel(&self.columns[*k].name))
                .collect(),
            false => asked.columns.iter().map(|name| self.named(name)).collect::<Result<Vec<_>, _>>()?,
        };
        match chosen.len() {
            0 => Err(self.bad(format!("no column with samples; found {}", self.found()))),
            1..=MOST_CHANNELS => Ok(chosen),
            count => Err(self.bad(format!(
                "{count} channels; allowed are at most {MOST_CHANNELS}: choose some with --columns NAME,NAME"
            ))),
        }
    }

    fn named(&self, name: &str) -> Result<usize, Error> {
        let exactly = self.columns.iter().position(|column| column.name == name);
        let fits =
            |column: &Column| names(name, &column.name) || short(&column.name).eq_ignore_ascii_case(name);
        let found = exactly.or_else(|| self.columns.iter().position(fits));
        found.ok_or_else(|| self.bad(format!("--columns: no column `{name}`; found {}", self.found())))
    }

    /// The unit of each channel: the one given, else the one that the file says; empty where nothing says one.
    fn units(&self, asked: &ChannelRequest, chosen: &[usize]) -> Result<Vec<String>, Error> {
        let given = self.given_units(asked, chosen)?;
        let unit = |(i, k): (usize, &usize)| {
            let column = &self.columns[*k];
            let by_file = Some(column.unit.as_str()).filter(|unit| !matches!(*unit, "" | "1"));
            let said = base(&column.name).1.or(by_file);
            match (given.get(i), said) {
                (Some(given), Some(said)) if !same(given, said) => Err(self.bad(format!(
                    "column {}: unit {given} by --units, but {said} by the file: leave --units out, or give {said}",
                    column.name
                ))),
                (given, said) => Ok(given.map(String::as_str).or(said).unwrap_or("").to_owned()),
            }
        };
        chosen.iter().enumerate().map(unit).collect()
    }

    fn given_units(&self, asked: &ChannelRequest, chosen: &[usize]) -> Result<Vec<String>, Error> {
        let units = &asked.units;
        if units.is_empty() || units.len() == chosen.len() {
            return Ok(units.clone());
        }
        let place = |k: &usize| SIX.iter().position(|known| is(&self.columns[*k].name, known));
        let places: Option<Vec<usize>> = chosen.iter().map(place).collect();
        let (Some(places), [force, moment]) = (places, units.as_slice()) else {
            return Err(self.bad(format!(
                "--units: {} for {} channels; allowed is one for each, or two, of forces and of moments, where all \
                 channels are Fx .. Tz",
                units.len(),
                chosen.len()
            )));
        };
        for (unit, quantity, what) in
            [(force, ChannelQuantity::Force, "force"), (moment, ChannelQuantity::Moment, "moment")]
        {
            if quantity.factor(unit).is_none() {
                let known = quantity.names().join(", ");
                return Err(self.bad(format!("--units: `{unit}` is no unit of {what}; allowed are {known}")));
            }
        }
        Ok(places.into_iter().map(|place| if place < 3 { force.clone() } else { moment.clone() }).collect())
    }

    /// Where the samples lie by column `k` of times, and its unit in s.
    fn by_column(&self, k: usize) -> Result<(SampleGrid, f64), Error> {
        let column = &self.columns[k];
        let unit = base(&column.name).1.unwrap_or(if column.unit.is_empty() { "s" } else { &column.unit });
        let factor = ChannelQuantity::Time.factor(unit).ok_or_else(|| {
            let known = ChannelQuantity::Time.names().join(", ");
            self.bad(format!("column {}: `{unit}` is no unit of time; allowed are {known}", column.name))
        })?;
        let grid = SampleGrid::timed(&column.values, factor, self.unordered);
        let grid = grid.map_err(|what| self.bad(format!("{what}; --rate HZ takes samples as even")))?;
        Ok((grid, factor))
    }

    /// Where the samples lie on even steps, and their own times, s, where the file has them and no rate is given.
    fn placed(
        &self,
        asked: &ChannelRequest,
        time: Option<usize>,
        rows: usize,
    ) -> Result<(SampleGrid, Option<Vec<f64>>), Error> {
        let sequence = SEQUENCES.iter().find_map(|name| self.columns.iter().find(|c| c.name == *name));
        let sequence = sequence.filter(|column| column.values.len() == rows);
        let bad = |what: String| self.bad(what);
        match (asked.rate.or(self.rate), sequence, time) {
            (Some(rate), Some(column), _) => Ok((SampleGrid::numbered(&column.values, rate).map_err(bad)?, None)),
            (Some(rate), None, _) => Ok((SampleGrid::counted(rows, rate), None)),
            (None, _, Some(k)) => {
                let (grid, factor) = self.by_column(k)?;
                Ok((grid, Some(self.columns[k].values.iter().map(|t| factor * t).collect())))
            }
            (None, _, None) => Err(self.bad(format!(
                "no column of time; found {}: give the samples per second with --rate HZ, or add a column t (s)",
                self.found()
            ))),
        }
    }
}

/// Whether a column has a name of the channel.
fn is(column: &str, known: &KnownChannel) -> bool {
    known.names().any(|name| base(column).0.eq_ignore_ascii_case(name))
}

fn is_channel(column: &str) -> bool {
    let plain = base(column).0;
    !SEQUENCES.iter().chain(&NO_CHANNELS).any(|name| plain.eq_ignore_ascii_case(name))
}

/// The name without its unit; of forces and moments that of the record.
fn short(column: &str) -> String {
    let known = SIX.iter().find(|known| is(column, known));
    known.map_or(base(column).0, |known| known.name).to_owned()
}

/// Whether two names are of one unit.
fn same(a: &str, b: &str) -> bool {
    let one = |quantity: &ChannelQuantity| {
        let (a, b) = (quantity.factor(a), quantity.factor(b));
        a.is_some() && a == b
    };
    a == b || ChannelQuantity::ALL.iter().any(one)
}
