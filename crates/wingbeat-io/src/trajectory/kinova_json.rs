//! Joint-angle lists of the Kinova Web App, in degrees from 0 to 360.

use serde_json::{Value, json};
use wingbeat::math::order::ascend_by;
use wingbeat::rig::JointTrajectory;

use super::ros_yaml::equal_step;
use super::{ImportedTrajectory, entries, unwind};

/// The list of joint poses that the Web App imports, one every `every` points
/// and the last. The time of each stands in its `applicationData`.
pub fn kinova_json(trajectory: &JointTrajectory, every: usize) -> String {
    let every = every.max(1);
    let poses: Vec<Value> = trajectory
        .position
        .iter()
        .enumerate()
        .filter(|(k, _)| k % every == 0)
        .map(|(k, q)| pose(k / every, k as f64 * trajectory.step, q))
        .collect();
    let mut text = format!("{:#}", json!({ "jointAnglesGroup": { "jointAngles": poses } }));
    text.push('\n');
    text
}

fn pose(index: usize, time: f64, q: &[f64]) -> Value {
    let angles: Vec<Value> = q
        .iter()
        .enumerate()
        .map(|(j, x)| json!({ "jointIdentifier": j, "value": x.to_degrees().rem_euclid(360.0) }))
        .collect();
    json!({
        "handle": { "identifier": index + 1, "actionType": 7, "permission": 7 },
        "name": format!("wingbeat {index:04}"),
        "applicationData": format!("{{\"time_s\":{time}}}"),
        "reachJointAngles": {
            "jointAngles": { "jointAngles": angles },
            "constraint": { "type": 0, "value": 0 },
        },
    })
}

/// Reads such a list; whole turns between neighbours are taken out. Without
/// times in `applicationData` the points are taken to be 1 s apart.
///
/// # Errors
/// What is wrong, without the file's name.
pub fn parse_kinova_json(text: &str) -> Result<ImportedTrajectory, String> {
    entries(text)?;
    let root: Value = serde_json::from_str(text).map_err(|error| format!("not JSON: {error}"))?;
    let poses = root["jointAnglesGroup"]["jointAngles"]
        .as_array()
        .ok_or("no jointAnglesGroup.jointAngles: not a joint-angle list of the Kinova Web App")?;
    let mut position = poses.iter().enumerate().map(angles).collect::<Result<Vec<_>, _>>()?;
    let times: Vec<f64> = poses.iter().filter_map(time).collect();
    let mut warnings = Vec::new();
    let step = if times.len() == poses.len() {
        equal_step(&times)?
    } else {
        warnings.push("no times: points are taken to be 1 s apart".into());
        1.0
    };
    unwind(&mut position);
    let joints = (1..=position.first().map_or(0, Vec::len)).map(|j| format!("joint_{j}")).collect();
    let trajectory = JointTrajectory { joints, step, position, ..Default::default() };
    trajectory.check().map_err(|error| error.to_string())?;
    Ok(ImportedTrajectory { trajectory, warnings })
}

/// Angles of one pose, rad in (-pi, pi], ordered by joint.
fn angles((index, pose): (usize, &Value)) -> Result<Vec<f64>, String> {
    let fail = |what: &str| format!("pose {index}: {what}");
    let list = pose["reachJointAngles"]["jointAngles"]["jointAngles"]
        .as_array()
        .ok_or_else(|| fail("no reachJointAngles.jointAngles.jointAngles"))?;
    let mut pairs = Vec::with_capacity(list.len());
    for (j, entry) in list.iter().enumerate() {
        let value = entry["value"].as_f64().ok_or_else(|| fail(&format!("joint {j} has no value")))?;
        pairs.push((entry["jointIdentifier"].as_u64().unwrap_or(j as u64), value));
    }
    ascend_by(&mut pairs, |pair| pair.0 as f64);
    Ok(pairs.iter().map(|(_, degrees)| (degrees - 360.0 * (degrees / 360.0).round()).to_radians()).collect())
}

fn time(pose: &Value) -> Option<f64> {
    let data: Value = serde_json::from_str(pose["applicationData"].as_str()?).ok()?;
    data["time_s"].as_f64()
}
