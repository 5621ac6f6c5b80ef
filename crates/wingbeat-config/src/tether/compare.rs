//! The loads of a case beside a measured file.

use super::TetherCase;
use crate::{ConfigError, TableBy};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_flight::tether::{CycleFit, PHASES, TetherRun, cycle_of, fit, smooth};
use wingbeat_judge::data::{CyclePair, Finding, MeasuredChannel, Purpose, Series, compared, examined};
use wingbeat_judge::limits::data::OTHER_FREQUENCY;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// How a measured file is read.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct CompareSpec {
    /// Which column says when.
    pub by: TableBy,
    /// Frequency of the measured motion, Hz, where it is not the case's; of a file by time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Columns of the file by the columns of the loads that they are compared with, as `force_z = "Fz"`. Without any,
    /// columns of one name.
    pub channels: BTreeMap<String, String>,
    /// Factors on the columns of the file, by the columns of the loads: their unit and sign, `force_z = -1e-3` where the file has
    /// mN downwards.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub scale: BTreeMap<String, f64>,
}

/// Sizes of a factor from one unit to another: nN and GN are the ends.
const FACTORS: RangeInclusive<f64> = 1e-9..=1e9;

ranges!(CompareSpec { frequency_hz: Range::POSITIVE });

impl CompareSpec {
    pub(super) fn is_empty(&self) -> bool {
        self.by == TableBy::Time
            && self.frequency_hz.is_none()
            && self.channels.is_empty()
            && self.scale.is_empty()
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        for (our, factor) in &self.scale {
            if !FACTORS.contains(&factor.abs()) {
                let allowed = format!("{:e} to {:e}, of either sign", FACTORS.start(), FACTORS.end());
                return Err(Error::invalid(format!("scale.{our}"), factor, allowed));
            }
        }
        let Some(frequency) = self.frequency_hz else { return Ok(()) };
        if self.by == TableBy::Phase {
            let error =
                Error::invalid("frequency_hz", frequency, "none: a phase has no frequency of its own");
            return Err(error.against(["by"]));
        }
        self.in_range()
    }
}

/// A computed column beside a measured one.
#[derive(Clone, Debug, Serialize)]
pub struct Compared {
    /// Column of the loads.
    pub computed: String,
    /// Column of the file.
    pub measured: String,
    /// Whole cycles measured.
    pub cycles: usize,
    /// Lag at the frequency of the measured motion, s; none of a file by phase.
    pub lag_s: Option<f64>,
    /// Lag, gain, offset and what is left.
    #[serde(flatten)]
    pub fit: CycleFit,
}

/// A comparison with a file.
#[derive(Clone, Debug)]
pub struct MeasuredComparison {
    /// One per channel.
    pub channels: Vec<Compared>,
    /// What is wrong with the measured data, by themselves and beside the loads of the case.
    pub found: Vec<Finding>,
    /// Over the phase: `measured_*`, `low_*`, `high_*`, `computed_*`, `fitted_*` of each channel.
    pub cycle: Record,
}

impl TetherCase {
    /// The channels that a measured file and the loads have in common: columns of the loads with those of the file.
    ///
    /// # Errors
    /// A channel that one of them has not; none at all.
    pub fn channels(&self, measured: &Record) -> Result<Vec<(String, String)>, ConfigError> {
        let found = self.found_channels(measured);
        found.map_err(|error| self.document.explain(&error.within("compare")))
    }

    fn found_channels(&self, measured: &Record) -> Result<Vec<(String, String)>, Error> {
        let loads = self.tether.columns()?;
        let names = |columns: &[Column]| {
            let names = columns.iter().map(|column| column.name.clone());
            names.filter(|name| !["t", "phase"].contains(&name.as_str())).collect::<Vec<_>>()
        };
        let (ours, theirs) = (names(loads.columns()), names(measured.columns()));
        if let Some((our, factor)) = self.spec.compare.scale.iter().find(|(our, _)| !ours.contains(our)) {
            let allowed = format!("under a column of the loads: {}", ours.join(", "));
            return Err(Error::invalid(format!("scale.{our}"), factor, allowed));
        }
        if self.spec.compare.channels.is_empty() {
            let both: Vec<_> = ours
                .into_iter()
                .filter(|name| theirs.contains(name))
                .map(|name| (name.clone(), name))
                .collect();
            self.scales_one_of(&both)?;
            if both.is_empty() {
                let allowed =
                    format!("column of the loads = column of the file; it has {}", theirs.join(", "));
                return Err(Error::invalid("channels", "none, and no column of one name", allowed));
            }
            return Ok(both);
        }
        for (our, their) in &self.spec.compare.channels {
            let key = format!("channels.{our}");
            if !ours.contains(our) {
                return Err(Error::invalid(
                    key,
                    their,
                    format!("under a column of the loads: {}", ours.join(", ")),
                ));
            }
            if called(their, &theirs).is_none() {
                return Err(Error::invalid(
                    key,
                    their,
                    format!("a column of the file: {}", theirs.join(", ")),
                ));
            }
        }
        let found =
            |(our, their): (&String, &String)| Some((our.clone(), called(their, &theirs)?.to_owned()));
        let channels: Vec<_> = self.spec.compare.channels.iter().filter_map(found).collect();
        self.scales_one_of(&channels)?;
        Ok(channels)
    }

    /// Refuses a factor on a column that is not compared.
    fn scales_one_of(&self, channels: &[(String, String)]) -> Result<(), Error> {
        let compared = |our: &String| channels.iter().any(|(compared, _)| compared == our);
        match self.spec.compare.scale.iter().find(|(our, _)| !channels.is_empty() && !compared(our)) {
            None => Ok(()),
            Some((our, factor)) => {
                let names: Vec<_> = channels.iter().map(|(our, _)| our.as_str()).collect();
                let allowed = format!("under a column that is compared: {}", names.join(", "));
                Err(Error::invalid(format!("scale.{our}"), factor, allowed))
            }
        }
    }

    /// The phase of the measured rows, cycles.
    ///
    /// # Errors
    /// No column that says when, or one that does not ascend.
    pub fn measured_phase(&self, measured: &Record) -> Result<Vec<f64>, Error> {
        let spec = &self.spec.compare;
        let name = spec.by.column();
        let when = measured.values(name).ok_or_else(|| {
            let names: Vec<_> = measured.columns().iter().map(|column| column.name.as_str()).collect();
            Error::invalid("columns", names.join(", "), format!("one called {name} among them (compare.by)"))
        })?;
        if let Some(row) = (1..when.len()).find(|row| when[*row] <= when[row - 1]) {
            let key = format!("row {} of the data, column {name}", row + 1);
            let grows = match spec.by {
                TableBy::Phase => "; a phase grows on from cycle to cycle",
                TableBy::Time => "",
            };
            let allowed = format!("more than {} before it{grows}", when[row - 1]);
            return Err(Error::invalid(key, when[row], allowed));
        }
        let pace = match spec.by {
            TableBy::Phase => 1.0,
            TableBy::Time => self.measured_frequency(),
        };
        let span = when.last().zip(when.first()).map_or(0.0, |(last, first)| last - first);
        if pace * span > when.len() as f64 {
            let unit = match spec.by {
                TableBy::Phase => "is it in cycles? Degrees are to be divided by 360",
                TableBy::Time => "is it in s? A header such as `t [ms]` says another unit",
            };
            let key = format!("column {name} of the data");
            let given = format!("{:.0} cycles in {} rows", pace * span, when.len());
            return Err(Error::invalid(key, given, format!("a row or more in each cycle: {unit}")));
        }
        Ok(when.iter().map(|when| pace * when).collect())
    }

    /// Column `theirs` of a measured file in the unit and with the sign of the column `ours` of the loads.
    pub fn measured_values(&self, measured: &Record, ours: &str, theirs: &str) -> Vec<f64> {
        let factor = self.spec.compare.scale.get(ours).copied().unwrap_or(1.0);
        measured.values(theirs).unwrap_or_default().iter().map(|value| factor * value).collect()
    }

    /// Frequency of the measured motion, Hz.
    pub fn measured_frequency(&self) -> f64 {
        self.spec.compare.frequency_hz.unwrap_or(self.spec.time.frequency_hz)
    }

    /// Compares the last cycle of a run with the measured one. `channels` are those of [`channels`](Self::channels).
    ///
    /// # Errors
    /// Those of [`measured_phase`](Self::measured_phase); less than a cycle measured or computed; a column that does
    /// not vary.
    pub fn compare(
        &self,
        run: &TetherRun,
        measured: &Record,
        channels: &[(String, String)],
    ) -> Result<MeasuredComparison, Error> {
        let phase = self.measured_phase(measured)?;
        let even: Vec<f64> = (0..PHASES).map(|i| i as f64 / PHASES as f64).collect();
        let mut columns = vec![Column { values: even.clone(), ..Column::new("phase", "cycles", "") }];
        let mut compared = Vec::new();
        for (ours, theirs) in channels {
            let values = self.measured_values(measured, ours, theirs);
            let cycle = cycle_of(&phase, &values).map_err(|e| e.renamed(&[("process.window_s", theirs)]))?;
            let computed = run.last_cycle(ours).unwrap_or_default();
            let named = [("measured", theirs), ("computed", ours)];
            let fit = fit(&cycle.mean, computed).map_err(|e| e.renamed(&named))?;
            let curve = smooth(computed)?;
            let drawn = |lag: f64| even.iter().map(|phase| curve.at(phase - lag).x).collect::<Vec<_>>();
            let fitted = drawn(fit.lag_cycles).iter().map(|c| fit.offset + fit.gain * c).collect();
            let unit = run.loads.column(ours).map_or("", |column| column.unit.as_str());
            for (kind, unit, values) in [
                ("measured", "", cycle.mean),
                ("low", "", cycle.low),
                ("high", "", cycle.high),
                ("computed", unit, drawn(0.0)),
                ("fitted", "", fitted),
            ] {
                columns.push(Column { values, ..Column::new(format!("{kind}_{ours}"), unit, "") });
            }
            let lag_s =
                (self.spec.compare.by == TableBy::Time).then(|| fit.lag_cycles / self.measured_frequency());
            let (computed, measured) = (ours.clone(), theirs.clone());
            compared.push(Compared { computed, measured, cycles: cycle.cycles, lag_s, fit });
        }
        let cycle = Record::new(columns, PHASES)?;
        let found = self.suspected(run, measured, (channels, &phase), &cycle);
        Ok(MeasuredComparison { channels: compared, found, cycle })
    }

    /// That the measured motion is faster or slower than that of the case.
    fn other_frequency(&self) -> Option<Finding> {
        let (own, measured) = (self.spec.time.frequency_hz, self.spec.compare.frequency_hz?);
        let off = (measured / own - 1.0).abs();
        let text = format!(
            "the case moves at {own:.4} Hz, the measured motion at {measured:.4} Hz (compare.frequency_hz): at another reduced frequency \
             loads are others; set time.frequency_hz, or the wind so that both have the same"
        );
        Some(Finding::new("data.other_frequency", &OTHER_FREQUENCY, MEASURED.to_owned(), off, text))
    }

    /// What is wrong with the measured channels, and what of their `cycle` cannot be that of the case. Lag and gain are what the
    /// comparison fits, so that a shift is noted alone.
    fn suspected(
        &self,
        run: &TetherRun,
        measured: &Record,
        (channels, phase): (&[(String, String)], &[f64]),
        cycle: &Record,
    ) -> Vec<Finding> {
        let unit = |ours: &str| run.loads.column(ours).map_or("", |column| column.unit.as_str());
        let samples: Vec<Vec<f64>> =
            channels.iter().map(|(ours, theirs)| self.measured_values(measured, ours, theirs)).collect();
        let by_time = self.spec.compare.by == TableBy::Time;
        let series = Series {
            what: MEASURED,
            phase,
            frequency_hz: by_time.then(|| self.measured_frequency()),
            channels: channels
                .iter()
                .zip(&samples)
                .map(|((ours, theirs), samples)| MeasuredChannel { name: theirs, unit: unit(ours), samples })
                .collect(),
            purpose: Purpose::Datum,
        };
        let mut found = examined(&series, &self.limits);
        found.extend(self.other_frequency().filter(|finding| finding.breaks(&self.limits)));
        // Cycles of another frequency are none.
        if !found.iter().any(|finding| finding.id == "data.frequency") {
            let of = |kind: &str, ours: &str| cycle.values(&format!("{kind}_{ours}")).unwrap_or_default();
            let sampled = |(ours, _): &(String, String)| {
                let sampled = if is_sparse(phase) { as_sampled(run.last_cycle(ours)?, phase) } else { None };
                Some(sampled.unwrap_or_else(|| of("computed", ours).to_vec()))
            };
            let all: Vec<Vec<f64>> = channels.iter().map(|pair| sampled(pair).unwrap_or_default()).collect();
            let mut pairs = Vec::new();
            for ((ours, theirs), computed) in channels.iter().zip(&all) {
                let measured = of("measured", ours);
                pairs.push(CyclePair { name: theirs, unit: unit(ours), measured, computed });
            }
            let beside = compared(MEASURED, &pairs, &self.limits).into_iter();
            // The gain is only a warning by its own limit; another unit is no gain.
            found.extend(beside.map(|f| if f.id == "data.shift" { f.noted() } else { f }));
        }
        found.into_iter().map(mended_in_compare).collect()
    }
}

/// The column of `theirs` that is called `name`, or else the only one that is the same load of a cell by another name: `Fz` is `force_z`.
fn called<'a>(name: &str, theirs: &'a [String]) -> Option<&'a str> {
    if let Some(own) = theirs.iter().find(|own| *own == name) {
        return Some(own);
    }
    let load = load_of(name)?;
    let mut same = theirs.iter().filter(|own| load_of(own).is_some_and(|own| own == load));
    same.next().filter(|_| same.next().is_none()).map(String::as_str)
}

/// Names before the axis of a force, and of a moment.
const LOADS: [&[&str]; 2] = [&["force_", "f_", "f"], &["moment_", "torque_", "m_", "t_", "m", "t"]];

/// Which load of a cell a name is, and along which axis.
fn load_of(name: &str) -> Option<(usize, String)> {
    let name = name.to_lowercase();
    let axis = |kind: &str| name.strip_prefix(kind).filter(|axis| ["x", "y", "z"].contains(axis));
    LOADS
        .iter()
        .enumerate()
        .find_map(|(kind, names)| Some((kind, names.iter().find_map(|n| axis(n))?.to_owned())))
}

/// Whether samples at these phases (cycles) are so few of a cycle that its harmonics turn into one another.
fn is_sparse(phase: &[f64]) -> bool {
    let cycles = phase.last().zip(phase.first()).map_or(0.0, |(last, first)| last - first);
    (phase.len() as f64) < SPARSE * cycles
}

/// The mean cycle that samples at these phases (cycles) show of a computed one: as what is measured, so that both have the same
/// harmonics.
fn as_sampled(computed: &[f64], phase: &[f64]) -> Option<Vec<f64>> {
    let curve = smooth(computed).ok()?;
    let samples: Vec<f64> = phase.iter().map(|phase| curve.at(*phase).x).collect();
    Some(cycle_of(phase, &samples).ok()?.mean)
}

/// Samples of a cycle below which it counts as sparse. *Choice*: loads of flapping wings have 20 harmonics at most.
const SPARSE: f64 = 40.0;

/// What findings call the file of a comparison.
const MEASURED: &str = "the measured file";

/// A finding in data that `compare` reads, with the key of the case that mends it.
pub fn mended_in_compare(finding: Finding) -> Finding {
    let key = match finding.id {
        "data.frequency" | "data.other_frequency" => Some("compare.frequency_hz"),
        "data.reversed" | "data.scaled" | "data.tiny" | "data.huge" => Some("compare.scale"),
        "data.swapped" | "data.dead" => Some("compare.channels"),
        _ => None,
    };
    finding.mended_by(key.map(Into::into))
}
