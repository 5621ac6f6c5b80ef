//! What a calibration file says.

use super::RunName;
use super::verdict_limits::VerdictLimits;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use wingbeat_math::DeclaredQuantity;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_robot::MOST_HARMONICS;

/// A calibration: numbers of robot and rig fitted to runs on the load cell.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
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
    /// The runs on the rig.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<CalibratedRunSpec>,
    /// Cases of a tethered wing that are fitted beside the runs, or alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cases: Vec<CalibratedCaseSpec>,
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
    /// Limits of the verdict in place of the usual ones, by name: `calibration.phase_deg = 8.0`.
    #[serde(default, skip_serializing_if = "VerdictLimits::is_empty")]
    pub limits: VerdictLimits,
}

/// Runs laid out for the next one: all combinations of what may vary of one run.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignSpec {
    /// File of the run on the rig, or the run itself.
    #[schemars(schema_with = "crate::schema::file_or::<crate::RigRunSpec>")]
    pub run: toml::Value,
    /// Overrides of the run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// What varies.
    pub vary: Vec<VariedSpec>,
}

/// A key of a run with the values that it may have.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VariedSpec {
    /// Key of the run, `frequency_hz`, `turn.speed_m_s`, `turn.roll_deg`, `hold.tilts_deg`, `wind_m_s`.
    pub key: String,
    /// Values as they would stand behind the key: numbers, `"[-1.2, 0.0, 0.0]"`.
    #[schemars(with = "Vec<crate::sweep_spec::Listed>")]
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
            CalibratedRunSpec { run, name, set, data: Vec::new(), held_out: false, residual: false }
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
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StructureOfModel {
    /// What the report calls it.
    pub name: String,
    /// Overrides of every run, after those of `model`.
    pub set: Vec<String>,
}

/// A run of a calibration.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibratedRunSpec {
    /// File of the run on the rig, or the run itself.
    #[schemars(schema_with = "crate::schema::file_or::<crate::RigRunSpec>")]
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
    /// True for a run that is not fitted, and of which is learned what the fitted model leaves of its loads: residual.toml, for
    /// `robot.residual`. Such runs flap at one frequency, each at one velocity against the air.
    #[serde(default)]
    pub residual: bool,
}

/// A case of a tethered wing in a calibration.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibratedCaseSpec {
    /// File of the case, or the case itself. Its `compare` says which columns of the samples are which: forces and moments in body
    /// axes, `force_x` to `moment_z`, as many of them as were measured.
    #[schemars(schema_with = "crate::schema::file_or::<crate::TetherSpec>")]
    pub case: toml::Value,
    /// What the report calls it; without it the case's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Overrides of the case. Those of `model` and of `structures` that begin with `rig.aero.` come first, without their `rig.`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// CSV files of samples, one per pass of the same case.
    pub data: Vec<PathBuf>,
    /// True for a case that is only predicted.
    #[serde(default)]
    pub held_out: bool,
}

/// A number to be fitted.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterSpec {
    /// Name, `surfaces.wing.cd0`, `links.twist.mass_kg` (both sides), `mount.shift_m[2]`, `gait.phase_rad`.
    pub name: String,
    /// Where the fit begins, in the unit of the number; without it the value of the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<f64>,
    /// Lowest value, in the unit of the number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Highest value, in the unit of the number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// What is known beforehand: mean and standard deviation, in the unit of the number.
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
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
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
    harmonics: Range::between(1.0, MOST_HARMONICS as f64),
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
        if let Some(k) = self.runs.iter().position(|run| run.held_out && run.residual) {
            let allowed = "not beside residual = true: a run is predicted alone or learned from";
            return Err(Error::invalid(format!("runs[{k}].held_out"), true, allowed));
        }
        if let Some(k) = self.candidates.iter().position(|run| run.residual) {
            let allowed = "no residual = true among candidates: a next run is one that is fitted";
            return Err(Error::invalid(format!("candidates[{k}].residual"), true, allowed));
        }
        let held = self.runs.iter().map(|run| run.held_out || run.residual);
        if held.chain(self.cases.iter().map(|case| case.held_out)).all(|held| held) {
            let given = format!("{} runs and {} cases", self.runs.len(), self.cases.len());
            return Err(Error::invalid("runs", given, "a run or a case that is fitted"));
        }
        if self.parameters.iter().all(|parameter| parameter.held) {
            let given = format!("{} parameters", self.parameters.len());
            return Err(Error::invalid("parameters", given, "one that is not held"));
        }
        for (k, parameter) in self.parameters.iter().enumerate() {
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
        self.check_stages()?;
        let runs = self.runs.iter().enumerate().map(|(k, run)| (format!("runs[{k}]"), &run.data));
        let cases = self.cases.iter().enumerate().map(|(k, case)| (format!("cases[{k}]"), &case.data));
        let mut seen: Vec<&PathBuf> = Vec::new();
        for (key, data) in runs.chain(cases) {
            if data.is_empty() && (self.truth.is_none() || key.starts_with("cases")) {
                let made = if key.starts_with("runs") { ", or a [truth] that makes them" } else { "" };
                let allowed = format!("files of samples{made}");
                return Err(Error::invalid(format!("{key}.data"), "none", allowed));
            }
            for (i, file) in data.iter().enumerate() {
                let given = file.display();
                if data[..i].contains(file) {
                    return Err(Error::invalid(format!("{key}.data[{i}]"), given, "each file once"));
                }
                if seen.contains(&file) {
                    let allowed = "a file that no other run names";
                    return Err(Error::invalid(format!("{key}.data[{i}]"), given, allowed));
                }
            }
            seen.extend(data);
        }
        Ok(())
    }

    /// Refuses stages in which nothing is fitted, and numbers of the air before masses and centres: what they would take up of an inertia
    /// that is not yet fitted they would keep.
    fn check_stages(&self) -> Result<(), Error> {
        let fitted = || self.parameters.iter().enumerate().filter(|(_, parameter)| !parameter.held);
        for (k, parameter) in fitted() {
            let key = format!("parameters[{k}].stage");
            let empty = (1..parameter.stage).find(|stage| !fitted().any(|(_, other)| other.stage == *stage));
            if let Some(stage) = empty {
                let allowed = format!("at most {stage}: no number is fitted in stage {stage}");
                return Err(Error::invalid(key, parameter.stage, allowed));
            }
            if parameter.stage == 0 {
                return Err(Error::invalid(key, 0, "1 or more"));
            }
            let inertia = |name: &str| INERTIA.iter().any(|of| name.contains(of));
            let later = fitted().find(|(_, other)| other.stage > parameter.stage && inertia(&other.name));
            if let Some((other, later)) = later
                && AIR.iter().any(|of| parameter.name.starts_with(of))
                && !inertia(&parameter.name)
            {
                let allowed = format!(
                    "{} or more: masses and centres come before the air, and {} is of stage {}",
                    later.stage, later.name, later.stage
                );
                let against = [format!("parameters[{other}].stage")];
                return Err(Error::invalid(key, parameter.stage, allowed).against(against));
            }
        }
        Ok(())
    }
}

/// What the names of numbers of inertia contain.
const INERTIA: [&str; 3] = ["mass_kg", "com_m", "inertia_kg_m2"];
/// What the names of numbers of the air begin with.
const AIR: [&str; 2] = ["surfaces.", "air."];

impl ParameterSpec {
    /// Lowest and highest value of the number that `quantity` declares, in its unit.
    pub fn bounds(&self, quantity: &DeclaredQuantity) -> [f64; 2] {
        let [low, high] = quantity.given;
        [self.low.unwrap_or(low), self.high.unwrap_or(high)]
    }

    /// Refuses bounds, a start and a prior that the number that `quantity` declares cannot have.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key.
    pub fn check(&self, quantity: &DeclaredQuantity) -> Result<(), Error> {
        let [lowest, highest] = quantity.given;
        for (key, value) in [("low", self.low), ("high", self.high)] {
            let Some(value) = value else { continue };
            Range::between(lowest, highest).check(key, value)?;
        }
        let [low, high] = self.bounds(quantity);
        if low >= high {
            return Err(Error::invalid("low", low, format!("below {high}")).against(["high"]));
        }
        let within = Range::between(low, high);
        self.start.map_or(Ok(()), |start| within.check("start", start))?;
        let Some([mean, deviation]) = self.prior else { return Ok(()) };
        // A prior in another unit, degrees for radians, mostly lies where the number cannot.
        within.check("prior[0]", mean)?;
        Range::POSITIVE.check("prior[1]", deviation)
    }
}
