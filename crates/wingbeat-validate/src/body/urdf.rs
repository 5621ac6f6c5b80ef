//! Reading of a URDF into a floating tree.

use crate::Error;
use wingbeat::body::{Base, JointKind, Link, Tree};
use wingbeat::math::{Mat3, Vec3};
use wingbeat_io::urdf::tree::{JointType, UrdfJoint, UrdfLink as Described, UrdfOrigin, UrdfRobot};

const FILE: &str = "multibody/aerobat10.urdf";

/// The reference tree of 10 degrees of freedom.
pub fn reference() -> Result<Tree, Error> {
    parse(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../validation/multibody/aerobat10.urdf")))
}

/// A tree with the root link as floating base; every joint must be revolute or continuous.
fn parse(text: &str) -> Result<Tree, Error> {
    let robot = UrdfRobot::read(text).map_err(|e| Error::reference(FILE, e))?;
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child == name);
    let root = robot.links.iter().find(|link| !is_child(&link.name));
    let root = root.ok_or_else(|| Error::reference(FILE, "no root link"))?;
    let (mass, com, inertia) = body(root);
    let mut links = Vec::new();
    branch(&robot, &root.name, None, &mut links)?;
    Ok(Tree::new(&Base { mass, com, inertia }, &links)?)
}

/// Appends the links beyond the link `name`, which has the index `parent`, branch by
/// branch: the order in which Pinocchio numbers the joints of this file.
fn branch(robot: &UrdfRobot, name: &str, parent: Option<usize>, links: &mut Vec<Link>) -> Result<(), Error> {
    for joint in robot.joints.iter().filter(|joint| joint.parent == name) {
        links.push(hinged(robot, joint, parent)?);
        branch(robot, &joint.child, Some(links.len() - 1), links)?;
    }
    Ok(())
}

/// The child link of `joint`.
fn hinged(robot: &UrdfRobot, joint: &UrdfJoint, parent: Option<usize>) -> Result<Link, Error> {
    if !matches!(joint.joint_type, JointType::Revolute | JointType::Continuous) {
        return Err(Error::reference(FILE, format!("joint {} is not revolute", joint.name)));
    }
    let child = robot.links.iter().find(|link| link.name == joint.child);
    let child = child.ok_or_else(|| Error::reference(FILE, format!("no link {}", joint.child)))?;
    let (mass, com, inertia) = body(child);
    Ok(Link {
        name: child.name.clone(),
        parent,
        origin: Vec3(joint.origin.xyz),
        orientation: rotation(&joint.origin),
        kind: JointKind::Revolute,
        axis: Vec3(joint.axis).unit(),
        mass,
        com,
        inertia,
    })
}

/// Mass, centre of mass and inertia in link axes.
fn body(link: &Described) -> (f64, Vec3, Mat3) {
    let [xx, xy, xz, yy, yz, zz] = link.inertia;
    let own = Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let r = rotation(&link.origin);
    (link.mass, Vec3(link.origin.xyz), r * own * r.transpose())
}

fn rotation(origin: &UrdfOrigin) -> Mat3 {
    let [roll, pitch, yaw] = origin.rpy;
    Mat3::from_roll_pitch_yaw(roll, pitch, yaw)
}
