//! Serial arms from URDF files.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use wingbeat::rig::arm::{ArmConfig, JointConfig, LinkConfig, ProfileConfig, ToolConfig};
use wingbeat::rig::{Pose, rotation_vector};
use wingbeat::scenario::text_of;

use crate::{Error, text};

pub mod tree;

use tree::{JointType, UrdfJoint, UrdfLink, UrdfRobot};

/// Reads the chain of moving joints from the root to `tip` (the only leaf when
/// absent). Fixed joints are folded into their neighbours; velocity limits
/// become the limit profile `urdf`.
///
/// # Errors
/// What is wrong with the file, or with the chain: no root, several leaves
/// (listed), a loop, a joint of a kind that an arm cannot have.
pub fn read_urdf(path: &Path, tip: Option<&str>) -> Result<ArmConfig, Error> {
    parse_urdf(&text(path)?, tip).map_err(|what| Error::format(path, what))
}

/// The same from the text of a file.
///
/// # Errors
/// A message without the file's name.
pub fn parse_urdf(text: &str, tip: Option<&str>) -> Result<ArmConfig, String> {
    if !text.contains("<robot") {
        return Err("no <robot> element: not a URDF file (expand xacro files first)".into());
    }
    let robot = UrdfRobot::read(text).map_err(|error| format!("not a URDF file: {error}"))?;
    let tip = tip_of(&robot, tip)?;
    let chain = chain_to(&robot, tip)?;
    assemble(&robot, &chain)
}

/// The arm of a file whose name ends in `.urdf` as TOML, for a rig that names it; the part is the
/// tip. `None` for other files.
pub fn urdf_as_toml(path: &Path, tip: Option<&str>) -> Option<Result<String, String>> {
    if !path.extension().is_some_and(|end| end.eq_ignore_ascii_case("urdf")) {
        return None;
    }
    let text = text_of(path).map_err(|error| error.to_string());
    let arm = text.and_then(|text| parse_urdf(&text, tip)).and_then(|arm| limited(&arm).map(|()| arm));
    Some(arm.and_then(|arm| toml::to_string(&arm).map_err(|error| error.to_string())))
}

/// Refuses a joint without limit of speed: a rig plans motion within those.
fn limited(arm: &ArmConfig) -> Result<(), String> {
    let speeds = arm.profiles.iter().flat_map(|profile| arm.joints.iter().zip(&profile.velocity_rad_s));
    match speeds.into_iter().find(|(_, speed)| !speed.is_finite()) {
        None => Ok(()),
        Some((joint, _)) => Err(format!(
            "joint {}: <limit velocity=\"...\"> is missing or not above 0: an arm's motion is planned within it",
            joint.name
        )),
    }
}

/// Most leaves that a message lists.
const LISTED: usize = 20;

fn tip_of<'a>(robot: &'a UrdfRobot, wanted: Option<&'a str>) -> Result<&'a str, String> {
    let parents: HashSet<&str> = robot.joints.iter().map(|joint| joint.parent.as_str()).collect();
    let names = robot.links.iter().map(|link| link.name.as_str());
    let leaves: Vec<&str> = names.filter(|name| !parents.contains(name)).collect();
    let more = if leaves.len() > LISTED { ", ..." } else { "" };
    let listed = leaves.iter().copied().take(LISTED).collect::<Vec<_>>().join(", ") + more;
    match (wanted, leaves.as_slice()) {
        (Some(name), _) if robot.links.iter().any(|link| link.name == name) => Ok(name),
        (Some(name), _) => Err(format!("no link {name}; leaves are {listed}")),
        (None, [leaf]) => Ok(leaf),
        (None, _) => Err(format!("{} leaves; name the tool's link: {listed}", leaves.len())),
    }
}

/// The joints from the root to `tip`.
fn chain_to<'a>(robot: &'a UrdfRobot, tip: &str) -> Result<Vec<&'a UrdfJoint>, String> {
    let mut above: HashMap<&str, &UrdfJoint> = HashMap::new();
    for joint in &robot.joints {
        above.entry(&joint.child).or_insert(joint);
    }
    let mut chain = Vec::new();
    let mut link = tip;
    while let Some(joint) = above.get(link) {
        if chain.len() > robot.joints.len() {
            return Err(format!("the joints above {tip} form a loop"));
        }
        chain.push(*joint);
        link = &joint.parent;
    }
    chain.reverse();
    Ok(chain)
}

fn assemble(robot: &UrdfRobot, chain: &[&UrdfJoint]) -> Result<ArmConfig, String> {
    let mut joints: Vec<JointConfig> = Vec::new();
    let mut velocity = Vec::new();
    // Placement of the joint at hand in the last moving joint's frame.
    let mut at = Pose::IDENTITY;
    for joint in chain {
        let o = &joint.origin;
        at = at * Pose::from_xyz_rpy(o.xyz, o.rpy);
        if joint.joint_type == JointType::Fixed {
            continue;
        }
        joints.push(moving(joint, &at, robot)?);
        velocity.push(if joint.velocity > 0.0 { joint.velocity } else { f64::INFINITY });
        at = Pose::IDENTITY;
    }
    let base = chain.first().and_then(|j| robot.links.iter().find(|l| l.name == j.parent));
    let profile = ProfileConfig {
        name: "urdf".into(),
        source: "velocity limits of the URDF file".into(),
        velocity_rad_s: velocity,
        acceleration_rad_s2: None,
        jerk_rad_s3: None,
        tool_speed_m_s: None,
        tool_rate_rad_s: None,
        tool_acceleration_m_s2: None,
    };
    Ok(ArmConfig {
        name: robot.name.clone(),
        base: base.map_or_else(LinkConfig::default, body),
        joints,
        tool: ToolConfig { xyz_m: at.origin.0, rpy_rad: at.rotation.roll_pitch_yaw().0 },
        profiles: vec![profile],
    })
}

fn moving(joint: &UrdfJoint, at: &Pose, robot: &UrdfRobot) -> Result<JointConfig, String> {
    let limited = match joint.joint_type {
        JointType::Revolute | JointType::Prismatic => true,
        JointType::Continuous => false,
        _ => {
            return Err(format!(
                "joint {}: an arm has revolute, continuous, prismatic or fixed joints",
                joint.name
            ));
        }
    };
    if joint.mimics {
        return Err(format!("joint {} mimics another; an arm's joints move on their own", joint.name));
    }
    let a = joint.axis;
    let length = a.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length > 1e-9 && length.is_finite()) {
        return Err(format!("joint {}: axis {a:?} has no direction", joint.name));
    }
    let (lower, upper, effort) = (joint.lower, joint.upper, joint.effort);
    if limited && !(lower < upper && lower.is_finite() && upper.is_finite()) {
        return Err(format!(
            "joint {}: <limit lower=\"{lower}\" upper=\"{upper}\"> leaves it no room; a revolute or prismatic joint \
             has a lower limit below its upper one",
            joint.name
        ));
    }
    Ok(JointConfig {
        name: joint.name.clone(),
        xyz_m: at.origin.0,
        rpy_rad: at.rotation.roll_pitch_yaw().0,
        axis: a.map(|x| x / length),
        prismatic: joint.joint_type == JointType::Prismatic,
        low_rad: limited.then_some(lower),
        high_rad: limited.then_some(upper),
        effort_n_m: (effort > 0.0).then_some(effort),
        link: robot.links.iter().find(|l| l.name == joint.child).map_or_else(LinkConfig::default, body),
    })
}

/// Mass properties with the inertia turned into the link's axes.
fn body(link: &UrdfLink) -> LinkConfig {
    let r = Pose::from_xyz_rpy([0.0; 3], link.origin.rpy).rotation;
    let [xx, xy, xz, yy, yz, zz] = link.inertia;
    let given = wingbeat::math::Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let turned = if rotation_vector(&r).norm() > 0.0 { r * given * r.transpose() } else { given };
    let m = turned.0;
    LinkConfig {
        mass_kg: link.mass,
        com_m: link.origin.xyz,
        inertia_kg_m2: [m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]],
        radius_m: 0.04,
    }
}
