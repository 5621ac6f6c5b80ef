//! A robot carried on the rig.

use std::path::Path;

use wingbeat::math::{GRAVITY, Jet, Mat3, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::BodyMotion;
use wingbeat::scenario::RigRun;

#[test]
fn a_robot_at_rest_bears_its_weight_on_the_stand() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rigs/runs/roll15_speed08.toml");
    let run = RigRun::load(&file, &["rig.air.density_kg_m3=1e-30".into()]).unwrap();
    let attitude = Mat3::from_roll_pitch_yaw(0.3, -0.2, 1.0);
    let zero = Vec3::ZERO;
    let body =
        BodyMotion { attitude, velocity: zero, rate: zero, acceleration: zero, angular_acceleration: zero };
    let x = vec![0.0; run.robot.carried_states()];
    let u = vec![0.0; run.robot.inputs().len()];
    let loads = run.robot.carried(&Jet::default(), &body, &x, &u, &mut x.clone()).unwrap();
    let weight = Vec3([0.0, 0.0, -GRAVITY * run.robot.mass()]);
    assert!((attitude * loads.total().force - weight).norm() < 1e-12);
}
