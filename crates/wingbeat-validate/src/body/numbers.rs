//! Derivatives of loads and rates by the numbers of a robot, against differences.

use crate::shipped::{Shipped, scenario};
use crate::{ComparisonRow, Error};
use std::collections::BTreeSet;
use wingbeat::math::{Jet, Mat3, Quat, Scalar, Vec3};
use wingbeat::plant::{Fault, Plant};
use wingbeat::robot::{BodyMotion, CarriedLoads, Robot, TOGETHER, Varying};

/// Between them they have every kind of number: motor, series, elastic hinges, matrices of the structure, two surfaces;
/// and a linkage with independent elements.
const FLOWN: [Shipped; 2] = ["motor_flapper", "glide"];

/// Instants looked at, s.
const TIMES: [f64; 3] = [0.03, 0.11, 0.19];
/// Shares of a number, or of the size of such numbers, by which it is moved for a difference: a linkage near its dead
/// centre asks for small steps, what moves little for large ones. The best of them judges.
const SHARES: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
/// Sizes of numbers by what their names hold: a step must not hang on a value that happens to be small.
const SIZES: [(&str, f64); 5] =
    [("inertia", 1e-8), ("_m[", 1e-2), ("_m", 1e-2), ("mass_kg", 1e-4), ("rad", 0.3)];

/// Share of the largest result that a number moves by its whole size only by rounding: the length of a direction.
const NOTHING: f64 = 1e-9;

/// The robot of a shipped scenario.
fn robot(flown: Shipped, preset: &str) -> Result<Robot, Error> {
    let preset = format!("aero.preset={preset}");
    Ok(scenario(flown, &[&preset, "aero.law=lev", "flight.flapping=true"])?.robot().clone())
}

/// A state somewhere in flight: elements displaced by a tenth of a radian, or of what lengths are, and all else moving.
fn state(robot: &Robot, t: f64) -> Vec<f64> {
    let l = *robot.layout();
    let mut x = vec![0.0; l.len];
    Quat::from_roll_pitch_yaw(0.2, -0.3, 0.4).store_wxyz(&mut x[l.attitude..]);
    Vec3::new(2.0, 0.1, -0.3).store(&mut x[l.velocity..]);
    Vec3::new(0.4, -0.8, 0.5).store(&mut x[l.rate..]);
    let start = robot.start_coordinates();
    x[l.joints..][..start.len()].copy_from_slice(&start);
    for (i, (state, channel)) in x.iter_mut().zip(robot.states()).enumerate().skip(l.structure) {
        let size = if i < l.joints && channel.unit.starts_with('m') { 2e-4 } else { 0.12 };
        *state += size * (1.7 * (i - l.structure) as f64 + 40.0 * t).sin();
    }
    x
}

/// A robot in numbers with or without derivatives.
trait Computes<S: Scalar> {
    fn rates(&self, t: f64, x: &[S], u: &[S], dx: &mut [S]) -> Result<(), Fault>;
    fn carried(
        &self,
        clock: &Jet<S>,
        body: &BodyMotion<S>,
        x: &[S],
        u: &[S],
        dx: &mut [S],
    ) -> Result<CarriedLoads<S>, Fault>;
}

impl Computes<f64> for Robot {
    fn rates(&self, t: f64, x: &[f64], u: &[f64], dx: &mut [f64]) -> Result<(), Fault> {
        self.rates_in_numbers(t, x, u, dx)
    }
    fn carried(
        &self,
        clock: &Jet<f64>,
        body: &BodyMotion<f64>,
        x: &[f64],
        u: &[f64],
        dx: &mut [f64],
    ) -> Result<CarriedLoads<f64>, Fault> {
        self.carried_in_numbers(clock, body, x, u, dx)
    }
}

impl Computes<Varying> for Robot<Varying> {
    fn rates(&self, t: f64, x: &[Varying], u: &[Varying], dx: &mut [Varying]) -> Result<(), Fault> {
        self.rates_in_varying(t, x, u, dx)
    }
    fn carried(
        &self,
        clock: &Jet<Varying>,
        body: &BodyMotion<Varying>,
        x: &[Varying],
        u: &[Varying],
        dx: &mut [Varying],
    ) -> Result<CarriedLoads<Varying>, Fault> {
        self.carried_in_varying(clock, body, x, u, dx)
    }
}

/// Rates of the flying robot, loads on a carrier and joint efforts, at a state somewhere in flight.
fn outcome<S: Scalar>(robot: &impl Computes<S>, plain: &Robot, t: f64) -> Result<Vec<S>, Fault> {
    let (l, x) = (*plain.layout(), state(plain, t));
    let u: Vec<S> = plain.inputs().iter().map(|input| S::from(0.1 * input.low)).collect();
    let lifted: Vec<S> = x.iter().map(|state| S::from(*state)).collect();
    let mut all = vec![S::ZERO; l.len];
    robot.rates(t, &lifted, &u, &mut all)?;
    let body = BodyMotion::steady(
        Mat3::constant(Quat::from_wxyz(&x[l.attitude..]).matrix()),
        Vec3::constant(Vec3::new(2.0, 0.1, -0.3)),
    );
    let mut rates = vec![S::ZERO; plain.carried_states()];
    let clock = Jet::new(S::from(t), S::ONE, S::ZERO);
    let loads = robot.carried(&clock, &body, &lifted[l.structure..], &u, &mut rates)?;
    let wrench = loads.total();
    all.extend(wrench.force.0);
    all.extend(wrench.moment.0);
    all.extend(loads.torques.iter().copied());
    Ok(all)
}

/// Arcs of stations on which a hinge lies: the chord there has a kink, and no derivative by either.
fn on_a_kink(name: &str, values: &[(String, f64)]) -> bool {
    let arc = |name: &str| {
        let (surface, key) = name.strip_prefix("surfaces.")?.split_once('.')?;
        let station = key.starts_with("planform[") && key.ends_with(".arc_m");
        (station || key.ends_with(".from_arc_m")).then(|| (surface.to_string(), station))
    };
    let value = |name: &str| values.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
    let Some((surface, station)) = arc(name) else { return false };
    let meets = |(other, at): &(String, f64)| {
        arc(other).is_some_and(|(of, is_station)| of == surface && is_station != station)
            && value(name).is_some_and(|value| (value - at).abs() < 1e-9)
    };
    values.iter().any(meets)
}

/// The worst derivative, and how many numbers moved anything.
struct WorstDerivative {
    worst: f64,
    name: String,
    moving: usize,
    all: usize,
}

/// Largest difference of a derivative from the central one over all that is computed, over the largest of that number.
fn compare(robot: &Robot) -> Result<WorstDerivative, Error> {
    let values = robot.named_numbers();
    let smooth = values.iter().map(|(name, _)| name.as_str()).filter(|name| !on_a_kink(name, &values));
    let names: Vec<&str> = smooth.collect::<BTreeSet<_>>().into_iter().collect();
    let mut found = WorstDerivative { worst: 0.0, name: String::new(), moving: 0, all: names.len() };
    let judged = robot.in_batches(
        &names,
        |_| false,
        |varied, names| -> Result<(), Error> {
            let mut moving = [false; TOGETHER];
            for t in TIMES {
                let exact: Vec<Varying> = outcome(&varied, robot, t)?;
                for (k, &name) in names.iter().enumerate() {
                    let Some(error) = difference(robot, name, t, exact.iter().map(|e| e.eps[k]))? else {
                        continue;
                    };
                    moving[k] = true;
                    if error > found.worst {
                        (found.worst, found.name) = (error, name.into());
                    }
                }
            }
            found.moving += moving.iter().filter(|moving| **moving).count();
            Ok(())
        },
    )?;
    judged.into_iter().collect::<Result<Vec<_>, _>>()?;
    Ok(found)
}

/// Largest difference of the `exact` derivatives by the number `name` from the central ones of fourth order, over the
/// largest of them; none where nothing depends on it.
fn difference(
    robot: &Robot,
    name: &str,
    t: f64,
    exact: impl Iterator<Item = f64>,
) -> Result<Option<f64>, Error> {
    let named = robot.named_numbers().into_iter().find(|(other, _)| other == name);
    let value = named.map_or(0.0, |(_, value)| value);
    let size = SIZES.iter().find(|(part, _)| name.contains(part)).map_or(0.0, |(_, size)| *size);
    let span = value.abs().max(size);
    if span == 0.0 {
        return Ok(None);
    }
    let exact: Vec<f64> = exact.collect();
    let mut best: Option<f64> = None;
    for share in SHARES {
        if let Some(error) = apart(robot, (name, value, span, share), t, &exact)? {
            best = Some(best.map_or(error, |best| best.min(error)));
        }
    }
    Ok(best)
}

/// The same with one step.
fn apart(
    robot: &Robot,
    (name, value, span, share): (&str, f64, f64, f64),
    t: f64,
    exact: &[f64],
) -> Result<Option<f64>, Error> {
    let step = share * span;
    let moved = |steps: f64| -> Result<Vec<f64>, Error> {
        let numbers = robot.given(&[(name, value + steps * step)])?;
        Ok(outcome(&robot.with(&numbers)?, robot, t)?)
    };
    let near = [moved(1.0)?, moved(-1.0)?, moved(2.0)?, moved(-2.0)?];
    let largest = near[0].iter().fold(0.0, |m: f64, value| m.max(value.abs()));
    let near = |i: usize| (8.0 * (near[0][i] - near[1][i]) - (near[2][i] - near[3][i])) / (12.0 * step);
    let pairs: Vec<(f64, f64)> = exact.iter().enumerate().map(|(i, exact)| (*exact, near(i))).collect();
    let scale = pairs.iter().fold(0.0, |m: f64, (e, d)| m.max(e.abs()).max(d.abs()));
    let worst = pairs.iter().fold(0.0, |m: f64, (e, d)| m.max((e - d).abs()));
    Ok((scale * span > NOTHING * largest).then(|| worst / scale))
}

/// The row.
pub fn rows() -> Result<Vec<ComparisonRow>, Error> {
    let mut all = WorstDerivative { worst: 0.0, name: String::new(), moving: 0, all: 0 };
    for flown in FLOWN {
        for preset in ["paper", "full"] {
            let found = compare(&robot(flown, preset)?)?;
            if found.worst > all.worst {
                (all.worst, all.name) = (found.worst, found.name);
            }
            (all.moving, all.all) = (all.moving + found.moving, all.all + found.all);
        }
    }
    let metric = format!(
        "max error of rates, loads and efforts by each number of a flapper with motor, regulators, elastic hinges and \
         tail, and of a linkage robot, both presets, law lev ({} of {} numbers move something)",
        all.moving, all.all
    );
    Ok(vec![ComparisonRow::judged(
        "body.parameter_derivatives",
        "own central differences",
        &metric,
        all.worst,
        1e-6,
        "",
    )])
}
