//! Limits of a sweep. All values are choices.

use super::JudgedLimit;
use crate::status::Status::{NotFound, NotJudged, NotResolved, OffTarget};

/// Of fewer runs the shares and quantiles say little of the whole.
pub const COMPLETED: JudgedLimit = JudgedLimit::at_least("sweep.completed_fraction", 0.5, "", NotResolved)
    .on("share of the runs that reached their end");
/// Runs that broke down, which no quantile knows.
pub const FAILED: JudgedLimit = JudgedLimit::warn_above("sweep.failed_fraction", 0.0, "")
    .on("tables and figures leave out the runs that broke down: share of them");
/// Runs that ended, and whose own verdict says that they cannot be used.
pub const USABLE: JudgedLimit = JudgedLimit::warn_below("sweep.usable_fraction", 1.0, "")
    .on("share of the completed runs that their own verdict lets be used");
/// Runs with warnings, which the tables of a sweep cannot repeat.
pub const WARNED: JudgedLimit = JudgedLimit::warn_above("sweep.warned_fraction", 0.0, "")
    .on("a run made alone prints its own warnings: share of the completed runs that carry any");
/// Runs of which nothing says whether they may be used, as a first cycle from rest or a flight of a moment: tables count them.
pub const UNJUDGED: JudgedLimit = JudgedLimit::warn_above("sweep.unjudged_fraction", 0.0, "")
    .on("what their task asks could not be judged (not_judged), and tables and figures count them: share of the completed runs");
/// Where none can be used, tables and figures are of what their own verdicts refuse.
pub const SOME: JudgedLimit = JudgedLimit::at_least("sweep.usable_runs", 1.0, "", NotResolved)
    .on("number of the completed runs that their own verdict lets be used");
/// The largest error of a window with one record or none is no largest error: that of two or more is.
pub const WINDOWLESS: JudgedLimit = JudgedLimit::at_most("sweep.windowless_fraction", 0.0, "", NotJudged)
    .on("nothing says whether flights hold of which one record or none is left after goal.settle_s (lengthen flight.duration_s): share of the flights");
/// How many flights hold is what a sweep is there to find, so only a document gives the limit.
pub const HELD: JudgedLimit = JudgedLimit::at_least("sweep.held_fraction", f64::NEG_INFINITY, "", OffTarget)
    .on("share of the flights that are held");

/// A search ends well where its best candidate meets every goal in every flight, and no verdict refuses one.
pub const MISSED: JudgedLimit = JudgedLimit::at_most("sweep.search_missed_goals", 0.0, "", NotFound)
    .on("goals of a search that its best candidate misses, over all its flights, and flights that their own verdict refuses");

/// All of them.
pub const ALL: [JudgedLimit; 9] =
    [COMPLETED, FAILED, USABLE, WARNED, UNJUDGED, SOME, WINDOWLESS, HELD, MISSED];
