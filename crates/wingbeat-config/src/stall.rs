//! How much of a run is past the angles of attack up to which lift laws hold, as every run is judged.

use wingbeat_aero::StallCount;
use wingbeat_judge::Judge;
use wingbeat_judge::limits::range;

/// Holds the strips and instants of a run against the angles of attack up to which their laws hold. `key` of the document names the law,
/// which bears where another one holds further.
pub(super) fn hold(judge: &mut Judge, stalled: &StallCount, key: &str) {
    for (law, share) in stalled.by_law() {
        let (law, about) = (law.name(), law.about());
        let angle = about.holds_to_deg.map_or("the stall angle".to_owned(), |angle| format!("{angle} deg"));
        let words = format!("(`{law}` past {angle}: it {})", about.beyond);
        if !judge.hold_about(&range::STALLED, share, &words) && about.holds_to_deg.is_none() {
            judge.mended_by(key);
        }
    }
}
