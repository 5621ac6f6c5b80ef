//! A camera that looks at world coordinates (x forward, y left, z up).

use super::WorldPoint;

/// Nearest point that a perspective shows, over the distance of its target: what is nearer is drawn as if it were there. *Choice.*
const NEAREST: f64 = 0.05;

/// A direction of view with its axes on paper, and the distance of the eye where it has one.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    right: WorldPoint,
    down: WorldPoint,
    away: WorldPoint,
    eye: Option<Eye>,
}

/// The eye of a perspective.
#[derive(Clone, Copy, Debug)]
struct Eye {
    target: WorldPoint,
    distance: f64,
}

impl Camera {
    /// Parallel rays from `azimuth` about z (0 looks along -x from positive x) and `elevation` above the ground, degrees.
    pub fn orthographic(azimuth_deg: f64, elevation_deg: f64) -> Self {
        let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
        let away = [-cos_e * cos_a, -cos_e * sin_a, -sin_e];
        Self { right: [-sin_a, cos_a, 0.0], down: [sin_e * cos_a, sin_e * sin_a, -cos_e], away, eye: None }
    }

    /// Rays into an eye that looks at `target` from the same direction and `distance` m off. Lengths at the target are kept.
    pub fn perspective(azimuth_deg: f64, elevation_deg: f64, target: WorldPoint, distance: f64) -> Self {
        Self { eye: Some(Eye { target, distance }), ..Self::orthographic(azimuth_deg, elevation_deg) }
    }

    /// Paper coordinates of a point, m to the right and down: along parallel rays p.r and p.d; into an eye at distance D from its
    /// target q' = p - target goes to q'.r D / (D + q'.a) and q'.d D / (D + q'.a), with r right, d down and a away from the eye.
    pub fn project(&self, point: WorldPoint) -> (f64, f64) {
        match self.eye {
            None => (dot(self.right, point), dot(self.down, point)),
            Some(Eye { target, distance }) => {
                let from = minus(point, target);
                let depth = (distance + dot(self.away, from)).max(NEAREST * distance);
                let share = distance / depth;
                (share * dot(self.right, from), share * dot(self.down, from))
            }
        }
    }

    /// How near a point is to the eye, in an order, of which only the sign counts (m or m2): larger is nearer.
    pub fn nearness(&self, point: WorldPoint) -> f64 {
        match self.eye {
            None => -dot(self.away, point),
            Some(Eye { target, distance }) => {
                let from = minus(point, target);
                let eye: WorldPoint = std::array::from_fn(|i| from[i] + distance * self.away[i]);
                -dot(eye, eye)
            }
        }
    }
}

pub(super) fn dot(a: WorldPoint, b: WorldPoint) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: WorldPoint, b: WorldPoint) -> WorldPoint {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_across_the_view_are_kept_and_up_is_up() {
        let camera = Camera::orthographic(-50.0, 25.0);
        let (_, up) = camera.project([0.0, 0.0, 1.0]);
        assert!((up + 25_f64.to_radians().cos()).abs() < 1e-12);
        assert!(dot(camera.right, camera.down).abs() < 1e-12);
        let [a, b, c] = camera.right;
        let [x, y, z] = camera.down;
        let across = [b * z - c * y, c * x - a * z, a * y - b * x];
        assert!(minus(across, camera.away).iter().all(|part| part.abs() < 1e-12));
        let from_above = Camera::orthographic(-90.0, 90.0);
        let (right, down) = from_above.project([1.0, 2.0, 3.0]);
        assert!((right - 1.0).abs() < 1e-12 && (down + 2.0).abs() < 1e-12);
        assert!(from_above.nearness([0.0, 0.0, 1.0]) > from_above.nearness([0.0; 3]));
    }

    #[test]
    fn a_perspective_halves_what_is_twice_as_far_and_ends_in_parallel_rays() {
        let target = [1.0, 2.0, 0.5];
        // It looks along -x from 2 m before the target; y lies to the right.
        let camera = Camera::perspective(0.0, 0.0, target, 2.0);
        let (right, down) = camera.project([1.0, 2.3, 0.5]);
        assert!((right - 0.3).abs() < 1e-12 && down.abs() < 1e-12);
        assert!((camera.project([-1.0, 2.3, 0.5]).0 - 0.15).abs() < 1e-12);
        assert!(camera.nearness([2.0, 2.0, 0.5]) > camera.nearness([1.5, 2.0, 0.5]));
        assert!(camera.project([9.0, 2.3, 0.5]).0.is_finite());
        let far = Camera::perspective(-50.0, 25.0, [0.0; 3], 1e9);
        let parallel = Camera::orthographic(-50.0, 25.0);
        let ((a, b), (c, d)) = (far.project(target), parallel.project(target));
        assert!((a - c).abs() < 1e-7 && (b - d).abs() < 1e-7);
    }
}
