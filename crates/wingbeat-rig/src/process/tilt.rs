//! Mass, centre and offsets from the weight in several attitudes.

use serde::Serialize;
use wingbeat_math::Error;
use wingbeat_math::linear::{lu_factor, lu_solve, symmetric_eigenvalues};
use wingbeat_math::{GRAVITY, Vec3};

/// The mean wrench of one attitude, held still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Middle of the time it was held, s.
    pub time: f64,
    /// Gravity in the cell's frame, m/s2.
    pub gravity: Vec3,
    /// Fx .. Tz in the cell's frame, N and N m.
    pub wrench: [f64; 6],
}

/// What the cell carries, from tilts. Plus-minus is one standard deviation of the fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Weighing {
    /// Attitudes.
    pub tilts: usize,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Its plus-minus.
    pub mass_sigma_kg: f64,
    /// Centre of mass in the cell's frame, m.
    pub com_m: [f64; 3],
    /// Its plus-minus.
    pub com_sigma_m: [f64; 3],
    /// Offsets of the channels at t = 0, N and N m.
    pub bias: [f64; 6],
    /// Their drift per s; zero when not fitted.
    pub drift_per_s: [f64; 6],
    /// Root mean square of what is left of forces, N, and moments, N m.
    pub residual_rms: [f64; 2],
    /// Largest of what is left of forces, N, and moments, N m.
    pub residual_largest: [f64; 2],
}

/// Variance of mass and first moments beside offsets and drift, over that beside known ones, from which they are not determined. *Choice.*
const INFLATION: f64 = 1e4;
/// Unknowns: mass, first moment, offsets, and drift where wanted.
const FIXED: usize = 10;

/// Least squares of F = b + d t + m g and T = b' + d' t + (m c) x g over the tilts. Moments are
/// weighed against forces by `lever` (m), the length at which both are known equally well.
///
/// Equation: rig.static_tilts
/// `F = b + d t + m g, T = b' + d' t + (m c) x g, least squares`
/// Source: weight of a rigid load in several attitudes.
/// Test: `mass_centre_bias_and_drift_come_back`.
///
/// # Errors
/// Tilts that do not part mass and centre from the offsets.
pub fn weigh(tilts: &[Tilt], drift: bool, lever: f64) -> Result<Weighing, Error> {
    let unknowns = if drift { FIXED + 6 } else { FIXED };
    if spread(tilts) < 1e-3 * GRAVITY * GRAVITY || 6 * tilts.len() < unknowns {
        let allowed = "three attitudes or more, tilted about two axes by 10 deg or more, and one of them twice \
                       where drift is fitted";
        return Err(Error::invalid("hold.tilts_deg", format!("{} attitudes", tilts.len()), allowed));
    }
    let rows: Vec<(Vec<f64>, f64)> = tilts.iter().flat_map(|tilt| rows(tilt, unknowns, lever)).collect();
    let mut normal = vec![0.0; unknowns * unknowns];
    let mut solution = vec![0.0; unknowns];
    for (row, value) in &rows {
        for i in 0..unknowns {
            solution[i] += row[i] * value;
            for j in 0..unknowns {
                normal[i * unknowns + j] += row[i] * row[j];
            }
        }
    }
    let mut pivots = vec![0; unknowns];
    let own: [f64; 4] = std::array::from_fn(|i| normal[i * unknowns + i]);
    let undetermined = || {
        let allowed = "tilts that part mass and centre from the offsets, and from their drift where that is fitted: one attitude twice or more of them";
        Error::invalid("hold.tilts_deg", format!("{} attitudes", tilts.len()), allowed)
    };
    if !lu_factor(&mut normal, unknowns, &mut pivots) {
        return Err(undetermined());
    }
    lu_solve(&normal, unknowns, &pivots, &mut solution, 1);
    let left = |(row, value): &(Vec<f64>, f64)| value - dot(row, &solution);
    let residuals: Vec<f64> = rows.iter().map(left).collect();
    let freedom = (rows.len() - unknowns).max(1) as f64;
    let variance = residuals.iter().map(|r| r * r).sum::<f64>() / freedom;
    let inverse = |i: usize| -> Vec<f64> {
        let mut unit = vec![0.0; unknowns];
        unit[i] = 1.0;
        lu_solve(&normal, unknowns, &pivots, &mut unit, 1);
        unit
    };
    // How much more of the variance an unknown has than if the others were known.
    let columns: [Vec<f64>; 4] = std::array::from_fn(inverse);
    // Rounding makes that of a singular matrix large, or negative.
    let known = |(i, (column, own)): (usize, (&Vec<f64>, f64))| (0.0..INFLATION).contains(&(column[i] * own));
    if !columns.iter().zip(own).enumerate().all(known) {
        return Err(undetermined());
    }
    let mass = solution[0];
    // Of (m c)/m: both err, and together.
    let com_variance = |i: usize| {
        let c = solution[1 + i] / mass;
        columns[1 + i][1 + i] + c * c * columns[0][0] - 2.0 * c * columns[0][1 + i]
    };
    let sigma = |of: f64| (variance * of.max(0.0)).sqrt();
    let part = |from: usize| std::array::from_fn(|i| solution.get(from + i).copied().unwrap_or(0.0));
    Ok(Weighing {
        tilts: tilts.len(),
        mass_kg: mass,
        mass_sigma_kg: sigma(columns[0][0]),
        com_m: std::array::from_fn(|i| solution[1 + i] / mass),
        com_sigma_m: std::array::from_fn(|i| sigma(com_variance(i)) / mass.abs()),
        bias: part(4),
        drift_per_s: part(FIXED),
        residual_rms: parts(&residuals, lever, |r| {
            (r.iter().map(|x| x * x).sum::<f64>() / r.len() as f64).sqrt()
        }),
        residual_largest: parts(&residuals, lever, |r| r.iter().fold(0.0, |most: f64, x| most.max(x.abs()))),
    })
}

/// The six equations of one tilt; those of moments are divided by `lever`.
fn rows(tilt: &Tilt, unknowns: usize, lever: f64) -> Vec<(Vec<f64>, f64)> {
    let g = tilt.gravity;
    // (m c) x g as a matrix on m c.
    let cross = [[0.0, g[2], -g[1]], [-g[2], 0.0, g[0]], [g[1], -g[0], 0.0]];
    let equation = |i: usize| {
        let mut row = vec![0.0; unknowns];
        match i {
            0..3 => row[0] = g[i],
            _ => row[1..4].copy_from_slice(&cross[i - 3]),
        }
        row[4 + i] = 1.0;
        if unknowns > FIXED {
            row[FIXED + i] = tilt.time;
        }
        let weight = if i < 3 { 1.0 } else { 1.0 / lever };
        row.iter_mut().for_each(|x| *x *= weight);
        (row, weight * tilt.wrench[i])
    };
    (0..6).map(equation).collect()
}

/// Forces and moments of the residuals through `f`.
fn parts(residuals: &[f64], lever: f64, f: impl Fn(&[f64]) -> f64) -> [f64; 2] {
    let of = |moments: bool| -> Vec<f64> {
        let here = residuals.iter().enumerate().filter(|(k, _)| (k % 6 >= 3) == moments);
        here.map(|(_, r)| if moments { r * lever } else { *r }).collect()
    };
    [f(&of(false)), f(&of(true))]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// How far the directions of gravity spread about their mean along the second axis, m2/s4.
fn spread(tilts: &[Tilt]) -> f64 {
    let n = tilts.len().max(1) as f64;
    let mean = tilts.iter().fold(Vec3::ZERO, |sum, tilt| sum + tilt.gravity) * (1.0 / n);
    let mut covariance = [[0.0; 3]; 3];
    for tilt in tilts {
        let d = tilt.gravity - mean;
        for i in 0..3 {
            for j in 0..3 {
                covariance[i][j] += d[i] * d[j] / n;
            }
        }
    }
    let mut values = symmetric_eigenvalues(covariance);
    wingbeat_math::order::ascend(&mut values);
    values[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use wingbeat_math::Mat3;

    fn tilt(k: usize, roll: f64, pitch: f64) -> Tilt {
        let (m, c) = (0.031, Vec3([0.002, -0.003, 0.05]));
        let time = k as f64;
        let gravity = Mat3::from_roll_pitch_yaw(roll, pitch, 0.0).transpose_mul(Vec3([0.0, 0.0, -GRAVITY]));
        let (force, moment) = (gravity * m, (c * m).cross(gravity));
        let bias = [0.1, -0.2, 0.3, 1e-3, 2e-3, -3e-3];
        let wrench = std::array::from_fn(|i| {
            bias[i] * (1.0 + 0.01 * time) + if i < 3 { force[i] } else { moment[i - 3] }
        });
        Tilt { time, gravity, wrench }
    }

    #[test]
    fn mass_centre_bias_and_drift_come_back() {
        let angles = [(0.0, 0.0), (0.8, 0.0), (-0.8, 0.0), (0.0, 0.8), (0.0, -0.8), (3.1, 0.0), (0.0, 0.0)];
        let tilts: Vec<Tilt> = angles.iter().enumerate().map(|(k, (r, p))| tilt(k, *r, *p)).collect();
        let found = weigh(&tilts, true, 0.01).unwrap();
        assert!((found.mass_kg - 0.031).abs() < 1e-12 && (found.com_m[2] - 0.05).abs() < 1e-11);
        assert!((found.bias[2] - 0.3).abs() < 1e-11 && (found.drift_per_s[0] - 1e-3).abs() < 1e-12);
        assert!(found.residual_largest[0] < 1e-12 && found.residual_largest[1] < 1e-12);
        // Without drift in the fit it stays in the residual.
        assert!(weigh(&tilts, false, 0.01).unwrap().residual_rms[0] > 1e-4);
    }

    #[test]
    fn tilts_about_one_axis_do_not_suffice() {
        let tilts: Vec<Tilt> = (0..9).map(|k| tilt(k, 0.3 * k as f64, 0.0)).collect();
        assert!(weigh(&tilts, true, 0.01).is_ok());
        let same: Vec<Tilt> = (0..9).map(|k| tilt(k, 0.02 * k as f64, 0.0)).collect();
        assert!(weigh(&same, true, 0.01).unwrap_err().to_string().contains("hold.tilts_deg"));
        assert!(weigh(&tilts[..2], false, 0.01).is_err());
        // As many equations as unknowns determine nothing beside a drift.
        let three: Vec<Tilt> = [(0.0, 0.0), (0.8, 0.0), (0.0, 0.8)]
            .iter()
            .enumerate()
            .map(|(k, (r, p))| tilt(k, *r, *p))
            .collect();
        assert!(weigh(&three, false, 0.01).is_ok());
        assert!(weigh(&three, true, 0.01).unwrap_err().to_string().contains("their drift"));
    }
}
