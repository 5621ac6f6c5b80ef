//! What a motor takes that turns the crank, and how evenly it turns.

use super::Measure;
use crate::summary::{Settled, mean};

/// Range over mean.
fn ripple(rates: &[f64]) -> Option<f64> {
    let low = rates.iter().copied().reduce(f64::min)?;
    let high = rates.iter().copied().reduce(f64::max)?;
    Some((high - low) / mean(rates)?)
}

pub(super) const MEASURES: &[Measure] = &[
    Measure {
        key: "motor_power_w",
        meaning: "Mean mechanical power of the motor's shaft, W, where a motor turns the crank.",
        line: Some(("power of the motor", 3, "W, of its shaft")),
        always: false,
        swept: None,
        value: |settled: &Settled<'_>| mean(settled.in_strokes("motor_power")),
    },
    Measure {
        key: "electrical_power_w",
        meaning: "Mean electrical power of the motor, W.",
        line: Some(("motor, electrical", 3, "W")),
        always: false,
        swept: None,
        value: |settled| mean(settled.in_strokes("electrical_power")),
    },
    Measure {
        key: "crank_ripple",
        meaning: "Range of the crank's rate over its mean.",
        line: Some(("range of the crank's rate", 3, "of its mean")),
        always: false,
        swept: None,
        value: |settled| ripple(settled.column("crank_rate")),
    },
];
