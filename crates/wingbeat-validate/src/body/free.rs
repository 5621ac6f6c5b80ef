//! The reference tree as a robot whose joints are partly driven and partly free.

use wingbeat::math::{GRAVITY, Vec3};
use wingbeat::plant::Plant;
use wingbeat::robot::{Air, Robot, Wind};
use wingbeat::scenario::Document;

use super::{ReferenceState, reference};
use crate::{ComparisonRow, Error};

/// Rate of the phase, rad/s.
const PHASE_RATE: f64 = 40.0;

/// The robot file of validation/multibody/aerobat10.urdf; joint i free, with a spring that exerts the reference's
/// effort, where bit i of `free` is set, else driven with the reference's coordinate, rate and acceleration.
fn toml(reference: &ReferenceState, free: usize) -> String {
    let mut text = format!(
        r#"
name = "reference_tree"
body = {{ mass_kg = 0.025, inertia_kg_m2 = [8e-6, 2.2e-5, 2.4e-5] }}
[gait.fourier]
frequency_hz = {:e}
"#,
        PHASE_RATE / std::f64::consts::TAU
    );
    for i in 0..4 {
        let side = if i < 2 { 1.0 } else { -1.0 };
        let (parent, origin, mass, arm, inertia) = if i % 2 == 0 {
            ("body".into(), [0.01, side * 0.02, 0.005], 0.003, 0.035, "[1.5e-6, 4e-7, 1.8e-6]")
        } else {
            (format!("link{}", i - 1), [0.0, side * 0.07, 0.0], 0.002, 0.05, "[2.2e-6, 3e-7, 2.4e-6]")
        };
        let moved = if free >> i & 1 == 1 {
            let stiffness = 1e-2;
            let rest = reference.q[i] + reference.efforts[i] / stiffness;
            format!("elastic = {{ stiffness = {stiffness:e}, rest = {rest:e} }}")
        } else {
            // mean + a cos(phase - p) with the rate and the acceleration of the reference at phase 0.
            let (sine, cosine) = (reference.qd[i] / PHASE_RATE, -reference.qdd[i] / PHASE_RATE.powi(2));
            let (amplitude, phase, mean) = (sine.hypot(cosine), sine.atan2(cosine), reference.q[i] - cosine);
            format!(
                "driven = {{ mean_rad = {mean:e}, harmonics = [{{ amplitude_rad = {amplitude:e}, phase_rad = {phase:e} }}] }}"
            )
        };
        text += &format!(
            r#"
[[links]]
name = "link{i}"
parent = "{parent}"
origin_m = {origin:?}
axis = [{side:?}, 0.0, 0.0]
mass_kg = {mass}
com_m = [-0.01, {com}, 0.0]
inertia_kg_m2 = {inertia}
{moved}
"#,
            com = side * arm,
        );
    }
    text
}

/// Largest relative errors of the accelerations and of the efforts of the driven joints.
fn errors(reference: &ReferenceState, free: usize) -> Result<[f64; 2], Error> {
    let spec = Document::text("tree", &toml(reference, free))
        .and_then(|d| d.robot())
        .map_err(|e| Error::NoAnswer(e.to_string()))?;
    let vacuum = Air { density: 0.0, wind: Wind::steady(Vec3::ZERO) };
    let robot = Robot::new(&spec, Vec::new(), vacuum, 0.0)?;
    let (l, turned) = (*robot.layout(), reference.attitude.matrix());
    let mut x = vec![0.0; l.len];
    reference.attitude.store_wxyz(&mut x[l.attitude..]);
    (turned * reference.v).store(&mut x[l.velocity..]);
    reference.w.store(&mut x[l.rate..]);
    let joints: Vec<usize> = (0..4).filter(|i| free >> i & 1 == 1).collect();
    for (c, &i) in joints.iter().enumerate() {
        (x[l.joints + c], x[l.joints + joints.len() + c]) = (reference.q[i], reference.qd[i]);
    }
    let mut dx = vec![0.0; l.len];
    robot.rates_in_numbers(0.0, &x, &[], &mut dx)?;
    let efforts = robot.observe(0.0, &x, &[])?.torques;
    // Uniform gravity accelerates the whole alike: the reference falls with its own.
    let fall = Vec3::new(0.0, 0.0, reference.gravity - GRAVITY);
    let inertial = turned.transpose_mul(Vec3::from_slice(&dx[l.velocity..]) - fall);
    let linear = inertial - reference.w.cross(reference.v);
    let found = linear.0.into_iter().chain(Vec3::from_slice(&dx[l.rate..]).0);
    let found = found.chain(dx[l.joints + joints.len()..][..joints.len()].iter().copied());
    let expected = reference.base.iter().copied().chain(joints.iter().map(|&i| reference.qdd[i]));
    let relative = |(found, exact): (f64, f64)| ((found - exact) / exact).abs();
    let motion = found.zip(expected).map(relative).fold(0.0, f64::max);
    let driven = (0..4).filter(|i| !joints.contains(i));
    let effort = driven.map(|i| relative((efforts[i], reference.efforts[i]))).fold(0.0, f64::max);
    Ok([motion, effort])
}

/// The rows.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let reference = reference()?;
    let mut worst = [0.0_f64; 2];
    for free in 0..16 {
        for (worst, error) in worst.iter_mut().zip(errors(&reference, free)?) {
            *worst = worst.max(error);
        }
    }
    let (id, source) = ("body.multibody_free", "Pinocchio 4.1 and MuJoCo 4.0 (agreeing to 1e-15)");
    let motion = "max relative error of the accelerations, all 16 choices of free and driven joints";
    let effort = "max relative error of the efforts of the driven joints, the same";
    Ok(vec![
        ComparisonRow::judged(id, source, motion, worst[0], 1e-10, ""),
        ComparisonRow::judged(&format!("{id}.efforts"), source, effort, worst[1], 1e-10, ""),
    ])
}
