//! The axis of a revolute joint.

use crate::math::{Mat3, Scalar, Vec3};

/// Axis of rotation; the coordinate axes are told apart because they are cheap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Axis {
    /// `sign` times the coordinate axis `index`.
    Coordinate { index: usize, sign: f64 },
    /// Any unit vector.
    General(Vec3),
}

impl Axis {
    /// The axis along the unit vector `axis`.
    pub(super) fn new(axis: Vec3) -> Self {
        match (0..3).find(|&i| axis[i].abs() == 1.0) {
            Some(index) => Self::Coordinate { index, sign: axis[index] },
            None => Self::General(axis),
        }
    }

    /// The axis in the frame that `r` turns coordinates into.
    #[inline]
    pub(super) fn direction<S: Scalar>(&self, r: &Mat3<S>) -> Vec3<S> {
        match *self {
            Self::Coordinate { index, sign } => Vec3(r.0.map(|row| row[index] * sign)),
            Self::General(axis) => r.mul_constant(axis),
        }
    }

    /// `r` times the rotation by `angle` rad about the axis.
    #[inline]
    pub(super) fn turn<S: Scalar>(&self, r: &Mat3<S>, angle: S) -> Mat3<S> {
        let (index, sign) = match *self {
            Self::Coordinate { index, sign } => (index, sign),
            Self::General(axis) => return *r * Mat3::rotation_about(axis, angle),
        };
        let (s, c) = angle.sin_cos();
        let s = s * sign;
        let (j, k) = ((index + 1) % 3, (index + 2) % 3);
        Mat3(r.0.map(|row| {
            let mut turned = row;
            turned[j] = row[j] * c + row[k] * s;
            turned[k] = row[k] * c - row[j] * s;
            turned
        }))
    }
}
