//! How well a controller's estimator knew the flight.

use super::summary::mean;
use super::told_errors::Updates;
use serde::Serialize;
use wingbeat_flight::guide::angle_error;
use wingbeat_flight::simulate::{Column, Record};

/// Errors of the state as it was estimated, at the updates from the settling time on, against the true one; present where
/// an estimator reads instruments.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct EstimateSummary {
    /// Root mean square of the height's error, m.
    pub height_rms_m: f64,
    /// Largest error of the height, m.
    pub height_max_m: f64,
    /// Root mean square of the error of the velocity in heading axes, m/s.
    pub velocity_rms_m_s: f64,
    /// Root mean square of the roll's error, deg.
    pub roll_rms_deg: f64,
    /// Root mean square of the pitch's error, deg.
    pub pitch_rms_deg: f64,
    /// Root mean square of the error of the angular rate, rad/s.
    pub rate_rms_rad_s: f64,
    /// Mean square of all these errors over the variances that the filter gives them: 1 of a filter that knows how well it
    /// knows, less of one too careful.
    pub normalised_square: f64,
    /// Share of the errors within three of the filter's standard deviations; .997 of normal errors that it knows.
    pub within_3_sigma: f64,
    /// Mean square of the innovations over their variances: of angular rates, forces, height, airspeed, those that there are. 1
    /// likewise.
    pub innovation_square: Vec<f64>,
}

/// Numbers that are estimated, in the order of the columns.
const NAMES: [&str; 9] =
    ["height", "forward", "leftward", "upward", "roll", "pitch", "w_WB_B_x", "w_WB_B_y", "w_WB_B_z"];

/// An estimated flight: rows that are updates, and at each the errors.
pub(super) struct Estimated<'a> {
    record: &'a Record,
    rows: Vec<usize>,
    /// Estimate less truth.
    errors: Vec<[f64; NAMES.len()]>,
}

impl<'a> Estimated<'a> {
    /// Of the rows from `first` on under a controller with such `updates`; none where nothing was estimated.
    pub fn new(record: &'a Record, first: usize, updates: Updates) -> Option<Self> {
        record.column("estimate_t")?;
        let rows = updates.rows(record, first..record.rows());
        let values = |name: String| record.values(&name);
        let estimates = NAMES.map(|name| values(format!("estimate_{name}")));
        let truth =
            ["p_WB_z", "v_WB_W_x", "v_WB_W_y", "v_WB_W_z", "yaw", "roll", "pitch"].map(|n| record.values(n));
        let rates = ["x", "y", "z"].map(|axis| values(format!("w_WB_B_{axis}")));
        let errors = rows.iter().map(|&row| {
            let at = |column: &Option<&[f64]>| Some(column.as_ref()?[row]);
            let [z, vx, vy, vz, yaw, roll, pitch] = truth.each_ref().map(at);
            let (sin, cos) = yaw?.sin_cos();
            let [wx, wy, wz] = rates.each_ref().map(at);
            let forward = vx? * cos + vy? * sin;
            let leftward = vy? * cos - vx? * sin;
            let truth = [z?, forward, leftward, vz?, roll?, pitch?, wx?, wy?, wz?];
            let mut errors = [0.0; NAMES.len()];
            for (i, error) in errors.iter_mut().enumerate() {
                let estimate = at(&estimates[i])?;
                *error =
                    if (4..6).contains(&i) { angle_error(estimate, truth[i]) } else { estimate - truth[i] };
            }
            Some(errors)
        });
        let errors = errors.collect::<Option<Vec<_>>>()?;
        (!rows.is_empty()).then_some(Self { record, rows, errors })
    }

    /// Columns of the innovations, one for each kind of reading.
    fn innovations(&self) -> impl Iterator<Item = &Column> {
        self.record.columns().iter().filter(|column| column.name.starts_with("estimate_innovation_"))
    }

    /// The summary.
    pub fn summary(&self) -> Option<EstimateSummary> {
        let square = |i: usize| mean(&self.errors.iter().map(|e| e[i] * e[i]).collect::<Vec<_>>());
        let rms = |from: usize, to: usize| Some((from..to).map(square).sum::<Option<f64>>()?.sqrt());
        let mut normalised = Vec::with_capacity(NAMES.len() * self.rows.len());
        for (i, name) in NAMES.iter().enumerate() {
            let deviation = self.record.values(&format!("estimate_deviation_{name}"))?;
            normalised.extend(self.rows.iter().zip(&self.errors).map(|(&row, e)| e[i] / deviation[row]));
        }
        let squares: Vec<f64> = normalised.iter().map(|n| n * n).collect();
        let within = squares.iter().filter(|square| **square <= 9.0).count();
        let innovation =
            |column: &Column| mean(&self.rows.iter().map(|&row| column.values[row]).collect::<Vec<_>>());
        Some(EstimateSummary {
            height_rms_m: rms(0, 1)?,
            height_max_m: self.errors.iter().map(|e| e[0].abs()).reduce(f64::max)?,
            velocity_rms_m_s: rms(1, 4)?,
            roll_rms_deg: rms(4, 5)?.to_degrees(),
            pitch_rms_deg: rms(5, 6)?.to_degrees(),
            rate_rms_rad_s: rms(6, 9)?,
            normalised_square: mean(&squares)?,
            within_3_sigma: within as f64 / squares.len() as f64,
            innovation_square: self.innovations().filter_map(innovation).collect(),
        })
    }
}
