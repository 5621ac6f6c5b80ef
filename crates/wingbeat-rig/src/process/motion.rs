//! How the arm moved, by the joints of a record.

use super::Butterworth;
use crate::JointTrajectory;
use crate::arm::SerialArm;
use wingbeat_flight::simulate::{Column, Record};
use wingbeat_math::interpolation::piecewise_linear;

/// Cut-off of positions whose rates are not recorded, Hz. *Choice*: far above a turn of a second, far below the noise of
/// encoders.
const CUTOFF_HZ: f64 = 10.0;
/// Shortest step of the motion, s.
const STEP_S: f64 = 1e-3;

/// Part of a step by which times may lie off equal steps from 0 s. *Choice.*
const OFF: f64 = 0.01;

/// The motion of `arm` from 0 to `until` s by the columns q1, q2 .. of a record; with dq1 .. and ddq1 .. where
/// they are recorded, else by differences of the filtered positions. Rows that begin later than 0, or lie at unequal steps, are read off
/// straight lines between them, and the arm rests where the first one has it before. None without a column for every joint, or with gaps.
pub fn recorded_motion(record: &Record, arm: &SerialArm, until: f64) -> Option<JointTrajectory> {
    let t = record.values("t")?;
    let from = t.partition_point(|t| *t < -1e-9);
    let to = t.partition_point(|t| *t <= until);
    if to < from + 3 {
        return None;
    }
    let step = (t[to - 1] - t[from]) / (to - 1 - from) as f64;
    if !(step > 0.0) {
        return None;
    }
    let every = (STEP_S / step).round().max(1.0) as usize;
    let of = |prefix: &str| -> Option<Vec<&[f64]>> {
        let columns: Option<Vec<&[f64]>> =
            (1..=arm.dof()).map(|j| record.values(&format!("{prefix}{j}"))).collect();
        columns.filter(|of| of.iter().all(|values| values[from..to].iter().all(|value| value.is_finite())))
    };
    let positions = of("q")?;
    let is_off = |(k, t): (usize, &f64)| (t - k as f64 * step).abs() > OFF * step;
    if t[from..to].iter().enumerate().any(is_off) {
        if t[from..to].windows(2).any(|pair| pair[1] <= pair[0]) {
            return None;
        }
        let (given, last) = (&t[from..to], (t[to - 1] / step) as usize);
        let parts = ["q", "dq", "ddq"].into_iter().filter_map(|prefix| Some((prefix, of(prefix)?)));
        let parts: Vec<(String, &[f64])> = parts
            .flat_map(|(prefix, of)| {
                of.into_iter().enumerate().map(move |(j, column)| (format!("{prefix}{}", j + 1), column))
            })
            .collect();
        let names = std::iter::once("t").chain(parts.iter().map(|(name, _)| name.as_str()));
        let mut even = Record::new(names.map(|name| Column::new(name, "", "")).collect(), last + 1).ok()?;
        for at in (0..=last).map(|k| k as f64 * step) {
            let read = |(name, column): &(String, &[f64])| match at < given[0] && name.starts_with('d') {
                true => 0.0,
                false => piecewise_linear(given, &column[from..to], at),
            };
            even.append(&std::iter::once(at).chain(parts.iter().map(read)).collect::<Vec<f64>>());
        }
        return recorded_motion(&even, arm, until);
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
