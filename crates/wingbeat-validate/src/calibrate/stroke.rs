//! One stroke of a turn that carries its weight, flown by the truth and followed by a model.

use super::fitted::{TRUTH, aero, set, with_residual};
use super::no_answer;
use crate::Error;
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::math::{Jet, Quat, RK4, Vec3, Workspace};
use wingbeat::plant::Plant;
use wingbeat::robot::{BodyMotion, ResidualSpec};
use wingbeat::scenario::Scenario;
use wingbeat::simulate::Record;

/// Period of the truth's record, s: its step.
const RECORD: f64 = 2e-4;
/// Strokes over which the model's air follows the recorded motion before the one that is compared: of what wake and vortex remember of
/// their start six tenths are left after each. *Choice.*
const BEFORE: usize = 12;
/// Phases of the cycle at which strokes begin. *Choice.*
const PHASES: usize = 4;
/// Steps of a stroke.
const STEPS: usize = 200;

/// The turn at 15 deg of bank of the robot with the Beta's masses, which carries its weight under the truth.
fn turn(
    structure: [&str; 2],
    numbers: &[(String, f64)],
    residual: Option<&ResidualSpec>,
) -> Result<Scenario, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/bank15_beta_lev.toml");
    let mut overrides = vec!["flight.duration_s=4.0".to_owned(), format!("flight.record_every_s={RECORD}")];
    overrides.extend(aero(structure));
    overrides.extend(set(numbers));
    overrides.extend(residual.map(with_residual).transpose()?);
    Scenario::load(&file, &overrides).map_err(no_answer)
}

/// A column at `t`, between its rows.
fn at(record: &Record, name: &str, t: f64) -> Result<f64, Error> {
    let column = |name: &str| {
        record
            .values(name)
            .filter(|values| values.len() > 1)
            .ok_or_else(|| no_answer(format!("no column {name}")))
    };
    let (time, values) = (column("t")?, column(name)?);
    if !(time[0]..=time[time.len() - 1]).contains(&t) {
        return Err(no_answer(format!("the flight has no {t} s")));
    }
    let next = time.partition_point(|own| *own < t).clamp(1, time.len() - 1);
    let share = (t - time[next - 1]) / (time[next] - time[next - 1]);
    Ok(values[next - 1] + share * (values[next] - values[next - 1]))
}

fn vector(record: &Record, names: [&str; 3], t: f64) -> Result<Vec3, Error> {
    let [x, y, z] = names.map(|name| at(record, name, t));
    Ok(Vec3([x?, y?, z?]))
}

/// The recorded motion of the body at `t`, its accelerations by central differences.
fn body(record: &Record, t: f64) -> Result<BodyMotion, Error> {
    let velocity = |t| vector(record, ["v_WB_W_x", "v_WB_W_y", "v_WB_W_z"], t);
    let rate = |t| vector(record, ["w_WB_B_x", "w_WB_B_y", "w_WB_B_z"], t);
    let mut attitude = [0.0; 4];
    for (q, name) in attitude.iter_mut().zip(["quat_w", "quat_x", "quat_y", "quat_z"]) {
        *q = at(record, name, t)?;
    }
    let length = attitude.iter().map(|q| q * q).sum::<f64>().sqrt();
    Ok(BodyMotion {
        attitude: Quat::from_wxyz(&attitude.map(|q| q / length)).matrix(),
        velocity: velocity(t)?,
        rate: rate(t)?,
        acceleration: (velocity(t + RECORD)? - velocity(t - RECORD)?) * (0.5 / RECORD),
        angular_acceleration: (rate(t + RECORD)? - rate(t - RECORD)?) * (0.5 / RECORD),
    })
}

/// The truth's turn.
pub(super) struct TruthTurn {
    record: Record,
    /// Period of the stroke, s.
    cycle: f64,
}

impl TruthTurn {
    /// Flies it.
    pub fn new() -> Result<Self, Error> {
        let truth = turn(TRUTH, &[], None)?;
        let cycle = 1.0 / truth.robot().frequency_hz();
        Ok(Self { record: truth.fly(|_| ControlFlow::Continue(())).map_err(no_answer)?.record, cycle })
    }

    /// Angle, rad, and velocity, m/s, by which a model is off the truth after a stroke: rms over strokes that begin at even phases of the
    /// cycle, from `begin` on. What an error of the loads within a cycle leaves after it depends on where the stroke begins.
    ///
    /// `residual` acts on the body beside the model.
    pub fn off(
        &self,
        begin: f64,
        structure: [&str; 2],
        numbers: &[(String, f64)],
        residual: Option<&ResidualSpec>,
    ) -> Result<[f64; 2], Error> {
        let scenario = turn(structure, numbers, residual)?;
        let mut squares = [0.0; 2];
        for phase in 0..PHASES {
            let off = self.off_after(begin + phase as f64 / PHASES as f64 * self.cycle, &scenario)?;
            squares.iter_mut().zip(off).for_each(|(sum, off)| *sum += off * off / PHASES as f64);
        }
        Ok(squares.map(f64::sqrt))
    }

    /// The same after the stroke that begins at `begin`.
    ///
    /// Body and structure begin as the truth's. The model's air, which has other states than the truth's, is what follows when the model is
    /// carried along the recorded motion for some strokes before. The crank is taken to run evenly: this turn does not command it.
    fn off_after(&self, begin: f64, scenario: &Scenario) -> Result<[f64; 2], Error> {
        let (robot, record) = (scenario.robot(), &self.record);
        let l = robot.layout();
        let inputs = |t: f64| -> Result<Vec<f64>, Error> {
            robot.inputs().iter().map(|channel| at(record, &channel.name, t)).collect()
        };
        let told = |from: usize, to: usize, t: f64| -> Result<Vec<f64>, Error> {
            robot.states()[from..to].iter().map(|channel| at(record, &channel.name, t)).collect()
        };
        let h = self.cycle / STEPS as f64;
        let early = begin - BEFORE as f64 * self.cycle;
        let mut carried = told(l.structure, l.aero, early)?;
        carried.resize(robot.carried_states(), 0.0);
        let clock = |t: f64| Jet::new(t, 1.0, 0.0);
        robot
            .settle_carried(&clock(early), &body(record, early)?, &mut carried, &inputs(early)?)
            .map_err(no_answer)?;
        let mut work = Workspace::new(carried.len(), RK4.b.len());
        for k in 0..BEFORE * STEPS {
            let rates = |t: f64, x: &[f64], dx: &mut [f64]| {
                let loads = robot.carried(&clock(t), &body(record, t)?, x, &inputs(t)?, dx);
                loads.map(|_| ()).map_err(no_answer)
            };
            RK4.step(rates, early + k as f64 * h, h, &mut carried, &mut work)?;
        }
        let mut x = told(0, l.aero, begin)?;
        x.extend(&carried[l.aero - l.structure..]);
        let mut work = Workspace::new(x.len(), RK4.b.len());
        for k in 0..STEPS {
            let rates =
                |t: f64, x: &[f64], dx: &mut [f64]| robot.rates(t, x, &inputs(t)?, dx).map_err(no_answer);
            RK4.step(rates, begin + k as f64 * h, h, &mut x, &mut work)?;
        }
        let truth = body(record, begin + self.cycle)?;
        let own = Quat::from_wxyz(&x[l.attitude..]).matrix();
        let between = truth.attitude.transpose() * own;
        // The trace of a rotation is 1 + 2 cos of its angle, the skew part 2 sin of it along its axis.
        let [a, b, c] = [0, 1, 2].map(|j| between.column(j));
        let sine = 0.5 * (Vec3([b[2] - c[1], c[0] - a[2], a[1] - b[0]])).norm();
        let cosine = 0.5 * (a[0] + b[1] + c[2] - 1.0);
        let velocity = (Vec3::from_slice(&x[l.velocity..]) - truth.velocity).norm();
        Ok([sine.atan2(cosine), velocity])
    }
}
