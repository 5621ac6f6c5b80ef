//! What `[search]` of a sweep says.

use super::measure::measures;
use super::schema::Schemas;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use wingbeat_judge::limits::{flight, trim};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::require;

/// Most candidates of a generation.
const MOST: f64 = 1000.0;

/// A search of the draws by an evolution strategy for candidates whose flights meet all goals.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct SweepSearch {
    /// Candidates of a generation.
    #[serde(default = "population")]
    pub population: usize,
    /// Standard deviation of the first generation, over the range of each draw.
    #[serde(default = "spread")]
    pub spread: f64,
    /// The flights of a candidate, each a list of overrides, `["aero.paper.nodes=24"]`; without it one flight.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flights: Vec<Vec<String>>,
    /// What every flight of a candidate is to meet.
    pub goals: Vec<SearchGoal>,
    /// Largest distance between the end points (x and y) of a candidate's flights, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_within_m: Option<f64>,
}

/// A number of `summary.json` of a flight and the range in which it is to lie.
#[derive(Clone, Debug, Deserialize, Serialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct SearchGoal {
    /// Its key, `roll_mean_deg`; of a table inside `controller.failures`; or the name of a limit, `flight.path_angle_deg`, for what is held
    /// against it.
    pub key: String,
    /// Least value, in the unit of the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// Largest value, in the unit of the key.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Miss that costs 1, in the unit of the key; the cost is the sum of the squares.
    #[serde(default = "one")]
    pub per: f64,
}

/// *Choice.*
fn population() -> usize {
    8
}

/// *Choice.*
fn spread() -> f64 {
    0.2
}

fn one() -> f64 {
    1.0
}

ranges!(SweepSearch {
    population: Range::between(4.0, MOST),
    spread: Range::over(0.0, 1.0),
    ends_within_m: Range::over(0.0, 1e6),
});
ranges!(SearchGoal { per: Range::over(0.0, 1e12) });

impl SweepSearch {
    pub(super) fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        if self.goals.is_empty() {
            return Err(Error::invalid("goals", "none", "what the flights are to meet"));
        }
        for (i, goal) in self.goals.iter().enumerate() {
            goal.check().map_err(|e| e.within(&format!("goals[{i}]")))?;
        }
        let schemas = Schemas::kept();
        let told = |key: &str| is_number(schemas.summary(), key) || measures().any(|own| own.key == key);
        for (i, goal) in self.goals.iter().enumerate() {
            let wrong = |allowed: &str| Error::invalid(format!("goals[{i}].key"), &goal.key, allowed);
            if self.goals[..i].iter().any(|other| other.key == goal.key) {
                return Err(wrong("a key that no goal before has: low and high stand in one goal"));
            }
            let judged = flight::ALL.iter().chain(&trim::ALL).any(|limit| limit.id == goal.key);
            if !judged && !told(&goal.key) {
                return Err(wrong("a number of summary.json of a flight, or the name of a limit of flights"));
            }
        }
        if self.ends_within_m.is_some() && self.flights.len() < 2 {
            return Err(Error::invalid("ends_within_m", "given", "two flights or more").against(["flights"]));
        }
        Ok(())
    }

    /// Flights of a candidate.
    pub fn count(&self) -> usize {
        self.flights.len().max(1)
    }
}

impl SearchGoal {
    fn check(&self) -> Result<(), Error> {
        self.in_range()?;
        require::finite("low", self.low.as_slice())?;
        require::finite("high", self.high.as_slice())?;
        match (self.low, self.high) {
            (None, None) => Err(Error::invalid("low", "none", "low or high or both")),
            (Some(low), Some(high)) => require::at_most("low", low, high).map_err(|e| e.against(["high"])),
            _ => Ok(()),
        }
    }

    /// How far outside of the range `value` lies, in its unit; none where there is no value.
    pub fn miss(&self, value: f64) -> Option<f64> {
        let below = self.low.map_or(0.0, |low| low - value);
        let above = self.high.map_or(0.0, |high| value - high);
        value.is_finite().then(|| below.max(above).max(0.0))
    }

    /// The range in words.
    pub fn asked(&self) -> String {
        match (self.low, self.high) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (Some(low), None) => format!("at least {low}"),
            (_, high) => format!("at most {}", high.unwrap_or(f64::INFINITY)),
        }
    }
}

/// Whether `key` names a number in what the schema describes; a table of any names has `additionalProperties`.
fn is_number(schema: &Value, key: &str) -> bool {
    let inner = |of| move |part| Value::get(of, "properties").and_then(|known: &Value| known.get(part));
    let found = key.split('.').try_fold(schema, |of, part| {
        inner(of)(part).or_else(|| of.get("additionalProperties").filter(|any| any.is_object()))
    });
    let number = |of: &Value| of == "number" || of == "integer";
    match found.map(|of| &of["type"]) {
        Some(Value::Array(types)) => types.iter().any(number),
        Some(of) => number(of),
        None => false,
    }
}
