//! What the controllers of a sweep's flights share.

use super::Scenario;
use super::spec::ScenarioSpec;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use wingbeat_flight::guide::Prepared;

/// Most that are kept: a sweep may draw what they are made from.
const KEPT: usize = 4;

/// What is being made, or made; none where there is nothing to share, or it cannot be made.
type Made = Arc<OnceLock<Option<Prepared>>>;

/// What was prepared, by all that it was made from; the latest last.
#[derive(Debug, Default)]
pub(super) struct Shared(Mutex<Vec<(String, Made)>>);

impl Shared {
    /// Gives `scenario` what its controller shares with others of the same model. Who comes first makes it, others wait.
    pub fn give(&self, scenario: &mut Scenario) {
        let Some(key) = made_from(&scenario.spec) else { return };
        let made = {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            match all.iter().find(|(other, _)| *other == key) {
                Some((_, made)) => made.clone(),
                None => {
                    if all.len() == KEPT {
                        all.remove(0);
                    }
                    let made = Made::default();
                    all.push((key, made.clone()));
                    made
                }
            }
        };
        scenario.prepared = made.get_or_init(|| scenario.prepare()).clone();
    }
}

/// All that the model and its controller are made from; neither gusts, mismatch nor noise are among it.
fn made_from(spec: &ScenarioSpec) -> Option<String> {
    let ScenarioSpec { robot, air, aero, start, flight, controller, manoeuvre, solver, .. } = spec;
    let numbers = [air.density_kg_m3, start.phase_rad, air.wind_m_s[0], air.wind_m_s[1], air.wind_m_s[2]];
    let numbers = numbers.map(f64::to_bits);
    let tables = [
        toml::to_string(robot).ok()?,
        toml::to_string(aero).ok()?,
        toml::to_string(controller.as_ref()?).ok()?,
        manoeuvre.as_ref().map_or(Ok(String::new()), toml::to_string).ok()?,
        solver.as_ref().map_or(Ok(String::new()), toml::to_string).ok()?,
    ];
    Some(format!("{numbers:?} {} {}", flight.flapping, tables.join("\n---\n")))
}
