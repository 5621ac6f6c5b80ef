//! The chain of joints and its forward kinematics.

use crate::Error;
use crate::math::{Mat3, Scalar, Vec3};
use crate::rig::Pose;

/// Largest number of joints; kinematics live on the stack.
pub const MAX_JOINTS: usize = 8;

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis, rad.
    Revolute,
    /// Slides along its axis, m.
    Prismatic,
}

/// One moving joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Turns or slides.
    pub kind: JointKind,
    /// Joint frame J in the link before it at zero position, X_PJ.
    pub mount: Pose,
    /// Unit axis in J.
    pub axis: Vec3,
    /// Lowest position, rad or m; -infinity when continuous.
    pub low: f64,
    /// Highest position, rad or m.
    pub high: f64,
    /// Greatest torque, N m, or force, N; infinity when not stated.
    pub effort: f64,
}

impl Joint {
    /// True when the joint turns without end.
    pub fn continuous(&self) -> bool {
        self.kind == JointKind::Revolute && self.low == f64::NEG_INFINITY && self.high == f64::INFINITY
    }
    /// The moved frame in the link before, X_PJ(q).
    #[inline]
    fn place<S: Scalar>(&self, q: S) -> Pose<S> {
        let motion = match self.kind {
            JointKind::Revolute => Pose { rotation: Mat3::rotation_about(self.axis, q), origin: Vec3::ZERO },
            JointKind::Prismatic => Pose { rotation: Mat3::IDENTITY, origin: Vec3::constant(self.axis) * q },
        };
        Pose::constant(&self.mount) * motion
    }
}

/// The body that a joint carries, in that joint's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkBody {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: Vec3,
    /// Inertia about the centre of mass, kg m2.
    pub inertia: Mat3,
    /// Radius of the capsule that holds the link, m.
    pub radius: f64,
}

/// A serial arm on a fixed base. `q` holds one position per joint, rad or m.
#[derive(Clone, Debug, PartialEq)]
pub struct SerialArm {
    /// Name.
    pub name: String,
    /// Joints from base to tool.
    pub joints: Vec<Joint>,
    /// The body of the base, in the base frame.
    pub base: LinkBody,
    /// The body that each joint carries.
    pub links: Vec<LinkBody>,
    /// Tool frame in the last joint's frame.
    pub tool: Pose,
}

impl SerialArm {
    /// Checks the parts and makes the arm.
    ///
    /// # Errors
    /// [`Error::Invalid`] for no or too many joints, an axis that is not a
    /// unit vector, limits in the wrong order, or a negative mass.
    pub fn new(
        name: String,
        base: LinkBody,
        parts: Vec<(Joint, LinkBody)>,
        tool: Pose,
    ) -> Result<Self, Error> {
        if parts.is_empty() || parts.len() > MAX_JOINTS {
            return Err(Error::invalid("joints", parts.len(), format!("1 to {MAX_JOINTS} moving joints")));
        }
        for (joint, link) in &parts {
            let fail = |key: &str, value: f64, allowed: &str| {
                Err(Error::invalid(format!("joints.{}.{key}", joint.name), value, allowed))
            };
            if !((joint.axis.norm() - 1.0).abs() < 1e-9) {
                return fail("axis", joint.axis.norm(), "a vector of length 1");
            }
            if !(joint.low < joint.high) {
                return fail("low", joint.low, &format!("less than high = {}", joint.high));
            }
            if !(link.mass >= 0.0 && link.mass.is_finite()) {
                return fail("link.mass_kg", link.mass, "zero or more");
            }
            if !(joint.mount.origin.is_finite() && link.com.is_finite()) {
                return fail("xyz_m", f64::NAN, "finite numbers");
            }
        }
        let (joints, links) = parts.into_iter().unzip();
        Ok(Self { name, joints, base, links, tool })
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Joint frames in the base frame, then the tool frame at index `dof()`.
    ///
    /// Product of exponentials about each joint's own frame (Lynch & Park,
    /// Modern Robotics, 4.1.2).
    ///
    /// Equation: rig.forward_kinematics
    pub fn frames<S: Scalar>(&self, q: &[S]) -> [Pose<S>; MAX_JOINTS + 1] {
        let mut frames = [Pose::IDENTITY; MAX_JOINTS + 1];
        let mut at = Pose::IDENTITY;
        for (i, joint) in self.joints.iter().enumerate() {
            at = at * joint.place(q[i]);
            frames[i] = at;
        }
        frames[self.dof()] = at * Pose::constant(&self.tool);
        frames
    }

    /// Tool frame in the base frame.
    pub fn tool_pose<S: Scalar>(&self, q: &[S]) -> Pose<S> {
        self.frames(q)[self.dof()]
    }

    /// The first joint whose position lies more than `slack` outside its
    /// limits: (joint, rad or m beyond the limit).
    pub fn beyond_limits(&self, q: &[f64], slack: f64) -> Option<(usize, f64)> {
        self.joints
            .iter()
            .zip(q)
            .map(|(joint, &x)| (joint.low - x).max(x - joint.high))
            .enumerate()
            .find(|&(_, beyond)| beyond > slack)
    }
}

#[cfg(test)]
mod tests {
    use crate::rig::arm::ArmConfig;

    #[test]
    fn zero_pose_stands_upright() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let tool = arm.tool_pose(&[0.0; 6]);
        assert!((tool.origin[2] - 1.17662).abs() < 6e-6, "{:?}", tool.origin);
    }

    #[test]
    fn limits_are_seen_with_slack() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let q = [9.0, 0.0, -2.575, 0.0, 0.0, 0.0];
        let (joint, beyond) = arm.beyond_limits(&q, 0.0).unwrap();
        assert!(joint == 2 && (beyond - 0.005).abs() < 1e-12);
        assert!(arm.beyond_limits(&q, 0.01).is_none());
    }
}
