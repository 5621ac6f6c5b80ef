//! What a calibration file says.

use super::RunName;
use crate::Error;
use crate::range::{Range, ranges};
use crate::robot::bounds;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A calibration: numbers of robot and rig fitted to runs on the load cell.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct CalibrationSpec {
    /// Name; the run folder is called after it.
    pub name: String,
    /// Seed of the starts, and of the noise of runs that `truth` makes.
    #[serde(default)]
    pub seed: u64,
    /// Harmonics of the flapping frequency, beside the mean, by which the cycles are held against the model.
    #[serde(default = "harmonics")]
    pub harmonics: usize,
    /// Steps of the model per cycle.
    #[serde(default = "steps_per_cycle")]
    pub steps_per_cycle: usize,
    /// Starts of the fit: the first from the values given, the others drawn evenly within `start_spread` of them.
    #[serde(default = "starts")]
    pub starts: usize,
    /// Share of its value by which a start may differ; of a number that is zero, share of its prior's deviation or of its
    /// range.
    #[serde(default = "start_spread")]
    pub start_spread: f64,
    /// Whether what the model cannot say is added to the noise (fitted by channel and harmonic); without it the noise of the
    /// cycles alone weighs.
    #[serde(default = "yes")]
    pub discrepancy: bool,
    /// Whether cycles far from the others count less (Huber's loss at 1.345 deviations); without it all count alike.
    #[serde(default = "yes")]
    pub robust: bool,
    /// Overrides of every run, `rig.aero.law=stall`: the structure of the model that is fitted.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub model: Vec<String>,
    /// Other structures that are fitted to the same runs and compared by the error in runs left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub structures: Vec<StructureOfModel>,
    /// The runs.
    pub runs: Vec<CalibratedRunSpec>,
    /// What is fitted.
    pub parameters: Vec<ParameterSpec>,
    /// Makes the samples of runs without files: a robot that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<TruthSpec>,
    /// Runs among which the next one is chosen.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<CalibratedRunSpec>,
    /// Runs laid out for the next one, beside `candidates`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub design: Vec<DesignSpec>,
}

/// Runs laid out for the next one: all combinations of what may vary of one run.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DesignSpec {
    /// File of the run on the rig, or the run itself.
    #[cfg_attr(
        feature = "schema",
        schemars(schema_with = "crate::scenario::schema::file_or::<crate::scenario::RigRunSpec>")
    )]
    pub run: toml::Value,
    /// Overrides of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// What varies.
    pub vary: Vec<VariedSpec>,
}

/// A key of a run with the values that it may have.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct VariedSpec {
    /// Key of the run, `frequency_hz`, `turn.speed_m_s`, `turn.roll_deg`, `hold.tilts_deg`, `wind_m_s`.
    pub key: String,
    /// Values as they would stand behind the key: numbers, `"[-1.2, 0.0, 0.0]"`.
    #[cfg_attr(feature = "schema", schemars(with = "Vec<crate::scenario::sweep_spec::Listed>"))]
    pub values: Vec<toml::Value>,
}

/// Most runs that a calibration lays out for the next one.
const MOST_LAID_OUT: usize = 400;

impl DesignSpec {
    /// How many runs it lays out.
    fn count(&self) -> usize {
        self.vary.iter().map(|varied| varied.values.len()).fold(1, usize::saturating_mul)
    }

    /// Every combination: a name, and the run with its overrides.
    pub fn laid_out(&self) -> Vec<CalibratedRunSpec> {
        let one = |mut number: usize| {
            let (mut set, mut words) = (self.set.clone(), Vec::new());
            for VariedSpec { key, values } in &self.vary {
                let value = match &values[number % values.len()] {
                    toml::Value::String(text) => text.clone(),
                    value => value.to_string(),
                };
                number /= values.len();
                words.push(format!("{key}={value}"));
                set.push(format!("{key}={value}"));
            }
            let (run, name) = (self.run.clone(), Some(words.join(" ")));
            CalibratedRunSpec { run, name, set, data: Vec::new(), held_out: false }
        };
        (0..self.count()).map(one).collect()
    }

    fn check(&self) -> Result<(), Error> {
        for (k, VariedSpec { values, .. }) in self.vary.iter().enumerate() {
            if values.is_empty() {
                return Err(Error::invalid(format!("vary[{k}].values"), "none", "at least one value"));
            }
        }
        match self.count() {
            count if (1..=MOST_LAID_OUT).contains(&count) => Ok(()),
            count => {
                Err(Error::invalid("vary", format!("{count} runs"), format!("1 to {MOST_LAID_OUT} runs")))
            }
        }
    }
}

/// Another structure of the model.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StructureOfModel {
    /// What the report calls it.
    pub name: String,
    /// Overrides of every run, after those of `model`.
    pub set: Vec<String>,
}

/// A run of a calibration.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibratedRunSpec {
    /// File of the run on the rig, or the run itself.
    #[cfg_attr(
        feature = "schema",
        schemars(schema_with = "crate::scenario::schema::file_or::<crate::scenario::RigRunSpec>")
    )]
    pub run: toml::Value,
    /// What the report calls it; without it the run's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Overrides of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Files of samples, one per pass of the same run; without any `truth` makes them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub data: Vec<PathBuf>,
    /// True for a run that is only predicted.
    #[serde(default)]
    pub held_out: bool,
}

/// A number to be fitted.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// Name, `surfaces.wing.cd0`, `links.twist.mass_kg` (both sides), `mount.shift_m[2]`, `gait.phase_rad`.
    pub name: String,
    /// Where the fit begins; without it the value of the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Lowest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Highest value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// What is known beforehand: mean and standard deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<[f64; 2]>,
    /// True to hold it at its start; it is then only named in the report.
    #[serde(default)]
    pub held: bool,
    /// Stage of the fit in which it joins: those of stage 1 are fitted first, then those of stages 1 and 2 together.
    #[serde(default = "one")]
    pub stage: usize,
}

/// A robot whose runs are simulated in place of measured ones.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(transform = crate::range::put(Self::RANGES)))]
#[serde(deny_unknown_fields)]
pub struct TruthSpec {
    /// Overrides of every run in place of `model`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Passes of every run.
    #[serde(default = "passes")]
    pub passes: usize,
    /// Loads that differ from instant to instant (gusts, arm, structure), as deviation in parts of each channel's rms:
    /// first-order noise of the time `unrest_time_s`.
    #[serde(default = "unrest")]
    pub unrest: f64,
    /// Time over which that noise forgets itself, s.
    #[serde(default = "unrest_time")]
    pub unrest_time_s: f64,
}

ranges!(CalibrationSpec {
    harmonics: Range::between(1.0, 40.0),
    steps_per_cycle: Range::between(32.0, 4000.0),
    starts: Range::between(1.0, 100.0),
    start_spread: Range::between(0.0, 1.0),
});
ranges!(TruthSpec {
    passes: Range::between(1.0, 1000.0),
    unrest: Range::between(0.0, 1.0),
    unrest_time_s: Range::between(1e-4, 10.0),
});

fn harmonics() -> usize {
    10
}
fn steps_per_cycle() -> usize {
    200
}
fn starts() -> usize {
    3
}
fn start_spread() -> f64 {
    0.2
}
fn yes() -> bool {
    true
}
fn one() -> usize {
    1
}
fn passes() -> usize {
    7
}
pub(super) fn unrest() -> f64 {
    0.01
}
pub(super) fn unrest_time() -> f64 {
    0.02
}

impl CalibrationSpec {
    /// The name of the run folder.
    ///
    /// # Errors
    /// A name that is none.
    pub fn run_name(&self) -> Result<RunName, Error> {
        RunName::new("name", &self.name)
    }

    /// Checks what the file says by itself.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self) -> Result<(), Error> {
        self.run_name()?;
        self.in_range()?;
        self.truth.as_ref().map_or(Ok(()), |truth| truth.in_range().map_err(|e| e.within("truth")))?;
        if self.runs.iter().all(|run| run.held_out) {
            return Err(Error::invalid("runs", format!("{} runs", self.runs.len()), "a run that is fitted"));
        }
        if self.parameters.iter().all(|parameter| parameter.held) {
            let given = format!("{} parameters", self.parameters.len());
            return Err(Error::invalid("parameters", given, "one that is not held"));
        }
        for (k, parameter) in self.parameters.iter().enumerate() {
            parameter.check().map_err(|e| e.within(&format!("parameters[{k}]")))?;
            if self.parameters[..k].iter().any(|other| other.name == parameter.name) {
                return Err(Error::invalid(
                    format!("parameters[{k}].name"),
                    &parameter.name,
                    "each name once",
                ));
            }
        }
        for (k, design) in self.design.iter().enumerate() {
            design.check().map_err(|e| e.within(&format!("design[{k}]")))?;
        }
        for (k, run) in self.runs.iter().enumerate() {
            if run.data.is_empty() && self.truth.is_none() {
                let allowed = "files of samples, or a [truth] that makes them";
                return Err(Error::invalid(format!("runs[{k}].data"), "none", allowed));
            }
            let twice = (1..run.data.len()).find(|&i| run.data[..i].contains(&run.data[i]));
            if let Some(i) = twice {
                let given = run.data[i].display();
                return Err(Error::invalid(format!("runs[{k}].data[{i}]"), given, "each file once"));
            }
            let shared = |file: &PathBuf| self.runs[..k].iter().any(|other| other.data.contains(file));
            if let Some(i) = run.data.iter().position(shared) {
                let given = run.data[i].display();
                let allowed = "a file that no other run names";
                return Err(Error::invalid(format!("runs[{k}].data[{i}]"), given, allowed));
            }
        }
        Ok(())
    }
}

impl ParameterSpec {
    /// Lowest and highest value.
    pub fn bounds(&self) -> [f64; 2] {
        let [low, high] = bounds(&self.name);
        [self.low.unwrap_or(low), self.high.unwrap_or(high)]
    }

    fn check(&self) -> Result<(), Error> {
        let widest = bounds(&self.name);
        for (key, value) in [("low", self.low), ("high", self.high)] {
            let Some(value) = value else { continue };
            Range::between(widest[0], widest[1]).check(key, value)?;
        }
        let [low, high] = self.bounds();
        if low >= high {
            return Err(Error::invalid("low", low, format!("below {high}")).against(["high"]));
        }
        let within = Range::between(low, high);
        self.start.map_or(Ok(()), |start| within.check("start", start))?;
        let Some([_, deviation]) = self.prior else { return Ok(()) };
        Range::POSITIVE.check("prior[1]", deviation)
    }
}
