//! Which columns of a measured file are which.

use crate::netft::COUNTS_PER_UNIT;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};

/// How a measured file is to be read; what it says itself need not be given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields, default)]
pub struct InputSpec {
    /// Names of columns or datasets that differ: `Fz = "force_up"`, `Fz = "-force_down"` where the sign does too. Channels are t,
    /// Fx .. Tz, phase (of the gait), status, and q1, q2 .. of the arm's joints.
    pub columns: BTreeMap<String, String>,
    /// Units where the file does not say them.
    pub units: UnitSpec,
    /// Counts per N of channels in counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counts_per_newton: Option<f64>,
    /// Counts per N m of channels in counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counts_per_newton_metre: Option<f64>,
    /// Samples per second, Hz, where there is no column of time or it is not to be trusted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Time of the file at which the run begins, s; the rest lies before.
    pub start_s: f64,
    /// Gaps of at most so many samples are bridged by straight lines; longer ones stay open.
    pub bridge_samples: usize,
}

ranges!(InputSpec {
    counts_per_newton: Range::between(COUNTS_PER_UNIT[0], COUNTS_PER_UNIT[1]),
    counts_per_newton_metre: Range::between(COUNTS_PER_UNIT[0], COUNTS_PER_UNIT[1]),
    rate_hz: Range::POSITIVE,
});

impl InputSpec {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn check(&self) -> Result<(), Error> {
        self.in_range()
    }
}

/// Units by quantity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct UnitSpec {
    /// Of forces.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Of moments.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment: Option<String>,
    /// Of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Of phase and joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<String>,
}
