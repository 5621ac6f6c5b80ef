//! How well a flight followed its path.

use super::summary::mean;
use super::told_errors::TrueErrors;
use serde::Serialize;
use wingbeat_flight::guide::PathSpec;

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
    /// Of the true places beside `path`; none where no path was followed.
    pub(super) fn new(truth: &TrueErrors, path: &PathSpec) -> Option<Self> {
        let ([cross, along], arc_m) = truth.path(path)?;
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
