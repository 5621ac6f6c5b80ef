//! The multibody tree against Pinocchio's numbers, conservation laws and itself.

use wingbeat::body::{Base, BaseAcceleration, JointKind, Link, LinkMotion, MAX_LINKS, Tree, joint_power};
use wingbeat::math::linear::solve_symmetric;
use wingbeat::math::{Dual, Jet, Mat3, Quat, RK4, Scalar, Vec3, Workspace, Wrench};

fn diagonal(x: f64, y: f64, z: f64) -> Mat3 {
    Mat3::diagonal(Vec3([x, y, z]))
}

fn wing_link(name: &str, parent: Option<usize>, origin: [f64; 3], axis: [f64; 3]) -> Link {
    Link {
        name: name.into(),
        parent,
        origin: Vec3(origin),
        orientation: Mat3::IDENTITY,
        kind: JointKind::Revolute,
        axis: Vec3(axis),
        mass: 0.0,
        com: Vec3::ZERO,
        inertia: Mat3::ZERO,
    }
}

fn massive(link: Link, mass: f64, com: [f64; 3], inertia: Mat3) -> Link {
    Link { mass, com: Vec3(com), inertia, ..link }
}

/// The tree of validation/multibody/aerobat10.urdf.
fn reference_tree() -> Tree {
    let base = Base { mass: 0.025, com: Vec3::ZERO, inertia: diagonal(8e-6, 2.2e-5, 2.4e-5) };
    let humerus = diagonal(1.5e-6, 4e-7, 1.8e-6);
    let radius = diagonal(2.2e-6, 3e-7, 2.4e-6);
    let mut links = Vec::new();
    for (k, side) in [1.0, -1.0].into_iter().enumerate() {
        let axis = [side, 0.0, 0.0];
        let shoulder = wing_link(["hum_l", "hum_r"][k], None, [0.01, side * 0.02, 0.005], axis);
        links.push(massive(shoulder, 0.003, [-0.01, side * 0.035, 0.0], humerus));
        let elbow = wing_link(["rad_l", "rad_r"][k], Some(2 * k), [0.0, side * 0.07, 0.0], axis);
        links.push(massive(elbow, 0.002, [-0.01, side * 0.05, 0.0], radius));
    }
    Tree::new(&base, &links).unwrap()
}

/// Sweep hinge without mass, flap hinge and elbow per wing, inertias off axis and a tilted mount.
fn awkward_tree() -> Tree {
    let tilt = Mat3::from_roll_pitch_yaw(0.2, -0.3, 0.1);
    let skewed = |scale: f64| tilt * diagonal(1.2 * scale, 0.5 * scale, 1.5 * scale) * tilt.transpose();
    let symmetric = |m: Mat3| (m + m.transpose()) * 0.5;
    let base = Base { mass: 0.03, com: Vec3([-0.015, 0.001, 0.002]), inertia: symmetric(skewed(2e-5)) };
    let mut links = Vec::new();
    for side in [1.0, -1.0] {
        let (name, first) = (if side > 0.0 { "left" } else { "right" }, links.len());
        let sweep = wing_link(&format!("sweep_{name}"), None, [0.0, side * 0.02, 0.007], [0.0, 0.0, side]);
        links.push(Link { orientation: tilt, ..sweep });
        let flap = wing_link(&format!("flap_{name}"), Some(first), [0.0; 3], [side, 0.0, 0.0]);
        links.push(massive(flap, 0.002, [0.005, side * 0.025, 0.001], symmetric(skewed(2e-6))));
        let elbow_axis = (Vec3([1.0, 0.1, -0.2]) * side).unit();
        let elbow =
            wing_link(&format!("elbow_{name}"), Some(first + 1), [0.0, side * 0.05, 0.0], elbow_axis.0);
        links.push(massive(elbow, 0.004, [0.02, side * 0.05, 0.0], symmetric(skewed(1e-5))));
    }
    Tree::new(&base, &links).unwrap()
}

/// A flapping motion with every joint moving, at time t.
fn gait<S: Scalar>(tree: &Tree, t: S) -> Vec<Jet<S>> {
    let time = Jet::new(t, S::ONE, S::ZERO);
    (0..tree.links())
        .map(|i| (time * 22.0 + 0.7 * i as f64).cos() * (0.3 + 0.15 * i as f64) + 0.1 * i as f64)
        .collect()
}

fn numbers(file: &str) -> Vec<f64> {
    let path = format!("{}/../../validation/multibody/{file}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap().split_whitespace().map(|s| s.parse().unwrap()).collect()
}

#[test]
fn free_joints_agree_with_pinocchio() {
    let tree = reference_tree();
    let [q, v, tau, expected] =
        ["ref_q.txt", "ref_v.txt", "ref_tau.txt", "ref_qdd_pin_local.txt"].map(numbers);
    let r_wb = Quat::from_wxyz(&[q[6], q[3], q[4], q[5]]).matrix();
    let (v_b, w_b) = (Vec3::from_slice(&v), Vec3::from_slice(&v[3..]));
    let joints: Vec<Jet> = (0..4).map(|i| Jet::new(q[7 + i], v[6 + i], 0.0)).collect();
    let mut motions = [LinkMotion::default(); MAX_LINKS];
    tree.motions(&joints, v_b, w_b, &mut motions);
    let g_b = r_wb.transpose_mul(Vec3([0.0, 0.0, -9.81]));
    let torques: [f64; 4] = tau[6..].try_into().unwrap();
    let none = [Wrench::ZERO; 4];
    let found = tree.forward_dynamics(w_b, &motions, &torques, g_b, Wrench::ZERO, &none).unwrap();
    // Pinocchio's free-flyer acceleration is spatial: a_spatial = a_classical - w x v.
    let spatial = found.base.origin - w_b.cross(v_b);
    let all = [&spatial.0[..], &found.base.angular.0, &found.joints[..4]].concat();
    for i in 0..10 {
        let error = (all[i] - expected[i]).abs() / expected[i].abs().max(1.0);
        assert!(error < 1e-10, "{i}: {} against {}, {error:e}", all[i], expected[i]);
    }
}

#[test]
fn inverse_dynamics_returns_the_torques_of_forward_dynamics() {
    for tree in [reference_tree(), awkward_tree()] {
        let n = tree.links();
        let (v_b, w_b) = (Vec3([1.0, -0.3, 0.2]), Vec3([2.0, -3.0, 1.0]));
        let g_b = Vec3([1.0, 2.0, -9.0]);
        let torques: [f64; MAX_LINKS] = std::array::from_fn(|i| 0.01 * (i as f64 - 1.3));
        let loads: [_; MAX_LINKS] = std::array::from_fn(|i| Wrench {
            force: Vec3([0.01, 0.02 * i as f64, -0.03]),
            moment: Vec3([1e-3, -2e-3, 5e-4]),
        });
        let push = Wrench { force: Vec3([0.1, 0.05, 0.3]), moment: Vec3([1e-3, 2e-3, -1e-3]) };
        let mut joints: Vec<_> = gait(&tree, 0.13).into_iter().map(|j| Jet::new(j.x, j.d, 0.0)).collect();
        let mut motions = [LinkMotion::default(); MAX_LINKS];
        tree.motions(&joints, v_b, w_b, &mut motions);
        let free = tree.forward_dynamics(w_b, &motions, &torques, g_b, push, &loads).unwrap();
        for (joint, dd) in joints.iter_mut().zip(free.joints) {
            joint.dd = dd;
        }
        tree.motions(&joints, v_b, w_b, &mut motions);
        let mut back = [0.0; MAX_LINKS];
        tree.joint_torques(&motions, free.base, g_b, &loads, &mut back);
        for i in 0..n {
            assert!((back[i] - torques[i]).abs() < 1e-13, "{i}: {} {}", back[i], torques[i]);
        }
        let (mass, bias) = tree.inertia_and_bias(w_b, &motions);
        let external = loads[..n].iter().fold(push + tree.gravity(g_b, &motions), |sum, w| sum + *w);
        let base = solve(mass, external + -bias);
        let scale = free.base.angular.norm();
        assert!((base.origin - free.base.origin).norm() < 1e-12 * scale);
        assert!((base.angular - free.base.angular).norm() < 1e-12 * scale);
    }
}

fn solve(mass: [[f64; 6]; 6], w: Wrench<f64>) -> BaseAcceleration {
    let ([a, b, c], [d, e, f]) = (w.force.0, w.moment.0);
    BaseAcceleration::from_slice(&solve_symmetric(mass, [a, b, c, d, e, f]).unwrap())
}

/// Base state: position W, quaternion, v_WB_B, w_WB_B, work of the joints.
const STATES: usize = 14;

fn vacuum_rates(tree: &Tree, g_w: Vec3, t: f64, x: &[f64], dx: &mut [f64]) {
    let q = Quat::from_wxyz(&x[3..]);
    let (v_b, w_b) = (Vec3::from_slice(&x[7..]), Vec3::from_slice(&x[10..]));
    let (joints, mut motions) = (gait(tree, t), [LinkMotion::default(); MAX_LINKS]);
    tree.motions(&joints, v_b, w_b, &mut motions);
    let g_b = q.matrix().transpose_mul(g_w);
    let (mass, bias) = tree.inertia_and_bias(w_b, &motions);
    let base = solve(mass, tree.gravity(g_b, &motions) + -bias);
    let mut torques = [0.0; MAX_LINKS];
    tree.joint_torques(&motions, base, g_b, &[Wrench::ZERO; MAX_LINKS], &mut torques);
    (q.matrix() * v_b).store(dx);
    q.rate(w_b).store_wxyz(&mut dx[3..]);
    (base.origin - w_b.cross(v_b)).store(&mut dx[7..]);
    base.angular.store(&mut dx[10..]);
    dx[13] = joint_power(&torques, &joints);
}

struct Totals {
    linear: Vec3,
    angular: Vec3,
    energy: f64,
}

/// Momentum about the world origin, in W, and energy.
fn totals(tree: &Tree, g_w: Vec3, t: f64, x: &[f64]) -> Totals {
    let r = Quat::from_wxyz(&x[3..]).normalized().matrix();
    let (v_b, w_b) = (Vec3::from_slice(&x[7..]), Vec3::from_slice(&x[10..]));
    let mut motions = [LinkMotion::default(); MAX_LINKS];
    tree.motions(&gait(tree, t), v_b, w_b, &mut motions);
    let origin = -r.transpose_mul(Vec3::from_slice(x));
    let momentum = tree.momentum(v_b, w_b, &motions, origin);
    let potential = tree.potential_energy(r.transpose_mul(g_w), &motions, origin);
    let energy = tree.kinetic_energy(v_b, w_b, &motions) + potential;
    Totals { linear: r * momentum.linear, angular: r * momentum.angular, energy }
}

/// One flapping cycle from a moving start; totals before and after, work of the joints, peak energy.
fn one_cycle(tree: &Tree, g_w: Vec3) -> (Totals, Totals, f64, f64) {
    let period = std::f64::consts::TAU / 22.0;
    let steps = 4000;
    let (h, mut workspace) = (period / steps as f64, Workspace::new(STATES, 4));
    let mut x = [0.0; STATES];
    Quat::from_roll_pitch_yaw(0.1, -0.3, 0.5).store_wxyz(&mut x[3..]);
    Vec3([1.5, 0.1, -0.2]).store(&mut x[7..]);
    Vec3([0.5, -1.0, 0.3]).store(&mut x[10..]);
    let before = totals(tree, g_w, 0.0, &x);
    let mut peak: f64 = 0.0;
    for k in 0..steps {
        let rates = |t: f64, x: &[f64], dx: &mut [f64]| {
            vacuum_rates(tree, g_w, t, x, dx);
            Ok::<_, ()>(())
        };
        RK4.step(rates, k as f64 * h, h, &mut x, &mut workspace).unwrap();
        peak = peak.max(x[13].abs());
    }
    (before, totals(tree, g_w, period, &x), x[13], peak)
}

#[test]
fn momentum_is_kept_in_vacuum() {
    for tree in [reference_tree(), awkward_tree()] {
        let (before, after, _, _) = one_cycle(&tree, Vec3::ZERO);
        let linear = (after.linear - before.linear).norm() / before.linear.norm();
        let angular = (after.angular - before.angular).norm() / before.angular.norm();
        assert!(linear < 1e-9 && angular < 1e-9, "{linear:e} {angular:e}");
    }
}

#[test]
fn joint_work_equals_the_change_of_energy() {
    for tree in [reference_tree(), awkward_tree()] {
        let (before, after, work, peak) = one_cycle(&tree, Vec3([0.0, 0.0, -9.80665]));
        let error = (after.energy - before.energy - work).abs() / peak;
        assert!(error < 1e-8, "{error:e}: work {work}, energy {} {}", before.energy, after.energy);
    }
}

#[test]
fn motion_rates_are_the_time_derivatives_of_the_motion() {
    // With the body at rest the velocities are d(position)/dt; a nested dual gives both derivatives.
    let tree = awkward_tree();
    let t = Dual::<1, Dual<1>> { re: Dual::variable(0.21, 0), eps: [Dual::constant(1.0)] };
    let zero = Vec3::ZERO;
    let mut exact = [LinkMotion::default(); MAX_LINKS];
    let mut moved = [LinkMotion::default(); MAX_LINKS];
    tree.motions(&gait(&tree, 0.21), Vec3::ZERO, Vec3::ZERO, &mut exact);
    tree.motions(&gait(&tree, t), zero, zero, &mut moved);
    let mark = Vec3([0.02, -0.03, 0.05]);
    for i in 0..tree.links() {
        let (point, m) = (moved[i].point(mark), &exact[i]);
        let at = m.point(mark);
        for k in 0..3 {
            assert!((point[k].re.eps[0] - m.velocity_at(at)[k]).abs() < 1e-12);
            assert!((point[k].eps[0].eps[0] - m.acceleration_at(at)[k]).abs() < 1e-9);
        }
    }
}

#[test]
fn bias_acceleration_of_a_moving_base_matches_central_differences() {
    // The base turns steadily and its origin moves uniformly: no acceleration of its own.
    let tree = awkward_tree();
    let (v_w, w) = (Vec3([1.0, 0.5, -0.3]), Vec3([3.0, -2.0, 4.0]));
    let mark = Vec3([0.02, 0.04, -0.01]);
    let at = |t: f64| {
        let r = Quat::exp(w * t).matrix();
        let mut motions = [LinkMotion::default(); MAX_LINKS];
        tree.motions(&gait(&tree, t), r.transpose_mul(v_w), w, &mut motions);
        (r, motions)
    };
    let (t, h) = (0.17, 1e-5);
    let ((r, now), (r_next, next), (r_last, last)) = (at(t), at(t + h), at(t - h));
    for i in 0..tree.links() {
        let velocity = |r: Mat3, m: &LinkMotion| r * m.velocity_at(m.point(mark));
        let position = |r: Mat3, m: &LinkMotion, t: f64| v_w * t + r * m.point(mark);
        let slope = (velocity(r_next, &next[i]) - velocity(r_last, &last[i])) * (0.5 / h);
        let found = r * now[i].acceleration_at(now[i].point(mark));
        assert!((slope - found).norm() < 1e-6 * found.norm(), "{i}: {slope:?} {found:?}");
        let slope = (position(r_next, &next[i], t + h) - position(r_last, &last[i], t - h)) * (0.5 / h);
        assert!((slope - velocity(r, &now[i])).norm() < 1e-7);
        let spin = (r_next * next[i].rate - r_last * last[i].rate) * (0.5 / h);
        assert!((spin - r * now[i].rate_dot).norm() < 1e-6 * spin.norm().max(1.0));
    }
}

#[test]
fn mirrored_wings_move_and_load_as_mirror_images() {
    let tree = reference_tree();
    let joint = |k: f64| (Jet::new(0.3, 5.0, 0.0) * k).cos() + 0.2;
    let joints = [joint(1.0), joint(2.0), joint(1.0), joint(2.0)];
    let (v_b, w_b) = (Vec3([1.5, 0.0, -0.2]), Vec3([0.0, 2.0, 0.0]));
    let mut motions = [LinkMotion::default(); MAX_LINKS];
    tree.motions(&joints, v_b, w_b, &mut motions);
    for i in 0..2 {
        let (l, r) = (&motions[i], &motions[i + 2]);
        for (a, b, polar) in [
            (l.position, r.position, 1.0),
            (l.velocity, r.velocity, 1.0),
            (l.acceleration, r.acceleration, 1.0),
            (l.rate, r.rate, -1.0),
            (l.rate_dot, r.rate_dot, -1.0),
        ] {
            let image = Vec3([b[0], -b[1], b[2]]) * polar;
            assert!((a - image).norm() < 1e-13, "{i}: {a:?} {b:?}");
        }
    }
    let (_, bias) = tree.inertia_and_bias(w_b, &motions);
    let sideways = [bias.force[1], bias.moment[0], bias.moment[2]];
    assert!(sideways.iter().all(|x| x.abs() < 1e-15), "{sideways:?}");
}

#[test]
fn impossible_trees_are_refused_by_name() {
    let base = Base { mass: 0.02, com: Vec3::ZERO, inertia: diagonal(1e-5, 1e-5, 1e-5) };
    let good = massive(
        wing_link("humerus", None, [0.0; 3], [1.0, 0.0, 0.0]),
        0.001,
        [0.0; 3],
        diagonal(1e-6, 1e-6, 1e-6),
    );
    let refusal = |link: Link| Tree::new(&base, &[link]).unwrap_err().to_string();
    assert!(Tree::new(&base, std::slice::from_ref(&good)).is_ok());
    let message = refusal(Link { mass: -1.0, ..good.clone() });
    assert!(message.starts_with("links.humerus.mass_kg = -1"), "{message}");
    let message = refusal(Link { inertia: diagonal(1e-6, 1e-6, 3e-6), ..good.clone() });
    assert!(message.contains("inertia_kg_m2"), "{message}");
    let message = refusal(Link { axis: Vec3([1.0, 1.0, 0.0]), ..good.clone() });
    assert!(message.contains("axis"), "{message}");
    let message = refusal(Link { parent: Some(0), ..good.clone() });
    assert!(message.contains("parent"), "{message}");
    let twice = Tree::new(&base, &[good.clone(), good]).unwrap_err().to_string();
    assert!(twice.contains("humerus"), "{twice}");
}
