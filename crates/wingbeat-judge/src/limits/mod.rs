//! The limits that results are held against, one file per kind of result.

pub mod asked;
pub mod calibration;
pub mod data;
pub mod flap;
pub mod flight;
pub mod linkage;
pub mod membrane;
pub mod paper;
pub mod plan;
pub mod range;
pub mod recording;
pub mod rig;
pub mod spar;
pub mod sweep;
pub mod tether;
pub mod trim;
pub mod wake;

use crate::status::Status;
use std::collections::BTreeMap;

/// On which side of a limit a value may lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sense {
    /// The value may be at most the limit.
    AtMost,
    /// The value must be at least the limit.
    AtLeast,
}

/// One quantity that is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JudgedLimit {
    /// Its name, `kind.quantity_unit`; what `[limits]` of a document calls it.
    pub id: &'static str,
    /// The side on which a value may lie.
    pub sense: Sense,
    /// The limit, in `unit`; infinite where nothing is judged until a document gives one.
    pub value: f64,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// What a result is called that breaks it; `None`: it stays what it is and gets a warning.
    pub status: Option<Status>,
    /// What is judged, as the beginning of a sentence: "largest distance from the reference height".
    pub meaning: &'static str,
}

impl JudgedLimit {
    /// A value above `value`, both in `unit`, makes the result `status`.
    pub const fn at_most(id: &'static str, value: f64, unit: &'static str, status: Status) -> Self {
        Self { id, sense: Sense::AtMost, value, unit, status: Some(status), meaning: "" }
    }

    /// A value below `value`, both in `unit`, makes the result `status`.
    pub const fn at_least(id: &'static str, value: f64, unit: &'static str, status: Status) -> Self {
        Self { id, sense: Sense::AtLeast, value, unit, status: Some(status), meaning: "" }
    }

    /// A value above `value`, both in `unit`, is worth a warning.
    pub const fn warn_above(id: &'static str, value: f64, unit: &'static str) -> Self {
        Self { id, sense: Sense::AtMost, value, unit, status: None, meaning: "" }
    }

    /// A value below `value`, both in `unit`, is worth a warning.
    pub const fn warn_below(id: &'static str, value: f64, unit: &'static str) -> Self {
        Self { id, sense: Sense::AtLeast, value, unit, status: None, meaning: "" }
    }

    /// The same limit with what it judges in words.
    pub const fn on(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }

    /// True when `value` lies on the allowed side of `limit`, both in its unit. A value that is not a number never does.
    pub fn allows(&self, value: f64, limit: f64) -> bool {
        match self.sense {
            Sense::AtMost => value <= limit,
            Sense::AtLeast => value >= limit,
        }
    }
}

/// Every limit, by kind.
pub fn all() -> impl Iterator<Item = &'static JudgedLimit> {
    let kinds: [&'static [JudgedLimit]; 16] = [
        &flight::ALL,
        &range::ALL,
        &membrane::ALL,
        &flap::ALL,
        &spar::ALL,
        &linkage::ALL,
        &trim::ALL,
        &plan::ALL,
        &sweep::ALL,
        &tether::ALL,
        &wake::ALL,
        &calibration::ALL,
        &rig::ALL,
        &recording::ALL,
        &data::ALL,
        &paper::ALL,
    ];
    kinds.into_iter().flatten()
}

/// The limits of one run: those of the table, and what a document overrides.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunLimits {
    overridden: BTreeMap<&'static str, f64>,
}

impl RunLimits {
    /// The same limits with `value`, in its unit, for the one called `id`.
    pub fn with(mut self, id: &str, value: f64) -> Result<Self, UnknownLimit> {
        let limit = all().find(|limit| limit.id == id).ok_or_else(|| UnknownLimit::new(id))?;
        self.overridden.insert(limit.id, value);
        Ok(self)
    }

    /// The value that holds, in the unit of the limit, and whether a document gave it.
    pub fn of(&self, limit: &JudgedLimit) -> (f64, bool) {
        self.overridden.get(limit.id).map_or((limit.value, false), |value| (*value, true))
    }
}

/// A limit that is not in the table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{id}: no such limit; the limits of this kind are {known}")]
pub struct UnknownLimit {
    /// The name given.
    pub id: String,
    /// Names of the same kind, or all where there is no such kind.
    pub known: String,
}

/// Names that limits once had, and what took their place.
const FORMER: [(&str, &str); 4] = [
    ("flight.dive_height_m", "flight.dive_velocity_heads, which took its place: the height over v^2/(2 g)"),
    ("rig.stall_fraction", STALL),
    ("plan.stall_fraction", STALL),
    ("trim.stall_fraction_12", STALL),
];
/// What took the place of the limits on stall of each verb.
const STALL: &str = "range.stall_fraction, which took its place in every verb";

impl UnknownLimit {
    fn new(id: &str) -> Self {
        if let Some((_, new)) = FORMER.iter().find(|(old, _)| *old == id) {
            return Self { id: id.into(), known: (*new).into() };
        }
        let kind = |of: &str| of.split('.').next().map(str::to_owned);
        let same: Vec<&str> = all().map(|limit| limit.id).filter(|known| kind(known) == kind(id)).collect();
        let known = if same.is_empty() { all().map(|limit| limit.id).collect() } else { same };
        Self { id: id.into(), known: known.join(", ") }
    }
}
