//! Trajectories of joints, to files and back.

use wingbeat::rig::JointTrajectory;
use wingbeat::rig::arm::ArmConfig;
use wingbeat_io::trajectory::{
    ImportedTrajectory, against, kinova_json, kortex_csv, parse_kinova_json, parse_kortex_csv,
};
#[cfg(feature = "yaml")]
use wingbeat_io::trajectory::{parse_ros_yaml, ros_yaml};

fn sample() -> JointTrajectory {
    let arm = ArmConfig::kinova_gen3().build().unwrap();
    let row = |f: &dyn Fn(f64) -> f64| {
        (0..40).map(|k| (0..6).map(|j| f(0.02 * k as f64 + 0.3 * j as f64)).collect()).collect()
    };
    JointTrajectory {
        joints: arm.joints.iter().map(|j| j.name.clone()).collect(),
        step: 0.02,
        position: row(&|x| x.sin()),
        velocity: row(&|x| x.cos()),
        acceleration: row(&|x| -x.sin()),
    }
}

fn near(a: &[Vec<f64>], b: &[Vec<f64>], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (x, y) in a.iter().flatten().zip(b.iter().flatten()) {
        assert!((x - y).abs() < tolerance, "{x} {y}");
    }
}

#[test]
fn a_hair_outside_warns_and_more_is_refused() {
    let arm = ArmConfig::kinova_gen3().build().unwrap();
    let mut t = sample();
    t.position[3][2] = 2.575;
    let imported = against(ImportedTrajectory { trajectory: t.clone(), warnings: vec![] }, &arm).unwrap();
    assert!(imported.warnings[0].contains("point 3: joint_3 lies 0.0050 rad"), "{imported:?}");
    t.position[3][2] = 2.8;
    let refusal = against(ImportedTrajectory { trajectory: t, warnings: vec![] }, &arm).unwrap_err();
    assert!(refusal.contains("0.2300 rad"), "{refusal}");
}

#[test]
fn the_table_round_trips() {
    let t = JointTrajectory { step: 1e-3, ..sample() };
    let text = kortex_csv(&t).unwrap();
    assert!(text.lines().nth(1).unwrap().starts_with("0.000,"));
    let back = parse_kortex_csv(&text).unwrap();
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    near(&back.trajectory.position, &t.position, 1e-10);
    near(&back.trajectory.velocity, &t.velocity, 1e-10);
    assert_eq!(back.trajectory.joints, t.joints);
}

#[test]
fn the_arms_rules_are_kept() {
    assert!(kortex_csv(&sample()).unwrap_err().contains("exactly 1 ms"));
    let long = JointTrajectory { step: 1e-3, position: vec![vec![0.0; 6]; 30_002], ..sample() };
    assert!(kortex_csv(&long).unwrap_err().contains("at most 30 s"));
}

#[test]
fn units_are_detected_without_a_header() {
    let degrees = parse_kortex_csv("0,10,20,90\n0.001,10,20,90.5\n").unwrap();
    assert!(
        (degrees.trajectory.position[0][2] - std::f64::consts::FRAC_PI_2).abs() < 1e-12
            && degrees.warnings.len() == 1
    );
    let radians = parse_kortex_csv("0,0.1,0.2,1.5\n0.001,0.1,0.2,1.51\n").unwrap();
    assert!(radians.trajectory.position[0][2] == 1.5 && radians.warnings[0].contains("Radians"));
}

#[test]
fn ragged_and_wordy_files_are_explained() {
    assert!(parse_kortex_csv("0,1,2\n0.001,1\n").is_err());
    assert!(parse_kortex_csv("time,a\n0,1\n0.001,x\n").unwrap_err().contains("line 3"));
    assert!(parse_kortex_csv("").is_err());
    let cut = parse_kortex_csv("0,0.5\n0.001,0.5\n0.002,0.").unwrap_err();
    assert!(cut.contains("line 3, the last"), "{cut}");
}

#[test]
fn the_list_round_trips() {
    let t = sample();
    let back = parse_kinova_json(&kinova_json(&t, 1)).unwrap();
    assert!(back.warnings.is_empty() && (back.trajectory.step - 0.02).abs() < 1e-12);
    near(&back.trajectory.position, &t.position, 1e-12);
}

#[test]
fn other_json_is_explained() {
    assert!(parse_kinova_json("{}").unwrap_err().contains("jointAnglesGroup"));
    assert!(parse_kinova_json("[1,").unwrap_err().contains("not JSON"));
    let hollow = r#"{"jointAnglesGroup":{"jointAngles":[{"reachJointAngles":{}}]}}"#;
    assert!(parse_kinova_json(hollow).unwrap_err().contains("pose 0"));
}

#[cfg(feature = "yaml")]
#[test]
fn the_message_round_trips() {
    let t = sample();
    let back = parse_ros_yaml(&ros_yaml(&t, "base_link")).unwrap();
    assert!(back.warnings.is_empty() && (back.trajectory.step - 0.02).abs() < 1e-12);
    near(&back.trajectory.position, &t.position, 1e-15);
    near(&back.trajectory.acceleration, &t.acceleration, 1e-15);
    assert_eq!(back.trajectory.joints, t.joints);
}

#[cfg(feature = "yaml")]
#[test]
fn degrees_in_a_message_are_noticed() {
    let mut t = sample();
    for x in t.position.iter_mut().flatten() {
        *x = x.to_degrees();
    }
    let back = parse_ros_yaml(&ros_yaml(&t, "base_link")).unwrap();
    assert!(back.warnings[0].contains("degrees"));
    near(&back.trajectory.position, &sample().position, 1e-12);
}

#[cfg(feature = "yaml")]
#[test]
fn a_cut_file_and_uneven_times_are_explained() {
    let text = ros_yaml(&sample(), "base_link");
    assert!(parse_ros_yaml(&text[..text.len() - 60]).is_err());
    assert!(parse_ros_yaml(text.trim_end()).unwrap_err().contains("line break"));
    let uneven = text.replace("nanosec: 40000000", "nanosec: 45000000");
    assert!(parse_ros_yaml(&uneven).unwrap_err().contains("equal step"));
    assert!(parse_ros_yaml(&("[".repeat(200_000) + "\n")).unwrap_err().contains("brackets"));
}
