//! Periodic flight: the orbits of the shipped scenarios close, hold as their multipliers say, and keep their energy.

mod bounding;
mod drift;
mod lattice;
mod level;
mod random;
pub mod replay;

pub(crate) use lattice::cycles as replayed;
pub(crate) use replay::InstantLoads;

use std::ops::ControlFlow;

use wingbeat::math::{RK4, Workspace};
use wingbeat::orbit::{Cycle, Direction, Orbit, OrbitSection, Point, floquet, measure};
use wingbeat::plant::{Fault, Plant};
use wingbeat::scenario::{ConfigError, Scenario, Trimmed};

use crate::shipped::{Shipped, scenario};
use crate::{Case, ComparisonRow, Error, LongCase};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "trim.residual", quick: true, run: residual },
    Case { id: "trim.floquet", quick: false, run: multipliers },
    Case { id: "trim.energy", quick: true, run: energy },
    Case { id: "trim.drift", quick: false, run: drift::rows },
    Case { id: "trim.replay", quick: false, run: lattice::own },
    Case { id: "trim.random", quick: false, run: random::rows },
    Case { id: "trim.cruise_20g", quick: false, run: || level::driven("cruise_20g", 80.0, [6.0, 0.10]) },
    Case {
        id: "trim.cruise_20g_lev",
        quick: false,
        run: || level::driven("cruise_20g_lev", 80.0, [6.0, 0.10]),
    },
    Case { id: "trim.cruise_44g", quick: false, run: || level::driven("cruise_44g", 95.0, [8.0, 0.10]) },
    Case { id: "trim.cruise_beta", quick: false, run: || level::driven("cruise_beta", 100.0, [10.5, 0.15]) },
    Case {
        id: "trim.cruise_44g_lev",
        quick: false,
        run: || level::driven("cruise_44g_lev", 95.0, [8.0, 0.10]),
    },
    Case {
        id: "trim.cruise_beta_lev",
        quick: false,
        run: || level::driven("cruise_beta_lev", 100.0, [10.5, 0.15]),
    },
    Case { id: "trim.bounding_20g", quick: false, run: bounding::rows },
    Case { id: "trim.passive_20g", quick: false, run: || level::passive("passive_20g", 85.0) },
    Case { id: "trim.passive_linkage", quick: false, run: || level::passive("passive_linkage", 140.0) },
];

/// Those that take minutes.
pub const LONG: &[LongCase] = &[LongCase { id: "trim.lattice", core_minutes: 5.0, run: lattice::rows }];

/// Level flight of 20 g with a driven twist, and with a twist that the air moves.
const DRIVEN: Shipped = "cruise_20g";
const PASSIVE: Shipped = "passive_20g";

/// The orbit of a shipped scenario with what `trim` says of it.
fn trimmed(shipped: Shipped, overrides: &[&str]) -> Result<Trimmed, Error> {
    let refused = |e: ConfigError| Error::reference(shipped, e.to_string());
    let trimmed = scenario(shipped, overrides)?.trim(&mut |_| ControlFlow::Continue(())).map_err(refused)?;
    match &trimmed.summary.reason {
        Some(reason) => Err(Error::NoAnswer(reason.clone())),
        None => Ok(trimmed),
    }
}

fn found(scenario: &Scenario, cycle: &Cycle) -> Result<Orbit, Error> {
    let found = scenario.find_orbit(cycle, &mut |_, _| ControlFlow::Continue(()))?;
    found.map(|found| found.orbit).map_err(|failure| Error::NoAnswer(failure.to_string()))
}

/// How far a cycle ends from its begin, and speed and climb from what was asked.
fn residual() -> Result<Vec<ComparisonRow>, Error> {
    let (id, source) = ("trim.residual", "definition of a periodic flight");
    let mut worst: f64 = 0.0;
    let mut rows = Vec::new();
    for (shipped, name) in [(DRIVEN, "driven"), (PASSIVE, "passive")] {
        let scenario = scenario(shipped, &[])?;
        let cycle = scenario.cycle()?;
        let orbit = found(&scenario, &cycle)?;
        let end = cycle.end(&orbit.point)?;
        let returns = end.z.iter().zip(&orbit.point.z).map(|(a, b)| a - b);
        let speed = end.displacement[0] / end.duration - orbit.course.speed;
        let climb = end.displacement[2] / end.duration - orbit.course.climb;
        worst = returns.chain([speed, climb, end.heading]).fold(worst, |most, r| most.max(r.abs()));
        let lift = measure(&cycle, &orbit, &[])?.lift_over_weight;
        rows.push(ComparisonRow::judged(
            &format!("{id}.lift_{name}"),
            "mean force of the air = weight",
            &format!("lift over weight less 1, 20 g, twist {name}"),
            (lift - 1.0).abs(),
            1e-3,
            "",
        ));
        let finer = self::scenario(shipped, &["trim.step_s=2.5e-4"])?;
        let cycle = finer.cycle()?;
        let moved = 1.0 / found(&finer, &cycle)?.end.duration - 1.0 / orbit.end.duration;
        rows.push(ComparisonRow::judged(
            &format!("{id}.step_{name}"),
            "own steps of .5 and .25 ms",
            &format!("change of the frequency, twist {name}"),
            moved.abs(),
            1e-4,
            "Hz",
        ));
    }
    let metric =
        "largest difference of the state after a cycle, of speed and climb, twist driven and passive";
    rows.insert(0, ComparisonRow::judged(&format!("{id}.closure"), source, metric, worst, 1e-10, "SI"));
    Ok(rows)
}

/// Step of the central differences.
const STEP: f64 = 1e-5;
/// Disturbance that is flown.
const DISTURBANCE: f64 = 1e-6;
/// Cycles for which it is flown.
const CYCLES: usize = 10;

fn moved(point: &Point, direction: &Direction, step: f64) -> Point {
    let mut point = point.clone();
    direction.iter().for_each(|(i, share)| point.z[*i] += share * step);
    point
}

/// The monodromy against central differences, and a disturbance flown against its powers.
fn multipliers() -> Result<Vec<ComparisonRow>, Error> {
    let id = "trim.floquet";
    let scenario = scenario(PASSIVE, &[])?;
    let cycle = scenario.cycle()?;
    let orbit = found(&scenario, &cycle)?;
    let section: &OrbitSection = cycle.section();
    let directions = [section.symmetric(), section.antisymmetric()].concat();
    let along = |z: &[f64]| directions.iter().map(|d| OrbitSection::along(d, z)).collect::<Vec<f64>>();
    let (_, monodromy) = cycle.differentiate(&orbit.point, &directions, &[], |_, end| {
        directions.iter().map(|d| OrbitSection::along(d, &end.z)).collect()
    })?;
    let largest = monodromy.iter().flatten().fold(0.0, |most: f64, m| most.max(m.abs()));
    let mut worst: f64 = 0.0;
    for (j, direction) in directions.iter().enumerate() {
        let high = along(&cycle.end(&moved(&orbit.point, direction, STEP))?.z);
        let low = along(&cycle.end(&moved(&orbit.point, direction, -STEP))?.z);
        for (i, row) in monodromy.iter().enumerate() {
            worst = worst.max((row[j] - (high[i] - low[i]) / (2.0 * STEP)).abs() / largest);
        }
    }
    // Every coordinate disturbed at once, in the units of the coordinates.
    let mut linear: Vec<f64> = (0..directions.len()).map(|i| DISTURBANCE * (1.0 + 0.1 * i as f64)).collect();
    let mut point = orbit.point.clone();
    for (direction, step) in directions.iter().zip(&linear) {
        point = moved(&point, direction, *step);
    }
    for _ in 0..CYCLES {
        point.z = cycle.end(&point)?.z;
        linear = monodromy.iter().map(|row| row.iter().zip(&linear).map(|(m, d)| m * d).sum()).collect();
    }
    let flown: Vec<f64> = along(&point.z).iter().zip(along(&orbit.point.z)).map(|(a, b)| a - b).collect();
    let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let apart: Vec<f64> = flown.iter().zip(&linear).map(|(a, b)| a - b).collect();
    let modes = floquet(&cycle, &orbit)?;
    Ok(vec![
        ComparisonRow::judged(
            &format!("{id}.monodromy"),
            "own central differences",
            "max error of the derivative of the flow over a cycle, over its largest entry",
            worst,
            1e-6,
            "",
        ),
        ComparisonRow::judged(
            &format!("{id}.flown"),
            "a disturbance of 1e-6 flown ten cycles",
            "difference from the tenth power of the monodromy, relative",
            size(&apart) / size(&linear),
            1e-3,
            "",
        ),
        ComparisonRow::judged(
            &format!("{id}.sectors"),
            "symmetry",
            "largest derivative that leads from flight in the plane of symmetry out of it, or back",
            modes.coupling,
            1e-12,
            "",
        ),
    ])
}

/// Steps of the energy's integral for every step of the orbit.
const FINER: usize = 4;

/// Work of drives, dampers and air over a cycle less the growth of the energy, over the work of the drives.
fn imbalance(shipped: Shipped) -> Result<f64, Error> {
    let scenario = scenario(shipped, &[])?;
    let cycle = scenario.cycle()?;
    let orbit = found(&scenario, &cycle)?;
    let robot = cycle.robot().paced(orbit.point.pace);
    let (n, u) = (robot.states().len(), &orbit.point.inputs);
    let mut x = cycle.start(&orbit.point);
    let energy = |x: &[f64], t: f64| -> Result<f64, Fault> { Ok(robot.observe(t, &x[..n], u)?.energy) };
    let before = energy(&x, 0.0)?;
    // Two more states: the work of all, and the positive work of the joints.
    x.extend([0.0, 0.0]);
    let mut rates = |t: f64, x: &[f64], dx: &mut [f64]| -> Result<(), Fault> {
        robot.rates_in_numbers(t, &x[..n], u, &mut dx[..n])?;
        let seen = robot.observe(t, &x[..n], u)?;
        dx[n] = seen.power + seen.air_power - seen.dissipation;
        dx[n + 1] = seen.power.max(0.0);
        Ok(())
    };
    let steps = FINER * cycle.steps();
    let step = orbit.end.duration / steps as f64;
    let mut work = Workspace::new(x.len(), RK4.b.len());
    for k in 0..steps {
        RK4.step(&mut rates, k as f64 * step, step, &mut x, &mut work)?;
    }
    let grown = energy(&x, orbit.end.duration)? - before;
    Ok((x[n] - grown).abs() / x[n + 1])
}

fn energy() -> Result<Vec<ComparisonRow>, Error> {
    let metric = "work over a cycle less the growth of the energy, over the work of the drives, twist driven and passive";
    let worst = imbalance(DRIVEN)?.max(imbalance(PASSIVE)?);
    Ok(vec![ComparisonRow::judged("trim.energy", "conservation of energy", metric, worst, 1e-8, "")])
}
