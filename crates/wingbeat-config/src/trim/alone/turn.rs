//! A turn about the orbits of a gait that was found.

use super::super::TrimProgress;
use super::super::summary::TrimSummary;
use super::numbers;
use crate::{ConfigError, Document, Scenario, ScenarioSpec};
use serde::Serialize;
use std::ops::ControlFlow;
use wingbeat_judge::{Judged, Status, Warning};
use wingbeat_math::Error;

/// Step of integration, s, and updates of the controller in a cycle. *Choices* of the shipped turns.
const STEP: f64 = 2.5e-4;
const UPDATES: f64 = 20.0;
/// Level flight before the turn, time into it, and in it, s. *Choices.*
const LEVEL_S: f64 = 2.0;
const INTO_S: f64 = 2.5;
const TURN_S: f64 = 2.5;
/// Speed in the turn over that of level flight, and the deviation of angles that costs a full command, deg: tried one after another
/// until a turn holds. *Choices*: 1 / sqrt(cos 30 deg) is 1.075.
const TRIES: [(f64, f64); 3] = [(1.075, 3.0), (1.0, 3.0), (1.15, 6.0)];
/// Largest error of the height of a turn that holds, m. *Choice.*
const HELD: f64 = 0.02;
/// Largest difference of the mean roll from the bank, deg. *Choice.*
const ROLLED_DEG: f64 = 3.0;

/// Share of commands at a limit from which on that is told of a turn that does not hold. *Choice.*
const SATURATED: f64 = 0.05;

/// A turn that was flown.
#[derive(Clone, Debug, Serialize)]
pub struct TurnSummary {
    /// Its verdict, that of a flight; `off_target` where the height is off by more than 20 mm or the mean roll by more than 3 deg.
    pub status: Status,
    /// Why it is not `ok`.
    pub reason: Option<String>,
    /// What the status rests on.
    pub judged: Vec<Judged>,
    /// What a reader must know.
    pub warnings: Vec<Warning>,
    /// Bank that was asked, deg.
    pub bank_deg: f64,
    /// Speed in it, m/s.
    pub speed_m_s: f64,
    /// Mean roll in it, deg.
    pub roll_mean_deg: Option<f64>,
    /// Largest error of the height from the second second on, m.
    pub height_max_error_m: Option<f64>,
    /// Least clearance, m.
    pub least_clearance_m: Option<f64>,
    /// Mean positive power over the mass of the whole flight, W/kg.
    pub power_w_kg: Option<f64>,
    /// Share of commands at a limit.
    pub input_saturation_fraction: Option<f64>,
    /// Flights tried.
    pub flights: usize,
}

impl TurnSummary {
    fn none(bank_deg: f64, speed_m_s: f64, reason: String) -> Self {
        Self {
            status: Status::NotFound,
            reason: Some(reason),
            judged: Vec::new(),
            warnings: Vec::new(),
            bank_deg,
            speed_m_s,
            roll_mean_deg: None,
            height_max_error_m: None,
            least_clearance_m: None,
            power_w_kg: None,
            input_saturation_fraction: None,
            flights: 0,
        }
    }

    /// Why none is flown at `speed`, m/s: its controller is no key that the user gave.
    #[doc(hidden)]
    pub fn not_flown(error: &Error, speed: f64) -> String {
        let Error::Invalid { key, value, allowed, .. } = error;
        match key.strip_prefix("controller.orbit.") {
            Some("weights") => {
                format!("at {speed:.2} m/s no feedback by its actuators holds the flight into it")
            }
            Some(_) => {
                // What it advises is for a scenario that names its start.
                let why = value.split(": begin").next().unwrap_or(value);
                format!("at {speed:.2} m/s no periodic flight leads into it: {why}")
            }
            None => format!("at {speed:.2} m/s it is not flown: {key} = {value}, allowed is {allowed}"),
        }
    }

    /// Better ones come first: the status, then the height.
    fn order(&self) -> (Status, f64) {
        (self.status, self.height_max_error_m.unwrap_or(f64::INFINITY))
    }
}

impl TrimSummary {
    /// Takes in what became of the turn.
    pub(super) fn with_turn(&mut self, turn: &TurnSummary) {
        if turn.status == Status::Ok {
            return;
        }
        let why = turn.reason.as_deref().unwrap_or(turn.status.name());
        let own = self.reason.take().map_or(String::new(), |reason| format!("{reason}; "));
        self.reason = Some(format!("{own}the turn of {:.0} deg: {why}", turn.bank_deg));
        self.status = self.status.max(turn.status);
    }
}

/// The scenario of the turn.
fn scenario(
    spec: &ScenarioSpec,
    level: &TrimSummary,
    bank_deg: f64,
    try_: (f64, f64),
) -> Result<Document, ConfigError> {
    let mut spec = ScenarioSpec { trim: None, ..spec.clone() };
    spec.name = format!("{}-turn", spec.name);
    let cycle = 1.0 / level.frequency_hz.unwrap_or(1.0);
    let period = STEP * (cycle / (UPDATES * STEP)).round().max(1.0);
    let whole = |time: f64| (time / period).round() * period;
    spec.flight.step_s = STEP;
    spec.flight.record_every_s = period;
    spec.flight.duration_s = whole(LEVEL_S + INTO_S + TURN_S);
    let own = Scenario::new(Document::value("turn", &spec)?)?;
    let mut free = numbers::free(own.model());
    free.rotate_left(1);
    if own.model().pacer().is_none() {
        free.retain(|name| name != "frequency");
    }
    let (faster, angle) = try_;
    let speed = level.speed_m_s;
    let text = format!(
        "controller.orbit={{period_s={period:?}, speed_m_s={speed:?}, free={free:?}, weights={{angle_deg={angle:?}}}, legs=[{{\
         start_s={LEVEL_S:?}, duration_s={INTO_S:?}, speed_m_s={:?}, bank_deg={bank_deg:?}}}]}}",
        faster * speed
    );
    Ok(Document::value("turn", &spec)?.set(text))
}

/// Flies turns until one holds; the best, and its scenario.
pub(super) fn flown(
    spec: &ScenarioSpec,
    level: &TrimSummary,
    bank_deg: f64,
    observe: &mut dyn FnMut(TrimProgress) -> ControlFlow<()>,
) -> Result<(TurnSummary, Option<String>), ConfigError> {
    let mut best: Option<(TurnSummary, Option<String>)> = None;
    let mut flights = 0;
    for try_ in TRIES {
        let speed = try_.0 * level.speed_m_s;
        flights += 1;
        let mut stopped = false;
        let mut tell = || {
            let flow = observe(TrimProgress::Turn { flight: flights });
            stopped |= flow.is_break();
            flow
        };
        let one = match scenario(spec, level, bank_deg, try_).and_then(Scenario::new) {
            Ok(scenario) => match scenario.fly(|_| tell()) {
                Ok(run) => (turned(&run.summary, bank_deg, speed), Some(scenario.resolved.clone())),
                Err(error) => {
                    (TurnSummary::none(bank_deg, speed, TurnSummary::not_flown(&error, speed)), None)
                }
            },
            Err(error) => (TurnSummary::none(bank_deg, speed, error.to_string()), None),
        };
        let done = one.0.status == Status::Ok;
        if best.as_ref().is_none_or(|(best, _)| one.0.order() < best.order()) {
            best = Some(one);
        }
        if done || stopped {
            break;
        }
    }
    let (mut summary, file) =
        best.unwrap_or_else(|| (TurnSummary::none(bank_deg, level.speed_m_s, "none was flown".into()), None));
    summary.flights = flights;
    Ok((summary, file))
}

/// The numbers of a turn from the summary of its flight.
fn turned(run: &crate::Summary, bank_deg: f64, speed: f64) -> TurnSummary {
    let lost = run.height_max_error_m.filter(|error| !(*error <= HELD));
    let (mut status, mut reason) = (run.status, run.reason.clone());
    if let Some(lost) = lost {
        status = status.max(Status::OffTarget);
        let text = format!("the height is off by {:.0} mm, allowed is {:.0} mm", 1e3 * lost, 1e3 * HELD);
        reason = Some(reason.map_or(text.clone(), |reason| format!("{reason}; {text}")));
    }
    if let Some(roll) = run.turn_roll_mean_deg.filter(|roll| !((roll - bank_deg).abs() <= ROLLED_DEG)) {
        status = status.max(Status::OffTarget);
        let text = format!(
            "the mean roll in the turn is {roll:.1} deg, allowed is {bank_deg:.0} +- {ROLLED_DEG:.0} deg"
        );
        reason = Some(reason.map_or(text.clone(), |reason| format!("{reason}; {text}")));
    }
    let held = run.input_saturation_fraction;
    if status != Status::Ok && held > SATURATED {
        let text = format!("{:.0} % of the commands are at a limit", 100.0 * held);
        reason = Some(reason.map_or(text.clone(), |reason| format!("{reason}; {text}")));
    }
    TurnSummary {
        status,
        reason,
        judged: run.judged.clone(),
        warnings: run.warnings.clone(),
        bank_deg,
        speed_m_s: speed,
        roll_mean_deg: run.turn_roll_mean_deg,
        height_max_error_m: run.height_max_error_m,
        least_clearance_m: run.least_clearance_m,
        power_w_kg: run.cost.positive_power_w_kg,
        input_saturation_fraction: Some(held),
        flights: 0,
    }
}
