//! Limits of a wake of the vortex lattice. All values are choices.

use super::Limit;
use crate::status::Status::NotResolved;

/// A symmetric motion whose halves drift apart.
pub const DRIFTED: Limit = Limit::warn_above("wake.symmetry_fraction", 0.01, "").on(
    "left and right of a symmetric motion drift apart, the free wake is not resolved where it meets the wing or itself \
     (try --prescribed, a larger --core or more --steps): largest difference of a ring and its mirror image over the largest ring",
);
/// Halves that have nothing to do with each other any more.
pub const LOST: Limit = Limit::at_most("wake.symmetry_lost_fraction", 0.5, "", NotResolved)
    .on("largest difference of a ring and its mirror image over the largest ring");
/// The sum of all circulations, which Kelvin's theorem keeps at zero: rounding leaves 1e-12.
pub const KELVIN: Limit = Limit::at_most("wake.circulation_error", 1e-6, "", NotResolved)
    .on("sum of all circulations over the largest one");

/// Vortices that have left a leading edge and come near to others or to the wing in long steps.
pub const RUNS: Limit = Limit::warn_above("wake.sheet_way_chords", 0.5, "mean chords").on(
    "the sheets of the leading edges are coarse: largest way in a step of a vortex that has left one (try more --steps)",
);
/// Vortices that fly off.
pub const RUN_AWAY: Limit = Limit::at_most("wake.sheet_lost_chords", 5.0, "mean chords", NotResolved)
    .on("largest way in a step of a vortex that has left a leading edge");

/// All of them.
pub const ALL: [Limit; 5] = [DRIFTED, LOST, KELVIN, RUNS, RUN_AWAY];
