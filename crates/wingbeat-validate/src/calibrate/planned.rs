//! A calibrated model that plans while the truth flies: the banking turn of the robot of 20 g, whose air is what the seven runs of the
//! robot of 45 g told.

use super::flight::{Calibrated, STRUCTURES, TRUTH, aero, calibrated, drawn, median, named, set};
use super::no_answer;
use crate::{Error, Row};
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::Scenario;

/// The models that plan: the paper's, and the strips of the truth with the law of a quasi-steady section.
const PLANNING: [[&str; 2]; 2] = [STRUCTURES[0], STRUCTURES[3]];

/// What a flight came to: rms errors of roll and pitch, deg; where it ended, m.
#[derive(Clone, Copy)]
struct Turned {
    attitude: [f64; 2],
    end: [f64; 3],
}

/// The turn of the truth, planned by a model of `structure` with `numbers`; by the truth's own without a structure.
fn turned(structure: Option<[&str; 2]>, numbers: &[(String, f64)]) -> Result<Turned, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let mut overrides: Vec<String> = aero(structure.unwrap_or(TRUTH)).into();
    if structure.is_some() {
        let [preset, law] = TRUTH;
        overrides
            .push(format!("mismatch={{ aero = {{ preset = {preset:?}, law = {law:?} }}, numbers = {{}} }}"));
        overrides.extend(set("robot.numbers", numbers));
    }
    let scenario = Scenario::load(&file, &overrides).map_err(no_answer)?;
    let summary = scenario.fly(|_| ControlFlow::Continue(())).map_err(no_answer)?.summary;
    let rms = [summary.roll_rms_error_deg, summary.pitch_rms_error_deg].map(|rms| rms.unwrap_or(f64::NAN));
    Ok(Turned { attitude: rms, end: [summary.distance_x_m, summary.distance_y_m, summary.altitude_change_m] })
}

/// Flights of the turn under plans of one structure of the model.
pub struct Plans {
    /// Preset and law.
    pub structure: [&'static str; 2],
    /// Planned by the truth.
    own: Turned,
    /// With the air of the fit.
    fitted: Turned,
    /// With airs up to 20 % off.
    drawn: Vec<Turned>,
}

impl Plans {
    /// Where flights end, m forward and to the left: planned by the truth, with the air of the fit, and with those before.
    pub fn ends(&self) -> [Vec<(f64, f64)>; 3] {
        let end = |turned: &Turned| (turned.end[0], turned.end[1]);
        [vec![end(&self.own)], vec![end(&self.fitted)], self.drawn.iter().map(end).collect()]
    }

    /// Rms of roll and pitch, and how far from that of the truth's own plans the flight ends.
    fn rows(&self) -> [Row; 3] {
        let Self { structure: [preset, law], own, fitted, drawn } = self;
        let apart = |turned: &Turned| {
            turned.end.iter().zip(own.end).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let source = format!("own truth ({}, {}) flown under plans of another model", TRUTH[0], TRUTH[1]);
        let row = |what: &str, of: &dyn Fn(&Turned) -> f64, unit: &'static str| {
            let drawn: Vec<f64> = drawn.iter().map(of).collect();
            let (low, high) = drawn.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(*d), h.max(*d)));
            let metric = format!(
                "{what} of the banking turn planned by {preset}, {law} with the air of the seven runs; by the truth {:.2}, \
                 before in 20 draws +-20 % {low:.2} to {high:.2}, median {:.2}",
                of(own),
                median(drawn)
            );
            let id = format!("calibrate.flight.planned.{preset}_{law}.{}", what.replace(' ', "_"));
            Row::shown(&id, &source, &metric, of(fitted), unit)
        };
        [
            row("roll rms", &|turned| turned.attitude[0], "deg"),
            row("pitch rms", &|turned| turned.attitude[1], "deg"),
            row("end", &apart, "m"),
        ]
    }
}

/// The turns that are planned by the two structures. Of the numbers those of the air count: the masses are another robot's.
pub fn plans() -> Result<Vec<Plans>, Error> {
    let of_air = |numbers: &[(String, f64)]| -> Vec<(String, f64)> {
        numbers.iter().filter(|(name, _)| name.starts_with("surfaces.")).cloned().collect()
    };
    let own = turned(None, &[])?;
    let one = |model: Calibrated| {
        let Calibrated { structure, parameters, values, .. } = model;
        let fitted = turned(Some(structure), &of_air(&named(&parameters, &values)))?;
        let before = drawn(&parameters);
        let drawn = wingbeat::parallel::map(&before, |_, numbers| turned(Some(structure), &of_air(numbers)));
        Ok(Plans { structure, own, fitted, drawn: drawn.into_iter().collect::<Result<_, Error>>()? })
    };
    calibrated(TRUTH, &[], &PLANNING)?.into_iter().map(one).collect()
}

pub(super) fn rows() -> Result<Vec<Row>, Error> {
    Ok(plans()?.iter().flat_map(Plans::rows).collect())
}
