//! A calibrated model that plans while the truth flies: the banking turn of the robot of 20 g, whose air is what the seven runs of the
//! robot of 45 g told; and the turn that carries the weight of the robot of 45 g, held about orbits that the model has.

use super::fitted::{Calibrated, TRUTH, aero, calibrated, median, set, with_residual};
use super::no_answer;
use crate::{ComparisonRow, Error};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use wingbeat::robot::ResidualSpec;
use wingbeat::scenario::Scenario;

/// A flight and the model that plans it.
#[derive(Clone, Copy)]
enum PlannedFlight {
    /// The banking turn, by optimal control.
    Banking,
    /// The turn at 15 deg of bank, by a regulator about orbits.
    Orbit,
}

/// What is planned by which preset and law.
const PLANNING: [(PlannedFlight, [&str; 2]); 4] = [
    (PlannedFlight::Banking, ["paper", "linear"]),
    (PlannedFlight::Banking, ["full", "stall"]),
    (PlannedFlight::Orbit, ["paper", "lev"]),
    (PlannedFlight::Orbit, ["full", "stall"]),
];

impl PlannedFlight {
    fn scenario(self) -> &'static str {
        match self {
            Self::Banking => "banking_turn.toml",
            Self::Orbit => "bank15_beta_lev.toml",
        }
    }
    fn name(self) -> &'static str {
        match self {
            Self::Banking => "banking turn",
            Self::Orbit => "turn about orbits",
        }
    }
    /// What its ids have.
    fn id(self) -> &'static str {
        match self {
            Self::Banking => "banking",
            Self::Orbit => "orbit",
        }
    }
    /// Of the numbers of the seven runs those that are this robot's: the banking turn has other masses.
    fn own(self, mut numbers: Vec<(String, f64)>) -> Vec<(String, f64)> {
        numbers.retain(|(name, _)| matches!(self, Self::Orbit) || name.starts_with("surfaces."));
        numbers
    }
}

/// What a flight came to: rms errors of roll and, where one is told, pitch, deg; largest error of height, where one is told, m; where it
/// ended, m.
#[derive(Clone, Copy)]
struct Turned {
    roll: f64,
    pitch: Option<f64>,
    height: Option<f64>,
    end: [f64; 3],
}

/// What the controller asks of a model that has no orbit of the gait at its speed or along a leg.
const NO_ORBIT: [&str; 2] = ["controller.orbit.", "of which the gait has an orbit"];

/// The flight of the truth, planned by a model of `structure` with `numbers` and a learned wrench; by the truth's own without a structure.
/// None where the model has no orbit to hold.
fn turned(
    flight: PlannedFlight,
    structure: Option<[&str; 2]>,
    numbers: &[(String, f64)],
    residual: Option<&ResidualSpec>,
) -> Result<Option<Turned>, Error> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(flight.scenario());
    let mut overrides: Vec<String> = aero(structure.unwrap_or(TRUTH)).into();
    if structure.is_some() {
        let [preset, law] = TRUTH;
        let grid = if matches!(flight, PlannedFlight::Orbit) { ", full = { strips = 9 }" } else { "" };
        overrides.push(format!(
            "mismatch={{ aero = {{ preset = {preset:?}, law = {law:?}{grid} }}, numbers = {{}} }}"
        ));
        overrides.extend(set(numbers));
        overrides.extend(residual.map(with_residual).transpose()?);
    }
    let scenario = Scenario::load(&file, &overrides).map_err(no_answer)?;
    let summary = match scenario.fly(|_| ControlFlow::Continue(())) {
        Err(wingbeat::Error::Invalid { key, allowed, .. })
            if key.starts_with(NO_ORBIT[0]) && allowed.contains(NO_ORBIT[1]) =>
        {
            return Ok(None);
        }
        other => other.map_err(no_answer)?.summary,
    };
    Ok(Some(Turned {
        roll: summary.roll_rms_error_deg.unwrap_or(f64::NAN),
        pitch: summary.pitch_rms_error_deg,
        height: summary.height_max_error_m,
        end: [summary.distance_x_m, summary.distance_y_m, summary.altitude_change_m],
    }))
}

/// A flight under plans of one structure of the model.
pub struct Plans {
    flight: PlannedFlight,
    structure: [&'static str; 2],
    /// Planned by the truth.
    own: Turned,
    /// As calibrated.
    fitted: Option<Turned>,
    /// Without the learned wrench, where there is one.
    numbers: Option<Turned>,
    /// With numbers up to 20 % off: those that plan.
    drawn: Vec<Turned>,
    /// How many were tried.
    tried: usize,
}

impl Plans {
    /// What is planned by what.
    pub fn title(&self) -> String {
        let [preset, law] = self.structure;
        format!("{}, planned by {preset}, {law}", self.flight.name())
    }

    /// Where flights end, m forward and to the left: planned by the truth, as calibrated, and before.
    pub fn ends(&self) -> [Vec<(f64, f64)>; 3] {
        let end = |turned: &Turned| (turned.end[0], turned.end[1]);
        [vec![end(&self.own)], self.fitted.iter().map(end).collect(), self.drawn.iter().map(end).collect()]
    }

    /// Errors of roll, pitch and height, and how far from that of the truth's own plans the flight ends.
    fn rows(&self) -> Vec<ComparisonRow> {
        let Self { flight, structure: [preset, law], own, fitted, numbers, drawn, tried } = self;
        let apart = |turned: &Turned| {
            turned.end.iter().zip(own.end).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let source = format!("own truth ({}, {}) flown under plans of another model", TRUTH[0], TRUTH[1]);
        let row = |what: &str, of: &dyn Fn(&Turned) -> Option<f64>, unit: &'static str| {
            let truth = of(own)?;
            let mut metric = format!("{what} of the {}; by the truth {truth:.4}", self.title());
            if matches!(flight, PlannedFlight::Orbit) {
                let alone = numbers.as_ref().and_then(of);
                metric += &alone
                    .map_or(", with the numbers of the seven runs alone no orbit".into(), |alone| {
                        format!(", with the numbers of the seven runs alone {alone:.4}")
                    });
            }
            let drawn: Vec<f64> = drawn.iter().filter_map(of).collect();
            let (low, high) = drawn.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), d| (l.min(*d), h.max(*d)));
            metric += &match drawn.len() {
                0 => format!(", before in {tried} draws +-20 % none has an orbit"),
                count => format!(
                    ", before in {count} of {tried} draws +-20 % {low:.2} to {high:.2}, median {:.2}",
                    median(drawn)
                ),
            };
            let id =
                format!("calibrate.flight.planned.{}.{preset}_{law}.{}", flight.id(), what.replace(' ', "_"));
            Some(ComparisonRow::shown(
                &id,
                &source,
                &metric,
                fitted.as_ref().and_then(of).unwrap_or(f64::NAN),
                unit,
            ))
        };
        let told = [
            row("roll rms", &|turned| Some(turned.roll), "deg"),
            row("pitch rms", &|turned| turned.pitch, "deg"),
            row("height", &|turned| turned.height.map(|height| 1e3 * height), "mm"),
            row("end", &|turned| Some(apart(turned)), "m"),
        ];
        told.into_iter().flatten().collect()
    }
}

/// The flights under the plans of all structures; about orbits with the learned wrench, which is that robot's. Rows and figure share them.
pub fn plans() -> Result<&'static [Plans], Error> {
    static FLOWN: OnceLock<Vec<Plans>> = OnceLock::new();
    if let Some(flown) = FLOWN.get() {
        return Ok(flown);
    }
    let one = |((flight, structure), model): (&(PlannedFlight, [&'static str; 2]), Arc<Calibrated>)| {
        let (flight, structure) = (*flight, *structure);
        let own = turned(flight, None, &[], None)?.ok_or_else(|| no_answer("the truth has no orbit"))?;
        let residual = matches!(flight, PlannedFlight::Orbit).then_some(&model.residual.spec);
        let numbers = flight.own(model.numbers());
        let fitted = turned(flight, Some(structure), &numbers, residual)?;
        let alone = if residual.is_some() { turned(flight, Some(structure), &numbers, None)? } else { None };
        let before = model.drawn();
        let tried = before.len();
        let drawn = wingbeat::parallel::map(&before, |_, numbers| {
            turned(flight, Some(structure), &flight.own(numbers.clone()), None)
        });
        let drawn = drawn.into_iter().collect::<Result<Vec<_>, Error>>()?.into_iter().flatten().collect();
        Ok(Plans { flight, structure, own, fitted, numbers: alone, drawn, tried })
    };
    let structures = PLANNING.map(|(_, structure)| structure);
    let flown =
        PLANNING.iter().zip(calibrated(&structures)?).map(one).collect::<Result<Vec<Plans>, Error>>()?;
    Ok(FLOWN.get_or_init(|| flown))
}

pub(super) fn rows() -> Result<Vec<ComparisonRow>, Error> {
    Ok(plans()?.iter().flat_map(Plans::rows).collect())
}
