//! Flight along a path: the figure of eight of 20 g in gusts, by a regulator and by a plan.

use std::ops::ControlFlow;

use wingbeat::scenario::Run;

use super::SATURATED;
use crate::shipped::{Shipped, scenario};
use crate::{ComparisonRow, Error};

/// By the bank that the distance across asks of the regulator.
pub const EIGHT: Shipped = "path_figure8";
/// By a plan whose cost holds the distances.
pub const PLANNED: Shipped = "predictive_figure8";
/// Largest distance across the path, root mean square, m.
const CROSS: f64 = 0.15;

/// The comparisons: still air, then gusts of .3 m/s along each axis.
pub fn rows(of: Shipped) -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = flown(of, "still", &["air.gust_m_s=0.0"])?;
    rows.extend(flown(of, "gusts", &["air.gust_m_s=0.3"])?);
    Ok(rows)
}

fn flown(of: Shipped, name: &str, overrides: &[&str]) -> Result<Vec<ComparisonRow>, Error> {
    let Run { summary, .. } = scenario(of, overrides)?.fly(|_| ControlFlow::Continue(()))?;
    let row = |end: &str, metric: &str, value: f64, limit: f64, unit| {
        let id = format!("flight.{of}.{name}.{end}");
        ComparisonRow::judged(&id, "what is asked of the flight", metric, value, limit, unit)
    };
    let missing = || Error::reference("summary", "no path".to_string());
    let path = summary.path.as_ref().ok_or_else(missing)?;
    let least = summary.least_clearance_m.unwrap_or(f64::NAN);
    let saturated = summary.input_saturation_fraction;
    Ok(vec![
        row("cross", "rms distance across the path", path.cross_rms_m, CROSS, "m"),
        row("saturated", "share of commands at a limit", saturated, SATURATED, ""),
        row("clearance", "the least clearance below zero: wings that cross", -least, 0.0, "m"),
    ])
}
