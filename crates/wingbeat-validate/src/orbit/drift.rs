//! The shipped orbits flown without feedback.

use std::ops::ControlFlow;

use wingbeat::scenario::{ConfigError, Document, Scenario};

use super::trimmed;
use crate::shipped::Shipped;
use crate::{ComparisonRow, Error};

/// Level flights whose orbits are flown.
const FLOWN: [Shipped; 11] = [
    "cruise_20g",
    "cruise_44g",
    "cruise_beta",
    "cruise_20g_lev",
    "cruise_44g_lev",
    "cruise_beta_lev",
    "cruise_linkage",
    "cruise_20g_margin",
    "passive_20g",
    "passive_20g_margin",
    "passive_linkage",
];
/// Cycles for which they are flown.
const CYCLES: f64 = 10.0;
/// Steps of the flight, which are not those of the orbit, s.
const STEP: f64 = 1e-4;

pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    FLOWN.iter().map(row).collect()
}

/// How far the body is from where the orbit has it after each cycle, at most.
fn row(shipped: &Shipped) -> Result<ComparisonRow, Error> {
    let name = *shipped;
    let refused = |e: ConfigError| Error::reference(name, e.to_string());
    let trimmed = trimmed(shipped, &[])?;
    let summary = &trimmed.summary;
    let (Some(frequency), Some((_, orbit))) = (summary.frequency_hz, trimmed.files.first()) else {
        return Err(Error::reference(name, "no orbit in what was trimmed"));
    };
    let document = Document::text("orbit.toml", orbit)
        .map_err(refused)?
        .set(format!("flight.duration_s={:.4}", STEP * (CYCLES / frequency / STEP).ceil()))
        .set(format!("flight.step_s={STEP:?}"))
        .set(format!("flight.record_every_s={STEP:?}"));
    let record = Scenario::new(document).map_err(refused)?.fly(|_| ControlFlow::Continue(()))?.record;
    let column = |name: &str| {
        record.values(name).ok_or_else(|| Error::reference("record", format!("no column {name}")))
    };
    let (t, place) = (column("t")?, [column("p_WB_x")?, column("p_WB_y")?, column("p_WB_z")?]);
    let begin = place.map(|p| p[0]);
    let mut most: f64 = 0.0;
    for cycle in 1..=CYCLES as usize {
        let when = cycle as f64 / frequency;
        let k = t.partition_point(|t| *t <= when).clamp(1, t.len() - 1);
        // Between the rows the place is linear to well below a hundredth of a millimetre.
        let share = (when - t[k - 1]) / (t[k] - t[k - 1]);
        let way = [summary.speed_m_s * when, 0.0, summary.climb_m_s * when];
        let off = (0..3).map(|i| {
            let there = place[i][k - 1] + share * (place[i][k] - place[i][k - 1]);
            (there - begin[i] - way[i]).powi(2)
        });
        most = most.max(off.sum::<f64>().sqrt());
    }
    let metric = "largest distance from the orbit's place after each of ten cycles open loop";
    Ok(ComparisonRow::judged(&format!("trim.drift.{name}"), "own orbit", metric, most, 1e-3, "m"))
}
