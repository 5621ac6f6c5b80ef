//! How still a hovering robot was, and what its controller took for the force of the air.

use super::summary::mean;
use super::told_errors::TrueErrors;
use serde::Serialize;
use wingbeat_aero::LoadSource;
use wingbeat_flight::simulate::{AXES, Record};
use wingbeat_math::{Mat3, Vec3};

/// Hover from the settling time on.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct HoverSummary {
    /// Root mean square of the distance from the place asked, at the updates of the controller, m.
    pub place_rms_m: f64,
    /// Root mean square of the rotation, deg.
    pub attitude_rms_deg: f64,
    /// Largest rotation, deg.
    pub attitude_max_deg: f64,
    /// Mean force of the air on wings and body in W, N.
    pub air_force_n: [f64; 3],
    /// The same as the controller's observer has it.
    pub air_force_estimate_n: [f64; 3],
    /// Magnitude of their difference over that of the true one.
    pub air_force_error: f64,
}

impl HoverSummary {
    /// Of the rows from `first` on; none where nothing hovered.
    pub(super) fn new(record: &Record, first: usize, truth: &TrueErrors) -> Option<Self> {
        let column = |name: &str| record.values(name).and_then(|values| values.get(first..));
        let vector = |prefix: &str| -> Option<Vec<Vec3>> {
            let [x, y, z] = AXES.map(|axis| column(&format!("{prefix}_{axis}")));
            let (x, y, z) = (x?, y?, z?);
            Some((0..x.len()).map(|row| Vec3::new(x[row], y[row], z[row])).collect())
        };
        let average = |vectors: &[Vec3]| -> Option<[f64; 3]> {
            let axis = |i: usize| mean(&vectors.iter().map(|v| v[i]).collect::<Vec<_>>());
            Some([axis(0)?, axis(1)?, axis(2)?])
        };
        let rms = |sizes: &[f64]| mean(&sizes.iter().map(|s| s * s).collect::<Vec<_>>()).map(f64::sqrt);
        let errors = truth.hover()?;
        let estimate = vector("hover_force")?;
        let (roll, pitch, yaw) = (column("roll")?, column("pitch")?, column("yaw")?);
        let attitude = |row: usize| Mat3::from_roll_pitch_yaw(roll[row], pitch[row], yaw[row]);
        // The angle of a rotation by its trace.
        let turned = |row: usize| {
            let m = attitude(row);
            (0.5 * (m.0[0][0] + m.0[1][1] + m.0[2][2] - 1.0)).clamp(-1.0, 1.0).acos()
        };
        let turned: Vec<f64> = (0..roll.len()).map(turned).collect();
        let mut air = vec![Vec3::ZERO; roll.len()];
        for source in LoadSource::ALL.iter().filter(|source| source.is_of_air()) {
            let forces = vector(&format!("force_{}", source.name()))?;
            air.iter_mut().zip(&forces).enumerate().for_each(|(row, (sum, f))| *sum += attitude(row) * *f);
        }
        let (truth, estimate) = (average(&air)?, average(&estimate)?);
        Some(Self {
            place_rms_m: rms(&errors.iter().map(|e| e.norm()).collect::<Vec<_>>())?,
            attitude_rms_deg: rms(&turned)?.to_degrees(),
            attitude_max_deg: turned.iter().copied().reduce(f64::max)?.to_degrees(),
            air_force_n: truth,
            air_force_estimate_n: estimate,
            air_force_error: (Vec3(estimate) - Vec3(truth)).norm() / Vec3(truth).norm(),
        })
    }
}
