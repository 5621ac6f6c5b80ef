//! Numbers by name, and the verdict on the fit that they are from.

use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

/// The key of a file of numbers that holds the verdict on their fit.
const VERDICT: &str = "verdict";

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

/// Numbers by name; from a calibration with the verdict on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenNumbers {
    numbers: BTreeMap<String, f64>,
    /// The verdict on the fit; none of numbers that are written by hand.
    pub verdict: Option<FitVerdict>,
}

impl GivenNumbers {
    /// True without numbers and verdict.
    pub fn is_silent(&self) -> bool {
        self.numbers.is_empty() && self.verdict.is_none()
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
        Self { numbers, verdict: None }
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
            } else if given.numbers.insert(name.clone(), map.next_value()?).is_some() {
                return Err(de::Error::custom(format!("{name} once")));
            }
        }
        Ok(given)
    }
}
