//! Hover of a guarded robot on thrusters, its wings beating unseen.

use std::ops::ControlFlow;

use wingbeat::scenario::Run;

use crate::shipped::{Shipped, scenario};
use crate::{ComparisonRow, Error};

const HOVER: Shipped = "hover_guarded";
/// Largest distance from the place, root mean square, m; largest rotation, deg; share of the air's mean force.
const PLACE: f64 = 0.05;
const ATTITUDE: f64 = 3.0;
const FORCE: f64 = 0.1;

/// The comparisons.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let Run { summary, .. } = scenario(HOVER, &[])?.fly(|_| ControlFlow::Continue(()))?;
    let row = |end: &str, metric: &str, value: f64, limit: f64, unit| {
        let id = format!("flight.hover_guarded.{end}");
        ComparisonRow::judged(&id, "what is asked of the hover", metric, value, limit, unit)
    };
    let missing = || Error::reference("summary", "no hover".to_string());
    let hover = summary.hover.as_ref().ok_or_else(missing)?;
    let (least, saturated) =
        (summary.least_clearance_m.unwrap_or(f64::NAN), summary.input_saturation_fraction);
    Ok(vec![
        row("place", "rms distance from the place over 20 s", hover.place_rms_m, PLACE, "m"),
        row("attitude", "largest rotation", hover.attitude_max_deg, ATTITUDE, "deg"),
        row("force", "estimated mean force of the air, relative error", hover.air_force_error, FORCE, ""),
        row("clearance", "the least clearance below zero: wings that cross", -least, 0.0, "m"),
        row("saturated", "share of commands at a limit", saturated, 0.05, ""),
    ])
}
