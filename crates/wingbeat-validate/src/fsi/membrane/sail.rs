//! A sail of constant tension in plane, attached flow, independent of the library: Galerkin's method with the shapes
//! z_k = sin^2 t cos^k t, x = (1 - cos t)/2, and the pressure of Glauert's series.
//!
//! T z'' = -dp, dp = 2 rho V^2 [A0 cot(t/2) + sum An sin nt], A0 = alpha - mean of z', An = (2/pi) int z' cos nt dt (Glauert 1926, ch. 7);
//! tension over q c is C_T (Nielsen 1963; Thwaites 1961, whose lambda is 4/C_T).

use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Points of the quadrature over t, even: exact for these trigonometric sums.
const POINTS: usize = 400;

/// A sail at unit incidence.
pub struct Sail {
    /// Lift slope, 1/rad.
    pub slope: f64,
    /// Height over chord at mid chord per radian.
    pub middle: f64,
}

fn angles() -> impl Iterator<Item = f64> {
    (0..POINTS).map(|i| (i as f64 + 0.5) * PI / POINTS as f64)
}

/// Shape k, and its slope dz/dx over the chord.
fn shape(k: usize, t: f64) -> [f64; 2] {
    let (s, u) = t.sin_cos();
    let power = |n: i32| if n < 0 { 0.0 } else { u.powi(n) };
    let k_ = k as i32;
    [s * s * power(k_), 2.0 * (2.0 * power(k_ + 1) - k as f64 * s * s * power(k_ - 1))]
}

/// Stiffness by unit tension over q c, loads by the shapes, and loads by unit incidence, all over q c^2.
fn matrices(count: usize) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
    let step = PI / POINTS as f64;
    let series = |slope: &dyn Fn(f64) -> f64, incidence: f64| -> Vec<f64> {
        let coefficient = |n: usize| {
            let sum: f64 = angles().map(|t| slope(t) * (n as f64 * t).cos()).sum();
            2.0 / PI * sum * step
        };
        let mut all: Vec<f64> = (0..count + 3).map(coefficient).collect();
        all[0] = incidence - 0.5 * all[0];
        all
    };
    // dp/q = 4 [A0 cot(t/2) + sum An sin nt].
    let load = |series: &[f64], on: usize| -> f64 {
        let pressure = |t: f64| {
            let waves = series.iter().enumerate().skip(1);
            series[0] / (0.5 * t).tan() + waves.map(|(n, a)| a * (n as f64 * t).sin()).sum::<f64>()
        };
        angles().map(|t| 4.0 * pressure(t) * shape(on, t)[0] * 0.5 * t.sin()).sum::<f64>() * step
    };
    let by: Vec<Vec<f64>> = (0..count).map(|k| series(&|t| shape(k, t)[1], 0.0)).collect();
    let flat = series(&|_| 0.0, 1.0);
    let stiffness = DMatrix::from_fn(count, count, |i, j| {
        angles().map(|t| shape(i, t)[1] * shape(j, t)[1] * 0.5 * t.sin()).sum::<f64>() * step
    });
    let loads = DMatrix::from_fn(count, count, |i, j| load(&by[j], i));
    (stiffness, loads, DVector::from_fn(count, |i, _| load(&flat, i)))
}

/// A sail of which `ratio` is the ratio of tension to q c, with so many shapes.
pub fn solve(ratio: f64, shapes: usize) -> Sail {
    let (stiffness, loads, flat) = matrices(shapes);
    let heights = (stiffness * ratio - loads).lu().solve(&flat).unwrap_or_else(|| DVector::zeros(shapes));
    let step = PI / POINTS as f64;
    // C_L = 2 pi (A0 + A1/2) with A0 + A1/2 = 1 + (1/pi) int z' (cos t - 1) dt.
    let camber: f64 = angles()
        .map(|t| (0..shapes).map(|k| heights[k] * shape(k, t)[1]).sum::<f64>() * (t.cos() - 1.0))
        .sum();
    Sail { slope: TAU * (1.0 + camber * step / PI), middle: heights[0] }
}

/// Ratio of tension to q c at which a sail without incidence bulges: the largest eigenvalue of loads against stiffness.
pub fn divergence(shapes: usize) -> f64 {
    let (stiffness, loads, _) = matrices(shapes);
    let Some(system) = stiffness.lu().solve(&loads) else { return f64::NAN };
    system.complex_eigenvalues().iter().map(|value| value.re).fold(0.0, f64::max)
}
