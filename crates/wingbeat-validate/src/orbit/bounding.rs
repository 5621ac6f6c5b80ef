//! Bounding flight as one orbit, and its power over the share of the strokes beside that of the same gait without glides.

use super::trimmed;
use crate::{ComparisonRow, Error};

/// Strokes of a cycle and those left out, beside the shipped three and one.
const BOUNDS: [(usize, usize); 2] = [(5, 1), (2, 1)];
/// Largest condition missed, SI.
const CLOSES: f64 = 1e-8;

/// Whether the shipped bound closes and its feedback holds it, and what bounds take.
pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let source = "definition of a periodic flight";
    let shipped = trimmed("bounding_20g", &[])?.summary;
    let told = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let judged = |end: &str, metric: &str, value: f64, limit: f64| {
        ComparisonRow::judged(&format!("trim.bounding_20g.{end}"), source, metric, value, limit, "")
    };
    let mut rows = vec![
        judged(
            "closes",
            "largest condition missed over three strokes and a glide, SI",
            told(shipped.residual),
            CLOSES,
        ),
        judged(
            "held",
            "largest multiplier of the cycle under the feedback of gains.csv",
            told(shipped.held_multiplier),
            1.0,
        ),
        ComparisonRow::shown(
            "trim.bounding_20g.free",
            source,
            "largest multiplier of the cycle without feedback",
            told(shipped.largest_multiplier),
            "",
        ),
    ];
    let steady = told(trimmed("cruise_20g_margin", &[])?.summary.power_w_kg);
    let over = |strokes: usize, all: usize, power: f64| {
        let id = format!("trim.bounding_20g.power_{strokes}_of_{all}");
        let metric =
            format!("positive power of {strokes} strokes of {all} over that of steady flight at the speed");
        ComparisonRow::shown(&id, "the same gait without glides", &metric, power / steady, "")
    };
    rows.push(over(3, 4, told(shipped.power_w_kg)));
    for (strokes, glide) in BOUNDS {
        let hz = 9.0 / (strokes + glide) as f64;
        let set = [
            format!("robot.gait.fourier.bound.strokes={strokes}"),
            format!("robot.gait.fourier.bound.glide={glide}"),
            format!("robot.gait.fourier.bound.harmonics={}", 6 * (strokes + glide) / 4),
            format!("robot.gait.fourier.frequency_hz={hz}"),
        ];
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let power = told(trimmed("bounding_20g", &set)?.summary.power_w_kg);
        rows.push(over(strokes, strokes + glide, power));
    }
    Ok(rows)
}
