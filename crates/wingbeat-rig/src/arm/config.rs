//! Arms as data.

use super::{ArmJointKind, Joint, LimitProfile, LinkBody, SerialArm, ToolLimits};
use crate::Pose;
use serde::{Deserialize, Serialize};
use wingbeat_math::Error;
use wingbeat_math::range::{Range, ranges};
use wingbeat_math::{Mat3, Vec3};

/// An arm as written in a TOML file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmConfig {
    /// Name.
    pub name: String,
    /// The body that does not move.
    #[serde(default)]
    pub base: LinkConfig,
    /// Joints from base to tool.
    pub joints: Vec<JointConfig>,
    /// Tool frame on the last link.
    #[serde(default)]
    pub tool: ToolConfig,
    /// Named limit profiles.
    #[serde(default)]
    pub profiles: Vec<ProfileConfig>,
}

/// A placement in the frame before.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolConfig {
    /// Origin, m.
    #[serde(default)]
    pub xyz_m: [f64; 3],
    /// Roll, pitch, yaw, rad (R = Rz Ry Rx).
    #[serde(default)]
    pub rpy_rad: [f64; 3],
}

/// One joint with the link that it carries.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointConfig {
    /// Name.
    pub name: String,
    /// Origin of the joint frame in the link before, m.
    #[serde(default)]
    pub xyz_m: [f64; 3],
    /// Its roll, pitch, yaw, rad.
    #[serde(default)]
    pub rpy_rad: [f64; 3],
    /// Unit axis in the joint frame.
    #[serde(default = "along_z")]
    pub axis: [f64; 3],
    /// True for a joint that slides; its limits are then in m.
    #[serde(default)]
    pub prismatic: bool,
    /// Lowest position, rad; without both limits the joint turns without end.
    #[serde(default)]
    pub low_rad: Option<f64>,
    /// Highest position, rad.
    #[serde(default)]
    pub high_rad: Option<f64>,
    /// Greatest torque, N m.
    #[serde(default)]
    pub effort_n_m: Option<f64>,
    /// The link carried.
    #[serde(default)]
    pub link: LinkConfig,
}

fn along_z() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// Mass and size of a link.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkConfig {
    /// Mass, kg.
    #[serde(default)]
    pub mass_kg: f64,
    /// Centre of mass, m.
    #[serde(default)]
    pub com_m: [f64; 3],
    /// Inertia about it: xx, yy, zz, xy, xz, yz, kg m2.
    #[serde(default)]
    pub inertia_kg_m2: [f64; 6],
    /// Capsule radius, m.
    #[serde(default)]
    pub radius_m: f64,
}

/// Limits of one profile, one number per joint; absent means not limited.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(transform = wingbeat_math::range::put(Self::RANGES))]
#[serde(deny_unknown_fields)]
pub struct ProfileConfig {
    /// Name by which it is chosen and printed.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// Joint speed, rad/s.
    pub velocity_rad_s: Vec<f64>,
    /// Joint acceleration, rad/s2.
    #[serde(default)]
    pub acceleration_rad_s2: Option<Vec<f64>>,
    /// Joint jerk, rad/s3.
    #[serde(default)]
    pub jerk_rad_s3: Option<Vec<f64>>,
    /// Tool speed, m/s.
    #[serde(default)]
    pub tool_speed_m_s: Option<f64>,
    /// Tool angular rate, rad/s.
    #[serde(default)]
    pub tool_rate_rad_s: Option<f64>,
    /// Tool acceleration, m/s2.
    #[serde(default)]
    pub tool_acceleration_m_s2: Option<f64>,
}

impl ArmConfig {
    /// The Kinova Gen3 with six joints.
    pub fn kinova_gen3() -> Self {
        let text = include_str!("../../documents/kinova_gen3_6dof.toml");
        toml::from_str(text).expect("the embedded arm is valid; a test reads it")
    }

    /// The arm.
    ///
    /// # Errors
    /// What [`SerialArm::new`] refuses, or profiles that do not hold one positive number per joint.
    pub fn build(&self) -> Result<SerialArm, Error> {
        self.check_profiles()?;
        let parts = self.joints.iter().map(|j| (j.joint(), j.link.body())).collect();
        SerialArm::new(self.name.clone(), self.base.body(), parts, self.tool.pose())
    }

    /// The limit profile called `name`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown name (listing the known ones).
    pub fn profile(&self, name: &str) -> Result<LimitProfile, Error> {
        let Some(profile) = self.profiles.iter().find(|p| p.name == name) else {
            let known: Vec<_> = self.profiles.iter().map(|p| p.name.as_str()).collect();
            return Err(Error::invalid("profile", name, format!("one of {}", known.join(", "))));
        };
        Ok(profile.build(self.joints.len()))
    }

    fn check_profiles(&self) -> Result<(), Error> {
        let mut profiles = self.profiles.iter().enumerate();
        let check = |p: &ProfileConfig| p.check(self.joints.len());
        profiles.try_for_each(|(i, p)| check(p).map_err(|e| e.within(&format!("profiles[{i}]"))))
    }
}

impl JointConfig {
    fn joint(&self) -> Joint {
        Joint {
            name: self.name.clone(),
            kind: if self.prismatic { ArmJointKind::Prismatic } else { ArmJointKind::Revolute },
            mount: Pose::from_xyz_rpy(self.xyz_m, self.rpy_rad),
            axis: Vec3(self.axis),
            low: self.low_rad.unwrap_or(f64::NEG_INFINITY),
            high: self.high_rad.unwrap_or(f64::INFINITY),
            effort: self.effort_n_m.unwrap_or(f64::INFINITY),
        }
    }
}

impl ToolConfig {
    /// The placement.
    pub fn pose(&self) -> Pose {
        Pose::from_xyz_rpy(self.xyz_m, self.rpy_rad)
    }
}

impl LinkConfig {
    /// The body.
    pub fn body(&self) -> LinkBody {
        let [xx, yy, zz, xy, xz, yz] = self.inertia_kg_m2;
        LinkBody {
            mass: self.mass_kg,
            com: Vec3(self.com_m),
            inertia: Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
            radius: self.radius_m,
        }
    }
}

ranges!(ProfileConfig {
    velocity_rad_s: Range::POSITIVE,
    acceleration_rad_s2: Range::POSITIVE,
    jerk_rad_s3: Range::POSITIVE,
    tool_speed_m_s: Range::POSITIVE,
    tool_rate_rad_s: Range::POSITIVE,
    tool_acceleration_m_s2: Range::POSITIVE,
});

impl ProfileConfig {
    fn check(&self, dof: usize) -> Result<(), Error> {
        let lists = [
            ("velocity_rad_s", Some(&self.velocity_rad_s)),
            ("acceleration_rad_s2", self.acceleration_rad_s2.as_ref()),
            ("jerk_rad_s3", self.jerk_rad_s3.as_ref()),
        ];
        for (key, list) in lists.iter().filter_map(|(key, list)| Some((key, (*list)?))) {
            if list.len() != dof {
                let given = format!("{} numbers", list.len());
                return Err(Error::invalid(*key, given, format!("{dof} numbers, one per joint")));
            }
        }
        self.in_range()
    }

    fn build(&self, dof: usize) -> LimitProfile {
        let list = |given: Option<&Vec<f64>>| given.cloned().unwrap_or_else(|| vec![f64::INFINITY; dof]);
        LimitProfile {
            name: self.name.clone(),
            source: self.source.clone(),
            velocity: list(Some(&self.velocity_rad_s)),
            acceleration: list(self.acceleration_rad_s2.as_ref()),
            jerk: list(self.jerk_rad_s3.as_ref()),
            tool: ToolLimits {
                speed: self.tool_speed_m_s.unwrap_or(f64::INFINITY),
                rate: self.tool_rate_rad_s.unwrap_or(f64::INFINITY),
                acceleration: self.tool_acceleration_m_s2.unwrap_or(f64::INFINITY),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_profile_of_the_embedded_arm_builds() {
        let config = ArmConfig::kinova_gen3();
        assert_eq!(config.build().unwrap().dof(), 6);
        for p in &config.profiles {
            config.profile(&p.name).unwrap();
        }
        let message = config.profile("fast").unwrap_err().to_string();
        assert!(message.contains("moveit-hard"), "{message}");
    }
}
