//! Orthographic view of world coordinates (x forward, y left, z up) on paper.

/// A direction of view: the paper's axes in world coordinates, and what is nearer.
#[derive(Clone, Copy, Debug)]
pub struct View {
    right: [f64; 3],
    down: [f64; 3],
}

impl View {
    /// The view from `azimuth` about z (0 looks along -x from positive x) and `elevation` above the ground, degrees.
    pub fn new(azimuth_deg: f64, elevation_deg: f64) -> Self {
        let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
        Self { right: [-sin_a, cos_a, 0.0], down: [sin_e * cos_a, sin_e * sin_a, -cos_e] }
    }

    /// How near a point is to the eye: along right x down, which points away from it, backwards.
    pub fn nearness(&self, point: [f64; 3]) -> f64 {
        let ([a, b, c], [x, y, z]) = (self.right, self.down);
        let away = [b * z - c * y, c * x - a * z, a * y - b * x];
        -away.iter().zip(point).map(|(a, p)| a * p).sum::<f64>()
    }

    /// Paper coordinates (right, down) of a point.
    pub fn project(&self, point: [f64; 3]) -> (f64, f64) {
        let dot = |axis: [f64; 3]| axis.iter().zip(point).map(|(a, p)| a * p).sum();
        (dot(self.right), dot(self.down))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_across_the_view_are_kept_and_up_is_up() {
        let view = View::new(-50.0, 25.0);
        let (_, up) = view.project([0.0, 0.0, 1.0]);
        assert!((up + 25_f64.to_radians().cos()).abs() < 1e-12);
        let dot: f64 = view.right.iter().zip(view.down).map(|(a, b)| a * b).sum();
        assert!(dot.abs() < 1e-12);
        let from_above = View::new(-90.0, 90.0);
        let (right, down) = from_above.project([1.0, 2.0, 3.0]);
        assert!((right - 1.0).abs() < 1e-12 && (down + 2.0).abs() < 1e-12);
    }
}
