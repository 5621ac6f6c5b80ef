//! Motion of every link, outwards from the base.

use super::joint::Axis;
use super::tree::Tree;
use crate::math::{Jet, Mat3, Scalar, Vec3};

/// Motion of one link. Everything is resolved in the body frame B; positions
/// are from the body origin; rates are inertial (relative to W). SI units.
///
/// The accelerations hold every velocity term and the joints' accelerations, but
/// not the base's own: with the acceleration `a0` of the body origin and `w_dot`
/// of the body, a point at `r` gains `a0 + w_dot x r` and the link `w_dot`.
#[derive(Clone, Copy, Debug)]
pub struct LinkMotion<S: Scalar = f64> {
    /// R_BL: turns link coordinates into body coordinates.
    pub rotation: Mat3<S>,
    /// Link origin.
    pub position: Vec3<S>,
    /// Velocity of the link origin, m/s.
    pub velocity: Vec3<S>,
    /// Angular rate, rad/s.
    pub rate: Vec3<S>,
    /// Acceleration of the link origin without the base's, m/s2.
    pub acceleration: Vec3<S>,
    /// Angular acceleration without the base's, rad/s2.
    pub rate_dot: Vec3<S>,
}

impl<S: Scalar> Default for LinkMotion<S> {
    fn default() -> Self {
        Self::base(Vec3::ZERO, Vec3::ZERO)
    }
}

impl<S: Scalar> LinkMotion<S> {
    /// The base body moving with `v_B` at its origin and `w_B`.
    #[inline]
    pub fn base(v_b: Vec3<S>, w_b: Vec3<S>) -> Self {
        Self {
            rotation: Mat3::IDENTITY,
            position: Vec3::ZERO,
            velocity: v_b,
            rate: w_b,
            acceleration: Vec3::ZERO,
            rate_dot: Vec3::ZERO,
        }
    }

    /// The point `r_L` fixed in the link, from the body origin.
    #[inline]
    pub fn point(&self, r_l: Vec3<f64>) -> Vec3<S> {
        self.position + self.rotation.mul_constant(r_l)
    }

    /// Velocity of the body-frame point `r_B` moving with the link.
    #[inline]
    pub fn velocity_at(&self, r_b: Vec3<S>) -> Vec3<S> {
        self.velocity + self.rate.cross(r_b - self.position)
    }

    /// Acceleration, without the base's, of the body-frame point `r_B` moving with the link.
    #[inline]
    pub fn acceleration_at(&self, r_b: Vec3<S>) -> Vec3<S> {
        self.acceleration + self.swept(r_b - self.position)
    }

    /// Angular acceleration and centripetal terms at the arm `r`: alpha x r + w x (w x r).
    #[inline]
    fn swept(&self, r: Vec3<S>) -> Vec3<S> {
        self.rate_dot.cross(r) + self.rate.cross(self.rate.cross(r))
    }

    /// The frame fixed in this link at `origin`, turned by `orientation` (None: not turned).
    #[inline]
    fn mount(&self, origin: Vec3<f64>, orientation: Option<&Mat3>) -> Self {
        let mut mount = *self;
        if origin != Vec3::ZERO {
            let arm = self.rotation.mul_constant(origin);
            let sweep = self.rate.cross(arm);
            mount.position += arm;
            mount.velocity += sweep;
            mount.acceleration += self.rate_dot.cross(arm) + self.rate.cross(sweep);
        }
        if let Some(fixed) = orientation {
            let column = |j| self.rotation.mul_constant(fixed.column(j));
            mount.rotation = Mat3::from_columns(column(0), column(1), column(2));
        }
        mount
    }

    /// [`LinkMotion::mount`] on the base, where rotation and accelerations are constant.
    #[inline]
    fn mount_on_base(v_b: Vec3<S>, w_b: Vec3<S>, origin: Vec3<f64>, orientation: Option<&Mat3>) -> Self {
        let arm = Vec3::constant(origin);
        let sweep = w_b.cross(arm);
        Self {
            rotation: orientation.map_or(Mat3::IDENTITY, |fixed| Mat3::constant(*fixed)),
            position: arm,
            velocity: v_b + sweep,
            rate: w_b,
            acceleration: w_b.cross(sweep),
            rate_dot: Vec3::ZERO,
        }
    }

    /// This frame after turning about `axis` as the joint does.
    #[inline]
    fn turned(self, axis: &Axis, joint: &Jet<S>) -> Self {
        let hinge = axis.direction(&self.rotation);
        let spin = hinge * joint.d;
        Self {
            rotation: axis.turn(&self.rotation, joint.x),
            rate: self.rate + spin,
            rate_dot: self.rate_dot + hinge * joint.dd + self.rate.cross(spin),
            ..self
        }
    }
}

impl Tree {
    /// Equation: body.kinematics
    ///
    /// Motion of every link from the joint angles with their rates and
    /// accelerations, the inertial velocity `v_b` of the body origin and the
    /// angular rate `w_b`, both in B: v = v_p + w_p x r,
    /// a = a_p + w_p' x r + w_p x (w_p x r), w = w_p + e q',
    /// w' = w_p' + e q'' + w_p x e q' (Featherstone 2008, section 5.3, at the joint origins).
    ///
    /// `joints` and `out` hold one entry per link.
    pub fn motions<S: Scalar>(
        &self,
        joints: &[Jet<S>],
        v_b: Vec3<S>,
        w_b: Vec3<S>,
        out: &mut [LinkMotion<S>],
    ) {
        for (i, node) in self.nodes.iter().enumerate() {
            let orientation = node.orientation.as_ref();
            let mount = match node.parent {
                None => LinkMotion::mount_on_base(v_b, w_b, node.origin, orientation),
                Some(p) => out[p].mount(node.origin, orientation),
            };
            out[i] = mount.turned(&node.axis, &joints[i]);
        }
    }
}
