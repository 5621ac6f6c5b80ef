//! Numbers by name, the verdict on the fit that they are from, and the model that was fitted.

use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

/// The key of a file of numbers that holds the verdict on their fit.
const VERDICT: &str = "verdict";
/// The key that holds the model that was fitted.
const MODEL: &str = "model";
/// The key that holds how well the fit knows its numbers.
const UNCERTAINTY: &str = "uncertainty";

/// The verdict on a fit, as `wingbeat calibrate` writes it into its file of numbers.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitVerdict {
    /// Its status; `ok` for a fit that can be used.
    pub status: String,
    /// Why it is not `ok`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// What wrote it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub written: String,
}

impl FitVerdict {
    /// True for a fit that can be used.
    pub fn is_ok(&self) -> bool {
        self.status == "ok"
    }
}

/// The model that numbers were fitted with, as `wingbeat calibrate` writes it into its file of numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedModel {
    /// Name of the robot; none of a fit to cases of a wing alone.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub robot: String,
    /// Preset of the aerodynamic model.
    pub preset: String,
    /// Lift law.
    pub law: String,
    /// Half span of the wing along its arc, m: tells a wing alone, which has no name, from another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub half_span_m: Option<f64>,
}

/// How well a fit knows its numbers, as `wingbeat calibrate` writes it into its file of numbers.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FitUncertainty {
    /// Names of the fitted numbers.
    pub of: Vec<String>,
    /// Their standard errors, in their units.
    pub standard_error: Vec<f64>,
    /// Rows of the correlations of their estimates, dimensionless.
    pub correlation: Vec<Vec<f64>>,
    /// Degrees of freedom of the standard errors, dimensionless: the cycles beyond their means from which the noise is known. Draws
    /// are of Student's distribution with so many; of the normal one where the file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
}

/// Share by which half spans of one wing may differ. *Choice*: the arc begins at the shoulder or at the middle of the body.
const SPANS: f64 = 0.2;

impl FittedModel {
    /// What of it is not as in `other`, in words; what one of them does not say agrees.
    pub fn apart(&self, other: &Self) -> Vec<String> {
        let parts = [
            ("robot", &self.robot, &other.robot),
            ("preset", &self.preset, &other.preset),
            ("law", &self.law, &other.law),
        ];
        let differ =
            parts.into_iter().filter(|(_, own, other)| own != other && !own.is_empty() && !other.is_empty());
        let span = self.half_span_m.zip(other.half_span_m);
        let span = span.filter(|(own, other)| !((own / other).ln().abs() < SPANS));
        let span = span.map(|(own, other)| format!("a wing of a half span of {own} m, here {other} m"));
        let differ = differ.map(|(what, own, other)| format!("{what} {:?}, here {:?}", cut(own), cut(other)));
        differ.chain(span).collect()
    }
}

/// Most letters of a name in a warning. *Choice.*
const LETTERS: usize = 80;

/// A name with its end left out where it is longer than anyone reads.
fn cut(name: &str) -> String {
    let short: String = name.chars().take(LETTERS).collect();
    if short.len() < name.len() { short + "..." } else { short }
}

/// Numbers by name; from a calibration with the verdict on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenNumbers {
    numbers: BTreeMap<String, f64>,
    /// The verdict on the fit; none of numbers that are written by hand.
    pub verdict: Option<FitVerdict>,
    /// The model that was fitted; none of numbers that are written by hand, and of older files.
    pub model: Option<FittedModel>,
    /// How well the fit knows them; none of numbers that are written by hand, and of older files.
    pub uncertainty: Option<FitUncertainty>,
}

impl GivenNumbers {
    /// True without numbers and anything on their fit.
    pub fn is_silent(&self) -> bool {
        *self == Self::default()
    }
}

impl Deref for GivenNumbers {
    type Target = BTreeMap<String, f64>;

    fn deref(&self) -> &Self::Target {
        &self.numbers
    }
}

impl DerefMut for GivenNumbers {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.numbers
    }
}

impl From<BTreeMap<String, f64>> for GivenNumbers {
    fn from(numbers: BTreeMap<String, f64>) -> Self {
        Self { numbers, ..Self::default() }
    }
}

impl Serialize for GivenNumbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (name, value) in &self.numbers {
            map.serialize_entry(name, value)?;
        }
        if let Some(verdict) = &self.verdict {
            map.serialize_entry(VERDICT, verdict)?;
        }
        if let Some(model) = &self.model {
            map.serialize_entry(MODEL, model)?;
        }
        if let Some(uncertainty) = &self.uncertainty {
            map.serialize_entry(UNCERTAINTY, uncertainty)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for GivenNumbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Names)
    }
}

struct Names;

impl<'de> Visitor<'de> for Names {
    type Value = GivenNumbers;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<GivenNumbers, A::Error> {
        let mut given = GivenNumbers::default();
        while let Some(name) = map.next_key::<String>()? {
            if name == VERDICT {
                given.verdict = Some(map.next_value()?);
            } else if name == MODEL {
                given.model = Some(map.next_value()?);
            } else if name == UNCERTAINTY {
                given.uncertainty = Some(map.next_value()?);
            } else if given.numbers.insert(name.clone(), map.next_value()?).is_some() {
                return Err(de::Error::custom(format!("{name} once")));
            }
        }
        Ok(given)
    }
}
