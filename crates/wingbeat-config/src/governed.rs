//! How the clearance that a controller is asked to keep was kept.

use serde::Serialize;
use wingbeat_flight::simulate::Record;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::flight;

/// A flight under `controller.orbit.clearance_m`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct GovernedSummary {
    /// The clearance that is asked, m.
    pub asked_m: f64,
    /// How far the least clearance falls short of it, as a share of it; 0 where it does not.
    pub short_fraction: f64,
    /// Updates at which no commands were found that keep it over the cycle ahead.
    pub not_kept: usize,
    /// Their share of all updates.
    pub not_kept_fraction: f64,
}

impl GovernedSummary {
    /// Of a record with a clearance of `least` m at least, in which the controller made `updates`; none where it keeps no clearance.
    pub(super) fn new(record: &Record, least: f64, updates: usize) -> Option<Self> {
        let last = |name: &str| record.values(name)?.last().copied();
        let (asked_m, not_kept) = (last("orbit_clearance_asked")?, last("orbit_not_kept")?);
        Some(Self {
            asked_m,
            short_fraction: (1.0 - least / asked_m).max(0.0),
            not_kept: not_kept as usize,
            not_kept_fraction: not_kept / updates.max(1) as f64,
        })
    }

    pub(super) fn judge(&self, judge: &mut Judge) {
        judge.hold(&flight::KEPT, self.short_fraction);
        judge.hold(&flight::NOT_KEPT, self.not_kept_fraction);
    }
}
