//! The horizon of the predictive controller: in seconds, in cycles of the gait, and as an unknown.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use wingbeat::judge::Status;
use wingbeat::scenario::{Document, Scenario};
use wingbeat::simulate::Record;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios")
}

/// The turn of the paper, whose horizon is given in cycles.
fn turn(overrides: &[&str]) -> Result<Scenario, String> {
    let document = Document::file(&folder().join("paper_turn.toml")).map_err(|e| e.to_string())?;
    let document = overrides.iter().fold(document, |document, text| document.set(*text));
    Scenario::new(document).map_err(|e| e.to_string())
}

fn fly(scenario: &Scenario) -> Record {
    scenario.fly(|_| ControlFlow::Continue(())).unwrap().record
}

/// All columns.
fn numbers(record: &Record) -> Vec<(String, Vec<f64>)> {
    record
        .columns()
        .iter()
        .map(|column| (column.name.clone(), record.values(&column.name).unwrap().to_vec()))
        .collect()
}

#[test]
fn a_horizon_in_cycles_is_the_one_in_seconds() {
    let short = "flight.duration_s=0.1";
    let cycles = turn(&[short]).unwrap();
    let spec = cycles.spec.controller.as_ref().unwrap().shipped().unwrap();
    let hz = cycles.robot().frequency_hz();
    let seconds = spec.in_seconds(hz).unwrap();
    let interval = spec.horizon_cycles.unwrap() / (hz * spec.intervals as f64);
    assert_eq!((seconds.interval_s, seconds.horizon_cycles), (Some(interval), None));
    let text = format!(
        "base = \"paper_turn.toml\"\nwithout = [\"controller.horizon_cycles\"]\ncontroller.interval_s = {interval:?}\n"
    );
    let file = folder().join("in_seconds.toml");
    let read = |path: &Path| match path.ends_with("in_seconds.toml") {
        true => Ok(text.clone()),
        false => std::fs::read_to_string(path),
    };
    let other = Scenario::new(Document::among(&file, &read).unwrap().set(short)).unwrap();
    let (a, b) = (fly(&cycles), fly(&other));
    for ((name, a), (_, b)) in numbers(&a).into_iter().zip(numbers(&b)) {
        let worst = a.iter().zip(&b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        assert!(worst <= 1e-12, "{name}: {worst:e}");
    }
}

#[test]
fn a_horizon_is_given_once_and_of_a_gait_that_flaps() {
    let both = turn(&["controller.interval_s=0.04"]).unwrap_err();
    assert!(both.contains("controller.horizon_cycles") && both.contains("not both"), "{both}");
    assert!(both.contains("controller.interval_s"), "{both}");
    let still = turn(&["flight.flapping=false"]).unwrap_err();
    assert!(still.contains("controller.horizon_cycles") && still.contains("interval_s"), "{still}");
    for wrong in ["0.0", "-1.0", "101.0"] {
        let refused = turn(&[&format!("controller.horizon_cycles={wrong}")]).unwrap_err();
        assert!(refused.contains("controller.horizon_cycles"), "{refused}");
    }
    let document = Document::file(&folder().join("banking_turn.toml")).unwrap();
    let free = document.set("controller.horizon_between_cycles=[0.5, 1.5]");
    let refused = Scenario::new(free).map(drop).unwrap_err().to_string();
    assert!(refused.contains("horizon_between_cycles"), "{refused}");
    let narrow = turn(&["controller.horizon_between_cycles=[1.0, 1.5]"]).unwrap_err();
    assert!(narrow.contains("around horizon_cycles"), "{narrow}");
}

#[test]
fn a_free_horizon_keeps_to_its_range_and_one_without_room_is_the_given_one() {
    let short = "flight.duration_s=0.3";
    let given = fly(&turn(&[short]).unwrap());
    let cycle = 1.0 / turn(&[]).unwrap().robot().frequency_hz();
    assert!(given.values("horizon").is_none());
    let spec = turn(&[]).unwrap();
    let own = spec.spec.controller.as_ref().unwrap().shipped().unwrap().horizon_cycles.unwrap();
    let no_room = format!("controller.horizon_between_cycles=[{own:?}, {own:?}]");
    let held = fly(&turn(&[short, &no_room]).unwrap());
    for (name, values) in numbers(&given) {
        assert_eq!(held.values(&name).unwrap(), &values[..], "{name}");
    }
    let free = fly(&turn(&[short, "controller.horizon_between_cycles=[0.5, 1.5]"]).unwrap());
    let lengths = free.values("horizon").unwrap();
    let first = lengths[0];
    assert!(lengths.iter().all(|length| (0.5 * cycle - 1e-12..=1.5 * cycle + 1e-12).contains(length)));
    assert!(lengths.iter().any(|length| (length - first).abs() > 1e-3), "{first} s throughout");
}

#[test]
fn updates_may_be_prepared_before_their_measurement() {
    let turn = |overrides: &[&str]| {
        let document = Document::file(&folder().join("banking_turn.toml")).unwrap();
        let short = ["flight.duration_s=0.3", "goal.settle_s=0.1"];
        let document = short.iter().chain(overrides).fold(document, |document, text| document.set(*text));
        Scenario::new(document).map_err(|e| e.to_string())
    };
    let flown = |overrides: &[&str]| turn(overrides).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
    let [whole, prepared] =
        [false, true].map(|prepared| flown(&[&format!("controller.prepared={prepared}")]));
    assert!(whole.summary.prepared.is_none() && whole.record.values("plan_missed_attitude").is_none());
    let missed = prepared.summary.prepared.unwrap();
    assert!(0.0 < missed.missed_rms_deg && missed.missed_rms_deg < missed.missed_max_deg);
    assert!(missed.missed_max_deg < 0.5, "{missed:?}");
    assert_eq!(prepared.summary.controller.failures, 0);
    let rolls = [&whole, &prepared].map(|run| run.record.values("roll").unwrap().to_vec());
    let apart = rolls[0].iter().zip(&rolls[1]).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(0.0 < apart && apart < 0.02, "{apart:.3e} rad");
    // The limit is of all updates, however rarely they are recorded.
    let rare = flown(&["controller.prepared=true", "flight.record_every_s=0.1"]);
    assert_eq!(rare.summary.prepared.unwrap().missed_max_deg, missed.missed_max_deg);
    // A plan that was kept begins where nothing was measured; all updates come late here.
    let late = flown(&["controller.prepared=true", "controller.deadline_s=1e-7"]);
    let (counted, verdict) = (&late.summary.controller, &late.summary);
    assert_eq!([counted.late, counted.dropped], [counted.updates; 2]);
    let reason = verdict.reason.as_deref().unwrap_or_default();
    assert_eq!(verdict.status, Status::NotResolved, "{reason}");
    assert!(reason.contains("none by its deadline"), "{reason}");
    let commands = late.record.values("roll").unwrap();
    assert!(commands.iter().all(|roll| roll.is_finite()));
    // Where updates are rare and a gust is strong, what is found is far from what was expected.
    let gust = "air.gusts=[{start_s=0.05, duration_s=0.2, velocity_m_s=[0.0, 8.0, 4.0]}]";
    let far = flown(&["controller.prepared=true", "controller.period_s=0.05", gust]);
    let warned = far.summary.warnings.iter().any(|warning| warning.id == "flight.prepared_missed_deg");
    assert!(warned && far.summary.prepared.unwrap().missed_max_deg > 9.0, "{:?}", far.summary.prepared);
    // A model that knows the robot less well leads to another attitude.
    let mistaken = flown(&["controller.prepared=true", "mismatch.com_x_m=0.02"]);
    assert!(mistaken.summary.prepared.unwrap().missed_rms_deg > 1.5 * missed.missed_rms_deg);
}

#[test]
fn updates_of_a_free_horizon_are_not_prepared() {
    let free = "controller.horizon_between_cycles=[0.5, 1.5]";
    let refused = turn(&[free, "controller.prepared=true"]).unwrap_err();
    assert!(refused.contains("controller.prepared = true") && refused.contains("horizon"), "{refused}");
}
