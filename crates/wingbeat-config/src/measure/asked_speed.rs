//! Velocity along the heading beside that which a controller about orbits asks.

use super::Measure;
use crate::summary::{Settled, mean};

fn errors(settled: &Settled<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
    settled.truth.as_ref()?.speed()
}

/// Root mean square of the errors, m/s.
fn error(settled: &Settled<'_>) -> Option<f64> {
    let (_, off) = errors(settled)?;
    mean(&off.iter().map(|off| off * off).collect::<Vec<_>>()).map(f64::sqrt)
}

/// Key of the error over what was asked.
pub(crate) const FRACTION: &str = "speed_error_fraction";

pub(super) const MEASURES: &[Measure] = &[
    Measure {
        key: "speed_rms_error_m_s",
        meaning: "Root mean square of the velocity along the heading minus that of the orbit at the same phase, m/s, at the updates; \
                  under `[controller.orbit]`.",
        line: Some(("speed, rms error", 3, "m/s")),
        always: false,
        swept: None,
        value: error,
    },
    Measure {
        key: FRACTION,
        meaning: "The same over the mean of the velocity that is asked, dimensionless.",
        line: None,
        always: false,
        swept: None,
        value: |settled| {
            let (asked, _) = errors(settled)?;
            mean(&asked).filter(|asked| *asked > 0.0).and_then(|asked| Some(error(settled)? / asked))
        },
    },
];
