//! Motion from a table in a CSV file: by time or by phase, scaled, smoothed.

use super::{CoordinateSpec, ReadTable};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use wingbeat_flight::simulate::Record;
use wingbeat_flight::tether::Coordinate;
use wingbeat_judge::RunLimits;
use wingbeat_judge::data::{Finding, MeasuredChannel, Purpose, Series, estimate, examined};
use wingbeat_judge::limits::data::LEFT;
use wingbeat_math::CubicSpline;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;

/// Most harmonics of a smoothed table. *Choice.*
const MOST_HARMONICS: usize = 64;
/// Most samples times harmonics of a smoothed table: a fit of them takes about a second. *Choice.*
const MOST_FITTED: usize = 10_000_000;

/// Cycles, and the share of the power that harmonics explain, from which a table repeats. *Choice.*
const CYCLES: f64 = 3.0;
const REPEATS: f64 = 0.95;

/// Part of a cycle by which the span of a table that ends where it begins may differ from one.
const CLOSED: f64 = 1e-6;

/// Part of its mean by which a coordinate that is held may move. *Choice*: 0.2 deg at 20 deg.
const HELD: f64 = 0.01;

/// Columns of a CSV file: `t` (s) or `phase` (cycles), and one with the coordinate.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// The file, relative to the case file.
    pub file: PathBuf,
    /// Name of the coordinate's column.
    pub column: String,
    /// Which column says when.
    #[serde(default)]
    pub by: TableBy,
    /// Whether it repeats; else it goes straight on beyond its ends. By phase, or with `harmonics`, it always does.
    #[serde(default)]
    pub periodic: bool,
    /// Factor on the coordinate.
    #[serde(default = "one")]
    pub scale: f64,
    /// Frequency of the motion in a table by time, Hz, where it is not the case's: the case runs through the table at
    /// its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Number of harmonics that stand in place of the table, fitted by least squares to all of its cycles: noise
    /// would else be differentiated twice. What they leave is printed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub harmonics: Option<usize>,
}

/// The column of a table that says when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TableBy {
    /// Column `t`, s.
    #[default]
    Time,
    /// Column `phase`, cycles.
    Phase,
}

impl TableBy {
    /// Name of the column.
    pub fn column(self) -> &'static str {
        match self {
            Self::Time => "t",
            Self::Phase => "phase",
        }
    }
}

fn one() -> f64 {
    1.0
}

/// What a fit of harmonics leaves of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Smoothed {
    /// Key of the coordinate.
    pub key: String,
    /// Number of harmonics.
    pub harmonics: usize,
    /// Number of samples.
    pub samples: usize,
    /// Root of the mean square of table less fit, in the unit of the key, scale included.
    pub residual_rms: f64,
    /// Largest magnitude of what the fit leaves, in the unit of the key.
    pub residual_largest: f64,
}

/// A coordinate as it is run.
pub(super) struct BuiltCoordinate {
    /// The coordinate in its own unit.
    pub coordinate: Coordinate,
    /// What smoothing left of its table.
    pub smoothed: Option<Smoothed>,
    /// What is wrong with its table.
    pub found: Vec<Finding>,
}

impl BuiltCoordinate {
    fn whole(coordinate: Coordinate) -> Self {
        Self { coordinate, smoothed: None, found: Vec::new() }
    }
}

impl CoordinateSpec {
    /// The coordinate in its own unit, with what its table says; tables are sought in `folder`.
    pub(super) fn build(
        &self,
        frequency_hz: f64,
        folder: &dyn Fn() -> PathBuf,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<BuiltCoordinate, Error> {
        Ok(match self {
            Self::Constant(value) => BuiltCoordinate::whole(Coordinate::Constant(*value)),
            Self::Fourier(f) => {
                let (cos, sin) = (f.cos.clone(), f.sin.clone());
                BuiltCoordinate::whole(Coordinate::Fourier { frequency_hz, mean: f.mean, cos, sin })
            }
            Self::Table(table) => {
                table.build(frequency_hz, &folder(), read, limits).map_err(|e| e.within("table"))?
            }
        })
    }
}

ranges!(TableSpec { frequency_hz: Range::POSITIVE, harmonics: Range::between(1.0, MOST_HARMONICS as f64) });

impl TableSpec {
    /// A table by time of one cycle at the case's frequency.
    pub fn repeating(file: PathBuf, column: &str) -> Self {
        let (by, column) = (TableBy::Time, column.to_owned());
        Self { file, column, by, periodic: true, scale: 1.0, frequency_hz: None, harmonics: None }
    }

    fn check(&self) -> Result<(), Error> {
        require::finite("scale", &[self.scale])?;
        self.in_range()?;
        let Some(frequency) = self.frequency_hz else { return Ok(()) };
        if self.by == TableBy::Phase {
            let error =
                Error::invalid("frequency_hz", frequency, "none: a phase has no frequency of its own");
            return Err(error.against(["by"]));
        }
        if !self.repeats() {
            let allowed = "only of a table that repeats: with periodic = true, or harmonics";
            return Err(Error::invalid("frequency_hz", frequency, allowed).against(["periodic"]));
        }
        Ok(())
    }

    fn repeats(&self) -> bool {
        self.periodic || self.by == TableBy::Phase || self.harmonics.is_some()
    }

    /// The factor that turns the table's column of when into time at the case's frequency, s.
    fn pace(&self, frequency_hz: f64) -> f64 {
        match self.by {
            TableBy::Phase => 1.0 / frequency_hz,
            TableBy::Time => self.frequency_hz.map_or(1.0, |own| own / frequency_hz),
        }
    }

    fn build(
        &self,
        frequency_hz: f64,
        folder: &Path,
        read: ReadTable,
        limits: &RunLimits,
    ) -> Result<BuiltCoordinate, Error> {
        self.check()?;
        let path = folder.join(&self.file);
        let record = read(&path).map_err(|what| Error::invalid("file", path.display(), what))?;
        let pace = self.pace(frequency_hz);
        let t: Vec<f64> = column(&record, self.by.column(), "file")?.iter().map(|t| t * pace).collect();
        let y: Vec<f64> = column(&record, &self.column, "column")?.iter().map(|y| y * self.scale).collect();
        let mut found = self.found((frequency_hz, limits), &t, &y);
        if let Some(count) = self.harmonics {
            if t.len().saturating_mul(count) > MOST_FITTED {
                let allowed = format!("at most {MOST_FITTED} over the {} samples of the table", t.len());
                return Err(Error::invalid("harmonics", count, allowed).against(["file"]));
            }
            let (coordinate, left, share) = smoothed(frequency_hz, &t, &y, count).ok_or_else(|| {
                let allowed = format!("fewer: the {} samples of the table do not determine so many", t.len());
                Error::invalid("harmonics", count, allowed).against(["file"])
            })?;
            found.extend(self.left(&left, share).filter(|finding| finding.breaks(limits)));
            return Ok(BuiltCoordinate { coordinate, smoothed: Some(left), found });
        }
        let spline = match self.repeats() {
            true => closed(&t, &y, 1.0 / frequency_hz),
            false => CubicSpline::natural(&t, &y),
        };
        let other = found.iter().find(|finding| finding.id == "data.frequency").map(Finding::words);
        let other = other.map_or(String::new(), |words| format!("; {words}"));
        let refused = |allowed: String| Error::invalid("file", path.display(), format!("{allowed}{other}"));
        self.in_order(&record, (pace, frequency_hz)).map_err(refused)?;
        Ok(BuiltCoordinate {
            coordinate: Coordinate::Table(spline.map_err(|error| refused(error.to_string()))?),
            smoothed: None,
            found,
        })
    }

    /// Refuses, in words, times that do not ascend, and more than a cycle of a table that repeats, whose times are `pace` times those of
    /// the record.
    fn in_order(&self, record: &Record, (pace, frequency_hz): (f64, f64)) -> Result<(), String> {
        let (name, unit) = match self.by {
            TableBy::Time => (self.by.column(), "s"),
            TableBy::Phase => (self.by.column(), "cycles"),
        };
        let when = record.values(name).unwrap_or_default();
        if let Some(row) = (1..when.len()).find(|&row| !(when[row] > when[row - 1])) {
            return Err(format!(
                "a column {name} that ascends: row {} has {} {unit} after {} {unit}",
                row + 1,
                when[row],
                when[row - 1]
            ));
        }
        let [first, .., last] = when else { return Ok(()) };
        let cycle = 1.0 / (frequency_hz * pace);
        if self.repeats() && last - first > cycle * (1.0 + CLOSED) {
            return Err(format!(
                "at most one cycle of a table that repeats, {cycle:.6} {unit}; {name} spans {:.6} {unit}: with harmonics it takes several",
                last - first
            ));
        }
        Ok(())
    }

    /// That harmonics leave `share` of the motion.
    fn left(&self, left: &Smoothed, share: f64) -> Option<Finding> {
        let Smoothed { harmonics, residual_rms, residual_largest, .. } = left;
        let text = format!(
            "{harmonics} harmonics leave {residual_rms:.4} rms of it, {share:.2} of the motion that they are, and {residual_largest:.4} \
             at most: spikes, a part at rest, or no cycle; mend the file, or take more harmonics"
        );
        let about = format!("{} of {}", self.column, self.file.display());
        share.is_finite().then(|| Finding::new("data.left", &LEFT, about, share, text))
    }

    /// What is wrong with a table, at times `t` (s) of the case. Harmonics take away noise, and ask for no order. Of one that need
    /// not repeat it is another frequency or noise, where it does repeat.
    fn found(&self, (frequency_hz, limits): (f64, &RunLimits), t: &[f64], y: &[f64]) -> Vec<Finding> {
        let phase: Vec<f64> = t.iter().map(|t| t * frequency_hz).collect();
        let own = self.frequency_hz.unwrap_or(frequency_hz);
        let series = Series {
            what: &self.file.display().to_string(),
            phase: &phase,
            frequency_hz: (self.by == TableBy::Time).then_some(own),
            channels: vec![MeasuredChannel { name: &self.column, unit: "(unit of the key)", samples: y }],
            purpose: Purpose::Motion,
        };
        let mended = |id: &str| match id {
            "data.frequency" => Some("table.frequency_hz".to_owned()),
            "data.rough" | "data.ends" => Some("table.harmonics".to_owned()),
            _ => None,
        };
        let smoothed =
            |id: &str| self.harmonics.is_some() && ["data.rough", "data.time", "data.ends"].contains(&id);
        let counts = |finding: &Finding| match self.repeats() {
            true => !smoothed(finding.id),
            false => ["data.frequency", "data.rough"].contains(&finding.id) && does_repeat(&phase, y),
        };
        let found = examined(&series, limits).into_iter().filter(counts);
        found
            .map(|finding| {
                let key = mended(finding.id);
                finding.mended_by(key)
            })
            .collect()
    }
}

/// Whether samples repeat, though nothing says that they do: harmonics of one frequency leave next to nothing of three cycles.
fn does_repeat(phase: &[f64], y: &[f64]) -> bool {
    let span = phase.last().unwrap_or(&0.0) - phase.first().unwrap_or(&0.0);
    estimate(phase, y).is_some_and(|found| found.ratio * span >= CYCLES && found.explained > REPEATS)
}

/// The column `name`; `key` is what asks for it.
fn column<'a>(record: &'a Record, name: &str, key: &str) -> Result<&'a [f64], Error> {
    let names = || record.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
    record.values(name).ok_or_else(|| Error::invalid(key, name, format!("one of {}", names())))
}

/// A periodic spline; a last sample that is the first of the next cycle goes.
fn closed(t: &[f64], y: &[f64], period: f64) -> Result<CubicSpline, Error> {
    match t {
        [first, inner @ .., last] if (last - first - period).abs() < CLOSED * period => {
            CubicSpline::periodic(&t[..=inner.len()], &y[..=inner.len()], period)
        }
        _ => CubicSpline::periodic(t, y, period),
    }
}

/// The fit, what it leaves, and how much that is in parts of the motion about its mean; not a number of a coordinate that is held
/// to its last digits or to noise.
fn smoothed(
    frequency_hz: f64,
    t: &[f64],
    y: &[f64],
    harmonics: usize,
) -> Option<(Coordinate, Smoothed, f64)> {
    let fit = Coordinate::fitted(frequency_hz, t, y, harmonics)?;
    let left = t.iter().zip(y).map(|(t, y)| y - fit.at(*t).x);
    let (square, residual_largest) =
        left.fold((0.0, 0.0_f64), |(square, most), left| (square + left * left, most.max(left.abs())));
    let (samples, residual_rms) = (t.len(), (square / t.len() as f64).sqrt());
    let mean = y.iter().sum::<f64>() / t.len() as f64;
    let moves = (t.iter().map(|t| (fit.at(*t).x - mean).powi(2)).sum::<f64>() / t.len() as f64).sqrt();
    let held = residual_rms < HELD * mean.abs() && moves < HELD * mean.abs();
    let share = if held { f64::NAN } else { residual_rms / moves };
    Some((fit, Smoothed { key: String::new(), harmonics, samples, residual_rms, residual_largest }, share))
}
