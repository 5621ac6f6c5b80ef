//! Multibody dynamics, linkage: values in f64, and with eight exact derivatives.

use std::hint::black_box;

use wingbeat::body::{Base, JointKind, Link, LinkMotion, Linkage, LinkageDimensions, Tree};
use wingbeat::math::{Dual, Jet, Mat3, Scalar, Vec3};

use super::{median, row};

/// Sweep, flap, elbow and twist per wing; two of the four links are heavy.
const LINKS: usize = 8;

fn link(parent: Option<usize>, name: String, origin: f64, axis: [f64; 3], mass: f64) -> Link {
    let side = axis[0] + axis[1] + axis[2];
    let inertia = Mat3::diagonal(Vec3([1e-6, 0.6e-6, 1.5e-6].map(|i| i * (mass / 2e-3))));
    Link {
        name,
        parent,
        origin: Vec3([0.0, side * origin, 0.0]),
        orientation: Mat3::IDENTITY,
        kind: JointKind::Revolute,
        axis: Vec3(axis),
        mass,
        com: Vec3([0.02, side * 0.05, 0.0]),
        inertia,
    }
}

fn tree() -> Tree {
    let inertia = Mat3::diagonal(Vec3([1e-5, 3e-5, 3e-5]));
    let mut links = Vec::new();
    for (side, word) in [(1.0, "left"), (-1.0, "right")] {
        let first = links.len();
        let x = [side, 0.0, 0.0];
        links.push(link(None, format!("sweep_{word}"), 0.02, [0.0, 0.0, side], 0.0));
        links.push(link(Some(first), format!("humerus_{word}"), 0.0, x, 1e-3));
        links.push(link(Some(first + 1), format!("radius_{word}"), 0.05, x, 4e-3));
        links.push(link(Some(first + 2), format!("tip_{word}"), 0.0, [0.0, side, 0.0], 0.0));
    }
    Tree::new(&Base { mass: 0.01, com: Vec3::ZERO, inertia }, &links)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Motions, mass matrix and bias of the tree, and the pose of the linkage; `number` makes the inputs.
fn times<S: Scalar>(kind: &str, batch: usize, number: impl Fn(f64, usize) -> S) {
    let tree = tree();
    let joints: [Jet<S>; LINKS] = std::array::from_fn(|i| {
        Jet::new(number(0.1 * i as f64 + 0.1, i), number(3.0, i + 1), number(50.0, i + 2))
    });
    let vector = |k: usize| Vec3([number(1.0, k), number(0.1, k + 1), number(0.2, k + 2)]);
    let (v_b, w_b) = (vector(0), vector(3));
    let mut motions = [LinkMotion::default(); LINKS];
    let body = median(batch, || {
        tree.motions(black_box(&joints), v_b, w_b, &mut motions);
        black_box(tree.inertia_and_bias(w_b, &motions));
    });
    row(&format!("mechanics of {LINKS} links, {kind}"), 1e6 * body, "us");
    let linkage = Linkage::new(LinkageDimensions::default()).unwrap_or_else(|error| panic!("{error}"));
    let crank = Jet::new(number(0.3, 0), number(22.0, 1), number(0.0, 2));
    let pose = median(batch, || {
        let _ = black_box(linkage.pose(black_box(crank), [Jet::ZERO; 3]));
    });
    row(&format!("linkage of one wing, {kind}"), 1e6 * pose, "us");
}

pub fn rows() {
    times("values", 1000, |x, _| x);
    times("eight derivatives", 200, |x, i| Dual::<8>::variable(x, i % 8));
}
