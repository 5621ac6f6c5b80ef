//! Derivatives of loads and rates by the numbers of a robot, against differences.

use crate::aero_full::Preset;
use crate::fsi::flapper;
use crate::{Error, Row};
use wingbeat::aero::LiftLaw;
use wingbeat::math::{Dual, Jet, Mat3, Meets, Quat, Scalar, Vec3};
use wingbeat::plant::Fault;
use wingbeat::robot::{BodyMotion, Robot};

/// The numbers: distal mass and its place, hinge, sections, air, body, gait.
const NUMBERS: [&str; COUNT] = [
    "links.feather.mass_kg",
    "links.feather.com_m[0]",
    "links.feather.inertia_kg_m2[1]",
    "links.feather.elastic.stiffness",
    "links.feather.elastic.damping",
    "surfaces.wing.cd0",
    "surfaces.wing.cd90",
    "surfaces.wing.section_slope",
    "surfaces.wing.stall_angle_rad",
    "surfaces.wing.critical_suction",
    "air.density_kg_m3",
    "body.mass_kg",
    "gait.phase_rad",
    "gait.phase_rate_rad_s",
];
const COUNT: usize = 14;
/// Instants looked at, s.
const TIMES: [f64; 3] = [0.03, 0.11, 0.19];
/// Share of a number by which it is moved for a difference.
const SHARE: f64 = 2e-5;

/// Rates of the flying robot, loads on a carrier and joint efforts, at a state somewhere in flight.
fn outcome<P: Scalar, S: Scalar + Meets<P>>(
    robot: &Robot<P>,
    plain: &Robot,
    t: f64,
) -> Result<Vec<S>, Fault> {
    let (l, n) = (*plain.layout(), plain.layout().len);
    let mut x = vec![0.0; n];
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
    for (i, state) in x[l.structure..].iter_mut().enumerate() {
        *state = 0.12 * (1.7 * i as f64 + 40.0 * t).sin();
    }
    let lifted: Vec<S> = x.iter().map(|state| S::from(*state)).collect();
    let mut all = vec![S::ZERO; n];
    robot.state_rates(S::from(t), &lifted, &[], &mut all)?;
    let body = BodyMotion::steady(
        Mat3::constant(Quat::from_wxyz(&x[l.attitude..]).matrix()),
        Vec3::constant(Vec3::new(2.0, 0.1, -0.3)),
    );
    let mut rates = vec![S::ZERO; robot.carried_states()];
    let clock = Jet::new(S::from(t), S::ONE, S::ZERO);
    let loads = robot.carried(&clock, &body, &lifted[l.structure..], &[], &mut rates)?;
    let wrench = loads.total();
    all.extend(wrench.force.0);
    all.extend(wrench.moment.0);
    all.extend(loads.torques.iter().copied());
    Ok(all)
}

/// The value of a number; of a pair that of the left link.
fn value(robot: &Robot, name: &str) -> Result<f64, Error> {
    let left = name.replacen("feather", "feather_left", 1);
    let named = robot.named_numbers().into_iter().find(|(other, _)| other == name || *other == left);
    named.map(|(_, value)| value).ok_or_else(|| Error::NoAnswer(format!("no number {name}")))
}

/// Numbers varied together: few, as all that an evaluation holds on the stack grows with them.
const TOGETHER: usize = 2;

/// Largest difference of a derivative from the central one over all that is computed, over the largest of that number.
fn error(preset: Preset) -> Result<f64, Error> {
    let robot = flapper(preset, LiftLaw::Lev)?;
    let mut worst = 0.0_f64;
    for pair in NUMBERS.chunks_exact(TOGETHER) {
        let varied = robot.varied::<TOGETHER>([pair[0], pair[1]])?;
        for t in TIMES {
            let exact: Vec<Dual<TOGETHER>> = outcome(&varied, &robot, t)?;
            for (k, name) in pair.iter().enumerate() {
                worst = worst.max(difference(&robot, name, t, exact.iter().map(|e| e.eps[k]))?);
            }
        }
    }
    Ok(worst)
}

/// Largest difference of the `exact` derivatives by the number `name` from the central ones, over the largest of them.
fn difference(robot: &Robot, name: &str, t: f64, exact: impl Iterator<Item = f64>) -> Result<f64, Error> {
    let value = value(robot, name)?;
    let moved = |share: f64| -> Result<Vec<f64>, Error> {
        Ok(outcome(&robot.adjusted(&[(name, value * (1.0 + share))])?, robot, t)?)
    };
    let (high, low) = (moved(SHARE)?, moved(-SHARE)?);
    let near = high.iter().zip(&low).map(|(h, l)| (h - l) / (2.0 * SHARE * value));
    let pairs: Vec<(f64, f64)> = exact.zip(near).collect();
    let scale = pairs.iter().fold(0.0, |m: f64, (e, _)| m.max(e.abs()));
    if scale == 0.0 {
        return Err(Error::NoAnswer(format!("nothing depends on {name}")));
    }
    Ok(pairs.iter().fold(0.0, |m: f64, (e, d)| m.max((e - d).abs() / scale)))
}

/// The row.
pub fn rows() -> Result<Vec<Row>, Error> {
    let worst = error(Preset::Paper)?.max(error(Preset::Full)?);
    let metric = "max error of rates, loads and efforts by 14 numbers of a flapper, both presets, law lev";
    Ok(vec![Row::judged("body.parameter_derivatives", "own central differences", metric, worst, 1e-6, "")])
}
