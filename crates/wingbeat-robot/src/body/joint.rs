//! The axis of a revolute joint.

use wingbeat_math::{Mat3, Scalar, Vec3};

/// Axis of rotation; the coordinate axes are told apart because they are cheap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RotationAxis {
    /// `sign` times the coordinate axis `index`.
    Coordinate { index: usize, sign: f64 },
    /// Any unit vector.
    General(Vec3),
}

impl RotationAxis {
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
            Self::Coordinate { index, sign } => r.column(index).scaled(sign),
            Self::General(axis) => r.mul_constant(axis),
        }
    }

    /// `r` times the rotation about the axis by the angle of this sine and cosine.
    #[inline]
    pub(super) fn turn<S: Scalar>(&self, r: &Mat3<S>, turn: [S; 2]) -> Mat3<S> {
        match *self {
            Self::Coordinate { index: 0, sign } => turn_columns::<1, 2, S>(r, turn, sign),
            Self::Coordinate { index: 1, sign } => turn_columns::<2, 0, S>(r, turn, sign),
            Self::Coordinate { sign, .. } => turn_columns::<0, 1, S>(r, turn, sign),
            Self::General(axis) => *r * Mat3::rotation_by(axis, turn),
        }
    }
}

/// Turns columns `J` and `K` into each other: a rotation about the third axis.
#[inline]
fn turn_columns<const J: usize, const K: usize, S: Scalar>(
    r: &Mat3<S>,
    [s, c]: [S; 2],
    sign: f64,
) -> Mat3<S> {
    let s = s * sign;
    let mut turned = *r;
    for i in 0..3 {
        let (j, k) = (r.0[i][J], r.0[i][K]);
        turned.0[i][J] = (j * c).plus_product(k, s);
        turned.0[i][K] = (k * c).less_product(j, s);
    }
    turned
}
