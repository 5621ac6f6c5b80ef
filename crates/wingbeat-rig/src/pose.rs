//! Rigid placements of one frame in another.

use std::ops::Mul;
use wingbeat_math::{Mat3, Scalar, Vec3};

/// Placement X_AB of frame B in frame A: rotation R_AB and origin p_AB, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<S: Scalar = f64> {
    /// R_AB.
    pub rotation: Mat3<S>,
    /// p_AB, m.
    pub origin: Vec3<S>,
}

impl<S: Scalar> Pose<S> {
    /// B on A.
    pub const IDENTITY: Self = Self { rotation: Mat3::IDENTITY, origin: Vec3::ZERO };

    /// A constant placement.
    #[inline]
    pub fn constant(x: &Pose<f64>) -> Self {
        Self { rotation: Mat3::constant(x.rotation), origin: Vec3::constant(x.origin) }
    }
    /// The values without derivatives.
    #[inline]
    pub fn values(&self) -> Pose<f64> {
        Pose { rotation: self.rotation.each(S::value), origin: self.origin.values() }
    }
    /// X_BA.
    #[inline]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, origin: -(rotation * self.origin) }
    }
    /// The point `p_B` in A, m.
    #[inline]
    pub fn point(&self, p: Vec3<S>) -> Vec3<S> {
        self.rotation * p + self.origin
    }
}

impl Pose<f64> {
    /// From an origin in m and roll, pitch, yaw in rad (R = Rz Ry Rx, the convention of URDF).
    pub fn from_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Self {
        Self { rotation: Mat3::from_roll_pitch_yaw(rpy[0], rpy[1], rpy[2]), origin: Vec3(xyz) }
    }
}

impl<S: Scalar> Mul for Pose<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self { rotation: self.rotation * o.rotation, origin: self.point(o.origin) }
    }
}

/// Rotation vector of the rotation `r`, angle in [0, pi], rad; exact near 0 and near pi.
pub fn rotation_vector(r: &Mat3<f64>) -> Vec3<f64> {
    let m = &r.0;
    let sine = Vec3([m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]) * 0.5;
    let cosine = 0.5 * (m[0][0] + m[1][1] + m[2][2] - 1.0);
    let s = sine.norm();
    let angle = s.atan2(cosine);
    if s > 1e-6 {
        return sine * (angle / s);
    }
    if cosine > 0.0 {
        return sine;
    }
    // Near pi the axis a is the largest column of (R + R')/2 - cos I = (1 - cos) a a'.
    let column = |j: usize| {
        Vec3(std::array::from_fn(|i| 0.5 * (m[i][j] + m[j][i]) - if i == j { cosine } else { 0.0 }))
    };
    let axis = (0..3).map(column).max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or(Vec3::ZERO).unit();
    let sign = if axis.dot(sine) < 0.0 { -1.0 } else { 1.0 };
    axis * (sign * angle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_vector_inverts_rodrigues() {
        let axis = Vec3([0.36, -0.48, 0.8]);
        for angle in [0.0, 1e-9, 1e-4, 1.0, 3.0, 3.13, std::f64::consts::PI - 1e-9] {
            let back = rotation_vector(&Mat3::rotation_about(axis, angle));
            assert!((back - axis * angle).norm() < 1e-8, "{angle}: {back:?}");
        }
    }

    #[test]
    fn inverse_undoes() {
        let x = Pose::from_xyz_rpy([0.1, -0.2, 0.3], [0.4, -0.5, 0.6]);
        let e = x * x.inverse();
        assert!(e.origin.norm() < 1e-15 && rotation_vector(&e.rotation).norm() < 1e-15);
    }
}
