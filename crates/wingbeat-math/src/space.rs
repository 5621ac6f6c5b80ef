//! Vectors, rotations and frames in three dimensions.
//!
//! Monogram notation: `R_WB` turns coordinates in B into coordinates in W,
//! `p_WB` is the position of B's origin in W, `w_WB_B` the angular rate of B
//! in W, resolved in B. Body axes are FLU (x forward, y left, z up).

use super::{Meets, Scalar};
use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

/// A vector of three components. Its components are in the caller's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3<S: Scalar = f64>(pub [S; 3]);

impl<S: Scalar> Vec3<S> {
    /// The zero vector.
    pub const ZERO: Self = Self([S::ZERO; 3]);

    /// From components.
    #[inline]
    pub fn new(x: S, y: S, z: S) -> Self {
        Self([x, y, z])
    }
    /// A constant vector.
    #[inline]
    pub fn constant(v: Vec3<f64>) -> Self {
        let [x, y, z] = v.0;
        Self([S::from(x), S::from(y), S::from(z)])
    }
    /// `f` of each component: written out, as a closure in `array::map` stays a call.
    #[inline(always)]
    pub fn each<T: Scalar>(self, f: impl Fn(S) -> T) -> Vec3<T> {
        let [x, y, z] = self.0;
        Vec3([f(x), f(y), f(z)])
    }
    /// The values without derivatives.
    #[inline]
    pub fn values(self) -> Vec3<f64> {
        self.each(S::value)
    }
    /// From the first three entries of a slice.
    #[inline]
    pub fn from_slice(s: &[S]) -> Self {
        Self([s[0], s[1], s[2]])
    }
    /// Writes the components into the first three entries of a slice.
    #[inline]
    pub fn store(self, s: &mut [S]) {
        s[..3].copy_from_slice(&self.0);
    }
    /// Scalar product.
    #[inline]
    pub fn dot(self, o: Self) -> S {
        (self.0[0] * o.0[0]).plus_product(self.0[1], o.0[1]).plus_product(self.0[2], o.0[2])
    }
    /// Vector product.
    #[inline]
    pub fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([(b * z).less_product(c, y), (c * x).less_product(a, z), (a * y).less_product(b, x)])
    }
    /// Adds the vector product of `a` and `b`, component by component in place: a vector of large numbers that is made elsewhere is copied.
    #[inline]
    pub fn add_cross(&mut self, a: &Self, b: &Self) {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.0[i] += (a.0[j] * b.0[k]).less_product(a.0[k], b.0[j]);
        }
    }
    /// Becomes the vector product of `a` and `b`, likewise.
    #[inline]
    pub fn set_cross(&mut self, a: &Self, b: &Self) {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            self.0[i] = (a.0[j] * b.0[k]).less_product(a.0[k], b.0[j]);
        }
    }
    /// Squared length.
    #[inline]
    pub fn norm_squared(self) -> S {
        if const { S::NARROW } {
            return self.dot(self);
        }
        self.0[0].squared() + self.0[1].squared() + self.0[2].squared()
    }
    /// Length; not differentiable at zero.
    #[inline]
    pub fn norm(self) -> S {
        self.norm_squared().sqrt()
    }
    /// Unit vector; the length must not be zero.
    #[inline]
    pub fn unit(self) -> Self {
        self * self.norm().recip()
    }
    /// Scaled by a constant; cheaper than by a [`Scalar`].
    #[inline]
    pub fn scaled<P: Copy>(self, k: P) -> Self
    where
        S: Mul<P, Output = S>,
    {
        let [x, y, z] = self.0;
        Self([x * k, y * k, z * k])
    }
    /// True when every component and its derivatives are zero.
    #[inline]
    pub fn is_zero(self) -> bool {
        self.0.iter().all(|c| c.is_zero())
    }
    /// True when every component is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }
}

impl<S: Scalar> Index<usize> for Vec3<S> {
    type Output = S;
    #[inline]
    fn index(&self, i: usize) -> &S {
        &self.0[i]
    }
}
impl<S: Scalar> IndexMut<usize> for Vec3<S> {
    #[inline]
    fn index_mut(&mut self, i: usize) -> &mut S {
        &mut self.0[i]
    }
}
impl<S: Scalar> Add for Vec3<S> {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }
}
impl<S: Scalar> Sub for Vec3<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
}
impl<S: Scalar> Neg for Vec3<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2]])
    }
}
impl<S: Scalar> Mul<S> for Vec3<S> {
    type Output = Self;
    #[inline]
    fn mul(self, k: S) -> Self {
        Self([self.0[0] * k, self.0[1] * k, self.0[2] * k])
    }
}
impl<S: Scalar> AddAssign for Vec3<S> {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
impl<S: Scalar> SubAssign for Vec3<S> {
    #[inline]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

/// A 3x3 matrix by rows. Its entries are in the caller's unit; those of a rotation have none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mat3<S: Scalar = f64>(pub [[S; 3]; 3]);

impl<S: Scalar> Mat3<S> {
    /// The zero matrix.
    pub const ZERO: Self = Self([[S::ZERO; 3]; 3]);
    /// The identity.
    pub const IDENTITY: Self =
        Self([[S::ONE, S::ZERO, S::ZERO], [S::ZERO, S::ONE, S::ZERO], [S::ZERO, S::ZERO, S::ONE]]);

    /// `f` of each entry.
    #[inline(always)]
    pub fn each<T: Scalar>(self, f: impl Fn(S) -> T) -> Mat3<T> {
        let [a, b, c] = self.0;
        Mat3([Vec3(a).each(&f).0, Vec3(b).each(&f).0, Vec3(c).each(&f).0])
    }
    /// A constant matrix.
    #[inline]
    pub fn constant(m: Mat3<f64>) -> Self {
        m.each(S::from)
    }
    /// Diagonal matrix.
    #[inline]
    pub fn diagonal(d: Vec3<S>) -> Self {
        let mut m = Self::ZERO;
        for i in 0..3 {
            m.0[i][i] = d[i];
        }
        m
    }
    /// From columns.
    #[inline]
    pub fn from_columns(a: Vec3<S>, b: Vec3<S>, c: Vec3<S>) -> Self {
        Self([[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]])
    }
    /// Cross-product matrix: `skew(a) b = a x b`.
    #[inline]
    pub fn skew(a: Vec3<S>) -> Self {
        let z = S::ZERO;
        Self([[z, -a[2], a[1]], [a[2], z, -a[0]], [-a[1], a[0], z]])
    }
    /// Outer product a b'.
    #[inline]
    pub fn outer(a: Vec3<S>, b: Vec3<S>) -> Self {
        Self([(b * a[0]).0, (b * a[1]).0, (b * a[2]).0])
    }
    /// Transpose.
    #[inline]
    pub fn transpose(self) -> Self {
        let m = self.0;
        Self([[m[0][0], m[1][0], m[2][0]], [m[0][1], m[1][1], m[2][1]], [m[0][2], m[1][2], m[2][2]]])
    }
    /// Column `j`.
    #[inline]
    pub fn column(self, j: usize) -> Vec3<S> {
        Vec3([self.0[0][j], self.0[1][j], self.0[2][j]])
    }
    /// Product with a constant vector; cheaper than with a [`Scalar`] one.
    #[inline]
    pub fn mul_constant<P: Scalar>(&self, v: Vec3<P>) -> Vec3<S>
    where
        S: Meets<P>,
    {
        if const { S::NARROW } {
            return *self * v.met();
        }
        let ([a, b, c], [x, y, z]) = (&self.0, v.0);
        let row = |r: &[S; 3]| r[0] * x + r[1] * y + r[2] * z;
        Vec3([row(a), row(b), row(c)])
    }
    /// Product of the transpose with a vector.
    #[inline]
    pub fn transpose_mul(self, v: Vec3<S>) -> Vec3<S> {
        self.transpose() * v
    }

    /// Rotation by `angle` rad about x.
    #[inline]
    pub fn rotation_x(angle: S) -> Self {
        let (s, c) = angle.sin_cos();
        Self([[S::ONE, S::ZERO, S::ZERO], [S::ZERO, c, -s], [S::ZERO, s, c]])
    }
    /// Rotation by `angle` rad about y.
    #[inline]
    pub fn rotation_y(angle: S) -> Self {
        let (s, c) = angle.sin_cos();
        Self([[c, S::ZERO, s], [S::ZERO, S::ONE, S::ZERO], [-s, S::ZERO, c]])
    }
    /// Rotation by `angle` rad about z.
    #[inline]
    pub fn rotation_z(angle: S) -> Self {
        let (s, c) = angle.sin_cos();
        Self([[c, -s, S::ZERO], [s, c, S::ZERO], [S::ZERO, S::ZERO, S::ONE]])
    }
    /// Rotation by `angle` rad about the unit vector `axis` (Rodrigues).
    #[inline]
    pub fn rotation_about(axis: Vec3<f64>, angle: S) -> Self {
        Self::rotation_by(axis, angle.sin_cos().into())
    }
    /// The same by the sine and cosine of the angle.
    pub fn rotation_by(axis: Vec3<f64>, [s, c]: [S; 2]) -> Self {
        let k = Mat3::skew(Vec3::<S>::constant(axis));
        Self::IDENTITY + k * s + k * k * (S::ONE - c)
    }
    /// R_WB = Rz(yaw) Ry(pitch) Rx(roll), angles in rad. With FLU body axes a
    /// negative pitch is nose up and a positive roll is right wing down.
    pub fn from_roll_pitch_yaw(roll: S, pitch: S, yaw: S) -> Self {
        Self::rotation_z(yaw) * Self::rotation_y(pitch) * Self::rotation_x(roll)
    }
    /// (roll, pitch, yaw) rad of a rotation R_WB = Rz Ry Rx.
    #[inline]
    pub fn roll_pitch_yaw(self) -> Vec3<S> {
        let m = self.0;
        let cos_pitch = (m[0][0] * m[0][0] + m[1][0] * m[1][0]).sqrt();
        Vec3([m[2][1].atan2(m[2][2]), (-m[2][0]).atan2(cos_pitch), m[1][0].atan2(m[0][0])])
    }
}

impl<S: Scalar> Add for Mat3<S> {
    type Output = Self;
    #[inline]
    fn add(mut self, o: Self) -> Self {
        for i in 0..3 {
            for j in 0..3 {
                self.0[i][j] += o.0[i][j];
            }
        }
        self
    }
}
impl<S: Scalar> Sub for Mat3<S> {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        self + o * -S::ONE
    }
}
impl<S: Scalar> Mul<S> for Mat3<S> {
    type Output = Self;
    #[inline]
    fn mul(self, k: S) -> Self {
        let mut m = self;
        for i in 0..3 {
            for j in 0..3 {
                m.0[i][j] *= k;
            }
        }
        m
    }
}
impl<S: Scalar> Mul<Vec3<S>> for Mat3<S> {
    type Output = Vec3<S>;
    #[inline]
    fn mul(self, v: Vec3<S>) -> Vec3<S> {
        let row = |i: usize| {
            (self.0[i][0] * v[0]).plus_product(self.0[i][1], v[1]).plus_product(self.0[i][2], v[2])
        };
        Vec3([row(0), row(1), row(2)])
    }
}
impl<S: Scalar> Mul for Mat3<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self::from_columns(self * o.column(0), self * o.column(1), self * o.column(2))
    }
}

/// A unit quaternion, order w, x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quat<S: Scalar = f64> {
    /// Scalar part, cos(angle/2), dimensionless.
    pub w: S,
    /// Vector part, axis times sin(angle/2), dimensionless.
    pub v: Vec3<S>,
}

impl<S: Scalar> Quat<S> {
    /// No rotation.
    pub const IDENTITY: Self = Self { w: S::ONE, v: Vec3::ZERO };

    /// From (w, x, y, z) of a unit quaternion.
    #[inline]
    pub fn from_wxyz(q: &[S]) -> Self {
        Self { w: q[0], v: Vec3::from_slice(&q[1..4]) }
    }
    /// Writes (w, x, y, z) of this unit quaternion.
    #[inline]
    pub fn store_wxyz(self, q: &mut [S]) {
        q[0] = self.w;
        self.v.store(&mut q[1..4]);
    }
    /// A constant rotation.
    #[inline]
    pub fn constant(q: Quat<f64>) -> Self {
        Self { w: S::from(q.w), v: Vec3::constant(q.v) }
    }
    /// Quaternion of the rotation vector `r` (axis times angle, rad); smooth at zero.
    #[inline]
    pub fn exp(r: Vec3<S>) -> Self {
        let angle2 = r.norm_squared();
        let (w, k) = if angle2.value() < 1e-8 {
            // Taylor series of cos(a/2) and sin(a/2)/a to a^4.
            (
                S::ONE - angle2 * 0.125 + angle2 * angle2 * (1.0 / 384.0),
                S::from(0.5) - angle2 * (1.0 / 48.0) + angle2 * angle2 * (1.0 / 3840.0),
            )
        } else {
            let angle = angle2.sqrt();
            let (s, c) = (angle * 0.5).sin_cos();
            (c, s / angle)
        };
        Self { w, v: r * k }
    }
    /// Rotation vector of this rotation, rad, angle in [0, pi].
    pub fn log(self) -> Vec3<S> {
        let q = if self.w.value() < 0.0 { Self { w: -self.w, v: -self.v } } else { self };
        let sine2 = q.v.norm_squared();
        if sine2.value() < 1e-16 {
            return q.v * 2.0.into();
        }
        let sine = sine2.sqrt();
        q.v * (sine.atan2(q.w) * 2.0 / sine)
    }
    /// From roll, pitch, yaw (rad), see [`Mat3::from_roll_pitch_yaw`].
    pub fn from_roll_pitch_yaw(roll: S, pitch: S, yaw: S) -> Self {
        let half = |a: S, axis: usize| {
            let (s, c) = (a * 0.5).sin_cos();
            let mut v = Vec3::ZERO;
            v[axis] = s;
            Self { w: c, v }
        };
        half(yaw, 2) * half(pitch, 1) * half(roll, 0)
    }
    /// Inverse rotation.
    #[inline]
    pub fn conjugate(self) -> Self {
        Self { w: self.w, v: -self.v }
    }
    /// Scaled to unit length.
    #[inline]
    pub fn normalized(self) -> Self {
        let k = (self.w * self.w + self.v.norm_squared()).sqrt().recip();
        Self { w: self.w * k, v: self.v * k }
    }
    /// Rotation matrix; homogeneous form, exact for unit quaternions.
    #[inline]
    pub fn matrix(self) -> Mat3<S> {
        let (w, [x, y, z]) = (self.w, self.v.0);
        let one = S::ONE;
        Mat3([
            [one - (y * y + z * z) * 2.0, (x * y - w * z) * 2.0, (x * z + w * y) * 2.0],
            [(x * y + w * z) * 2.0, one - (x * x + z * z) * 2.0, (y * z - w * x) * 2.0],
            [(x * z - w * y) * 2.0, (y * z + w * x) * 2.0, one - (x * x + y * y) * 2.0],
        ])
    }
    /// dq/dt = q (0, w)/2 of q_WB for the angular rate `w_WB_B` in rad/s; a rate of a unit quaternion, 1/s.
    #[inline]
    pub fn rate(self, w_b: Vec3<S>) -> Self {
        let half = w_b * S::from(0.5);
        Self { w: -self.v.dot(half), v: half * self.w + self.v.cross(half) }
    }
}

impl<S: Scalar> Mul for Quat<S> {
    type Output = Self;
    #[inline]
    fn mul(self, o: Self) -> Self {
        Self { w: self.w * o.w - self.v.dot(o.v), v: o.v * self.w + self.v * o.w + self.v.cross(o.v) }
    }
}
