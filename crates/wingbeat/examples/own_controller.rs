//! A feedback controller of one's own, chosen from a scenario: the wings' strokes level the robot.
//!
//! `cargo run --release --example own_controller`

use std::error::Error;
use std::ops::ControlFlow;
use wingbeat::guide::{ControllerSpec, ControllerTask};
use wingbeat::plant::{Plant, Role};
use wingbeat::scenario::{Document, Doors, Scenario};
use wingbeat::simulate::{Column, Controller, Measurement, Update};

/// What `[controller.leveller]` says.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct LevellerSpec {
    /// Time between updates, s.
    period_s: f64,
    /// Stroke per roll.
    roll_gain: f64,
    /// Stroke per roll rate, s.
    rate_gain_s: f64,
}

/// Offsets both shoulders against roll and roll rate.
struct Leveller {
    gains: [f64; 2],
    /// Numbers of the inputs of the left and the right shoulder.
    shoulders: [usize; 2],
    /// Offset in force, rad.
    offset: f64,
}

impl ControllerSpec for LevellerSpec {
    fn period_s(&self) -> f64 {
        self.period_s
    }

    fn build<'a>(&self, task: ControllerTask<'a>) -> Result<Box<dyn Controller + 'a>, wingbeat::Error> {
        let inputs = task.model.inputs();
        let shoulder = |name: &str| {
            let found = inputs.iter().position(|input| input.name == name);
            found.ok_or_else(|| {
                wingbeat::Error::invalid("", "given", format!("a robot with the input {name}"))
            })
        };
        let shoulders = [shoulder("command_shoulder_left")?, shoulder("command_shoulder_right")?];
        Ok(Box::new(Leveller { gains: [self.roll_gain, self.rate_gain_s], shoulders, offset: 0.0 }))
    }
}

impl Controller for Leveller {
    fn update(&mut self, _t: f64, measurement: &Measurement) -> Update {
        let (Some(q), Some(w)) = (measurement.attitude(), measurement.vector(Role::AngularRate)) else {
            return Update::Kept;
        };
        self.offset = self.gains[0] * q.matrix().roll_pitch_yaw()[0] + self.gains[1] * w[0];
        Update::Fresh
    }

    fn input(&self, _t: f64, u: &mut [f64]) {
        u.fill(0.0);
        (u[self.shoulders[0]], u[self.shoulders[1]]) = (-self.offset, self.offset);
    }

    fn columns(&self) -> Vec<Column> {
        vec![Column::new("levelling_offset", "rad", "")]
    }

    fn diagnostics(&self, row: &mut Vec<f64>) {
        row.push(self.offset);
    }
}

const CONTROLLER: &str = "
[leveller]
period_s = 0.005
roll_gain = 0.5
rate_gain_s = 0.02
";

/// Runs the example.
pub fn main() -> Result<(), Box<dyn Error>> {
    let doors = Doors::shipped().controller::<LevellerSpec>("leveller");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    let document = Document::file(path.as_ref())?
        .put("controller", Document::text("leveller", CONTROLLER)?)?
        .set("flight.duration_s=0.2")
        .set("start.roll_deg=5.0");
    let run = Scenario::open(document, &doors)?.fly(|_| ControlFlow::Continue(()))?;
    let offsets = run.record.values("levelling_offset").ok_or("no column of the controller")?;
    println!("{} updates, offset at first {:.4} rad", run.summary.controller.updates, offsets[0]);
    assert!((offsets[0] - 0.5 * 5.0_f64.to_radians()).abs() < 1e-12);
    assert_eq!(run.summary.controller.updates, 40);
    Ok(())
}
