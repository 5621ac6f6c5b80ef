//! A calibrated model that plans while the truth flies: the banking turn of the robot of 20 g, whose air is what the seven runs of the
//! robot of 45 g told.

use super::flight::{aero, median, set};
use super::no_answer;
use crate::{Error, Row};
use std::ops::ControlFlow;
use std::path::Path;
use wingbeat::scenario::Scenario;

/// What a flight came to: rms errors of roll and pitch, deg; where it ended, m.
#[derive(Clone, Copy)]
struct Turned {
    attitude: [f64; 2],
    end: [f64; 3],
}

/// The turn of the truth, planned by a model of `structure` with `numbers`; by the truth's own without a structure.
fn turned(
    truth: [&str; 2],
    structure: Option<[&str; 2]>,
    numbers: &[(String, f64)],
) -> Result<Turned, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let mut overrides: Vec<String> = aero(structure.unwrap_or(truth)).into();
    if structure.is_some() {
        let [preset, law] = truth;
        overrides
            .push(format!("mismatch={{ aero = {{ preset = {preset:?}, law = {law:?} }}, numbers = {{}} }}"));
        overrides.extend(set("robot.numbers", numbers));
    }
    let scenario = Scenario::load(&file, &overrides).map_err(no_answer)?;
    let summary = scenario.fly(|_| ControlFlow::Continue(())).map_err(no_answer)?.summary;
    let rms = [summary.roll_rms_error_deg, summary.pitch_rms_error_deg].map(|rms| rms.unwrap_or(f64::NAN));
    Ok(Turned { attitude: rms, end: [summary.distance_x_m, summary.distance_y_m, summary.altitude_change_m] })
}

/// Rms of roll and pitch and the end of the turn that a model of `structure` plans and the truth flies, with the numbers of the fit
/// (`after`) and with those `before`. Of the numbers those of the air count: the masses are another robot's.
pub(super) fn rows(
    truth: [&str; 2],
    structure: [&str; 2],
    before: &[Vec<(String, f64)>],
    after: &[(String, f64)],
) -> Result<Vec<Row>, Error> {
    let of_air = |numbers: &[(String, f64)]| -> Vec<(String, f64)> {
        numbers.iter().filter(|(name, _)| name.starts_with("surfaces.")).cloned().collect()
    };
    let fitted = turned(truth, Some(structure), &of_air(after))?;
    let own = turned(truth, None, &[])?;
    let drawn =
        wingbeat::parallel::map(before, |_, numbers| turned(truth, Some(structure), &of_air(numbers)));
    let drawn = drawn.into_iter().collect::<Result<Vec<_>, _>>()?;
    let apart =
        |turned: &Turned| turned.end.iter().zip(own.end).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let [preset, law] = structure;
    let source = format!("own truth ({}, {}) flown under plans of another model", truth[0], truth[1]);
    let row = |what: &str, value: f64, own: f64, drawn: Vec<f64>, unit: &'static str| {
        let (low, high) = drawn.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(*d), h.max(*d)));
        let metric = format!(
            "{what} of the banking turn planned by {preset}, {law} with the air of the seven runs; by the truth {own:.2}, before \
             in 20 draws +-20 % {low:.2} to {high:.2}, median {:.2}",
            median(drawn)
        );
        Row::shown(
            &format!("calibrate.flight.planned.{preset}_{law}.{}", what.replace(' ', "_")),
            &source,
            &metric,
            value,
            unit,
        )
    };
    let of = |i: usize| drawn.iter().map(|turned| turned.attitude[i]).collect::<Vec<f64>>();
    Ok(vec![
        row("roll rms", fitted.attitude[0], own.attitude[0], of(0), "deg"),
        row("pitch rms", fitted.attitude[1], own.attitude[1], of(1), "deg"),
        row("end", apart(&fitted), 0.0, drawn.iter().map(apart).collect(), "m"),
    ])
}
