//! Class 3: updates of a controller that come late are counted; the other cases are data, `status.toml`.

use super::case::ScriptedCase;
use super::readers::{holds, json};

/// The cases.
pub fn cases() -> Vec<ScriptedCase> {
    vec![ScriptedCase::new(3, "late_updates_count", |place| {
        let turn = "{root}/scenarios/banking_turn.toml";
        let set = ["--set", "flight.duration_s=0.05", "--set", "controller.iterations=100"];
        let words = [&["fly", turn, "--quiet", "--out", "a"][..], &set[..]].concat();
        place.run(&words)?.exits(0)?;
        let controller = &json(place, "a/summary.json")?["controller"];
        let period_us = 1e6 * controller["period_s"].as_f64().unwrap_or(0.0);
        let slow = controller["median_us"].as_f64().is_some_and(|us| us > period_us);
        holds(!slow || controller["late"].as_u64() > Some(0), "late = 0 beside slow updates")
    })]
}
