//! What a calibration is worth in flight: truth and model under the same inputs, before and after the fit.

use super::{all_clean, measured, no_answer, shipped, structure, truth};
use crate::{Error, Row};
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::math::Random;
use wingbeat::scenario::Scenario;
use wingbeat::simulate::{Controller, Measurement, Record, Update};
use wingbeat_calibrate::{Plan, Progress, solve};

/// Draws of the numbers before the fit.
const DRAWS: usize = 20;
/// Share by which they are off.
const OFF: f64 = 0.2;
/// One stroke at 3.5 Hz, s, in whole records.
const CYCLE: f64 = 0.286;

/// Inputs of a record, played again.
struct Again<'a> {
    time: &'a [f64],
    inputs: Vec<&'a [f64]>,
}

impl<'a> Again<'a> {
    fn of(record: &'a Record) -> Self {
        let commands = record.columns().iter().filter(|column| column.name.starts_with("command_"));
        let inputs = commands.map(|column| column.values.as_slice()).collect();
        Self { time: record.values("t").unwrap_or_default(), inputs }
    }
}

impl Controller for Again<'_> {
    fn update(&mut self, _: f64, _: &Measurement) -> Update {
        Update::Kept
    }
    fn input(&self, t: f64, u: &mut [f64]) {
        let next = self.time.partition_point(|at| *at < t).clamp(1, self.time.len() - 1);
        let share = ((t - self.time[next - 1]) / (self.time[next] - self.time[next - 1])).clamp(0.0, 1.0);
        for (u, of) in u.iter_mut().zip(&self.inputs) {
            *u = of[next - 1] + share * (of[next] - of[next - 1]);
        }
    }
}

fn scenario(overrides: &[String]) -> Result<Scenario, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn_beta.toml");
    let brief = [format!("flight.duration_s={CYCLE}"), "manoeuvre.turn_start_s=0.0".into()];
    Scenario::load(&file, &[&brief, overrides].concat()).map_err(no_answer)
}

/// Attitude (rad) and velocity (m/s) at the end of a record.
fn end(record: &Record) -> Result<([f64; 3], [f64; 3]), Error> {
    let last = |name: &str| {
        let column = record.values(name).and_then(<[f64]>::last).copied();
        column.ok_or_else(|| no_answer(format!("no column {name}")))
    };
    let three = |names: [&str; 3]| -> Result<[f64; 3], Error> {
        Ok([last(names[0])?, last(names[1])?, last(names[2])?])
    };
    Ok((three(["roll", "pitch", "yaw"])?, three(["v_WB_W_x", "v_WB_W_y", "v_WB_W_z"])?))
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// How far the model with these numbers is from the truth after a cycle: attitude, rad, and velocity, m/s.
fn off(numbers: &[(String, f64)], flown: &Record) -> Result<(f64, f64), Error> {
    let list: Vec<String> = numbers.iter().map(|(name, value)| format!("{name:?} = {value:?}")).collect();
    let overrides = [
        "aero.preset=paper".into(),
        "aero.law=linear".into(),
        format!("robot.numbers={{ {} }}", list.join(", ")),
    ];
    let model = scenario(&overrides)?;
    let mut again = Again::of(flown);
    let run = model
        .fly_with(&mut again, 0.005, model.sensors(), |_| ControlFlow::Continue(()))
        .map_err(no_answer)?;
    let ((angles, velocity), (true_angles, true_velocity)) = (end(&run.record)?, end(flown)?);
    Ok((apart(angles, true_angles), apart(velocity, true_velocity)))
}

fn median(mut of: Vec<f64>) -> f64 {
    of.sort_by(f64::total_cmp);
    0.5 * (of[(of.len() - 1) / 2] + of[of.len() / 2])
}

/// Median over twenty draws of what is left after the fit, in parts of before.
pub fn rows() -> Result<Vec<Row>, Error> {
    let calibration = shipped("seven_runs.toml", &["structures=[]", "starts=1"])?;
    let (own, targets) = (structure(&calibration)?, truth(&calibration)?);
    let runs = measured(&calibration, &targets, &all_clean(&targets)?, 1)?;
    let plan = Plan { starts: 1, spread: 0.0, seed: 0, discrepancy: true };
    let watch = &mut |_: &Progress| ControlFlow::Continue(());
    let solved = solve(&own.model, &runs, &own.parameters, &plan, &mut (), watch).map_err(no_answer)?;
    let flown = scenario(&["aero.preset=full".into(), "aero.law=lev".into()])?
        .fly(|_| ControlFlow::Continue(()))
        .map_err(no_answer)?
        .record;
    // The encoder's lag is the rig's, not the robot's.
    let named = |values: &[f64]| -> Vec<(String, f64)> {
        let all =
            own.parameters.iter().zip(values).map(|(parameter, value)| (parameter.name.clone(), *value));
        all.filter(|(name, _)| name != "gait.phase_rad").collect()
    };
    let after = off(&named(&solved.values), &flown)?;
    let nominal: Vec<f64> = own.parameters.iter().map(|parameter| parameter.start).collect();
    let plain = off(&named(&nominal), &flown)?;
    let (mut angles, mut speeds) = (Vec::new(), Vec::new());
    for draw in 0..DRAWS {
        let mut random = Random::stream(29, draw as u64);
        let drawn: Vec<f64> = own
            .parameters
            .iter()
            .map(|parameter| {
                let value = parameter.start + random.between(-OFF, OFF) * parameter.scale();
                value.clamp(parameter.low, parameter.high)
            })
            .collect();
        let before = off(&named(&drawn), &flown)?;
        angles.push(after.0 / before.0);
        speeds.push(after.1 / before.1);
    }
    let source = "own truth (full, lev) and paper, linear under its inputs, one stroke";
    let degrees = |angle: f64| angle.to_degrees();
    let attitude = format!(
        "attitude: median after over before, 20 draws +-20 %; {:.3} deg after, {:.3} deg without draws",
        degrees(after.0),
        degrees(plain.0)
    );
    let velocity = format!("velocity: the same; {:.4} m/s after, {:.4} m/s without draws", after.1, plain.1);
    Ok(vec![
        Row::judged("calibrate.flight", source, &attitude, median(angles), 1.0 / 3.0, ""),
        Row::judged("calibrate.flight.velocity", source, &velocity, median(speeds), 1.0 / 3.0, ""),
    ])
}
