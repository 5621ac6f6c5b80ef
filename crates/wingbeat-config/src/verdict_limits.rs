//! `[limits]`: the limits of a verdict that a document overrides.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_judge::RunLimits;
use wingbeat_math::Error;

/// Limits by kind of result and quantity, in place of those of the table: `flight.altitude_m = 3.0`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(transparent)]
pub struct VerdictLimits(pub BTreeMap<String, BTreeMap<String, f64>>);

impl VerdictLimits {
    /// True when nothing is overridden.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The limits that hold.
    ///
    /// # Errors
    /// [`Error::Invalid`] with the key `limits.KIND.QUANTITY` for a limit that the table does not have.
    pub fn limits(&self) -> Result<RunLimits, Error> {
        let all =
            self.0.iter().flat_map(|(kind, of)| of.iter().map(move |(name, value)| (kind, name, value)));
        all.into_iter().try_fold(RunLimits::default(), |limits, (kind, name, &value)| {
            let id = format!("{kind}.{name}");
            let unknown = |known: String| {
                Error::invalid(format!("limits.{id}"), value, format!("one of the limits {known}"))
            };
            limits.with(&id, value).map_err(|error| unknown(error.known))
        })
    }
}
