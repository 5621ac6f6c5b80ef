//! The nodes of the lifting line: places, weights and constants.

use super::{JONES_RATES, LiftingLineSettings};
use std::f64::consts::PI;

/// Constants of one node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// 1 / chord of the planform, 1/m; all else holds the floored chord.
    pub inverse_edge: f64,
    pub half_chord: f64,
    pub inverse_chord: f64,
    /// Circulation per wash, a0 c / 2, m.
    pub circulation: f64,
    /// Rates of the lags per airspeed, 1/m.
    pub lag_rates: [f64; 2],
    /// rho a0 (c/2) dy: lift per wash and airspeed, kg/m.
    pub lift: f64,
    /// Added mass, kg.
    pub mass: f64,
    /// rho c dy / 2, kg/m.
    pub drag: f64,
}

impl Node {
    /// Node at `angle` with its quadrature `width` for the lift.
    pub fn new(chord: f64, width: f64, half_span: f64, angle: f64, set: &LiftingLineSettings) -> Self {
        let edge = chord;
        let chord = edge.max(set.chord_floor_m);
        let half_chord = 0.5 * chord;
        let area_width = half_span * fejer_weight(angle, set.nodes);
        let mass = set.density_kg_m3 * PI * half_chord * half_chord * area_width;
        Self {
            inverse_edge: 1.0 / edge,
            half_chord,
            inverse_chord: 1.0 / chord,
            circulation: set.section_slope * half_chord,
            lag_rates: JONES_RATES.map(|e| e / half_chord),
            lift: set.density_kg_m3 * set.section_slope * half_chord * width,
            mass,
            drag: 0.5 * set.density_kg_m3 * chord * area_width,
        }
    }
}

/// theta_i = i pi/(m+1), left tip (0) to right tip (pi).
pub(super) fn node_angles(m: usize) -> Vec<f64> {
    (1..=m).map(|i| i as f64 * PI / (m + 1) as f64).collect()
}

/// Fejer's second rule on cos(theta_i) over [-1, 1] (Fejer 1933): for
/// quantities that do not vanish at the tips, exact for polynomials.
fn fejer_weight(angle: f64, m: usize) -> f64 {
    let sum: f64 = (1..=m.div_ceil(2)).map(|k| (2 * k - 1) as f64).map(|n| (n * angle).sin() / n).sum();
    4.0 * angle.sin() / (m + 1) as f64 * sum
}

/// D_ij = 1/(2 span) sum_n n 2/(m+1) sin(n theta_j) sin(n theta_i) / sin(theta_i)
/// (Glauert 1926; Multhopp 1938). Entries that cancel exactly are set to zero.
pub(super) fn influence(angles: &[f64], span: f64) -> Vec<f64> {
    let m = angles.len();
    let mut d = vec![0.0; m * m];
    for i in 0..m {
        for j in (0..m).filter(|j| i == *j || (i + j) % 2 == 1) {
            let sum: f64 =
                (1..=m).map(|n| n as f64).map(|n| n * (n * angles[j]).sin() * (n * angles[i]).sin()).sum();
            d[i * m + j] = sum / (span * (m + 1) as f64 * angles[i].sin());
        }
    }
    d
}
