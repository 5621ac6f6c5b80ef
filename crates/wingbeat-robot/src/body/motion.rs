//! Motion of every link, outwards from the base.

use super::MAX_LINKS;
use super::dynamics::BaseAcceleration;
use super::tree::{JointKind, LinkNode, Tree};
use arrayvec::ArrayVec;
use wingbeat_math::{Jet, Mat3, Meets, Scalar, Vec3, append_copies};

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
    /// Link origin, m in B.
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
        Self::REST
    }
}

impl<S: Scalar> LinkMotion<S> {
    /// The base at rest.
    pub const REST: Self = Self {
        rotation: Mat3::IDENTITY,
        position: Vec3::ZERO,
        velocity: Vec3::ZERO,
        rate: Vec3::ZERO,
        acceleration: Vec3::ZERO,
        rate_dot: Vec3::ZERO,
    };

    /// The base body moving with `v_B` (m/s) at its origin and `w_B` (rad/s).
    #[inline]
    pub fn base(v_b: Vec3<S>, w_b: Vec3<S>) -> Self {
        Self { velocity: v_b, rate: w_b, ..Self::REST }
    }

    /// The point `r_L` fixed in the link, from the body origin, m in B.
    #[inline]
    pub fn point<P: Scalar>(&self, r_l: Vec3<P>) -> Vec3<S>
    where
        S: Meets<P>,
    {
        self.position + self.rotation.mul_constant(r_l)
    }

    /// Velocity, m/s in B, of the body-frame point `r_B` moving with the link.
    #[inline]
    pub fn velocity_at(&self, r_b: Vec3<S>) -> Vec3<S> {
        self.velocity + self.rate.cross(r_b - self.position)
    }

    /// Acceleration, m/s2 in B, without the base's, of the body-frame point `r_B` moving with the link.
    #[inline]
    pub fn acceleration_at(&self, r_b: Vec3<S>) -> Vec3<S> {
        self.moving_at(r_b).1
    }

    /// Velocity and acceleration, m/s and m/s2 in B, without the base's, of the body-frame point `r_B` moving with the link:
    /// v + w x r, a + w' x r + w x (w x r).
    #[inline]
    pub fn moving_at(&self, r_b: Vec3<S>) -> (Vec3<S>, Vec3<S>) {
        let arm = r_b - self.position;
        let sweep = self.rate.cross(arm);
        (self.velocity + sweep, self.acceleration + self.rate_dot.cross(arm) + self.rate.cross(sweep))
    }

    /// The same motion with the field of acceleration `x` about the body origin added.
    #[inline]
    pub fn accelerated(&self, x: &BaseAcceleration<S>) -> Self {
        let mut motion = *self;
        motion.accelerate(x);
        motion
    }

    /// Adds the field of acceleration `x` about the body origin.
    #[inline]
    pub fn accelerate(&mut self, x: &BaseAcceleration<S>) {
        let mut there = x.origin;
        there.add_cross(&x.angular, &self.position);
        for i in 0..3 {
            self.acceleration[i] += there[i];
            self.rate_dot[i] += x.angular[i];
        }
    }

    /// Places `out` at `origin` in this link, moving with it; not yet turned.
    #[inline]
    fn carry<P: Scalar>(&self, origin: Vec3<P>, out: &mut Self)
    where
        S: Meets<P>,
    {
        if origin.is_zero() {
            (out.position, out.velocity, out.acceleration) =
                (self.position, self.velocity, self.acceleration);
            return;
        }
        let arm = self.rotation.mul_constant(origin);
        let sweep = self.rate.cross(arm);
        out.position = self.position + arm;
        out.velocity = self.velocity + sweep;
        out.acceleration = self.acceleration + self.rate_dot.cross(arm) + self.rate.cross(sweep);
    }

    /// Moves `out`, carried by this link, as its joint does, which turns it by the angle of the sine and cosine `turn`.
    #[inline]
    fn articulate<P: Scalar>(&self, node: &LinkNode<P>, joint: &Jet<S>, turn: [S; 2], out: &mut Self)
    where
        S: Meets<P>,
    {
        let mounted;
        let frame = match &node.orientation {
            None => &self.rotation,
            Some(fixed) => {
                let column = |j| self.rotation.mul_constant(fixed.column(j));
                mounted = Mat3::from_columns(column(0), column(1), column(2));
                &mounted
            }
        };
        let axis = node.axis.direction(frame);
        match node.kind {
            JointKind::Revolute => {
                let spin = axis * joint.d;
                out.rotation = node.axis.turn(frame, turn);
                out.rate = self.rate + spin;
                out.rate_dot = self.rate_dot + axis * joint.dd + self.rate.cross(spin);
            }
            JointKind::Prismatic => {
                let (arm, slide) = (axis * joint.x, axis * joint.d);
                let sweep = self.rate.cross(arm);
                out.rotation = *frame;
                out.rate = self.rate;
                out.rate_dot = self.rate_dot;
                out.position += arm;
                out.velocity += sweep + slide;
                out.acceleration +=
                    axis * joint.dd + self.rate_dot.cross(arm) + self.rate.cross(sweep + slide + slide);
            }
        }
    }
}

impl<P: Scalar> Tree<P> {
    /// Equation: body.kinematics
    /// `v = v_p + w_p x r, a = a_p + w_p' x r + w_p x (w_p x r), w = w_p + e q', w' = w_p' + e q'' + w_p x e q'`
    /// Source: rigid-body kinematics; Featherstone 2008, section 5.3.
    /// Test: `bias_acceleration_of_a_moving_base_matches_central_differences`.
    ///
    /// Motion of every link from the joint angles with their rates and accelerations, the inertial velocity `v_b` (m/s) of the
    /// body origin and the angular rate `w_b`, both in B: v = v_p + w_p x r, a = a_p + w_p' x r + w_p x (w_p x r), w = w_p + e
    /// q', w' = w_p' + e q'' + w_p x e q' (Featherstone 2008, section 5.3, at the joint origins); a prismatic joint adds e q to
    /// r, e q' to v and e q'' + 2 w_p x e q' to a instead.
    ///
    /// `joints` and `out` hold one entry per link.
    #[inline(never)]
    pub fn motions<S: Scalar + Meets<P>>(
        &self,
        joints: &[Jet<S>],
        v_b: Vec3<S>,
        w_b: Vec3<S>,
        out: &mut [LinkMotion<S>],
    ) {
        // Sines and cosines first: each of them waits for all sums that were begun before.
        let mut turns = ArrayVec::<[S; 2], MAX_LINKS>::new();
        append_copies(&mut turns, [S::ZERO; 2], self.nodes.len());
        for (i, node) in self.nodes.iter().enumerate() {
            if node.kind == JointKind::Revolute {
                turns[i] = joints[i].x.sin_cos().into();
            }
        }
        let base = LinkMotion::base(v_b, w_b);
        for (i, node) in self.nodes.iter().enumerate() {
            let (done, rest) = out.split_at_mut(i);
            let parent = node.parent.map_or(&base, |p| &done[p]);
            parent.carry(node.origin, &mut rest[0]);
            parent.articulate(node, &joints[i], turns[i], &mut rest[0]);
        }
    }
}
