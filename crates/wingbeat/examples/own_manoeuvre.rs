//! A manoeuvre of one's own, chosen from a scenario: the robot rolls to and fro.
//!
//! `cargo run --release --example own_manoeuvre`

use std::error::Error;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use wingbeat::guide::{Manoeuvre, Reference};
use wingbeat::math::Vec3;
use wingbeat::scenario::{Document, Doors, Scenario};

/// Roll as a sine of time, at constant pitch.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Weave {
    /// Largest roll, deg.
    roll_deg: f64,
    /// Pitch, deg; negative is nose up.
    nose_up_deg: f64,
    /// Period, s.
    period_s: f64,
}

impl Manoeuvre for Weave {
    fn check(&self) -> Result<(), wingbeat::Error> {
        if self.period_s > 0.0 {
            return Ok(());
        }
        Err(wingbeat::Error::invalid("period_s", self.period_s, "above 0"))
    }

    fn reference(&self, t: f64) -> Reference {
        let (amplitude, rate) = (self.roll_deg.to_radians(), TAU / self.period_s);
        let (sine, cosine) = (rate * t).sin_cos();
        let w = Vec3::new(amplitude * rate * cosine, 0.0, 0.0);
        Reference { roll: amplitude * sine, pitch: -self.nose_up_deg.to_radians(), w }
    }
}

/// Runs the example.
pub fn main() -> Result<(), Box<dyn Error>> {
    let doors = Doors::shipped().manoeuvre::<Weave>("weave");
    let weave = Document::text("weave", "[weave]\nroll_deg = 10.0\nnose_up_deg = 15.0\nperiod_s = 1.0")?;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenarios/banking_turn.toml");
    let document = Document::file(path.as_ref())?.put("manoeuvre", weave)?;
    let document = document.set("flight.duration_s=1.0").set("goal.settle_s=0.25");

    let refused = Scenario::open(document.clone().set("manoeuvre.weave.period_s=-1"), &doors);
    let refused = refused.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.contains("manoeuvre.weave.period_s = -1: allowed is above 0"), "{refused}");

    let run = Scenario::open(document, &doors)?.fly(|_| ControlFlow::Continue(()))?;
    let error = run.summary.roll_rms_error_deg.ok_or("the flight is not judged")?;
    println!("roll follows the sine within {error:.2} deg rms");
    assert!(error < 2.0, "{error}");
    Ok(())
}
