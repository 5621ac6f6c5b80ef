//! The banking turn flown with preset `full`: convergence with the step, the fastest slope of the lags, and what of
//! its end depends on the choices of the model.

use crate::aero_full::{ComparedPreset, E1, F2, last_cycle};
use crate::shipped::scenario;
use crate::{Case, ComparisonRow, Error};
use std::ops::ControlFlow;
use wingbeat::plant::{Linearisation, Plant};
use wingbeat::scenario::{Run, Scenario};

/// The comparisons.
pub const CASES: &[Case] = &[
    Case { id: "aero.convergence.step", quick: false, run: steps },
    Case { id: "aero.convergence.strips", quick: true, run: strips },
    Case { id: "aero.convergence.lag_slope", quick: false, run: lag_slope },
    Case { id: "aero.convergence.spread", quick: false, run: spread },
];

const SOURCE: &str = "own steps of .2, .1 and .05 ms";

/// The turn of `scenarios/banking_turn.toml` with preset `full`.
pub(crate) fn turn(overrides: &[String]) -> Result<Scenario, Error> {
    let all: Vec<&str> =
        ["aero.preset=full"].into_iter().chain(overrides.iter().map(String::as_str)).collect();
    scenario("banking_turn", &all)
}

fn flown(overrides: &[String]) -> Result<Run, Error> {
    let run = turn(overrides)?.fly(|_| ControlFlow::Continue(()))?;
    let ended = run.record.values("t").and_then(|t| t.last().copied());
    match &run.summary.reason {
        Some(reason) if ended.is_none() => Err(Error::NoAnswer(reason.to_string())),
        _ => Ok(run),
    }
}

/// Where the body's centre of mass is, m, and how it lies, rad, at the time `t`, s.
fn pose(run: &Run, t: f64) -> Result<[f64; 6], Error> {
    let lost = || Error::NoAnswer(format!("the flight did not last {t} s"));
    let times = run.record.values("t").ok_or_else(lost)?;
    let row = times.iter().position(|at| (at - t).abs() < 1e-9).ok_or_else(lost)?;
    let mut pose = [0.0; 6];
    for (value, name) in pose.iter_mut().zip(["com_x", "com_y", "com_z", "roll", "pitch", "yaw"]) {
        *value = run.record.values(name).ok_or_else(lost)?[row];
    }
    Ok(pose)
}

fn apart(a: [f64; 6], b: [f64; 6]) -> f64 {
    a.iter().zip(b).fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

/// Order in the step, and what the step still moves at 1 and 5 s.
fn steps() -> Result<Vec<ComparisonRow>, Error> {
    let fly = |step: &str| flown(&[format!("flight.step_s={step}"), "flight.record_every_s=0.005".into()]);
    let runs = [fly("2e-4")?, fly("1e-4")?, fly("5e-5")?];
    let id = |name: &str| format!("aero.convergence.step.{name}");
    let mut rows = Vec::new();
    for (name, t, limit) in [("1s", 1.0, 1e-8), ("5s", 5.0, 1e-5)] {
        let [coarse, middle, fine] = [pose(&runs[0], t)?, pose(&runs[1], t)?, pose(&runs[2], t)?];
        let moved = apart(middle, fine);
        let metric = format!(
            "turn with preset full: largest change of place (m) or attitude (rad) at {t} s, steps of .1 to .05 ms"
        );
        rows.push(ComparisonRow::judged(&id(name), SOURCE, &metric, moved, limit, ""));
        if t == 5.0 {
            let order = (apart(coarse, middle) / moved).log2();
            rows.push(ComparisonRow::order(&id("order"), SOURCE, order, 4.0, 0.5));
        }
    }
    Ok(rows)
}

/// Lift of large flapping with 8, 16 and 32 strips: what doubling them moves, and the order.
fn strips() -> Result<Vec<ComparisonRow>, Error> {
    let mut rows = Vec::new();
    for (name, flap) in [("F2", F2), ("E1", E1)] {
        let lift = |strips: usize| -> Result<Vec<f64>, Error> {
            let cycle = last_cycle(&flap.tether_of(ComparedPreset::Full, strips, 96)?)?;
            Ok(cycle.iter().map(|loads| loads.wrench.force[2]).collect())
        };
        let [coarse, middle, fine] = [lift(8)?, lift(16)?, lift(32)?];
        let rms = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let moved = rms(&middle, &fine) / rms(&fine, &vec![0.0; fine.len()]);
        let order = (rms(&coarse, &middle) / rms(&middle, &fine)).log2();
        let metric =
            format!("{name}: lift with 16 against 32 strips, rms over rms; observed order {order:.2}");
        let id = format!("aero.convergence.strips.{name}");
        rows.push(ComparisonRow::shown(&id, "own doubled strips", &metric, moved, ""));
    }
    Ok(rows)
}

/// Largest derivative of the rate of a lag by a lag of its kind along the turn, 1/s.
fn lag_slope() -> Result<Vec<ComparisonRow>, Error> {
    let scenario = turn(&[])?;
    let robot = scenario.robot();
    let (layout, states) = (*robot.layout(), robot.states());
    let mut linear = Linearisation::new(states.len(), robot.inputs().len());
    let (mut largest, mut fault, mut next) = (0.0_f64, None, 0.0);
    let alike = |i: usize, j: usize| states[i].unit == states[j].unit;
    let run = scenario.fly(|sample| {
        if sample.t + 1e-9 < next {
            return ControlFlow::Continue(());
        }
        next = sample.t + SLOPE_EVERY;
        if let Err(e) = linear.evaluate(robot, sample.t, sample.x, sample.u) {
            fault = Some(e);
            return ControlFlow::Break(());
        }
        for i in layout.aero..layout.len {
            for j in (layout.aero..layout.len).filter(|&j| alike(i, j)) {
                largest = largest.max(linear.a[i * layout.len + j].abs());
            }
        }
        ControlFlow::Continue(())
    })?;
    if let Some(fault) = fault {
        return Err(fault.into());
    }
    pose(&run, 5.0)?;
    let metric = "turn with preset full: largest derivative of a lag state's rate by a lag state of its unit, every 2 ms";
    let id = "aero.convergence.lag_slope";
    Ok(vec![ComparisonRow::judged(id, "a controller's interval holds it", metric, largest, 2000.0, "1/s")])
}

/// How often the slopes are taken, s.
const SLOPE_EVERY: f64 = 2e-3;

/// A tenth of the scenario's weight of the inputs, with which the number of strips chooses one of two sideslips.
const LIGHT: &str = "controller.weights.input=0.005";

/// Distances between ends of the turn with other cores and strips, m: what the model leaves open. Strips move it by much less than
/// what lies between the two sideslips that a [lighter](LIGHT) weight leaves.
fn spread() -> Result<Vec<ComparisonRow>, Error> {
    let fly = |strips: usize, more: &[&str]| {
        let mut keys = vec![format!("aero.full.strips={strips}")];
        keys.extend(more.iter().map(ToString::to_string));
        flown(&keys).and_then(|run| pose(&run, 5.0))
    };
    let away = |end: [f64; 6], from: [f64; 6]| (0..3).map(|i| (end[i] - from[i]).powi(2)).sum::<f64>().sqrt();
    let default = fly(16, &[])?;
    let mut rows = Vec::new();
    for (name, core) in [("core_quarter", 0.25), ("core_larger", 0.35)] {
        let id = format!("aero.convergence.spread.{name}");
        let metric = format!("distance of the turn's ends, 16 strips, vortex_core {core} from 0.3");
        let moved = away(fly(16, &[&format!("aero.full.vortex_core={core}")])?, default);
        rows.push(ComparisonRow::shown(&id, "choices of the model", &metric, moved, "m"));
    }
    for strips in [9, 23, 24, 32] {
        let id = format!("aero.convergence.spread.strips_{strips}");
        let metric = format!("distance of the turn's ends, {strips} strips from 16");
        rows.push(ComparisonRow::judged(
            &id,
            "own other strips",
            &metric,
            away(fly(strips, &[])?, default),
            0.3,
            "m",
        ));
    }
    let metric = format!("distance of the turn's ends, 24 strips from 16, with {LIGHT}: two flights");
    let two = away(fly(24, &[LIGHT])?, fly(16, &[LIGHT])?);
    rows.push(ComparisonRow::shown("aero.convergence.spread.two_flights", "warning", &metric, two, "m"));
    Ok(rows)
}
