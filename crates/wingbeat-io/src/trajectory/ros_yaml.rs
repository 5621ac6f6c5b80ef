//! ROS 2 `trajectory_msgs/JointTrajectory` as YAML, in radians.

use std::fmt::Write;

use serde::Deserialize;
use wingbeat::rig::JointTrajectory;

use super::{ImportedTrajectory, Unit, entries, to_radians, whole};

/// The message, with `header.frame_id` as given.
pub fn ros_yaml(trajectory: &JointTrajectory, frame_id: &str) -> String {
    let list = |row: &[f64]| row.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let mut text =
        format!("header:\n  stamp: {{sec: 0, nanosec: 0}}\n  frame_id: {frame_id}\njoint_names:\n");
    for joint in &trajectory.joints {
        let _ = writeln!(text, "  - {joint}");
    }
    text += "points:\n";
    for (k, position) in trajectory.position.iter().enumerate() {
        let _ = writeln!(text, "  - positions: [{}]", list(position));
        for (key, rows) in [("velocities", &trajectory.velocity), ("accelerations", &trajectory.acceleration)]
        {
            if let Some(row) = rows.get(k) {
                let _ = writeln!(text, "    {key}: [{}]", list(row));
            }
        }
        let nanoseconds = (k as f64 * trajectory.step * 1e9).round() as u64;
        let (sec, nanosec) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        let _ = writeln!(text, "    time_from_start: {{sec: {sec}, nanosec: {nanosec}}}");
    }
    text
}

#[derive(Deserialize)]
struct Message {
    joint_names: Vec<String>,
    points: Vec<TrajectoryPoint>,
}

#[derive(Deserialize)]
#[serde(expecting = "struct Point")]
struct TrajectoryPoint {
    positions: Vec<f64>,
    #[serde(default)]
    velocities: Vec<f64>,
    #[serde(default)]
    accelerations: Vec<f64>,
    time_from_start: Time,
}

#[derive(Deserialize)]
struct Time {
    #[serde(default, alias = "secs")]
    sec: i64,
    #[serde(default, alias = "nsecs")]
    nanosec: i64,
}

/// Reads the message; ROS 1's `secs`, `nsecs` are understood too.
///
/// # Errors
/// What is wrong, without the file's name.
pub fn parse_ros_yaml(text: &str) -> Result<ImportedTrajectory, String> {
    whole(text)?;
    entries(text)?;
    if open_brackets(text) > DEEPEST {
        return Err(format!(
            "not a trajectory_msgs/JointTrajectory: more than {DEEPEST} brackets open at once"
        ));
    }
    let message = message(text)?;
    let time = |p: &TrajectoryPoint| p.time_from_start.sec as f64 + 1e-9 * p.time_from_start.nanosec as f64;
    let times: Vec<f64> = message.points.iter().map(time).collect();
    let step = equal_step(&times)?;
    let rows = |f: fn(&TrajectoryPoint) -> &Vec<f64>| -> Vec<Vec<f64>> {
        if message.points.iter().all(|p| f(p).is_empty()) {
            return Vec::new();
        }
        message.points.iter().map(|p| f(p).clone()).collect()
    };
    let trajectory = JointTrajectory {
        joints: message.joint_names,
        step,
        position: rows(|p| &p.positions),
        velocity: rows(|p| &p.velocities),
        acceleration: rows(|p| &p.accelerations),
    };
    trajectory.check().map_err(|error| error.to_string())?;
    let mut imported = ImportedTrajectory { trajectory, warnings: Vec::new() };
    to_radians(&mut imported, Some(Unit::Radians));
    Ok(imported)
}

#[cfg(feature = "yaml")]
fn message(text: &str) -> Result<Message, String> {
    serde_yaml_ng::from_str(text).map_err(|error| format!("not a trajectory_msgs/JointTrajectory: {error}"))
}

#[cfg(not(feature = "yaml"))]
fn message(_: &str) -> Result<Message, String> {
    Err(crate::not_built("a ROS 2 trajectory (YAML)"))
}

/// Brackets that may be open at once: the parser's time grows with the square, and the message needs 1.
const DEEPEST: usize = 256;

fn open_brackets(text: &str) -> usize {
    let (mut open, mut most) = (0_usize, 0);
    for byte in text.bytes() {
        match byte {
            b'[' | b'{' => open += 1,
            b']' | b'}' => open = open.saturating_sub(1),
            _ => {}
        }
        most = most.max(open);
    }
    most
}

/// The common step of `times`, s.
pub(super) fn equal_step(times: &[f64]) -> Result<f64, String> {
    let [first, .., last] = times else { return Ok(0.0) };
    let step = (last - first) / (times.len() - 1) as f64;
    for (k, w) in times.windows(2).enumerate() {
        if !((w[1] - w[0] - step).abs() <= 1e-3 * step.abs() + 2e-9) || !(step > 0.0) {
            return Err(format!(
                "point {}: {:.6} s after the one before; allowed is an equal step (here {step:.6} s)",
                k + 1,
                w[1] - w[0]
            ));
        }
    }
    Ok(step)
}
