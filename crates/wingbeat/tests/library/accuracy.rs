//! Flights in steps of a stated error.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::judge::Status;
use wingbeat::scenario::{Document, Run, Scenario};

/// A flight of `scenarios/banking_turn.toml`, whose inputs `free` leaves at rest.
fn fly(free: bool, overrides: &[&str]) -> Run {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let base = format!("base = {path:?}\nwithout = [\"controller\", \"manoeuvre\", \"goal\"]");
    let document = if free { Document::text("free", &base) } else { Document::file(&path) };
    let set = |document: Document, key: &&str| document.set((*key).to_string());
    let document = overrides.iter().fold(document.unwrap(), set);
    Scenario::new(document).unwrap().fly(|_| ControlFlow::Continue(())).unwrap()
}

/// Largest distance between two flights over all samples, m.
fn apart(one: &Run, other: &Run) -> f64 {
    let of = |name| {
        let [a, b] = [one, other].map(|run| run.record.values(name).unwrap());
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    ["com_x", "com_y", "com_z"].map(of).into_iter().fold(0.0, f64::max)
}

#[test]
fn a_stated_error_is_kept_measured_and_judged() {
    let of = |more: &str| fly(true, &["flight.duration_s=0.5", "flight.record_every_s=5e-3", more]);
    let fine = of("flight.step_s=5e-5");
    let mut before = usize::MAX;
    for asked in [1e-9, 1e-7, 1e-5] {
        let run = of(&format!("flight.error_m={asked:e}"));
        let (off, told) = (apart(&run, &fine), run.summary.step_error_m.unwrap());
        assert!(
            off < asked && told < asked && run.summary.status != Status::NotResolved,
            "{asked}: {off}, {told}"
        );
        let taken = run.summary.steps_taken.unwrap();
        assert!(taken < before, "{asked}: {taken}");
        before = taken;
    }
    let short = ["flight.duration_s=0.02", "flight.record_every_s=5e-3", "flight.step_s=1e-3"];
    let beyond = fly(true, &[&short[..], &["flight.error_m=1e-25"]].concat());
    assert_eq!(beyond.summary.status, Status::NotResolved);
    assert!(beyond.summary.reason.unwrap().contains("flight.error_m"));
}

#[test]
fn a_controller_acts_at_the_same_times_whatever_the_steps() {
    let of = |more: &str| fly(false, &["flight.duration_s=0.1", more]);
    let (equal, chosen) = (of("flight.step_s=5e-5"), of("flight.error_m=1e-8"));
    assert_eq!(chosen.summary.controller.updates, equal.summary.controller.updates);
    let off = apart(&equal, &chosen);
    assert!(off < 1e-8, "{off}");
}

#[test]
fn a_stated_error_beside_a_lattice_is_refused_by_its_key() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let lattice = ["flight.error_m=1e-6".to_string(), "lattice={step_s=1e-3}".to_string()];
    let error = Scenario::load(&path, &lattice).unwrap_err().to_string();
    assert!(error.contains("flight.error_m = 1e-6"), "{error}");
}
