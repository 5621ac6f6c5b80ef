//! The dive out of level flight and its pull-out.

use std::ops::ControlFlow;

use wingbeat::orbit::SKIN;

use crate::shipped::scenario;
use crate::{ComparisonRow, Error};

/// Room of the wings beside their skins, m.
const CLEAR: f64 = 0.003;

/// Height, nose and clearance of the shipped dive, and the same with another model that flies.
pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    let other = ["mismatch.mass=1.05", "mismatch.density=0.95", "mismatch.profile_drag=1.2"];
    for (end, told, overrides) in
        [("", "", &[][..]), (".other", ", 5 % heavier, air 5 % thinner, cd0 x 1.2", &other[..])]
    {
        let summary = scenario("dive_45_20g", overrides)?.fly(|_| ControlFlow::Continue(()))?.summary;
        let dive = summary.dive.ok_or_else(|| Error::NoAnswer("no dive was flown".into()))?;
        let row = |name: &str, metric: &str, value: f64, limit: f64, unit| {
            let id = format!("flight.dive_45_20g{end}.{name}");
            ComparisonRow::judged(
                &id,
                "what is asked of the flight",
                &format!("{metric}{told}"),
                value,
                limit,
                unit,
            )
        };
        let least = summary.least_clearance_m.unwrap_or(f64::NAN);
        rows.extend([
            row("height", "height lost in the dive and its pull-out", dive.height_lost_m, 1.5, "m"),
            row(
                "nose",
                "45 deg less the largest mean pitch down over a cycle",
                45.0 - dive.nose_down_cycle_deg,
                0.0,
                "deg",
            ),
            row(
                "level",
                "time until the path is level for good",
                dive.level_after_s.unwrap_or(f64::INFINITY),
                2.0,
                "s",
            ),
        ]);
        // The plan knows the nominal robot alone, and so its wings are clear with that alone.
        let clearance = "3 mm of room and 3 mm of skin less the least clearance";
        rows.push(match overrides.is_empty() {
            true => row("clearance", clearance, CLEAR + SKIN - least, 0.0, "m"),
            false => {
                let metric = format!("{clearance}{told}");
                ComparisonRow::shown(
                    "flight.dive_45_20g.other.clearance",
                    "what is asked of the flight",
                    &metric,
                    CLEAR + SKIN - least,
                    "m",
                )
            }
        });
    }
    Ok(rows)
}
