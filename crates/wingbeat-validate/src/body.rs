//! Linkage and multibody dynamics.

mod elastic;
mod free;
mod numbers;
pub mod urdf;
mod vacuum;

pub use urdf::reference as reference_tree;

use crate::{Case, ComparisonRow, Error, reference_table};
use wingbeat::body::{LinkMotion, Linkage, LinkageDimensions, MAX_LINKS};
use wingbeat::math::{Jet, Quat, Vec3, Wrench};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "linkage.cycle", quick: true, run: linkage_cycle },
    Case { id: "body.momentum_vacuum", quick: true, run: momentum_vacuum },
    Case { id: "body.energy_power_balance", quick: true, run: energy_power_balance },
    Case { id: "body.pinocchio", quick: true, run: pinocchio },
    Case { id: "body.elastic_frequency", quick: true, run: elastic::rows },
    Case { id: "body.multibody_free", quick: true, run: free::rows },
    Case { id: "body.parameter_derivatives", quick: true, run: numbers::rows },
];

/// Angles of one revolution of the crank, degrees.
#[derive(Clone, Debug)]
pub struct CrankAngles {
    /// Crank.
    pub crank: Vec<f64>,
    /// Humerus and radius of the model.
    pub value: [Vec<f64>; 2],
    /// The same of the table.
    pub exact: [Vec<f64>; 2],
}

/// Humerus and radius over a revolution of the crank, beside an independent loop closure.
///
/// # Errors
/// [`Error`] when the table or the linkage fails.
pub fn crank_angles() -> Result<CrankAngles, Error> {
    let table = reference_table!("linkage/cycle.csv")?;
    let crank = table.column_at(0)?;
    let linkage = Linkage::new(LinkageDimensions::default())?;
    let mut value: [Vec<f64>; 2] = Default::default();
    for crank in &crank {
        let pose = linkage.pose(Jet::<f64>::from(crank.to_radians()), [Jet::from(0.0); 3])?;
        value[0].push(pose.humerus.x.to_degrees());
        value[1].push(pose.radius.x.to_degrees());
    }
    Ok(CrankAngles { crank, value, exact: [table.column_at(1)?, table.column_at(2)?] })
}

fn linkage_cycle() -> Result<Vec<ComparisonRow>, Error> {
    let angles = crank_angles()?;
    let pairs = angles.value.iter().flatten().zip(angles.exact.iter().flatten());
    let worst = pairs.map(|(value, exact)| (value - exact).abs()).fold(0.0, f64::max);
    let metric = "max error of humerus and radius angle";
    Ok(vec![ComparisonRow::judged(
        "linkage.cycle",
        "independent loop closure by Newton",
        metric,
        worst,
        1e-3,
        "deg",
    )])
}

fn momentum_vacuum() -> Result<Vec<ComparisonRow>, Error> {
    let flight = vacuum::VacuumCycle::one_cycle(reference_tree()?, Vec3::ZERO)?;
    let drift = |before: Vec3, after: Vec3| (after - before).norm() / before.norm();
    let linear = drift(flight.before.linear, flight.after.linear);
    let angular = drift(flight.before.angular, flight.after.angular);
    let metric = "relative drift of linear and angular momentum over one cycle";
    let source = "conservation of momentum";
    Ok(vec![ComparisonRow::judged("body.momentum_vacuum", source, metric, linear.max(angular), 1e-9, "")])
}

fn energy_power_balance() -> Result<Vec<ComparisonRow>, Error> {
    let gravity = Vec3([0.0, 0.0, -wingbeat::math::GRAVITY]);
    let flight = vacuum::VacuumCycle::one_cycle(reference_tree()?, gravity)?;
    let change = flight.after.energy - flight.before.energy;
    let error = (flight.work - change).abs() / flight.peak_work;
    let metric = "work of joint torques less change of energy, over the peak work";
    Ok(vec![ComparisonRow::judged(
        "body.energy_power_balance",
        "conservation of energy",
        metric,
        error,
        1e-8,
        "",
    )])
}

/// State, efforts and accelerations of the reference tree; Pinocchio's numbers.
#[derive(Clone, Debug)]
struct ReferenceState {
    attitude: Quat,
    /// Velocity of the base in its own frame, m/s.
    v: Vec3,
    /// Its angular rate, rad/s.
    w: Vec3,
    /// Joint angles, their rates and accelerations, rad.
    q: [f64; 4],
    qd: [f64; 4],
    qdd: [f64; 4],
    /// Joint efforts, N m.
    efforts: [f64; 4],
    /// Acceleration of the base: linear, spatial (a - w x v), then angular.
    base: Vec<f64>,
    /// Gravity, m/s2.
    gravity: f64,
}

fn reference() -> Result<ReferenceState, Error> {
    let q = reference_table!("multibody/ref_q.txt")?.column_at(0)?;
    let v = reference_table!("multibody/ref_v.txt")?.column_at(0)?;
    let efforts = reference_table!("multibody/ref_tau.txt")?.column_at(0)?;
    let accelerations = reference_table!("multibody/ref_qdd_pin_local.txt")?.column_at(0)?;
    let joints = |column: &[f64], first: usize| std::array::from_fn(|i| column[first + i]);
    Ok(ReferenceState {
        // The table has x, y, z, w.
        attitude: Quat::from_wxyz(&[q[6], q[3], q[4], q[5]]),
        v: Vec3::from_slice(&v),
        w: Vec3::from_slice(&v[3..]),
        q: joints(&q, 7),
        qd: joints(&v, 6),
        qdd: joints(&accelerations, 6),
        efforts: joints(&efforts, 6),
        base: accelerations[..6].to_vec(),
        // Pinocchio's default.
        gravity: 9.81,
    })
}

/// Accelerations of the reference tree beside Pinocchio's: base linear and angular (m/s2, rad/s2), then
/// the joints (rad/s2).
///
/// # Errors
/// [`Error`] when a table or the tree fails.
pub fn tree_accelerations() -> Result<Vec<(f64, f64)>, Error> {
    let (tree, reference) = (reference_tree()?, reference()?);
    let (v_b, w_b) = (reference.v, reference.w);
    let joints: Vec<Jet> =
        reference.q.iter().zip(&reference.qd).map(|(q, v)| Jet::new(*q, *v, 0.0)).collect();
    let mut motions = [LinkMotion::default(); MAX_LINKS];
    tree.motions(&joints, v_b, w_b, &mut motions);
    let g_b = reference.attitude.matrix().transpose_mul(Vec3([0.0, 0.0, -reference.gravity]));
    let found = tree
        .forward_dynamics(w_b, &motions, &reference.efforts, g_b, Wrench::ZERO, &[Wrench::ZERO; 4])
        .ok_or_else(|| Error::NoAnswer("the mass matrix is not positive definite".into()))?;

    let linear = found.base.origin - w_b.cross(v_b);
    let all = linear.0.iter().chain(&found.base.angular.0).chain(&found.joints);
    Ok(all.copied().zip(reference.base.iter().chain(&reference.qdd).copied()).collect())
}

fn pinocchio() -> Result<Vec<ComparisonRow>, Error> {
    let error = |(a, b): (f64, f64)| (a - b).abs() / b.abs();
    let worst = tree_accelerations()?.into_iter().map(error).fold(0.0, f64::max);
    let source = "Pinocchio 4.1 and MuJoCo 4.0 (agreeing to 1e-15)";
    let metric = "max relative error of the 10 accelerations, joints free";
    Ok(vec![ComparisonRow::judged("body.pinocchio", source, metric, worst, 1e-10, "")])
}
