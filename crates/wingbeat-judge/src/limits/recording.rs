//! Limits of a recording from the load cell. Shares are of at least a hundred records, so that a short recording is not
//! judged by one of them. All values are choices.

use super::JudgedLimit;
use crate::status::Status::{Failed, SuspectData};

/// Records that never came, of one start.
pub const LOST: JudgedLimit = JudgedLimit::at_most("recording.lost_fraction", 0.02, "", SuspectData)
    .on("share of the records that were lost");
/// Records between two streams of one start.
pub const UNSENT: JudgedLimit = JudgedLimit::at_most("recording.unsent_fraction", 0.1, "", SuspectData)
    .on("share of the records that the box did not send between two streams");
/// Records whose loads the box calls invalid.
pub const SERIOUS: JudgedLimit = JudgedLimit::at_most("recording.serious_fraction", 0.001, "", SuspectData)
    .on("share of the records with a serious status");
/// Records beyond the range of the cell.
pub const SATURATED: JudgedLimit =
    JudgedLimit::at_most("recording.saturated_fraction", 0.01, "", SuspectData)
        .on("share of the records with a saturated channel");
/// Records with a warning.
pub const WARNED: JudgedLimit = JudgedLimit::warn_above("recording.status_warnings_fraction", 0.05, "")
    .on("share of the records with a warning status");
/// Records out of order: late, or so far off that they begin another stream or are a leap.
pub const DISORDER: JudgedLimit = JudgedLimit::at_most("recording.disorder_fraction", 0.1, "", SuspectData)
    .on("share of the records whose number does not follow the one before");
/// Records that came again.
pub const DUPLICATES: JudgedLimit =
    JudgedLimit::at_most("recording.duplicate_fraction", 0.1, "", SuspectData)
        .on("share of the records that were received twice");
/// Datagrams that are no records.
pub const MALFORMED: JudgedLimit = JudgedLimit::at_most("recording.malformed_fraction", 0.3, "", SuspectData)
    .on("datagrams that are no records, for each record that came,");
/// Sample numbers of the box that do not count.
pub const STANDING: JudgedLimit = JudgedLimit::at_most("recording.standing_fraction", 0.01, "", SuspectData)
    .on("share of the records whose sample number does not grow with their own number");
/// Channels without a change.
pub const DEAD: JudgedLimit = JudgedLimit::at_most("recording.dead_channels", 0.0, "", SuspectData)
    .on("number of channels that never change");
/// All loads frozen for a while.
pub const HELD: JudgedLimit = JudgedLimit::at_most("recording.held_s", 0.1, "s", SuspectData)
    .on("longest time in which no channel changes");
/// The rate of arrival against the stated one.
pub const RATE: JudgedLimit = JudgedLimit::at_most("recording.rate_error_fraction", 0.1, "", SuspectData).on(
    "difference between the rate of arrival by the clock and the rate that the box states, relative to it,",
);
/// Count against clock, beyond a twentieth of the recording, at least 0.1 s and at most 0.5 s: ten times the delays of a busy host are
/// no share of a recording of 2 s. A box of 7 kHz that makes 93 % of its rate is found from 2 s on.
pub const UNACCOUNTED: JudgedLimit =
    JudgedLimit::at_most("recording.unaccounted_fraction", 0.01, "", SuspectData)
        .on("share by which the records received or counted as missing differ from those due by the clock, \
         beyond a tolerance of 5 % of them (0.1 to 0.5 s of records),");
/// Silence at the end.
pub const SILENT_END: JudgedLimit = JudgedLimit::at_most("recording.silent_end_s", 0.5, "s", Failed)
    .on("time since the box stopped sending, at the end,");

/// All of them.
pub const ALL: [JudgedLimit; 14] = [
    LOST,
    UNSENT,
    SERIOUS,
    SATURATED,
    WARNED,
    DISORDER,
    DUPLICATES,
    MALFORMED,
    STANDING,
    DEAD,
    HELD,
    RATE,
    UNACCOUNTED,
    SILENT_END,
];
