//! The motion of a frame carried by the arm.

use super::Pose;
use wingbeat_math::{Jet, Mat3, Scalar, Vec3};

/// Placement, velocity and acceleration of a frame B in the base frame W.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// X_WB.
    pub pose: Pose,
    /// v_WB_W, m/s.
    pub velocity: Vec3,
    /// a_WB_W, m/s2.
    pub acceleration: Vec3,
    /// w_WB_W, rad/s.
    pub rate: Vec3,
    /// Its derivative, rad/s2.
    pub angular_acceleration: Vec3,
}

impl FrameMotion {
    /// Reads rates out of a placement along time: dR R' = skew(w) and the
    /// antisymmetric part of d2R R' is skew(dw/dt).
    pub fn from_jets(x: &Pose<Jet>) -> Self {
        let part = |f: fn(Jet) -> f64| x.rotation.each(f);
        let (r, dr, ddr) = (part(|j| j.x), part(|j| j.d), part(|j| j.dd));
        let vee = |m: Mat3| {
            let m = m.0;
            Vec3([m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]) * 0.5
        };
        let vector = |f: fn(Jet) -> f64| x.origin.each(f);
        Self {
            pose: Pose { rotation: r, origin: vector(|j| j.x) },
            velocity: vector(|j| j.d),
            acceleration: vector(|j| j.dd),
            rate: vee(dr * r.transpose()),
            angular_acceleration: vee(ddr * r.transpose()),
        }
    }

    /// Acceleration of the point `p_B` fixed in the frame, m/s2.
    pub fn point_acceleration<S: Scalar>(&self, p: Vec3<S>) -> Vec3<S> {
        let [rate, turning] = [self.rate, self.angular_acceleration].map(Vec3::<S>::constant);
        let lever = Mat3::<S>::constant(self.pose.rotation) * p;
        Vec3::constant(self.acceleration) + turning.cross(lever) + rate.cross(rate.cross(lever))
    }

    /// Velocity of the point `p_B` fixed in the frame, m/s.
    pub fn point_velocity<S: Scalar>(&self, p: Vec3<S>) -> Vec3<S> {
        let lever = Mat3::<S>::constant(self.pose.rotation) * p;
        Vec3::constant(self.velocity) + Vec3::<S>::constant(self.rate).cross(lever)
    }

    /// Rate of angular momentum about its own centre of mass of a rigid body
    /// with the inertia `i_B`, N m in W (Euler's equation).
    pub fn spin_rate(&self, inertia: Mat3) -> Vec3 {
        let r = self.pose.rotation;
        let i_w = r * inertia * r.transpose();
        i_w * self.angular_acceleration + self.rate.cross(i_w * self.rate)
    }
}
