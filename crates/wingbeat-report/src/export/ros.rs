//! Types of messages of ROS 2 as their packages define them, and the robot's description.

use std::fmt::Write;

use wingbeat::math::Vec3;

use crate::motion::{RunMotion, SurfaceTrack, at};
use crate::page::escaped;

/// Places in [`TYPES`].
pub const STRING: usize = 0;
pub const TF: usize = 1;
pub const ODOMETRY: usize = 2;
pub const JOINTS: usize = 3;
pub const WRENCH: usize = 4;
pub const POINT: usize = 5;

macro_rules! parts {
    ($own:literal $(, $name:literal: $text:literal)* $(,)?) => {
        concat!($own $(, "================================================================================\nMSG: ", $name, "\n", $text)*)
    };
}

/// Names and definitions, those that a definition names behind it.
pub const TYPES: [(&str, &str); 6] = [
    ("std_msgs/msg/String", "string data\n"),
    (
        "tf2_msgs/msg/TFMessage",
        parts!(
            "geometry_msgs/TransformStamped[] transforms\n",
            "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
            "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
            "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
            "geometry_msgs/Transform": "Vector3 translation\nQuaternion rotation\n",
            "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
            "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
        ),
    ),
    (
        "nav_msgs/msg/Odometry",
        parts!(
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n",
            "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
            "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
            "geometry_msgs/PoseWithCovariance": "Pose pose\nfloat64[36] covariance\n",
            "geometry_msgs/Pose": "Point position\nQuaternion orientation\n",
            "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
            "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
            "geometry_msgs/TwistWithCovariance": "Twist twist\nfloat64[36] covariance\n",
            "geometry_msgs/Twist": "Vector3 linear\nVector3 angular\n",
            "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
        ),
    ),
    (
        "sensor_msgs/msg/JointState",
        parts!(
            "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
            "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
            "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
        ),
    ),
    (
        "geometry_msgs/msg/WrenchStamped",
        parts!(
            "std_msgs/Header header\nWrench wrench\n",
            "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
            "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
            "geometry_msgs/Wrench": "Vector3 force\nVector3 torque\n",
            "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
        ),
    ),
    (
        "trajectory_msgs/msg/JointTrajectoryPoint",
        parts!(
            "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\nbuiltin_interfaces/Duration time_from_start\n",
            "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec\n",
        ),
    ),
];

/// The quality of service of a topic whose last message late readers get, as `ros2 bag` writes it.
pub const LATCHED: &str = "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: 854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  avoid_ros_namespace_conventions: false";

/// A flat piece that moves: its frame, its front and its back edge, the direction of the span there, to the left, and whether it is drawn.
pub struct FlatPiece {
    pub frame: String,
    pub edges: [Vec3; 2],
    pub left: Vec3,
    pub drawn: bool,
}

/// The pieces of rib `k` in frame `i`, in B: its chord, and of a membrane behind it the parts of its bulge, which are drawn in its place.
pub fn pieces(surface: &SurfaceTrack, k: usize, i: usize) -> Vec<FlatPiece> {
    let points = surface.along(k, i);
    let frame = format!("{}_rib_{k}", surface.name);
    let left = span(surface, k, i);
    let part = |(n, edges): (usize, &[Vec3])| FlatPiece {
        frame: format!("{frame}_part_{n}"),
        edges: [edges[0], edges[1]],
        left,
        drawn: true,
    };
    let flat = points.len() == 2;
    let parts = points.windows(2).filter(|_| !flat).enumerate().map(part);
    let chord =
        FlatPiece { frame: frame.clone(), edges: [points[0], points[points.len() - 1]], left, drawn: flat };
    std::iter::once(chord).chain(parts).collect()
}

/// From the middle of the rib to the right of rib `k` to that of the rib to its left in frame `i`, m in B: over the panels on both sides of it,
/// of which there are one or two; straight to the left where there is none.
fn span(surface: &SurfaceTrack, k: usize, i: usize) -> Vec3 {
    let middle = |k: usize| (at(&surface.ribs[k][0], i) + at(&surface.ribs[k][1], i)) * 0.5;
    let covered = |panel: usize| surface.covered.get(panel) == Some(&true);
    let to_left = k.checked_sub(1).filter(|panel| covered(*panel));
    let to_right = if covered(k) { k + 1 } else { k };
    let span = middle(to_left.unwrap_or(k)) - middle(to_right);
    if span.norm() > 0.0 { span } else { Vec3([0.0, 1.0, 0.0]) }
}

/// The robot as links for its body and every piece of its ribs, which hang on it by floating joints: their places are in the transforms.
pub fn urdf(motion: &RunMotion, name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let (reach, com) = (motion.reach(), at(&motion.com, 0).0);
    let shape = |text: &mut String, link: &str, [x, y, z]: [f64; 3], size: [f64; 3], colour: &str| {
        // Writing to a String does not fail.
        let _ = write!(
            text,
            "<link name=\"{link}\"><visual><origin xyz=\"{x} {y} {z}\"/><geometry><box size=\"{} {} {}\"/></geometry>\
             <material name=\"{link}\"><color rgba=\"{colour} 1\"/></material></visual></link>",
            size[0], size[1], size[2]
        );
    };
    let mut text = format!("<?xml version=\"1.0\"?><robot name=\"{plain}\">");
    shape(&mut text, "base_link", com, [0.6 * reach, 0.12 * reach, 0.12 * reach], "0.4 0.42 0.46");
    for surface in &motion.surfaces {
        let middle = |k: usize| (at(&surface.ribs[k][0], 0) + at(&surface.ribs[k][1], 0)) * 0.5;
        for k in 0..surface.ribs.len() {
            let near = [k.checked_sub(1), (k + 1 < surface.ribs.len()).then_some(k + 1)];
            let width = near.into_iter().flatten().map(|other| (middle(other) - middle(k)).norm());
            let width = 0.5 * width.fold(0.0, f64::max);
            let side = surface.side.get(k.min(surface.side.len().saturating_sub(1))).copied().unwrap_or(2);
            let colour = ["0 0.45 0.7", "0.84 0.37 0", "0.55 0.57 0.6"][side];
            for piece in pieces(surface, k, 0) {
                let (link, chord) = (escaped(&piece.frame), (piece.edges[0] - piece.edges[1]).norm());
                if piece.drawn {
                    shape(&mut text, &link, [0.0; 3], [chord, width.max(1e-3), 1e-3], colour);
                } else {
                    let _ = write!(text, "<link name=\"{link}\"/>");
                }
                let _ = write!(
                    text,
                    "<joint name=\"{link}_joint\" type=\"floating\"><parent link=\"base_link\"/><child link=\"{link}\"/></joint>"
                );
            }
        }
    }
    text + "</robot>"
}
