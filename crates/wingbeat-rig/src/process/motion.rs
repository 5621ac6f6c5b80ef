//! How the arm moved, by the joints of a record.

use super::Butterworth;
use crate::JointTrajectory;
use crate::arm::SerialArm;
use wingbeat_flight::simulate::Record;

/// Cut-off of positions whose rates are not recorded, Hz. *Choice*: far above a turn of a second, far below the noise of
/// encoders.
const CUTOFF_HZ: f64 = 10.0;
/// Shortest step of the motion, s.
const STEP_S: f64 = 1e-3;

/// The motion of `arm` from 0 to `until` s by the columns q1, q2 .. of a record at equal steps; with dq1 .. and ddq1 .. where
/// they are recorded, else by differences of the filtered positions. None without a column for every joint, or with gaps.
pub fn recorded_motion(record: &Record, arm: &SerialArm, until: f64) -> Option<JointTrajectory> {
    let t = record.values("t")?;
    let from = t.partition_point(|t| *t < -1e-9);
    let to = t.partition_point(|t| *t <= until);
    if to < from + 3 {
        return None;
    }
    let step = (t[to - 1] - t[from]) / (to - 1 - from) as f64;
    let every = (STEP_S / step).round().max(1.0) as usize;
    let of = |prefix: &str| -> Option<Vec<&[f64]>> {
        (1..=arm.dof()).map(|j| record.values(&format!("{prefix}{j}"))).collect()
    };
    let positions = of("q")?;
    if positions.iter().any(|q| q[from..to].iter().any(|q| !q.is_finite())) {
        return None;
    }
    let joints: Vec<String> = (1..=arm.dof()).map(|j| format!("q{j}")).collect();
    let rows = |columns: &[&[f64]]| -> Vec<Vec<f64>> {
        (from..to).step_by(every).map(|k| columns.iter().map(|column| column[k]).collect()).collect()
    };
    if let (Some(rates), Some(slopes)) = (of("dq"), of("ddq")) {
        let step = step * every as f64;
        let (velocity, acceleration) = (rows(&rates), rows(&slopes));
        return Some(JointTrajectory { joints, step, position: rows(&positions), velocity, acceleration });
    }
    let filter = Butterworth::new(CUTOFF_HZ, 1.0 / step).ok()?;
    let smooth: Vec<Vec<f64>> = positions.iter().map(|q| filter.apply(&q[from..to])).collect();
    let position = (0..to - from).step_by(every).map(|k| smooth.iter().map(|q| q[k]).collect()).collect();
    let step = step * every as f64;
    Some(JointTrajectory { joints, step, position, ..JointTrajectory::default() }.differenced())
}
