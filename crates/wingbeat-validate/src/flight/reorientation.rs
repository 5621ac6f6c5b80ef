//! Half a turn in a vacuum: what is asked of it, and the turn by quadrature of the wings' motion.

use std::ops::ControlFlow;

use wingbeat::judge::Status;
use wingbeat::math::{Mat3, Vec3};
use wingbeat::orbit::SKIN;
use wingbeat::scenario::PlanSummary;
use wingbeat::simulate::Record;

use super::values;
use crate::shipped::scenario;
use crate::{ComparisonRow, Error};

/// What is asked: deg, s, kg m2/s.
const TURNED: f64 = 150.0;
const WITHIN: f64 = 0.5;
const MOMENTUM: f64 = 1e-9;
/// Largest difference of the turn from the quadrature over 200 intervals, deg.
const QUADRATURE: f64 = 0.2;

/// A rigid part: mass, centre of mass, principal inertia.
struct RigidPart {
    mass: f64,
    com: Vec3,
    inertia: [f64; 3],
}

/// Body, arm and hand of `flip_20g`; the left wing from its shoulder, before sweep and stroke.
const SHOULDER: Vec3 = Vec3([0.0, 0.0207, 0.0075]);
const BODY: RigidPart =
    RigidPart { mass: 0.010, com: Vec3([-0.00062, 0.0, 0.00062]), inertia: [9.4e-6, 2.97e-5, 2.97e-5] };
const WING: [RigidPart; 2] = [
    RigidPart { mass: 0.001, com: Vec3([0.0, 0.025, 0.0]), inertia: [2.083e-7, 0.0, 2.083e-7] },
    RigidPart { mass: 0.004, com: Vec3([0.020, 0.100, 0.0]), inertia: [5.81e-6, 4.72e-6, 1.053e-5] },
];

/// Parts of body and left wing about the plane of symmetry at stroke and sweep, rad: centre of mass, mass that counts (both wings), and
/// inertia with its axes.
fn parts(stroke: f64, sweep: f64) -> [(Vec3, f64, Mat3, [f64; 3]); 3] {
    let turn = Mat3::rotation_x(stroke) * Mat3::rotation_z(-sweep);
    let wing = |k: usize| {
        (SHOULDER + turn * WING[k].com, 2.0 * WING[k].mass, turn, WING[k].inertia.map(|i| 2.0 * i))
    };
    [(BODY.com, BODY.mass, Mat3::IDENTITY, BODY.inertia), wing(0), wing(1)]
}

/// The turn about y by the motion of the wings between rows, rad: sum of -h/I with the angular momentum h about the centre of mass of a body
/// that does not turn, by the midpoint rule (Kane & Scher 1969: the momentum is zero throughout).
fn quadrature(stroke: &[f64], sweep: &[f64]) -> f64 {
    let mass = BODY.mass + 2.0 * (WING[0].mass + WING[1].mass);
    let about = |parts: &[(Vec3, f64, Mat3, [f64; 3]); 3]| {
        let com = parts.iter().fold(Vec3::ZERO, |sum, part| sum + part.0 * (part.1 / mass));
        parts.map(|part| part.0 - com)
    };
    let mut turned = 0.0;
    for k in 1..stroke.len() {
        let [a, b] = [k - 1, k].map(|k| about(&parts(stroke[k], sweep[k])));
        let middle = [0.5 * (stroke[k] + stroke[k - 1]), 0.5 * (sweep[k] + sweep[k - 1])];
        let now = parts(middle[0], middle[1]);
        let (r, spin) = (about(&now), Vec3::new(stroke[k] - stroke[k - 1], 0.0, 0.0));
        let sweeping = Mat3::rotation_x(middle[0]) * Vec3::new(0.0, 0.0, sweep[k - 1] - sweep[k]);
        let (mut momentum, mut inertia) = (0.0, 0.0);
        for (i, (_, mass, turn, principal)) in now.iter().enumerate() {
            let way = b[i] - a[i];
            momentum += mass * r[i].cross(way)[1];
            inertia += mass * (r[i][0].powi(2) + r[i][2].powi(2));
            let apply = |w: Vec3| {
                let own = turn.transpose_mul(w);
                *turn * Vec3(std::array::from_fn(|i| principal[i] * own[i]))
            };
            inertia += apply(Vec3::new(0.0, 1.0, 0.0))[1];
            if i > 0 {
                momentum += apply(spin + sweeping)[1];
            }
        }
        turned -= momentum / inertia;
    }
    turned
}

/// Plans and flies the shipped scenario.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let of = scenario("reorientation", &[])?;
    let planned = of.plan(&mut |_| ControlFlow::Continue(()))?;
    let (PlanSummary::RollIn(summary), Some(record)) = (&planned.summary, &planned.record) else {
        return Err(Error::reference("reorientation", "no plan was flown"));
    };
    let met = f64::from(u8::from(summary.solver.verdict.status != Status::Ok));
    let turned = pitched(record)?;
    let column = |name: &str| values(record, name);
    let alone = quadrature(column("shoulder_left")?, column("sweep_left")?);
    let asked = "what is asked of the turn";
    let row = |end: &str, source: &str, metric: &str, value: f64, limit: f64, unit| {
        ComparisonRow::judged(&format!("flight.reorientation.{end}"), source, metric, value, limit, unit)
    };
    let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
    Ok(vec![
        row("verdict", asked, "0 where the plan ends `ok`", met, 0.0, ""),
        row(
            "turn",
            asked,
            "150 deg nose up less the turn as it was flown",
            TURNED + turned.to_degrees(),
            0.0,
            "deg",
        ),
        row("duration", asked, "duration", number(summary.duration_s), WITHIN, "s"),
        row(
            "momentum",
            asked,
            "largest angular momentum about the centre of mass",
            momentum(record)?,
            MOMENTUM,
            "kg m2/s",
        ),
        row(
            "clearance",
            asked,
            "3 mm of skin less the least clearance",
            SKIN - number(summary.least_clearance_m),
            0.0,
            "m",
        ),
        row(
            "quadrature",
            "Kane & Scher 1969",
            "turn as it was flown less the sum of -h/I over the motion of the wings",
            (turned - alone).abs().to_degrees(),
            QUADRATURE,
            "deg",
        ),
    ])
}

/// Largest angular momentum about the centre of mass over a record, kg m2/s.
fn momentum(record: &Record) -> Result<f64, Error> {
    let [x, y, z] = ["x", "y", "z"].map(|axis| values(record, &format!("angular_momentum_{axis}")));
    let (x, y, z) = (x?, y?, z?);
    Ok((0..x.len()).map(|row| Vec3::new(x[row], y[row], z[row]).norm()).fold(0.0, f64::max))
}

/// The turn about the body's y axis over a record, rad: that of a body that turns about it alone.
fn pitched(record: &Record) -> Result<f64, Error> {
    let [w, y] = ["quat_w", "quat_y"].map(|name| values(record, name));
    let half: Vec<f64> = w?.iter().zip(y?).map(|(w, y)| y.atan2(*w)).collect();
    let way = |pair: &[f64]| {
        let step = pair[1] - pair[0];
        2.0 * (step - std::f64::consts::PI * (step / std::f64::consts::PI).round())
    };
    Ok(half.windows(2).map(way).sum())
}
