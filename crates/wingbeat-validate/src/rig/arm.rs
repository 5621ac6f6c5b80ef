//! Kinematics of the Kinova Gen3.

use wingbeat::math::{Quat, Random, Vec3};
use wingbeat::rig::arm::{ArmConfig, InverseKinematics, InverseStatus, SerialArm};
use wingbeat::rig::rotation_vector;

use crate::{ComparisonRow, Error, reference_table};

/// Tool poses from the frames by matrices against quaternions in 40 digits.
pub fn forward_kinematics() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.forward_kinematics";
    let arm = ArmConfig::kinova_gen3().build()?;
    let table = reference_table!("kinova_gen3/forward_kinematics.csv")?;
    let columns: Vec<Vec<f64>> = (0..13).map(|i| table.column_at(i)).collect::<Result<_, _>>()?;
    let (mut position, mut angle) = (0.0_f64, 0.0_f64);
    for row in 0..table.len() {
        let at = |i: usize| columns[i][row];
        let q: [f64; 6] = std::array::from_fn(at);
        let expected = Quat::from_wxyz(&[at(9), at(10), at(11), at(12)]).matrix();
        let tool = arm.tool_pose(&q);
        position = position.max((tool.origin - Vec3([at(6), at(7), at(8)])).norm());
        angle = angle.max(rotation_vector(&(tool.rotation * expected.transpose())).norm());
    }
    let source = "URDF frames by quaternions, 40 digits";
    Ok(vec![
        ComparisonRow::judged(ID, source, "largest position error, 6 poses", position, 1e-9, "m"),
        ComparisonRow::judged(
            &format!("{ID}.angle"),
            source,
            "largest angle error, 6 poses",
            angle,
            1e-9,
            "rad",
        ),
    ])
}

/// A thousand random poses within the joint limits, found again from one fixed seed pose.
pub fn inverse_kinematics() -> Result<Vec<ComparisonRow>, Error> {
    const ID: &str = "rig.inverse_kinematics";
    const POSES: usize = 1000;
    let arm = ArmConfig::kinova_gen3().build()?;
    let solver = InverseKinematics::default();
    let mut random = Random::new(2024);
    let (mut position, mut angle, mut missed) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..POSES {
        let goal = arm.tool_pose(&random_pose(&arm, &mut random));
        let solution = solver.solve(&arm, &goal, &[0.3, 0.4, -0.9, 0.0, -0.7, 0.0]);
        if solution.status != InverseStatus::Solved || arm.beyond_limits(&solution.q, 0.0).is_some() {
            missed += 1;
            continue;
        }
        let tool = arm.tool_pose(&solution.q);
        position = position.max((tool.origin - goal.origin).norm());
        angle = angle.max(rotation_vector(&(tool.rotation * goal.rotation.transpose())).norm());
    }
    let source = "forward kinematics, 1000 random poses";
    let share = missed as f64 / POSES as f64;
    Ok(vec![
        ComparisonRow::judged(ID, source, "largest position error", position, 1e-6, "m"),
        ComparisonRow::judged(&format!("{ID}.angle"), source, "largest angle error", angle, 1e-6, "rad"),
        ComparisonRow::judged(
            &format!("{ID}.unsolved"),
            source,
            "share not solved within the limits",
            share,
            0.005,
            "",
        ),
    ])
}

fn random_pose(arm: &SerialArm, random: &mut Random) -> Vec<f64> {
    use std::f64::consts::PI;
    arm.joints.iter().map(|j| random.between(j.low.max(-PI), j.high.min(PI))).collect()
}
