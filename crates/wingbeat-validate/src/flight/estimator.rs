//! Flight by instruments: the turn and level flight of 20 g under an extended Kalman filter with noise, offsets and delay.

use std::ops::ControlFlow;

use wingbeat::scenario::Run;

use super::{SATURATED, SKIN, values};
use crate::shipped::{Shipped, scenario};
use crate::{ComparisonRow, Error};

const ESTIMATOR: Shipped = "estimator_20g";
/// Largest error of the height, m, and of the roll, root mean square, deg.
const HEIGHT: f64 = 0.04;
const ROLL: f64 = 1.0;
/// Share of normal errors within three standard deviations, less a margin: choice.
const WITHIN: f64 = 0.98;
/// When the turn begins, s.
const TURNING: f64 = 2.0;
/// From when on roll is judged by what the turn ends in, s: half a second after the turn's end is reached.
const TURNED: f64 = 4.0;

/// The comparisons: in the turn, then in level flight.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = flown("bank15", &[], 15.0)?;
    rows.extend(flown("level", &["controller.orbit.legs=[]"], 0.0)?);
    Ok(rows)
}

fn flown(name: &str, overrides: &[&str], roll_deg: f64) -> Result<Vec<ComparisonRow>, Error> {
    let Run { record, summary, .. } = scenario(ESTIMATOR, overrides)?.fly(|_| ControlFlow::Continue(()))?;
    let (t, roll) = (values(&record, "t")?, values(&record, "roll")?);
    let turned = &roll[t.partition_point(|at| *at < TURNED)..];
    let rms = |of: &[f64]| (of.iter().map(|x| x * x).sum::<f64>() / of.len() as f64).sqrt();
    let off = rms(&turned.iter().map(|roll| roll.to_degrees() - roll_deg).collect::<Vec<_>>());
    let asked = values(&record, "orbit_roll_asked")?;
    let through: Vec<f64> =
        (t.partition_point(|at| *at < TURNING)..t.len()).map(|k| (roll[k] - asked[k]).to_degrees()).collect();
    let row = |end: &str, metric: &str, value: f64, limit: f64, unit| {
        let id = format!("flight.estimator.{name}.{end}");
        ComparisonRow::judged(&id, "what is asked of the flight", metric, value, limit, unit)
    };
    let missing = || Error::reference("summary", "no estimate".to_string());
    let estimate = summary.estimate.as_ref().ok_or_else(missing)?;
    let height = summary.height_max_error_m.unwrap_or(f64::NAN);
    let beyond = 1.0 - estimate.within_3_sigma;
    let least = summary.least_clearance_m.unwrap_or(f64::NAN);
    let saturated = summary.input_saturation_fraction;
    Ok(vec![
        row("height", "largest error of the true height from 2 s on", height, HEIGHT, "m"),
        row("roll", "rms error of the true roll from 4 s on", off, ROLL, "deg"),
        row(
            "roll_through",
            "rms error of the true roll from 2 s on against that asked",
            rms(&through),
            ROLL,
            "deg",
        ),
        row("saturated", "share of commands at a limit", saturated, SATURATED, ""),
        row("clearance", "3 mm of skin less the least clearance", SKIN - least, 0.0, "m"),
        row(
            "consistent",
            "share of errors beyond three of the filter's deviations",
            beyond,
            1.0 - WITHIN,
            "",
        ),
    ])
}
