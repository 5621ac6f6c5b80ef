//! The chain of joints and its forward kinematics.

use crate::Pose;
use wingbeat_math::Error;
use wingbeat_math::require;
use wingbeat_math::{Mat3, Scalar, Vec3};
use wingbeat_robot::body::principal_moments;

/// Largest number of joints; kinematics live on the stack.
pub const MAX_JOINTS: usize = 8;

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArmJointKind {
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
    pub kind: ArmJointKind,
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
        self.kind == ArmJointKind::Revolute && self.low == f64::NEG_INFINITY && self.high == f64::INFINITY
    }
    fn check(&self) -> Result<(), Error> {
        if !((self.axis.norm() - 1.0).abs() < 1e-9) {
            let allowed = format!("of length 1; this is of length {}", self.axis.norm());
            return Err(Error::invalid("axis", format!("{:?}", self.axis.0), allowed));
        }
        if !(self.low < self.high) {
            let error = Error::invalid("low_rad", self.low, format!("less than high_rad, {}", self.high));
            return Err(error.against(["high_rad"]));
        }
        if !(self.effort > 0.0) {
            return Err(Error::invalid("effort_n_m", self.effort, "a number above 0"));
        }
        require::finite("xyz_m", &self.mount.origin.0)
    }
    /// The moved frame in the link before, X_PJ(q).
    #[inline]
    fn place<S: Scalar>(&self, q: S) -> Pose<S> {
        let motion = match self.kind {
            ArmJointKind::Revolute => {
                Pose { rotation: Mat3::rotation_about(self.axis, q), origin: Vec3::ZERO }
            }
            ArmJointKind::Prismatic => {
                Pose { rotation: Mat3::IDENTITY, origin: Vec3::constant(self.axis) * q }
            }
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

impl LinkBody {
    /// Refuses what no body is.
    ///
    /// # Errors
    /// [`Error::Invalid`] for a negative mass or radius, or an inertia that no distribution of mass has.
    pub fn check(&self) -> Result<(), Error> {
        require::not_negative("mass_kg", self.mass)?;
        require::not_negative("radius_m", self.radius)?;
        require::finite("com_m", &self.com.0)?;
        let Mat3([[xx, xy, xz], [_, yy, yz], [_, _, zz]]) = self.inertia;
        let item = |i: usize| format!("inertia_kg_m2[{i}]");
        require::all("inertia_kg_m2", &[xx, yy, zz], require::not_negative)?;
        for (i, product, [j, k]) in [(3, xy, [0, 1]), (4, xz, [0, 2]), (5, yz, [1, 2])] {
            let largest = ([xx, yy, zz][j] * [xx, yy, zz][k]).sqrt();
            if !(product.abs() <= largest * (1.0 + 1e-9)) {
                let allowed = format!("at most {largest} in magnitude: no body has more");
                return Err(Error::invalid(item(i), product, allowed).against([j, k].map(item)));
            }
        }
        principal_moments(self.inertia).map(drop)
    }
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
        base.check().map_err(|e| e.within("base"))?;
        for (i, (joint, link)) in parts.iter().enumerate() {
            joint.check().map_err(|e| e.within(&format!("joints[{i}]")))?;
            link.check().map_err(|e| e.within(&format!("joints[{i}].link")))?;
        }
        if !tool.origin.is_finite() {
            return Err(Error::invalid("tool.xyz_m", format!("{:?}", tool.origin.0), "finite numbers"));
        }
        let (joints, links) = parts.into_iter().unzip();
        Ok(Self { name, joints, base, links, tool })
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Joint frames in the base frame (places in m) at the joint positions `q` (rad), then the tool frame at index `dof()`.
    ///
    /// Product of exponentials about each joint's own frame (Lynch & Park,
    /// Modern Robotics, 4.1.2).
    ///
    /// Equation: rig.forward_kinematics
    /// `X = prod mount_i motion_i(q_i) tool`
    /// Source: Lynch & Park, Modern Robotics, 4.1.
    /// Test: `zero_pose_stands_upright`.
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

    /// Tool frame in the base frame (its place in m) at the joint positions `q` (rad).
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
    use super::LinkBody;
    use crate::arm::ArmConfig;
    use wingbeat_math::Mat3;

    #[test]
    fn zero_pose_stands_upright() {
        let arm = ArmConfig::kinova_gen3().build().unwrap();
        let tool = arm.tool_pose(&[0.0; 6]);
        assert!((tool.origin[2] - 1.17662).abs() < 6e-6, "{:?}", tool.origin);
    }

    #[test]
    fn a_link_has_an_inertia_that_some_body_has() {
        let link = |moments: [f64; 3]| {
            let inertia =
                Mat3(std::array::from_fn(|i| std::array::from_fn(|j| if i == j { moments[i] } else { 0.0 })));
            LinkBody { mass: 1.0, inertia, ..LinkBody::default() }.check()
        };
        assert!(link([1.0, 0.6, 0.5]).is_ok() && link([1.0, 0.5, 0.5]).is_ok() && link([0.0; 3]).is_ok());
        for moments in [[1.0, 0.0, 0.0], [1.0, 0.4, 0.5], [-1.0, 1.0, 1.0]] {
            assert!(link(moments).unwrap_err().to_string().contains("inertia_kg_m2"), "{moments:?}");
        }
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
