//! What the camber line of a thin section does in attached flow.

use std::f64::consts::PI;

/// A thin section in plane, attached flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSection {
    /// Incidence of the chord at which it bears no lift, rad; negative with camber upward.
    pub zero_lift_angle_rad: f64,
    /// Coefficient of the moment about a quarter of the chord, positive nose up.
    pub quarter_chord_moment: f64,
}

impl ThinSection {
    /// Of a camber line that is straight between `points`, (x, z) over the chord, x ascending from 0 to 1: with
    /// x = (1 - cos t)/2 the integrals -(1/pi) ∫ z' (cos t - 1) dt and (A2 - A1) pi/4, An = (2/pi) ∫ z' cos(n t) dt, are
    /// exact for each piece.
    ///
    /// Equation: aero.camber
    /// `zero-lift angle -(1/pi) int z' (cos t - 1) dt and moment (A2 - A1) pi/4 of a camber line, x = (1 - cos t)/2`
    /// Source: Glauert 1926, The Elements of Aerofoil and Airscrew Theory, ch. 7.
    /// Test: `a_parabolic_camber_line_has_glauerts_angle_and_moment`.
    pub fn of_camber(points: &[[f64; 2]]) -> Self {
        let angle = |x: f64| (1.0 - 2.0 * x).clamp(-1.0, 1.0).acos();
        let (mut mean, mut first, mut second) = (0.0, 0.0, 0.0);
        for pair in points.windows(2) {
            let ([x, z], [to, up]) = (pair[0], pair[1]);
            let (from, till, slope) = (angle(x), angle(to), (up - z) / (to - x));
            mean += slope * (till - from);
            first += slope * (till.sin() - from.sin());
            second += slope * 0.5 * ((2.0 * till).sin() - (2.0 * from).sin());
        }
        Self { zero_lift_angle_rad: (mean - first) / PI, quarter_chord_moment: 0.5 * (second - first) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parabola z = 4 h x (1 - x) has alpha_0 = -2 h and c_m = -pi h (Glauert 1926, ch. 7).
    #[test]
    fn a_parabolic_camber_line_has_glauerts_angle_and_moment() {
        let camber = 0.03;
        let x = |k: usize| 0.5 * (1.0 - (PI * k as f64 / 400.0).cos());
        let points: Vec<[f64; 2]> = (0..=400).map(|k| [x(k), 4.0 * camber * x(k) * (1.0 - x(k))]).collect();
        let section = ThinSection::of_camber(&points);
        assert!((section.zero_lift_angle_rad + 2.0 * camber).abs() < 1e-6, "{section:?}");
        assert!((section.quarter_chord_moment + PI * camber).abs() < 1e-5, "{section:?}");
    }
}
