//! What a search of gaits is asked.

use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;

/// Most starts of a search, and most numbers that it varies.
const MAX_STARTS: usize = 10_000;
const MAX_VARIED: usize = 200;
/// Most airs beside the scenario's own.
const MAX_AIRS: usize = 100;

/// The gait that does something best, among those that fly the orbit which `[trim]` asks for.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct SearchSpec {
    /// What is to be best.
    pub goal: Goal,
    /// Keys of the scenario that are varied, each within its range.
    pub vary: Vec<VarySpec>,
    /// Numbers of strips at which the limits have to hold as well, beside the scenario's own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strips: Vec<usize>,
    /// Other airs, or other flights, of the same gait: each a list of settings as `--set` takes them, such as
    /// `["aero.law=lev", "trim.bank_deg=30"]`. In each the gait has an orbit of its own, for which the frequency or commands are
    /// chosen anew. The limits have to hold in all of them, and the power is the mean of all. None sets a key that `vary` varies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub airs: Vec<Vec<String>>,
    /// What a gait has to keep to.
    pub limits: LimitsSpec,
    /// Number of starts: the first from the scenario's own gait, the others from beside it.
    #[serde(default = "one")]
    pub starts: usize,
    /// How far beside, at most, as a share of each range.
    #[serde(default = "tenth")]
    pub spread: f64,
    /// Seed of the starts.
    #[serde(default)]
    pub seed: u64,
    /// Most iterations from a start: steps that are tried, also those that are refused.
    #[serde(default = "sixty")]
    pub iterations: usize,
}

fn one() -> usize {
    1
}
fn tenth() -> f64 {
    0.1
}
fn sixty() -> usize {
    60
}

/// What is to be best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// The least mean of the positive part of the total power of the driven joints, over the mass; the mean of all `airs`.
    Power,
    /// The lowest frequency of the gait.
    Frequency,
    /// The largest mass that is carried; among the varied keys is one that carries it, such as `robot.body.mass_kg`.
    Payload,
}

/// A number that is varied.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VarySpec {
    /// Key of the scenario, e.g. `robot.links[0].driven.mean_rad` or `trim.speed_m_s`.
    pub key: String,
    /// Lower end, in the unit of the key.
    pub low: f64,
    /// Upper end, in the unit of the key.
    pub high: f64,
}

/// What a gait has to keep to; what is not given is free.
#[derive(Clone, Debug, Default, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct LimitsSpec {
    /// Least clearance over the cycle, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_m: Option<f64>,
    /// Highest frequency, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
    /// Most power over the mass, W/kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_w_kg: Option<f64>,
    /// Largest share of U^2 c dy dt beyond an angle of attack of 12 deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stall_fraction_12: Option<f64>,
    /// Largest share beyond 20 deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stall_fraction_20: Option<f64>,
    /// Largest |multiplier| without the heading's, dimensionless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multiplier: Option<f64>,
}

ranges!(SearchSpec {
    starts: Range::between(1.0, MAX_STARTS as f64),
    spread: Range::between(0.0, 1.0),
    iterations: Range::between(1.0, 10_000.0),
});
ranges!(LimitsSpec {
    clearance_m: Range::between(-1.0, 1.0),
    frequency_hz: Range::POSITIVE,
    power_w_kg: Range::POSITIVE,
    stall_fraction_12: Range::between(0.0, 1.0),
    stall_fraction_20: Range::between(0.0, 1.0),
    multiplier: Range::POSITIVE,
});

impl SearchSpec {
    /// One start, everything else as where it is not given.
    pub(crate) fn new(goal: Goal, vary: Vec<VarySpec>, limits: LimitsSpec) -> Self {
        let (strips, airs, seed) = (Vec::new(), Vec::new(), 0);
        Self { goal, vary, strips, airs, limits, starts: one(), spread: tenth(), seed, iterations: sixty() }
    }

    /// Checks ranges; the keys are tried as the search begins.
    pub(crate) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        self.limits.in_range().map_err(|e| e.within("limits"))?;
        require::between("airs", self.airs.len(), 0, MAX_AIRS)?;
        require::between("vary", self.vary.len(), 1, MAX_VARIED)?;
        for (i, vary) in self.vary.iter().enumerate() {
            vary.check().map_err(|e| e.within(&format!("vary[{i}]")))?;
            if self.vary[..i].iter().any(|other| other.key == vary.key) {
                return Err(Error::invalid(format!("vary[{i}].key"), &vary.key, "each key once"));
            }
            let mut airs = self.airs.iter().enumerate();
            if let Some((air, _)) = airs.find(|(_, air)| air.iter().any(|setting| sets(setting, &vary.key))) {
                let allowed = format!("settings that leave {} to vary[{i}]", vary.key);
                return Err(Error::invalid(format!("airs[{air}]"), self.airs[air].join(", "), allowed));
            }
        }
        Ok(())
    }
}

impl VarySpec {
    fn check(&self) -> Result<(), Error> {
        require::finite("low", &[self.low])?;
        require::finite("high", &[self.high])?;
        if self.low < self.high {
            return Ok(());
        }
        let allowed = format!("a number below high = {}", self.high);
        Err(Error::invalid("low", self.low, allowed).against(["high"]))
    }

    /// The value at a share of the range.
    pub(crate) fn at(&self, share: f64) -> f64 {
        self.low + (self.high - self.low) * share
    }

    /// The share of the range at which a value lies.
    pub(crate) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

/// Whether the setting `key=value` sets `key`, or a table or list that holds it.
fn sets(setting: &str, key: &str) -> bool {
    let set = setting.split('=').next().unwrap_or_default().trim();
    key.strip_prefix(set).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}
