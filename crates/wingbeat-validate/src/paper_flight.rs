//! The paper's controller and its robot: a horizon in cycles beside the same in seconds, and what the published linkage lifts.

use std::ops::ControlFlow;

use wingbeat::guide::{Flapping, Stand};
use wingbeat::math::{GRAVITY, RK4, Vec3, Workspace};
use wingbeat::plant::Plant;
use wingbeat::robot::Robot;
use wingbeat::scenario::Scenario;

use crate::shipped::{based, scenario};
use crate::{Case, ComparisonRow, Error};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "paper.horizon", quick: true, run: horizon },
    Case { id: "paper.linkage_lift", quick: false, run: linkage_lift },
];

/// The banking turn for .2 s with a horizon of .4375 cycles beside its own of 5 x 25 ms, every column of the record.
fn horizon() -> Result<Vec<ComparisonRow>, Error> {
    let overrides = ["flight.duration_s=0.2"];
    let in_cycles = "without = [\"controller.interval_s\"]\ncontroller.horizon_cycles = 0.4375";
    let fly = |scenario: Scenario| scenario.fly(|_| ControlFlow::Continue(())).map_err(Error::from);
    let seconds = fly(scenario("banking_turn", &overrides)?)?.record;
    let cycles = fly(based("banking_turn", in_cycles, &overrides)?)?.record;
    let mut worst = 0.0_f64;
    for column in seconds.columns() {
        let missing = || Error::reference("paper.horizon", column.name.clone());
        let [a, b] = [&seconds, &cycles].map(|record| record.values(&column.name));
        let (a, b) = (a.ok_or_else(missing)?, b.ok_or_else(missing)?);
        worst = a.iter().zip(b).fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
    }
    let metric = "largest difference of any recorded number, .4375 cycles beside 5 x 25 ms at 3.5 Hz, .2 s";
    let source = "the same horizon in seconds";
    Ok(vec![ComparisonRow::judged("paper.horizon", source, metric, worst, 1e-12, "")])
}

/// Steps of a cycle, and cycles of which the last is averaged. *Choice.*
const STEPS: usize = 120;
const CYCLES: usize = 3;
/// Airspeeds, m/s, and incidences of the body, deg, that are tried.
const SPEEDS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0];
const INCIDENCES: [f64; 5] = [-30.0, -15.0, 0.0, 15.0, 30.0];
/// Shares of its stroke that each regulator is held at, alike on both wings.
const SHARES: [f64; 3] = [-0.95, 0.0, 0.95];

/// A point of the grid with its means over a cycle.
#[derive(Clone, Copy)]
struct GridPoint {
    speed: f64,
    incidence: f64,
    /// Over the weight.
    lift: f64,
    thrust: f64,
}

/// Mean lift and thrust over the last cycle, N, with the regulators of one wing held at `commands`; none where the linkage
/// does not close.
fn means(robot: &Robot, speed: f64, incidence: f64, commands: &[f64]) -> Option<[f64; 2]> {
    let stand = Stand::new(robot, Vec3([speed, 0.0, 0.0]), 0.0).ok()?;
    let pitch = -incidence.to_radians();
    let flapping = Flapping { frequency_hz: robot.frequency_hz(), pitch };
    let mut x = vec![0.0; stand.mirror().states.len()];
    x[..commands.len()].copy_from_slice(commands);
    let mut work = Workspace::new(x.len(), RK4.b.len());
    let h = 1.0 / (robot.frequency_hz() * STEPS as f64);
    let (mut sum, mut aside) = ([0.0; 2], vec![0.0; x.len()]);
    for k in 0..CYCLES * STEPS {
        let t = k as f64 * h;
        if k >= (CYCLES - 1) * STEPS {
            let loads = stand.evaluate(t, &flapping, &x, commands, &mut aside).ok()?;
            let [lift, thrust, _] = stand.lift_thrust_trim(&loads, pitch);
            (sum[0], sum[1]) = (sum[0] + lift / STEPS as f64, sum[1] + thrust / STEPS as f64);
        }
        let rates =
            |t: f64, x: &[f64], dx: &mut [f64]| stand.evaluate(t, &flapping, x, commands, dx).map(|_| ());
        RK4.step(rates, t, h, &mut x, &mut work).ok()?;
    }
    Some(sum)
}

/// The commands of one wing on the grid.
fn commands(robot: &Robot) -> Vec<Vec<f64>> {
    let channels: Vec<_> = robot.inputs().iter().filter(|channel| channel.name.ends_with("_left")).collect();
    let held = |share: f64, low: f64, high: f64| if share < 0.0 { -share * low } else { share * high };
    let grid = SHARES.len().pow(channels.len() as u32);
    let place = |k: usize, j: usize| SHARES[k / SHARES.len().pow(j as u32) % SHARES.len()];
    (0..grid)
        .map(|k| channels.iter().enumerate().map(|(j, c)| held(place(k, j), c.low, c.high)).collect())
        .collect()
}

/// The points of the largest lift: of all, and of those where the air does not hold the robot back.
fn best(law: &str) -> Result<[Option<GridPoint>; 2], Error> {
    let law = format!("aero.law={law}");
    let scenario = scenario("banking_turn_beta", &["aero.preset=full", "aero.full.strips=9", &law])?;
    let robot = scenario.robot();
    let weight = robot.mass() * GRAVITY;
    let mut best: [Option<GridPoint>; 2] = [None, None];
    for commands in commands(robot) {
        for (speed, incidence) in SPEEDS.iter().flat_map(|v| INCIDENCES.iter().map(move |a| (*v, *a))) {
            let Some([lift, thrust]) = means(robot, speed, incidence, &commands) else { continue };
            let point = GridPoint { speed, incidence, lift: lift / weight, thrust: thrust / weight };
            for (best, counts) in best.iter_mut().zip([true, thrust >= 0.0]) {
                if counts && best.is_none_or(|best| point.lift > best.lift) {
                    *best = Some(point);
                }
            }
        }
    }
    Ok(best)
}

/// The largest mean lift of the published linkage at 3.5 Hz under each law, beside the weight of 45 g.
fn linkage_lift() -> Result<Vec<ComparisonRow>, Error> {
    let source =
        "weight of 45 g; incidence +-30 deg, .5 to 3 m/s, regulators over their strokes, preset full";
    let mut rows = Vec::new();
    for law in ["linear", "stall", "lev"] {
        let kinds = [("", "largest mean lift over the weight"), (".pulled", "the same without net drag")];
        for ((end, what), point) in kinds.into_iter().zip(best(law)?) {
            let id = format!("paper.linkage_lift.{law}{end}");
            let metric = point.map_or(format!("{what}: nowhere, law {law}"), |p| {
                let GridPoint { speed, incidence, thrust, .. } = p;
                format!("{what}, law {law}: at {speed} m/s, {incidence} deg, thrust {thrust:.2} of it")
            });
            rows.push(ComparisonRow::shown(&id, source, &metric, point.map_or(0.0, |p| p.lift), ""));
        }
    }
    Ok(rows)
}
