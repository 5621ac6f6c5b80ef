//! How well a flight followed its path.

use super::summary::mean;
use super::told_errors::TrueErrors;
use serde::Serialize;
use wingbeat_flight::guide::PathSpec;
use wingbeat_flight::simulate::Record;

/// Errors from the path from the settling time on, at the updates of the controller.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PathSummary {
    /// Root mean square of the distance across the path, m.
    pub cross_rms_m: f64,
    /// Largest distance across, m.
    pub cross_max_m: f64,
    /// Root mean square of the arc ahead of or behind what time and speed ask, m.
    pub along_rms_m: f64,
    /// Largest of it, m.
    pub along_max_m: f64,
    /// Horizontal arc of the path flown by the end, m.
    pub arc_m: f64,
}

impl PathSummary {
    /// Of the rows from `first` on; none where no path was followed. By the true place where the controller is told of it with errors.
    pub(super) fn new(
        record: &Record,
        first: usize,
        truth: Option<(&TrueErrors, &PathSpec)>,
    ) -> Option<Self> {
        let column = |name: &str| record.values(name).and_then(|values| values.get(first..));
        let ([cross, along], arc_m) = match truth {
            Some((truth, path)) => truth.path(path)?,
            None => {
                let arc = *column("path_arc")?.last()?;
                (["path_cross", "path_along"].map(|name| column(name).unwrap_or_default().to_vec()), arc)
            }
        };
        let (cross, along) = (&cross[..], &along[..]);
        let rms = |values: &[f64]| mean(&values.iter().map(|v| v * v).collect::<Vec<_>>()).map(f64::sqrt);
        let largest = |values: &[f64]| values.iter().map(|v| v.abs()).reduce(f64::max);
        Some(Self {
            cross_rms_m: rms(cross)?,
            cross_max_m: largest(cross)?,
            along_rms_m: rms(along)?,
            along_max_m: largest(along)?,
            arc_m,
        })
    }
}
