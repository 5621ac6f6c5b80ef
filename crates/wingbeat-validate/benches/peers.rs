//! Running times of what other programs compute as well; `cargo xtask peers` runs both sides.
//!
//! Prints `name<TAB>seconds`, medians over repeats.

use cpu_time::ProcessTime;
use std::f64::consts::TAU;
use std::hint::black_box;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use wingbeat::body::{LinkMotion, Tree};
use wingbeat::math::{GRAVITY, Jet, Quat, Vec3, Wrench};
use wingbeat::plant::Plant;
use wingbeat::scenario::{Scenario, TetherCase};
use wingbeat_validate::{Error, body, reference_table};

/// States evaluated in one batch, all different.
const BATCH: usize = 500;
/// Joints of the reference tree.
const JOINTS: usize = 4;

/// Median time of `run`, s, over `repeats`.
fn median(repeats: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..repeats)
        .map(|_| {
            let start = ProcessTime::now();
            run();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[repeats / 2]
}

fn row(name: &str, seconds: f64) {
    println!("{name}\t{seconds:e}");
}

/// Configuration and rates of the reference tree in Pinocchio's order.
struct Pose {
    attitude: Quat,
    rates: [f64; 6 + JOINTS],
    angles: [f64; JOINTS],
}

/// Accelerations of base (spatial, as Pinocchio's) and joints of one pose.
fn forward_dynamics(tree: &Tree, pose: &Pose, torques: &[f64; JOINTS]) -> Option<[f64; 6 + JOINTS]> {
    let (v_b, w_b) = (Vec3::from_slice(&pose.rates), Vec3::from_slice(&pose.rates[3..]));
    let joints: [Jet; JOINTS] = std::array::from_fn(|i| Jet::new(pose.angles[i], pose.rates[6 + i], 0.0));
    let mut motions = [LinkMotion::default(); JOINTS];
    tree.motions(&joints, v_b, w_b, &mut motions);
    let g_b = pose.attitude.matrix().transpose_mul(Vec3([0.0, 0.0, -GRAVITY]));
    let none = [Wrench::ZERO; JOINTS];
    let free = tree.forward_dynamics(w_b, &motions, torques, g_b, Wrench::ZERO, &none)?;
    let ([a, b, c], [d, e, f]) = ((free.base.origin - w_b.cross(v_b)).0, free.base.angular.0);
    let [p, q, r, s] = free.joints;
    Some([a, b, c, d, e, f, p, q, r, s])
}

fn tree() -> Result<(), Error> {
    let tree = body::reference_tree()?;
    let v = reference_table!("multibody/ref_v.txt")?.column_at(0)?;
    let tau = reference_table!("multibody/ref_tau.txt")?.column_at(0)?;
    let torques = std::array::from_fn(|i| tau[6 + i]);
    let wave = |k: usize, i: usize| (TAU * (0.026 * k as f64 + 0.1 * i as f64)).sin();
    let poses: Vec<Pose> = (0..BATCH)
        .map(|k| Pose {
            attitude: Quat::exp(Vec3([0, 1, 2].map(|i| wave(k, i)))),
            rates: std::array::from_fn(|i| v[i] * (1.0 + 0.5 * wave(k, i))),
            angles: std::array::from_fn(|i| wave(k, i + 3)),
        })
        .collect();
    let batch = median(201, || {
        for pose in &poses {
            black_box(forward_dynamics(&tree, black_box(pose), &torques));
        }
    });
    row("forward_dynamics", batch / BATCH as f64);
    Ok(())
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The plant of the banking turn with `strips` strips of aerodynamics.
fn plant(preset: &str, key: &str, strips: usize) {
    let overrides = [format!("aero.preset={preset:?}"), format!("aero.{preset}.{key}={strips}")];
    let scenario = Scenario::load(&root().join("scenarios/banking_turn.toml"), &overrides)
        .unwrap_or_else(|error| panic!("{error}"));
    let (robot, x) = (scenario.robot(), scenario.start());
    let (mut dx, u) = (x.clone(), vec![0.01; robot.inputs().len()]);
    let evaluations = 50;
    let batch = median(201, || {
        for k in 0..evaluations {
            let rates = robot.rates_in_numbers(black_box(1e-2 * f64::from(k)), black_box(&x), &u, &mut dx);
            black_box(rates.map(|()| dx[0])).unwrap_or_else(|fault| panic!("{fault}"));
        }
    });
    row(&format!("plant_{preset}_{strips}"), batch / f64::from(evaluations));
}

/// The flapping wing of case F2, per simulated second.
fn flap(preset: &str, key: &str, strips: usize) {
    let overrides = [format!("aero.preset={preset:?}"), format!("aero.{preset}.{key}={strips}")];
    let none = |file: &Path| Err(format!("{} is not read here", file.display()));
    let case = TetherCase::load(&root().join("cases/flap_f2.toml"), &overrides, &none)
        .unwrap_or_else(|error| panic!("{error}"));
    let time = median(11, || drop(black_box(case.tether.run(|_| ControlFlow::Continue(())))));
    let simulated = case.tether.clock.step() * case.tether.clock.steps() as f64;
    row(&format!("flap_f2_{preset}"), time / simulated);
}

fn main() -> Result<(), Error> {
    tree()?;
    // Eight would leave a hinge between two edges of the strips.
    for strips in [9, 16] {
        plant("paper", "nodes", strips);
        plant("full", "strips", strips);
    }
    flap("paper", "nodes", 16);
    flap("full", "strips", 16);
    Ok(())
}
