//! Flights in steps of a stated error.

use std::ops::ControlFlow;
use std::path::PathBuf;
use wingbeat::judge::Status;
use wingbeat::scenario::{Document, Run, Scenario};
use wingbeat::simulate::AtRest;

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
fn an_error_that_the_closed_loop_lets_grow_is_stated() {
    let grown =
        |run: &Run| run.summary.judged.iter().find(|j| j.id == "flight.error_grown_fraction").cloned();
    let kept = fly(false, &["flight.duration_s=0.3", "flight.error_m=1e-6"]);
    let held = grown(&kept).unwrap();
    assert!(held.met && held.value.unwrap() > 1e-4, "{held:?}");
    assert!(grown(&fly(true, &["flight.duration_s=0.1", "flight.error_m=1e-6"])).is_none());
    // Under a law that stalls the loop makes 45 mm of what steps err by .4 mm.
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn_stall.toml");
    let set = ["flight.duration_s=2.5", "flight.error_m=1e-3"].map(String::from);
    let lost = Scenario::load(&path, &set).unwrap().fly(|_| ControlFlow::Continue(())).unwrap();
    assert_eq!(lost.summary.status, Status::NotResolved, "{:?}", lost.summary.reason);
    assert!(!grown(&lost).unwrap().met && lost.summary.step_error_m.unwrap() > 1e-2, "{:?}", lost.summary);
    // One that is stopped stops the other.
    let stopped = Scenario::load(&path, &set).unwrap().fly(|_| ControlFlow::Break(())).unwrap();
    assert!(stopped.summary.status == Status::Interrupted && grown(&stopped).is_none());
}

/// A sail is stiff: what a step errs in it is gone in the next ones, and a guess that carries it on to the end is far off.
#[test]
fn errors_of_steps_that_die_out_are_measured_by_a_second_flight() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/sail_glide.toml");
    let fly = |more: &[&str]| {
        let always = ["flight.duration_s=1", "flight.record_every_s=2e-2"];
        let set: Vec<String> = always.iter().chain(more).map(|set| (*set).to_string()).collect();
        Scenario::load(&path, &set).unwrap().fly(|_| ControlFlow::Continue(())).unwrap()
    };
    let guessed =
        fly(&["flight.step_s=2e-3", "limits.flight.step_error_m=1e3", "limits.flight.steps_lost_m=1e3"]);
    let measured = fly(&["flight.step_s=2e-3", "limits.flight.step_error_m=1e-12"]);
    let off = apart(&measured, &fly(&["flight.step_s=2.5e-4"]));
    let [guess, told] = [guessed, measured].map(|run| run.summary.step_error_m.unwrap());
    assert!(told > 0.5 * off && told < 2.0 * off && guess > 100.0 * off, "{guess} {told} {off}");
}

#[test]
fn a_controller_of_ones_own_beside_a_stated_error_is_told_that_it_flies_once() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let short = ["flight.duration_s=0.05".to_string(), "flight.error_m=1e-6".to_string()];
    let scenario = Scenario::load(&path, &short).unwrap();
    let run =
        scenario.fly_with(&mut AtRest, 0.005, scenario.sensors(), |_| ControlFlow::Continue(())).unwrap();
    let told = run.summary.warnings.iter().find(|warning| warning.id == "flight.error_of_steps");
    assert_eq!(told.unwrap().key.as_deref(), Some("flight.error_m"));
}

#[test]
fn a_stated_error_beside_a_lattice_is_refused_by_its_key() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/banking_turn.toml");
    let lattice = ["flight.error_m=1e-6".to_string(), "lattice={step_s=1e-3}".to_string()];
    let error = Scenario::load(&path, &lattice).unwrap_err().to_string();
    assert!(error.contains("flight.error_m = 1e-6"), "{error}");
}
